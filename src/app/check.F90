! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The command check: reads deck and mesh, finds every name and checks every point, but solves nothing. With --fields it writes
!> supports, loads and contact for ParaView.
module sig_check
  use sig_body_constants, only: check_box
  use sig_check_fields, only: boundary_groups, write_check_fields
  use sig_command_line, only: command_t
  use sig_contact_summary, only: contact_lines
  use sig_deck_config, only: deck_config_t
  use sig_deck_echo, only: echo_deck
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_location, error_t
  use sig_forest_training, only: warn_of_missing_tool
  use sig_kinds, only: rk
  use sig_leaning_contacts, only: predicted_lean_warnings
  use sig_log, only: log_info, log_warning, log_warnings
  use sig_parameter_space, only: build_states, find_states, format_point
  use sig_point_argument, only: parse_states
  use sig_point_checks, only: check_points
  use sig_problem, only: problem_t
  use sig_problem_texts, only: inert_pair_names, warn_of_plan
  use sig_row_condition, only: condition_of_rows
  use sig_session, only: session_t
  use sig_solver_plan, only: plan_text
  use sig_study_plan, only: stage_lines
  use sig_text, only: counted, fine_digits, join, short_number, string_t, to_text
  use petsc
  implicit none(type, external)
  private
  public :: check_deck

contains

  !> Prints the effective deck, which is a valid deck itself, and the sizes as comments. Gives the warnings of the problem
  !> (warn_of_plan) and of contacts whose forces will lean (predicted_lean_warnings), and warns if the tool that trains forests is
  !> missing and may be needed, and if there are training points but only solve can take the deck. With --fields it also writes
  !> check.h5 and check.xdmf. After an error it prints no deck; with --fields the two files are still written if --at could be read
  !> and supports and loads could be built. Collective on all ranks.
  !>
  !> Errors are printed and set session%exit_code: --at cannot be read; those of the loading of the problem, of build_states,
  !> check_points (also of the point of --fields) and check_box; a file cannot be written.
  subroutine check_deck(command, session, ierr)
    type(command_t), intent(in) :: command
    type(session_t), intent(inout) :: session
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: error, refusal
    real(rk), allocatable :: training(:, :), test(:, :), output(:, :), shown(:, :)
    type(string_t), allocatable :: warnings(:)

    ierr = 0
    work: block
      call choose_shown(command, session%deck, shown, error)
      if (allocated(error)) exit work
      PetscCall(session%load_study(error, ierr, refusal))
      if (allocated(error)) exit work
      call check_all_points(session%full_order%problem, shown, training, test, output, error)
      if (allocated(error)) exit work
      call log_info(echo_deck(session%deck) // sizes_text(session%full_order%problem, training, test, output))
      if (allocated(refusal)) call log_warning(error_location(refusal) // ': there cannot be a model, so only solve takes ' // &
        'this deck: ' // refusal%message)
      call warn_of_plan(session%full_order%problem, joined_points(training, test, output))
      warnings = predicted_lean_warnings(session%full_order%problem, joined_points(training, test, output))
      call log_warnings(warnings)
      PetscCall(warn_of_missing_tool(session%deck, ierr))
    end block work
    if (allocated(error)) call session%fail(error)
    ! also after an error: pictures show best what is wrong
    if (command%has_fields .and. session%full_order%problem%has_driving) then
      PetscCall(write_fields(shown(:, size(shown, 2)), session, ierr))
    end if
  end subroutine check_deck

  !> Builds the training points and the test points of the deck and checks them, the shown ones, those of the output, and the box of
  !> the training. Errors: those of build_states, find_states, check_points and check_box.
  subroutine check_all_points(problem, shown, training, test, output, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points), as all
    real(rk), intent(in) :: shown(:, :)
    !> without points if the deck has no such section
    real(rk), allocatable, intent(out) :: training(:, :)
    real(rk), allocatable, intent(out) :: test(:, :)
    !> states of the output points
    real(rk), allocatable, intent(out) :: output(:, :)
    type(error_t), allocatable, intent(out) :: error

    associate (deck => problem%deck)
      allocate (training(size(deck%state_parameters), 0), test(size(deck%state_parameters), 0))
      if (deck%has_training) call build_states(deck, deck%training, training, error)
      if (allocated(error)) return
      if (deck%has_test) call build_states(deck, deck%test, test, error)
      if (allocated(error)) return
      call check_points(problem, shown, error)
      if (allocated(error)) return
      call check_points(problem, training, error)
      if (allocated(error)) return
      call check_points(problem, test, error)
      if (allocated(error)) return
      call find_states(deck, deck%output%points, output, error)
      if (allocated(error)) return
      call check_points(problem, output, error)
      if (allocated(error)) return
      ! the model must be possible in the whole box
      if (deck%has_training) call check_box(problem, error)
    end associate
  end subroutine check_all_points

  !> Finds the point of --fields: that of --at, or the middle of the box; with a history all its states, of which the last is shown.
  !> Errors: those of parse_states.
  subroutine choose_shown(command, deck, shown, error)
    type(command_t), intent(in) :: command
    type(deck_config_t), intent(in) :: deck
    !> shape (size(deck%state_parameters), n_states), no column without --fields
    real(rk), allocatable, intent(out) :: shown(:, :)
    type(error_t), allocatable, intent(out) :: error

    if (.not. command%has_fields) then
      allocate (shown(size(deck%state_parameters), 0))
    else if (command%at /= '') then
      call parse_states(command%at, deck, shown, error)
    else
      call find_states(deck, reshape(deck%parameters%minimum / 2 + deck%parameters%maximum / 2, [size(deck%parameters), 1]), &
        shown, error)
    end if
  end subroutine choose_shown

  !> Writes check.h5 and check.xdmf in the results folder, also if the session has failed already, and logs boundary_text, the path
  !> and the point. Collective on all ranks. Errors are printed and set session%exit_code: the folder cannot be claimed; a file
  !> cannot be written.
  subroutine write_fields(point, session, ierr)
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    type(session_t), intent(inout) :: session
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: error
    logical :: had_failed

    had_failed = session%has_failed
    session%has_failed = .false.
    PetscCall(session%claim_folder(ierr))
    if (session%has_failed) return
    session%has_failed = had_failed
    if (session%rank == 0) call write_check_fields(session%full_order%problem, point, session%folder, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    if (allocated(error)) then
      call session%fail(error)
    else
      call log_info(boundary_text(session%full_order%problem) // '# fields: ' // session%folder // '/check.xdmf at ' // &
        format_point(session%deck%state_parameters, point))
    end if
  end subroutine write_fields

  !> Returns `# boundaries: 1 left, 2 right` and a line end: the numbers and names of boundary_groups. Viewers show only these
  !> numbers, in the field `boundary`.
  function boundary_text(problem) result(text)
    type(problem_t), intent(in) :: problem
    character(:), allocatable :: text
    integer :: i

    text = '# boundaries:'
    associate (groups => boundary_groups(problem%mesh))
      do i = 1, size(groups)
        if (i > 1) text = text // ','
        text = text // ' ' // to_text(i) // ' ' // problem%mesh%groups(groups(i))%name
      end do
    end associate
    text = text // new_line('a')
  end function boundary_text

  !> Returns the comment lines below the deck, without a line end at their end: sizes, numbers of training points (or candidates)
  !> and test points, contacts, the condition number of B (only if there are contact rows), the planned solver, what the
  !> stages are predicted to take, notes and inert pairs.
  function sizes_text(problem, training, test, output) result(text)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: training(:, :)
    real(rk), intent(in) :: test(:, :)
    real(rk), intent(in) :: output(:, :)
    character(:), allocatable :: text, training_text
    type(string_t), allocatable :: inert(:), contact(:), stages(:)
    integer :: i

    inert = inert_pair_names(problem)
    training_text = to_text(size(training, 2)) // ' training'
    if (problem%deck%greedy%is_used) training_text = counted(size(training, 2), 'candidate') // ' for training'
    text = '# sizes: ' // counted(problem%mesh%n_nodes, 'node') // ', ' // counted(problem%mesh%n_cells, 'cell') // ', ' // &
      counted(problem%mesh%n_dim * problem%mesh%n_nodes, 'dof') // ' (' // to_text(size(problem%boundary%prescribed_dofs)) // &
      ' prescribed), ' // counted(problem%rows%n_rows + problem%inert%n_rows, 'contact pair') // ', ' // &
      counted(problem%force_rows%n_rows, 'multiplier') // new_line('a') // '# points: ' // training_text // ', ' // &
      to_text(size(test, 2)) // ' test'
    associate (history => problem%deck%history%states)
      if (history%is_there()) text = text // '; ' // counted(history%n_times(), 'time') // ' of each point are counted'
    end associate
    contact = contact_lines(problem%deck, problem%mesh, problem%rows, problem%inert, problem%terms, &
      joined_points(training, test, output))
    do i = 1, size(contact)
      text = text // new_line('a') // '# ' // contact(i)%text
    end do
    if (problem%rows%n_rows > 0) text = text // new_line('a') // '# condition number of the contact matrix B: ' // &
      short_number(condition_of_rows(problem%rows, problem%boundary%is_prescribed), fine_digits)
    text = text // new_line('a') // '# ' // plan_text(problem%plan)
    stages = stage_lines(problem)
    do i = 1, size(stages)
      text = text // new_line('a') // '# ' // stages(i)%text
    end do
    do i = 1, size(problem%contact_notes)
      text = text // new_line('a') // '# note: ' // problem%contact_notes(i)%text
    end do
    do i = 1, size(problem%notes)
      text = text // new_line('a') // '# note: ' // problem%notes(i)%text
    end do
    if (size(inert) > 0) text = text // new_line('a') // '# inert pairs (both sides prescribed, no multiplier): nodes ' // &
      join(inert, ', ')
  end function sizes_text

  !> Returns the training points, the test points and the output points, shape (n_parameters, n_points).
  pure function joined_points(training, test, output) result(points)
    real(rk), intent(in) :: training(:, :)
    real(rk), intent(in) :: test(:, :)
    real(rk), intent(in) :: output(:, :)
    real(rk), allocatable :: points(:, :)

    points = reshape([training, test, output], [size(training, 1), size(training, 2) + size(test, 2) + size(output, 2)])
  end function joined_points
end module sig_check
