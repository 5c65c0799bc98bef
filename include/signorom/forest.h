/* SPDX-License-Identifier: BSD-3-Clause */
/* A random forest that scikit-learn trained, as flat arrays. It maps a point to the votes of its trees. The nodes of
 * all trees stand one after the other. All numbers are 0-based. */
#ifndef SIGNOROM_FOREST_H
#define SIGNOROM_FOREST_H

typedef struct {
  int n_features, n_classes, n_trees;
  /* first node of each tree and the end of the last one (n_trees + 1) */
  const int *tree_starts;
  /* per node: the feature it looks at, -1 in a leaf; a value <= threshold goes left. Children count from the tree's
     first node and come after their parent. */
  const int *feature;
  const double *threshold;
  const int *left, *right;
  /* share of each class, (n_nodes, n_classes), the class fastest */
  const double *values;
} sig_forest;

/* Checks a forest. Returns 0 when it is valid, -1 when there is no tree, no class or the starts of the trees do not
 * ascend from 0, or 1 + the number of the first node with an invalid feature or child. In a valid forest every walk
 * ends in a leaf. */
int sig_forest_check(const sig_forest *forest);

/* Computes the mean share of each class over the trees, votes (n_classes), at a point (n_features). The function
 * compares values in single precision and adds shares in the order of the trees, exactly as scikit-learn does. */
void sig_forest_votes(const sig_forest *forest, const double *point, double *votes);

#endif
