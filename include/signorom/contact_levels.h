/* SPDX-License-Identifier: BSD-3-Clause */
/* Multigrid for T' K T where some unknowns are held, on the levels that GAMG built for K, the stiffness of the bodies
 * without contact. For C only. */
#ifndef SIGNOROM_CONTACT_LEVELS_H
#define SIGNOROM_CONTACT_LEVELS_H
#include <petscksp.h>

/* Makes a KSP with the levels of a GAMG for K solve with T' K T. T = `transformation` is kept as a reference;
 * `inverse`, the inverse of T, is only read. `mark` has 1 for each unknown that may be held though T leaves it as it
 * is, and 0 for all others; it changes. All unknowns are free until sig_contact_levels_hold. Where options chose
 * another preconditioner, the operator changes alone. Collective. */
PetscErrorCode sig_contact_levels_create(KSP ksp, Mat transformation, Mat inverse, Vec mark);

/* Holds the unknowns for which `is_free` is 0, and computes the matrices of the levels; it is 1 for all others.
 * Collective. */
PetscErrorCode sig_contact_levels_hold(KSP ksp, Vec is_free);
#endif
