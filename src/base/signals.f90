! SPDX-License-Identifier: BSD-3-Clause
!> SIGINT and SIGTERM as a wish to stop, asked for between two pieces of work.
module sig_signals
  use sig_base_c_interfaces, only: sig_install_stop_signals, sig_is_stop_requested
  implicit none(type, external)
  private
  public :: install_stop_signals, is_stop_requested

contains

  !> From now on SIGINT and SIGTERM only set a flag; the same signal seconds later ends the program at once.
  subroutine install_stop_signals()
    call sig_install_stop_signals()
  end subroutine install_stop_signals

  !> True once a signal came to this process. Local: ranks agree by a reduction of their own.
  logical function is_stop_requested()
    is_stop_requested = sig_is_stop_requested() == 1
  end function is_stop_requested
end module sig_signals
