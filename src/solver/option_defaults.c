// SPDX-License-Identifier: BSD-3-Clause
#include "option_defaults.h"

PetscErrorCode sig_set_default(const char *name, const char *value, PetscBool *is_set) {
  PetscBool is_given;

  PetscCall(PetscOptionsHasName(NULL, NULL, name, &is_given));
  *is_set = is_given ? PETSC_FALSE : PETSC_TRUE;
  if (*is_set) PetscCall(PetscOptionsSetValue(NULL, name, value));
  return 0;
}

PetscErrorCode sig_drop_default(const char *name, PetscBool is_set) {
  if (is_set) PetscCall(PetscOptionsClearValue(NULL, name));
  return 0;
}
