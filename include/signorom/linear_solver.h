/* SPDX-License-Identifier: BSD-3-Clause */
/* A symmetric matrix made ready for solves behind a KSP with its own option prefix: factored by MUMPS Cholesky (L D
   L'), or conjugate gradients with algebraic multigrid (PETSc's GAMG). PETSc objects cross as intptr_t (component %v of
   the Fortran handle). Every function returns a PETSc error code. */
#ifndef SIGNOROM_LINEAR_SOLVER_H
#define SIGNOROM_LINEAR_SOLVER_H
#include <stdint.h>

enum { SIG_LINEAR_CHOLESKY = 1, SIG_LINEAR_GAMG = 2 };
enum { SIG_LINEAR_DONE = 1, SIG_LINEAR_FAILED = -1, SIG_LINEAR_SINGULAR = -2 };

/* Makes `matrix` ready for solves. It is symmetric AIJ of full blocks; it is not changed, and the KSP keeps a reference
   to it. `kind` and `reason` are values of the enumerations above; `message` (SIG_MESSAGE_SIZE bytes of
   petsc_support.h) says what failed if `reason` is SIG_LINEAR_FAILED, and is empty otherwise. If the workspace of MUMPS
   is too small (INFOG(1) = -8, -9), it is tried again with twice the memory in addition to MUMPS's estimate. Errors
   inside PETSc, which wrong options cause, are failures too, without a trace. The KSP is created here and destroyed by
   sig_linear_solver_destroy. */
int sig_linear_solver_create(intptr_t matrix, const char *prefix, int kind, intptr_t *ksp, int *reason, char *message);

/* Makes a KSP with multigrid for K solve with T' K T from now on, where some unknowns are held; sig_linear_solver_hold
 * must follow. The levels keep their interpolations. `transformation` and `inverse` give the patterns of T and its
 * inverse. `mark` has 1 for each unknown that may be held though no T changes it, and 0 for all others; it changes.
 * `reason` and `message` are as for sig_linear_solver_create. */
int sig_linear_solver_change_unknowns(intptr_t ksp, intptr_t transformation, intptr_t inverse, intptr_t mark,
                                      int *reason, char *message);

/* Makes the KSP solve with T' K T where the unknowns are held for which `is_free` has 0; it has 1 for all others. T =
 * `transformation` is kept as a reference, `inverse` is only read. `springs` is as in
 * contact_levels.h, 0 for none. `reason` and `message` are as for sig_linear_solver_create. */
int sig_linear_solver_hold(intptr_t ksp, intptr_t transformation, intptr_t inverse, intptr_t is_free, intptr_t springs,
                           int *reason, char *message);

/* Factors a matrix again after its entries changed within their pattern: MUMPS keeps its ordering. `reason` and
   `message` are as for sig_linear_solver_create. */
int sig_linear_solver_factor_again(intptr_t ksp, int *reason, char *message);

/* Tells how many solves with the factor take about the time of one factorization, by MUMPS's count of operations; 0
 * where there is no count. */
int sig_linear_solver_solves_per_factorization(intptr_t ksp, int *n_solves);

/* Makes a KSP ready again after the entries of its factored matrix changed within their pattern: the factor that it has
   becomes the preconditioner of conjugate gradients, which fail after max_iterations. */
int sig_linear_solver_keep_factor(intptr_t ksp, int max_iterations);

/* Gives a matrix the fields that cost it next to no energy, which GAMG must reproduce on its coarse levels. `modes`
   holds the local rows of at most six fields, shape [n_modes][n_local]; the matrix gets orthonormal combinations of
   them. */
int sig_set_near_null_space(intptr_t matrix, int n_modes, int n_local, const double *modes);

/* Solves for n_columns right-hand sides; arrays hold the local rows, shape [n_columns][n_local], solution apart from
   rhs. `reason` is SIG_LINEAR_DONE, or SIG_LINEAR_FAILED after an iteration that failed; later columns are not solved
   then. Not after sig_linear_solver_keep_factor: it would solve with the factor of the old entries. */
int sig_linear_solver_solve_many(intptr_t ksp, int n_columns, int n_local, const double *rhs, double *solution,
                                 int *reason);

/* Solves for one right-hand side from the solution given, to `tolerance` (relative, in the energy norm) or to the
   tightest one, that of the options, whichever is larger. A factored matrix is always solved exactly, in 0 iterations,
   unless it has changed (sig_linear_solver_keep_factor). `reason` is SIG_LINEAR_DONE or SIG_LINEAR_FAILED. */
int sig_linear_solver_solve(intptr_t ksp, intptr_t rhs, double tolerance, intptr_t solution, int *n_iterations,
                            int *reason);

/* Solves I (A + E A + Z) I x = f by iterations with the preconditioner of the KSP, the last factor or multigrid: GMRES,
 * or conjugate gradients without E = `coupling`. I keeps the free unknowns, for which `is_free` has 1, and Z =
 * `springs`. A = `stiffness`; it is 0 with multigrid, which has A from sig_linear_solver_hold, for
 * which other unknowns may be held. Starts from
 * the solution given, and ends when the residual has fallen by `reduction`, or to the tightest tolerance times `size`,
 * the size of f; it is measured where it is 0 on entry or `reduction` is 0. `reason` is SIG_LINEAR_DONE or
 * SIG_LINEAR_FAILED. */
int sig_linear_solver_solve_coupled(intptr_t ksp, intptr_t stiffness, intptr_t is_free, intptr_t springs,
                                    intptr_t coupling, intptr_t rhs, double reduction, double *size, intptr_t solution,
                                    int *n_iterations, int *reason);

int sig_linear_solver_destroy(intptr_t *ksp);
#endif
