/* SPDX-License-Identifier: BSD-3-Clause */
/* PETSc's SNESVI on a quadratic problem with upper bounds: min 1/2 x' A x - b' x, x <= upper.
   PETSc objects cross as intptr_t (component %v of the Fortran handle). Returns a PETSc error code. */
#ifndef SIGNOROM_SNES_VI_H
#define SIGNOROM_SNES_VI_H
#include <stdint.h>

enum { SIG_VI_DONE = 1, SIG_VI_MAX_ITERATIONS = -1, SIG_VI_LINEAR_SOLVER = -3, SIG_VI_LINE_SEARCH = -6 };

/* `solution` holds the start and the answer. `length_scale` (> 0) and `force_scale` (> 0) make the unknowns and the
   residual numbers of order one, because SNESVI's own tolerances are absolute. `upper` is given in units of
   length_scale, with PETSC_INFINITY where there is no bound. Linear systems are factored, or solved by conjugate
   gradients with GAMG where `is_multigrid` is not 0 (PETSc 3.19 or later). Errors inside PETSc, which wrong options
   cause, are a failure of the linear solver. If max_iterations full steps are not enough, the problem is solved again
   from the start with a line search, by up to as many iterations; `n_iterations` is the sum of both. */
int sig_snes_vi_solve(intptr_t matrix, intptr_t rhs, intptr_t upper, double length_scale, double force_scale,
                      int is_multigrid, int max_iterations, intptr_t solution, int *n_iterations, int *reason);
#endif
