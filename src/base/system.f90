! SPDX-License-Identifier: BSD-3-Clause
!> Error messages of the system.
module sig_system
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_size_t
  use sig_c_strings, only: from_c
  implicit none(type, external)
  private
  public :: system_reason

  ! include/signorom/system.h describes this procedure in C.
  interface
    subroutine sig_error_text(code, text, size) bind(c)
      import :: c_char, c_int, c_size_t
      integer(c_int), value :: code
      character(kind=c_char), intent(inout) :: text(*)
      integer(c_size_t), value :: size
    end subroutine sig_error_text
  end interface

contains

  !> Returns the system's message for an errno, without a capital: `no such file or directory`.
  function system_reason(code) result(text)
    integer(c_int), intent(in) :: code
    character(:), allocatable :: text
    character(kind=c_char) :: buffer(128)

    call sig_error_text(code, buffer, size(buffer, kind=c_size_t))
    text = from_c(buffer)
    if (len(text) > 1) then
      if (text(1:1) >= 'A' .and. text(1:1) <= 'Z') text(1:1) = achar(iachar(text(1:1)) + 32)
    end if
  end function system_reason
end module sig_system
