/* SPDX-License-Identifier: BSD-3-Clause */
/* Size of the factor of a matrix, from its graph alone. */
#ifndef SIG_FACTOR_SIZE_H
#define SIG_FACTOR_SIZE_H

/* Orders a graph by nested dissection (METIS) and counts the entries of the Cholesky factor and the operations of the
 * factorization, where each vertex stands for n_dim unknowns. The neighbors of vertex i are neighbors[offsets[i] ..
 * offsets[i + 1] - 1], 0-based, with each edge in both directions and no vertex its own neighbor. The same seed gives
 * the same counts. Returns 0, or nonzero when METIS fails (out of memory). */
int sig_count_factor(int n_vertices, const int *offsets, const int *neighbors, int n_dim, int seed, double *entries,
                     double *operations);

#endif
