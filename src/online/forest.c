/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/forest.h"

#include <stdbool.h>

static bool is_node_sound(const sig_forest *forest, int start, int n_nodes, int i) {
  const int node = start + i;
  if (forest->feature[node] == -1) return true;
  if (forest->feature[node] < 0 || forest->feature[node] >= forest->n_features) return false;
  return forest->left[node] > i && forest->left[node] < n_nodes && forest->right[node] > i &&
         forest->right[node] < n_nodes;
}

/* Checked before any node is read: a start behind the end of the nodes would lead out of the arrays. */
static bool are_starts_ascending(const sig_forest *forest) {
  if (forest->tree_starts[0] != 0) return false;
  for (int tree = 0; tree < forest->n_trees; tree++)
    if (forest->tree_starts[tree + 1] <= forest->tree_starts[tree]) return false;
  return true;
}

int sig_forest_check(const sig_forest *forest) {
  if (forest->n_trees < 1 || forest->n_classes < 1 || !are_starts_ascending(forest)) return -1;
  for (int tree = 0; tree < forest->n_trees; tree++) {
    const int start = forest->tree_starts[tree], n_nodes = forest->tree_starts[tree + 1] - start;
    for (int i = 0; i < n_nodes; i++)
      if (!is_node_sound(forest, start, n_nodes, i)) return 1 + start + i;
  }
  return 0;
}

/* Returns the leaf of a tree to which the point belongs, counted among the nodes of all trees. scikit-learn trains and
 * evaluates with parameters in single precision, hence the conversion to float. */
static int find_leaf(const sig_forest *forest, int start, const double *point) {
  int node = start;
  while (forest->feature[node] >= 0) {
    const double value = (float)point[forest->feature[node]];
    node = start + (value <= forest->threshold[node] ? forest->left[node] : forest->right[node]);
  }
  return node;
}

void sig_forest_votes(const sig_forest *forest, const double *point, double *votes) {
  for (int i = 0; i < forest->n_classes; i++) votes[i] = 0;
  for (int tree = 0; tree < forest->n_trees; tree++) {
    const int leaf = find_leaf(forest, forest->tree_starts[tree], point);
    for (int i = 0; i < forest->n_classes; i++) votes[i] += forest->values[(long long)leaf * forest->n_classes + i];
  }
  for (int i = 0; i < forest->n_classes; i++) votes[i] /= forest->n_trees;
}
