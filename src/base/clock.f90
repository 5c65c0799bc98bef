! SPDX-License-Identifier: BSD-3-Clause
!> Wall clock for durations, and the date.
module sig_clock
  use sig_kinds, only: lk, rk
  implicit none(type, external)
  private
  public :: wall_time, date_and_time_text

contains

  !> Returns the time [s] since an arbitrary start. The clock never runs backwards, so differences are durations.
  real(rk) function wall_time() result(seconds)
    integer(lk) :: count, count_rate

    call system_clock(count, count_rate)
    seconds = real(count, rk) / real(count_rate, rk)
  end function wall_time

  !> Returns the date and time as `2026-11-23T04:05:06+00:00`, in the time zone of the machine.
  function date_and_time_text() result(text)
    character(25) :: text
    character(8) :: date
    character(10) :: time
    character(5) :: zone

    call date_and_time(date, time, zone)
    text = date(1:4) // '-' // date(5:6) // '-' // date(7:8) // 'T' // time(1:2) // ':' // time(3:4) // ':' // time(5:6) // &
      zone(1:3) // ':' // zone(4:5)
  end function date_and_time_text
end module sig_clock
