/* SPDX-License-Identifier: BSD-3-Clause */
/* Products and factorizations of small and middle-sized dense matrices. A query of a model calls nothing else for its
   linear algebra, so an answer does not depend on the BLAS of the machine or of the host program.

   Matrices are stored by columns: entry (i, j) of a matrix with the leading dimension ld is at [i + j * ld], ld >=
   number of rows. Indices are 0-based. Arrays that are written overlap no other one. No function keeps anything,
   allocates memory or prints: any number of threads may call them. The order of every sum depends on the shapes alone,
   so the same numbers give the same bits, whatever the thread and the addresses of the arrays. Processors with
   different vector instructions round differently. */
#ifndef SIGNOROM_DENSE_KERNELS_H
#define SIGNOROM_DENSE_KERNELS_H

/* y = alpha a x + beta y, shapes (m, n), (n), (m). With beta = 0 it does not matter what y holds. */
void sig_multiply(int m, int n, double alpha, const double *a, int lda, const double *x, double beta, double *y);

/* y += a x for an x that is mostly zero: the columns of a that belong to zeros are not read. Shapes (m, n), (n), (m).
 */
void sig_add_few_columns(int m, int n, const double *a, int lda, const double *x, double *y);

/* y += a x, and sizes += the sizes of all terms of this sum. Columns that belong to zeros in x are not read. Shapes
   (m, n), (n), (m), (m). */
void sig_add_columns_and_sizes(int m, int n, const double *a, int lda, const double *x, double *y, double *sizes);

/* y = alpha a' x + beta y, shapes (m, n), (m), (n). */
void sig_multiply_transpose(int m, int n, double alpha, const double *a, int lda, const double *x, double beta,
                            double *y);

/* y += a x for a in single precision; sums are in double precision. Columns that belong to zeros of x are not read.
   Shapes (m, n), (n), (m); the columns of a follow each other. */
void sig_add_single_columns(int m, int n, const float *a, const double *x, double *y);

/* y += a' x likewise, shapes (m, n), (m), (n). */
void sig_add_single_products(int m, int n, const float *a, const double *x, double *y);

/* c += alpha op(a) op(b), op(a) of shape (m, k), op(b) of shape (k, n); the first two arguments say what is transposed.
 */
void sig_add_product(int a_is_transposed, int b_is_transposed, int m, int n, int k, double alpha, const double *a,
                     int lda, const double *b, int ldb, double *c, int ldc);

/* LU factors with row exchanges in place, shape (n, n): L has ones on its diagonal, row i was exchanged with
   row pivots[i] >= i. Returns 0, or the number (from 1) of the first pivot that is zero or not a number; the factors
   are of no use then. */
int sig_factor_lu(int n, double *a, int lda, int *pivots);

/* x = A^-1 b in place for n_rhs columns, with the factors of sig_factor_lu. */
void sig_solve_lu(int n, int n_rhs, const double *factors, int ldf, const int *pivots, double *b, int ldb);

/* 1 / (|A| |A^-1|) in the 1-norm from the factors of A and its norm; |A^-1| is estimated and is hardly ever three times
   too small (Higham, ACM Trans. Math. Softw. 14 (1988) 381). 1 where n is 0, and 0 where the inverse or the norm is not
   finite. Work arrays: work (n), signs (n). */
double sig_reciprocal_condition_lu(int n, const double *factors, int ldf, double norm, double *work, int *signs);

/* A = L L' in place, lower triangle; the upper one is neither read nor written. Returns 0, or the number (from 1) of
   the first pivot that is not positive: A is not positive definite, and the factor is of no use. */
int sig_factor_cholesky(int n, double *a, int lda);

/* The same where part of the factor is known: on entry the first n_columns columns hold L in their first n_rows rows,
   and all other entries hold A. n_columns is a multiple of 8, n_columns <= n_rows <= n. */
int sig_extend_cholesky(int n_columns, int n_rows, int n, double *a, int lda);

/* x = A^-1 b in place for n_rhs columns, with the factor of sig_factor_cholesky. */
void sig_solve_cholesky(int n, int n_rhs, const double *factor, int ldf, double *b, int ldb);

/* b = L^-1 b in place: b' A^-1 b is then the sum of squares. */
void sig_reduce_cholesky(int n, const double *factor, int ldf, double *b);

/* 1 / (|A| |A^-1|) as sig_reciprocal_condition_lu gives it, from the factor of sig_factor_cholesky. */
double sig_reciprocal_condition_cholesky(int n, const double *factor, int ldf, double norm, double *work, int *signs);

/* Largest |x_i|; 0 where n is 0, NaN where an x_i is NaN. */
double sig_largest_size(int n, const double *x);

/* Sum of |x_i|. */
double sig_sum_of_sizes(int n, const double *x);

#endif
