! SPDX-License-Identifier: BSD-3-Clause
!> Numbers, shapes and subscripts as text, for the messages.
module funit_values
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none(type, external)
  private
  public :: to_text, index_text, shape_text

  interface to_text
    procedure integer_to_text, long_to_text, real_to_text
  end interface to_text

contains

  pure function integer_to_text(number) result(text)
    integer, intent(in) :: number
    character(:), allocatable :: text

    text = long_to_text(int(number, int64))
  end function integer_to_text

  pure function long_to_text(number) result(text)
    integer(int64), intent(in) :: number
    character(:), allocatable :: text
    character(32) :: buffer

    write (buffer, '(i0)') number
    text = trim(buffer)
  end function long_to_text

  pure function real_to_text(number) result(text)
    real(real64), intent(in) :: number
    character(:), allocatable :: text
    character(48) :: buffer

    write (buffer, '(g0)') number
    text = trim(adjustl(buffer))
  end function real_to_text

  !> `(3, 4)`.
  pure function shape_text(extents) result(text)
    integer, intent(in) :: extents(:)
    character(:), allocatable :: text
    integer :: i_dim

    text = '('
    do i_dim = 1, size(extents)
      if (i_dim > 1) text = text // ', '
      text = text // integer_to_text(extents(i_dim))
    end do
    text = text // ')'
  end function shape_text

  !> Subscripts of an entry given by its position in memory order; empty for a scalar.
  pure function index_text(position, extents) result(text)
    integer, intent(in) :: position
    integer, intent(in) :: extents(:)
    character(:), allocatable :: text
    integer :: subscripts(size(extents))
    integer :: i_dim, rest

    text = ''
    if (size(extents) == 0) return
    rest = position - 1
    do i_dim = 1, size(extents)
      subscripts(i_dim) = mod(rest, extents(i_dim)) + 1
      rest = rest / extents(i_dim)
    end do
    text = ' at ' // shape_text(subscripts)
  end function index_text
end module funit_values
