/* SPDX-License-Identifier: BSD-3-Clause */
/* Products of matrices in single precision with vectors in double precision.

   The order of every sum is written out in the loops, so that vector instructions of the compiler change no bit. */
#include "dense_parts.h"
#include "signorom/dense_kernels.h"

/* Eight numbers of single precision at any place in memory. */
typedef float eight_singles __attribute__((vector_size(32), aligned(4), may_alias));

/* Eight numbers of single precision from `place` on, in double precision: a macro, as a function cannot return such a
   vector on every processor. */
#define EIGHT_AT(place) __builtin_convertvector(*(const eight_singles *)(place), sig_eight)

/* y += sum_k t_k a_k over four columns, each at any place in memory. */
SIG_FOR_EACH_PROCESSOR
static void add_four_columns(int m, const float *const *a, const double *t, double *restrict y) {
  const float *a0 = a[0], *a1 = a[1], *a2 = a[2], *a3 = a[3];
  const double t0 = t[0], t1 = t[1], t2 = t[2], t3 = t[3];
  int i = 0;
  for (; i + 8 <= m; i += 8) {
    sig_eight sum = *(const sig_eight_in_memory *)(y + i);
    sum += EIGHT_AT(a0 + i) * t0;
    sum += EIGHT_AT(a1 + i) * t1;
    sum += EIGHT_AT(a2 + i) * t2;
    sum += EIGHT_AT(a3 + i) * t3;
    *(sig_eight_in_memory *)(y + i) = sum;
  }
  for (; i < m; i++) {
    double sum = y[i];
    sum += a0[i] * t0;
    sum += a1[i] * t1;
    sum += a2[i] * t2;
    sum += a3[i] * t3;
    y[i] = sum;
  }
}

void sig_add_single_columns(int m, int n, const float *a, const double *x, double *y) {
  const float *columns[4];
  double t[4];
  int n_found = 0;
  for (int j = 0; j < n; j++) {
    if (x[j] == 0) continue;
    columns[n_found] = a + (ptrdiff_t)j * m;
    t[n_found++] = x[j];
    if (n_found < 4) continue;
    add_four_columns(m, columns, t, y);
    n_found = 0;
  }
  if (n_found == 0) return;
  for (int k = n_found; k < 4; k++) columns[k] = columns[0], t[k] = 0;
  add_four_columns(m, columns, t, y);
}

/* products_k += a_k' x over four columns, which may be the same. */
SIG_FOR_EACH_PROCESSOR
static void four_products(int m, const float *const *a, const double *x, double *products) {
  const float *a0 = a[0], *a1 = a[1], *a2 = a[2], *a3 = a[3];
  sig_eight s0 = {0}, s1 = {0}, s2 = {0}, s3 = {0};
  int i = 0;
  for (; i + 8 <= m; i += 8) {
    const sig_eight xi = *(const sig_eight_in_memory *)(x + i);
    s0 += xi * EIGHT_AT(a0 + i);
    s1 += xi * EIGHT_AT(a1 + i);
    s2 += xi * EIGHT_AT(a2 + i);
    s3 += xi * EIGHT_AT(a3 + i);
  }
  const sig_eight sums[4] = {s0, s1, s2, s3};
  for (int k = 0; k < 4; k++) {
    double part[8];
    for (int l = 0; l < 8; l++) part[l] = sums[k][l];
    for (int l = i; l < m; l++) part[l - i] += x[l] * a[k][l];
    products[k] += ((part[0] + part[4]) + (part[2] + part[6])) + ((part[1] + part[5]) + (part[3] + part[7]));
  }
}

void sig_add_single_products(int m, int n, const float *a, const double *x, double *products) {
  for (int j = 0; j < n; j += 4) {
    const float *columns[4];
    double four[4] = {0};
    for (int k = 0; k < 4; k++) columns[k] = a + (ptrdiff_t)(j + k < n ? j + k : n - 1) * m;
    four_products(m, columns, x, four);
    for (int k = 0; k < 4 && j + k < n; k++) products[j + k] += four[k];
  }
}
