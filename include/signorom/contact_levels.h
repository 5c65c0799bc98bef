/* SPDX-License-Identifier: BSD-3-Clause */
/* Multigrid for T' K T where some unknowns are held, on the levels that GAMG built for K, the stiffness of the bodies
 * without contact. For C only. */
#ifndef SIGNOROM_CONTACT_LEVELS_H
#define SIGNOROM_CONTACT_LEVELS_H
#include <petscksp.h>

/* Makes the levels of GAMG, built for K, keep their interpolations for T' K T; sig_contact_levels_hold computes their
 * matrices. K = `stiffness` and T = `transformation` are kept as references; `inverse`, the inverse of T, is only read.
 * The function does nothing where options chose another preconditioner or where there is one level. */
PetscErrorCode sig_contact_levels_create(KSP ksp, Mat stiffness, Mat transformation, Mat inverse);

/* Computes the matrices of the levels where unknowns are held; the finest level works with the matrices of the KSP.
 * `free_share` has 1 for each free unknown and a small number, the remaining share of its interpolation, for a held
 * one. The function does nothing where sig_contact_levels_create did nothing. */
PetscErrorCode sig_contact_levels_hold(KSP ksp, Vec free_share);
#endif
