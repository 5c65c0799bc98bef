/* SPDX-License-Identifier: BSD-3-Clause */
/* A factored symmetric matrix: MUMPS Cholesky (L D L') behind a KSP with its own option prefix.
   PETSc objects cross as intptr_t (component %v of the Fortran handle). Every function returns a PETSc error code. */
#ifndef SIGNOROM_LINEAR_SOLVER_H
#define SIGNOROM_LINEAR_SOLVER_H
#include <stdint.h>

enum { SIG_FACTOR_DONE = 1, SIG_FACTOR_FAILED = -1, SIG_FACTOR_SINGULAR = -2 };

/* Factors `matrix` (symmetric AIJ, not changed). `reason` is one of the above; `detail` is MUMPS's INFOG(1) when it
   failed and the number of null pivots when the matrix is singular. Workspace failures (INFOG(1) = -8, -9) are retried
   with twice the room. The KSP of the caller is created here and destroyed by sig_linear_solver_destroy. */
int sig_linear_solver_factor(intptr_t matrix, const char *prefix, intptr_t *ksp, int *reason, int *detail);

/* Solves for n_columns right-hand sides; arrays hold the local rows, shape [n_columns][n_local], solution apart from
 * rhs. */
int sig_linear_solver_solve_many(intptr_t ksp, int n_columns, int n_local, const double *rhs, double *solution);

int sig_linear_solver_destroy(intptr_t *ksp);
#endif
