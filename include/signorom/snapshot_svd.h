/* SPDX-License-Identifier: BSD-3-Clause */
/* Singular values and left vectors of a matrix whose rows are spread over ranks, and the gathering of rows. The matrix
   is handed over column by column and kept once. All arrays are column-major and contiguous; comm is a Fortran
   communicator handle. Every function returns a PETSc error code, 0 = success, and is collective. */
#ifndef SIGNOROM_SNAPSHOT_SVD_H
#define SIGNOROM_SNAPSHOT_SVD_H
#include <stdint.h>

/* Room for n_local rows of this rank (n_local >= 0, different from rank to rank) and n_columns columns of zeros. */
int sig_snapshot_svd_create(int comm, int n_local, int n_columns, intptr_t *svd);

/* Column `column`, 0-based: the n_local rows of this rank. */
int sig_snapshot_svd_set_column(intptr_t svd, int column, const double *rows);

/* A = Q triangle with orthonormal columns of Q, by tall-skinny QR (SLEPc's BV). triangle (n_columns, n_columns), zero
   below its diagonal, the same on all ranks. Q takes the place of A. Needs n_columns <= rows of all ranks. */
int sig_snapshot_svd_triangle(intptr_t svd, double *triangle);

/* A = left diag(singular_values) right', by the same and SLEPc's SVD object for the triangle. singular_values
   (n_columns), descending, the same on all ranks. An error where options of the SVD object (-pod_svd_...) leave values
   out: the tail of the values counts. */
int sig_snapshot_svd_decompose(intptr_t svd, double *singular_values);

/* After sig_snapshot_svd_decompose, once: the first n_vectors left vectors, shape (n_local, n_vectors). */
int sig_snapshot_svd_left(intptr_t svd, int n_vectors, double *left);

int sig_snapshot_svd_destroy(intptr_t *svd);

/* The same for a matrix (n_rows, n_columns) of any shape on one rank; with k = min(n_rows, n_columns):
   singular_values (k), left (n_rows, k). */
int sig_thin_svd(int n_rows, int n_columns, const double *matrix, double *singular_values, double *left);

/* Rows of all ranks below each other, in rank order: local (n_local, n_columns) -> gathered (n_rows, n_columns)
   everywhere, n_rows = sum of n_local. */
int sig_gather_rows(int comm, int n_local, int n_rows, int n_columns, const double *local, double *gathered);
#endif
