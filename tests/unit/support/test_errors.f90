! SPDX-License-Identifier: BSD-3-Clause
!> Assertions about user errors.
module test_errors
  use funit, only: assertTrue
  use sig_errors, only: error_t
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: assert_user_error, assert_no_error

contains

  !> There is an error, on this line of the user's file (0 = none), and its message contains the text.
  subroutine assert_user_error(error, line, text)
    type(error_t), allocatable, intent(in) :: error
    integer, intent(in) :: line
    character(*), intent(in) :: text

    call assertTrue(allocated(error), message='no error; expected: ' // text)
    if (.not. allocated(error)) return
    call assertTrue(error%line == line, message='error on line ' // to_text(error%line) // ', not ' // to_text(line))
    call assertTrue(index(error%message, text) > 0, message='"' // error%message // '" does not contain "' // text // '"')
  end subroutine assert_user_error

  !> There is no error; if there is, the failure shows it.
  subroutine assert_no_error(error)
    type(error_t), allocatable, intent(in) :: error

    if (.not. allocated(error)) return
    call assertTrue(.false., message='unexpected error: ' // error%message)
  end subroutine assert_no_error
end module test_errors
