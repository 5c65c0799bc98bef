// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/symmetric_copy.h"

static PetscErrorCode fill(Mat matrix, Mat copy) {
  PetscInt first, end;

  PetscCall(MatGetOwnershipRange(matrix, &first, &end));
  for (PetscInt row = first; row < end; row++) {
    const PetscInt *columns;
    const PetscScalar *values;
    PetscInt n_columns, n_lower = 0;
    PetscCall(MatGetRow(matrix, row, &n_columns, &columns, &values));
    while (columns[n_lower] < row) n_lower++;
    PetscCall(MatSetValues(copy, 1, &row, n_columns - n_lower, columns + n_lower, values + n_lower, INSERT_VALUES));
    PetscCall(MatRestoreRow(matrix, row, &n_columns, &columns, &values));
  }
  PetscCall(MatAssemblyBegin(copy, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(copy, MAT_FINAL_ASSEMBLY));
  return 0;
}

// Counts the blocks of each local block row from its diagonal block on: those in columns of this rank, and the others.
static PetscErrorCode count_blocks(Mat matrix, PetscInt block_size, PetscInt *inside, PetscInt *outside) {
  PetscInt first, end;

  PetscCall(MatGetOwnershipRange(matrix, &first, &end));
  for (PetscInt row = first; row < end; row += block_size) {
    const PetscInt i = (row - first) / block_size, *columns;
    PetscInt n_columns;
    inside[i] = outside[i] = 0;
    PetscCall(MatGetRow(matrix, row, &n_columns, &columns, NULL));
    for (PetscInt k = 0; k < n_columns; k += block_size) {
      if (columns[k] >= row && columns[k] < end) inside[i]++;
      if (columns[k] >= end) outside[i]++;
    }
    PetscCall(MatRestoreRow(matrix, row, &n_columns, &columns, NULL));
  }
  return 0;
}

PetscErrorCode sig_symmetric_copy_create(Mat matrix, Mat *copy) {
  PetscInt n_local, block_size, *inside, *outside;

  PetscCall(MatGetLocalSize(matrix, &n_local, NULL));
  PetscCall(MatGetBlockSize(matrix, &block_size));
  PetscCall(PetscMalloc2(n_local / block_size, &inside, n_local / block_size, &outside));
  PetscCall(count_blocks(matrix, block_size, inside, outside));
  PetscCall(MatCreate(PetscObjectComm((PetscObject)matrix), copy));
  PetscCall(MatSetSizes(*copy, n_local, n_local, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(*copy, MATSBAIJ));
  PetscCall(MatXAIJSetPreallocation(*copy, block_size, NULL, NULL, inside, outside));
  PetscCall(PetscFree2(inside, outside));
  PetscCall(fill(matrix, *copy));
  return 0;
}
