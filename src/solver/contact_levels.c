// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/contact_levels.h"

#include "signorom/held_operator.h"
#include "smoother_bounds.h"

// P is the finest interpolation, of GAMG or from linear elements, F = T^-1 P, and S = diag(share), with 1 for a free
// unknown and HELD_SHARE for a held one. The unknowns x = T^-1 u have the interpolation S F, and the first coarse
// matrix is M' K M with M = T S F. Where nothing is held, M = P. So M = P - D with D = T (1 - S) F, which has entries
// only in the rows J of dofs at contacts and supports, and
//
//     M' K M = P' K P - D_J' (K P)_J - (K P)_J' D_J + D_J' K_JJ D_J .
//
// Springs between unknowns at contacts, x' Z x / 2, add (S F)_J' Z_JJ (S F)_J, whose entries are some of D_J' K_JJ D_J.
// A change of held unknowns costs as much as contacts and supports are large, whatever the size of the bodies. The
// same holds for the diagonal of T' K T, because T differs from the identity in T_JJ alone.
typedef struct {
  IS boundary;                 // J
  Mat transformation, inverse; // T_JJ, (T^-1)_JJ
  Mat stiffness, product;      // K_JJ, T_JJ' K_JJ T_JJ
  Vec diagonal;                // of T' K T
  // the others are NULL without levels
  Mat fixed, forces;          // P_J, (K P)_J
  Mat free, held, change;     // F_J, (1 - S)_JJ F_J, D_J
  Mat interpolation;          // S F
  Mat mixed, transposed, own; // D_J' (K P)_J, its transpose, D_J' K_JJ D_J
  Mat moved, springs, sprung; // (S F)_J, Z_JJ, (S F)_J' Z_JJ (S F)_J; the last two are NULL without springs
  Mat all_free, coarse;       // P' K P, M' K M
  PetscBool is_kept;          // whether the smoothers keep bounds that were estimated for other matrices
} Levels;

// With zero, coarse matrices could become singular.
static const double HELD_SHARE = 1e-3;
static const char NAME[] = "signorom_contact_levels";

static PetscErrorCode destroy_levels(void *pointer) {
  Levels *levels = pointer;
  Mat *matrices[] = {&levels->transformation, &levels->inverse,  &levels->stiffness,  &levels->product,
                     &levels->fixed,          &levels->forces,   &levels->free,       &levels->held,
                     &levels->change,         &levels->mixed,    &levels->transposed, &levels->own,
                     &levels->interpolation,  &levels->all_free, &levels->coarse,     &levels->moved,
                     &levels->springs,        &levels->sprung};

  for (size_t i = 0; i < sizeof matrices / sizeof *matrices; i++) PetscCall(MatDestroy(matrices[i]));
  PetscCall(VecDestroy(&levels->diagonal));
  PetscCall(ISDestroy(&levels->boundary));
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

// Lists the dofs that may be held, those that T may change, and those that they depend on. `mark` has 1 for the
// first ones.
static PetscErrorCode find_boundary(Mat transformation, Vec mark, IS *boundary) {
  const PetscScalar *marks;
  PetscInt first, end, n = 0, *dofs;

  PetscCall(MatGetOwnershipRange(transformation, &first, &end));
  for (PetscInt i = first; i < end; i++) {
    PetscInt n_columns;
    const PetscInt *columns;
    PetscCall(MatGetRow(transformation, i, &n_columns, &columns, NULL));
    for (PetscInt k = 0; k < n_columns && n_columns > 1; k++)
      PetscCall(VecSetValue(mark, columns[k], 1.0, INSERT_VALUES));
    PetscCall(MatRestoreRow(transformation, i, &n_columns, &columns, NULL));
  }
  PetscCall(VecAssemblyBegin(mark));
  PetscCall(VecAssemblyEnd(mark));
  PetscCall(VecGetArrayRead(mark, &marks));
  for (PetscInt i = 0; i < end - first; i++) n += marks[i] != 0.0;
  PetscCall(PetscMalloc1(n, &dofs));
  n = 0;
  for (PetscInt i = 0; i < end - first; i++)
    if (marks[i] != 0.0) dofs[n++] = first + i;
  PetscCall(VecRestoreArrayRead(mark, &marks));
  PetscCall(ISCreateGeneral(PetscObjectComm((PetscObject)transformation), n, dofs, PETSC_OWN_POINTER, boundary));
  return 0;
}

// Takes T_JJ, and computes the diagonal of T' K T.
static PetscErrorCode take_transformation(Levels *levels, Mat transformation, Mat inverse, MatReuse reuse) {
  const IS boundary = levels->boundary;
  Vec values, part;

  PetscCall(MatCreateSubMatrix(transformation, boundary, boundary, reuse, &levels->transformation));
  PetscCall(MatCreateSubMatrix(inverse, boundary, boundary, reuse, &levels->inverse));
  PetscCall(MatPtAP(levels->stiffness, levels->transformation, reuse, PETSC_DEFAULT, &levels->product));
  PetscCall(MatCreateVecs(levels->product, &values, NULL));
  PetscCall(MatGetDiagonal(levels->product, values));
  PetscCall(VecGetSubVector(levels->diagonal, boundary, &part));
  PetscCall(VecCopy(values, part));
  PetscCall(VecRestoreSubVector(levels->diagonal, boundary, &part));
  PetscCall(VecDestroy(&values));
  return 0;
}

// Computes F_J, (1 - S)_JJ F_J and D_J. held_part has 1 - share of each boundary dof.
static PetscErrorCode change_motions(Levels *levels, Vec held_part, MatReuse reuse) {
  PetscCall(MatMatMult(levels->inverse, levels->fixed, reuse, PETSC_DEFAULT, &levels->free));
  if (reuse == MAT_INITIAL_MATRIX) PetscCall(MatDuplicate(levels->free, MAT_COPY_VALUES, &levels->held));
  PetscCall(MatCopy(levels->free, levels->held, SAME_NONZERO_PATTERN));
  PetscCall(MatDiagonalScale(levels->held, held_part, NULL));
  PetscCall(MatMatMult(levels->transformation, levels->held, reuse, PETSC_DEFAULT, &levels->change));
  return 0;
}

// Puts the rows J into the interpolation S F = F - (1 - S) F.
static PetscErrorCode set_boundary_rows(Levels *levels) {
  const PetscInt *rows;
  PetscInt n, first;

  if (!levels->moved) PetscCall(MatDuplicate(levels->free, MAT_DO_NOT_COPY_VALUES, &levels->moved));
  PetscCall(MatCopy(levels->free, levels->moved, SAME_NONZERO_PATTERN));
  PetscCall(MatAXPY(levels->moved, -1.0, levels->held, SAME_NONZERO_PATTERN));
  PetscCall(MatGetOwnershipRange(levels->moved, &first, NULL));
  PetscCall(ISGetLocalSize(levels->boundary, &n));
  PetscCall(ISGetIndices(levels->boundary, &rows));
  for (PetscInt i = 0; i < n; i++) {
    PetscInt n_columns;
    const PetscInt *columns;
    const PetscScalar *values;
    PetscCall(MatGetRow(levels->moved, first + i, &n_columns, &columns, &values));
    PetscCall(MatSetValues(levels->interpolation, 1, &rows[i], n_columns, columns, values, INSERT_VALUES));
    PetscCall(MatRestoreRow(levels->moved, first + i, &n_columns, &columns, &values));
  }
  PetscCall(ISRestoreIndices(levels->boundary, &rows));
  PetscCall(MatAssemblyBegin(levels->interpolation, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(levels->interpolation, MAT_FINAL_ASSEMBLY));
  return 0;
}

// Computes M' K M.
static PetscErrorCode project_boundary(Levels *levels, MatReuse reuse) {
  PetscCall(MatTransposeMatMult(levels->change, levels->forces, reuse, PETSC_DEFAULT, &levels->mixed));
  PetscCall(MatTranspose(levels->mixed, reuse, &levels->transposed));
  PetscCall(MatPtAP(levels->stiffness, levels->change, reuse, PETSC_DEFAULT, &levels->own));
  if (reuse == MAT_INITIAL_MATRIX) {
    // Nothing is held yet, so these products are zero, and only their patterns are added.
    PetscCall(MatAXPY(levels->all_free, 1.0, levels->mixed, DIFFERENT_NONZERO_PATTERN));
    PetscCall(MatAXPY(levels->all_free, 1.0, levels->transposed, DIFFERENT_NONZERO_PATTERN));
    PetscCall(MatAXPY(levels->all_free, 1.0, levels->own, DIFFERENT_NONZERO_PATTERN));
    PetscCall(MatDuplicate(levels->all_free, MAT_COPY_VALUES, &levels->coarse));
  }
  PetscCall(MatCopy(levels->all_free, levels->coarse, SAME_NONZERO_PATTERN));
  PetscCall(MatAXPY(levels->coarse, -1.0, levels->mixed, SUBSET_NONZERO_PATTERN));
  PetscCall(MatAXPY(levels->coarse, -1.0, levels->transposed, SUBSET_NONZERO_PATTERN));
  PetscCall(MatAXPY(levels->coarse, 1.0, levels->own, SUBSET_NONZERO_PATTERN));
  return 0;
}

// Adds springs to M' K M, and to the diagonal.
static PetscErrorCode add_springs(Levels *levels, Mat springs) {
  const IS boundary = levels->boundary;
  const MatReuse reuse = levels->springs ? MAT_REUSE_MATRIX : MAT_INITIAL_MATRIX;
  Vec values;

  PetscCall(MatCreateVecs(springs, &values, NULL));
  PetscCall(MatGetDiagonal(springs, values));
  PetscCall(VecAXPY(levels->diagonal, 1.0, values));
  PetscCall(VecDestroy(&values));
  if (!levels->coarse) return 0;
  PetscCall(MatCreateSubMatrix(springs, boundary, boundary, reuse, &levels->springs));
  PetscCall(MatPtAP(levels->springs, levels->moved, reuse, PETSC_DEFAULT, &levels->sprung));
  PetscCall(MatAXPY(levels->coarse, 1.0, levels->sprung, SUBSET_NONZERO_PATTERN));
  return 0;
}

// Sets the matrix of a level, from which its smoother is made, too.
static PetscErrorCode set_matrix(PC pc, PetscInt i_level, Mat matrix) {
  KSP smoother;

  PetscCall(PCMGGetSmoother(pc, i_level, &smoother));
  PetscCall(KSPSetOperators(smoother, matrix, matrix));
  if (i_level > 0) PetscCall(PCMGSetResidual(pc, i_level, PCMGResidualDefault, matrix));
  return 0;
}

// Sets the matrix of the first coarse level, and computes those of the levels below. Except for the first time, these
// have matrices of the same pattern, which get the new values.
static PetscErrorCode project_further(PC pc, PetscInt i_first, Mat matrix, MatReuse reuse) {
  PetscCall(set_matrix(pc, i_first, matrix));
  for (PetscInt i = i_first - 1; i >= 0; i--) {
    Mat interpolation, coarse;
    KSP smoother;
    PetscCall(PCMGGetInterpolation(pc, i + 1, &interpolation));
    PetscCall(PCMGGetSmoother(pc, i, &smoother));
    PetscCall(KSPGetOperators(smoother, NULL, &coarse));
    PetscCall(MatPtAP(matrix, interpolation, reuse, PETSC_DEFAULT, &coarse));
    PetscCall(set_matrix(pc, i, coarse));
    // The smoother keeps a reference to the matrix.
    if (reuse == MAT_INITIAL_MATRIX) PetscCall(PetscObjectDereference((PetscObject)coarse));
    matrix = coarse;
  }
  return 0;
}

// Makes the levels of a PC with at least two keep their interpolations.
static PetscErrorCode take_levels(Levels *levels, PC pc, PetscInt n_levels, Mat stiffness, Mat inverse, Mat operator) {
  Mat interpolation, rows;
  Vec nothing_held;
  KSP coarse;

  PetscCall(PCMGGetSmoother(pc, n_levels - 2, &coarse));
  PetscCall(KSPGetOperators(coarse, NULL, &levels->all_free));
  PetscCall(PetscObjectReference((PetscObject)levels->all_free));
  // otherwise it would keep K
  PetscCall(MatProductClear(levels->all_free));
  PetscCall(PCMGGetInterpolation(pc, n_levels - 1, &interpolation));
  PetscCall(MatCreateSubMatrix(interpolation, levels->boundary, NULL, MAT_INITIAL_MATRIX, &levels->fixed));
  PetscCall(MatCreateSubMatrix(stiffness, levels->boundary, NULL, MAT_INITIAL_MATRIX, &rows));
  PetscCall(MatMatMult(rows, interpolation, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &levels->forces));
  PetscCall(MatProductClear(levels->forces));
  PetscCall(MatDestroy(&rows));
  PetscCall(MatMatMult(inverse, interpolation, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &levels->interpolation));
  PetscCall(MatProductClear(levels->interpolation));
  PetscCall(PCMGSetInterpolation(pc, n_levels - 1, levels->interpolation));
  PetscCall(PCMGSetRestriction(pc, n_levels - 1, levels->interpolation));
  // Otherwise GAMG would compute the coarse matrices itself.
  PetscCall(PCSetReusePreconditioner(pc, PETSC_TRUE));
  PetscCall(MatCreateVecs(levels->stiffness, &nothing_held, NULL));
  PetscCall(VecSet(nothing_held, 0.0));
  PetscCall(change_motions(levels, nothing_held, MAT_INITIAL_MATRIX));
  PetscCall(VecDestroy(&nothing_held));
  PetscCall(project_boundary(levels, MAT_INITIAL_MATRIX));
  PetscCall(project_further(pc, n_levels - 2, levels->coarse, MAT_INITIAL_MATRIX));
  PetscCall(set_matrix(pc, n_levels - 1, operator));
  return 0;
}

PetscErrorCode sig_contact_levels_create(KSP ksp, Mat transformation, Mat inverse, Vec mark) {
  PC pc;
  Mat stiffness, copy, operator;
  PetscBool has_levels;
  PetscInt n_levels;
  Levels *levels;

  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(KSPGetOperators(ksp, &copy, &stiffness));
  PetscCall(PetscNew(&levels));
  PetscCall(keep_levels(ksp, levels));
  PetscCall(find_boundary(transformation, mark, &levels->boundary));
  PetscCall(MatCreateSubMatrix(stiffness, levels->boundary, levels->boundary, MAT_INITIAL_MATRIX, &levels->stiffness));
  PetscCall(MatCreateVecs(stiffness, &levels->diagonal, NULL));
  PetscCall(MatGetDiagonal(stiffness, levels->diagonal));
  PetscCall(take_transformation(levels, transformation, inverse, MAT_INITIAL_MATRIX));
  PetscCall(sig_held_operator_create(copy, &operator));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &has_levels, PCGAMG, PCMG, ""));
  if (has_levels) {
    PetscCall(PCMGGetLevels(pc, &n_levels));
    if (n_levels > 1) PetscCall(take_levels(levels, pc, n_levels, stiffness, inverse, operator));
    // some dozen unknowns
    if (n_levels <= 1) PetscCall(PCSetType(pc, PCJACOBI));
  }
  PetscCall(KSPSetOperators(ksp, operator, operator));
  PetscCall(MatDestroy(&operator));
  return 0;
}

// Computes S F and M' K M.
static PetscErrorCode hold_coarse(Levels *levels, Vec is_free) {
  Vec part, held_part;

  PetscCall(VecGetSubVector(is_free, levels->boundary, &part));
  PetscCall(VecDuplicate(part, &held_part));
  PetscCall(VecSet(held_part, 1.0));
  PetscCall(VecAXPY(held_part, -1.0, part));
  PetscCall(VecScale(held_part, 1.0 - HELD_SHARE));
  PetscCall(VecRestoreSubVector(is_free, levels->boundary, &part));
  PetscCall(change_motions(levels, held_part, MAT_REUSE_MATRIX));
  PetscCall(VecDestroy(&held_part));
  PetscCall(set_boundary_rows(levels));
  PetscCall(project_boundary(levels, MAT_REUSE_MATRIX));
  return 0;
}

PetscErrorCode sig_contact_levels_hold(KSP ksp, Mat transformation, Mat inverse, Vec is_free, Mat springs) {
  PC pc;
  PetscInt n_levels;
  Mat operator;
  Levels *levels;

  PetscCall(get_levels(ksp, &levels));
  PetscCall(take_transformation(levels, transformation, inverse, MAT_REUSE_MATRIX));
  if (levels->coarse) PetscCall(hold_coarse(levels, is_free));
  if (springs) PetscCall(add_springs(levels, springs));
  PetscCall(KSPGetOperators(ksp, NULL, &operator));
  PetscCall(sig_held_operator_couple(operator, springs, NULL));
  PetscCall(sig_held_operator_hold(operator, transformation, levels->diagonal, is_free));
  if (!levels->coarse) return 0;
  // The largest eigenvalue of a level hardly depends on what is held: bounds for K serve all sets, until a solution
  // fails with them.
  if (!levels->is_kept) PetscCall(sig_smoother_bounds_keep(ksp, &levels->is_kept));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCMGGetLevels(pc, &n_levels));
  PetscCall(project_further(pc, n_levels - 2, levels->coarse, MAT_REUSE_MATRIX));
  // so that the smoother takes the new diagonal
  PetscCall(set_matrix(pc, n_levels - 1, operator));
  return 0;
}

PetscErrorCode sig_contact_levels_estimate(KSP ksp, PetscBool *has_new) {
  Levels *levels;

  *has_new = PETSC_FALSE;
  PetscCall(get_levels(ksp, &levels));
  if (!levels || !levels->is_kept) return 0;
  PetscCall(sig_smoother_bounds_estimate(ksp));
  levels->is_kept = PETSC_FALSE;
  *has_new = PETSC_TRUE;
  return 0;
}
