// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/linear_solver.h"

#include <string.h>

#include "factorization.h"
#include "option_defaults.h"
#include "signorom/contact_levels.h"
#include "signorom/held_operator.h"
#include "signorom/petsc_support.h"
#include "signorom/quadratic_levels.h"
#include "signorom/symmetric_copy.h"
#include "smoother_bounds.h"

// Number of right-hand sides per call of MatMatSolve; a larger number only needs more memory.
enum { CHUNK = 64 };
// Tightest relative tolerance in the energy norm: with it, contact forces agree with those of a factorization to 1e-8.
static const double TIGHTEST = 1e-12;

// The same with a factor as the preconditioner of a coupled solve, and by how much rounding may miss it.
static const double TIGHTEST_COUPLED = 1e-14, NEARLY = 100.0;
// Most iterations of a coupled solve, and how many directions it keeps.
enum { MAX_GMRES_ITERATIONS = 500, GMRES_RESTART = 60 };

// P'AP by way of AP takes half the time of PETSc's default for matrices of one process; those of several ranks have
// other ways, with other names. It is an option, too, that a product reads when it is made.
static const char PRODUCT[] = "-matptap_via", BY_AP[] = "rap";

static PetscErrorCode set_default_product(KSP ksp, PetscBool *is_set) {
  PetscMPIInt n_ranks;

  *is_set = PETSC_FALSE;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)ksp), &n_ranks));
  if (n_ranks == 1) PetscCall(sig_set_default(PRODUCT, BY_AP, is_set));
  return 0;
}

// The levels read their options when they are made.
static PetscErrorCode set_up(KSP ksp) {
  PetscBool has_margins, has_product;

  PetscCall(sig_smoother_bounds_set_margins(ksp, &has_margins));
  PetscCall(set_default_product(ksp, &has_product));
  // the options must not stay where the levels cannot be made
  PetscErrorCode status = KSPSetUp(ksp);
  if (status == 0) status = KSPSetUpOnBlocks(ksp);
  PetscCall(sig_drop_default(PRODUCT, has_product));
  PetscCall(sig_smoother_bounds_drop_margins(ksp, has_margins));
  return status;
}

static PetscErrorCode prepare_gamg(KSP ksp, Mat matrix) {
  PetscReal no_edge = 0.0;
  PetscBool is_gamg;
  Mat copy;
  PC pc;

  PetscCall(sig_symmetric_copy_create(matrix, &copy));
  PetscCall(KSPSetOperators(ksp, copy, matrix));
  PetscCall(MatDestroy(&copy));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPSetNormType(ksp, KSP_NORM_NATURAL));
  PetscCall(KSPSetTolerances(ksp, TIGHTEST, 0.0, 1e15, MAX_CG_ITERATIONS));
  PetscCall(KSPSetInitialGuessNonzero(ksp, PETSC_TRUE));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCGAMG));
  // Edges without stiffness do not count, so that no aggregate has nodes of two bodies.
  PetscCall(PCGAMGSetThreshold(pc, &no_edge, 1));
  // Otherwise the smoothers would keep the eigenvalues of this matrix when contacts close (contact_levels.h).
  PetscCall(PCGAMGSetUseSAEstEig(pc, PETSC_FALSE));
  PetscCall(KSPSetFromOptions(ksp));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCGAMG, &is_gamg));
  PetscCall(PCSetUseAmat(pc, is_gamg));
  if (is_gamg) PetscCall(sig_quadratic_levels_create(ksp, matrix, prepare_gamg));
  PetscCall(set_up(ksp));
  return 0;
}

static PetscErrorCode make_ready(KSP ksp, Mat matrix, int kind, int *reason, char *message) {
  if (kind == SIG_LINEAR_GAMG) {
    PetscCall(prepare_gamg(ksp, matrix));
    *reason = SIG_LINEAR_DONE;
  } else {
    PetscCall(sig_factor(ksp, matrix, reason, message));
  }
  return 0;
}

int sig_linear_solver_create(intptr_t matrix, const char *prefix, int kind, intptr_t *handle, int *reason,
                             char *message) {
  KSP ksp;

  message[0] = '\0';
  PetscCall(KSPCreate(PetscObjectComm((PetscObject)(Mat)matrix), &ksp));
  *handle = (intptr_t)ksp;
  PetscCall(KSPSetOptionsPrefix(ksp, prefix));
  sig_quiet_errors(message);
  PetscErrorCode status = make_ready(ksp, (Mat)matrix, kind, reason, message);
  sig_loud_errors();
  if (status != 0) *reason = SIG_LINEAR_FAILED;
  return 0;
}

static void end_levels(PetscErrorCode status, int *reason) {
  sig_loud_errors();
  *reason = status == 0 ? SIG_LINEAR_DONE : SIG_LINEAR_FAILED;
}

static PetscErrorCode create_levels(KSP ksp, Mat transformation, Mat inverse, Vec mark) {
  PetscBool has_product;

  PetscCall(set_default_product(ksp, &has_product));
  const PetscErrorCode status = sig_contact_levels_create(ksp, transformation, inverse, mark);
  PetscCall(sig_drop_default(PRODUCT, has_product));
  return status;
}

int sig_linear_solver_change_unknowns(intptr_t handle, intptr_t transformation, intptr_t inverse, intptr_t mark,
                                      int *reason, char *message) {
  message[0] = '\0';
  sig_quiet_errors(message);
  end_levels(create_levels((KSP)handle, (Mat)transformation, (Mat)inverse, (Vec)mark), reason);
  return 0;
}

int sig_linear_solver_hold(intptr_t handle, intptr_t transformation, intptr_t inverse, intptr_t is_free,
                           intptr_t springs, int *reason, char *message) {
  message[0] = '\0';
  sig_quiet_errors(message);
  end_levels(sig_contact_levels_hold((KSP)handle, (Mat)transformation, (Mat)inverse, (Vec)is_free, (Mat)springs),
             reason);
  return 0;
}

int sig_linear_solver_factor_again(intptr_t handle, int *reason, char *message) {
  KSP ksp = (KSP)handle;
  Mat matrix;

  message[0] = '\0';
  PetscCall(KSPGetOperators(ksp, NULL, &matrix));
  sig_quiet_errors(message);
  PetscErrorCode status = sig_factor_again(ksp, matrix, reason, message);
  sig_loud_errors();
  if (status != 0) *reason = SIG_LINEAR_FAILED;
  return 0;
}

int sig_set_near_null_space(intptr_t matrix, int n_modes, int n_local, const double *modes) {
  MPI_Comm comm = PetscObjectComm((PetscObject)(Mat)matrix);
  MatNullSpace space;
  Vec fields[6];

  for (int i = 0; i < n_modes; i++) {
    PetscScalar *values;
    PetscCall(VecCreateMPI(comm, n_local, PETSC_DETERMINE, &fields[i]));
    PetscCall(VecGetArrayWrite(fields[i], &values));
    memcpy(values, modes + (size_t)i * (size_t)n_local, (size_t)n_local * sizeof *values);
    PetscCall(VecRestoreArrayWrite(fields[i], &values));
    for (int sweep = 0; sweep < 2; sweep++) {
      PetscScalar products[6];
      PetscCall(VecMDot(fields[i], i, fields, products));
      for (int j = 0; j < i; j++) products[j] = -products[j];
      PetscCall(VecMAXPY(fields[i], i, products, fields));
      PetscCall(VecNormalize(fields[i], NULL));
    }
  }
  PetscCall(MatNullSpaceCreate(comm, PETSC_FALSE, n_modes, fields, &space));
  PetscCall(MatSetNearNullSpace((Mat)matrix, space));
  PetscCall(MatNullSpaceDestroy(&space));
  for (int i = 0; i < n_modes; i++) PetscCall(VecDestroy(&fields[i]));
  return 0;
}

// Solves, and once more from zero if that fails with bounds of the smoothers that were estimated for other matrices.
static PetscErrorCode try_twice(KSP ksp, Vec rhs, Vec solution) {
  KSPConvergedReason reason;
  PetscBool has_new;

  PetscCall(KSPSolve(ksp, rhs, solution));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  if (reason > 0) return 0;
  PetscCall(sig_contact_levels_estimate(ksp, &has_new));
  if (!has_new) return 0;
  PetscCall(VecSet(solution, 0.0));
  PetscCall(KSPSolve(ksp, rhs, solution));
  return 0;
}

static PetscErrorCode iterate(KSP ksp, Vec rhs, double tolerance, Vec solution, int *n_iterations, int *reason) {
  KSPConvergedReason ksp_reason;
  PetscReal tightest, absolute, divergence;
  PetscInt limit, count;
  PetscErrorCode status;
  char message[SIG_MESSAGE_SIZE];

  PetscCall(KSPGetTolerances(ksp, &tightest, &absolute, &divergence, &limit));
  PetscCall(KSPSetTolerances(ksp, PetscMax(tightest, tolerance), absolute, divergence, limit));
  sig_quiet_errors(message);
  status = try_twice(ksp, rhs, solution);
  sig_loud_errors();
  PetscCall(KSPSetTolerances(ksp, tightest, absolute, divergence, limit));
  PetscCall(KSPGetConvergedReason(ksp, &ksp_reason));
  PetscCall(KSPGetIterationNumber(ksp, &count));
  *n_iterations = (int)count;
  *reason = status == 0 && ksp_reason > 0 ? SIG_LINEAR_DONE : SIG_LINEAR_FAILED;
  return 0;
}

int sig_linear_solver_solve(intptr_t handle, intptr_t rhs, double tolerance, intptr_t solution, int *n_iterations,
                            int *reason) {
  KSP ksp = (KSP)handle;
  PetscBool has_factor, is_preconditioner;

  *n_iterations = 0;
  *reason = SIG_LINEAR_DONE;
  PetscCall(sig_is_factored(ksp, &has_factor));
  PetscCall(PetscObjectTypeCompare((PetscObject)ksp, KSPCG, &is_preconditioner));
  if (has_factor && !is_preconditioner) {
    PC pc;
    PetscCall(KSPGetPC(ksp, &pc));
    PetscCall(PCApply(pc, (Vec)rhs, (Vec)solution));
  } else {
    PetscCall(iterate(ksp, (Vec)rhs, tolerance, (Vec)solution, n_iterations, reason));
  }
  return 0;
}

// Makes the operator of a coupled solve. Without `stiffness` the KSP has multigrid, which has the other parts.
static PetscErrorCode couple(KSP ksp, Mat stiffness, Vec is_free, Mat springs, Mat coupling, Mat *coupled) {
  Mat operator;

  if (stiffness) {
    Vec diagonal;
    PetscCall(sig_held_operator_create(stiffness, coupled));
    PetscCall(sig_held_operator_couple(*coupled, springs, coupling));
    PetscCall(MatCreateVecs(stiffness, &diagonal, NULL));
    PetscCall(MatGetDiagonal(stiffness, diagonal));
    PetscCall(sig_held_operator_hold(*coupled, NULL, diagonal, is_free));
    PetscCall(VecDestroy(&diagonal));
  } else {
    PetscCall(KSPGetOperators(ksp, NULL, &operator));
    PetscCall(sig_held_operator_with_coupling(operator, is_free, springs, coupling, coupled));
  }
  return 0;
}

// Gives the size of M^-1 f, or the energy f' M^-1 f, from which tolerances count.
static PetscErrorCode measure(PC pc, Vec rhs, PetscBool is_energy, PetscReal *size) {
  Vec product;
  PetscScalar energy;

  PetscCall(VecDuplicate(rhs, &product));
  PetscCall(PCApply(pc, rhs, product));
  if (is_energy) {
    PetscCall(VecDot(rhs, product, &energy));
    *size = PetscSqrtReal(PetscAbsScalar(energy));
  } else {
    PetscCall(VecNorm(product, NORM_2, size));
  }
  PetscCall(VecDestroy(&product));
  return 0;
}

static PetscErrorCode iterate_coupled(KSP ksp, PC pc, Vec rhs, double reduction, double tightest, Vec solution,
                                      PetscBool is_symmetric, double *size, int *n_iterations, int *reason) {
  PetscReal rest;
  PetscInt count;
  KSPConvergedReason ksp_reason;

  PetscCall(KSPSetType(ksp, is_symmetric ? KSPCG : KSPGMRES));
  if (is_symmetric) PetscCall(KSPSetNormType(ksp, KSP_NORM_NATURAL));
  if (!is_symmetric) PetscCall(KSPGMRESSetRestart(ksp, GMRES_RESTART));
  PetscCall(KSPSetInitialGuessNonzero(ksp, PETSC_TRUE));
  PetscCall(KSPConvergedDefaultSetUIRNorm(ksp));
  PetscCall(KSPSetUp(ksp));
  if (*size <= 0.0 || reduction <= 0.0) PetscCall(measure(pc, rhs, is_symmetric, size));
  PetscCall(KSPSetTolerances(ksp, reduction, tightest * *size, 1e15, MAX_GMRES_ITERATIONS));
  PetscCall(KSPSolve(ksp, rhs, solution));
  PetscCall(KSPGetConvergedReason(ksp, &ksp_reason));
  PetscCall(KSPGetIterationNumber(ksp, &count));
  PetscCall(KSPGetResidualNorm(ksp, &rest));
  *n_iterations = (int)count;
  // rounding may stop the iteration a little above the tightest tolerance
  *reason = ksp_reason > 0 || rest <= NEARLY * tightest * *size ? SIG_LINEAR_DONE : SIG_LINEAR_FAILED;
  return 0;
}

// Iterates, and once more from zero as try_twice does. `levels`: the KSP of the levels.
static PetscErrorCode iterate_coupled_twice(KSP levels, KSP ksp, Vec rhs, double reduction, double tightest,
                                            Vec solution, PetscBool is_symmetric, double *size, int *n_iterations,
                                            int *reason) {
  PetscBool has_new;
  PC pc;

  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(iterate_coupled(ksp, pc, rhs, reduction, tightest, solution, is_symmetric, size, n_iterations, reason));
  if (*reason == SIG_LINEAR_DONE) return 0;
  PetscCall(sig_contact_levels_estimate(levels, &has_new));
  if (!has_new) return 0;
  PetscCall(VecSet(solution, 0.0));
  PetscCall(iterate_coupled(ksp, pc, rhs, reduction, tightest, solution, is_symmetric, size, n_iterations, reason));
  return 0;
}

int sig_linear_solver_solve_coupled(intptr_t handle, intptr_t stiffness, intptr_t is_free, intptr_t springs,
                                    intptr_t coupling, intptr_t rhs, double reduction, double *size, intptr_t solution,
                                    int *n_iterations, int *reason) {
  KSP ksp = (KSP)handle, outer;
  PC pc;
  Mat amat, pmat, coupled;
  PetscBool reuses;
  char message[SIG_MESSAGE_SIZE];

  *n_iterations = 0;
  PetscCall(couple(ksp, (Mat)stiffness, (Vec)is_free, (Mat)springs, (Mat)coupling, &coupled));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(KSPGetOperators(ksp, &amat, &pmat));
  PetscCall(PetscObjectReference((PetscObject)amat));
  PetscCall(PetscObjectReference((PetscObject)pmat));
  PetscCall(PCGetReusePreconditioner(pc, &reuses));
  PetscCall(PCSetReusePreconditioner(pc, PETSC_TRUE));
  PetscCall(KSPCreate(PetscObjectComm((PetscObject)ksp), &outer));
  PetscCall(KSPSetPC(outer, pc));
  PetscCall(KSPSetOperators(outer, coupled, pmat));
  sig_quiet_errors(message);
  const PetscErrorCode status =
      iterate_coupled_twice(ksp, outer, (Vec)rhs, reduction, stiffness ? TIGHTEST_COUPLED : TIGHTEST, (Vec)solution,
                            coupling ? PETSC_FALSE : PETSC_TRUE, size, n_iterations, reason);
  sig_loud_errors();
  if (status != 0) *reason = SIG_LINEAR_FAILED;
  PetscCall(KSPDestroy(&outer));
  PetscCall(MatDestroy(&coupled));
  PetscCall(KSPSetOperators(ksp, amat, pmat));
  PetscCall(PCSetReusePreconditioner(pc, reuses));
  PetscCall(MatDestroy(&amat));
  PetscCall(MatDestroy(&pmat));
  return 0;
}

// Gives whether the right-hand sides should be passed to MUMPS as a sparse matrix, which saves work: on one rank, if at
// most 1 % of their entries differ from zero, but not none. counts: number of such entries of each column. On several
// ranks MUMPS would need the whole sparse matrix on the first rank, and it refuses a matrix without entries.
static PetscErrorCode takes_sparse(Mat factor, int n_columns, int n_local, const double *rhs, PetscInt *counts,
                                   PetscBool *is_sparse) {
  MatSolverType type;
  PetscMPIInt n_ranks;
  PetscInt n_entries = 0;

  *is_sparse = PETSC_FALSE;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)factor), &n_ranks));
  PetscCall(MatFactorGetSolverType(factor, &type));
  if (n_ranks > 1 || strcmp(type, MATSOLVERMUMPS) != 0) return 0;
  for (int k = 0; k < n_columns; k++) {
    counts[k] = 0;
    for (int i = 0; i < n_local; i++) counts[k] += rhs[(size_t)k * (size_t)n_local + (size_t)i] != 0.0;
    n_entries += counts[k];
  }
  if (n_entries > 0 && (size_t)n_entries <= (size_t)n_columns * (size_t)n_local / 100) *is_sparse = PETSC_TRUE;
  return 0;
}

// Makes the transpose of the columns as a sparse matrix; counts: number of entries of each column.
static PetscErrorCode make_sparse_rows(int n_columns, int n_local, const double *columns, const PetscInt *counts,
                                       Mat *rows) {
  PetscCall(MatCreateSeqAIJ(PETSC_COMM_SELF, n_columns, n_local, 0, counts, rows));
  for (int k = 0; k < n_columns; k++)
    for (int i = 0; i < n_local; i++) {
      const double value = columns[(size_t)k * (size_t)n_local + (size_t)i];
      if (value != 0.0) PetscCall(MatSetValue(*rows, k, i, value, INSERT_VALUES));
    }
  PetscCall(MatAssemblyBegin(*rows, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*rows, MAT_FINAL_ASSEMBLY));
  return 0;
}

static PetscErrorCode solve_chunks(KSP ksp, int n_columns, int n_local, const double *rhs, double *solution) {
  MPI_Comm comm = PetscObjectComm((PetscObject)ksp);
  PC pc;
  Mat factor;

  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCFactorGetMatrix(pc, &factor));
  for (int first = 0; first < n_columns; first += CHUNK) {
    int n = n_columns - first < CHUNK ? n_columns - first : CHUNK;
    size_t offset = (size_t)first * (size_t)n_local;
    Mat b, x;
    PetscInt counts[CHUNK];
    PetscBool is_sparse;
    PetscCall(takes_sparse(factor, n, n_local, rhs + offset, counts, &is_sparse));
    PetscCall(MatCreateDense(comm, n_local, PETSC_DECIDE, PETSC_DETERMINE, n, solution + offset, &x));
    if (is_sparse) {
      PetscCall(make_sparse_rows(n, n_local, rhs + offset, counts, &b));
      PetscCall(MatMatTransposeSolve(factor, b, x));
    } else {
      // MatCreateDense takes no const array, but the right-hand side is only read.
      PetscCall(MatCreateDense(comm, n_local, PETSC_DECIDE, PETSC_DETERMINE, n,
                               (PetscScalar *)(uintptr_t)(rhs + offset), &b));
      PetscCall(MatMatSolve(factor, b, x));
    }
    PetscCall(MatDestroy(&b));
    PetscCall(MatDestroy(&x));
  }
  return 0;
}

int sig_linear_solver_solve_many(intptr_t handle, int n_columns, int n_local, const double *rhs, double *solution,
                                 int *reason) {
  KSP ksp = (KSP)handle;
  MPI_Comm comm = PetscObjectComm((PetscObject)ksp);
  PetscBool has_factor;

  *reason = SIG_LINEAR_DONE;
  PetscCall(sig_is_factored(ksp, &has_factor));
  if (has_factor) return solve_chunks(ksp, n_columns, n_local, rhs, solution);
  for (int i = 0; i < n_columns && *reason == SIG_LINEAR_DONE; i++) {
    size_t offset = (size_t)i * (size_t)n_local;
    Vec b, x;
    int n_iterations;
    PetscCall(VecCreateMPIWithArray(comm, 1, n_local, PETSC_DECIDE, rhs + offset, &b));
    PetscCall(VecCreateMPIWithArray(comm, 1, n_local, PETSC_DECIDE, solution + offset, &x));
    PetscCall(VecSet(x, 0.0));
    PetscCall(iterate(ksp, b, 0.0, x, &n_iterations, reason));
    PetscCall(VecDestroy(&b));
    PetscCall(VecDestroy(&x));
  }
  return 0;
}

int sig_linear_solver_destroy(intptr_t *handle) {
  KSP ksp = (KSP)*handle;

  PetscCall(KSPDestroy(&ksp));
  *handle = 0;
  return 0;
}
