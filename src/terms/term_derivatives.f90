! SPDX-License-Identifier: BSD-3-Clause
!> Derivatives of the terms with respect to the parameters.
!>
!> The texts of the terms are known to muParser alone, so they are evaluated beside the point: four values per parameter give the
!> derivative to the fourth order, about 1e-12 of the variation over the box. Where the slopes on both sides differ, the steps are
!> made smaller; where they still differ, the point is a kink (of min, max, abs, a condition, a window) and the slope is that of the
!> side that was asked for.
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
  !> [-] rounding of a term's value
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
    real(rk) :: values(size(slopes), -2:2)
    logical :: has_side(-1:1), is_open(size(slopes)), is_same(size(slopes))
    integer :: i

    values(:, 0) = theta
    is_open = .true.
    do i = 1, size(steps)
      call evaluate_beside(terms, point, i_parameter, steps(i) * length, values, has_side)
      is_same = are_same(values, steps(i) * length)
      if (.not. (has_side(-1) .and. has_side(1))) is_same = .false.
      where (is_open .and. is_same) slopes = central_slope(values, steps(i) * length)
      is_open = is_open .and. .not. is_same
      if (.not. any(is_open)) exit
    end do
    is_kink = any(is_open)
    is_found = .true.
    if (.not. is_kink) return
    call take_side(terms, point, theta, i_parameter, length, direction, is_open, slopes, is_found)
  end subroutine differentiate

  !> The slopes of one side where those of both differ: they do not depend on the step.
  subroutine take_side(terms, point, theta, i_parameter, length, direction, is_open, slopes, is_found)
    type(term_values_t), intent(inout) :: terms
    real(rk), intent(in) :: point(:)
    real(rk), intent(in) :: theta(:)
    integer, intent(in) :: i_parameter
    real(rk), intent(in) :: length
    integer, intent(in) :: direction
    !> terms that have no slope yet
    logical, intent(in) :: is_open(:)
    real(rk), contiguous, intent(inout) :: slopes(:)
    logical, intent(out) :: is_found
    real(rk) :: coarse(size(slopes)), fine(size(slopes)), noise(size(slopes)), values(size(slopes), -2:2)
    logical :: has_side(-1:1)

    values(:, 0) = theta
    call evaluate_beside(terms, point, i_parameter, 10 * steps(size(steps)) * length, values, has_side)
    coarse = slope_of_side(values, direction, 10 * steps(size(steps)) * length)
    call evaluate_beside(terms, point, i_parameter, steps(size(steps)) * length, values, has_side)
    fine = slope_of_side(values, direction, steps(size(steps)) * length)
    noise = rounding * maxval(abs(values), dim=2) / (steps(size(steps)) * length)
    is_found = has_side(direction) .and. &
      all(.not. is_open .or. abs(fine - coarse) <= 1.0e-3_rk * max(abs(fine), abs(coarse)) + noise)
    where (is_open) slopes = fine
  end subroutine take_side

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
  pure function are_same(values, step)
    real(rk), intent(in) :: values(:, -2:)
    real(rk), intent(in) :: step
    logical :: are_same(size(values, 1))
    real(rk), dimension(size(values, 1)) :: below, above, middle

    below = slope_of_side(values, -1, step)
    above = slope_of_side(values, 1, step)
    middle = central_slope(values, step)
    are_same = max(abs(above - middle), abs(below - middle)) <= same_slope * max(abs(above), abs(below)) + &
      rounding * maxval(abs(values), dim=2) / step
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
