! SPDX-License-Identifier: BSD-3-Clause
!> What the program says while it runs. The only module with a state: whether this rank speaks.
module sig_log
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  implicit none(type, external)
  private
  public :: start_log, log_info, log_warning, log_error
  public :: is_log_shown, show_status, clear_status

  !> false until start_log: a library is silent
  logical :: is_log_speaking = .false.
  logical :: is_log_quiet = .false.
  !> columns that the status line on the terminal takes now; 0 = there is none
  integer :: n_status_columns = 0

contains

  !> Says who speaks. Every rank calls it; one of them with is_speaking.
  subroutine start_log(is_speaking, is_quiet)
    logical, intent(in) :: is_speaking
    !> keeps warnings and errors only
    logical, intent(in) :: is_quiet

    is_log_speaking = is_speaking
    is_log_quiet = is_quiet
    n_status_columns = 0
  end subroutine start_log

  !> True where log_info would show its text.
  logical function is_log_shown()
    is_log_shown = is_log_speaking .and. .not. is_log_quiet
  end function is_log_shown

  !> To stdout.
  subroutine log_info(text)
    character(*), intent(in) :: text

    if (is_log_shown()) call say(output_unit, text)
  end subroutine log_info

  !> To stderr, quiet or not.
  subroutine log_warning(text)
    character(*), intent(in) :: text

    if (is_log_speaking) call say(error_unit, 'warning: ' // text)
  end subroutine log_warning

  !> To stderr, quiet or not; the text is error_report's and already names itself an error.
  subroutine log_error(text)
    character(*), intent(in) :: text

    if (is_log_speaking) call say(error_unit, text)
  end subroutine log_error

  subroutine say(unit, text)
    integer, intent(in) :: unit
    character(*), intent(in) :: text

    call clear_status()
    write (unit, '(a)') text
    flush (unit)
  end subroutine say

  !> Draws one line on the terminal (stderr) over the one before it; the next log line wipes it.
  subroutine show_status(text)
    !> ASCII, shorter than a terminal line
    character(*), intent(in) :: text

    if (.not. is_log_shown()) return
    write (error_unit, '(a)', advance='no') achar(13) // text // repeat(' ', max(0, n_status_columns - len(text)))
    flush (error_unit)
    n_status_columns = len(text)
  end subroutine show_status

  !> Wipes the status line.
  subroutine clear_status()
    if (n_status_columns == 0) return
    write (error_unit, '(a)', advance='no') achar(13) // repeat(' ', n_status_columns) // achar(13)
    flush (error_unit)
    n_status_columns = 0
  end subroutine clear_status
end module sig_log
