// SPDX-License-Identifier: BSD-3-Clause
#include "smoother_bounds.h"

#include "option_defaults.h"

// Shares of the estimated largest eigenvalue. On stretched quadratic tetrahedra, PETSc's estimate (ten steps) is too
// small. Above the upper bound the smoother magnifies modes, and the preconditioner is no longer positive definite. So
// the upper share is 1.3; PETSc's own one is 1.1.
static const PetscReal LOWER = 0.1, UPPER = 1.3;

static PetscErrorCode name_of_margins(KSP ksp, size_t size, char *name) {
  const char *prefix;

  PetscCall(KSPGetOptionsPrefix(ksp, &prefix));
  PetscCall(PetscSNPrintf(name, size, "-%smg_levels_ksp_chebyshev_esteig", prefix ? prefix : ""));
  return 0;
}

PetscErrorCode sig_smoother_bounds_set_margins(KSP ksp, PetscBool *is_set) {
  char name[256], value[64];

  PetscCall(name_of_margins(ksp, sizeof name, name));
  PetscCall(PetscSNPrintf(value, sizeof value, "0,%g,0,%g", (double)LOWER, (double)UPPER));
  PetscCall(sig_set_default(name, value, is_set));
  return 0;
}

PetscErrorCode sig_smoother_bounds_drop_margins(KSP ksp, PetscBool is_set) {
  char name[256];

  PetscCall(name_of_margins(ksp, sizeof name, name));
  PetscCall(sig_drop_default(name, is_set));
  return 0;
}

// Gives the largest eigenvalue that a Krylov method has found; 0 before its first solve.
static PetscErrorCode largest_eigenvalue(KSP estimator, PetscReal *largest) {
  PetscInt n, n_found = 0;
  PetscReal *real, *imaginary;

  *largest = 0.0;
  PetscCall(KSPGetIterationNumber(estimator, &n));
  PetscCall(PetscMalloc2(n, &real, n, &imaginary));
  if (n > 0) PetscCall(KSPComputeEigenvalues(estimator, n, real, imaginary, &n_found));
  for (PetscInt i = 0; i < n_found; i++) *largest = PetscMax(*largest, real[i]);
  PetscCall(PetscFree2(real, imaginary));
  return 0;
}

static PetscErrorCode keep_bounds(KSP smoother, PetscBool *is_kept) {
  PetscBool is_chebyshev;
  KSP estimator;
  PetscReal largest;

  PetscCall(PetscObjectTypeCompare((PetscObject)smoother, KSPCHEBYSHEV, &is_chebyshev));
  if (!is_chebyshev) return 0;
  PetscCall(KSPChebyshevEstEigGetKSP(smoother, &estimator));
  if (!estimator) return 0;
  PetscCall(largest_eigenvalue(estimator, &largest));
  if (largest <= 0.0) return 0;
  PetscCall(KSPChebyshevSetEigenvalues(smoother, UPPER * largest, LOWER * largest));
  *is_kept = PETSC_TRUE;
  return 0;
}

// Gives the number of levels, 0 without any, and their preconditioner.
static PetscErrorCode get_levels(KSP ksp, PC *pc, PetscInt *n) {
  PetscBool has_levels;

  *n = 0;
  PetscCall(KSPGetPC(ksp, pc));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)*pc, &has_levels, PCGAMG, PCMG, ""));
  if (has_levels) PetscCall(PCMGGetLevels(*pc, n));
  return 0;
}

PetscErrorCode sig_smoother_bounds_keep(KSP ksp, PetscBool *is_kept) {
  char name[256];
  PetscBool is_given;
  PetscInt n;
  PC pc;
  KSP smoother;

  *is_kept = PETSC_FALSE;
  PetscCall(name_of_margins(ksp, sizeof name, name));
  PetscCall(PetscOptionsHasName(NULL, NULL, name, &is_given));
  if (is_given) return 0;
  PetscCall(get_levels(ksp, &pc, &n));
  for (PetscInt i = 1; i < n; i++) {
    PetscCall(PCMGGetSmoother(pc, i, &smoother));
    PetscCall(keep_bounds(smoother, is_kept));
  }
  return 0;
}

// A smoother that has bounds ignores new estimates, and only a new one has none.
static PetscErrorCode estimate_bounds(KSP smoother) {
  PetscBool is_chebyshev;

  PetscCall(PetscObjectTypeCompare((PetscObject)smoother, KSPCHEBYSHEV, &is_chebyshev));
  if (!is_chebyshev) return 0;
  PetscCall(KSPSetType(smoother, KSPRICHARDSON));
  PetscCall(KSPSetType(smoother, KSPCHEBYSHEV));
  PetscCall(KSPChebyshevEstEigSet(smoother, 0.0, LOWER, 0.0, UPPER));
  return 0;
}

PetscErrorCode sig_smoother_bounds_estimate(KSP ksp) {
  PetscInt n;
  PC pc;
  KSP smoother;

  PetscCall(get_levels(ksp, &pc, &n));
  for (PetscInt i = 1; i < n; i++) {
    PetscCall(PCMGGetSmoother(pc, i, &smoother));
    PetscCall(estimate_bounds(smoother));
  }
  return 0;
}
