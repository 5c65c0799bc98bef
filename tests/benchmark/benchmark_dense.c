/* SPDX-License-Identifier: BSD-3-Clause */
/* Times the dense kernels beside the BLAS and LAPACK that the program is linked with, in CPU time: the best of several
   rounds, in turn. Prints microseconds and ratios; below 1 the kernels are faster.
   benchmark_dense [N]: matrices of at most N rows. */
#include "signorom/dense_kernels.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

void dgemv_(const char *trans, const int *m, const int *n, const double *alpha, const double *a, const int *lda,
            const double *x, const int *incx, const double *beta, double *y, const int *incy);
void dgemm_(const char *transa, const char *transb, const int *m, const int *n, const int *k, const double *alpha,
            const double *a, const int *lda, const double *b, const int *ldb, const double *beta, double *c,
            const int *ldc);
void dgetrf_(const int *m, const int *n, double *a, const int *lda, int *pivots, int *info);
void dpotrf_(const char *uplo, const int *n, double *a, const int *lda, int *info);

enum { n_rounds = 15 };
static const double one = 1, zero = 0;
static const int step = 1;

/* Matrices of one size: any, symmetric positive definite, and room for their factors. */
typedef struct {
  int n;
  double *any, *definite, *room, *x, *y;
  int *pivots;
} data_t;

static double *fresh(const data_t *d, const double *matrix) {
  return memcpy(d->room, matrix, (size_t)d->n * d->n * sizeof *matrix);
}

static void their_product(const data_t *d) {
  dgemv_("N", &d->n, &d->n, &one, d->any, &d->n, d->x, &step, &zero, d->y, &step);
}
static void our_product(const data_t *d) { sig_multiply(d->n, d->n, 1, d->any, d->n, d->x, 0, d->y); }

static void their_transposed(const data_t *d) {
  dgemv_("T", &d->n, &d->n, &one, d->any, &d->n, d->x, &step, &zero, d->y, &step);
}
static void our_transposed(const data_t *d) { sig_multiply_transpose(d->n, d->n, 1, d->any, d->n, d->x, 0, d->y); }

static void their_matrices(const data_t *d) {
  dgemm_("N", "N", &d->n, &d->n, &d->n, &one, d->any, &d->n, d->definite, &d->n, &one, d->room, &d->n);
}
static void our_matrices(const data_t *d) {
  sig_add_product(0, 0, d->n, d->n, d->n, 1, d->any, d->n, d->definite, d->n, d->room, d->n);
}

static void their_lu(const data_t *d) {
  int info;
  dgetrf_(&d->n, &d->n, fresh(d, d->any), &d->n, d->pivots, &info);
}
static void our_lu(const data_t *d) { sig_factor_lu(d->n, fresh(d, d->any), d->n, d->pivots); }

static void their_cholesky(const data_t *d) {
  int info;
  dpotrf_("L", &d->n, fresh(d, d->definite), &d->n, &info);
}
static void our_cholesky(const data_t *d) { sig_factor_cholesky(d->n, fresh(d, d->definite), d->n); }

static const struct {
  const char *name;
  void (*ours)(const data_t *), (*theirs)(const data_t *);
  double work; /* multiplications over n^3, or over n^2 where negative */
} pairs[] = {{"a x", our_product, their_product, -1},
             {"a' x", our_transposed, their_transposed, -1},
             {"a b", our_matrices, their_matrices, 1},
             {"LU", our_lu, their_lu, 1.0 / 3},
             {"Cholesky", our_cholesky, their_cholesky, 1.0 / 6}};

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double time_of(void (*run)(const data_t *), const data_t *d, int n_times) {
  const double start = seconds();
  for (int i = 0; i < n_times; i++) run(d);
  return (seconds() - start) / n_times;
}

static data_t make(int n) {
  const size_t size = (size_t)n * n;
  data_t d = {.n = n};
  d.any = calloc(size, sizeof *d.any), d.definite = calloc(size, sizeof *d.definite);
  d.room = calloc(size, sizeof *d.room), d.x = calloc((size_t)n, sizeof *d.x), d.y = calloc((size_t)n, sizeof *d.y);
  d.pivots = calloc((size_t)n, sizeof *d.pivots);
  srand(20220430);
  for (size_t i = 0; i < size; i++) d.any[i] = rand() / (double)RAND_MAX - 0.5;
  sig_add_product(0, 1, n, n, n, 1, d.any, n, d.any, n, d.definite, n);
  for (int i = 0; i < n; i++) d.x[i] = d.any[i], d.definite[i + (size_t)i * n] += 1;
  return d;
}

static void drop(data_t *d) { free(d->any), free(d->definite), free(d->room), free(d->x), free(d->y), free(d->pivots); }

int main(int argc, char **argv) {
  static const int sizes[] = {20, 50, 100, 300, 1000};
  const int largest = argc > 1 ? atoi(argv[1]) : 1000;
  for (size_t s = 0; s < sizeof sizes / sizeof *sizes && sizes[s] <= largest; s++) {
    data_t d = make(sizes[s]);
    printf("n = %4d", d.n);
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++) {
      const double square = (double)d.n * d.n;
      const int n_times = (int)(1e7 / (pairs[k].work < 0 ? square : pairs[k].work * square * d.n)) + 1;
      double ours = 1e9, theirs = 1e9;
      for (int i = 0; i < n_rounds; i++) {
        const double a = time_of(pairs[k].ours, &d, n_times), b = time_of(pairs[k].theirs, &d, n_times);
        ours = a < ours ? a : ours;
        theirs = b < theirs ? b : theirs;
      }
      printf("  %s %.2f us, %.2f", pairs[k].name, 1e6 * ours, ours / theirs);
    }
    printf("\n");
    drop(&d);
  }
  return 0;
}
