! SPDX-License-Identifier: BSD-3-Clause
!> Median, 95 % quantile, minimum and maximum of errors, where NaN values are left out; sorting of numbers.
module sig_statistics
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: statistics_t, summarize, measured_statistics, sort

  !> Statistics of values; p95 is the 95 % quantile.
  type :: statistics_t
    !> number of values that are not NaN
    integer :: n_values = 0
    real(rk) :: minimum = 0
    real(rk) :: median = 0
    real(rk) :: p95 = 0
    real(rk) :: maximum = 0
  end type statistics_t

contains

  !> Computes the statistics of the values that are not NaN; all are zero where there is none. Infinite values count.
  pure function summarize(values) result(statistics)
    real(rk), intent(in) :: values(:)
    type(statistics_t) :: statistics
    real(rk), allocatable :: sorted(:)

    sorted = pack(values, .not. is_no_number(values))
    call sort(sorted)
    statistics%n_values = size(sorted)
    if (size(sorted) == 0) return
    statistics%minimum = sorted(1)
    statistics%median = quantile(sorted, 0.5_rk)
    statistics%p95 = quantile(sorted, 0.95_rk)
    statistics%maximum = sorted(size(sorted))
  end function summarize

  !> Computes the statistics of the values that are not NaN. If there are none, n_values is 0 and all others are NaN, because zero
  !> would mean no error.
  pure function measured_statistics(values) result(statistics)
    real(rk), intent(in) :: values(:)
    type(statistics_t) :: statistics
    real(rk) :: none

    statistics = summarize(values)
    if (statistics%n_values > 0) return
    none = ieee_value(none, ieee_quiet_nan)
    statistics = statistics_t(n_values=0, minimum=none, median=none, p95=none, maximum=none)
  end function measured_statistics

  !> Returns a quantile of ascending values, linear between neighbors (the default of NumPy).
  pure real(rk) function quantile(sorted, fraction)
    !> ascending, at least one value
    real(rk), intent(in) :: sorted(:)
    !> [-] in [0, 1]
    real(rk), intent(in) :: fraction
    real(rk) :: position, part
    integer :: i

    position = 1 + fraction * (size(sorted) - 1)
    i = min(int(position), size(sorted) - 1)
    i = max(i, 1)
    part = position - i
    quantile = sorted(i)
    if (i == size(sorted)) return
    ! With infinite neighbors neither their difference nor a share of zero may become NaN.
    if (part > 0 .and. sorted(i + 1) > sorted(i)) quantile = sorted(i) + part * (sorted(i + 1) - sorted(i))
  end function quantile

  elemental logical function is_no_number(value)
    real(rk), intent(in) :: value

    is_no_number = .not. (value >= -huge(value) .or. value < -huge(value))
  end function is_no_number

  !> Sorts numbers, ascending, by Shell's method. Equal numbers may change their order. Requires: no NaN.
  pure subroutine sort(values, order)
    real(rk), intent(inout) :: values(:)
    !> numbers that move together with the values; shape (size(values))
    integer, intent(inout), optional :: order(:)
    real(rk) :: value
    integer :: gap, i, j, number

    number = 0
    gap = size(values) / 2
    do while (gap > 0)
      do i = gap + 1, size(values)
        value = values(i)
        if (present(order)) number = order(i)
        j = i - gap
        do while (j >= 1)
          if (values(j) <= value) exit
          values(j + gap) = values(j)
          if (present(order)) order(j + gap) = order(j)
          j = j - gap
        end do
        values(j + gap) = value
        if (present(order)) order(j + gap) = number
      end do
      gap = gap / 2
    end do
  end subroutine sort
end module sig_statistics
