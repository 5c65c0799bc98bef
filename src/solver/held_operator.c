// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/held_operator.h"

typedef struct {
  Mat stiffness, transformation, springs, coupling; // all but the first one may be NULL
  Vec diagonal, is_free;
  Vec unknowns, displacement, forces;
} Held;

static PetscErrorCode multiply(Mat matrix, Vec x, Vec y) {
  Held *held;
  const PetscScalar *d, *values, *is_free;
  PetscScalar *products;
  PetscInt n;

  PetscCall(MatShellGetContext(matrix, &held));
  PetscCall(VecPointwiseMult(held->unknowns, held->is_free, x));
  if (held->transformation) {
    PetscCall(MatMult(held->transformation, held->unknowns, held->displacement));
    PetscCall(MatMult(held->stiffness, held->displacement, held->forces));
    PetscCall(MatMultTranspose(held->transformation, held->forces, y));
  } else {
    PetscCall(MatMult(held->stiffness, held->unknowns, y));
  }
  if (held->coupling) {
    PetscCall(VecCopy(y, held->forces));
    PetscCall(MatMultAdd(held->coupling, held->forces, y, y));
  }
  if (held->springs) PetscCall(MatMultAdd(held->springs, held->unknowns, y, y));
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArrayRead(held->diagonal, &d));
  PetscCall(VecGetArrayRead(held->is_free, &is_free));
  PetscCall(VecGetArrayRead(x, &values));
  PetscCall(VecGetArray(y, &products));
  for (PetscInt i = 0; i < n; i++)
    if (is_free[i] == 0.0) products[i] = d[i] * values[i];
  PetscCall(VecRestoreArray(y, &products));
  PetscCall(VecRestoreArrayRead(x, &values));
  PetscCall(VecRestoreArrayRead(held->is_free, &is_free));
  PetscCall(VecRestoreArrayRead(held->diagonal, &d));
  return 0;
}

static PetscErrorCode get_diagonal(Mat matrix, Vec diagonal) {
  Held *held;

  PetscCall(MatShellGetContext(matrix, &held));
  PetscCall(VecCopy(held->diagonal, diagonal));
  return 0;
}

static PetscErrorCode destroy(Mat matrix) {
  Held *held;

  PetscCall(MatShellGetContext(matrix, &held));
  PetscCall(MatDestroy(&held->stiffness));
  PetscCall(MatDestroy(&held->transformation));
  PetscCall(MatDestroy(&held->springs));
  PetscCall(MatDestroy(&held->coupling));
  PetscCall(VecDestroy(&held->diagonal));
  PetscCall(VecDestroy(&held->is_free));
  PetscCall(VecDestroy(&held->unknowns));
  PetscCall(VecDestroy(&held->displacement));
  PetscCall(VecDestroy(&held->forces));
  PetscCall(PetscFree(held));
  return 0;
}

PetscErrorCode sig_held_operator_create(Mat stiffness, Mat *matrix) {
  Held *held;
  PetscInt n_local, block_size;

  PetscCall(PetscNew(&held));
  PetscCall(PetscObjectReference((PetscObject)stiffness));
  held->stiffness = stiffness;
  PetscCall(MatCreateVecs(stiffness, &held->diagonal, &held->is_free));
  PetscCall(MatCreateVecs(stiffness, &held->unknowns, &held->displacement));
  PetscCall(VecDuplicate(held->displacement, &held->forces));
  PetscCall(MatGetLocalSize(stiffness, &n_local, NULL));
  PetscCall(MatGetBlockSize(stiffness, &block_size));
  PetscCall(MatCreateShell(PetscObjectComm((PetscObject)stiffness), n_local, n_local, PETSC_DETERMINE, PETSC_DETERMINE,
                           held, matrix));
  PetscCall(MatSetBlockSize(*matrix, block_size));
  PetscCall(MatShellSetOperation(*matrix, MATOP_MULT, (void (*)(void))multiply));
  PetscCall(MatShellSetOperation(*matrix, MATOP_GET_DIAGONAL, (void (*)(void))get_diagonal));
  PetscCall(MatShellSetOperation(*matrix, MATOP_DESTROY, (void (*)(void))destroy));
  return 0;
}

// Takes a matrix, or NULL, in the place of another one.
static PetscErrorCode replace(Mat *old, Mat matrix) {
  if (matrix) PetscCall(PetscObjectReference((PetscObject)matrix));
  PetscCall(MatDestroy(old));
  *old = matrix;
  return 0;
}

PetscErrorCode sig_held_operator_couple(Mat matrix, Mat springs, Mat coupling) {
  Held *held;

  PetscCall(MatShellGetContext(matrix, &held));
  PetscCall(replace(&held->springs, springs));
  PetscCall(replace(&held->coupling, coupling));
  return 0;
}

PetscErrorCode sig_held_operator_hold(Mat matrix, Mat transformation, Vec diagonal, Vec is_free) {
  Held *held;

  PetscCall(MatShellGetContext(matrix, &held));
  PetscCall(replace(&held->transformation, transformation));
  PetscCall(VecCopy(diagonal, held->diagonal));
  PetscCall(VecCopy(is_free, held->is_free));
  // It has changed: smoothers take its diagonal anew.
  PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  return 0;
}

PetscErrorCode sig_held_operator_with_coupling(Mat matrix, Vec is_free, Mat springs, Mat coupling, Mat *coupled) {
  Held *held;

  PetscCall(MatShellGetContext(matrix, &held));
  PetscCall(sig_held_operator_create(held->stiffness, coupled));
  PetscCall(sig_held_operator_couple(*coupled, springs, coupling));
  PetscCall(sig_held_operator_hold(*coupled, held->transformation, held->diagonal, is_free));
  return 0;
}
