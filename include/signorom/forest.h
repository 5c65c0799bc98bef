/* SPDX-License-Identifier: BSD-3-Clause */
/* A random forest that somebody else trained, as flat arrays: from a point to the votes of its trees.
   Nodes of all trees stand one after the other. All numbers are 0-based. */
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

/* 0, -1 where the starts of the trees are no ascending numbers from 0, or 1 + the first node with a feature or a child
   that cannot be. With 0 every walk ends in a leaf. */
int sig_forest_check(const sig_forest *forest);

/* Mean share of each class over the trees, votes (n_classes), at a point (n_features). Values are compared in single
   precision and shares are added in the order of the trees: exactly what scikit-learn does. */
void sig_forest_votes(const sig_forest *forest, const double *point, double *votes);

#endif
