! SPDX-License-Identifier: BSD-3-Clause
!> Progress of a long loop: a bar with the time left on a terminal, few log lines elsewhere.
module sig_progress
  use, intrinsic :: iso_c_binding, only: c_int
  use sig_clock, only: wall_time
  use sig_kinds, only: rk
  use sig_log, only: clear_status, is_log_shown, log_info, log_to_file_only, show_status
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: progress_t, duration_text

  !> [s] between two drawings of the bar, so that fast loops do not spend their time drawing
  real(rk), parameter :: bar_interval = 0.1_rk
  !> [s] between two log lines
  real(rk), parameter :: line_interval = 10
  integer, parameter :: n_bar_columns = 30
  integer(c_int), parameter :: stderr_descriptor = 2

  !> Progress of one loop: call start, advance (as often as wanted) and finish. Local: call it on the rank that prints or on all.
  type :: progress_t
    private
    character(:), allocatable :: label
    integer :: n_total = 0
    integer :: n_done = 0
    !> [s] the loop is told of only if it takes longer
    real(rk) :: silence = 0
    !> [s] time of the start, of the last drawing or line, and of the last line in the log file beside a bar
    real(rk) :: start_time = 0
    real(rk) :: shown_time = 0
    real(rk) :: noted_time = 0
    logical :: is_shown = .false.
    logical :: is_bar = .false.
  contains
    procedure :: start
    procedure :: advance
    procedure :: finish
  end type progress_t

  ! include/signorom/signals.h and include/signorom/system.h describe these procedures in C.
  interface
    integer(c_int) function sig_is_terminal(descriptor) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor
    end function sig_is_terminal

    integer(c_int) function sig_terminal_columns(descriptor) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor
    end function sig_terminal_columns
  end interface

contains

  !> Starts a loop of n_total steps, and draws an empty bar if stderr is a terminal. If the log is not shown now (is_log_shown),
  !> neither this nor advance and finish draw or write anything.
  subroutine start(self, label, n_total, silence)
    class(progress_t), intent(inout) :: self
    !> name of the work, for example `sampling`
    character(*), intent(in) :: label
    integer, intent(in) :: n_total
    !> [s] nothing is drawn or written before this time, nor at the end of a loop that was shorter; default: 0
    real(rk), intent(in), optional :: silence

    self%label = label
    self%n_total = n_total
    self%n_done = 0
    self%start_time = wall_time()
    self%shown_time = self%start_time
    self%noted_time = self%start_time
    self%is_shown = is_log_shown()
    self%is_bar = .false.
    self%silence = 0
    if (present(silence)) self%silence = silence
    if (self%is_shown) self%is_bar = sig_is_terminal(stderr_descriptor) == 1
    if (self%is_bar .and. self%silence <= 0) call show_status(bar_text(self, 0.0_rk))
  end subroutine start

  !> Sets the number of steps that are done. If 0.1 s have passed since the last drawing, draws the bar again and, at most every
  !> 10 s, writes a line to the log file only. Without a bar, writes a log line if 10 s have passed since the start or the last one.
  subroutine advance(self, n_done)
    class(progress_t), intent(inout) :: self
    !> steps done since start
    integer, intent(in) :: n_done
    real(rk) :: now

    self%n_done = n_done
    if (.not. self%is_shown) return
    now = wall_time()
    if (now - self%start_time < self%silence) return
    if (now - self%shown_time < merge(bar_interval, line_interval, self%is_bar)) return
    self%shown_time = now
    if (self%is_bar) then
      call show_status(bar_text(self, now - self%start_time))
      if (now - self%noted_time < line_interval) return
      self%noted_time = now
      call log_to_file_only(line_text(self, now - self%start_time))
    else
      call log_info(line_text(self, now - self%start_time))
    end if
  end subroutine advance

  !> Removes the bar and writes one log line: the label, the steps done of n_total, and the time since start. Writes nothing for a
  !> loop that was shorter than its silence.
  subroutine finish(self)
    class(progress_t), intent(inout) :: self

    real(rk) :: elapsed

    if (.not. self%is_shown) return
    self%is_shown = .false.
    elapsed = wall_time() - self%start_time
    if (elapsed < self%silence) return
    if (self%is_bar) call clear_status()
    call log_info(self%label // ': ' // to_text(self%n_done) // ' of ' // to_text(self%n_total) // ' in ' // duration_text(elapsed))
  end subroutine finish

  !> Returns the bar, such as `sampling [===========                   ] 12/31, 7.25 s left`. On a narrow terminal the text has no
  !> bar, or is cut.
  function bar_text(self, elapsed) result(text)
    class(progress_t), intent(in) :: self
    !> [s] time since the start
    real(rk), intent(in) :: elapsed
    character(:), allocatable :: text
    integer :: n_columns, n_filled

    n_filled = int(n_bar_columns * min(1.0_rk, real(self%n_done, rk) / max(1, self%n_total)))
    text = self%label // ' [' // repeat('=', n_filled) // repeat(' ', n_bar_columns - n_filled) // '] ' // &
      to_text(self%n_done) // '/' // to_text(self%n_total) // time_left(self, elapsed)
    n_columns = sig_terminal_columns(stderr_descriptor)
    ! the cursor needs a column, too
    if (n_columns == 0 .or. len(text) < n_columns) return
    text = line_text(self, elapsed)
    text = text(:min(len(text), n_columns - 1))
  end function bar_text

  pure function line_text(self, elapsed) result(text)
    class(progress_t), intent(in) :: self
    !> [s] time since the start
    real(rk), intent(in) :: elapsed
    character(:), allocatable :: text

    text = self%label // ': ' // to_text(self%n_done) // ' of ' // to_text(self%n_total) // time_left(self, elapsed)
  end function line_text

  !> Returns `, 7.25 s left` if the remaining steps take as long as those done; empty before the first step and after the last one.
  pure function time_left(self, elapsed) result(text)
    class(progress_t), intent(in) :: self
    !> [s]
    real(rk), intent(in) :: elapsed
    character(:), allocatable :: text

    text = ''
    if (self%n_done <= 0 .or. self%n_done >= self%n_total) return
    text = ', ' // duration_text(elapsed * (self%n_total - self%n_done) / self%n_done) // ' left'
  end function time_left

  !> Returns a duration [s] as text for people: `0.34 s`, `12 s`, `3 min 05 s`, `2 h 03 min`.
  pure function duration_text(seconds) result(text)
    real(rk), intent(in) :: seconds
    character(:), allocatable :: text
    character(24) :: buffer
    integer :: whole

    whole = nint(min(max(seconds, 0.0_rk), real(huge(whole), rk) / 2))
    if (seconds < 9.995_rk) then
      write (buffer, '(f4.2, a)') max(seconds, 0.0_rk), ' s'
    else if (whole < 60) then
      write (buffer, '(i0, a)') whole, ' s'
    else if (whole < 3600) then
      write (buffer, '(i0, a, i2.2, a)') whole / 60, ' min ', mod(whole, 60), ' s'
    else
      write (buffer, '(i0, a, i2.2, a)') whole / 3600, ' h ', mod(whole, 3600) / 60, ' min'
    end if
    text = trim(buffer)
  end function duration_text
end module sig_progress
