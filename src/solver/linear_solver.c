// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/linear_solver.h"

#include <petscksp.h>
#include <string.h>

// Room that MUMPS gets over its own estimate, in percent; doubled on each workspace failure.
enum { FIRST_WORKSPACE = 60, LARGEST_WORKSPACE = 1000 };
// Right-hand sides per call of MatMatSolve: more only costs memory.
enum { CHUNK = 64 };

static PetscErrorCode prepare(KSP ksp, Mat matrix, int workspace) {
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
  // Without null-pivot detection MUMPS answers a singular matrix with numbers of size 1e10 and no error.
  PetscCall(MatMumpsSetIcntl(factor, 24, 1));
  PetscCall(MatMumpsSetCntl(factor, 3, 1e-10));
  return 0;
}

// What the factorization says: MUMPS's own code and null pivots; of other packages, which the options may choose,
// whether it worked.
static PetscErrorCode examine(PC pc, PetscInt *infog1, PetscInt *null_pivots) {
  Mat factor;
  MatSolverType type;

  PetscCall(PCFactorGetMatrix(pc, &factor));
  PetscCall(MatFactorGetSolverType(factor, &type));
  if (strcmp(type, MATSOLVERMUMPS) == 0) {
    PetscCall(MatMumpsGetInfog(factor, 1, infog1));
    PetscCall(MatMumpsGetInfog(factor, 28, null_pivots));
  } else {
    MatFactorError error;
    PetscCall(MatFactorGetError(factor, &error));
    *infog1 = error == MAT_FACTOR_NOERROR ? 0 : -10;
    *null_pivots = 0;
  }
  return 0;
}

int sig_linear_solver_factor(intptr_t matrix, const char *prefix, intptr_t *handle, int *reason, int *detail) {
  KSP ksp;
  PC pc;
  PetscInt infog1 = -9, null_pivots = 0;

  PetscCall(KSPCreate(PetscObjectComm((PetscObject)(Mat)matrix), &ksp));
  PetscCall(KSPSetOptionsPrefix(ksp, prefix));
  for (int workspace = FIRST_WORKSPACE; (infog1 == -8 || infog1 == -9) && workspace < LARGEST_WORKSPACE;
       workspace *= 2) {
    PetscCall(prepare(ksp, (Mat)matrix, workspace));
    PetscCall(KSPSetUp(ksp));
    PetscCall(KSPGetPC(ksp, &pc));
    PetscCall(examine(pc, &infog1, &null_pivots));
  }
  *reason = infog1 < 0 ? SIG_FACTOR_FAILED : null_pivots > 0 ? SIG_FACTOR_SINGULAR : SIG_FACTOR_DONE;
  *detail = infog1 < 0 ? (int)infog1 : (int)null_pivots;
  *handle = (intptr_t)ksp;
  return 0;
}

int sig_linear_solver_solve_many(intptr_t ksp, int n_columns, int n_local, const double *rhs, double *solution) {
  MPI_Comm comm = PetscObjectComm((PetscObject)(KSP)ksp);
  PC pc;
  Mat factor;

  PetscCall(KSPGetPC((KSP)ksp, &pc));
  PetscCall(PCFactorGetMatrix(pc, &factor));
  for (int first = 0; first < n_columns; first += CHUNK) {
    int n = n_columns - first < CHUNK ? n_columns - first : CHUNK;
    size_t offset = (size_t)first * (size_t)n_local;
    Mat b, x;
    // MatCreateDense has no const; the right-hand side is only read.
    PetscCall(
        MatCreateDense(comm, n_local, PETSC_DECIDE, PETSC_DETERMINE, n, (PetscScalar *)(uintptr_t)(rhs + offset), &b));
    PetscCall(MatCreateDense(comm, n_local, PETSC_DECIDE, PETSC_DETERMINE, n, solution + offset, &x));
    PetscCall(MatMatSolve(factor, b, x));
    PetscCall(MatDestroy(&b));
    PetscCall(MatDestroy(&x));
  }
  return 0;
}

int sig_linear_solver_destroy(intptr_t *handle) {
  KSP ksp = (KSP)*handle;

  PetscCall(KSPDestroy(&ksp));
  *handle = 0;
  return 0;
}
