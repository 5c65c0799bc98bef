! SPDX-License-Identifier: BSD-3-Clause
!> User errors as values: a sentence, its place in a file, and a hint. Nothing here prints or stops.
module sig_errors
  use sig_text, only: string_t, split, to_text
  implicit none(type, external)
  private
  public :: error_t, error_list_t, make_error, error_location, error_report
  public :: exit_success, exit_internal, exit_user, exit_not_converged, exit_stopped

  integer, parameter :: exit_success = 0
  !> exit code: an internal fault of the program, PETSc or MPI
  integer, parameter :: exit_internal = 1
  !> exit code: the user has to correct the deck, the mesh, a file or the command line
  integer, parameter :: exit_user = 2
  !> exit code: a numerical method ended without an answer
  integer, parameter :: exit_not_converged = 3
  !> exit code: a signal ended the command; the same command continues the work or repeats it
  integer, parameter :: exit_stopped = 130

  !> An error for the user, who can correct it if exit_code is exit_user.
  type :: error_t
    !> complete sentence: what is wrong, where, and what is allowed
    character(:), allocatable :: message
    !> file that the message is about; empty where there is none
    character(:), allocatable :: file
    !> line in the file, 1-based; 0 = unknown
    integer :: line = 0
    !> column in the line, in characters, 1-based; 0 = unknown
    integer :: column = 0
    !> how to correct the error; may be empty
    character(:), allocatable :: hint
    integer :: exit_code = exit_user
  end type error_t

  !> A list of errors that are shown together.
  type :: error_list_t
    !> unallocated until the first error
    type(error_t), allocatable :: errors(:)
  contains
    procedure :: add
    procedure :: n_errors
  end type error_list_t

contains

  !> Allocates and fills an error. File and hint are empty, and line and column 0, if they are not given; the exit code is exit_user
  !> (2) by default.
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

  !> Returns `file:line:column` as far as it is known, or an empty text.
  pure function error_location(error) result(text)
    type(error_t), intent(in) :: error
    character(:), allocatable :: text

    text = error%file
    if (error%line > 0) text = text // ':' // to_text(error%line)
    if (error%line > 0 .and. error%column > 0) text = text // ':' // to_text(error%column)
  end function error_location

  !> Returns the text that the user sees: place and message; then the line of source_text with the error, if it has this line, and a
  !> marker below it, if the column is known; then the hint, if there is one. The text has no line end at its end.
  !>
  !>     disks.yaml:17:18: error: poisson_ratio is 0.52; it must be less than 0.5
  !>       17 |   poisson_ratio: 0.52
  !>          |                  ^
  !>     hint: ...
  pure function error_report(error, source_text) result(text)
    type(error_t), intent(in) :: error
    !> whole text of the file that the error is about
    character(*), intent(in), optional :: source_text
    character(:), allocatable :: text

    text = error_location(error)
    if (len(text) > 0) text = text // ': '
    text = text // 'error: ' // text_or_empty(error%message)
    if (present(source_text) .and. error%line > 0) text = text // marked_line(error, source_text)
    if (len(text_or_empty(error%hint)) > 0) text = text // new_line('a') // 'hint: ' // error%hint
  end function error_report

  !> Returns the error's source line and, if its column is known, the marker, each after a line end. The result is empty where the
  !> text has no such line. Requires: the error has a line.
  pure function marked_line(error, source_text) result(text)
    type(error_t), intent(in) :: error
    character(*), intent(in) :: source_text
    character(:), allocatable :: text
    type(string_t), allocatable :: lines(:)
    character(:), allocatable :: number, line

    text = ''
    allocate (lines, source=split(source_text, new_line('a')))
    if (error%line > size(lines)) return
    number = to_text(error%line)
    line = lines(error%line)%text
    if (len(line) > 0) then
      if (line(len(line):) == achar(13)) line = line(:len(line) - 1)
    end if
    text = new_line('a') // '  ' // number // ' | ' // line
    if (error%column > 0) text = text // new_line('a') // repeat(' ', len(number) + 2) // ' | ' // &
      blank_up_to(line, error%column) // '^'
  end function marked_line

  !> Returns as many blanks as there are characters before the column; tabs stay tabs, and a UTF-8 character counts once.
  pure function blank_up_to(line, column) result(text)
    character(*), intent(in) :: line
    !> in characters, 1-based
    integer, intent(in) :: column
    character(:), allocatable :: text
    integer :: i, n_characters

    text = ''
    n_characters = 0
    do i = 1, len(line)
      ! bytes 10xxxxxx continue a character
      if (iand(ichar(line(i:i)), 192) == 128) cycle
      n_characters = n_characters + 1
      if (n_characters == column) return
      text = text // merge(line(i:i), ' ', line(i:i) == achar(9))
    end do
    text = text // repeat(' ', max(0, column - 1 - n_characters))
  end function blank_up_to

  pure function text_or_empty(text) result(copy)
    character(:), allocatable, intent(in) :: text
    character(:), allocatable :: copy

    copy = ''
    if (allocated(text)) copy = text
  end function text_or_empty

  !> Appends an error. An unallocated error adds nothing, so that no caller needs to ask first.
  pure subroutine add(self, error)
    class(error_list_t), intent(inout) :: self
    type(error_t), intent(in), optional :: error

    if (.not. present(error)) return
    if (.not. allocated(self%errors)) allocate (self%errors(0))
    self%errors = [self%errors, error]
  end subroutine add

  !> Returns the number of errors in the list.
  pure integer function n_errors(self) result(n)
    class(error_list_t), intent(in) :: self

    n = 0
    if (allocated(self%errors)) n = size(self%errors)
  end function n_errors
end module sig_errors
