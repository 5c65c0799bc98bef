! SPDX-License-Identifier: BSD-3-Clause
!> Starts PETSc and SLEPc for the MPI tests, after the test program has started MPI.
!>
!> Nothing here finalizes them: pFUnit has finalized MPI by the time its hook for that is called.
module petsc_start
#include <petsc/finclude/petsc.h>
  use, intrinsic :: iso_c_binding, only: c_int
  use petsc
  implicit none(type, external)
  private
  public :: start_petsc

  interface
    function sig_test_start_slepc() bind(c) result(status)
      import :: c_int
      integer(c_int) :: status
    end function sig_test_start_slepc
  end interface

contains

  !> Collective on the world.
  subroutine start_petsc()
    PetscErrorCode :: ierr

    call PetscInitialize(PETSC_NULL_CHARACTER, ierr)
    if (ierr /= 0) error stop 'PETSc did not start'
    if (sig_test_start_slepc() /= 0) error stop 'SLEPc did not start'
  end subroutine start_petsc
end module petsc_start
