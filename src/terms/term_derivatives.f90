! SPDX-License-Identifier: BSD-3-Clause
!> Derivatives of the terms with respect to the parameters.
!>
!> The texts of the terms are known to muParser alone, so they are evaluated beside the point: four values per parameter give the
!> derivative to the fourth order, about 1e-12 of the variation over the box. Where the slopes of both sides differ from it, the
!> steps are made smaller. At the last step the limits of both sides count. Where these are the same, only the curvature jumps, as
!> where the end of a window passes a node. Where they differ, the point is a kink (of min, max, abs, a condition, a window). The
!> slope is then that of the side that was asked for.
module sig_term_derivatives
  use sig_kinds, only: rk
  use sig_term_values, only: term_values_t
  implicit none(type, external)
  private
  public :: differentiate_terms

  !> [-] steps as shares of a side of the box, the first one that serves
  real(rk), parameter :: steps(4) = [1.0e-3_rk, 1.0e-4_rk, 1.0e-5_rk, 1.0e-6_rk]
  !> [-] slopes that differ by less than this share of themselves are the same
  real(rk), parameter :: same_slope = 1.0e-6_rk
  !> [-] rounding of a term's value, as a share of its scale
  real(rk), parameter :: rounding = 1.0e-14_rk

contains

  !> Derivatives at a point, one parameter after the other.
  subroutine differentiate_terms(terms, point, theta, lengths, direction, derivatives, is_kink, i_failed)
    type(term_values_t), intent(inout) :: terms
    !> values of the parameters, where all terms have finite values; shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> the terms there, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> sides of the box, positive, in the units of the parameters
    real(rk), intent(in) :: lengths(:)
    !> +1: the slope towards larger values of each parameter counts at kinks; -1: towards smaller ones
    integer, intent(in) :: direction
    !> [per unit of a parameter] shape (n_terms, n_parameters)
    real(rk), contiguous, intent(inout) :: derivatives(:, :)
    !> the slopes on both sides differ; shape (n_parameters)
    logical, intent(out) :: is_kink(:)
    !> first parameter over which a term has no slope, because it jumps or has no value beside the point; 0 = none
    integer, intent(out) :: i_failed
    integer :: i
    logical :: is_found

    i_failed = 0
    is_kink = .false.
    do i = 1, size(point)
      call differentiate(terms, point, theta, i, lengths(i), direction, derivatives(:, i), is_kink(i), is_found)
      if (.not. is_found .and. i_failed == 0) i_failed = i
    end do
  end subroutine differentiate_terms

  !> Derivatives of all terms over one parameter.
  subroutine differentiate(terms, point, theta, i_parameter, length, direction, slopes, is_kink, is_found)
    type(term_values_t), intent(inout) :: terms
    real(rk), intent(in) :: point(:)
    real(rk), intent(in) :: theta(:)
    integer, intent(in) :: i_parameter
    real(rk), intent(in) :: length
    integer, intent(in) :: direction
    real(rk), contiguous, intent(inout) :: slopes(:)
    logical, intent(out) :: is_kink
    logical, intent(out) :: is_found
    real(rk) :: values(size(slopes), -2:2), sides(size(slopes), -1:1, size(steps))
    real(rk), dimension(size(slopes)) :: noise, scales
    logical :: has_side(-1:1), is_open(size(slopes)), is_same(size(slopes))
    integer :: i

    values(:, 0) = theta
    is_open = .true.
    scales = 0
    do i = 1, size(steps)
      call evaluate_beside(terms, point, i_parameter, steps(i) * length, values, has_side)
      scales = max(scales, terms%scales(maxval(abs(values), dim=2)))
      noise = rounding * scales / (steps(i) * length)
      sides(:, -1, i) = slope_of_side(values, -1, steps(i) * length)
      sides(:, 1, i) = slope_of_side(values, 1, steps(i) * length)
      sides(:, 0, i) = central_slope(values, steps(i) * length)
      is_same = are_same(sides(:, :, i), noise)
      if (.not. (has_side(-1) .and. has_side(1))) is_same = .false.
      where (is_open .and. is_same) slopes = sides(:, 0, i)
      is_open = is_open .and. .not. is_same
      if (.not. any(is_open)) exit
    end do
    is_kink = .false.
    is_found = .true.
    if (any(is_open)) call take_limits(sides, has_side, noise, is_open, direction, slopes, is_kink, is_found)
  end subroutine differentiate

  !> The limits of the slopes on both sides: their mean where they are the same, else that of the side that was asked for.
  pure subroutine take_limits(sides, has_side, noise, is_open, direction, slopes, is_kink, is_found)
    !> slopes below, in the middle and above at all steps, shape (n_terms, 3, n_steps)
    real(rk), intent(in) :: sides(:, -1:, :)
    logical, intent(in) :: has_side(-1:)
    !> [per unit of the parameter] rounding of a slope at the last step, shape (n_terms)
    real(rk), intent(in) :: noise(:)
    !> terms that have no slope yet, shape (n_terms)
    logical, intent(in) :: is_open(:)
    integer, intent(in) :: direction
    real(rk), intent(inout) :: slopes(:)
    logical, intent(out) :: is_kink
    logical, intent(out) :: is_found
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
    is_found = all(has_limit(:, direction) .or. is_smooth .or. .not. is_open)
  end subroutine take_limits

  !> Where the slopes of one side go as the step goes to 0. Their errors are of second order, so that those of the last two steps,
  !> one of which is a tenth of the other, give the limit. There is none where they do not settle: at a jump, or under a root.
  pure subroutine find_limits(slopes, noise, limits, has_limit)
    !> shape (n_terms, n_steps)
    real(rk), intent(in) :: slopes(:, :)
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

  !> The terms at steps -2 to 2 but at 0, where they are known.
  subroutine evaluate_beside(terms, point, i_parameter, step, values, has_side)
    type(term_values_t), intent(inout) :: terms
    real(rk), intent(in) :: point(:)
    integer, intent(in) :: i_parameter
    real(rk), intent(in) :: step
    !> shape (n_terms, 5); zero where has_side says no
    real(rk), contiguous, intent(inout) :: values(:, -2:)
    !> all terms have finite values on this side
    logical, intent(out) :: has_side(-1:)
    real(rk) :: place(size(point))
    integer :: i, i_source
    logical :: is_valid

    has_side = .true.
    do i = -2, 2
      if (i == 0) cycle
      place = point
      place(i_parameter) = point(i_parameter) + i * step
      call terms%evaluate(place, values(:, i), is_valid, i_source)
      if (.not. is_valid) has_side(sign(1, i)) = .false.
    end do
    if (.not. has_side(-1)) values(:, -2:-1) = 0
    if (.not. has_side(1)) values(:, 1:2) = 0
  end subroutine evaluate_beside

  !> The slopes of both sides are that of the middle, but for rounding.
  pure function are_same(sides, noise)
    !> slopes below, in the middle and above, shape (n_terms, 3)
    real(rk), intent(in) :: sides(:, -1:)
    real(rk), intent(in) :: noise(:)
    logical :: are_same(size(sides, 1))

    associate (below => sides(:, -1), middle => sides(:, 0), above => sides(:, 1))
      are_same = max(abs(above - middle), abs(below - middle)) <= same_slope * max(abs(above), abs(below)) + noise
    end associate
  end function are_same

  !> Slopes from the values on one side: (-3 f_0 + 4 f_1 - f_2) / 2h.
  pure function slope_of_side(values, side, step) result(slopes)
    real(rk), intent(in) :: values(:, -2:)
    integer, intent(in) :: side
    real(rk), intent(in) :: step
    real(rk) :: slopes(size(values, 1))

    slopes = side * (4 * (values(:, side) - values(:, 0)) - (values(:, 2 * side) - values(:, 0))) / (2 * step)
  end function slope_of_side

  !> (f_-2 - 8 f_-1 + 8 f_1 - f_2) / 12h.
  pure function central_slope(values, step) result(slopes)
    real(rk), intent(in) :: values(:, -2:)
    real(rk), intent(in) :: step
    real(rk) :: slopes(size(values, 1))

    slopes = (8 * (values(:, 1) - values(:, -1)) - (values(:, 2) - values(:, -2))) / (12 * step)
  end function central_slope
end module sig_term_derivatives
