! SPDX-License-Identifier: BSD-3-Clause
!> Failed assertions: printed at once (a rank may hang afterwards) and counted for the test that is running.
module funit_exceptions
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none(type, external)
  private
  public :: SourceLocation, throw, anyExceptions, begin_test, set_rank

  !> Place of an assertion; the translator fills it.
  type :: SourceLocation
    character(256) :: file_name = ''
    integer :: line_number = 0
  end type SourceLocation

  interface anyExceptions
    procedure any_exceptions_here
  end interface anyExceptions

  character(:), allocatable :: current_test
  integer :: n_failed_assertions = 0
  !> -1 = no MPI, so no rank in the message
  integer :: current_rank = -1

contains

  !> Names the test that later failures belong to.
  subroutine begin_test(name)
    character(*), intent(in) :: name

    current_test = name
    n_failed_assertions = 0
  end subroutine begin_test

  !> Makes messages name this rank.
  subroutine set_rank(rank)
    integer, intent(in) :: rank

    current_rank = rank
  end subroutine set_rank

  !> Records a failed assertion and prints `file:line: test: text: message`.
  subroutine throw(text, message, location)
    character(*), intent(in) :: text
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in), optional :: location
    character(:), allocatable :: line

    n_failed_assertions = n_failed_assertions + 1
    line = location_text(location)
    if (allocated(current_test)) line = line // current_test // ': '
    line = line // text
    if (present(message)) line = line // ': ' // trim(message)
    write (error_unit, '(a)') line // rank_text()
    flush (error_unit)
  end subroutine throw

  !> Whether the running test has failed, as far as this rank knows.
  logical function any_exceptions_here() result(is_failed)
    is_failed = n_failed_assertions > 0
  end function any_exceptions_here

  function location_text(location) result(text)
    type(SourceLocation), intent(in), optional :: location
    character(:), allocatable :: text
    character(16) :: number

    text = ''
    if (.not. present(location)) return
    write (number, '(i0)') location%line_number
    text = trim(location%file_name) // ':' // trim(number) // ': '
  end function location_text

  function rank_text() result(text)
    character(:), allocatable :: text
    character(16) :: number

    text = ''
    if (current_rank < 0) return
    write (number, '(i0)') current_rank
    text = ' [rank ' // trim(number) // ']'
  end function rank_text
end module funit_exceptions
