! SPDX-License-Identifier: BSD-3-Clause
!> Output of the program while it runs. The module keeps whether this rank prints, the log file, and whether a write failed.
module sig_log
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_size_t
  use sig_clock, only: date_and_time_text
  use sig_errors, only: error_t, make_error
  use sig_system, only: system_reason
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: start_log, log_to_file, log_info, log_note, log_warning, log_warnings, log_error, log_to_file_only, lost_output
  public :: is_log_shown, show_status, clear_status

  !> false until start_log, so that a library prints nothing
  logical :: is_log_speaking = .false.
  logical :: is_log_quiet = .false.
  !> columns that the status line takes on the terminal now; 0 = there is no status line
  integer :: n_status_columns = 0
  !> first errno of the standard output, and of the log file
  integer(c_int) :: output_failure = 0
  integer(c_int) :: file_failure = 0
  !> descriptor of the log file; negative: there is none
  integer(c_int) :: log_file = -1
  !> file descriptors of Linux
  integer(c_int), parameter :: standard_output = 1, standard_error = 2

  ! include/signorom/system.h describes these procedures in C.
  interface
    integer(c_int) function sig_open_to_append(path, length, descriptor) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      integer(c_int), intent(out) :: descriptor
    end function sig_open_to_append

    integer(c_int) function sig_write_all(descriptor, bytes, size) bind(c)
      import :: c_char, c_int, c_size_t
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(in) :: bytes(*)
      integer(c_size_t), value :: size
    end function sig_write_all
  end interface

contains

  !> Sets what this rank writes to the terminal; before this call it writes nothing there. Every rank calls it, one of them with
  !> is_speaking. Local.
  subroutine start_log(is_speaking, is_quiet)
    !> whether this rank writes to the terminal
    logical, intent(in) :: is_speaking
    !> whether the terminal gets only warnings and errors
    logical, intent(in) :: is_quiet

    is_log_speaking = is_speaking
    is_log_quiet = is_quiet
    n_status_columns = 0
  end subroutine start_log

  !> Opens a log file, or creates it if it is absent, and appends to it. From now on the file gets each text that this rank gives to
  !> the procedures log_..., with the date before its first line, also where the terminal is quiet. A process has one log file.
  !> Local.
  !>
  !> Errors: the file cannot be opened for writing.
  subroutine log_to_file(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: code

    code = sig_open_to_append(path, len(path, c_size_t), log_file)
    if (code /= 0) call make_error(error, 'cannot write the log: ' // system_reason(code), file=path)
  end subroutine log_to_file

  !> Whether log_info writes to stdout: this rank speaks, and the log is not quiet.
  logical function is_log_shown()
    is_log_shown = is_log_speaking .and. .not. is_log_quiet
  end function is_log_shown

  !> Writes a line to the log file and, if is_log_shown, to stdout. A full disk does not end the work: lost_output reports it at the
  !> end.
  subroutine log_info(text)
    character(*), intent(in) :: text
    integer(c_int) :: code

    call log_to_file_only(text)
    if (.not. is_log_shown()) return
    call say(standard_output, text, code)
    if (output_failure == 0) output_failure = code
  end subroutine log_info

  !> Writes a line to the log file and, if is_log_shown, to stderr. It is for a command whose table goes to stdout. lost_output does
  !> not report a failure on stderr.
  subroutine log_note(text)
    character(*), intent(in) :: text
    integer(c_int) :: ignored

    call log_to_file_only(text)
    if (is_log_shown()) call say(standard_error, text, ignored)
  end subroutine log_note

  !> Writes a line with the date to the log file, if there is one. The terminal gets nothing.
  subroutine log_to_file_only(text)
    character(*), intent(in) :: text
    character(:), allocatable :: line
    integer(c_int) :: code

    if (log_file < 0) return
    line = date_and_time_text() // ' ' // text // new_line('a')
    code = sig_write_all(log_file, line, len(line, c_size_t))
    if (file_failure == 0) file_failure = code
  end subroutine log_to_file_only

  !> Reports lost output of this rank. Errors: a line of log_info, or a line of the log file, could not be written.
  subroutine lost_output(error)
    type(error_t), allocatable, intent(out) :: error

    if (output_failure /= 0) then
      call make_error(error, 'cannot write everything: ' // system_reason(output_failure), file='standard output')
    else if (file_failure /= 0) then
      call make_error(error, 'cannot write everything: ' // system_reason(file_failure), file='the log')
    end if
  end subroutine lost_output

  !> Writes `warning: <text>` to the log file and, if this rank speaks, to stderr, also when the log is quiet.
  subroutine log_warning(text)
    character(*), intent(in) :: text

    integer(c_int) :: ignored

    call log_to_file_only('warning: ' // text)
    if (is_log_speaking) call say(standard_error, 'warning: ' // text, ignored)
  end subroutine log_warning

  !> Writes each text that is not empty as log_warning does.
  subroutine log_warnings(texts)
    type(string_t), intent(in) :: texts(:)
    integer :: i

    do i = 1, size(texts)
      if (texts(i)%text /= '') call log_warning(texts(i)%text)
    end do
  end subroutine log_warnings

  !> Writes an error to the log file and, if this rank speaks, to stderr, also when the log is quiet. The text comes from
  !> error_report and already contains the word `error`.
  subroutine log_error(text)
    character(*), intent(in) :: text

    integer(c_int) :: ignored

    call log_to_file_only(text)
    if (is_log_speaking) call say(standard_error, text, ignored)
  end subroutine log_error

  subroutine say(descriptor, text, code)
    integer(c_int), intent(in) :: descriptor
    character(*), intent(in) :: text
    !> 0 or the errno of the failure
    integer(c_int), intent(out) :: code

    call clear_status()
    code = sig_write_all(descriptor, text // new_line('a'), len(text, c_size_t) + 1)
  end subroutine say

  !> Draws one line on stderr over the status line before it, if is_log_shown. The next line on the terminal erases it.
  !> Requires: stderr is a terminal; this is not checked.
  subroutine show_status(text)
    !> ASCII, shorter than a terminal line
    character(*), intent(in) :: text

    if (.not. is_log_shown()) return
    call draw(achar(13) // text // repeat(' ', max(0, n_status_columns - len(text))))
    n_status_columns = len(text)
  end subroutine show_status

  !> Erases the status line.
  subroutine clear_status()
    if (n_status_columns == 0) return
    call draw(achar(13) // repeat(' ', n_status_columns) // achar(13))
    n_status_columns = 0
  end subroutine clear_status

  !> Writes to stderr without the end of a line. A failure is ignored.
  subroutine draw(text)
    character(*), intent(in) :: text
    integer(c_int) :: ignored

    ignored = sig_write_all(standard_error, text, len(text, c_size_t))
  end subroutine draw
end module sig_log
