! SPDX-License-Identifier: BSD-3-Clause
!> Warnings of decks with friction, before anything is solved: large coefficients, loads that act before the first time, and steps
!> so coarse that a table turns round inside of one.
module sig_friction_warnings
  use sig_contact_summary, only: contact_name
  use sig_deck_box, only: corners_to_try, names_of
  use sig_errors, only: error_t
  use sig_history, only: table_values_t
  use sig_kinds, only: rk
  use sig_parameter_space, only: find_states, format_point
  use sig_problem, only: problem_t
  use sig_rounding, only: rounding_of_data
  use sig_term_values, only: evaluate_points, term_values_t
  use sig_text, only: append_text, fine_digits, join, short_number, string_t, to_text
  use sig_unheld_bodies, only: moving_bodies, unheld_without_friction
  implicit none(type, external)
  private
  public :: friction_warnings

  !> largest number of states at corners of the box where coefficients of friction are looked at
  integer, parameter :: most_states = 100000

contains

  !> Returns the warnings, each once, with a point for which it holds; none without friction. Requires: check_points
  !> accepted the points.
  function friction_warnings(problem, points) result(warnings)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points); with a history all states of each point
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable :: warnings(:)

    allocate (warnings(0))
    if (.not. problem%laws%remembers() .or. size(points, 2) == 0) return
    call add_large_coefficients(problem, points, warnings)
    call add_missing_friction(problem, points, warnings)
    if (.not. problem%deck%history%states%is_there()) return
    call add_sudden_loads(problem, points, warnings)
    call add_turns_in_steps(problem, points, warnings)
  end function friction_warnings

  !> Above 1 a step may have several solutions (method of sig_friction_problem). Queries may ask for the whole box of the
  !> parameters, so its corners count, too.
  subroutine add_large_coefficients(problem, points, warnings)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable, intent(inout) :: warnings(:)
    real(rk), parameter :: usual = 1.0_rk
    type(error_t), allocatable :: error
    type(string_t), allocatable :: places(:)
    real(rk), allocatable :: corners(:, :), states(:, :)
    real(rk) :: largest(size(problem%deck%contact))
    integer :: i

    allocate (places(size(largest)))
    largest = 0
    corners = corners_to_try(problem%deck%parameters)
    ! many times of many corners: the middle and the two last corners do
    if (size(corners, 2) * max(1, problem%deck%history%states%n_times()) > most_states) &
      corners = corners(:, [1, 2, size(corners, 2)])
    call find_states(problem%deck, corners, states, error)
    if (.not. allocated(error)) call raise_coefficients(problem, states, largest, places)
    call raise_coefficients(problem, points, largest, places)
    do i = 1, size(largest)
      if (largest(i) > usual) call append_text(warnings, 'contact[' // to_text(i) // '] (' // contact_name(problem%deck, i) // &
        '): the coefficient of friction is up to ' // short_number(largest(i), fine_digits) // places(i)%text // &
        '; above 1 a step may have several solutions')
    end do
  end subroutine add_large_coefficients

  !> Raises the largest coefficient of friction [-] of each contact entry of the deck to those at some states. States at which an
  !> expression has no finite value do not count.
  subroutine raise_coefficients(problem, states, largest, places)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_states)
    real(rk), intent(in) :: states(:, :)
    !> shape (n_entries)
    real(rk), intent(inout) :: largest(:)
    !> ` at mu = 2.0`: where it is largest, same shape
    type(string_t), intent(inout) :: places(:)
    type(term_values_t) :: terms
    character(:), allocatable :: message
    real(rk) :: theta(problem%terms%n_terms())
    integer :: i, i_source, k
    logical :: is_valid

    call terms%create(problem%terms, message)
    do i = 1, size(states, 2)
      call terms%evaluate(states(:, i), theta, is_valid, i_source)
      if (.not. is_valid) cycle
      associate (friction => problem%laws%friction_at(theta))
        do k = 1, size(friction)
          associate (entry => problem%rows%contact_entry(k))
            if (.not. friction(k) > largest(entry)) cycle
            largest(entry) = friction(k)
            places(entry)%text = ' at ' // format_point(problem%deck%state_parameters, states(:, i))
          end associate
        end do
      end associate
    end do
    call terms%destroy()
  end subroutine raise_coefficients

  !> Where the coefficient of friction is 0, it holds nothing.
  subroutine add_missing_friction(problem, points, warnings)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable, intent(inout) :: warnings(:)
    type(string_t), allocatable :: bodies(:)
    real(rk), allocatable :: theta(:, :), loose(:, :)
    logical :: is_slippery(problem%laws%n_contacts), was_slippery(problem%laws%n_contacts)
    integer :: i, i_bad_point, i_bad_source

    if (problem%motions%n_free == 0) return
    call evaluate_points(problem%terms, points, theta, i_bad_point, i_bad_source)
    was_slippery = .false.
    do i = 1, size(points, 2)
      associate (friction => problem%laws%friction_at(theta(:, i)))
        is_slippery = problem%laws%have_friction() .and. .not. friction > 0
        if (all(is_slippery .eqv. was_slippery)) cycle
        was_slippery = is_slippery
        loose = unheld_without_friction(problem%motions, problem%laws, friction)
      end associate
      if (size(loose, 2) == 0) cycle
      bodies = moving_bodies(problem%deck, problem%mesh, problem%motions, loose)
      call append_text(warnings, 'the coefficient of friction is 0 at ' // &
        format_point(problem%deck%state_parameters, points(:, i)) // ', and nothing else holds ' // join(bodies, ', ') // &
        ': with a load along such a motion there is no equilibrium; without one the body stays where it is; hold it by a ' // &
        'support, or by friction from the beginning')
      exit
    end do
  end subroutine add_missing_friction

  !> Loads that do not begin at 0 act at once in the first step, wherever its time is: how contacts slip in it depends on nothing
  !> but the size of this step. The same holds for overlaps by initial_gap or an obstacle. Where no contact has friction in the
  !> first state, none of this matters.
  subroutine add_sudden_loads(problem, points, warnings)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable, intent(inout) :: warnings(:)
    type(table_values_t) :: tables
    character(:), allocatable :: fault, what
    real(rk), allocatable :: state(:), theta(:, :)
    integer :: i, i_bad_point, i_bad_source, i_table

    associate (history => problem%deck%history%states, n => size(problem%deck%parameters))
      call tables%create(history, names_of(problem%deck%parameters), fault)
      do i = 1, size(points, 2), history%n_times()
        call tables%begin(points(:n, i), i_table, fault)
        if (allocated(fault)) exit
        state = [points(:n, i), tables%at(0.0_rk)]
        call evaluate_points(problem%terms, reshape([state, points(:, i)], [size(state), 2]), theta, i_bad_point, i_bad_source)
        if (i_bad_point > 0 .or. .not. any(problem%laws%have_friction() .and. problem%laws%friction_at(theta(:, 2)) > 0)) cycle
        what = sudden_loads(problem, theta(:, 1))
        if (what == '') cycle
        call append_text(warnings, what // ' not 0 at the time 0 (' // format_point(problem%deck%parameters, points(:n, i)) // &
          '): this acts at once in the first step, and where contacts slip in it already, they slip in one stroke; let tables ' // &
          'begin with the value 0 if this matters')
        exit
      end do
      call tables%destroy()
    end associate
  end subroutine add_sudden_loads

  !> Returns what acts at a state, `loads, overlaps of contact[1] are`; empty where nothing does.
  function sudden_loads(problem, theta) result(text)
    type(problem_t), intent(in) :: problem
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    character(:), allocatable :: text
    integer :: i

    text = ''
    if (any(abs(problem%boundary%forces(theta)) > 0)) text = ', loads'
    if (any(abs(problem%boundary%prescribed_displacement(theta)) > 0)) text = text // ', prescribed displacements'
    associate (gaps => matmul(problem%rows%gap, theta), noise => rounding_of_data * maxval(abs(problem%mesh%coordinates)))
      do i = 1, size(problem%deck%contact)
        if (.not. (problem%deck%contact(i)%has_initial_gap .or. problem%deck%contact(i)%has_obstacle)) cycle
        if (any(gaps < -noise .and. problem%rows%contact_entry == i)) text = text // ', overlaps of contact[' // to_text(i) // ']'
      end do
    end associate
    if (text /= '') text = text(3:) // ' are'
  end function sudden_loads

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
