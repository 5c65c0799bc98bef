! SPDX-License-Identifier: BSD-3-Clause
!> User errors as values: a sentence, the place in the file it speaks of, a hint. Nothing here prints or stops.
module sig_errors
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: error_t, make_error, error_location
  public :: exit_success, exit_internal, exit_user, exit_not_converged

  integer, parameter :: exit_success = 0
  !> a broken promise inside the program (PETSc, MPI, a precondition)
  integer, parameter :: exit_internal = 1
  !> deck, mesh, file or command line of the user
  integer, parameter :: exit_user = 2
  !> a numerical method ended without an answer
  integer, parameter :: exit_not_converged = 3

  !> An error that the user can mend (or, with exit_not_converged, should know).
  type :: error_t
    !> whole sentence: what, where, what is allowed
    character(:), allocatable :: message
    !> file that the message speaks of; empty where there is none
    character(:), allocatable :: file
    !> 1-based; 0 = unknown
    integer :: line = 0
    !> 1-based; 0 = unknown
    integer :: column = 0
    !> what to do about it; may be empty
    character(:), allocatable :: hint
    integer :: exit_code = exit_user
  end type error_t

contains

  !> Fills an error; the caller returns right after.
  pure subroutine make_error(error, message, file, line, column, hint, exit_code)
    type(error_t), allocatable, intent(out) :: error
    character(*), intent(in) :: message
    character(*), intent(in), optional :: file
    integer, intent(in), optional :: line
    integer, intent(in), optional :: column
    character(*), intent(in), optional :: hint
    integer, intent(in), optional :: exit_code

    allocate (error)
    error%message = message
    error%file = ''
    error%hint = ''
    if (present(file)) error%file = file
    if (present(line)) error%line = line
    if (present(column)) error%column = column
    if (present(hint)) error%hint = hint
    if (present(exit_code)) error%exit_code = exit_code
  end subroutine make_error

  !> `file:line:column` as far as it is known, or an empty text.
  pure function error_location(error) result(text)
    type(error_t), intent(in) :: error
    character(:), allocatable :: text

    text = error%file
    if (error%line > 0) text = text // ':' // to_text(error%line)
    if (error%line > 0 .and. error%column > 0) text = text // ':' // to_text(error%column)
  end function error_location
end module sig_errors
