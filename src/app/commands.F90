! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Runs the command of the command line.
module sig_commands
  use mpi, only: MPI_Comm_rank
  use sig_command_help, only: usage, usage_of
  use sig_command_line, only: command_t, parse_command_line
  use sig_check, only: check_deck
  use sig_describe, only: describe
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_report, error_t, exit_success, exit_user
  use sig_forest_training, only: need_forest_tool, warn_of_missing_tool
  use sig_init, only: init_deck
  use sig_kinds, only: rk
  use sig_log, only: is_log_shown, log_error, log_info, log_to_file, lost_output, start_log
  use sig_memory_check, only: start_linear_algebra
  use sig_parameter_space, only: find_states
  use sig_point_argument, only: parse_states
  use sig_predict, only: predict
  use sig_run_report, only: run_report_t
  use sig_sampling_stage, only: sample_stage
  use sig_session, only: session_t
  use sig_signals, only: say_when_ended
  use sig_study, only: fields_stage, stop_if_asked, train_stage, validate_stage
  use sig_text, only: string_t
  use sig_version, only: code_version
  use petsc
  implicit none(type, external)
  private
  public :: run_command

contains

  !> Runs the command that the arguments name. Errors are printed and give the exit code. Output that could not be written is an
  !> error, too, but an exit code other than 0 of the command stays. Collective on all ranks, which all get the same exit code.
  subroutine run_command(arguments, exit_code, ierr)
    !> without the name of the program
    type(string_t), intent(in) :: arguments(:)
    integer, intent(out) :: exit_code
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: error

    PetscCall(choose_command(arguments, exit_code, ierr))
    call lost_output(error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    if (.not. allocated(error)) return
    call log_error(error_report(error))
    if (exit_code == exit_success) exit_code = error%exit_code
  end subroutine run_command

  subroutine choose_command(arguments, exit_code, ierr)
    type(string_t), intent(in) :: arguments(:)
    integer, intent(out) :: exit_code
    PetscErrorCode, intent(out) :: ierr
    type(command_t) :: command
    type(error_t), allocatable :: error
    integer :: rank

    call MPI_Comm_rank(PETSC_COMM_WORLD, rank, ierr)
    call parse_command_line(arguments, command, error)
    call start_log(rank == 0, command%is_quiet)
    exit_code = exit_user
    if (rank == 0 .and. command%log /= '' .and. .not. allocated(error)) call log_to_file(command%log, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    if (allocated(error)) then
      call log_error(error_report(error))
      return
    end if
    if (is_log_shown()) call say_when_ended('stopped by a signal: the work in progress is lost, all files are complete; ' // &
      'run the same command again')
    if (command%name /= 'help' .and. command%name /= 'version') call start_linear_algebra()
    exit_code = exit_success
    select case (command%name)
    case ('help')
      if (command%topic == '') call log_info(usage())
      if (command%topic /= '') call log_info(usage_of(command%topic))
    case ('version')
      call log_info('signorom ' // code_version)
    case ('init')
      PetscCall(init_deck(command, exit_code, ierr))
    case ('predict')
      PetscCall(predict(command, exit_code, ierr))
    case ('describe')
      PetscCall(describe(command, exit_code, ierr))
    case default
      PetscCall(run_on_deck(command, exit_code, ierr))
    end select
  end subroutine choose_command

  subroutine run_on_deck(command, exit_code, ierr)
    type(command_t), intent(in) :: command
    integer, intent(out) :: exit_code
    PetscErrorCode, intent(out) :: ierr
    type(session_t), target :: session

    PetscCall(session%open(command, ierr))
    if (session%exit_code == exit_success .and. command%name == 'check') then
      PetscCall(check_deck(command, session, ierr))
    else if (session%exit_code == exit_success) then
      PetscCall(session%claim_folder(ierr))
      if (session%exit_code == exit_success) then
        PetscCall(run_stages(command, session, ierr))
      end if
    end if
    PetscCall(session%close(command, ierr))
    exit_code = session%exit_code
  end subroutine run_on_deck

  !> Runs the stage of the command (that of solve is fields), or all stages for run: sample, train, validate (if the deck has a test
  !> section), fields. Stops at the first stage that has an error or is stopped by a signal, but not after points that did not
  !> converge. Errors are printed and set session%exit_code:
  !> --at is no valid point; for train and run, the deck may need the tool that trains forests, which is missing (for sample this is
  !> a warning); those of the stages. Collective on all ranks.
  subroutine run_stages(command, session, ierr)
    type(command_t), intent(in) :: command
    type(session_t), target, intent(inout) :: session
    PetscErrorCode, intent(out) :: ierr
    type(run_report_t) :: report
    type(error_t), allocatable :: error
    real(rk), allocatable :: points(:, :)
    logical :: is_run

    ierr = 0
    is_run = command%name == 'run'
    work: block
      if (command%at /= '') then
        call parse_states(command%at, session%deck, points, error)
      else
        call find_states(session%deck, session%deck%output%points, points, error)
      end if
      if (allocated(error)) exit work
      if (is_run .or. command%name == 'train') then
        PetscCall(need_forest_tool(session%deck, error, ierr))
      else if (command%name == 'sample') then
        PetscCall(warn_of_missing_tool(session%deck, ierr))
      end if
    end block work
    if (allocated(error)) then
      call session%fail(error)
      return
    end if
    if (is_run .or. command%name == 'sample') then
      PetscCall(sample_stage(session, ierr))
    end if
    if (session%may_go_on() .and. (is_run .or. command%name == 'train')) then
      PetscCall(train_stage(session, report, ierr))
      PetscCall(stop_if_asked(session, ierr))
    end if
    if (session%may_go_on() .and. ((is_run .and. session%deck%has_test) .or. command%name == 'validate')) then
      PetscCall(validate_stage(session, report, ierr))
    end if
    if (session%may_go_on() .and. (is_run .or. command%name == 'solve')) then
      PetscCall(fields_stage(session, points, is_run, report, ierr))
    end if
  end subroutine run_stages
end module sig_commands
