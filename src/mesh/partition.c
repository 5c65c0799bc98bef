/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/partition.h"

#include <metis.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Divides the vertices into parts of consecutive vertices. All parts have about the same number of vertices. */
static void share_in_runs(int n_vertices, int n_parts, int *part) {
  for (int i = 0; i < n_vertices; i++) part[i] = (int)((long long)i * n_parts / n_vertices);
}

static bool has_empty_part(int n_vertices, int n_parts, const int *part, bool *is_empty) {
  *is_empty = false;
  char *is_used = calloc((size_t)n_parts, 1);
  if (is_used == NULL) return false;
  for (int i = 0; i < n_vertices; i++) is_used[part[i]] = 1;
  *is_empty = memchr(is_used, 0, (size_t)n_parts) != NULL;
  free(is_used);
  return true;
}

static int run_metis(int n_vertices, const int *offsets, const int *neighbors, const int *weights, int n_parts,
                     int seed, int *part) {
  idx_t options[METIS_NOPTIONS];
  idx_t n = n_vertices, n_constraints = 1, parts = n_parts, n_cut;
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = seed;
  options[METIS_OPTION_NUMBERING] = 0;
  /* METIS declares the arrays without const, but does not write to them. */
  const int status = METIS_PartGraphKway(&n, &n_constraints, (idx_t *)offsets, (idx_t *)neighbors, (idx_t *)weights,
                                         NULL, NULL, &parts, NULL, NULL, options, &n_cut, part);
  return status == METIS_OK ? 0 : 1;
}

_Static_assert(sizeof(idx_t) == sizeof(int), "METIS with 32-bit numbers is needed");

int sig_partition_graph(int n_vertices, const int *offsets, const int *neighbors, const int *weights, int n_parts,
                        int seed, int *part) {
  if (n_vertices <= 0) return 0;
  /* With few vertices per part METIS is not needed, and it may leave a part empty. */
  if (n_parts == 1 || n_vertices < 4 * n_parts) {
    share_in_runs(n_vertices, n_parts, part);
    return 0;
  }
  bool is_empty;
  if (run_metis(n_vertices, offsets, neighbors, weights, n_parts, seed, part) != 0) return 1;
  if (!has_empty_part(n_vertices, n_parts, part, &is_empty)) return 1;
  if (is_empty) share_in_runs(n_vertices, n_parts, part);
  return 0;
}
