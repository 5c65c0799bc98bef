// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/snapshot_svd.h"

#include <slepcbv.h>

// needs the types of the one above
#include <slepcblaslapack.h>

// LAPACK wants an extent of at least one even where there is nothing.
static PetscBLASInt leading(PetscBLASInt n) { return n > 0 ? n : 1; }

int sig_thin_svd(int n_rows, int n_columns, const double *matrix, double *singular_values, double *left) {
  const PetscBLASInt m = n_rows, n = n_columns, k = m < n ? m : n, lda = leading(m), ldvt = leading(k);
  PetscBLASInt info = 0, work_size = -1, *integers;
  double *copy, *right, *work, best_size = 0;

  if (k == 0) return 0;
  PetscCall(PetscMalloc3((size_t)m * n, &copy, (size_t)k * n, &right, (size_t)8 * k, &integers));
  PetscCall(PetscArraycpy(copy, matrix, (size_t)m * n));
  LAPACKgesdd_("S", &m, &n, copy, &lda, singular_values, left, &lda, right, &ldvt, &best_size, &work_size, integers,
               &info);
  if (info == 0) {
    work_size = (PetscBLASInt)best_size;
    PetscCall(PetscMalloc1((size_t)work_size, &work));
    LAPACKgesdd_("S", &m, &n, copy, &lda, singular_values, left, &lda, right, &ldvt, work, &work_size, integers, &info);
    PetscCall(PetscFree(work));
  }
  PetscCall(PetscFree3(copy, right, integers));
  PetscCheck(info == 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK dgesdd failed with info %d", (int)info);
  return 0;
}

// Fills a basis vectors object with the rows; an empty rank adds one row of zeros, because LAPACK's QR refuses none at
// all and zero rows change neither singular values nor the other rows of the left vectors.
static PetscErrorCode create_basis(MPI_Comm comm, PetscInt n_local, PetscInt n_columns, const double *rows, BV *basis) {
  const PetscInt n_padded = n_local > 0 ? n_local : 1;

  PetscFunctionBegin;
  PetscCall(BVCreate(comm, basis));
  PetscCall(BVSetSizes(*basis, n_padded, PETSC_DETERMINE, n_columns));
  PetscCall(
      BVSetOrthogonalization(*basis, BV_ORTHOG_CGS, BV_ORTHOG_REFINE_IFNEEDED, PETSC_DEFAULT, BV_ORTHOG_BLOCK_TSQR));
  PetscCall(BVSetOptionsPrefix(*basis, "pod_"));
  PetscCall(BVSetFromOptions(*basis));
  // column by column: newer releases of SLEPc pad the columns of the whole array
  for (PetscInt column = 0; column < n_columns; column++) {
    Vec vector;
    PetscScalar *values;
    PetscCall(BVGetColumn(*basis, column, &vector));
    PetscCall(VecGetArrayWrite(vector, &values));
    values[0] = 0;
    PetscCall(PetscArraycpy(values, rows + (size_t)column * n_local, (size_t)n_local));
    PetscCall(VecRestoreArrayWrite(vector, &values));
    PetscCall(BVRestoreColumn(*basis, column, &vector));
  }
  PetscFunctionReturn(0);
}

// The inverse of create_basis.
static PetscErrorCode read_basis(BV basis, PetscInt n_local, PetscInt n_columns, double *rows) {
  PetscFunctionBegin;
  for (PetscInt column = 0; column < n_columns; column++) {
    Vec vector;
    const PetscScalar *values;
    PetscCall(BVGetColumn(basis, column, &vector));
    PetscCall(VecGetArrayRead(vector, &values));
    PetscCall(PetscArraycpy(rows + (size_t)column * n_local, values, (size_t)n_local));
    PetscCall(VecRestoreArrayRead(vector, &values));
    PetscCall(BVRestoreColumn(basis, column, &vector));
  }
  PetscFunctionReturn(0);
}

// basis <- left vectors of the matrix that it holds: QR, SVD of the triangle (replicated, so each rank does the same),
// product.
static PetscErrorCode replace_by_left_vectors(BV basis, PetscInt n_columns, double *singular_values) {
  Mat triangle, left_of_triangle;
  const PetscScalar *entries;
  PetscScalar *left;

  PetscFunctionBegin;
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, n_columns, n_columns, NULL, &triangle));
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, n_columns, n_columns, NULL, &left_of_triangle));
  PetscCall(BVOrthogonalize(basis, triangle));
  PetscCall(MatDenseGetArrayRead(triangle, &entries));
  PetscCall(MatDenseGetArrayWrite(left_of_triangle, &left));
  PetscCall((PetscErrorCode)sig_thin_svd(n_columns, n_columns, entries, singular_values, left));
  PetscCall(MatDenseRestoreArrayWrite(left_of_triangle, &left));
  PetscCall(MatDenseRestoreArrayRead(triangle, &entries));
  PetscCall(BVMultInPlace(basis, left_of_triangle, 0, n_columns));
  PetscCall(MatDestroy(&left_of_triangle));
  PetscCall(MatDestroy(&triangle));
  PetscFunctionReturn(0);
}

int sig_tall_svd(int comm, int n_local, int n_columns, const double *rows, double *singular_values, double *left) {
  BV basis;

  if (n_columns == 0) return 0;
  PetscCall(create_basis(MPI_Comm_f2c(comm), n_local, n_columns, rows, &basis));
  PetscCall(replace_by_left_vectors(basis, n_columns, singular_values));
  PetscCall(read_basis(basis, n_local, n_columns, left));
  PetscCall(BVDestroy(&basis));
  return 0;
}

int sig_tall_triangle(int comm, int n_local, int n_columns, const double *rows, double *triangle) {
  BV basis;
  Mat factor;
  const PetscScalar *entries;

  if (n_columns == 0) return 0;
  PetscCall(create_basis(MPI_Comm_f2c(comm), n_local, n_columns, rows, &basis));
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, n_columns, n_columns, NULL, &factor));
  PetscCall(BVOrthogonalize(basis, factor));
  PetscCall(MatDenseGetArrayRead(factor, &entries));
  PetscCall(PetscArraycpy(triangle, entries, (size_t)n_columns * n_columns));
  PetscCall(MatDenseRestoreArrayRead(factor, &entries));
  PetscCall(MatDestroy(&factor));
  PetscCall(BVDestroy(&basis));
  return 0;
}

int sig_gather_rows(int comm, int n_local, int n_rows, int n_columns, const double *local, double *gathered) {
  const MPI_Comm c_comm = MPI_Comm_f2c(comm);
  int n_ranks, *counts, *starts;

  PetscCallMPI(MPI_Comm_size(c_comm, &n_ranks));
  PetscCall(PetscMalloc2(n_ranks, &counts, n_ranks + 1, &starts));
  PetscCallMPI(MPI_Allgather(&n_local, 1, MPI_INT, counts, 1, MPI_INT, c_comm));
  starts[0] = 0;
  for (int rank = 0; rank < n_ranks; rank++) starts[rank + 1] = starts[rank] + counts[rank];
  // Column by column: counts stay below 2**31 and each piece lands in place.
  for (int column = 0; column < n_columns; column++)
    PetscCallMPI(MPI_Allgatherv(local + (size_t)column * n_local, n_local, MPI_DOUBLE,
                                gathered + (size_t)column * n_rows, counts, starts, MPI_DOUBLE, c_comm));
  PetscCall(PetscFree2(counts, starts));
  return 0;
}
