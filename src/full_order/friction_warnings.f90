! SPDX-License-Identifier: BSD-3-Clause
!> Warnings of decks with friction, before anything is solved: large coefficients, loads that act before the first time, and steps
!> so coarse that a table turns round inside of one.
module sig_friction_warnings
  use sig_contact_summary, only: contact_name
  use sig_deck_box, only: names_of
  use sig_history, only: table_values_t
  use sig_kinds, only: rk
  use sig_parameter_space, only: format_point
  use sig_problem, only: problem_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: append_text, fine_digits, short_number, string_t, to_text
  implicit none(type, external)
  private
  public :: friction_warnings

contains

  !> Returns the warnings, each once, with the first point for which it holds; none without friction. Requires: check_points
  !> accepted the points.
  function friction_warnings(problem, points) result(warnings)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points); with a history all states of each point
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable :: warnings(:)

    allocate (warnings(0))
    if (.not. problem%laws%remembers() .or. size(points, 2) == 0) return
    call add_large_coefficients(problem, points, warnings)
    if (.not. problem%deck%history%states%is_there()) return
    call add_sudden_loads(problem, points, warnings)
    call add_turns_in_steps(problem, points, warnings)
  end function friction_warnings

  !> Above 1 a step may have several solutions (method of sig_friction_problem).
  subroutine add_large_coefficients(problem, points, warnings)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable, intent(inout) :: warnings(:)
    real(rk), parameter :: usual = 1.0_rk
    real(rk), allocatable :: theta(:, :)
    real(rk) :: largest(size(problem%deck%contact))
    integer :: i, i_bad_point, i_bad_source, k

    call evaluate_points(problem%terms, points, theta, i_bad_point, i_bad_source)
    largest = 0
    do i = 1, size(points, 2)
      associate (friction => problem%laws%friction_at(theta(:, i)))
        do k = 1, size(friction)
          associate (of_entry => largest(problem%rows%contact_entry(k)))
            of_entry = max(of_entry, friction(k))
          end associate
        end do
      end associate
    end do
    do i = 1, size(largest)
      if (largest(i) > usual) call append_text(warnings, 'contact[' // to_text(i) // '] (' // contact_name(problem%deck, i) // &
        '): the coefficient of friction is up to ' // short_number(largest(i), fine_digits) // &
        '; above 1 a step may have several solutions')
    end do
  end subroutine add_large_coefficients

  !> Loads that do not begin at 0 act at once in the first step, wherever its time is: how contacts slip in it depends on nothing
  !> but the size of this step.
  subroutine add_sudden_loads(problem, points, warnings)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable, intent(inout) :: warnings(:)
    type(table_values_t) :: tables
    character(:), allocatable :: fault
    real(rk), allocatable :: state(:), theta(:, :)
    integer :: i, i_bad_point, i_bad_source, i_table

    associate (history => problem%deck%history%states, n => size(problem%deck%parameters))
      call tables%create(history, names_of(problem%deck%parameters), fault)
      do i = 1, size(points, 2), history%n_times()
        call tables%begin(points(:n, i), i_table, fault)
        if (allocated(fault)) exit
        state = [points(:n, i), tables%at(0.0_rk)]
        call evaluate_points(problem%terms, reshape(state, [size(state), 1]), theta, i_bad_point, i_bad_source)
        if (i_bad_point > 0) cycle
        if (.not. (any(abs(problem%boundary%forces(theta(:, 1))) > 0) .or. &
                   any(abs(problem%boundary%prescribed_displacement(theta(:, 1))) > 0))) cycle
        call append_text(warnings, 'loads or prescribed displacements are not 0 at the time 0 (' // &
          format_point(problem%deck%parameters, points(:n, i)) // '): they act at once in the first step, and contacts slip ' // &
          'in it as in one stroke; let tables begin with the value 0 if this matters')
        exit
      end do
      call tables%destroy()
    end associate
  end subroutine add_sudden_loads

  !> Between two times a load is a straight line: what happens at a turn inside of a step is lost.
  subroutine add_turns_in_steps(problem, points, warnings)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable, intent(inout) :: warnings(:)
    type(table_values_t) :: tables
    character(:), allocatable :: fault
    real(rk) :: time
    integer :: i, i_table, k, n

    n = size(problem%deck%parameters)
    associate (history => problem%deck%history%states)
      call tables%create(history, names_of(problem%deck%parameters), fault)
      do k = 1, size(history%tables)
        do i = 1, size(points, 2), history%n_times()
          call tables%begin(points(:n, i), i_table, fault)
          if (allocated(fault)) exit
          time = tables%turn_between(k, history%times)
          if (time < 0) cycle
          call append_text(warnings, 'the table ''' // history%tables(k)%name // ''' turns round at the time ' // &
            short_number(time, fine_digits) // ', inside of a step (' // format_point(problem%deck%parameters, points(:n, i)) // &
            '): friction does not see its largest value; let a step end there')
          exit
        end do
      end do
      call tables%destroy()
    end associate
  end subroutine add_turns_in_steps
end module sig_friction_warnings
