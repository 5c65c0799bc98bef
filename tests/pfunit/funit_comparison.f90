! SPDX-License-Identifier: BSD-3-Clause
!> The comparisons behind assertEqual and assertRelativelyEqual, on entries in memory order beside the shapes they came from.
!>
!> A scalar (empty shape) may be expected of each entry of an array.
module funit_comparison
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use funit_exceptions, only: SourceLocation, throw
  use funit_values, only: index_text, shape_text, to_text
  implicit none(type, external)
  private
  public :: compare_integers, compare_reals, compare_relatively

contains

  subroutine compare_integers(expected, actual, expected_shape, actual_shape, message, location)
    integer(int64), intent(in) :: expected(:)
    integer(int64), intent(in) :: actual(:)
    integer, intent(in) :: expected_shape(:)
    integer, intent(in) :: actual_shape(:)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location
    integer :: i_entry, i_expected

    if (.not. shapes_fit(expected_shape, actual_shape, message, location)) return
    do i_entry = 1, size(actual)
      i_expected = merge(1, i_entry, size(expected_shape) == 0)
      if (expected(i_expected) == actual(i_entry)) cycle
      call throw('expected ' // to_text(expected(i_expected)) // ', got ' // to_text(actual(i_entry)) // &
        index_text(i_entry, actual_shape), message, location)
      return
    end do
  end subroutine compare_integers

  subroutine compare_reals(expected, actual, expected_shape, actual_shape, tolerance, message, location)
    real(real64), intent(in) :: expected(:)
    real(real64), intent(in) :: actual(:)
    integer, intent(in) :: expected_shape(:)
    integer, intent(in) :: actual_shape(:)
    real(real64), intent(in) :: tolerance
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location
    real(real64), allocatable :: wanted(:)

    if (.not. shapes_fit(expected_shape, actual_shape, message, location)) return
    wanted = spread_if_scalar(expected, size(actual), size(expected_shape))
    ! the exact comparison first: the difference of two infinities is no number
    call report_first(wanted == actual .or. abs(actual - wanted) <= tolerance, wanted, actual, actual_shape, 'tolerance', &
      tolerance, message, location)
  end subroutine compare_reals

  !> Difference of each entry <= tolerance * |expected entry|; an expected zero is an error, as no difference is relative to it.
  subroutine compare_relatively(expected, actual, expected_shape, actual_shape, tolerance, message, location)
    real(real64), intent(in) :: expected(:)
    real(real64), intent(in) :: actual(:)
    integer, intent(in) :: expected_shape(:)
    integer, intent(in) :: actual_shape(:)
    real(real64), intent(in) :: tolerance
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location
    real(real64), allocatable :: wanted(:)

    if (.not. shapes_fit(expected_shape, actual_shape, message, location)) return
    if (any(abs(expected) <= 0)) then
      call throw('zero is expected, so no difference is relative to it', message, location)
      return
    end if
    wanted = spread_if_scalar(expected, size(actual), size(expected_shape))
    call report_first(abs(actual - wanted) <= tolerance * abs(wanted), wanted, actual, actual_shape, 'relative tolerance', &
      tolerance, message, location)
  end subroutine compare_relatively

  logical function shapes_fit(expected_shape, actual_shape, message, location) result(fits)
    integer, intent(in) :: expected_shape(:)
    integer, intent(in) :: actual_shape(:)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location

    fits = size(expected_shape) == 0
    if (.not. fits .and. size(expected_shape) == size(actual_shape)) fits = all(expected_shape == actual_shape)
    if (.not. fits) call throw('expected shape ' // shape_text(expected_shape) // ', got shape ' // shape_text(actual_shape), &
      message, location)
  end function shapes_fit

  pure function spread_if_scalar(values, n_entries, n_dim) result(entries)
    real(real64), intent(in) :: values(:)
    integer, intent(in) :: n_entries
    integer, intent(in) :: n_dim
    real(real64), allocatable :: entries(:)

    entries = values
    if (n_dim == 0) entries = spread(values(1), 1, n_entries)
  end function spread_if_scalar

  !> Throws for the first entry that is not within its tolerance.
  subroutine report_first(is_within, expected, actual, actual_shape, word, tolerance, message, location)
    logical, intent(in) :: is_within(:)
    real(real64), intent(in) :: expected(:)
    real(real64), intent(in) :: actual(:)
    integer, intent(in) :: actual_shape(:)
    character(*), intent(in) :: word
    real(real64), intent(in) :: tolerance
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location
    integer :: i_entry

    i_entry = findloc(is_within, .false., 1)
    if (i_entry == 0) return
    call throw('expected ' // to_text(expected(i_entry)) // ', got ' // to_text(actual(i_entry)) // &
      index_text(i_entry, actual_shape) // ' (difference ' // to_text(actual(i_entry) - expected(i_entry)) // ', ' // word // &
      ' ' // to_text(tolerance) // ')', message, location)
  end subroutine report_first
end module funit_comparison
