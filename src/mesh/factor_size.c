/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/factor_size.h"

#include <metis.h>
#include <stdlib.h>

/* Counts the entries of each column of the factor of a graph whose vertices are eliminated in an order: row i of the
 * factor is the union of the paths from the neighbors before i up the elimination tree to i (Liu 1990). parent and mark
 * are work space. */
static void count_columns(int n, const int *offsets, const int *neighbors, const idx_t *vertex_at,
                          const idx_t *place_of, int *parent, int *mark, int *count) {
  for (int i = 0; i < n; i++) {
    parent[i] = -1;
    mark[i] = i;
    count[i] = 1;
    for (int k = offsets[vertex_at[i]]; k < offsets[vertex_at[i] + 1]; k++) {
      int j = place_of[neighbors[k]];
      if (j > i) continue;
      for (; mark[j] != i; j = parent[j]) {
        if (parent[j] < 0) parent[j] = i;
        mark[j] = i;
        count[j]++;
      }
    }
  }
}

/* Counts how many of the rows first ... last - 1 below the matrix each column of its factor reaches, and adds them to
 * border: a row is on the paths from its vertices up the elimination tree. */
static void count_border(int first, int last, const int *row_offsets, const int *row_vertices, const idx_t *place_of,
                         const int *parent, int *mark, int *border) {
  for (int row = first; row < last; row++)
    for (int k = row_offsets[row]; k < row_offsets[row + 1]; k++)
      for (int j = place_of[row_vertices[k]]; j >= 0 && mark[j] != row; j = parent[j]) {
        mark[j] = row;
        border[j]++;
      }
}

/* Each vertex is a block of n_dim columns; a column with m entries takes m^2 operations. */
static void add_up(int n, int n_dim, const int *count, const int *border, sig_factor_size_t *size) {
  *size = (sig_factor_size_t){0};
  for (int i = 0; i < n; i++)
    for (int k = 0; k < n_dim; k++) {
      const double m = (double)count[i] * n_dim - k + (border ? border[i] : 0);
      size->entries += m;
      size->operations += m * m;
      if (m > size->largest_column) size->largest_column = m;
    }
}

int sig_count_factor(int n_vertices, const int *offsets, const int *neighbors, int n_dim, int seed, int n_borders,
                     const int *n_rows, const int *row_offsets, const int *row_vertices, sig_factor_size_t *factor,
                     sig_factor_size_t *bordered) {
  idx_t options[METIS_NOPTIONS];
  idx_t n = n_vertices;
  int *work = malloc(6 * ((size_t)n_vertices + 1) * sizeof *work);
  if (work == NULL) return 1;
  int *vertex_at = work, *place_of = work + n, *parent = work + 2 * (size_t)n, *mark = work + 3 * (size_t)n;
  int *count = work + 4 * (size_t)n, *border = work + 5 * (size_t)n;

  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = seed;
  options[METIS_OPTION_NUMBERING] = 0;
  /* METIS declares the arrays without const, but does not write to them. */
  const int status =
      n == 0 ? METIS_OK : METIS_NodeND(&n, (idx_t *)offsets, (idx_t *)neighbors, NULL, options, vertex_at, place_of);
  if (status == METIS_OK) {
    count_columns(n_vertices, offsets, neighbors, vertex_at, place_of, parent, mark, count);
    add_up(n_vertices, n_dim, count, NULL, factor);
    for (int i = 0; i < n_vertices; i++) {
      mark[i] = -1;
      border[i] = 0;
    }
    for (int k = 0; k < n_borders; k++) {
      count_border(k == 0 ? 0 : n_rows[k - 1], n_rows[k], row_offsets, row_vertices, place_of, parent, mark, border);
      add_up(n_vertices, n_dim, count, border, &bordered[k]);
    }
  }
  free(work);
  return status == METIS_OK ? 0 : 1;
}
