! SPDX-License-Identifier: BSD-3-Clause
!> Runs another program.
module sig_shell
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
  implicit none(type, external)
  private
  public :: run_shell

  ! include/signorom/shell.h describes this procedure in C.
  interface
    integer(c_int) function sig_run_shell(command) bind(c)
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: command(*)
    end function sig_run_shell
  end interface

contains

  !> Runs a command by the shell, waits for it and returns its exit code: 128 + number if a signal ended it, 127 if the shell
  !> or the program could not be started. If SIGINT or SIGTERM comes to this process (sig_signals), the shell gets SIGTERM; begin
  !> the command with `exec`, so that its program takes the place of the shell and gets the signal. After such a signal a new
  !> command is ended as soon as it starts.
  integer function run_shell(command)
    character(*), intent(in) :: command

    run_shell = sig_run_shell(command // c_null_char)
  end function run_shell
end module sig_shell
