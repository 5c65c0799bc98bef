! SPDX-License-Identifier: BSD-3-Clause
!> Builds the points of a deck: tensor grids, sequences, lists from CSV files. Writes points as text for people.
module sig_parameter_space
  use sig_deck_config, only: parameter_config_t, point_set_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_latin_hypercube, only: latin_hypercube_points
  use sig_point_list, only: read_points
  use sig_sobol, only: sobol_points
  use sig_text, only: join, short_number, string_t
  implicit none(type, external)
  private
  public :: build_points, format_point

  !> digits that are enough to tell points apart; more would show the rounding of grid values
  integer, parameter :: point_digits = 10

  interface format_point
    procedure format_point_of_deck, format_point_of_names
  end interface format_point

contains

  !> Builds the points that a deck asks for. Requires: the set is a grid, a Sobol sequence, a Latin hypercube or a list (CSV file).
  !>
  !> Grid: the first parameter varies slowest, ends included, value i of n is minimum + (maximum - minimum) * (i - 1) / (n - 1);
  !> a grid of one value takes the minimum. Errors, for a list only: the file is missing or damaged (read_points), or a point is
  !> outside of the box.
  subroutine build_points(point_set, parameters, points, error)
    !> section of the deck that gives the points
    type(point_set_config_t), intent(in) :: point_set
    !> section parameters of the deck
    type(parameter_config_t), intent(in) :: parameters(:)
    !> [unit of each parameter] shape (n_parameters, n_points)
    real(rk), allocatable, intent(out) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    type(string_t) :: names(size(parameters))
    integer :: i_parameter

    if (allocated(point_set%grid)) then
      points = grid_points(point_set%grid, parameters%minimum, parameters%maximum)
    else if (point_set%n_sobol > 0) then
      points = in_box(sobol_points(size(parameters), point_set%n_sobol, point_set%seed), parameters)
    else if (point_set%n_latin_hypercube > 0) then
      points = in_box(latin_hypercube_points(size(parameters), point_set%n_latin_hypercube, point_set%seed), parameters)
    end if
    if (.not. allocated(point_set%path)) return
    do i_parameter = 1, size(parameters)
      names(i_parameter)%text = parameters(i_parameter)%name
    end do
    call read_points(point_set%path, names, points, error, transpose(reshape([parameters%minimum, parameters%maximum], &
      [size(parameters), 2])))
  end subroutine build_points

  !> Maps points from the unit cube into the box of the parameters.
  pure function in_box(fractions, parameters) result(points)
    !> [-] in [0, 1), shape (n_parameters, n_points)
    real(rk), intent(in) :: fractions(:, :)
    type(parameter_config_t), intent(in) :: parameters(:)
    real(rk) :: points(size(fractions, 1), size(fractions, 2))
    integer :: i

    do i = 1, size(fractions, 2)
      points(:, i) = parameters%minimum + fractions(:, i) * (parameters%maximum - parameters%minimum)
    end do
  end function in_box

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

  !> Returns value number i_value_0 (from 0) of n_values from minimum to maximum; the ends are exact.
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

  !> Returns a point as text such as `squeeze = 0.2 m, angle = 3`, for logs and messages; numbers have up to 10 digits.
  pure function format_point_of_deck(parameters, point) result(text)
    type(parameter_config_t), intent(in) :: parameters(:)
    !> in the order of the parameters
    real(rk), intent(in) :: point(:)
    character(:), allocatable :: text
    type(string_t) :: parts(size(parameters))
    integer :: i

    do i = 1, size(parameters)
      parts(i)%text = parameters(i)%name // ' = ' // short_number(point(i), point_digits)
      if (.not. allocated(parameters(i)%unit)) cycle
      if (len(parameters(i)%unit) > 0) parts(i)%text = parts(i)%text // ' ' // parameters(i)%unit
    end do
    text = join(parts, ', ')
  end function format_point_of_deck

  !> Returns a point as text such as `squeeze = 0.2 m, angle = 3`, from names of parameters, with or without units.
  pure function format_point_of_names(names, point, units) result(text)
    type(string_t), intent(in) :: names(:)
    !> in the order of the names
    real(rk), intent(in) :: point(:)
    !> in the order of the names; default: no units
    type(string_t), intent(in), optional :: units(:)
    character(:), allocatable :: text
    type(string_t) :: parts(size(names))
    integer :: i

    do i = 1, size(names)
      parts(i)%text = names(i)%text // ' = ' // short_number(point(i), point_digits)
      if (.not. present(units)) cycle
      if (len(units(i)%text) > 0) parts(i)%text = parts(i)%text // ' ' // units(i)%text
    end do
    text = join(parts, ', ')
  end function format_point_of_names
end module sig_parameter_space
