! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Sends a user error of any rank, or a text or bytes of one rank, to all ranks. Afterwards all ranks can act in the same way.
module sig_error_broadcast
  use, intrinsic :: iso_fortran_env, only: int64
  use mpi, only: MPI_Allreduce, MPI_Bcast, MPI_CHARACTER, MPI_Comm_rank, MPI_INTEGER, MPI_INTEGER8, MPI_MIN
  use sig_errors, only: error_t, make_error
  use petsc
  implicit none(type, external)
  private
  public :: broadcast_error, broadcast_text, broadcast_bytes

  !> most bytes in one message, because counts of MPI are default integers
  integer(int64), parameter :: largest_piece = 2_int64**30

contains

  !> Gives every rank the error of the lowest rank that has one, in place of its own. If no rank has an error, nothing changes.
  !> Collective on comm.
  subroutine broadcast_error(error, comm, ierr)
    type(error_t), allocatable, intent(inout) :: error
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    character(:), allocatable :: message, file, hint
    integer :: rank, candidate, root, numbers(3)

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    candidate = huge(candidate)
    if (allocated(error)) candidate = rank
    PetscCallMPI(MPI_Allreduce(candidate, root, 1, MPI_INTEGER, MPI_MIN, comm, ierr))
    if (root == huge(root)) return
    numbers = 0
    message = ''
    file = ''
    hint = ''
    if (rank == root) then
      numbers = [error%line, error%column, error%exit_code]
      message = error%message
      file = error%file
      hint = error%hint
    end if
    PetscCallMPI(MPI_Bcast(numbers, size(numbers), MPI_INTEGER, root, comm, ierr))
    PetscCall(text_of_rank(root, message, comm, ierr))
    PetscCall(text_of_rank(root, file, comm, ierr))
    PetscCall(text_of_rank(root, hint, comm, ierr))
    call make_error(error, message, file=file, line=numbers(1), column=numbers(2), hint=hint, exit_code=numbers(3))
  end subroutine broadcast_error

  !> Gives every rank the text of rank 0; a text of rank 0 that is not allocated counts as empty. The text is allocated on all ranks
  !> afterwards. Collective on comm.
  subroutine broadcast_text(text, comm, ierr)
    character(:), allocatable, intent(inout) :: text
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr

    PetscCall(text_of_rank(0, text, comm, ierr))
  end subroutine broadcast_text

  !> Gives every rank the bytes of one rank. Collective on comm.
  subroutine broadcast_bytes(root, bytes, comm, ierr, piece)
    !> rank that has the bytes, 0-based
    integer, intent(in) :: root
    !> in: those of the root, where not allocated counts as none; out: the same on every rank
    character(1), allocatable, intent(inout) :: bytes(:)
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    !> most bytes in one message, the same on all ranks; default largest_piece (2**30)
    integer(int64), intent(in), optional :: piece
    integer(int64) :: first, last, length, step
    integer :: rank

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    step = largest_piece
    if (present(piece)) step = piece
    if (.not. allocated(bytes)) allocate (bytes(0))
    length = size(bytes, kind=int64)
    PetscCallMPI(MPI_Bcast(length, 1, MPI_INTEGER8, root, comm, ierr))
    if (rank /= root) then
      deallocate (bytes)
      allocate (bytes(length))
    end if
    do first = 1, length, step
      last = min(first + step - 1, length)
      PetscCallMPI(MPI_Bcast(bytes(first:last), int(last - first + 1), MPI_CHARACTER, root, comm, ierr))
    end do
  end subroutine broadcast_bytes

  !> Gives every rank the text of rank `root` (0-based); a text of this rank that is not allocated counts as empty. The text is
  !> allocated on all ranks afterwards. Collective on comm.
  subroutine text_of_rank(root, text, comm, ierr)
    integer, intent(in) :: root
    character(:), allocatable, intent(inout) :: text
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: rank, length

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    if (.not. allocated(text)) text = ''
    length = len(text)
    PetscCallMPI(MPI_Bcast(length, 1, MPI_INTEGER, root, comm, ierr))
    if (rank /= root) then
      deallocate (text)
      allocate (character(length) :: text)
    end if
    PetscCallMPI(MPI_Bcast(text, length, MPI_CHARACTER, root, comm, ierr))
  end subroutine text_of_rank
end module sig_error_broadcast
