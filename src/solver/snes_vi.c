// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/snes_vi.h"

#include <petscsnes.h>

#include "signorom/petsc_support.h"

typedef struct {
  Mat matrix; // scaled
  Vec rhs;    // scaled
} quadratic_t;

static PetscErrorCode residual(SNES snes, Vec x, Vec f, void *context) {
  quadratic_t *problem = context;

  (void)snes;
  PetscCall(MatMult(problem->matrix, x, f));
  PetscCall(VecAXPY(f, -1.0, problem->rhs));
  return 0;
}

// The Jacobian is the scaled matrix, which never changes.
static PetscErrorCode jacobian(SNES snes, Vec x, Mat a, Mat p, void *context) {
  (void)snes;
  (void)x;
  (void)a;
  (void)p;
  (void)context;
  return 0;
}

// search_type: full steps or a backtracking line search. Full steps are Newton steps on the active set and need few
// iterations. A backtracking search reduces the residual in each step. But at the bounds a full step projects the
// unknowns, which raises the residual by orders of magnitude, so that the search takes very small steps (1/100 to
// 1/10000 of a full step on the paper's case b). It is used only
// if max_iterations full steps do not converge, for example because they repeat the same active sets.
static PetscErrorCode set_up(SNES snes, quadratic_t *problem, Vec upper, int is_multigrid, int max_iterations,
                             SNESLineSearchType search_type) {
  KSP ksp;
  PC pc;
  SNESLineSearch search;
  Vec lower, work;

  PetscCall(SNESSetOptionsPrefix(snes, "vi_"));
  PetscCall(SNESSetType(snes, SNESVINEWTONRSLS));
  // Without this vector SNESVISetVariableBounds would ask the DM for one, and there is no DM.
  PetscCall(VecDuplicate(upper, &work));
  PetscCall(SNESSetFunction(snes, work, residual, problem));
  PetscCall(VecDestroy(&work));
  PetscCall(SNESSetJacobian(snes, problem->matrix, problem->matrix, jacobian, problem));
  PetscCall(VecDuplicate(upper, &lower));
  PetscCall(VecSet(lower, PETSC_NINFINITY));
  PetscCall(SNESVISetVariableBounds(snes, lower, upper));
  PetscCall(VecDestroy(&lower));
  // On a fixed active set the problem is quadratic, so the residual falls to rounding errors in the step that finds the
  // set.
  PetscCall(SNESSetTolerances(snes, 1e-11, 0.0, 0.0, max_iterations, PETSC_DEFAULT));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetType(ksp, is_multigrid ? KSPCG : KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, is_multigrid ? PCGAMG : PCCHOLESKY));
  if (is_multigrid)
    PetscCall(KSPSetTolerances(ksp, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  else
    PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  PetscCall(SNESGetLineSearch(snes, &search));
  PetscCall(SNESLineSearchSetType(search, search_type));
  PetscCall(SNESSetFromOptions(snes));
  return 0;
}

static PetscErrorCode run(SNES snes, quadratic_t *problem, Vec upper, int is_multigrid, int max_iterations,
                          SNESLineSearchType search_type, Vec x) {
  PetscCall(set_up(snes, problem, upper, is_multigrid, max_iterations, search_type));
  PetscCall(SNESSolve(snes, NULL, x));
  return 0;
}

static int reason_of(SNESConvergedReason reason) {
  if (reason > 0) return SIG_VI_DONE;
  if (reason == SNES_DIVERGED_MAX_IT) return SIG_VI_MAX_ITERATIONS;
  if (reason == SNES_DIVERGED_LINEAR_SOLVE) return SIG_VI_LINEAR_SOLVER;
  return SIG_VI_LINE_SEARCH;
}

// Solves the problem once, starting at x. An error of a library call counts as a failed linear solve.
static PetscErrorCode attempt(quadratic_t *problem, Vec upper, int is_multigrid, int max_iterations,
                              SNESLineSearchType search_type, Vec x, int *n_iterations, int *reason) {
  SNES snes;
  SNESConvergedReason snes_reason;
  PetscInt iterations;

  PetscCall(SNESCreate(PetscObjectComm((PetscObject)x), &snes));
  char message[SIG_MESSAGE_SIZE];
  sig_quiet_errors(message);
  PetscErrorCode status = run(snes, problem, upper, is_multigrid, max_iterations, search_type, x);
  sig_loud_errors();
  PetscCall(SNESGetConvergedReason(snes, &snes_reason));
  PetscCall(SNESGetIterationNumber(snes, &iterations));
  *n_iterations += (int)iterations;
  *reason = status != 0 ? SIG_VI_LINEAR_SOLVER : reason_of(snes_reason);
  PetscCall(SNESDestroy(&snes));
  return 0;
}

int sig_snes_vi_solve(intptr_t matrix, intptr_t rhs, intptr_t upper, double length_scale, double force_scale,
                      int is_multigrid, int max_iterations, intptr_t solution, int *n_iterations, int *reason) {
  quadratic_t problem;
  Vec start, x = (Vec)solution;

  PetscCall(MatDuplicate((Mat)matrix, MAT_COPY_VALUES, &problem.matrix));
  PetscCall(MatScale(problem.matrix, length_scale / force_scale));
  PetscCall(VecDuplicate((Vec)rhs, &problem.rhs));
  PetscCall(VecCopy((Vec)rhs, problem.rhs));
  PetscCall(VecScale(problem.rhs, 1.0 / force_scale));
  PetscCall(VecScale(x, 1.0 / length_scale));
  PetscCall(VecDuplicate(x, &start));
  PetscCall(VecCopy(x, start));

  *n_iterations = 0;
  PetscCall(attempt(&problem, (Vec)upper, is_multigrid, max_iterations, SNESLINESEARCHBASIC, x, n_iterations, reason));
  if (*reason == SIG_VI_MAX_ITERATIONS) {
    PetscCall(VecCopy(start, x));
    PetscCall(attempt(&problem, (Vec)upper, is_multigrid, max_iterations, SNESLINESEARCHBT, x, n_iterations, reason));
  }
  PetscCall(VecScale(x, length_scale));

  PetscCall(VecDestroy(&start));
  PetscCall(MatDestroy(&problem.matrix));
  PetscCall(VecDestroy(&problem.rhs));
  return 0;
}
