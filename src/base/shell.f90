! SPDX-License-Identifier: BSD-3-Clause
!> Runs another program.
module sig_shell
  use, intrinsic :: iso_c_binding, only: c_null_char
  use sig_base_c_interfaces, only: sig_run_shell
  implicit none(type, external)
  private
  public :: run_shell

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
