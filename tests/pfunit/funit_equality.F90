! SPDX-License-Identifier: BSD-3-Clause
!> assertEqual, assertNotEqual and assertRelativelyEqual for numbers (scalar, vector, matrix) and texts.
!>
!> A scalar may be expected of each entry of an array. As in pFUnit: no tolerance means exactly equal, and the blanks
!> around a text do not count. Assumed-rank arguments would be shorter, but gfortran 12 takes an empty array for assumed size.
#define MODULE_NAME funit_equality_of_scalars
#define EXPECTED_SHAPE
#define ACTUAL_SHAPE
#include "funit_equality.inc"
#undef MODULE_NAME
#undef EXPECTED_SHAPE
#undef ACTUAL_SHAPE

#define MODULE_NAME funit_equality_of_scalar_vector
#define EXPECTED_SHAPE
#define ACTUAL_SHAPE (:)
#include "funit_equality.inc"
#undef MODULE_NAME
#undef EXPECTED_SHAPE
#undef ACTUAL_SHAPE

#define MODULE_NAME funit_equality_of_scalar_matrix
#define EXPECTED_SHAPE
#define ACTUAL_SHAPE (:, :)
#include "funit_equality.inc"
#undef MODULE_NAME
#undef EXPECTED_SHAPE
#undef ACTUAL_SHAPE

#define MODULE_NAME funit_equality_of_vectors
#define EXPECTED_SHAPE (:)
#define ACTUAL_SHAPE (:)
#include "funit_equality.inc"
#undef MODULE_NAME
#undef EXPECTED_SHAPE
#undef ACTUAL_SHAPE

#define MODULE_NAME funit_equality_of_matrices
#define EXPECTED_SHAPE (:, :)
#define ACTUAL_SHAPE (:, :)
#include "funit_equality.inc"
#undef MODULE_NAME
#undef EXPECTED_SHAPE
#undef ACTUAL_SHAPE

module funit_equality
  use, intrinsic :: iso_fortran_env, only: real64
  use funit_equality_of_matrices, only: assertEqual, assertRelativelyEqual
  use funit_equality_of_scalar_matrix, only: assertEqual, assertRelativelyEqual
  use funit_equality_of_scalar_vector, only: assertEqual, assertRelativelyEqual
  use funit_equality_of_scalars, only: assertEqual, assertRelativelyEqual
  use funit_equality_of_vectors, only: assertEqual, assertRelativelyEqual
  use funit_exceptions, only: SourceLocation, throw
  use funit_values, only: to_text
  implicit none(type, external)
  private
  public :: assertEqual, assertNotEqual, assertRelativelyEqual

  interface assertEqual
    procedure equal_texts
  end interface assertEqual
  interface assertNotEqual
    procedure not_equal_integers, not_equal_reals, not_equal_reals_within
  end interface assertNotEqual

contains

  subroutine equal_texts(expected, actual, message, location)
    character(*), intent(in) :: expected
    character(*), intent(in) :: actual
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (trim(adjustl(expected)) == trim(adjustl(actual))) return
    call throw('expected "' // expected // '", got "' // actual // '"', message, location)
  end subroutine equal_texts

  subroutine not_equal_integers(expected, actual, message, location)
    integer, intent(in) :: expected
    integer, intent(in) :: actual
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (expected == actual) call throw('expected anything but ' // to_text(actual), message, location)
  end subroutine not_equal_integers

  subroutine not_equal_reals(expected, actual, message, location)
    real(real64), intent(in) :: expected
    real(real64), intent(in) :: actual
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    call not_equal_reals_within(expected, actual, 0.0_real64, message, location)
  end subroutine not_equal_reals

  subroutine not_equal_reals_within(expected, actual, tolerance, message, location)
    real(real64), intent(in) :: expected
    real(real64), intent(in) :: actual
    real(real64), intent(in) :: tolerance
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    if (abs(actual - expected) > tolerance) return
    call throw('expected anything but ' // to_text(expected) // ', got ' // to_text(actual), message, location)
  end subroutine not_equal_reals_within
end module funit_equality
