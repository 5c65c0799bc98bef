/* SPDX-License-Identifier: BSD-3-Clause */
/* k-medoids clustering of items of which only the mutual dissimilarities are known. Numbers of items and clusters are
   0-based. A dissimilarity matrix is symmetric with a zero diagonal, shape (n_items, n_items); its entries are finite
   and not negative. Ties within 1e-8 relative go to the lowest number, so that rounding changes no choice. */
#ifndef SIGNOROM_K_MEDOIDS_H
#define SIGNOROM_K_MEDOIDS_H

enum {
  SIG_K_MEDOIDS_OK = 0,
  SIG_K_MEDOIDS_NO_MEMORY = 1,
  SIG_K_MEDOIDS_BAD_COUNT = 2,         /* fewer than one cluster or more than items; no start */
  SIG_K_MEDOIDS_BAD_DISSIMILARITY = 3, /* an entry is negative, infinite or not a number */
  SIG_K_MEDOIDS_BAD_OPTION = 4,
  SIG_K_MEDOIDS_BAD_LABEL = 5
};

/* How medoids get better.
   FASTER_PAM: any exchange of a medoid for another item that lowers the loss is made at once, until none is left; a
   look at all exchanges costs n_items**2 (Schubert and Rousseeuw, Information Systems 101 (2021) 101804). ALTERNATING:
   new medoid of each cluster, new clusters, until the loss stands still (Park and Jun, Expert Systems with Applications
   36 (2009) 3336); cheaper, and stops at worse places. */
enum { SIG_K_MEDOIDS_FASTER_PAM = 0, SIG_K_MEDOIDS_ALTERNATING = 1 };

/* Where they start.
   BUILD: one by one, each the item that lowers the loss most. RANDOM: any items. LAB: as BUILD, each among
   10 + sqrt(n_items) items drawn anew and judged by these alone (same source as FASTER_PAM). CENTRAL: the items of
   least dissimilarity to all, relative to that of the others (Park and Jun). */
enum { SIG_K_MEDOIDS_BUILD = 0, SIG_K_MEDOIDS_RANDOM = 1, SIG_K_MEDOIDS_LAB = 2, SIG_K_MEDOIDS_CENTRAL = 3 };

typedef struct {
  int method;
  int start;
  int n_starts; /* >= 1, the best counts; BUILD and CENTRAL have one result: their second and later starts are RANDOM */
  int seed;     /* the same seed gives the same result */
} sig_k_medoids_options;

/* Medoids (n_clusters), ascending, and the cluster of each item, labels (n_items): that of the nearest medoid; a medoid
   is in its own cluster. loss = sum of the dissimilarities of the items to the medoids of their clusters. */
int sig_find_medoids(int n_items, const double *dissimilarity, int n_clusters, const sig_k_medoids_options *options,
                     int *medoids, int *labels, double *loss);

/* Mean over the items of (b - a) / max(a, b), a = mean dissimilarity to the others of the item's cluster, b = smallest
   mean dissimilarity to another cluster; 0 for an item that is alone in its cluster, and where there is one cluster
   (Rousseeuw, J. Comput. Appl. Math. 20 (1987) 53). In [-1, 1], large = well separated. */
int sig_silhouette(int n_items, const double *dissimilarity, int n_clusters, const int *labels, double *silhouette);

#endif
