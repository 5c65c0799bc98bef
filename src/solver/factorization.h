// SPDX-License-Identifier: BSD-3-Clause
#ifndef SIGNOROM_FACTORIZATION_H
#define SIGNOROM_FACTORIZATION_H

#include <petscksp.h>

// Limit of iterations: far more than a working preconditioner needs.
enum { MAX_CG_ITERATIONS = 1000 };

// [%] Memory that MUMPS gets in addition to its own estimate; it is doubled each time that MUMPS finds it too small.
enum { FIRST_WORKSPACE = 60, LARGEST_WORKSPACE = 1000 };

// ICNTL(24) and CNTL(3): without null-pivot detection, MUMPS gives numbers of size 1e10 and no error for a singular
// matrix.
enum { SIG_MUMPS_FINDS_NULL_PIVOTS = 1 };
static const double SIG_MUMPS_NULL_PIVOT = 1e-10;

// Writes why MUMPS failed, from its INFOG(1) and INFOG(2), to a message of SIG_MESSAGE_SIZE characters.
void sig_tell_mumps_failure(int code, int detail, char *message);

// Gives whether the preconditioner is a factorization.
PetscErrorCode sig_is_factored(KSP ksp, PetscBool *answer);

// Factors a matrix for the first time. reason: one of SIG_LINEAR_*; message: SIG_MESSAGE_SIZE characters, written only
// if reason is SIG_LINEAR_FAILED.
PetscErrorCode sig_factor(KSP ksp, Mat matrix, int *reason, char *message);

// Factors a matrix with the same pattern as the first one. Arguments as for sig_factor.
PetscErrorCode sig_factor_again(KSP ksp, Mat matrix, int *reason, char *message);

#endif
