/* SPDX-License-Identifier: BSD-3-Clause */
/* The compliance of contact rows by elimination: MUMPS eliminates all displacements from [K B'; B 0], and what is left
   is -B K^-1 B'. It keeps no factor, and needs neither responses nor solves. */
#ifndef SIGNOROM_ELIMINATION_H
#define SIGNOROM_ELIMINATION_H
#include <stdint.h>

/* Computes B K^-1 B' on the first rank. `stiffness` is symmetric AIJ of full blocks, positive definite; it does not
 * change. Row k of B has the coefficients offsets[k] ... offsets[k + 1] - 1 for the 0-based rows `places` of K, on all
 * ranks alike. `compliance` holds n_rows * n_rows numbers on the first rank and is not used on the others. `reason` and
 * `message` are those of sig_linear_solver_create. Returns a PETSc error code. */
int sig_eliminate(intptr_t stiffness, int n_rows, const int *offsets, const int *places, const double *coefficients,
                  double *compliance, int *reason, char *message);
#endif
