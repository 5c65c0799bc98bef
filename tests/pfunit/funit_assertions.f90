! SPDX-License-Identifier: BSD-3-Clause
!> The assertions; names and arguments are those of pFUnit 4, so that a .pf file works with either.
module funit_assertions
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
  use, intrinsic :: iso_fortran_env, only: real64
  use funit_exceptions, only: SourceLocation, throw
  use funit_values, only: index_text, to_text
  implicit none(type, external)
  private
  public :: assertFail, assertTrue, assertFalse
  public :: assertLessThan, assertLessThanOrEqual, assertGreaterThan, assertGreaterThanOrEqual
  public :: assertIsFinite, assertIsNaN

  interface assertTrue
    procedure assert_true_scalar, assert_true_vector
  end interface assertTrue
  interface assertFalse
    procedure assert_false_scalar, assert_false_vector
  end interface assertFalse
  interface assertLessThan
    procedure assert_less_integer, assert_less_real
  end interface assertLessThan
  interface assertLessThanOrEqual
    procedure assert_at_most_integer, assert_at_most_real
  end interface assertLessThanOrEqual
  interface assertGreaterThan
    procedure assert_greater_integer, assert_greater_real
  end interface assertGreaterThan
  interface assertGreaterThanOrEqual
    procedure assert_at_least_integer, assert_at_least_real
  end interface assertGreaterThanOrEqual

contains

  !> Fails always.
  subroutine assertFail(message, location)
    character(*), intent(in) :: message
    type(SourceLocation), intent(in), optional :: location

    call throw('reached a line that must not be reached', message, location)
  end subroutine assertFail

  subroutine assert_true_scalar(condition, message, location)
    logical, intent(in) :: condition
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. condition) call throw('expected true, got false', message, location)
  end subroutine assert_true_scalar

  subroutine assert_true_vector(condition, message, location)
    logical, intent(in) :: condition(:)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (all(condition)) return
    call throw('expected true, got false' // index_text(findloc(condition, .false., 1), shape(condition)), message, location)
  end subroutine assert_true_vector

  subroutine assert_false_scalar(condition, message, location)
    logical, intent(in) :: condition
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (condition) call throw('expected false, got true', message, location)
  end subroutine assert_false_scalar

  subroutine assert_false_vector(condition, message, location)
    logical, intent(in) :: condition(:)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. any(condition)) return
    call throw('expected false, got true' // index_text(findloc(condition, .true., 1), shape(condition)), message, location)
  end subroutine assert_false_vector

  subroutine assert_less_integer(lhs, rhs, message, location)
    integer, intent(in) :: lhs
    integer, intent(in) :: rhs
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. lhs < rhs) call throw_order(to_text(lhs), '<', to_text(rhs), message, location)
  end subroutine assert_less_integer

  subroutine assert_less_real(lhs, rhs, message, location)
    real(real64), intent(in) :: lhs
    real(real64), intent(in) :: rhs
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. lhs < rhs) call throw_order(to_text(lhs), '<', to_text(rhs), message, location)
  end subroutine assert_less_real

  subroutine assert_at_most_integer(lhs, rhs, message, location)
    integer, intent(in) :: lhs
    integer, intent(in) :: rhs
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. lhs <= rhs) call throw_order(to_text(lhs), '<=', to_text(rhs), message, location)
  end subroutine assert_at_most_integer

  subroutine assert_at_most_real(lhs, rhs, message, location)
    real(real64), intent(in) :: lhs
    real(real64), intent(in) :: rhs
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. lhs <= rhs) call throw_order(to_text(lhs), '<=', to_text(rhs), message, location)
  end subroutine assert_at_most_real

  subroutine assert_greater_integer(lhs, rhs, message, location)
    integer, intent(in) :: lhs
    integer, intent(in) :: rhs
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. lhs > rhs) call throw_order(to_text(lhs), '>', to_text(rhs), message, location)
  end subroutine assert_greater_integer

  subroutine assert_greater_real(lhs, rhs, message, location)
    real(real64), intent(in) :: lhs
    real(real64), intent(in) :: rhs
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. lhs > rhs) call throw_order(to_text(lhs), '>', to_text(rhs), message, location)
  end subroutine assert_greater_real

  subroutine assert_at_least_integer(lhs, rhs, message, location)
    integer, intent(in) :: lhs
    integer, intent(in) :: rhs
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. lhs >= rhs) call throw_order(to_text(lhs), '>=', to_text(rhs), message, location)
  end subroutine assert_at_least_integer

  subroutine assert_at_least_real(lhs, rhs, message, location)
    real(real64), intent(in) :: lhs
    real(real64), intent(in) :: rhs
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. lhs >= rhs) call throw_order(to_text(lhs), '>=', to_text(rhs), message, location)
  end subroutine assert_at_least_real

  !> Every entry is a number below infinity in size.
  subroutine assertIsFinite(x, message, location)
    real(real64), intent(in) :: x
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. ieee_is_finite(x)) call throw('expected a finite number, got ' // to_text(x), message, location)
  end subroutine assertIsFinite

  subroutine assertIsNaN(x, message, location)
    real(real64), intent(in) :: x
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (.not. ieee_is_nan(x)) call throw('expected NaN, got ' // to_text(x), message, location)
  end subroutine assertIsNaN

  subroutine throw_order(lhs, relation, rhs, message, location)
    character(*), intent(in) :: lhs
    character(*), intent(in) :: relation
    character(*), intent(in) :: rhs
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    call throw('expected ' // lhs // ' ' // relation // ' ' // rhs, message, location)
  end subroutine throw_order
end module funit_assertions
