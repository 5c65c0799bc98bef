// SPDX-License-Identifier: BSD-3-Clause
#ifndef SIGNOROM_FACTORIZATION_H
#define SIGNOROM_FACTORIZATION_H

#include <petscksp.h>

// Far more iterations than a working preconditioner needs.
enum { MAX_CG_ITERATIONS = 1000 };

// Whether the preconditioner is a factorization.
PetscErrorCode sig_is_factored(KSP ksp, PetscBool *answer);

// Factors a matrix for the first time. reason: one of SIG_LINEAR_*; message: SIG_MESSAGE_SIZE characters.
PetscErrorCode sig_factor(KSP ksp, Mat matrix, int *reason, char *message);

// The same for a matrix with the pattern of the first one.
PetscErrorCode sig_factor_again(KSP ksp, Mat matrix, int *reason, char *message);

#endif
