// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/contact_levels.h"

#include "signorom/held_operator.h"

// P is the finest interpolation, of GAMG or from linear elements, F = T^-1 P, and S = diag(share), with 1 for a free
// unknown and HELD_SHARE for a held one. The unknowns x = T^-1 u have the interpolation S F, and the first coarse
// matrix is M' K M with M = T S F. Where nothing is held, M = P. So M = P - D with D = T (1 - S) F, which has entries
// only in the rows J of dofs at contacts and supports, and
//
//     M' K M = P' K P - D_J' (K P)_J - (K P)_J' D_J + D_J' K_JJ D_J .
//
// A change of held unknowns costs as much as contacts and supports are large, whatever the size of the bodies.
typedef struct {
  Mat interpolation;          // S F, of the finest level
  Vec shares;                 // S
  IS boundary;                // J
  Mat transformation;         // T_JJ
  Mat free;                   // F_J
  Mat forces;                 // (K P)_J
  Mat stiffness;              // K_JJ
  Mat scaled, change;         // (1 - S)_JJ F_J; D_J
  Mat mixed, transposed, own; // D_J' (K P)_J, its transpose, D_J' K_JJ D_J
  Mat all_free, coarse;       // P' K P, with the pattern of M' K M; M' K M
} Levels;

// With zero, coarse matrices could become singular. A power of two, so that S changes without rounding.
static const double HELD_SHARE = 0x1p-10;
static const char NAME[] = "signorom_contact_levels";

static PetscErrorCode destroy_levels(void *pointer) {
  Levels *levels = pointer;
  Mat *matrices[] = {&levels->interpolation, &levels->transformation, &levels->free,
                     &levels->forces,        &levels->stiffness,      &levels->scaled,
                     &levels->change,        &levels->mixed,          &levels->transposed,
                     &levels->own,           &levels->all_free,       &levels->coarse};

  for (size_t i = 0; i < sizeof matrices / sizeof *matrices; i++) PetscCall(MatDestroy(matrices[i]));
  PetscCall(VecDestroy(&levels->shares));
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

// Lists the dofs that may be held, those that T changes, and those that they depend on. `mark` has 1 for the first
// ones.
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

// Makes the operator T' K T. T differs from the identity in T_JJ alone, so its diagonal that of K but for J.
static PetscErrorCode create_operator(Mat stiffness, Mat copy, Mat transformation, IS boundary, Mat *held) {
  Mat rows, change, product;
  Vec diagonal, part, values;

  PetscCall(MatCreateVecs(stiffness, &diagonal, NULL));
  PetscCall(MatGetDiagonal(stiffness, diagonal));
  PetscCall(MatCreateSubMatrix(stiffness, boundary, boundary, MAT_INITIAL_MATRIX, &rows));
  PetscCall(MatCreateSubMatrix(transformation, boundary, boundary, MAT_INITIAL_MATRIX, &change));
  PetscCall(MatPtAP(rows, change, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &product));
  PetscCall(MatCreateVecs(product, &values, NULL));
  PetscCall(MatGetDiagonal(product, values));
  PetscCall(VecGetSubVector(diagonal, boundary, &part));
  PetscCall(VecCopy(values, part));
  PetscCall(VecRestoreSubVector(diagonal, boundary, &part));
  PetscCall(sig_held_operator_create(copy, transformation, diagonal, held));
  PetscCall(VecDestroy(&values));
  PetscCall(VecDestroy(&diagonal));
  PetscCall(MatDestroy(&product));
  PetscCall(MatDestroy(&change));
  PetscCall(MatDestroy(&rows));
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

// Makes the parts of K, P and F in the rows J.
static PetscErrorCode take_boundary(Levels *levels, Mat stiffness, Mat transformation, Mat interpolation) {
  Mat rows;

  PetscCall(MatCreateSubMatrix(transformation, levels->boundary, levels->boundary, MAT_INITIAL_MATRIX,
                               &levels->transformation));
  PetscCall(MatCreateSubMatrix(levels->interpolation, levels->boundary, NULL, MAT_INITIAL_MATRIX, &levels->free));
  PetscCall(MatCreateSubMatrix(stiffness, levels->boundary, levels->boundary, MAT_INITIAL_MATRIX, &levels->stiffness));
  PetscCall(MatCreateSubMatrix(stiffness, levels->boundary, NULL, MAT_INITIAL_MATRIX, &rows));
  PetscCall(MatMatMult(rows, interpolation, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &levels->forces));
  PetscCall(MatProductClear(levels->forces));
  PetscCall(MatDestroy(&rows));
  PetscCall(MatDuplicate(levels->free, MAT_COPY_VALUES, &levels->scaled));
  return 0;
}

// Computes M' K M from P' K P for the shares of the unknowns.
static PetscErrorCode project_boundary(Levels *levels, MatReuse reuse) {
  Vec part, held;

  PetscCall(VecGetSubVector(levels->shares, levels->boundary, &part));
  PetscCall(VecDuplicate(part, &held));
  PetscCall(VecCopy(part, held));
  PetscCall(VecRestoreSubVector(levels->shares, levels->boundary, &part));
  PetscCall(VecScale(held, -1.0));
  PetscCall(VecShift(held, 1.0));
  PetscCall(MatCopy(levels->free, levels->scaled, SAME_NONZERO_PATTERN));
  PetscCall(MatDiagonalScale(levels->scaled, held, NULL));
  PetscCall(VecDestroy(&held));
  PetscCall(MatMatMult(levels->transformation, levels->scaled, reuse, PETSC_DEFAULT, &levels->change));
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

// Computes the matrices of the levels below the first coarse one. Except for the first time, these levels have matrices
// of the same pattern, which get the new values.
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

// Makes the levels of a PC with at least two keep their interpolations for T' K T.
static PetscErrorCode take_levels(KSP ksp, PC pc, PetscInt n_levels, Mat stiffness, Mat transformation, Mat inverse,
                                  IS boundary) {
  Mat interpolation;
  KSP coarse;
  Levels *levels;

  PetscCall(PetscNew(&levels));
  PetscCall(keep_levels(ksp, levels));
  PetscCall(PetscObjectReference((PetscObject)boundary));
  levels->boundary = boundary;
  PetscCall(MatCreateVecs(stiffness, &levels->shares, NULL));
  PetscCall(VecSet(levels->shares, 1.0));
  PetscCall(PCMGGetSmoother(pc, n_levels - 2, &coarse));
  PetscCall(KSPGetOperators(coarse, NULL, &levels->all_free));
  PetscCall(PetscObjectReference((PetscObject)levels->all_free));
  // otherwise it would keep K
  PetscCall(MatProductClear(levels->all_free));
  PetscCall(PCMGGetInterpolation(pc, n_levels - 1, &interpolation));
  PetscCall(MatMatMult(inverse, interpolation, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &levels->interpolation));
  PetscCall(MatProductClear(levels->interpolation));
  PetscCall(take_boundary(levels, stiffness, transformation, interpolation));
  PetscCall(PCMGSetInterpolation(pc, n_levels - 1, levels->interpolation));
  PetscCall(PCMGSetRestriction(pc, n_levels - 1, levels->interpolation));
  // Otherwise GAMG would compute the coarse matrices itself.
  PetscCall(PCSetReusePreconditioner(pc, PETSC_TRUE));
  PetscCall(project_boundary(levels, MAT_INITIAL_MATRIX));
  PetscCall(project_further(pc, n_levels - 2, levels->coarse, MAT_INITIAL_MATRIX));
  return 0;
}

PetscErrorCode sig_contact_levels_create(KSP ksp, Mat transformation, Mat inverse, Vec mark) {
  PC pc;
  Mat stiffness, copy, held;
  IS boundary;
  KSP smoother;
  PetscBool has_levels;
  PetscInt n_levels;

  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(KSPGetOperators(ksp, &copy, &stiffness));
  PetscCall(find_boundary(transformation, mark, &boundary));
  PetscCall(create_operator(stiffness, copy, transformation, boundary, &held));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &has_levels, PCGAMG, PCMG, ""));
  if (has_levels) {
    PetscCall(PCMGGetLevels(pc, &n_levels));
    if (n_levels > 1) {
      PetscCall(take_levels(ksp, pc, n_levels, stiffness, transformation, inverse, boundary));
      PetscCall(set_matrix(pc, n_levels - 1, held));
      // Its eigenvalues where nothing is held are bounds of those where some unknowns are.
      PetscCall(PCMGGetSmoother(pc, n_levels - 1, &smoother));
      PetscCall(KSPSetUp(smoother));
    } else {
      // some dozen unknowns
      PetscCall(PCSetType(pc, PCJACOBI));
    }
  }
  PetscCall(KSPSetOperators(ksp, held, held));
  PetscCall(MatDestroy(&held));
  PetscCall(ISDestroy(&boundary));
  return 0;
}

// Multiplies the rows of S F that change.
static PetscErrorCode scale_interpolation(Levels *levels, Vec is_free) {
  Vec shares;

  PetscCall(VecDuplicate(is_free, &shares));
  PetscCall(VecCopy(is_free, shares));
  PetscCall(VecScale(shares, 1.0 - HELD_SHARE));
  PetscCall(VecShift(shares, HELD_SHARE));
  PetscCall(VecPointwiseDivide(levels->shares, shares, levels->shares));
  PetscCall(MatDiagonalScale(levels->interpolation, levels->shares, NULL));
  PetscCall(VecCopy(shares, levels->shares));
  PetscCall(VecDestroy(&shares));
  return 0;
}

PetscErrorCode sig_contact_levels_hold(KSP ksp, Vec is_free) {
  PC pc;
  PetscInt n_levels;
  Mat held;
  Levels *levels;

  PetscCall(KSPGetOperators(ksp, &held, NULL));
  PetscCall(sig_held_operator_hold(held, is_free));
  PetscCall(get_levels(ksp, &levels));
  if (!levels) return 0;
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCMGGetLevels(pc, &n_levels));
  PetscCall(scale_interpolation(levels, is_free));
  PetscCall(project_boundary(levels, MAT_REUSE_MATRIX));
  PetscCall(project_further(pc, n_levels - 2, levels->coarse, MAT_REUSE_MATRIX));
  return 0;
}
