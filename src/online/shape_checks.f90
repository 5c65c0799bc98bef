! SPDX-License-Identifier: BSD-3-Clause
!> Checks of shapes and values of arrays from a file.
module sig_shape_checks
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: are_indices, is_ascending, is_matrix, place_in_ascending

contains

  !> Whether the matrix has this shape and all its values are finite.
  pure logical function is_matrix(values, n_rows, n_columns)
    real(rk), intent(in) :: values(:, :)
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_columns

    is_matrix = all(shape(values) == [n_rows, n_columns]) .and. all(ieee_is_finite(values))
  end function is_matrix

  !> Whether all values are at least 1 and at most n; true for an empty list.
  pure logical function are_indices(values, n)
    integer, intent(in) :: values(:)
    integer, intent(in) :: n

    are_indices = all(values >= 1 .and. values <= n)
  end function are_indices

  !> Whether each value is larger than the one before; true for a list of one value or none.
  pure logical function is_ascending(values)
    integer, intent(in) :: values(:)

    is_ascending = all(values(2:) > values(:size(values) - 1))
  end function is_ascending

  !> Returns the index i, 1-based, with list(i) = number in an ascending list; 0 if the list does not have the number.
  pure integer function place_in_ascending(list, number) result(place)
    integer, intent(in) :: list(:)
    integer, intent(in) :: number
    integer :: first, last

    first = 1
    last = size(list)
    do while (first < last)
      place = (first + last) / 2
      if (list(place) < number) then
        first = place + 1
      else
        last = place
      end if
    end do
    place = 0
    if (first > size(list)) return
    if (list(first) == number) place = first
  end function place_in_ascending
end module sig_shape_checks
