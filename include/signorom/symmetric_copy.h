/* SPDX-License-Identifier: BSD-3-Clause */
/* The upper triangle of a symmetric matrix in full blocks (SBAIJ). Products with it take a third of the time that they
   take in the format AIJ, and conjugate gradients spend most of their time on products. For C only. */
#ifndef SIGNOROM_SYMMETRIC_COPY_H
#define SIGNOROM_SYMMETRIC_COPY_H
#include <petscmat.h>

/* Makes a copy of an AIJ matrix whose pattern has full blocks of its block size; the caller destroys it. */
PetscErrorCode sig_symmetric_copy_create(Mat matrix, Mat *copy);
#endif
