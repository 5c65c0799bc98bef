/* SPDX-License-Identifier: BSD-3-Clause */
#ifndef SIGNOROM_BLAS_KERNELS_H
#define SIGNOROM_BLAS_KERNELS_H

/* Starts the program again, with OPENBLAS_CORETYPE set, if OpenBLAS has taken kernels that are much slower than the
   processor. Else, and where this is not possible, does nothing. To be called before MPI starts. */
void sig_choose_blas_kernels(void);

#endif
