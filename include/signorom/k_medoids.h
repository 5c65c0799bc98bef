/* SPDX-License-Identifier: BSD-3-Clause */
/* k-medoids clustering of items of which only the mutual dissimilarities are known. Numbers of items and clusters are
   0-based. A dissimilarity matrix is symmetric with a zero diagonal, shape (n_items, n_items); its entries are finite
   and not negative. Ties within 1e-8 relative go to the lowest number, so that rounding changes no choice. Both
   functions return one of the codes below. */
#ifndef SIGNOROM_K_MEDOIDS_H
#define SIGNOROM_K_MEDOIDS_H

enum {
  SIG_K_MEDOIDS_OK = 0,
  SIG_K_MEDOIDS_NO_MEMORY = 1,
  SIG_K_MEDOIDS_BAD_COUNT = 2,         /* fewer than one cluster or more than items; no start */
  SIG_K_MEDOIDS_BAD_DISSIMILARITY = 3, /* an entry is negative, infinite or not a number */
  SIG_K_MEDOIDS_BAD_OPTION = 4,        /* unknown start */
  SIG_K_MEDOIDS_BAD_LABEL = 5          /* sig_silhouette: a label is below 0 or not below n_clusters */
};

/* Methods that choose the first medoids. BUILD chooses one by one the item that lowers the loss most; RANDOM takes any
 * items. */
enum { SIG_K_MEDOIDS_BUILD = 0, SIG_K_MEDOIDS_RANDOM = 1 };

typedef struct {
  int start;
  int n_starts; /* >= 1, the best counts; BUILD has one result: its second and later starts are RANDOM */
  int seed;     /* the same seed gives the same result */
} sig_k_medoids_options;

/* Finds the medoids (n_clusters), ascending, and labels (n_items), the cluster of each item: that of the nearest
 * medoid. A medoid is in its own cluster. loss is the sum of the dissimilarities of the items to the medoids of their
 * clusters. From the first medoids on it exchanges a medoid for another item as soon as that lowers the loss, until no
 * exchange does; a look at all exchanges costs n_items**2 (FasterPAM: Schubert and Rousseeuw, Information Systems 101
 * (2021) 101804). */
int sig_find_medoids(int n_items, const double *dissimilarity, int n_clusters, const sig_k_medoids_options *options,
                     int *medoids, int *labels, double *loss);

/* Computes the mean silhouette: the mean over the items of (b - a) / max(a, b), where a is the mean dissimilarity to
 * the other items of the item's cluster and b the smallest mean dissimilarity to another cluster. It is 0 for an item
 * that is alone in its cluster, and where there is one cluster (Rousseeuw, J. Comput. Appl. Math. 20 (1987) 53). The
 * result is in [-1, 1]; large values mean well separated clusters. */
int sig_silhouette(int n_items, const double *dissimilarity, int n_clusters, const int *labels, double *silhouette);

#endif
