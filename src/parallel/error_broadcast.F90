! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> A user error or a text found on rank 0, told to every rank before anybody leaves.
module sig_error_broadcast
  use mpi, only: MPI_Bcast, MPI_CHARACTER, MPI_Comm_rank, MPI_INTEGER
  use sig_errors, only: error_t, make_error
  use petsc
  implicit none(type, external)
  private
  public :: broadcast_error, broadcast_text

contains

  !> Collective on comm. Rank 0's error, allocated or not, becomes that of every rank.
  subroutine broadcast_error(error, comm, ierr)
    type(error_t), allocatable, intent(inout) :: error
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    character(:), allocatable :: message, file, hint
    integer :: rank, numbers(4)

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    numbers = 0
    message = ''
    file = ''
    hint = ''
    if (rank == 0 .and. allocated(error)) then
      numbers = [1, error%line, error%column, error%exit_code]
      message = error%message
      file = error%file
      hint = error%hint
    end if
    PetscCallMPI(MPI_Bcast(numbers, size(numbers), MPI_INTEGER, 0, comm, ierr))
    if (numbers(1) == 0) then
      if (allocated(error)) deallocate (error)
      return
    end if
    PetscCall(broadcast_text(message, comm, ierr))
    PetscCall(broadcast_text(file, comm, ierr))
    PetscCall(broadcast_text(hint, comm, ierr))
    call make_error(error, message, file=file, line=numbers(2), column=numbers(3), hint=hint, exit_code=numbers(4))
  end subroutine broadcast_error

  !> Collective on comm. Rank 0's text becomes that of every rank; unallocated counts as empty.
  subroutine broadcast_text(text, comm, ierr)
    character(:), allocatable, intent(inout) :: text
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: rank, length

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    if (.not. allocated(text)) text = ''
    length = len(text)
    PetscCallMPI(MPI_Bcast(length, 1, MPI_INTEGER, 0, comm, ierr))
    if (rank /= 0) then
      deallocate (text)
      allocate (character(length) :: text)
    end if
    PetscCallMPI(MPI_Bcast(text, length, MPI_CHARACTER, 0, comm, ierr))
  end subroutine broadcast_text
end module sig_error_broadcast
