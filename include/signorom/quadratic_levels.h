/* SPDX-License-Identifier: BSD-3-Clause */
/* Multigrid for quadratic elements: the first coarse level are the linear elements with the same corners, the levels
 * below it are those that GAMG builds for them. */
#ifndef SIGNOROM_QUADRATIC_LEVELS_H
#define SIGNOROM_QUADRATIC_LEVELS_H
#include <petscksp.h>
#include <stdint.h>

/* Gives a matrix, whose rows are nodes with n_dim dofs each, the interpolation from the corners of the elements: local
 * node i moves by the mean of the corners corners_0[offsets[i] .. offsets[i + 1] - 1]. Corners are numbered from 0 over
 * all ranks, those of a rank in one block; this rank owns n_nodes nodes and n_corners corners. A corner has itself
 * alone. Collective. Returns a PETSc error code. */
int sig_set_linear_interpolant(intptr_t matrix, int n_dim, int n_nodes, int n_corners, const int *offsets,
                               const int *corners_0);

/* Replaces the levels of a GAMG that is not set up, for a matrix with such an interpolation; does nothing for another
 * matrix. prepare makes a GAMG for the linear elements ready: type, options and set-up of the KSP. For C only. */
PetscErrorCode sig_quadratic_levels_create(KSP ksp, Mat matrix, PetscErrorCode (*prepare)(KSP, Mat));
#endif
