/* SPDX-License-Identifier: BSD-3-Clause */
/* Multigrid for T' K T where some unknowns are held, on the levels that GAMG built for K: bodies without contact. For C
   only. */
#ifndef SIGNOROM_CONTACT_LEVELS_H
#define SIGNOROM_CONTACT_LEVELS_H
#include <petscksp.h>

/* Levels of GAMG, built for K, keep their interpolations for T' K T and let others compute their matrices. K =
   `stiffness` and T = `transformation` are referred to, the inverse of T is only read. Does nothing where options chose
   another preconditioner or where there is one level. */
PetscErrorCode sig_contact_levels_create(KSP ksp, Mat stiffness, Mat transformation, Mat inverse);

/* Matrices of the levels where unknowns are held; the finest one works with those of the KSP. `free_share` has 1 for
   each free unknown and a small number for a held one: what is left of its interpolation. Does nothing where
   sig_contact_levels_create did nothing. */
PetscErrorCode sig_contact_levels_hold(KSP ksp, Vec free_share);
#endif
