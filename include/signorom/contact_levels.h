/* SPDX-License-Identifier: BSD-3-Clause */
/* Multigrid for T' K T where some unknowns are held, on the levels that GAMG built for K, the stiffness of the bodies
 * without contact. For C only. */
#ifndef SIGNOROM_CONTACT_LEVELS_H
#define SIGNOROM_CONTACT_LEVELS_H
#include <petscksp.h>

/* Makes a KSP with multigrid levels for K solve with T' K T; sig_contact_levels_hold must follow. `transformation`
 * and `inverse` give the patterns of T and its inverse. `mark` has 1 for each unknown that may be held though no T
 * changes it, and 0 for all others; it changes. Where options chose another preconditioner, it must do without entries
 * of the matrix. Collective. */
PetscErrorCode sig_contact_levels_create(KSP ksp, Mat transformation, Mat inverse, Vec mark);

/* Sets T, which is kept as a reference, and holds the unknowns for which `is_free` is 0; it is 1 for all others.
 * `inverse`, that of T, is only read. `springs` act between unknowns that T changes, at nodes of one contact; they are
 * kept as a reference, always with the same pattern, and NULL is none. Collective. */
PetscErrorCode sig_contact_levels_hold(KSP ksp, Mat transformation, Mat inverse, Vec is_free, Mat springs);

/* Makes the smoothers estimate the bounds on their eigenvalues for the unknowns held now. has_new: whether they had
 * kept those of an earlier set; otherwise nothing changes. Collective. */
PetscErrorCode sig_contact_levels_estimate(KSP ksp, PetscBool *has_new);
#endif
