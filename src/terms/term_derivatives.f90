! SPDX-License-Identifier: BSD-3-Clause
!> Derivatives of the terms with respect to the parameters.
!>
!> The terms are texts that only muParser can evaluate, so the derivatives are finite differences. Per parameter the terms are
!> evaluated at two places on each side of the point. These four values give a derivative of fourth order, with an error of about
!> 1e-12 of the variation over the box. The values of each side alone give a slope of second order, too.
!>
!> Where the slopes of both sides equal the derivative, it is accepted. Elsewhere the step is made smaller. Where no step serves,
!> the slopes of each side are extrapolated to the step 0. If both limits are the same, they are the derivative: only the curvature
!> jumps, for example where the end of a window passes a node. If they differ, the point is a kink (of min, max, abs, a condition, a
!> window), and the derivative is the limit of the side that the caller asks for.
module sig_term_derivatives
  use sig_history, only: table_values_t
  use sig_kinds, only: rk
  use sig_term_values, only: term_values_t
  implicit none(type, external)
  private
  public :: differentiate_terms, term_failure_t

  !> [-] steps as fractions of a side of the box; they are tried in this order
  real(rk), parameter :: steps(4) = [1.0e-3_rk, 1.0e-4_rk, 1.0e-5_rk, 1.0e-6_rk]
  !> [-] largest relative difference of two slopes that count as equal
  real(rk), parameter :: same_slope = 1.0e-6_rk
  !> [-] rounding error of the value of a term, relative to its size from term_values_t%scales
  real(rk), parameter :: rounding = 1.0e-14_rk

  !> What has no derivative; all numbers are 1-based.
  type :: term_failure_t
    !> first parameter over which a term has none; 0 = there is none
    integer :: i_parameter = 0
    !> first term that jumps or has an infinite slope; 0 if a value is missing
    integer :: i_term = 0
    !> source that has no finite value beside the point; 0 = none
    integer :: i_source = 0
  end type term_failure_t

contains

  !> Computes the derivatives of all terms with respect to all parameters at one point.
  !>
  !> If some derivative does not exist, failure%i_parameter is not 0, and `derivatives` is of no use.
  subroutine differentiate_terms(terms, point, theta, lengths, direction, derivatives, is_kink, failure, tables)
    type(term_values_t), intent(inout) :: terms
    !> values of the parameters, shape (n_parameters); all terms must have finite values there
    real(rk), intent(in) :: point(:)
    !> values of the terms at this point, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [unit of each parameter] lengths > 0 that the steps are fractions of, such as the sides of the box; shape (n_parameters)
    real(rk), intent(in) :: lengths(:)
    !> which slope to take at a kink: +1 = towards larger values of the parameter, -1 = towards smaller ones
    integer, intent(in) :: direction
    !> [per unit of a parameter] shape (n_terms, n_parameters)
    real(rk), contiguous, intent(inout) :: derivatives(:, :)
    !> whether some term has different slopes on both sides, or lacks a slope on one or both; shape (n_parameters)
    logical, intent(out) :: is_kink(:)
    !> the first parameter over which a term has no derivative towards `direction`, because the term jumps, has an infinite slope,
    !> or has no finite value beside the point
    type(term_failure_t), intent(out) :: failure
    !> tables of a history, begun: the values of the point behind the time are theirs and change with the parameters and the time;
    !> default: each value of the point stands for itself
    type(table_values_t), intent(inout), optional :: tables
    type(term_failure_t) :: found
    integer :: i

    is_kink = .false.
    do i = 1, size(point)
      call differentiate(terms, point, theta, i, lengths(i), direction, derivatives(:, i), is_kink(i), found, tables)
      if (found%i_parameter > 0 .and. failure%i_parameter == 0) failure = found
    end do
  end subroutine differentiate_terms

  !> Computes the derivatives of all terms with respect to one parameter. is_kink: see take_limits; failure: one does not exist.
  !> Other arguments as in differentiate_terms.
  subroutine differentiate(terms, point, theta, i_parameter, length, direction, slopes, is_kink, failure, tables)
    type(term_values_t), intent(inout) :: terms
    real(rk), intent(in) :: point(:)
    real(rk), intent(in) :: theta(:)
    integer, intent(in) :: i_parameter
    real(rk), intent(in) :: length
    integer, intent(in) :: direction
    !> [per unit of the parameter] shape (n_terms)
    real(rk), contiguous, intent(inout) :: slopes(:)
    logical, intent(out) :: is_kink
    type(term_failure_t), intent(out) :: failure
    type(table_values_t), intent(inout), optional :: tables
    real(rk) :: values(size(slopes), -2:2), sides(size(slopes), -1:1, size(steps))
    real(rk), dimension(size(slopes)) :: noise, scales
    logical :: is_open(size(slopes)), is_same(size(slopes))
    integer :: i, i_term, missing(-1:1)

    values(:, 0) = theta
    is_open = .true.
    scales = 0
    do i = 1, size(steps)
      call evaluate_beside(terms, point, i_parameter, steps(i) * length, values, missing, tables)
      scales = max(scales, terms%scales(maxval(abs(values), dim=2)))
      noise = rounding * scales / (steps(i) * length)
      sides(:, -1, i) = slope_of_side(values, -1, steps(i) * length)
      sides(:, 1, i) = slope_of_side(values, 1, steps(i) * length)
      sides(:, 0, i) = central_slope(values, steps(i) * length)
      is_same = are_same(sides(:, :, i), noise)
      if (any(missing > 0)) is_same = .false.
      where (is_open .and. is_same) slopes = sides(:, 0, i)
      is_open = is_open .and. .not. is_same
      if (.not. any(is_open)) exit
    end do
    is_kink = .false.
    if (.not. any(is_open)) return
    call take_limits(sides, missing == 0, noise, is_open, direction, slopes, is_kink, i_term)
    if (i_term == 0) return
    failure%i_parameter = i_parameter
    failure%i_source = missing(direction)
    if (failure%i_source == 0) failure%i_term = i_term
  end subroutine differentiate

  !> Sets the slopes that are still open: the mean of the limits on both sides where both exist and differ by at most 1e-6 of the
  !> larger one plus `noise`, else the limit on the side `direction`. is_kink: the second case occurs.
  pure subroutine take_limits(sides, has_side, noise, is_open, direction, slopes, is_kink, i_failed)
    !> slopes below, central slopes and slopes above at all steps, shape (n_terms, 3, n_steps)
    real(rk), intent(in) :: sides(:, -1:, :)
    !> whether the terms have finite values below and above at the last step
    logical, intent(in) :: has_side(-1:)
    !> [per unit of the parameter] rounding error of a slope at the last step, shape (n_terms)
    real(rk), intent(in) :: noise(:)
    !> terms that have no slope yet, shape (n_terms)
    logical, intent(in) :: is_open(:)
    integer, intent(in) :: direction
    !> in: slopes of the terms that are not open; out: all
    real(rk), intent(inout) :: slopes(:)
    logical, intent(out) :: is_kink
    !> first term without a limit that is needed, 1-based; 0 = none
    integer, intent(out) :: i_failed
    real(rk) :: limits(size(slopes), -1:1)
    logical :: has_limit(size(slopes), -1:1), is_smooth(size(slopes))
    integer :: side

    has_limit = .false.
    do side = -1, 1, 2
      call find_limits(sides(:, side, :), noise, limits(:, side), has_limit(:, side))
      has_limit(:, side) = has_limit(:, side) .and. has_side(side)
    end do
    associate (below => limits(:, -1), above => limits(:, 1))
      is_smooth = has_limit(:, -1) .and. has_limit(:, 1) .and. &
        abs(above - below) <= same_slope * max(abs(above), abs(below)) + noise
      where (is_open .and. is_smooth) slopes = (above + below) / 2
    end associate
    where (is_open .and. .not. is_smooth) slopes = limits(:, direction)
    is_kink = any(is_open .and. .not. is_smooth)
    i_failed = findloc(is_open .and. .not. (has_limit(:, direction) .or. is_smooth), .true., dim=1)
  end subroutine take_limits

  !> Extrapolates the slopes of one side to the step 0. Their errors are of second order, and the last step is a tenth of the one
  !> before it, so the last two slopes give the limit. There is no limit where the slopes do not converge (at a jump, or at a root
  !> of infinite slope): the last one changes by more than 1e-3 of the larger of both plus `noise`, and by more than half of the
  !> change before.
  pure subroutine find_limits(slopes, noise, limits, has_limit)
    !> shape (n_terms, n_steps)
    real(rk), intent(in) :: slopes(:, :)
    !> [per unit of the parameter] rounding error of a slope, shape (n_terms)
    real(rk), intent(in) :: noise(:)
    real(rk), intent(out) :: limits(:)
    logical, intent(out) :: has_limit(:)
    real(rk), dimension(size(limits)) :: change, change_before
    integer :: n

    n = size(slopes, 2)
    change = abs(slopes(:, n) - slopes(:, n - 1))
    change_before = abs(slopes(:, n - 1) - slopes(:, n - 2))
    has_limit = change <= 1.0e-3_rk * max(abs(slopes(:, n)), abs(slopes(:, n - 1))) + noise .or. change <= change_before / 2
    limits = slopes(:, n) + (slopes(:, n) - slopes(:, n - 1)) / 99
  end subroutine find_limits

  !> Evaluates the terms at the steps -2, -1, 1 and 2 from the point, along one parameter. The values at 0 stay as they are.
  subroutine evaluate_beside(terms, point, i_parameter, step, values, missing, tables)
    type(term_values_t), intent(inout) :: terms
    real(rk), intent(in) :: point(:)
    integer, intent(in) :: i_parameter
    !> [unit of the parameter] > 0
    real(rk), intent(in) :: step
    !> values of the terms at the steps -2 to 2, shape (n_terms, 5); in: step 0; out: also the others. If any value on a side is
    !> missing, both columns of this side are 0 for all terms
    real(rk), contiguous, intent(inout) :: values(:, -2:)
    !> a source without a finite value on the side -1 and on the side 1, 1-based; 0 = none
    integer, intent(out) :: missing(-1:)
    type(table_values_t), intent(inout), optional :: tables
    real(rk) :: place(size(point))
    integer :: i, i_source
    logical :: is_valid

    missing = 0
    do i = -2, 2
      if (i == 0) cycle
      place = point
      place(i_parameter) = point(i_parameter) + i * step
      is_valid = .true.
      i_source = 1
      if (present(tables)) call follow_tables(tables, i_parameter, place, is_valid)
      if (is_valid) call terms%evaluate(place, values(:, i), is_valid, i_source)
      if (.not. is_valid) missing(sign(1, i)) = i_source
    end do
    if (missing(-1) > 0) values(:, -2:-1) = 0
    if (missing(1) > 0) values(:, 1:2) = 0
  end subroutine evaluate_beside

  !> Sets the values behind the time to those of the tables, unless it is one of them that was moved. is_valid: the tables are.
  subroutine follow_tables(tables, i_parameter, place, is_valid)
    type(table_values_t), intent(inout) :: tables
    !> the value that was moved
    integer, intent(in) :: i_parameter
    !> parameters, time, values of the tables
    real(rk), intent(inout) :: place(:)
    logical, intent(out) :: is_valid
    character(:), allocatable :: fault
    integer :: i_table, n

    is_valid = .true.
    n = size(place) - tables%n_values()
    if (i_parameter > n + 1) return
    call tables%begin(place(:n), i_table, fault)
    is_valid = i_table == 0
    if (is_valid) place(n + 1:) = tables%at(place(n + 1))
  end subroutine follow_tables

  !> Whether the slopes of both sides differ from the central slope by at most 1e-6 of the larger one plus `noise`, for each term.
  pure function are_same(sides, noise)
    !> slopes below, central slopes and slopes above, shape (n_terms, 3)
    real(rk), intent(in) :: sides(:, -1:)
    !> [per unit of the parameter] rounding error of a slope, shape (n_terms)
    real(rk), intent(in) :: noise(:)
    logical :: are_same(size(sides, 1))

    associate (below => sides(:, -1), middle => sides(:, 0), above => sides(:, 1))
      are_same = max(abs(above - middle), abs(below - middle)) <= same_slope * max(abs(above), abs(below)) + noise
    end associate
  end function are_same

  !> Returns the slopes from the values on one side: (-3 f_0 + 4 f_1 - f_2) / 2h, where h = side * step, and f_i is the value at i
  !> h.
  pure function slope_of_side(values, side, step) result(slopes)
    !> values of the terms at the steps -2 to 2, shape (n_terms, 5)
    real(rk), intent(in) :: values(:, -2:)
    !> -1 or 1
    integer, intent(in) :: side
    !> [unit of the parameter] > 0
    real(rk), intent(in) :: step
    real(rk) :: slopes(size(values, 1))

    slopes = side * (4 * (values(:, side) - values(:, 0)) - (values(:, 2 * side) - values(:, 0))) / (2 * step)
  end function slope_of_side

  !> Returns the slopes from the values on both sides: (f_-2 - 8 f_-1 + 8 f_1 - f_2) / 12h, where h = step, and f_i is the value at
  !> i h.
  pure function central_slope(values, step) result(slopes)
    !> values of the terms at the steps -2 to 2, shape (n_terms, 5)
    real(rk), intent(in) :: values(:, -2:)
    !> [unit of the parameter]
    real(rk), intent(in) :: step
    real(rk) :: slopes(size(values, 1))

    slopes = (8 * (values(:, 1) - values(:, -1)) - (values(:, 2) - values(:, -2))) / (12 * step)
  end function central_slope
end module sig_term_derivatives
