// SPDX-License-Identifier: BSD-3-Clause
// Options of PETSc that this program sets for a while, where the user has not.
#ifndef SIGNOROM_OPTION_DEFAULTS_H
#define SIGNOROM_OPTION_DEFAULTS_H

#include <petscsys.h>

// Sets an option until sig_drop_default, unless the user has set it.
PetscErrorCode sig_set_default(const char *name, const char *value, PetscBool *is_set);
PetscErrorCode sig_drop_default(const char *name, PetscBool is_set);

#endif
