/* SPDX-License-Identifier: BSD-3-Clause */
/* Thin singular value decomposition of a tall matrix whose rows are spread over ranks, and the gathering of its result.
   All matrices are column-major and contiguous; comm is a Fortran communicator handle. Every function returns a PETSc
   error code, 0 = success; all but sig_thin_svd are collective on comm. */
#ifndef SIGNOROM_SNAPSHOT_SVD_H
#define SIGNOROM_SNAPSHOT_SVD_H

/* A = left diag(singular_values) right' for the rows of all ranks below each other, by tall-skinny QR (SLEPc BV) and
   LAPACK's dgesdd of its triangle. rows (n_local, n_columns): this rank's rows, n_local >= 0 and different from rank to
   rank. singular_values (n_columns), descending, the same on all ranks; left (n_local, n_columns): this rank's rows of
   the left vectors. Needs n_columns <= rows of all ranks. */
int sig_tall_svd(int comm, int n_local, int n_columns, const double *rows, double *singular_values, double *left);

/* The same for a matrix (n_rows, n_columns) of any shape on one rank; with k = min(n_rows, n_columns):
   singular_values (k), left (n_rows, k). */
int sig_thin_svd(int n_rows, int n_columns, const double *matrix, double *singular_values, double *left);

/* A = Q triangle with orthonormal columns of Q, for the rows of all ranks below each other, as in sig_tall_svd.
   triangle (n_columns, n_columns), zero below its diagonal, the same on all ranks. */
int sig_tall_triangle(int comm, int n_local, int n_columns, const double *rows, double *triangle);

/* Rows of all ranks below each other, in rank order: local (n_local, n_columns) -> gathered (n_rows, n_columns)
   everywhere, n_rows = sum of n_local. */
int sig_gather_rows(int comm, int n_local, int n_rows, int n_columns, const double *local, double *gathered);
#endif
