/* SPDX-License-Identifier: BSD-3-Clause */
/* Which kernels of BLAS the program uses. */
#ifndef SIGNOROM_BLAS_KERNELS_H
#define SIGNOROM_BLAS_KERNELS_H

/* Starts the program anew with kernels that suit the processor, if OpenBLAS does not know the processor: an OpenBLAS
   that is older than the processor takes kernels without AVX then, which are up to five times slower. Call it first of
   all, as it replaces the process. It returns where nothing is to be done, or nothing can be done: another BLAS, a
   processor without AVX2, or a variable OPENBLAS_CORETYPE in the environment, which the user's choice and the new start
   set. */
void sig_take_fast_blas(void);

#endif
