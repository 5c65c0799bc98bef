/* SPDX-License-Identifier: BSD-3-Clause */
/* Size of the factor of a matrix, from its graph alone. */
#ifndef SIG_FACTOR_SIZE_H
#define SIG_FACTOR_SIZE_H

/* Numbers of entries of a factor, of operations of the factorization (m^2 for a column with m entries), and of entries
 * of the largest column. */
typedef struct {
  double entries, operations, largest_column;
} sig_factor_size_t;

/* Orders a graph by nested dissection (METIS) and measures the Cholesky factor, where each vertex stands for n_dim
 * unknowns: alone, and with rows below the matrix that are eliminated from, too, and stay: bordered[i] with the first
 * n_rows[i] rows, ascending, for n_borders of them. The neighbors of vertex i are neighbors[offsets[i] .. offsets[i +
 * 1] - 1], 0-based, with each edge in both directions and no vertex its own neighbor; row k has entries for the
 * vertices row_vertices[row_offsets[k] .. row_offsets[k + 1] - 1]. The same seed gives the same counts. Returns 0, or
 * nonzero when METIS fails (out of memory). */
int sig_count_factor(int n_vertices, const int *offsets, const int *neighbors, int n_dim, int seed, int n_borders,
                     const int *n_rows, const int *row_offsets, const int *row_vertices, sig_factor_size_t *factor,
                     sig_factor_size_t *bordered);

#endif
