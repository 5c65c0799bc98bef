! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The command describe: prints what a model file contains. It needs neither deck nor mesh.
module sig_describe
  use mpi, only: MPI_Comm_rank
  use sig_command_line, only: command_t
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_report, error_t, exit_success
  use sig_log, only: log_error, log_info
  use sig_model, only: model_t
  use sig_model_description, only: describe_model
  use sig_model_file, only: read_model
  use petsc
  implicit none(type, external)
  private
  public :: describe

contains

  !> Prints what the model file of the command contains. Rank 0 does the work. Collective on all ranks, which all get the exit code.
  !> Errors are printed and give the exit code: the model cannot be read.
  subroutine describe(command, exit_code, ierr)
    type(command_t), intent(in) :: command
    integer, intent(out) :: exit_code
    PetscErrorCode, intent(out) :: ierr
    type(model_t) :: model
    type(error_t), allocatable :: error
    integer :: rank

    call MPI_Comm_rank(PETSC_COMM_WORLD, rank, ierr)
    if (rank == 0) call read_model(command%file, model, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    exit_code = exit_success
    if (allocated(error)) then
      call log_error(error_report(error))
      exit_code = error%exit_code
    else if (rank == 0) then
      call log_info(describe_model(model))
    end if
  end subroutine describe
end module sig_describe
