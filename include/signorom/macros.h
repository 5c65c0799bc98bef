/* SPDX-License-Identifier: BSD-3-Clause */
/* For Fortran files that touch PETSc. PetscCall needs a dummy argument named ierr; never put it behind a one-line `if`. */
#ifndef SIGNOROM_MACROS_H
#define SIGNOROM_MACROS_H
#include <slepc/finclude/slepc.h>
/* A broken precondition of a public procedure: says where and returns through ierr.
   The module uses precondition_failed of sig_petsc_support. */
#define SIG_CHECK(condition, code, sentence) if (.not. (condition)) then; call precondition_failed(code, sentence, __FILE__, __LINE__, ierr); return; end if
#endif
