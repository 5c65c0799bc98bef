/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/k_medoids.h"

#include <math.h>
#include <stdlib.h>

/* Returns (b - a) / max(a, b) of one item (k_medoids.h) from its sums of dissimilarities over each of the clusters. */
static double silhouette_of(int own, int k, const double *sums, const int *sizes) {
  double others = INFINITY;
  if (sizes[own] < 2) return 0;
  for (int i = 0; i < k; i++)
    if (i != own && sizes[i] > 0) others = fmin(others, sums[i] / sizes[i]);
  const double mine = sums[own] / (sizes[own] - 1), larger = fmax(mine, others);
  return larger > 0 && isfinite(others) ? (others - mine) / larger : 0;
}

int sig_silhouette(int n_items, const double *dissimilarity, int n_clusters, const int *labels, double *silhouette) {
  if (n_items < 1 || n_clusters < 1) return SIG_K_MEDOIDS_BAD_COUNT;
  for (int o = 0; o < n_items; o++)
    if (labels[o] < 0 || labels[o] >= n_clusters) return SIG_K_MEDOIDS_BAD_LABEL;
  double *sums = malloc((size_t)n_clusters * sizeof *sums), total = 0;
  int *sizes = calloc((size_t)n_clusters, sizeof *sizes);
  if (sums && sizes) {
    for (int o = 0; o < n_items; o++) sizes[labels[o]]++;
    for (int o = 0; o < n_items; o++) {
      const double *row = dissimilarity + (size_t)o * n_items;
      for (int i = 0; i < n_clusters; i++) sums[i] = 0;
      for (int j = 0; j < n_items; j++) sums[labels[j]] += row[j];
      total += silhouette_of(labels[o], n_clusters, sums, sizes);
    }
    *silhouette = total / n_items;
  }
  const int is_there = sums && sizes;
  free(sums);
  free(sizes);
  if (!is_there) return SIG_K_MEDOIDS_NO_MEMORY;
  return isfinite(total) ? SIG_K_MEDOIDS_OK : SIG_K_MEDOIDS_BAD_DISSIMILARITY;
}
