! SPDX-License-Identifier: BSD-3-Clause
!> Builds the points of a deck: tensor grids, sequences, lists from CSV files. Writes points as text for people.
module sig_parameter_space
  use sig_deck_box, only: in_box, names_of
  use sig_deck_config, only: deck_config_t, parameter_config_t, point_set_config_t
  use sig_errors, only: error_t, make_error
  use sig_history, only: states_of
  use sig_kinds, only: rk
  use sig_latin_hypercube, only: latin_hypercube_points
  use sig_log, only: log_warning
  use sig_point_list, only: read_points
  use sig_rounding, only: rounding
  use sig_sobol, only: sobol_points
  use sig_statistics, only: sort
  use sig_text, only: counted, join, short_number, string_t, to_text
  implicit none(type, external)
  private
  public :: all_points, build_points, build_states, find_states, format_point, point_index

  !> digits that are enough to tell points apart; more would show the rounding of grid values
  integer, parameter :: point_digits = 10

  interface format_point
    procedure format_point_of_deck, format_point_of_names
  end interface format_point

contains

  !> Builds the points that a deck asks for. Requires: the set is a grid, a Sobol sequence, a Latin hypercube or a list (CSV file).
  !>
  !> Grid: the first parameter varies slowest, ends included, value i of n is minimum + (maximum - minimum) * (i - 1) / (n - 1);
  !> a parameter with n = 1 takes the minimum. Of equal points of a list only the first one is taken, with a warning. Errors, for a
  !> list only: those of read_points, such as a missing file, a line that is no point, or a point outside of the box. Local.
  subroutine build_points(point_set, parameters, points, error)
    !> section of the deck that gives the points
    type(point_set_config_t), intent(in) :: point_set
    !> section parameters of the deck
    type(parameter_config_t), intent(in) :: parameters(:)
    !> [unit of each parameter] shape (n_parameters, n_points)
    real(rk), allocatable, intent(out) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error

    if (allocated(point_set%grid)) then
      points = grid_points(point_set%grid, parameters%minimum, parameters%maximum)
    else if (point_set%n_sobol > 0) then
      points = in_box(sobol_points(size(parameters), point_set%n_sobol, point_set%seed), parameters)
    else if (point_set%n_latin_hypercube > 0) then
      points = in_box(latin_hypercube_points(size(parameters), point_set%n_latin_hypercube, point_set%seed), parameters)
    end if
    if (.not. allocated(point_set%path)) return
    call read_points(point_set%path, names_of(parameters), points, error, &
      transpose(reshape([parameters%minimum, parameters%maximum], [size(parameters), 2])))
    if (allocated(error)) return
    call drop_repeats(point_set%path, points)
  end subroutine build_points

  !> Builds the states that a deck asks for: those of all points of a set. Errors: those of build_points and find_states.
  subroutine build_states(deck, point_set, states, error)
    type(deck_config_t), intent(in) :: deck
    !> a section of this deck
    type(point_set_config_t), intent(in) :: point_set
    !> shape (size(deck%state_parameters), n_states)
    real(rk), allocatable, intent(out) :: states(:, :)
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: points(:, :)

    call build_points(point_set, deck%parameters, points, error)
    if (.not. allocated(error)) call find_states(deck, points, states, error)
  end subroutine build_states

  !> Finds the states of points: without a history the points themselves, otherwise all times of the first point, then those of the
  !> second one, and so on. Errors: a table of the history has no finite values at a point, or its times do not ascend there.
  subroutine find_states(deck, points, states, error)
    type(deck_config_t), intent(in) :: deck
    !> shape (size(deck%parameters), n_points)
    real(rk), intent(in) :: points(:, :)
    !> shape (size(deck%state_parameters), n_states)
    real(rk), allocatable, intent(out) :: states(:, :)
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: fault
    integer :: i_bad_point

    call states_of(deck%history%states, names_of(deck%parameters), points, states, i_bad_point, fault)
    if (allocated(fault)) call make_error(error, fault // ' at ' // format_point(deck%parameters, points(:, i_bad_point)), &
      deck%path)
  end subroutine find_states

  !> Keeps the first of equal points (point_index), and warns if it left points out.
  subroutine drop_repeats(path, points)
    !> path of the list, for the warning
    character(*), intent(in) :: path
    real(rk), allocatable, intent(inout) :: points(:, :)
    integer :: n_listed

    n_listed = size(points, 2)
    points = all_points(points(:, :0), points)
    if (size(points, 2) < n_listed) call log_warning(path // ' lists ' // counted(n_listed, 'point') // &
      '; left out, because they repeat others: ' // to_text(n_listed - size(points, 2)))
  end subroutine drop_repeats

  !> Returns the number of a point that equals the given one in each parameter up to rounding, that is, up to 1e-12 of the larger of
  !> both values; 0 if there is none. Of several such points it is the first one in the order of the search.
  pure integer function point_index(points, point, i_before) result(i_point)
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    real(rk), intent(in) :: point(:)
    !> >= 0; the search starts behind this number and goes on at the first point: records come nearly in the order of the points
    integer, intent(in) :: i_before
    integer :: i

    do i = 0, size(points, 2) - 1
      i_point = modulo(i_before + i, size(points, 2)) + 1
      if (all(abs(points(:, i_point) - point) <= rounding * max(abs(points(:, i_point)), abs(point)))) return
    end do
    i_point = 0
  end function point_index

  !> Returns all given points, also equal ones, and, behind them, the known points that are not among them, each once, in their
  !> order. Points that differ by rounding only (point_index) are the same.
  pure function all_points(points, known) result(all)
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> may hold a point several times; shape (n_parameters, n_known)
    real(rk), intent(in) :: known(:, :)
    real(rk), allocatable :: all(:, :)
    real(rk) :: weights(size(points, 1)), keys(size(points, 2) + size(known, 2)), tolerance
    logical :: is_kept(size(keys))
    integer :: order(size(keys)), i, j, later

    allocate (all(size(points, 1), size(keys)))
    all(:, :size(points, 2)) = points
    all(:, size(points, 2) + 1:) = known
    ! equal points have nearly equal keys, so only neighbors in the order of the keys are compared
    weights = sqrt(real([(i + 1, i=1, size(weights))], rk))
    tolerance = 1.0e-11_rk * sum(weights)
    keys = matmul(weights / max(maxval(abs(all), dim=2), tiny(1.0_rk)), all)
    order = [(i, i=1, size(keys))]
    call sort(keys, order)
    is_kept = .true.
    do i = 2, size(keys)
      do j = i - 1, 1, -1
        if (keys(i) - keys(j) > tolerance) exit
        later = max(order(i), order(j))
        if (later <= size(points, 2)) cycle
        if (point_index(all(:, order(i:i)), all(:, order(j)), 0) > 0) is_kept(later) = .false.
      end do
    end do
    all = all(:, pack([(i, i=1, size(keys))], is_kept))
  end function all_points

  pure function grid_points(n_values, minima, maxima) result(points)
    !> shape (n_parameters)
    integer, intent(in) :: n_values(:)
    real(rk), intent(in) :: minima(:)
    real(rk), intent(in) :: maxima(:)
    real(rk), allocatable :: points(:, :)
    integer :: i_parameter, i_point, i_rest

    allocate (points(size(n_values), product(n_values)))
    do i_point = 1, size(points, 2)
      i_rest = i_point - 1
      do i_parameter = size(n_values), 1, -1
        associate (n => n_values(i_parameter))
          points(i_parameter, i_point) = grid_value(modulo(i_rest, n), n, minima(i_parameter), maxima(i_parameter))
          i_rest = i_rest / n
        end associate
      end do
    end do
  end function grid_points

  !> Returns value number i_value_0 (from 0) of n_values from minimum to maximum; the ends are exact. One value is the minimum.
  pure real(rk) function grid_value(i_value_0, n_values, minimum, maximum) result(value)
    integer, intent(in) :: i_value_0
    integer, intent(in) :: n_values
    real(rk), intent(in) :: minimum
    real(rk), intent(in) :: maximum

    value = minimum
    if (n_values == 1) return
    value = minimum + (maximum - minimum) * i_value_0 / (n_values - 1)
    if (i_value_0 == n_values - 1) value = maximum
  end function grid_value

  !> Returns a point as text such as `squeeze = 0.2 m, angle = 3`, for logs and messages; numbers have up to 10 digits. A parameter
  !> without a unit in the deck has none here.
  pure function format_point_of_deck(parameters, point) result(text)
    type(parameter_config_t), intent(in) :: parameters(:)
    !> in the order of the parameters
    real(rk), intent(in) :: point(:)
    character(:), allocatable :: text
    type(string_t) :: parts(size(parameters))
    integer :: i

    do i = 1, size(parameters)
      parts(i)%text = parameters(i)%name // ' = ' // short_number(point(i), point_digits)
      if (allocated(parameters(i)%unit)) parts(i)%text = parts(i)%text // behind_number(parameters(i)%unit)
    end do
    text = join(parts, ', ')
  end function format_point_of_deck

  !> Returns a point as text such as `squeeze = 0.2 m, angle = 3`, from names of parameters, with or without units; numbers have up
  !> to 10 digits.
  pure function format_point_of_names(names, point, units) result(text)
    type(string_t), intent(in) :: names(:)
    !> in the order of the names
    real(rk), intent(in) :: point(:)
    !> in the order of the names; an empty text, `1` and `-` are left out; default: no units
    type(string_t), intent(in), optional :: units(:)
    character(:), allocatable :: text
    type(string_t) :: parts(size(names))
    integer :: i

    do i = 1, size(names)
      parts(i)%text = names(i)%text // ' = ' // short_number(point(i), point_digits)
      if (present(units)) parts(i)%text = parts(i)%text // behind_number(units(i)%text)
    end do
    text = join(parts, ', ')
  end function format_point_of_names

  !> Returns a unit with a blank before it; empty for the units of a number without dimension: none, `1` and `-`.
  pure function behind_number(unit) result(text)
    character(*), intent(in) :: unit
    character(:), allocatable :: text

    text = ''
    if (unit /= '' .and. unit /= '1' .and. unit /= '-') text = ' ' // unit
  end function behind_number
end module sig_parameter_space
