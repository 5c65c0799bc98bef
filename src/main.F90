! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Starts PETSc, runs one command, and ends with the exit code of this command, or with 1 after an internal error.
program signorom
  use mpi, only: MPI_Abort, MPI_COMM_WORLD
  use sig_commands, only: run_command
  use sig_errors, only: exit_internal
  use sig_kinds, only: rk
  use sig_memory_check, only: hint_at_memory
  use sig_petsc_support, only: end_petsc, start_petsc, take_fast_blas
  use sig_signals, only: install_stop_signals
  use sig_text, only: string_t
  implicit none(type, external)
  !> [s] after a stop signal the process may work on for this time before it is ended by force; start_petsc shortens the time where
  !> there are several ranks
  real(rk), parameter :: stop_grace = 1
  type(string_t), allocatable :: arguments(:)
  integer :: exit_code, ierr, ierr_abort

  call take_fast_blas()
  call install_stop_signals(stop_grace)
  call start_petsc(ierr)
  if (ierr == 0) then
    call read_arguments(arguments)
    call run_command(arguments, exit_code, ierr)
  end if
  if (ierr == 0) call end_petsc(ierr)
  if (ierr /= 0) call hint_at_memory()
  ! The other ranks may wait in a collective call that this one never reaches.
  if (ierr /= 0) call MPI_Abort(MPI_COMM_WORLD, exit_internal, ierr_abort)
  stop exit_code, quiet = .true.

contains

  subroutine read_arguments(arguments)
    type(string_t), allocatable, intent(out) :: arguments(:)
    integer :: i, length

    allocate (arguments(command_argument_count()))
    do i = 1, size(arguments)
      call get_command_argument(i, length=length)
      allocate (character(length) :: arguments(i)%text)
      call get_command_argument(i, arguments(i)%text)
    end do
  end subroutine read_arguments
end program signorom
