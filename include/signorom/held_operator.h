/* SPDX-License-Identifier: BSD-3-Clause */
/* The operator T' K T where some unknowns are held, as products with K and T: with I the unknowns that are free and d
 * the diagonal of T' K T, y = I T' K T I x + (1 - I) d x. No entry of T' K T is computed but its diagonal. For C only.
 */
#ifndef SIGNOROM_HELD_OPERATOR_H
#define SIGNOROM_HELD_OPERATOR_H
#include <petscmat.h>

/* Makes the operator, which keeps references to K = `stiffness` and T = `transformation`; d = `diagonal` is copied. All
 * unknowns are free. The caller destroys the operator. Collective. */
PetscErrorCode sig_held_operator_create(Mat stiffness, Mat transformation, Vec diagonal, Mat *held);

/* Holds the unknowns for which `is_free` is 0; it is 1 for all others. */
PetscErrorCode sig_held_operator_hold(Mat held, Vec is_free);
#endif
