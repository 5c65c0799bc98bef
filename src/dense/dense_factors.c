/* SPDX-License-Identifier: BSD-3-Clause */
/* LU and Cholesky factors, and systems of equations with them. A matrix is divided into halves again and again until a
   few columns are left, so that products of matrices do most of the work (Toledo, SIAM J. Matrix Anal. Appl. 18 (1997)
   1065). */
#include "dense_parts.h"
#include "signorom/dense_kernels.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Number of columns in the first half of a matrix with n > SIG_BLOCK columns: a multiple of SIG_BLOCK near n / 2. */
static int half_of(int n) { return (n / 2 + SIG_BLOCK - 1) / SIG_BLOCK * SIG_BLOCK; }

/* b = T^-1 b for a triangle of at most SIG_BLOCK columns and one right-hand side. */
static void solve_small(sig_triangle kind, int n, const double *a, ptrdiff_t lda, double *b) {
  switch (kind) {
  case SIG_LOWER_UNIT:
  case SIG_LOWER:
    for (int j = 0; j < n; j++) {
      if (kind == SIG_LOWER) b[j] /= a[j + j * lda];
      for (int i = j + 1; i < n; i++) b[i] -= a[i + j * lda] * b[j];
    }
    break;
  case SIG_UPPER:
    for (int j = n - 1; j >= 0; j--) {
      b[j] /= a[j + j * lda];
      for (int i = 0; i < j; i++) b[i] -= a[i + j * lda] * b[j];
    }
    break;
  case SIG_LOWER_UNIT_T:
  case SIG_LOWER_T:
    for (int j = n - 1; j >= 0; j--) {
      for (int i = j + 1; i < n; i++) b[j] -= a[i + j * lda] * b[i];
      if (kind == SIG_LOWER_T) b[j] /= a[j + j * lda];
    }
    break;
  case SIG_UPPER_T:
    for (int j = 0; j < n; j++) {
      for (int i = 0; i < j; i++) b[j] -= a[i + j * lda] * b[i];
      b[j] /= a[j + j * lda];
    }
    break;
  }
}

/* b -= b_p l_p, where l_p is column p below the diagonal; the shuffle copies b_p to all places of a register. */
#define TAKE(p, b) b -= l##p * __builtin_shufflevector(b, b, p, p, p, p, p, p, p, p)

/* b = L^-1 b for a triangle of SIG_BLOCK columns with ones on its diagonal. Four right-hand sides are solved at once,
   because each step of one of them must wait for the step before it. */
SIG_FOR_EACH_PROCESSOR
static void solve_unit_block(int n_rhs, const double *a, ptrdiff_t lda, double *b, ptrdiff_t ldb) {
  sig_eight below[SIG_BLOCK] = {0};
  for (int j = 0; j < SIG_BLOCK; j++)
    for (int i = j + 1; i < SIG_BLOCK; i++) below[j][i] = a[i + j * lda];
  const sig_eight l0 = below[0], l1 = below[1], l2 = below[2], l3 = below[3], l4 = below[4], l5 = below[5],
                  l6 = below[6];
  for (int j = 0; j < n_rhs; j += 4) {
    sig_eight_in_memory *place[4];
    for (int k = 0; k < 4; k++) place[k] = (sig_eight_in_memory *)(b + (j + k < n_rhs ? j + k : n_rhs - 1) * ldb);
    sig_eight x0 = *place[0], x1 = *place[1], x2 = *place[2], x3 = *place[3];
    TAKE(0, x0), TAKE(0, x1), TAKE(0, x2), TAKE(0, x3);
    TAKE(1, x0), TAKE(1, x1), TAKE(1, x2), TAKE(1, x3);
    TAKE(2, x0), TAKE(2, x1), TAKE(2, x2), TAKE(2, x3);
    TAKE(3, x0), TAKE(3, x1), TAKE(3, x2), TAKE(3, x3);
    TAKE(4, x0), TAKE(4, x1), TAKE(4, x2), TAKE(4, x3);
    TAKE(5, x0), TAKE(5, x1), TAKE(5, x2), TAKE(5, x3);
    TAKE(6, x0), TAKE(6, x1), TAKE(6, x2), TAKE(6, x3);
    *place[0] = x0, *place[1] = x1, *place[2] = x2, *place[3] = x3;
  }
}

/* b -= a x for one right-hand side, shapes (m), (m, n), (n): moves a known part x of the solution to the right-hand
   side. */
static void take_columns(int m, int n, const double *a, ptrdiff_t lda, const double *x, double *b) {
  double t[SIG_BLOCK] = {0};
  for (int j = 0; j < n; j++) t[j] = -x[j];
  sig_add_columns(m, n, a, lda, t, b);
}

static void take_products(int m, int n, const double *a, ptrdiff_t lda, const double *x, double *b) {
  double products[SIG_BLOCK];
  sig_column_products(m, n, a, lda, x, products);
  for (int j = 0; j < n; j++) b[j] -= products[j];
}

/* Whether the first unknown is solved for first. */
static int is_forward(sig_triangle kind) { return kind == SIG_LOWER_UNIT || kind == SIG_LOWER || kind == SIG_UPPER_T; }

/* b = T^-1 b for one right-hand side, block by block. */
static void solve_vector(sig_triangle kind, int n, const double *a, ptrdiff_t lda, double *b) {
  const int last = (n - 1) / SIG_BLOCK * SIG_BLOCK;
  for (int done = 0; done <= last; done += SIG_BLOCK) {
    const int k = is_forward(kind) ? done : last - done;
    const int end = k + SIG_BLOCK < n ? k + SIG_BLOCK : n;
    const double *columns = a + k * lda;
    if (kind == SIG_UPPER_T) take_products(k, end - k, columns, lda, b, b + k);
    if (kind == SIG_LOWER_T || kind == SIG_LOWER_UNIT_T)
      take_products(n - end, end - k, columns + end, lda, b + end, b + k);
    solve_small(kind, end - k, columns + k, lda, b + k);
    if (kind == SIG_UPPER) take_columns(k, end - k, columns, lda, b + k, b);
    if (kind == SIG_LOWER || kind == SIG_LOWER_UNIT) take_columns(n - end, end - k, columns + end, lda, b + k, b + end);
  }
}

void sig_solve_triangle(sig_triangle kind, int n, int n_rhs, const double *a, ptrdiff_t lda, double *b, ptrdiff_t ldb) {
  if (n == SIG_BLOCK && kind == SIG_LOWER_UNIT) {
    solve_unit_block(n_rhs, a, lda, b, ldb);
    return;
  }
  if (n <= SIG_BLOCK || n_rhs < 4) {
    for (int j = 0; j < n_rhs; j++) solve_vector(kind, n, a, lda, b + j * ldb);
    return;
  }
  const int n_1 = half_of(n), n_2 = n - n_1;
  const int is_transposed = kind == SIG_LOWER_UNIT_T || kind == SIG_LOWER_T || kind == SIG_UPPER_T;
  const int is_upper = kind == SIG_UPPER || kind == SIG_UPPER_T;
  const double *between = is_upper ? a + n_1 * lda : a + n_1, *second = a + n_1 + n_1 * lda;
  double *b_2 = b + n_1;
  const int l = (int)lda, m = (int)ldb;
  if (is_forward(kind)) {
    sig_solve_triangle(kind, n_1, n_rhs, a, lda, b, ldb);
    sig_add_product(is_transposed, 0, n_2, n_rhs, n_1, -1, between, l, b, m, b_2, m);
    sig_solve_triangle(kind, n_2, n_rhs, second, lda, b_2, ldb);
  } else {
    sig_solve_triangle(kind, n_2, n_rhs, second, lda, b_2, ldb);
    sig_add_product(is_transposed, 0, n_1, n_rhs, n_2, -1, between, l, b_2, m, b, m);
    sig_solve_triangle(kind, n_1, n_rhs, a, lda, b, ldb);
  }
}

/* Exchanges rows k and pivots[k], k = first to last - 1, of n columns. */
static void exchange_rows(int n, double *a, ptrdiff_t lda, int first, int last, const int *pivots) {
  for (int j = 0; j < n; j++) {
    double *column = a + j * lda;
    for (int k = first; k < last; k++) {
      const double entry = column[k];
      column[k] = column[pivots[k]];
      column[pivots[k]] = entry;
    }
  }
}

/* LU factors of at most SIG_BLOCK columns, one column after the other; each is updated by all earlier columns at once.
 */
static int factor_panel(int m, int n, double *a, ptrdiff_t lda, int *pivots) {
  int bad = 0;
  for (int j = 0; j < n; j++) {
    double *column = a + j * lda;
    solve_small(SIG_LOWER_UNIT, j, a, lda, column);
    take_columns(m - j, j, a + j, lda, column, column + j);
    pivots[j] = j + sig_place_of_largest(m - j, column + j);
    exchange_rows(n, a, lda, j, j + 1, pivots);
    const double pivot = column[j];
    if (!(fabs(pivot) > 0)) {
      if (!bad) bad = j + 1;
      continue;
    }
    /* the inverse of a pivot below DBL_MIN could be infinite */
    const double scale = 1 / pivot;
    if (fabs(pivot) >= DBL_MIN)
      for (int i = j + 1; i < m; i++) column[i] *= scale;
    else
      for (int i = j + 1; i < m; i++) column[i] /= pivot;
  }
  return bad;
}

/* LU factors of n columns with m >= n rows. */
static int factor_columns(int m, int n, double *a, ptrdiff_t lda, int *pivots) {
  if (n <= SIG_BLOCK) return factor_panel(m, n, a, lda, pivots);
  const int n_1 = half_of(n), n_2 = n - n_1;
  double *right = a + n_1 * lda;
  const int bad_1 = factor_columns(m, n_1, a, lda, pivots);
  exchange_rows(n_2, right, lda, 0, n_1, pivots);
  sig_solve_triangle(SIG_LOWER_UNIT, n_1, n_2, a, lda, right, lda);
  sig_add_product(0, 0, m - n_1, n_2, n_1, -1, a + n_1, (int)lda, right, (int)lda, right + n_1, (int)lda);
  const int bad_2 = factor_columns(m - n_1, n_2, right + n_1, lda, pivots + n_1);
  for (int k = n_1; k < n; k++) pivots[k] += n_1;
  exchange_rows(n_1, a, lda, n_1, n, pivots);
  if (bad_1) return bad_1;
  return bad_2 ? n_1 + bad_2 : 0;
}

int sig_factor_lu(int n, double *a, int lda, int *pivots) { return factor_columns(n, n, a, lda, pivots); }

void sig_solve_lu(int n, int n_rhs, const double *factors, int ldf, const int *pivots, double *b, int ldb) {
  exchange_rows(n_rhs, b, ldb, 0, n, pivots);
  sig_solve_triangle(SIG_LOWER_UNIT, n, n_rhs, factors, ldf, b, ldb);
  sig_solve_triangle(SIG_UPPER, n, n_rhs, factors, ldf, b, ldb);
}

/* Cholesky factor of a triangle of at most SIG_BLOCK columns. Each column is subtracted from the later ones as soon as
   it is known. */
SIG_FOR_EACH_PROCESSOR
static int factor_small(int n, double *a, ptrdiff_t lda) {
  for (int j = 0; j < n; j++) {
    double *column = a + j * lda;
    if (!(column[j] > 0)) return j + 1;
    column[j] = sqrt(column[j]);
    const double scale = 1 / column[j];
    for (int i = j + 1; i < n; i++) column[i] *= scale;
    for (int k = j + 1; k < n; k++)
      for (int i = k; i < n; i++) a[i + k * lda] -= column[i] * column[k];
  }
  return 0;
}

/* Steps for column j of b L'^-1 for eight rows: TAKE_COLUMN subtracts column k, FINISH divides by the diagonal. */
#define FINISH(j) x##j *= 1 / a[j + j * lda]
#define TAKE_COLUMN(j, k) x##j -= x##k * a[j + k * lda]

/* b = b L'^-1 for eight rows and a triangle of SIG_BLOCK columns. */
static inline __attribute__((always_inline)) void solve_eight_rows(const double *a, ptrdiff_t lda, double *b,
                                                                   ptrdiff_t ldb) {
  sig_eight_in_memory *place[SIG_BLOCK];
  for (int j = 0; j < SIG_BLOCK; j++) place[j] = (sig_eight_in_memory *)(b + j * ldb);
  sig_eight x0 = *place[0], x1 = *place[1], x2 = *place[2], x3 = *place[3];
  sig_eight x4 = *place[4], x5 = *place[5], x6 = *place[6], x7 = *place[7];
  FINISH(0);
  TAKE_COLUMN(1, 0), TAKE_COLUMN(2, 0), TAKE_COLUMN(3, 0), TAKE_COLUMN(4, 0);
  TAKE_COLUMN(5, 0), TAKE_COLUMN(6, 0), TAKE_COLUMN(7, 0);
  FINISH(1);
  TAKE_COLUMN(2, 1), TAKE_COLUMN(3, 1), TAKE_COLUMN(4, 1), TAKE_COLUMN(5, 1), TAKE_COLUMN(6, 1), TAKE_COLUMN(7, 1);
  FINISH(2);
  TAKE_COLUMN(3, 2), TAKE_COLUMN(4, 2), TAKE_COLUMN(5, 2), TAKE_COLUMN(6, 2), TAKE_COLUMN(7, 2);
  FINISH(3);
  TAKE_COLUMN(4, 3), TAKE_COLUMN(5, 3), TAKE_COLUMN(6, 3), TAKE_COLUMN(7, 3);
  FINISH(4);
  TAKE_COLUMN(5, 4), TAKE_COLUMN(6, 4), TAKE_COLUMN(7, 4);
  FINISH(5);
  TAKE_COLUMN(6, 5), TAKE_COLUMN(7, 5);
  FINISH(6);
  TAKE_COLUMN(7, 6);
  FINISH(7);
  *place[0] = x0, *place[1] = x1, *place[2] = x2, *place[3] = x3;
  *place[4] = x4, *place[5] = x5, *place[6] = x6, *place[7] = x7;
}

/* b = b L'^-1 for m rows and a triangle of SIG_BLOCK columns. */
SIG_FOR_EACH_PROCESSOR
static void solve_block_from_right(int m, const double *a, ptrdiff_t lda, double *b, ptrdiff_t ldb) {
  const int whole = m / 8 * 8;
  double copy[8 * SIG_BLOCK] = {0};
  for (int i = 0; i < whole; i += 8) solve_eight_rows(a, lda, b + i, ldb);
  if (whole == m) return;
  for (int j = 0; j < SIG_BLOCK; j++)
    for (int i = whole; i < m; i++) copy[i - whole + 8 * j] = b[i + j * ldb];
  solve_eight_rows(a, lda, copy, 8);
  for (int j = 0; j < SIG_BLOCK; j++)
    for (int i = whole; i < m; i++) b[i + j * ldb] = copy[i - whole + 8 * j];
}

/* b = b L'^-1 for m rows, which gives the rows of the factor below its leading triangle. n is a multiple of SIG_BLOCK.
 */
static void solve_from_right(int m, int n, const double *a, ptrdiff_t lda, double *b, ptrdiff_t ldb) {
  if (n == SIG_BLOCK) {
    solve_block_from_right(m, a, lda, b, ldb);
    return;
  }
  const int n_1 = half_of(n);
  double *right = b + n_1 * ldb;
  solve_from_right(m, n_1, a, lda, b, ldb);
  sig_add_product(0, 1, m, n - n_1, n_1, -1, b, (int)ldb, a + n_1, (int)lda, right, (int)ldb);
  solve_from_right(m, n - n_1, a + n_1 + n_1 * lda, lda, right, ldb);
}

/* c -= b b' in the lower triangle of c, shapes (n, n) and (n, k). */
static void take_square(int n, int k, const double *b, ptrdiff_t ldb, double *c, ptrdiff_t ldc) {
  if (n > 3 * SIG_BLOCK) {
    const int n_1 = half_of(n);
    take_square(n_1, k, b, ldb, c, ldc);
    sig_add_product(0, 1, n - n_1, n_1, k, -1, b + n_1, (int)ldb, b, (int)ldb, c + n_1, (int)ldc);
    take_square(n - n_1, k, b + n_1, ldb, c + n_1 + n_1 * ldc, ldc);
    return;
  }
  double square[9 * SIG_BLOCK * SIG_BLOCK];
  memset(square, 0, (size_t)n * n * sizeof *square);
  sig_add_product(0, 1, n, n, k, 1, b, (int)ldb, b, (int)ldb, square, n);
  for (int j = 0; j < n; j++)
    for (int i = j; i < n; i++) c[i + j * ldc] -= square[i + j * n];
}

static int factor_triangle(int n, double *a, ptrdiff_t lda) {
  if (n <= SIG_BLOCK) return factor_small(n, a, lda);
  const int n_1 = half_of(n), n_2 = n - n_1;
  double *lower = a + n_1, *second = a + n_1 + n_1 * lda;
  int bad = factor_triangle(n_1, a, lda);
  if (bad) return bad;
  solve_from_right(n_2, n_1, a, lda, lower, lda);
  take_square(n_2, n_1, lower, lda, second, lda);
  bad = factor_triangle(n_2, second, lda);
  return bad ? n_1 + bad : 0;
}

int sig_factor_cholesky(int n, double *a, int lda) { return factor_triangle(n, a, lda); }

int sig_extend_cholesky(int n_columns, int n_rows, int n, double *a, int lda) {
  const int n_2 = n - n_columns;
  double *second = a + n_columns + (ptrdiff_t)n_columns * lda;
  if (n_2 == 0) return 0;
  if (n_columns > 0) {
    if (n_rows < n) solve_from_right(n - n_rows, n_columns, a, lda, a + n_rows, lda);
    take_square(n_2, n_columns, a + n_columns, lda, second, lda);
  }
  const int bad = factor_triangle(n_2, second, lda);
  return bad ? n_columns + bad : 0;
}

void sig_reduce_cholesky(int n, const double *factor, int ldf, double *b) {
  sig_solve_triangle(SIG_LOWER, n, 1, factor, ldf, b, n);
}

void sig_solve_cholesky(int n, int n_rhs, const double *factor, int ldf, double *b, int ldb) {
  sig_solve_triangle(SIG_LOWER, n, n_rhs, factor, ldf, b, ldb);
  sig_solve_triangle(SIG_LOWER_T, n, n_rhs, factor, ldf, b, ldb);
}
