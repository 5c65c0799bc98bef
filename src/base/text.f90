! SPDX-License-Identifier: BSD-3-Clause
!> Small text helpers: numbers to text, lists of names, the nearest known word.
module sig_text
  use sig_kinds, only: lk, rk
  implicit none(type, external)
  private
  public :: string_t, to_text, join

  !> A text of its own length, so that texts can stand in arrays.
  type :: string_t
    character(:), allocatable :: text
  end type string_t

  interface to_text
    procedure integer_to_text, long_to_text, real_to_text
  end interface to_text

contains

  pure function integer_to_text(number) result(text)
    integer, intent(in) :: number
    character(:), allocatable :: text
    character(16) :: buffer

    write (buffer, '(i0)') number
    text = trim(buffer)
  end function integer_to_text

  pure function long_to_text(number) result(text)
    integer(lk), intent(in) :: number
    character(:), allocatable :: text
    character(24) :: buffer

    write (buffer, '(i0)') number
    text = trim(buffer)
  end function long_to_text

  !> Shortest of a few decimal forms that reads back as the same number (0.15, 1.0e-8).
  pure function real_to_text(number) result(text)
    real(rk), intent(in) :: number
    character(:), allocatable :: text
    character(32) :: buffer

    write (buffer, '(g0)') number
    text = trim(adjustl(buffer))
  end function real_to_text

  !> Names with a comma between them, for messages.
  pure function join(names, separator) result(text)
    type(string_t), intent(in) :: names(:)
    character(*), intent(in) :: separator
    character(:), allocatable :: text
    integer :: i_name

    text = ''
    do i_name = 1, size(names)
      if (i_name > 1) text = text // separator
      text = text // names(i_name)%text
    end do
  end function join
end module sig_text
