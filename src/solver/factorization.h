// SPDX-License-Identifier: BSD-3-Clause
#ifndef SIGNOROM_FACTORIZATION_H
#define SIGNOROM_FACTORIZATION_H

#include <petscksp.h>

// Limit of iterations: far more than a working preconditioner needs.
enum { MAX_CG_ITERATIONS = 1000 };

// Gives whether the preconditioner is a factorization.
PetscErrorCode sig_is_factored(KSP ksp, PetscBool *answer);

// Factors a matrix for the first time. reason: one of SIG_LINEAR_*; message: SIG_MESSAGE_SIZE characters, written only
// if reason is SIG_LINEAR_FAILED.
PetscErrorCode sig_factor(KSP ksp, Mat matrix, int *reason, char *message);

// Factors a matrix with the same pattern as the first one. Arguments as for sig_factor.
PetscErrorCode sig_factor_again(KSP ksp, Mat matrix, int *reason, char *message);

#endif
