/* SPDX-License-Identifier: BSD-3-Clause */
/* Products of matrices with vectors and matrices.

   The order of every sum is written out in the loops, so that vector instructions of the compiler change no bit. */
#include "dense_parts.h"
#include "signorom/dense_kernels.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Sizes of the pieces of a product. A panel of 8 rows and most_inner columns fits into the first-level cache. A piece
   of most_inner rows and most_columns columns of the other factor fits into the second-level cache. A tile has
   tile_columns columns of the result. */
enum { most_inner = 256, most_columns = 240, tile_columns = 6 };

/* With this number of columns or more, copying a panel once is cheaper than reading it from its matrix for each tile.
 */
enum { columns_worth_a_copy = 25 };

/* sum + t_1 a_1 + ... + t_7 a_7, of one row. */
static inline __attribute__((always_inline)) double add_seven(double sum, const double *a, ptrdiff_t lda,
                                                              const double *t) {
  sum += a[lda] * t[1];
  sum += a[2 * lda] * t[2];
  sum += a[3 * lda] * t[3];
  sum += a[4 * lda] * t[4];
  sum += a[5 * lda] * t[5];
  sum += a[6 * lda] * t[6];
  sum += a[7 * lda] * t[7];
  return sum;
}

SIG_FOR_EACH_PROCESSOR
void sig_add_columns(int m, int n, const double *restrict a, ptrdiff_t lda, const double *restrict t,
                     double *restrict y) {
  int j = 0;
  for (; j + 8 <= n; j += 8, a += 8 * lda, t += 8)
    for (int i = 0; i < m; i++) y[i] = add_seven(y[i] + a[i] * t[0], a + i, lda, t);
  if (j + 4 <= n) {
    for (int i = 0; i < m; i++) {
      double sum = y[i] + a[i] * t[0];
      sum += a[i + lda] * t[1];
      sum += a[i + 2 * lda] * t[2];
      sum += a[i + 3 * lda] * t[3];
      y[i] = sum;
    }
    j += 4, a += 4 * lda, t += 4;
  }
  if (j + 2 <= n) {
    for (int i = 0; i < m; i++) {
      double sum = y[i] + a[i] * t[0];
      sum += a[i + lda] * t[1];
      y[i] = sum;
    }
    j += 2, a += 2 * lda, t += 2;
  }
  if (j < n)
    for (int i = 0; i < m; i++) y[i] += a[i] * t[0];
}

/* Returns the sum of eight numbers, which are added in pairs. */
static inline double sum_of(const double *part) {
  return ((part[0] + part[4]) + (part[2] + part[6])) + ((part[1] + part[5]) + (part[3] + part[7]));
}

/* Products of four columns of length m with x; the columns may be the same. rest_of_x holds the last eight entries of
   x, with zeros for entries that earlier steps have used. */
static inline __attribute__((always_inline)) void four_products(int m, const double *const *a, const double *x,
                                                                const sig_eight *rest_of_x, double *products) {
  const double *a0 = a[0], *a1 = a[1], *a2 = a[2], *a3 = a[3];
  sig_eight sum[4];
  sig_eight s0 = {0}, s1 = {0}, s2 = {0}, s3 = {0};
  int i = 0;
  for (; i + 8 <= m; i += 8) {
    const sig_eight xi = *(const sig_eight_in_memory *)(x + i);
    s0 += xi * *(const sig_eight_in_memory *)(a0 + i);
    s1 += xi * *(const sig_eight_in_memory *)(a1 + i);
    s2 += xi * *(const sig_eight_in_memory *)(a2 + i);
    s3 += xi * *(const sig_eight_in_memory *)(a3 + i);
  }
  if (i < m) {
    i = m - 8;
    s0 += *rest_of_x * *(const sig_eight_in_memory *)(a0 + i);
    s1 += *rest_of_x * *(const sig_eight_in_memory *)(a1 + i);
    s2 += *rest_of_x * *(const sig_eight_in_memory *)(a2 + i);
    s3 += *rest_of_x * *(const sig_eight_in_memory *)(a3 + i);
  }
  sum[0] = s0, sum[1] = s1, sum[2] = s2, sum[3] = s3;
  for (int k = 0; k < 4; k++) products[k] = sum_of((const double *)&sum[k]);
}

/* Products of columns of fewer than eight entries with x. */
static void few_products(int m, int n, const double *a, ptrdiff_t lda, const double *x, double *products) {
  for (int j = 0; j < n; j++) {
    products[j] = 0;
    for (int i = 0; i < m; i++) products[j] += a[i + j * lda] * x[i];
  }
}

SIG_FOR_EACH_PROCESSOR
void sig_column_products(int m, int n, const double *a, ptrdiff_t lda, const double *x, double *products) {
  if (m < 8) {
    few_products(m, n, a, lda, x, products);
    return;
  }
  sig_eight rest_of_x = {0};
  for (int i = m / 8 * 8; i < m; i++) rest_of_x[i - m + 8] = x[i];
  for (int j = 0; j < n; j += 4) {
    const double *columns[4];
    double four[4];
    for (int k = 0; k < 4; k++) columns[k] = a + (j + k < n ? j + k : n - 1) * lda;
    four_products(m, columns, x, &rest_of_x, four);
    for (int k = 0; k < 4 && j + k < n; k++) products[j + k] = four[k];
  }
}

/* y = sum_j t_j a_j over eight columns. */
SIG_FOR_EACH_PROCESSOR
static void set_eight_columns(int m, const double *restrict a, ptrdiff_t lda, const double *restrict t,
                              double *restrict y) {
  for (int i = 0; i < m; i++) y[i] = add_seven(a[i] * t[0], a + i, lda, t);
}

void sig_multiply(int m, int n, double alpha, const double *a, int lda, const double *x, double beta, double *y) {
  double t[64];
  int n_set = 0; /* number of columns that are in the sum y before the loop */
  if (beta == 0 && n >= 8) {
    for (int j = 0; j < 8; j++) t[j] = alpha * x[j];
    set_eight_columns(m, a, lda, t, y);
    n_set = 8;
  } else if (beta != 1)
    for (int i = 0; i < m; i++) y[i] = beta == 0 ? 0 : beta * y[i];
  for (int first = n_set; first < n; first += 64) {
    const int n_columns = n - first < 64 ? n - first : 64;
    for (int j = 0; j < n_columns; j++) t[j] = alpha * x[first + j];
    sig_add_columns(m, n_columns, a + (ptrdiff_t)first * lda, lda, t, y);
  }
}

/* y += sum_k t_k a_k over four columns, each at any place in memory. */
SIG_FOR_EACH_PROCESSOR
static void add_four_columns(int m, const double *const *a, const double *restrict t, double *restrict y) {
  const double *restrict a0 = a[0], *restrict a1 = a[1], *restrict a2 = a[2], *restrict a3 = a[3];
  for (int i = 0; i < m; i++) {
    double sum = y[i] + a0[i] * t[0];
    sum += a1[i] * t[1];
    sum += a2[i] * t[2];
    sum += a3[i] * t[3];
    y[i] = sum;
  }
}

void sig_add_few_columns(int m, int n, const double *a, int lda, const double *x, double *y) {
  const double *columns[4];
  double t[4];
  int n_found = 0;
  for (int j = 0; j < n; j++) {
    if (x[j] == 0) continue;
    columns[n_found] = a + (ptrdiff_t)j * lda;
    t[n_found++] = x[j];
    if (n_found < 4) continue;
    add_four_columns(m, columns, t, y);
    n_found = 0;
  }
  for (int k = 0; k < n_found; k++) sig_add_columns(m, 1, columns[k], lda, t + k, y);
}

/* y += sum_k t_k a_k over four columns, each at any place in memory, and sizes += sum_k |t_k a_k|. */
SIG_FOR_EACH_PROCESSOR
static void add_four_columns_and_sizes(int m, const double *const *a, const double *restrict t, double *restrict y,
                                       double *restrict sizes) {
  const double *restrict a0 = a[0], *restrict a1 = a[1], *restrict a2 = a[2], *restrict a3 = a[3];
  for (int i = 0; i < m; i++) {
    const double p0 = a0[i] * t[0], p1 = a1[i] * t[1], p2 = a2[i] * t[2], p3 = a3[i] * t[3];
    y[i] += (p0 + p1) + (p2 + p3);
    sizes[i] += (fabs(p0) + fabs(p1)) + (fabs(p2) + fabs(p3));
  }
}

void sig_add_columns_and_sizes(int m, int n, const double *a, int lda, const double *x, double *y, double *sizes) {
  const double *columns[4] = {a, a, a, a};
  double t[4];
  int n_found = 0;
  for (int j = 0; j < n; j++) {
    if (x[j] == 0) continue;
    columns[n_found] = a + (ptrdiff_t)j * lda;
    t[n_found++] = x[j];
    if (n_found < 4) continue;
    add_four_columns_and_sizes(m, columns, t, y, sizes);
    n_found = 0;
  }
  if (n_found == 0) return;
  for (int k = n_found; k < 4; k++) t[k] = 0;
  add_four_columns_and_sizes(m, columns, t, y, sizes);
}

void sig_multiply_transpose(int m, int n, double alpha, const double *a, int lda, const double *x, double beta,
                            double *y) {
  double products[64];
  for (int first = 0; first < n; first += 64) {
    const int n_columns = n - first < 64 ? n - first : 64;
    sig_column_products(m, n_columns, a + (ptrdiff_t)first * lda, lda, x, products);
    for (int j = 0; j < n_columns; j++) y[first + j] = alpha * products[j] + (beta == 0 ? 0 : beta * y[first + j]);
  }
}

/* One factor of a product: entry (i, j) is at [i * row + j * column]. */
typedef struct {
  const double *entries;
  ptrdiff_t row, column;
} factor_t;

/* A panel of eight rows and k columns: entry (i, p) is at [i + p * step]. */
typedef struct {
  const double *entries;
  ptrdiff_t step;
  int k;
} panel_t;

/* Copies up to eight rows and k columns of a factor to a panel; missing rows become zero. */
static void copy_panel(const factor_t *a, int n_rows, int k, double *copy) {
  if (n_rows == 8 && a->row == 1) {
    for (int p = 0; p < k; p++) memcpy(copy + 8 * p, a->entries + p * a->column, 8 * sizeof *copy);
    return;
  }
  memset(copy, 0, 8 * (size_t)k * sizeof *copy);
  for (int p = 0; p < k; p++) {
    const double *column = a->entries + p * a->column;
    for (int i = 0; i < n_rows; i++) copy[8 * p + i] = column[i * a->row];
  }
}

/* c += alpha sum for one column of n_rows <= 8 rows. */
static inline void add_to(double *c, int n_rows, double alpha, const sig_eight *sum) {
  if (n_rows == 8) {
    *(sig_eight_in_memory *)c += alpha * *sum;
    return;
  }
  const sig_eight scaled = alpha * *sum;
  for (int i = 0; i < n_rows; i++) c[i] += scaled[i];
}

/* c += alpha a b for a tile of eight rows, of which n_rows are written, and up to six columns. Missing columns are
   computed as copies of the last one. */
SIG_FOR_EACH_PROCESSOR
static void add_tile_of_six(const panel_t *a, const factor_t *b, int n_rows, int n_columns, double alpha, double *c,
                            ptrdiff_t ldc) {
  sig_eight sum[6];
  sig_eight s0 = {0}, s1 = {0}, s2 = {0}, s3 = {0}, s4 = {0}, s5 = {0};
  const double *column[6];
  const double *ap = a->entries;
  const ptrdiff_t step = a->step, row = b->row;
  for (int j = 0; j < 6; j++) column[j] = b->entries + (j < n_columns ? j : n_columns - 1) * b->column;
  const double *b0 = column[0], *b1 = column[1], *b2 = column[2], *b3 = column[3], *b4 = column[4], *b5 = column[5];
  for (int p = 0; p < a->k; p++) {
    const sig_eight ai = *(const sig_eight_in_memory *)ap;
    const ptrdiff_t at = p * row;
    s0 += ai * b0[at];
    s1 += ai * b1[at];
    s2 += ai * b2[at];
    s3 += ai * b3[at];
    s4 += ai * b4[at];
    s5 += ai * b5[at];
    ap += step;
  }
  sum[0] = s0, sum[1] = s1, sum[2] = s2, sum[3] = s3, sum[4] = s4, sum[5] = s5;
  for (int j = 0; j < n_columns; j++) add_to(c + j * ldc, n_rows, alpha, &sum[j]);
}

/* c += alpha a b for a tile of eight rows, of which n_rows are written, and up to two columns. */
SIG_FOR_EACH_PROCESSOR
static void add_tile_of_two(const panel_t *a, const factor_t *b, int n_rows, int n_columns, double alpha, double *c,
                            ptrdiff_t ldc) {
  sig_eight s0 = {0}, s1 = {0};
  const double *ap = a->entries;
  const ptrdiff_t step = a->step, row = b->row;
  const double *b0 = b->entries, *b1 = b->entries + (n_columns > 1 ? b->column : 0);
  for (int p = 0; p < a->k; p++) {
    const sig_eight ai = *(const sig_eight_in_memory *)ap;
    s0 += ai * b0[p * row];
    s1 += ai * b1[p * row];
    ap += step;
  }
  add_to(c, n_rows, alpha, &s0);
  if (n_columns > 1) add_to(c + ldc, n_rows, alpha, &s1);
}

/* c += alpha a b for up to eight rows and any number of columns. */
static void add_panel(const factor_t *a, const factor_t *b, int n_rows, int n, int k, double alpha, double *c,
                      ptrdiff_t ldc) {
  _Alignas(64) double copy[8 * most_inner];
  panel_t panel = {.entries = a->entries, .step = a->column, .k = k};
  if (n_rows < 8 || a->row != 1 || n >= columns_worth_a_copy) {
    copy_panel(a, n_rows, k, copy);
    panel = (panel_t){.entries = copy, .step = 8, .k = k};
  }
  for (int j = 0; j < n; j += tile_columns) {
    const int n_columns = n - j < tile_columns ? n - j : tile_columns;
    const factor_t part = {.entries = b->entries + j * b->column, .row = b->row, .column = b->column};
    if (n_columns > 2)
      add_tile_of_six(&panel, &part, n_rows, n_columns, alpha, c + j * ldc, ldc);
    else
      add_tile_of_two(&panel, &part, n_rows, n_columns, alpha, c + j * ldc, ldc);
  }
}

void sig_add_product(int a_is_transposed, int b_is_transposed, int m, int n, int k, double alpha, const double *a,
                     int lda, const double *b, int ldb, double *c, int ldc) {
  factor_t left = {.row = a_is_transposed ? lda : 1, .column = a_is_transposed ? 1 : lda};
  factor_t right = {.row = b_is_transposed ? ldb : 1, .column = b_is_transposed ? 1 : ldb};
  for (int p = 0; p < k; p += most_inner) {
    const int n_inner = k - p < most_inner ? k - p : most_inner;
    for (int j = 0; j < n; j += most_columns) {
      const int n_columns = n - j < most_columns ? n - j : most_columns;
      right.entries = b + p * right.row + j * right.column;
      for (int i = 0; i < m; i += 8) {
        left.entries = a + i * left.row + p * left.column;
        add_panel(&left, &right, m - i < 8 ? m - i : 8, n_columns, n_inner, alpha, c + i + (ptrdiff_t)j * ldc, ldc);
      }
    }
  }
}

/* The bits of |x| as a whole number. These numbers have the same order as the |x|, and NaN comes last. */
typedef int64_t __attribute__((may_alias)) bits_t;
static const bits_t all_but_the_sign = INT64_MAX;

SIG_FOR_EACH_PROCESSOR
static bits_t largest_bits(int n, const bits_t *x) {
  bits_t largest = 0;
  for (int i = 0; i < n; i++) {
    const bits_t size = x[i] & all_but_the_sign;
    largest = size > largest ? size : largest;
  }
  return largest;
}

int sig_place_of_largest(int n, const double *x) {
  const bits_t *bits = (const bits_t *)x;
  const bits_t largest = largest_bits(n, bits);
  int i = 0;
  while (i < n - 1 && (bits[i] & all_but_the_sign) != largest) i++;
  return i;
}

double sig_largest_size(int n, const double *x) {
  const bits_t largest = largest_bits(n, (const bits_t *)x);
  double size;
  memcpy(&size, &largest, sizeof size);
  return size;
}

SIG_FOR_EACH_PROCESSOR
double sig_sum_of_sizes(int n, const double *x) {
  double part[8] = {0};
  int i = 0;
  for (; i + 8 <= n; i += 8)
    for (int k = 0; k < 8; k++) part[k] += fabs(x[i + k]);
  for (int k = 0; i < n; i++, k++) part[k] += fabs(x[i]);
  return sum_of(part);
}
