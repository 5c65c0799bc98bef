// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/snapshot_svd.h"

#include <slepcbv.h>
#include <slepcsvd.h>

typedef struct {
  BV basis;        // the matrix A, later Q of its QR
  Mat of_triangle; // left vectors of the triangle
  PetscInt n_local, n_columns;
} snapshot_svd;

// Computes the largest k singular values of a matrix on one rank and their left vectors. Fails if fewer are found.
static PetscErrorCode decompose(Mat matrix, PetscInt k, double *singular_values, Mat left) {
  SVD svd;
  Vec vector;
  PetscInt n_found;
  PetscReal value;

  PetscFunctionBegin;
  PetscCall(SVDCreate(PETSC_COMM_SELF, &svd));
  PetscCall(SVDSetOptionsPrefix(svd, "pod_"));
  PetscCall(SVDSetOperators(svd, matrix, NULL));
  PetscCall(SVDSetType(svd, SVDLAPACK));
  PetscCall(SVDSetDimensions(svd, k, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(SVDSetFromOptions(svd));
  PetscCall(SVDSolve(svd));
  PetscCall(SVDGetConverged(svd, &n_found));
  PetscCheck(n_found >= k, PETSC_COMM_SELF, PETSC_ERR_CONV_FAILED,
             "the options -pod_svd_... leave %d of %d singular values", (int)n_found, (int)k);
  for (PetscInt i = 0; i < k; i++) {
    PetscCall(MatDenseGetColumnVecWrite(left, i, &vector));
    PetscCall(SVDGetSingularTriplet(svd, i, &value, vector, NULL));
    PetscCall(MatDenseRestoreColumnVecWrite(left, i, &vector));
    singular_values[i] = value;
  }
  PetscCall(SVDDestroy(&svd));
  PetscFunctionReturn(0);
}

int sig_thin_svd(int n_rows, int n_columns, const double *matrix, double *singular_values, double *left) {
  const PetscInt k = n_rows < n_columns ? n_rows : n_columns;
  Mat copy, vectors;
  PetscScalar *entries;

  if (k == 0) return 0;
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, n_rows, n_columns, NULL, &copy));
  PetscCall(MatDenseGetArrayWrite(copy, &entries));
  PetscCall(PetscArraycpy(entries, matrix, (size_t)n_rows * (size_t)n_columns));
  PetscCall(MatDenseRestoreArrayWrite(copy, &entries));
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, n_rows, k, left, &vectors));
  PetscCall(decompose(copy, k, singular_values, vectors));
  PetscCall(MatDestroy(&vectors));
  PetscCall(MatDestroy(&copy));
  return 0;
}

// A rank without rows adds one row of zeros, because LAPACK's QR refuses an empty block. Zero rows change neither
// singular values nor the other rows of the left vectors.
int sig_snapshot_svd_create(int comm, int n_local, int n_columns, intptr_t *handle) {
  snapshot_svd *self;

  PetscCall(PetscNew(&self));
  *handle = (intptr_t)self;
  self->n_local = n_local;
  self->n_columns = n_columns;
  if (n_columns == 0) return 0;
  PetscCall(BVCreate(MPI_Comm_f2c(comm), &self->basis));
  PetscCall(BVSetSizes(self->basis, n_local > 0 ? n_local : 1, PETSC_DETERMINE, n_columns));
  PetscCall(BVSetOrthogonalization(self->basis, BV_ORTHOG_CGS, BV_ORTHOG_REFINE_IFNEEDED, PETSC_DEFAULT,
                                   BV_ORTHOG_BLOCK_TSQR));
  PetscCall(BVSetOptionsPrefix(self->basis, "pod_"));
  PetscCall(BVSetFromOptions(self->basis));
  return 0;
}

// Columns are set one by one, because newer releases of SLEPc add padding to the columns of the whole array.
int sig_snapshot_svd_set_column(intptr_t handle, int column, const double *rows) {
  const snapshot_svd *self = (snapshot_svd *)handle;
  Vec vector;
  PetscScalar *values;

  PetscCall(BVGetColumn(self->basis, column, &vector));
  PetscCall(VecGetArrayWrite(vector, &values));
  values[0] = 0;
  PetscCall(PetscArraycpy(values, rows, (size_t)self->n_local));
  PetscCall(VecRestoreArrayWrite(vector, &values));
  PetscCall(BVRestoreColumn(self->basis, column, &vector));
  return 0;
}

int sig_snapshot_svd_triangle(intptr_t handle, double *triangle) {
  const snapshot_svd *self = (snapshot_svd *)handle;
  Mat factor;

  if (self->n_columns == 0) return 0;
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, self->n_columns, self->n_columns, triangle, &factor));
  PetscCall(BVOrthogonalize(self->basis, factor));
  PetscCall(MatDestroy(&factor));
  return 0;
}

// All ranks have the triangle, but only one decomposes it, because this takes as much memory as about twenty triangles.
static PetscErrorCode decompose_on_first(MPI_Comm comm, Mat triangle, PetscInt n, double *singular_values, Mat left) {
  PetscMPIInt rank;
  PetscScalar *entries;
  int status = 0;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) status = (int)decompose(triangle, n, singular_values, left);
  PetscCallMPI(MPI_Bcast(&status, 1, MPI_INT, 0, comm));
  PetscCall((PetscErrorCode)status);
  PetscCallMPI(MPI_Bcast(singular_values, (int)n, MPI_DOUBLE, 0, comm));
  PetscCall(MatDenseGetArray(left, &entries));
  for (PetscInt column = 0; column < n; column++)
    PetscCallMPI(MPI_Bcast(entries + (size_t)column * (size_t)n, (int)n, MPI_DOUBLE, 0, comm));
  PetscCall(MatDenseRestoreArray(left, &entries));
  PetscFunctionReturn(0);
}

int sig_snapshot_svd_decompose(intptr_t handle, double *singular_values) {
  snapshot_svd *self = (snapshot_svd *)handle;
  const PetscInt n = self->n_columns;
  Mat triangle;

  if (n == 0) return 0;
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, n, n, NULL, &triangle));
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, n, n, NULL, &self->of_triangle));
  PetscCall(BVOrthogonalize(self->basis, triangle));
  PetscCall(
      decompose_on_first(PetscObjectComm((PetscObject)self->basis), triangle, n, singular_values, self->of_triangle));
  PetscCall(MatDestroy(&triangle));
  return 0;
}

int sig_snapshot_svd_left(intptr_t handle, int n_vectors, double *left) {
  const snapshot_svd *self = (snapshot_svd *)handle;

  if (n_vectors == 0) return 0;
  PetscCall(BVMultInPlace(self->basis, self->of_triangle, 0, n_vectors));
  for (PetscInt column = 0; column < n_vectors; column++) {
    Vec vector;
    const PetscScalar *values;
    PetscCall(BVGetColumn(self->basis, column, &vector));
    PetscCall(VecGetArrayRead(vector, &values));
    PetscCall(PetscArraycpy(left + (size_t)column * (size_t)self->n_local, values, (size_t)self->n_local));
    PetscCall(VecRestoreArrayRead(vector, &values));
    PetscCall(BVRestoreColumn(self->basis, column, &vector));
  }
  return 0;
}

int sig_snapshot_svd_destroy(intptr_t *handle) {
  snapshot_svd *self = (snapshot_svd *)*handle;

  PetscCall(BVDestroy(&self->basis));
  PetscCall(MatDestroy(&self->of_triangle));
  PetscCall(PetscFree(self));
  *handle = 0;
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
  // Column by column, so that counts stay below 2**31 and each piece is received at its final place.
  for (int column = 0; column < n_columns; column++)
    PetscCallMPI(MPI_Allgatherv(local + (size_t)column * n_local, n_local, MPI_DOUBLE,
                                gathered + (size_t)column * n_rows, counts, starts, MPI_DOUBLE, c_comm));
  PetscCall(PetscFree2(counts, starts));
  return 0;
}
