/* SPDX-License-Identifier: BSD-3-Clause */
/* Singular values and left vectors of a matrix whose rows are spread over ranks, and the gathering of rows. The matrix
   is handed over column by column and kept once. All arrays are column-major and contiguous; comm is a Fortran
   communicator handle. Every function returns a PETSc error code, 0 = success, and all but sig_thin_svd are
   collective. */
#ifndef SIGNOROM_SNAPSHOT_SVD_H
#define SIGNOROM_SNAPSHOT_SVD_H
#include <stdint.h>

/* Makes a matrix of n_columns columns of zeros with n_local rows on this rank; n_local >= 0 may differ from rank to
 * rank. */
int sig_snapshot_svd_create(int comm, int n_local, int n_columns, intptr_t *svd);

/* Sets column `column`, 0-based: the n_local rows of this rank. */
int sig_snapshot_svd_set_column(intptr_t svd, int column, const double *rows);

/* Decomposes A = Q triangle with orthonormal columns of Q, by tall-skinny QR (SLEPc's BV). triangle (n_columns,
 * n_columns) is zero below its diagonal and the same on all ranks. Q replaces A. The call needs n_columns <= rows of
 * all ranks. */
int sig_snapshot_svd_triangle(intptr_t svd, double *triangle);

/* Decomposes A = left diag(singular_values) right', by the same QR and SLEPc's SVD object for the triangle.
 * singular_values (n_columns) are descending and the same on all ranks. The call fails where options of the SVD object
 * (-pod_svd_...) leave values out, because the error measure needs all of them. */
int sig_snapshot_svd_decompose(intptr_t svd, double *singular_values);

/* Gives the first n_vectors left vectors, shape (n_local, n_vectors). Call it once, after sig_snapshot_svd_decompose.
 */
int sig_snapshot_svd_left(intptr_t svd, int n_vectors, double *left);

int sig_snapshot_svd_destroy(intptr_t *svd);

/* Computes the singular values and left vectors of a matrix (n_rows, n_columns) of any shape on one rank. With k =
 * min(n_rows, n_columns) the results are singular_values (k) and left (n_rows, k). It takes the same options and fails
 * in the same case as sig_snapshot_svd_decompose. */
int sig_thin_svd(int n_rows, int n_columns, const double *matrix, double *singular_values, double *left);

/* Gathers the rows of all ranks on every rank, in rank order: local (n_local, n_columns) -> gathered (n_rows,
 * n_columns), n_rows = sum of n_local. */
int sig_gather_rows(int comm, int n_local, int n_rows, int n_columns, const double *local, double *gathered);
#endif
