! SPDX-License-Identifier: BSD-3-Clause
!> Requests to stop by SIGINT and SIGTERM. The program checks for them between two pieces of work; a process that does not stop in
!> time is ended.
module sig_signals
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_size_t
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: install_stop_signals, is_stop_requested, say_when_ended

  ! include/signorom/signals.h describes these procedures in C.
  interface
    subroutine sig_install_stop_signals(grace) bind(c)
      import :: c_double
      real(c_double), value :: grace
    end subroutine sig_install_stop_signals

    subroutine sig_set_last_words(text, length, descriptor) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: text(*)
      integer(c_size_t), value :: length
      integer(c_int), value :: descriptor
    end subroutine sig_set_last_words

    integer(c_int) function sig_is_stop_requested() bind(c)
      import :: c_int
    end function sig_is_stop_requested
  end interface

contains

  !> Makes SIGINT and SIGTERM set a flag from now on; an earlier request is forgotten. A process that has not ended `grace` seconds
  !> after the signal is ended with exit code 130, whatever it does, and its unfinished files are removed. start_petsc shortens this
  !> time where there are several ranks. From now on a write that would make a file larger than allowed (ulimit -f) fails and no
  !> longer ends the process.
  subroutine install_stop_signals(grace)
    !> [s] time between the signal and the forced end
    real(rk), intent(in) :: grace

    call sig_install_stop_signals(grace)
  end subroutine install_stop_signals

  !> Whether SIGINT or SIGTERM has come to this process since install_stop_signals. Local, for any thread: ranks agree by a
  !> reduction of their own.
  logical function is_stop_requested()
    is_stop_requested = sig_is_stop_requested() == 1
  end function is_stop_requested

  !> Sets the text that a forced end of this process writes to standard output or standard error: its first 254 bytes, as a line. An
  !> empty text writes nothing.
  subroutine say_when_ended(text, is_warning)
    character(*), intent(in) :: text
    !> write it to standard error; default: no
    logical, intent(in), optional :: is_warning
    integer(c_int) :: descriptor

    descriptor = 1
    if (present(is_warning)) descriptor = merge(2, 1, is_warning)
    call sig_set_last_words(text, len(text, c_size_t), descriptor)
  end subroutine say_when_ended
end module sig_signals
