// SPDX-License-Identifier: BSD-3-Clause
// Cholesky factorization of a stiffness by MUMPS, as the preconditioner of a KSP.
#include "factorization.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "signorom/linear_solver.h"
#include "signorom/petsc_support.h"

// Up to this number of unknowns, the ordering is approximate minimum fill: one that gives a smaller factor takes longer
// than it saves.
enum { SMALL = 20000 };
static const char MINIMUM_FILL[] = "2";
// Tightest relative tolerance if the preconditioner is a factorization: the solution is as good as by a new
// factorization.
static const double TIGHTEST_WITH_FACTOR = 1e-14;
// Number of operations of a solve for each entry of the factor, and the speed of a factorization (operations per
// second) over that of a solve, which is limited by the memory.
static const double OPERATIONS_PER_ENTRY = 4.0, FACTORIZATION_SPEED = 5.0;

PetscErrorCode sig_is_factored(KSP ksp, PetscBool *answer) {
  PC pc;

  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, answer, PCCHOLESKY, PCLU, ""));
  return 0;
}

static PetscErrorCode prepare_cholesky(KSP ksp, Mat matrix, int workspace) {
  PC pc;
  Mat factor;

  PetscCall(KSPReset(ksp));
  PetscCall(KSPSetOperators(ksp, matrix, matrix));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCCHOLESKY));
  PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  PetscCall(KSPSetFromOptions(ksp));
  PetscCall(PCFactorSetUpMatSolverType(pc));
  PetscCall(PCFactorGetMatrix(pc, &factor));
  PetscCall(MatMumpsSetIcntl(factor, 14, workspace));
  PetscCall(MatMumpsSetIcntl(factor, 24, SIG_MUMPS_FINDS_NULL_PIVOTS));
  PetscCall(MatMumpsSetCntl(factor, 3, SIG_MUMPS_NULL_PIVOT));
  return 0;
}

// KSPSetUp with an ordering that suits the size. The ordering is set by an option, because PETSc 3.18 on one rank
// ignores the ordering of MatMumpsSetIcntl.
static PetscErrorCode set_up(KSP ksp, Mat matrix) {
  const char *prefix;
  char option[64];
  PetscBool is_given;
  PetscInt n;

  PetscCall(KSPGetOptionsPrefix(ksp, &prefix));
  PetscCall(PetscOptionsHasName(NULL, prefix, "-mat_mumps_icntl_7", &is_given));
  PetscCall(MatGetSize(matrix, &n, NULL));
  if (n > SMALL || is_given) return KSPSetUp(ksp);
  snprintf(option, sizeof option, "-%smat_mumps_icntl_7", prefix);
  PetscCall(PetscOptionsSetValue(NULL, option, MINIMUM_FILL));
  const PetscErrorCode status = KSPSetUp(ksp);
  PetscCall(PetscOptionsClearValue(NULL, option));
  return status;
}

// Gives the result of the factorization: error codes and number of null pivots of MUMPS. Of another package, which
// options may choose, it gives only whether the factorization succeeded.
static PetscErrorCode examine(PC pc, PetscInt infog[2], PetscInt *null_pivots) {
  Mat factor;
  MatSolverType type;

  PetscCall(PCFactorGetMatrix(pc, &factor));
  PetscCall(MatFactorGetSolverType(factor, &type));
  if (strcmp(type, MATSOLVERMUMPS) == 0) {
    PetscCall(MatMumpsGetInfog(factor, 1, &infog[0]));
    PetscCall(MatMumpsGetInfog(factor, 2, &infog[1]));
    PetscCall(MatMumpsGetInfog(factor, 28, null_pivots));
  } else {
    MatFactorError error;
    PetscCall(MatFactorGetError(factor, &error));
    infog[0] = error == MAT_FACTOR_NOERROR ? 0 : -10;
    *null_pivots = 0;
  }
  return 0;
}

// These codes of MUMPS: the workspace is too small even at its largest, or an allocation failed.
static bool is_out_of_memory(PetscInt code) { return code == -8 || code == -9 || code == -13; }

void sig_tell_mumps_failure(int code, int detail, char *message) {
  snprintf(message, SIG_MESSAGE_SIZE, "the factorization failed%s: INFOG(1) = %d, INFOG(2) = %d in the codes of MUMPS",
           is_out_of_memory(code) ? " for lack of memory (solver.linear: gamg needs less)" : "", code, detail);
}

PetscErrorCode sig_factor(KSP ksp, Mat matrix, int *reason, char *message) {
  PC pc;
  PetscInt infog[2] = {-9, 0}, null_pivots = 0;

  for (int workspace = FIRST_WORKSPACE; (infog[0] == -8 || infog[0] == -9) && workspace < LARGEST_WORKSPACE;
       workspace *= 2) {
    PetscCall(prepare_cholesky(ksp, matrix, workspace));
    PetscCall(set_up(ksp, matrix));
    PetscCall(KSPGetPC(ksp, &pc));
    PetscCall(examine(pc, infog, &null_pivots));
  }
  *reason = infog[0] < 0 ? SIG_LINEAR_FAILED : null_pivots > 0 ? SIG_LINEAR_SINGULAR : SIG_LINEAR_DONE;
  if (infog[0] < 0) sig_tell_mumps_failure((int)infog[0], (int)infog[1], message);
  return 0;
}

// MUMPS keeps its ordering and factors the new numbers only. If this fails, for example because the memory does not
// suffice, it begins again as for a first matrix.
PetscErrorCode sig_factor_again(KSP ksp, Mat matrix, int *reason, char *message) {
  PC pc;
  PetscInt infog[2] = {0, 0}, null_pivots = 0;

  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetReusePreconditioner(pc, PETSC_FALSE));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPSetOperators(ksp, matrix, matrix));
  PetscCall(KSPSetUp(ksp));
  PetscCall(examine(pc, infog, &null_pivots));
  *reason = null_pivots > 0 ? SIG_LINEAR_SINGULAR : SIG_LINEAR_DONE;
  if (infog[0] < 0) PetscCall(sig_factor(ksp, matrix, reason, message));
  return 0;
}

int sig_linear_solver_solves_per_factorization(intptr_t handle, int *n_solves) {
  PC pc;
  Mat factor;
  MatSolverType type;
  PetscBool has_factor;
  PetscReal operations;
  PetscInt entries_or_millions;

  *n_solves = 0;
  PetscCall(sig_is_factored((KSP)handle, &has_factor));
  if (!has_factor) return 0;
  PetscCall(KSPGetPC((KSP)handle, &pc));
  PetscCall(PCFactorGetMatrix(pc, &factor));
  PetscCall(MatFactorGetSolverType(factor, &type));
  if (strcmp(type, MATSOLVERMUMPS) != 0) return 0;
  PetscCall(MatMumpsGetRinfog(factor, 3, &operations));
  PetscCall(MatMumpsGetInfog(factor, 29, &entries_or_millions));
  const double entries = entries_or_millions < 0 ? -1e6 * entries_or_millions : (double)entries_or_millions;
  *n_solves = (int)PetscMin(operations / (OPERATIONS_PER_ENTRY * FACTORIZATION_SPEED * entries), MAX_CG_ITERATIONS);
  return 0;
}

int sig_linear_solver_keep_factor(intptr_t handle, int max_iterations) {
  KSP ksp = (KSP)handle;
  PC pc;

  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetReusePreconditioner(pc, PETSC_TRUE));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPSetNormType(ksp, KSP_NORM_NATURAL));
  PetscCall(KSPSetTolerances(ksp, TIGHTEST_WITH_FACTOR, 0.0, 1e15, max_iterations));
  PetscCall(KSPSetInitialGuessNonzero(ksp, PETSC_TRUE));
  return 0;
}
