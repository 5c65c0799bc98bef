/* SPDX-License-Identifier: BSD-3-Clause */
/* The operator T' K T where some unknowns are held, as products with K and T: with I the unknowns that are free and d
 * the diagonal of T' K T, y = I T' K T I x + (1 - I) d x. No entry of T' K T is computed but its diagonal. For C only.
 */
#ifndef SIGNOROM_HELD_OPERATOR_H
#define SIGNOROM_HELD_OPERATOR_H
#include <petscmat.h>

/* Makes the operator, which keeps a reference to K = `stiffness`; sig_held_operator_hold must follow. The caller
 * destroys it. */
PetscErrorCode sig_held_operator_create(Mat stiffness, Mat *held);

/* Makes it y = I (T' K T + E T' K T + S) I x + (1 - I) d x from now on; S and E are kept as references, and NULL is
 * zero. */
PetscErrorCode sig_held_operator_couple(Mat held, Mat springs, Mat coupling);

/* Sets T, which is kept as a reference and NULL where it is the identity, the diagonal of T' K T + S, and the unknowns
 * that are held: `is_free` has 0 for them and 1 for all others. */
PetscErrorCode sig_held_operator_hold(Mat held, Mat transformation, Vec diagonal, Vec is_free);

/* Makes another operator with the same K, T and d. The caller destroys it. */
PetscErrorCode sig_held_operator_with_coupling(Mat held, Vec is_free, Mat springs, Mat coupling, Mat *coupled);
#endif
