/* SPDX-License-Identifier: BSD-3-Clause */
/* Estimates the 1-norm of the inverse of a factored matrix from a few solves. The condition number follows from it. */
#include "dense_parts.h"
#include "signorom/dense_kernels.h"

#include <math.h>

/* The inverse A^-1 as two triangles: solving with `straight`, one after the other, applies A^-1, and with `transposed`
   its transpose. Exchanges of rows are left out, because they do not change the norm of the inverse. */
typedef struct {
  int n, ldf;
  const double *factors;
  sig_triangle straight[2], transposed[2];
} inverse_t;

/* Largest number of steps; more of them hardly ever raise the estimate. */
enum { most_steps = 5 };

static void apply(const inverse_t *inverse, const sig_triangle *kinds, double *x) {
  for (int i = 0; i < 2; i++)
    sig_solve_triangle(kinds[i], inverse->n, 1, inverse->factors, inverse->ldf, x, inverse->n);
}

/* Replaces x by its signs and stores them in `signs`. Returns 1 if `signs` had the same signs before. */
static int take_signs(int n, double *x, int *signs) {
  int is_same = 1;
  for (int i = 0; i < n; i++) {
    const int sign = x[i] >= 0 ? 1 : -1;
    is_same &= sign == signs[i];
    signs[i] = sign;
    x[i] = sign;
  }
  return is_same;
}

/* Returns |A^-1 x| / |x| for a vector x with alternating signs (for n = 1 two thirds of it). This finds some large
   inverses that the steps of norm_of_inverse miss. */
static double alternating_estimate(const inverse_t *inverse, double *x) {
  const int n = inverse->n;
  for (int i = 0; i < n; i++) x[i] = (i % 2 ? -1 : 1) * (1 + (double)i / (n > 1 ? n - 1 : 1));
  apply(inverse, inverse->straight, x);
  return 2 * sig_sum_of_sizes(n, x) / (3.0 * n);
}

/* Estimates |A^-1| by Hager's method in Higham's form. It starts with the mean x of all unit vectors; each step goes on
   with the unit vector x along which |A^-1 x| grows most. Returns the largest |A^-1 x|, or the alternating estimate if
   that is larger; infinity if a sum is not finite. */
static double norm_of_inverse(const inverse_t *inverse, double *x, int *signs) {
  const int n = inverse->n;
  int place = -1;
  double norm = 0;
  for (int i = 0; i < n; i++) x[i] = 1.0 / n, signs[i] = 0;
  for (int step = 0; step < most_steps; step++) {
    apply(inverse, inverse->straight, x);
    const double size = sig_sum_of_sizes(n, x);
    if (!isfinite(size)) return INFINITY;
    if (step > 0 && size <= norm) break;
    norm = size;
    if (take_signs(n, x, signs)) break;
    apply(inverse, inverse->transposed, x);
    const int next = sig_place_of_largest(n, x);
    if (place >= 0 && fabs(x[next]) <= fabs(x[place])) break;
    place = next;
    for (int i = 0; i < n; i++) x[i] = i == place;
  }
  const double alternating = alternating_estimate(inverse, x);
  return alternating > norm ? alternating : norm;
}

static double reciprocal(const inverse_t *inverse, double norm, double *work, int *signs) {
  if (inverse->n == 0) return 1;
  const double product = norm * norm_of_inverse(inverse, work, signs);
  return product > 0 ? 1 / product : 0;
}

double sig_reciprocal_condition_lu(int n, const double *factors, int ldf, double norm, double *work, int *signs) {
  const inverse_t inverse = {n, ldf, factors, {SIG_LOWER_UNIT, SIG_UPPER}, {SIG_UPPER_T, SIG_LOWER_UNIT_T}};
  return reciprocal(&inverse, norm, work, signs);
}

double sig_reciprocal_condition_cholesky(int n, const double *factor, int ldf, double norm, double *work, int *signs) {
  const inverse_t inverse = {n, ldf, factor, {SIG_LOWER, SIG_LOWER_T}, {SIG_LOWER, SIG_LOWER_T}};
  return reciprocal(&inverse, norm, work, signs);
}
