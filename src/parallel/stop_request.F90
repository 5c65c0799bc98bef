! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Tells all ranks that one of them got a request to stop.
module sig_stop_request
  use sig_kinds, only: rk
  use sig_petsc_support, only: max_over_ranks
  use sig_signals, only: is_stop_requested
  use petsc
  implicit none(type, external)
  private
  public :: agree_to_stop

contains

  !> Sets is_stopped, the same on every rank, to whether any rank got a request to stop. Collective on comm.
  subroutine agree_to_stop(comm, is_stopped, ierr)
    MPI_Comm, intent(in) :: comm
    logical, intent(out) :: is_stopped
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: flag

    flag = merge(1.0_rk, 0.0_rk, is_stop_requested())
    PetscCall(max_over_ranks(comm, flag, ierr))
    is_stopped = flag > 0
  end subroutine agree_to_stop
end module sig_stop_request
