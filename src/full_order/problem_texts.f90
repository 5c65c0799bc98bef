! SPDX-License-Identifier: BSD-3-Clause
!> What a command says of its problem before it solves: contacts, solver, notes and warnings, inert pairs.
module sig_problem_texts
  use sig_contact_summary, only: contact_lines
  use sig_friction_warnings, only: friction_warnings
  use sig_kinds, only: rk
  use sig_load_windows, only: window_warnings
  use sig_log, only: log_info, log_warnings
  use sig_problem, only: problem_t
  use sig_solver_plan, only: plan_text
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: announce_plan, warn_of_plan, inert_pair_names, tags_text

contains

  !> Writes to the log, by log_info, the contacts and their gaps at the points, the solver and why it is taken, and all notes;
  !> then the warnings (warn_of_plan). Requires: check_points accepted the points.
  subroutine announce_plan(problem, points)
    type(problem_t), intent(in) :: problem
    !> points that will be solved, shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable :: lines(:)
    integer :: i

    lines = contact_lines(problem%deck, problem%mesh, problem%rows, problem%inert, problem%terms, points)
    do i = 1, size(lines)
      call log_info(lines(i)%text)
    end do
    call log_info(plan_text(problem%plan))
    do i = 1, size(problem%contact_notes)
      call log_info('note: ' // problem%contact_notes(i)%text)
    end do
    do i = 1, size(problem%notes)
      call log_info('note: ' // problem%notes(i)%text)
    end do
    call warn_of_plan(problem, points)
  end subroutine announce_plan

  !> Logs the warnings of a problem, and those of window_warnings and friction_warnings at the points. Requires: check_points
  !> accepted the points.
  subroutine warn_of_plan(problem, points)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable :: more(:)

    call log_warnings(problem%warnings)
    more = window_warnings(problem%deck, problem%mesh, points)
    call log_warnings(more)
    more = friction_warnings(problem, points)
    call log_warnings(more)
  end subroutine warn_of_plan

  !> Returns the names of the inert rows, `3 - 8` or `3 - obstacle`, with the node numbers of the mesh file; several nodes of one
  !> side have blanks between them.
  function inert_pair_names(problem) result(names)
    type(problem_t), intent(in) :: problem
    type(string_t), allocatable :: names(:)
    integer :: k

    allocate (names(problem%inert%n_rows))
    do k = 1, size(names)
      associate (tags => problem%mesh%node_tags, second => problem%inert%second_nodes_of(k))
        names(k)%text = tags_text(tags(problem%inert%first_nodes_of(k)), ' ') // ' - obstacle'
        if (size(second) > 0) names(k)%text = tags_text(tags(problem%inert%first_nodes_of(k)), ' ') // ' - ' // &
          tags_text(tags(second), ' ')
      end associate
    end do
  end function inert_pair_names

  !> Returns numbers as text with a separator between them. Requires: at least one number.
  pure function tags_text(tags, separator) result(text)
    integer, intent(in) :: tags(:)
    character(*), intent(in) :: separator
    character(:), allocatable :: text
    integer :: i

    text = to_text(tags(1))
    do i = 2, size(tags)
      text = text // separator // to_text(tags(i))
    end do
  end function tags_text
end module sig_problem_texts
