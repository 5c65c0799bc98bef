/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/k_medoids.h"

#include "signorom/random_numbers.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const double tie_tolerance = 1e-8;

/* State of a search. Medoids are numbered by their place in `medoids`. */
typedef struct {
  int n, k;
  const double *dissimilarity;
  int *medoids;
  int *nearest, *second;          /* of each item */
  double *to_nearest, *to_second; /* of each item; to_second is infinite where k = 1 */
  double *removal_loss;           /* of each medoid: by how much the loss grows without it */
  double *change;                 /* of each medoid: work space */
  double *bound;                  /* of each item: work space */
  int *pool;                      /* of each item: work space */
  double loss;
} search_t;

static const double *row_of(const search_t *search, int i) { return search->dissimilarity + (size_t)i * search->n; }

/* Moves `count` entries drawn from the first `n` of the pool to its front. */
static void draw_to_front(int *pool, int n, int count, uint64_t *state) {
  for (int i = 0; i < count; i++) {
    const int j = i + sig_random_below(state, n - i), drawn = pool[j];
    pool[j] = pool[i];
    pool[i] = drawn;
  }
}

static bool is_medoid(const search_t *search, int n_medoids, int item) {
  for (int i = 0; i < n_medoids; i++)
    if (search->medoids[i] == item) return true;
  return false;
}

static void add_medoid(search_t *search, int i_medoid, int item) {
  const double *row = row_of(search, item);
  search->medoids[i_medoid] = item;
  for (int o = 0; o < search->n; o++)
    if (i_medoid == 0 || row[o] < search->to_nearest[o]) search->to_nearest[o] = row[o];
}

/* Returns the item with the smallest sum of dissimilarities to all items. */
static int most_central(const search_t *search) {
  int best = 0;
  double least = INFINITY;
  for (int c = 0; c < search->n; c++) {
    const double *row = row_of(search, c);
    double sum = 0;
    for (int o = 0; o < search->n; o++) sum += row[o];
    if (sum < least * (1 - tie_tolerance)) {
      best = c;
      least = sum;
    }
  }
  return best;
}

/* Returns by how much one more medoid lowers the loss. */
static double gain_of(const search_t *search, int candidate) {
  const double *row = row_of(search, candidate);
  double gain = 0;
  for (int o = 0; o < search->n; o++) gain += fmax(search->to_nearest[o] - row[o], 0);
  return gain;
}

static void start_with_build(search_t *search) {
  for (int c = 0; c < search->n; c++) search->bound[c] = INFINITY;
  add_medoid(search, 0, most_central(search));
  for (int i = 1; i < search->k; i++) {
    int best = -1;
    double most = -1;
    for (int c = 0; c < search->n; c++) {
      /* More medoids never make a gain larger, so an earlier gain is an upper bound. */
      if (search->bound[c] <= most * (1 + tie_tolerance) || is_medoid(search, i, c)) continue;
      const double gain = search->bound[c] = gain_of(search, c);
      if (gain <= most * (1 + tie_tolerance)) continue;
      best = c;
      most = gain;
    }
    add_medoid(search, i, best);
  }
}

static void fill_pool(search_t *search) {
  for (int o = 0; o < search->n; o++) search->pool[o] = o;
}

static void start_at_random(search_t *search, uint64_t *state) {
  fill_pool(search);
  draw_to_front(search->pool, search->n, search->k, state);
  memcpy(search->medoids, search->pool, (size_t)search->k * sizeof *search->medoids);
}

/* Second nearest medoid of an item whose nearest one is known. */
static void find_second(search_t *search, int item) {
  const double *row = row_of(search, item);
  int best = -1;
  double least = INFINITY;
  for (int i = 0; i < search->k; i++) {
    if (i == search->nearest[item]) continue;
    if (best >= 0 && row[search->medoids[i]] >= least) continue;
    best = i;
    least = row[search->medoids[i]];
  }
  search->second[item] = best;
  search->to_second[item] = least;
}

static void find_nearest(search_t *search, int item) {
  const double *row = row_of(search, item);
  int best = 0;
  for (int i = 1; i < search->k; i++)
    if (row[search->medoids[i]] < row[search->medoids[best]]) best = i;
  search->nearest[item] = best;
  search->to_nearest[item] = row[search->medoids[best]];
}

static void sum_up(search_t *search) {
  search->loss = 0;
  for (int i = 0; i < search->k; i++) search->removal_loss[i] = 0;
  for (int o = 0; o < search->n; o++) {
    search->loss += search->to_nearest[o];
    search->removal_loss[search->nearest[o]] += search->to_second[o] - search->to_nearest[o];
  }
}

/* Replaces a medoid by the candidate. For each item only what changes is computed again. */
static void exchange(search_t *search, int i_medoid, int candidate) {
  const double *row = row_of(search, candidate);
  search->medoids[i_medoid] = candidate;
  for (int o = 0; o < search->n; o++) {
    const double d = row[o];
    if (search->nearest[o] == i_medoid) {
      if (d < search->to_second[o]) {
        search->to_nearest[o] = d;
      } else {
        search->nearest[o] = search->second[o];
        search->to_nearest[o] = search->to_second[o];
        find_second(search, o);
      }
    } else if (d < search->to_nearest[o]) {
      search->second[o] = search->nearest[o];
      search->to_second[o] = search->to_nearest[o];
      search->nearest[o] = i_medoid;
      search->to_nearest[o] = d;
    } else if (search->second[o] == i_medoid) {
      find_second(search, o);
    } else if (d < search->to_second[o]) {
      search->second[o] = i_medoid;
      search->to_second[o] = d;
    }
  }
  sum_up(search);
}

/* Returns the medoid that the candidate should replace, and the change of the loss. `shared` is the part of the change
   that is the same for all medoids; `change` adds, for each medoid, the items whose nearest medoid it is. One pass over
   the items therefore judges all k exchanges. */
static int best_exchange(search_t *search, int candidate, double *total) {
  const double *row = row_of(search, candidate), *to_nearest = search->to_nearest, *to_second = search->to_second;
  double *change = search->change, shared = 0;
  memcpy(change, search->removal_loss, (size_t)search->k * sizeof *change);
  for (int o = 0; o < search->n; o++) {
    const double d = row[o];
    if (d >= to_second[o]) continue;
    if (d < to_nearest[o]) {
      shared += d - to_nearest[o];
      change[search->nearest[o]] += to_nearest[o] - to_second[o];
    } else {
      change[search->nearest[o]] += d - to_second[o];
    }
  }
  int best = 0;
  const double margin = tie_tolerance * search->loss;
  for (int i = 1; i < search->k; i++) {
    const bool is_lower = search->medoids[i] < search->medoids[best];
    if (change[i] < change[best] - margin || (is_lower && change[i] <= change[best] + margin)) best = i;
  }
  *total = change[best] + shared;
  return best;
}

/* Improves the medoids; the candidates come in the order of the pool. */
static void exchange_medoids(search_t *search) {
  if (search->k == 1) { /* no medoid is second nearest; the best medoid follows from sums */
    search->medoids[0] = most_central(search);
    return;
  }
  for (int o = 0; o < search->n; o++) {
    find_nearest(search, o);
    find_second(search, o);
  }
  sum_up(search);
  for (int i = 0, n_in_vain = 0; n_in_vain < search->n; i = (i + 1) % search->n, n_in_vain++) {
    const int c = search->pool[i];
    if (search->to_nearest[c] <= 0 && is_medoid(search, search->k, c)) continue;
    double total;
    const int i_medoid = best_exchange(search, c, &total);
    /* A gain that is only rounding does not count either: the same exchanges could repeat without end. */
    const double rounding = DBL_EPSILON * search->n * (search->loss + search->removal_loss[i_medoid]);
    if (total >= -(tie_tolerance * search->loss + rounding)) continue;
    exchange(search, i_medoid, c);
    n_in_vain = 0;
  }
}

static int compare_numbers(const void *a, const void *b) {
  const int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

/* Sorts the medoids and gives each item its cluster; returns the loss. */
static double assign(search_t *search) {
  double loss = 0;
  qsort(search->medoids, (size_t)search->k, sizeof *search->medoids, compare_numbers);
  for (int o = 0; o < search->n; o++) {
    const double *row = row_of(search, o);
    int best = 0;
    for (int i = 1; i < search->k; i++)
      if (row[search->medoids[i]] < row[search->medoids[best]] * (1 - tie_tolerance)) best = i;
    search->nearest[o] = best;
    loss += row[search->medoids[best]];
  }
  for (int i = 0; i < search->k; i++) search->nearest[search->medoids[i]] = i; /* also if medoids are equal */
  return loss;
}

static bool is_dissimilarity(int n, const double *entries) {
  for (int i = 0; i < n; i++) {
    const double *row = entries + (size_t)i * n;
    int n_bad = 0;
    for (int j = 0; j < n; j++) n_bad += !(row[j] >= 0 && row[j] <= DBL_MAX);
    if (n_bad > 0) return false;
  }
  return true;
}

static int check(int n, const double *dissimilarity, int k, const sig_k_medoids_options *options) {
  if (k < 1 || k > n || options->n_starts < 1) return SIG_K_MEDOIDS_BAD_COUNT;
  if (options->start != SIG_K_MEDOIDS_BUILD && options->start != SIG_K_MEDOIDS_RANDOM) return SIG_K_MEDOIDS_BAD_OPTION;
  return is_dissimilarity(n, dissimilarity) ? SIG_K_MEDOIDS_OK : SIG_K_MEDOIDS_BAD_DISSIMILARITY;
}

/* Allocates two blocks for the arrays of the search. A block is NULL where there is no memory. */
static void create_search(search_t *search, double **reals, int **integers) {
  const size_t n = (size_t)search->n, k = (size_t)search->k;
  *reals = malloc((3 * n + 2 * k) * sizeof **reals);
  *integers = malloc((3 * n + k) * sizeof **integers);
  if (!*reals || !*integers) return;
  search->to_nearest = *reals;
  search->to_second = search->to_nearest + n;
  search->bound = search->to_second + n;
  search->removal_loss = search->bound + n;
  search->change = search->removal_loss + k;
  search->nearest = *integers;
  search->second = search->nearest + n;
  search->pool = search->second + n;
  search->medoids = search->pool + n;
}

static double run_start(search_t *search, const sig_k_medoids_options *options, int i_start) {
  uint64_t state = ((uint64_t)(uint32_t)options->seed << 32) + (uint64_t)i_start;
  if (options->start == SIG_K_MEDOIDS_BUILD && i_start == 0)
    start_with_build(search);
  else
    start_at_random(search, &state);
  /* Starts with the same order of candidates would often give the same result. */
  fill_pool(search);
  if (i_start > 0) draw_to_front(search->pool, search->n, search->n, &state);
  exchange_medoids(search);
  return assign(search);
}

int sig_find_medoids(int n_items, const double *dissimilarity, int n_clusters, const sig_k_medoids_options *options,
                     int *medoids, int *labels, double *loss) {
  search_t search = {.n = n_items, .k = n_clusters, .dissimilarity = dissimilarity};
  double *reals;
  int *integers;
  int status = check(n_items, dissimilarity, n_clusters, options);
  if (status != SIG_K_MEDOIDS_OK) return status;
  create_search(&search, &reals, &integers);
  if (!reals || !integers) status = SIG_K_MEDOIDS_NO_MEMORY;
  for (int i_start = 0; i_start < options->n_starts && status == SIG_K_MEDOIDS_OK; i_start++) {
    const double found = run_start(&search, options, i_start);
    if (i_start > 0 && found >= *loss * (1 - tie_tolerance)) continue;
    *loss = found;
    memcpy(medoids, search.medoids, (size_t)n_clusters * sizeof *medoids);
    memcpy(labels, search.nearest, (size_t)n_items * sizeof *labels);
  }
  free(reals);
  free(integers);
  return status;
}
