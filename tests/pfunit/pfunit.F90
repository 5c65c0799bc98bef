! SPDX-License-Identifier: BSD-3-Clause
!> What a .pf file with MPI tests uses: the assertions and the face of the rank group that a test runs on.
module pfunit
  use funit
  use mpi, only: MPI_Allreduce, MPI_IN_PLACE, MPI_LOGICAL, MPI_LOR
  implicit none(type, external)
  public

  !> The group of ranks of the running test.
  type :: MpiTestMethod
    integer, private :: communicator = -1
    integer, private :: n_processes = 0
    integer, private :: rank = 0
  contains
    procedure :: getMpiCommunicator
    procedure :: getNumProcesses
    procedure :: getProcessRank
    procedure :: set_group
  end type MpiTestMethod

  interface anyExceptions
    procedure any_exceptions_on
  end interface anyExceptions

contains

  integer function getMpiCommunicator(this) result(communicator)
    class(MpiTestMethod), intent(in) :: this

    communicator = this%communicator
  end function getMpiCommunicator

  integer function getNumProcesses(this) result(n_processes)
    class(MpiTestMethod), intent(in) :: this

    n_processes = this%n_processes
  end function getNumProcesses

  integer function getProcessRank(this) result(rank)
    class(MpiTestMethod), intent(in) :: this

    rank = this%rank
  end function getProcessRank

  !> For the runner only.
  subroutine set_group(this, communicator, n_processes, rank)
    class(MpiTestMethod), intent(inout) :: this
    integer, intent(in) :: communicator
    integer, intent(in) :: n_processes
    integer, intent(in) :: rank

    this%communicator = communicator
    this%n_processes = n_processes
    this%rank = rank
  end subroutine set_group

  !> Whether any rank has failed. Collective.
  logical function any_exceptions_on(communicator) result(is_failed)
    integer, intent(in) :: communicator
    integer :: status

    is_failed = anyExceptions()
    call MPI_Allreduce(MPI_IN_PLACE, is_failed, 1, MPI_LOGICAL, MPI_LOR, communicator, status)
  end function any_exceptions_on
end module pfunit
