// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/contact_levels.h"

// P is the finest interpolation, of GAMG or from linear elements, and S = diag(free_share). The unknowns x = T^-1 u
// have the interpolation S T^-1 P. The first coarse matrix is computed as (T S T^-1 P)' K (T S T^-1 P), because K has
// far fewer entries than T' K T if contact rows have many nodes.
typedef struct {
  Mat stiffness, transformation;
  Mat free_interpolation; // T^-1 P
  Mat interpolation;      // S T^-1 P, the interpolation of the finest level
  Mat motions;            // T S T^-1 P
} Levels;

static const char NAME[] = "signorom_contact_levels";

static PetscErrorCode destroy_levels(void *pointer) {
  Levels *levels = pointer;

  PetscCall(MatDestroy(&levels->stiffness));
  PetscCall(MatDestroy(&levels->transformation));
  PetscCall(MatDestroy(&levels->free_interpolation));
  PetscCall(MatDestroy(&levels->interpolation));
  PetscCall(MatDestroy(&levels->motions));
  PetscCall(PetscFree(levels));
  return 0;
}

static PetscErrorCode get_levels(KSP ksp, Levels **levels) {
  PetscContainer container;

  *levels = NULL;
  PetscCall(PetscObjectQuery((PetscObject)ksp, NAME, (PetscObject *)&container));
  if (container) PetscCall(PetscContainerGetPointer(container, (void **)levels));
  return 0;
}

static PetscErrorCode keep_levels(KSP ksp, Levels *levels) {
  PetscContainer container;

  PetscCall(PetscContainerCreate(PetscObjectComm((PetscObject)ksp), &container));
  PetscCall(PetscContainerSetPointer(container, levels));
  PetscCall(PetscContainerSetUserDestroy(container, destroy_levels));
  PetscCall(PetscObjectCompose((PetscObject)ksp, NAME, (PetscObject)container));
  PetscCall(PetscContainerDestroy(&container));
  return 0;
}

PetscErrorCode sig_contact_levels_create(KSP ksp, Mat stiffness, Mat transformation, Mat inverse) {
  PC pc;
  Mat interpolation;
  PetscBool has_levels;
  PetscInt n_levels;
  Levels *levels;

  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &has_levels, PCGAMG, PCMG, ""));
  if (!has_levels) return 0;
  PetscCall(PCMGGetLevels(pc, &n_levels));
  if (n_levels < 2) return 0;
  PetscCall(PetscNew(&levels));
  PetscCall(keep_levels(ksp, levels));
  PetscCall(PetscObjectReference((PetscObject)stiffness));
  levels->stiffness = stiffness;
  PetscCall(PetscObjectReference((PetscObject)transformation));
  levels->transformation = transformation;
  PetscCall(PCMGGetInterpolation(pc, n_levels - 1, &interpolation));
  PetscCall(MatMatMult(inverse, interpolation, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &levels->free_interpolation));
  PetscCall(MatProductClear(levels->free_interpolation));
  PetscCall(MatDuplicate(levels->free_interpolation, MAT_COPY_VALUES, &levels->interpolation));
  PetscCall(PCMGSetInterpolation(pc, n_levels - 1, levels->interpolation));
  PetscCall(PCMGSetRestriction(pc, n_levels - 1, levels->interpolation));
  // Otherwise GAMG would compute the coarse matrices from T' K T itself.
  PetscCall(PCSetReusePreconditioner(pc, PETSC_TRUE));
  return 0;
}

// Sets the matrices of a level: the operator, and the matrix from which its smoother is made.
static PetscErrorCode set_matrices(PC pc, PetscInt i_level, Mat matrix, Mat preconditioning) {
  KSP smoother;

  PetscCall(PCMGGetSmoother(pc, i_level, &smoother));
  PetscCall(KSPSetOperators(smoother, matrix, preconditioning));
  if (i_level > 0) PetscCall(PCMGSetResidual(pc, i_level, PCMGResidualDefault, matrix));
  return 0;
}

// Computes P' A P as the matrix of a level. Except for the first time, the level has a matrix of the same pattern,
// which gets the new values.
static PetscErrorCode project(PC pc, PetscInt i_level, Mat fine, Mat interpolation, PetscBool is_first, Mat *coarse) {
  KSP smoother;

  PetscCall(PCMGGetSmoother(pc, i_level, &smoother));
  PetscCall(KSPGetOperators(smoother, NULL, coarse));
  PetscCall(MatPtAP(fine, interpolation, is_first ? MAT_INITIAL_MATRIX : MAT_REUSE_MATRIX, PETSC_DEFAULT, coarse));
  PetscCall(set_matrices(pc, i_level, *coarse, *coarse));
  // The smoother keeps a reference to the matrix.
  if (is_first) PetscCall(PetscObjectDereference((PetscObject)*coarse));
  return 0;
}

PetscErrorCode sig_contact_levels_hold(KSP ksp, Vec free_share) {
  PC pc;
  PetscInt n_levels;
  Mat matrix, preconditioning, interpolation;
  Levels *levels;

  PetscCall(get_levels(ksp, &levels));
  if (!levels) return 0;
  const PetscBool is_first = levels->motions ? PETSC_FALSE : PETSC_TRUE;
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCMGGetLevels(pc, &n_levels));
  PetscCall(MatCopy(levels->free_interpolation, levels->interpolation, SAME_NONZERO_PATTERN));
  PetscCall(MatDiagonalScale(levels->interpolation, free_share, NULL));
  PetscCall(MatMatMult(levels->transformation, levels->interpolation, is_first ? MAT_INITIAL_MATRIX : MAT_REUSE_MATRIX,
                       PETSC_DEFAULT, &levels->motions));
  PetscCall(KSPGetOperators(ksp, &matrix, &preconditioning));
  PetscCall(set_matrices(pc, n_levels - 1, matrix, preconditioning));
  matrix = levels->stiffness;
  interpolation = levels->motions;
  for (PetscInt i = n_levels - 2; i >= 0; i--) {
    PetscCall(project(pc, i, matrix, interpolation, is_first, &matrix));
    if (i > 0) PetscCall(PCMGGetInterpolation(pc, i, &interpolation));
  }
  return 0;
}
