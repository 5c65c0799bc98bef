// SPDX-License-Identifier: BSD-3-Clause
#include <slepcsys.h>

// SLEPc's Fortran modules are not packaged by Debian 12, so this half of the start is in C.
int sig_test_start_slepc(void);

// Options of the test program (pFUnit's --verbose) are none of PETSc's.
int sig_test_start_slepc(void) {
  const PetscErrorCode code = SlepcInitializeNoArguments();
  return code ? (int)code : (int)PetscOptionsClear(NULL);
}
