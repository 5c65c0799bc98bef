// SPDX-License-Identifier: BSD-3-Clause
// The bounds on eigenvalues between which Chebyshev's smoother works, on each level of multigrid. PETSc estimates the
// largest eigenvalue by ten steps of a Krylov method whenever the matrix of a level changes.
#ifndef SIGNOROM_SMOOTHER_BOUNDS_H
#define SIGNOROM_SMOOTHER_BOUNDS_H

#include <petscksp.h>

// Sets the margins of the estimates as an option, which levels read when they are made. is_set: PETSC_FALSE if the user
// has set it; sig_smoother_bounds_drop_margins takes the option away where it is PETSC_TRUE.
PetscErrorCode sig_smoother_bounds_set_margins(KSP ksp, PetscBool *is_set);
PetscErrorCode sig_smoother_bounds_drop_margins(KSP ksp, PetscBool is_set);

// Makes the smoothers keep the bounds that they have, whatever their matrices become, until
// sig_smoother_bounds_estimate. is_kept: PETSC_FALSE where the user chose margins or bounds; then nothing changes.
PetscErrorCode sig_smoother_bounds_keep(KSP ksp, PetscBool *is_kept);

// Makes smoothers that kept their bounds estimate them for the matrices that they have now.
PetscErrorCode sig_smoother_bounds_estimate(KSP ksp);

#endif
