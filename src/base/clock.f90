! SPDX-License-Identifier: BSD-3-Clause
!> Wall clock for durations.
module sig_clock
  use sig_kinds, only: lk, rk
  implicit none(type, external)
  private
  public :: wall_time

contains

  !> [s] since an arbitrary start; never runs backwards, so differences are durations.
  real(rk) function wall_time() result(seconds)
    integer(lk) :: count, count_rate

    call system_clock(count, count_rate)
    seconds = real(count, rk) / real(count_rate, rk)
  end function wall_time
end module sig_clock
