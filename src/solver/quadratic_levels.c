// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/quadratic_levels.h"

static const char NAME[] = "signorom_linear_interpolant";

int sig_set_linear_interpolant(intptr_t handle, int n_dim, int n_nodes, int n_corners, const int *offsets,
                               const int *corners_0) {
  Mat matrix = (Mat)handle, interpolant;
  PetscInt first_row, first_column;

  PetscCall(MatCreate(PetscObjectComm((PetscObject)matrix), &interpolant));
  PetscCall(MatSetSizes(interpolant, n_nodes * n_dim, n_corners * n_dim, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetBlockSizes(interpolant, n_dim, n_dim));
  PetscCall(MatSetType(interpolant, MATAIJ));
  // the middle of a hexahedron has eight corners
  PetscCall(MatSeqAIJSetPreallocation(interpolant, 8, NULL));
  PetscCall(MatMPIAIJSetPreallocation(interpolant, 8, NULL, 8, NULL));
  PetscCall(MatGetOwnershipRange(interpolant, &first_row, NULL));
  PetscCall(MatGetOwnershipRangeColumn(interpolant, &first_column, NULL));
  for (int i = 0; i < n_nodes; i++)
    for (int k = offsets[i]; k < offsets[i + 1]; k++)
      for (int d = 0; d < n_dim; d++)
        PetscCall(MatSetValue(interpolant, first_row + i * n_dim + d, corners_0[k] * n_dim + d,
                              1.0 / (offsets[i + 1] - offsets[i]), INSERT_VALUES));
  PetscCall(MatAssemblyBegin(interpolant, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(interpolant, MAT_FINAL_ASSEMBLY));
  PetscCall(PetscObjectCompose((PetscObject)matrix, NAME, (PetscObject)interpolant));
  PetscCall(MatDestroy(&interpolant));
  return 0;
}

// Copies the values of a field at the corners, whose rows of the interpolation have one entry.
static PetscErrorCode take_corners(Mat interpolant, Vec field, Vec corners) {
  const PetscScalar *values;
  PetscInt first, last;

  PetscCall(MatGetOwnershipRange(interpolant, &first, &last));
  PetscCall(VecGetArrayRead(field, &values));
  for (PetscInt i = first; i < last; i++) {
    PetscInt n;
    const PetscInt *columns;
    PetscCall(MatGetRow(interpolant, i, &n, &columns, NULL));
    if (n == 1) PetscCall(VecSetValue(corners, columns[0], values[i - first], INSERT_VALUES));
    PetscCall(MatRestoreRow(interpolant, i, &n, &columns, NULL));
  }
  PetscCall(VecRestoreArrayRead(field, &values));
  PetscCall(VecAssemblyBegin(corners));
  PetscCall(VecAssemblyEnd(corners));
  return 0;
}

// Gives the matrix of the linear elements the near null space of the quadratic ones, made orthonormal again.
static PetscErrorCode share_near_null_space(Mat quadratic, Mat interpolant, Mat linear) {
  MatNullSpace space;
  PetscInt n;
  const Vec *fields;
  Vec corners[6];
  PetscScalar products[6];

  PetscCall(MatGetNearNullSpace(quadratic, &space));
  if (!space) return 0;
  PetscCall(MatNullSpaceGetVecs(space, NULL, &n, &fields));
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(MatCreateVecs(linear, &corners[i], NULL));
    PetscCall(take_corners(interpolant, fields[i], corners[i]));
    for (int sweep = 0; sweep < 2; sweep++) {
      PetscCall(VecMDot(corners[i], i, corners, products));
      for (PetscInt j = 0; j < i; j++) products[j] = -products[j];
      PetscCall(VecMAXPY(corners[i], i, products, corners));
      PetscCall(VecNormalize(corners[i], NULL));
    }
  }
  PetscCall(MatNullSpaceCreate(PetscObjectComm((PetscObject)linear), PETSC_FALSE, n, corners, &space));
  PetscCall(MatSetNearNullSpace(linear, space));
  PetscCall(MatNullSpaceDestroy(&space));
  for (PetscInt i = 0; i < n; i++) PetscCall(VecDestroy(&corners[i]));
  return 0;
}

// The smoother of GAMG: Chebyshev's with the diagonal.
static PetscErrorCode set_smoother(PC pc, PetscInt i_level, Mat matrix, Mat preconditioning) {
  KSP smoother;
  PC diagonal;

  PetscCall(PCMGGetSmoother(pc, i_level, &smoother));
  PetscCall(KSPSetOperators(smoother, matrix, preconditioning));
  PetscCall(KSPSetType(smoother, KSPCHEBYSHEV));
  PetscCall(KSPGetPC(smoother, &diagonal));
  PetscCall(PCSetType(diagonal, PCJACOBI));
  return 0;
}

// Each rank factors all of the coarsest level. The shift is for bodies that only contact holds.
static PetscErrorCode set_coarse_solver(PC pc, Mat matrix) {
  KSP coarse, direct;
  PC copies, factor;

  PetscCall(PCMGGetCoarseSolve(pc, &coarse));
  PetscCall(KSPSetOperators(coarse, matrix, matrix));
  PetscCall(KSPSetType(coarse, KSPPREONLY));
  PetscCall(KSPGetPC(coarse, &copies));
  PetscCall(PCSetType(copies, PCREDUNDANT));
  PetscCall(PCRedundantGetKSP(copies, &direct));
  PetscCall(KSPSetType(direct, KSPPREONLY));
  PetscCall(KSPGetPC(direct, &factor));
  PetscCall(PCSetType(factor, PCLU));
  PetscCall(PCFactorSetShiftType(factor, MAT_SHIFT_INBLOCKS));
  return 0;
}

// Puts the quadratic elements above the levels of a GAMG for the linear ones.
static PetscErrorCode put_above(PC pc, Mat matrix, Mat preconditioning, Mat interpolant, PC gamg) {
  PetscInt n;
  Mat coarse;
  KSP smoother;

  PetscCall(PCMGGetLevels(gamg, &n));
  PetscCall(PCSetType(pc, PCMG));
  PetscCall(PCMGSetLevels(pc, n + 1, NULL));
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(PCMGGetSmoother(gamg, i, &smoother));
    PetscCall(KSPGetOperators(smoother, NULL, &coarse));
    if (i == 0) {
      PetscCall(set_coarse_solver(pc, coarse));
    } else {
      Mat interpolation;
      PetscCall(PCMGGetInterpolation(gamg, i, &interpolation));
      PetscCall(PCMGSetInterpolation(pc, i, interpolation));
      PetscCall(set_smoother(pc, i, coarse, coarse));
    }
  }
  PetscCall(PCMGSetInterpolation(pc, n, interpolant));
  PetscCall(set_smoother(pc, n, matrix, preconditioning));
  return 0;
}

PetscErrorCode sig_quadratic_levels_create(KSP ksp, Mat matrix, PetscErrorCode (*prepare)(KSP, Mat)) {
  Mat interpolant, linear, copy;
  const char *prefix;
  KSP linear_ksp;
  PC pc, gamg;

  PetscCall(PetscObjectQuery((PetscObject)matrix, NAME, (PetscObject *)&interpolant));
  if (!interpolant) return 0;
  PetscCall(MatPtAP(matrix, interpolant, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &linear));
  PetscCall(share_near_null_space(matrix, interpolant, linear));
  PetscCall(KSPCreate(PetscObjectComm((PetscObject)ksp), &linear_ksp));
  PetscCall(KSPGetOptionsPrefix(ksp, &prefix));
  PetscCall(KSPSetOptionsPrefix(linear_ksp, prefix));
  PetscCall(prepare(linear_ksp, linear));
  PetscCall(KSPGetOperators(ksp, &copy, NULL));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(KSPGetPC(linear_ksp, &gamg));
  PetscCall(put_above(pc, copy, matrix, interpolant, gamg));
  PetscCall(KSPDestroy(&linear_ksp));
  PetscCall(MatDestroy(&linear));
  return 0;
}
