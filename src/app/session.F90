! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The begin and the end of every command on a deck: one rank reads the deck for all, PETSc gets its options, claim_folder locks the
!> results folder, and user errors are printed once.
module sig_session
  use mpi, only: MPI_Comm_rank
  use sig_command_line, only: command_t
  use sig_condensed_plan, only: check_flow, check_friction
  use sig_deck_check_study, only: complaint_about_options
  use sig_deck_config, only: deck_config_t
  use sig_deck_read, only: read_deck
  use sig_error_broadcast, only: broadcast_error, broadcast_text
  use sig_errors, only: error_list_t, error_report, error_t, exit_not_converged, exit_stopped, exit_success, &
    make_error
  use sig_file_system, only: directory_lock_t, lock_directory, make_directories, read_text_file, unlock_directory
  use sig_full_order, only: full_order_t
  use sig_kinds, only: rk
  use sig_log, only: log_error, log_info
  use sig_petsc_support, only: insert_petsc_options, max_over_ranks, options_unused_everywhere
  use sig_problem_texts, only: announce_plan
  use sig_signals, only: say_when_ended
  use sig_problem, only: problem_t
  use sig_share, only: share_t
  use sig_study_plan, only: check_training_memory, plan_study
  use sig_text, only: string_t
  use petsc
  implicit none(type, external)
  private
  public :: session_t

  !> A command on a deck. Call open, then claim_folder and the stages if exit_code is exit_success, then close.
  type :: session_t
    type(deck_config_t) :: deck
    !> text of the deck, for messages
    character(:), allocatable :: deck_text
    !> results folder
    character(:), allocatable :: folder
    integer :: rank = 0
    integer :: exit_code = exit_success
    !> fail was called, so no further stage may run
    logical :: has_failed = .false.
    !> announce_plan has logged the plan, or the sampling stage has run, which logs it where it solves points
    logical :: has_plan = .false.
    !> the command is run: the report keeps nothing of earlier commands
    logical :: is_whole_run = .false.
    !> --benchmark: validation measures times, too
    logical :: has_benchmark = .false.
    !> --halve-steps: solve estimates the error of time steps
    logical :: halves_steps = .false.
    !> --share: sample solves a share of the points, beside other jobs
    type(share_t) :: share
    !> warnings of forces that lean (lean_warnings) which this command has given: of each contact entry, not allocated without one
    type(string_t), allocatable :: lean_warnings(:)
    type(directory_lock_t) :: lock
    !> problem of the deck; the first stage that needs it loads it
    type(full_order_t) :: full_order
  contains
    procedure :: open
    procedure :: load_study
    procedure :: claim_folder
    procedure :: announce_plan => announce_plan_once
    procedure :: fail
    procedure :: stop => stop_session
    procedure :: end_stage
    procedure :: may_go_on
    procedure :: close
  end type session_t

contains

  !> Reads the deck and sets the PETSc options of the deck and the command line. Collective on all ranks.
  !>
  !> Errors are printed and set exit_code: the deck cannot be read or is not valid; a PETSc option of the command line is not
  !> allowed, or PETSc refuses it.
  subroutine open(self, command, ierr)
    class(session_t), intent(inout) :: self
    type(command_t), intent(in) :: command
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: error
    type(error_list_t) :: errors
    character(:), allocatable :: complaint
    integer :: i

    call MPI_Comm_rank(PETSC_COMM_WORLD, self%rank, ierr)
    self%is_whole_run = command%name == 'run'
    self%has_benchmark = command%has_benchmark
    self%halves_steps = command%halves_steps
    self%share = command%share
    if (self%rank == 0) call read_text_file(command%file, self%deck_text, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    if (allocated(error)) then
      self%deck_text = ''
      call self%fail(error)
      return
    end if
    PetscCall(broadcast_text(self%deck_text, PETSC_COMM_WORLD, ierr))
    call read_deck(command%file, self%deck_text, self%deck, errors)
    do i = 1, errors%n_errors()
      call self%fail(errors%errors(i))
    end do
    PetscCall(agree_on_size(self%deck, ierr))
    if (self%exit_code /= exit_success) return
    complaint = complaint_about_options(command%petsc_options, self%deck%solver%linear)
    if (len(complaint) > 0) then
      call make_error(error, 'the command line has ' // complaint)
      call self%fail(error)
      return
    end if
    ! The later one wins, so the command line comes after the deck.
    PetscCall(insert_petsc_options(self%deck%petsc_options, ierr))
    PetscCall(insert_petsc_options(command%petsc_options, ierr, complaint))
    if (allocated(complaint)) call make_error(error, 'PETSc refuses the options of the command line: ' // complaint)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    if (allocated(error)) call self%fail(error)
  end subroutine open

  !> Makes the size that the deck leaves to the machine (reduction.max_full_order_size) that of the smallest machine, so that all
  !> ranks choose alike. Collective on all ranks.
  subroutine agree_on_size(deck, ierr)
    type(deck_config_t), intent(inout) :: deck
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: negative

    ierr = 0
    if (.not. deck%reduction%is_size_auto) return
    negative = -deck%reduction%max_full_order_size
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, negative, ierr))
    deck%reduction%max_full_order_size = -negative
  end subroutine agree_on_size

  !> Loads the problem and plans the stages of the study together, unless that is done. Collective on all ranks. Errors: those of
  !> the loading of the problem; those of check_friction and check_inelastic where the deck has training points. If `refusal` is
  !> present, it gets the error of check_inelastic: `solve` takes such a deck.
  subroutine load_study(self, error, ierr, refusal)
    class(session_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable, intent(out), optional :: refusal
    logical :: was_loaded

    was_loaded = self%full_order%is_loaded
    PetscCall(self%full_order%load(self%deck, error, ierr))
    if (was_loaded .or. allocated(error)) return
    call plan_study(self%full_order%problem)
    if (.not. self%deck%has_training) return
    call check_friction(self%full_order%problem, error)
    if (allocated(error)) return
    if (present(refusal)) then
      call check_inelastic(self%full_order%problem, refusal)
    else
      call check_inelastic(self%full_order%problem, error)
    end if
  end subroutine load_study

  !> Errors: those of check_flow and check_training_memory.
  subroutine check_inelastic(problem, error)
    type(problem_t), intent(in) :: problem
    type(error_t), allocatable, intent(out) :: error

    call check_flow(problem, error)
    if (.not. allocated(error)) call check_training_memory(problem, error)
  end subroutine check_inelastic

  !> Logs the plan for the points that a stage will solve (announce_plan), unless an earlier stage did. Requires: check_points
  !> accepted the points.
  subroutine announce_plan_once(self, points)
    class(session_t), intent(inout) :: self
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)

    if (.not. self%has_plan) call announce_plan(self%full_order%problem, points)
    self%has_plan = .true.
  end subroutine announce_plan_once

  !> Makes and locks the results folder of the deck, or the session's share of it; sets `folder`. Collective on all ranks.
  !>
  !> Errors are printed and set exit_code: the folder cannot be made or locked, for example because another command
  !> uses it.
  subroutine claim_folder(self, ierr)
    class(session_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: error

    self%folder = self%deck%output%path
    work: if (self%rank == 0) then
      call make_directories(self%folder, error)
      if (allocated(error)) exit work
      if (self%share%is_used()) then
        call lock_directory(self%folder, self%lock, error, self%share%label())
      else
        call lock_directory(self%folder, self%lock, error)
      end if
    end if work
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    if (allocated(error)) call self%fail(error)
  end subroutine claim_folder

  !> Prints an error, with its line of the deck if it is in the deck, and sets exit_code and has_failed. An error with exit_stopped
  !> ends the session as stop does. All ranks call it with the same error.
  subroutine fail(self, error)
    class(session_t), intent(inout) :: self
    type(error_t), intent(in) :: error
    logical :: is_in_deck

    self%has_failed = .true.
    if (error%exit_code == exit_stopped) then
      call self%stop(error%message)
      return
    end if
    is_in_deck = .false.
    if (allocated(self%deck%path)) is_in_deck = error%file == self%deck%path
    if (is_in_deck) then
      call log_error(error_report(error, self%deck_text))
    else
      call log_error(error_report(error))
    end if
    self%exit_code = error%exit_code
  end subroutine fail

  !> Logs that a signal ended the command, and sets exit_code. Local; every rank calls it.
  subroutine stop_session(self, text)
    class(session_t), intent(inout) :: self
    !> what was kept or written
    character(*), intent(in) :: text

    call say_when_ended('')
    call log_info('stopped by a signal; ' // text)
    self%exit_code = exit_stopped
  end subroutine stop_session

  !> Ends a stage that may have failed or been stopped: prints the error, as fail does, or says that a signal stopped the stage, as
  !> stop does. Does nothing after a stage that came to its end. All ranks call it with the same arguments.
  subroutine end_stage(self, error, is_stopped, text)
    class(session_t), intent(inout) :: self
    type(error_t), allocatable, intent(in) :: error
    !> a signal stopped the work of the stage
    logical, intent(in) :: is_stopped
    !> what was kept or written before the signal
    character(*), intent(in) :: text

    if (allocated(error)) then
      call self%fail(error)
    else if (is_stopped) then
      call self%stop(text)
    end if
  end subroutine end_stage

  !> Whether the next stage may run. Errors and signals prevent this; points that did not converge do not.
  pure logical function may_go_on(self)
    class(session_t), intent(in) :: self

    may_go_on = .not. self%has_failed .and. any(self%exit_code == [exit_success, exit_not_converged])
  end function may_go_on

  !> Frees the problem and unlocks the results folder. Collective on all ranks.
  !>
  !> Errors are printed and set exit_code: an option of PETSc was not used, although it is not for another command or solver. Unused
  !> options are not looked for after an error or a signal.
  subroutine close(self, command, ierr)
    class(session_t), intent(inout) :: self
    type(command_t), intent(in) :: command
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: error
    type(string_t), allocatable :: options(:)
    real(rk) :: flags(2, 1)
    integer :: i

    ! a run that ended early has not come to all options
    flags(1, 1) = merge(1, 0, self%has_failed .or. self%exit_code == exit_stopped)
    flags(2, 1) = self%full_order%n_solved()
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, flags, ierr))
    PetscCall(self%full_order%destroy(ierr))
    call unlock_directory(self%lock)
    if (flags(1, 1) > 0) return
    PetscCall(options_unused_everywhere(options, ierr))
    do i = 1, size(options)
      if (is_for_another_command(options(i)%text, command, self%deck%solver%type, flags(2, 1) > 0)) cycle
      call make_error(error, 'the PETSc option ' // options(i)%text // ' was not used; the command ran to its end without it', &
        hint='check its name (options of signorom begin with two hyphens); solver.type condensed reads -fom_, ' // &
        'active_set -active_set_, snesvi -vi_; train reads -pod_ if the model needs modes')
      call self%fail(error)
    end do
  end subroutine close

  !> Whether an unused option is no mistake, because it is for another command or solver, or for a solver that had nothing to do:
  !> the options of a deck serve all commands. Only options that begin with -fom_, -active_set_, -vi_ or -pod_ can be; all others
  !> are mistakes.
  pure logical function is_for_another_command(option, command, solver, has_solved)
    !> with its hyphen
    character(*), intent(in) :: option
    type(command_t), intent(in) :: command
    !> type of the deck's solver
    character(*), intent(in) :: solver
    !> the command has solved a point
    logical, intent(in) :: has_solved
    logical :: is_solving

    is_solving = has_solved .and. any(command%name == [character(8) :: 'run', 'sample', 'solve', 'validate'])
    ! either may be the one that auto takes
    is_for_another_command = solver == 'auto' .and. .not. command%has_benchmark .and. &
      (index(option, '-fom_') == 1 .or. index(option, '-active_set_') == 1)
    if (is_for_another_command) return
    if (index(option, '-fom_') == 1) then
      is_for_another_command = .not. (is_solving .and. solver == 'condensed')
    else if (index(option, '-active_set_') == 1) then
      is_for_another_command = .not. (command%has_benchmark .or. (is_solving .and. solver == 'active_set'))
    else if (index(option, '-vi_') == 1) then
      is_for_another_command = .not. (is_solving .and. solver == 'snesvi')
    else if (index(option, '-pod_') == 1) then
      is_for_another_command = .not. (command%name == 'run' .or. command%name == 'train')
    end if
  end function is_for_another_command
end module sig_session
