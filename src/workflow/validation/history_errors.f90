! SPDX-License-Identifier: BSD-3-Clause
!> Errors of a model over whole histories, where materials flow: the largest difference of all times, over the largest size of all
!> times. So times at which hardly anything presses do not count as much as those that matter. And how well the model's own estimate
!> of its error tells the error that it estimates.
module sig_history_errors
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
  use sig_kinds, only: rk
  use sig_statistics, only: measured_statistics, statistics_t
  implicit none(type, external)
  private
  public :: history_errors_t, estimate_quality_t, largest_of_history, over_histories, quality_of_estimates

  !> [-] a history whose size is below this share of the largest of all histories is compared with this share: where a contact
  !> hardly closes, or a part hardly yields, small values need no model
  real(rk), parameter, public :: least_share = 1.0e-2_rk
  !> [-] an estimate is near the error if their ratio is in this range
  real(rk), parameter, public :: near_ratios(2) = [0.5_rk, 1.2_rk]

  !> [-] Errors of each history, shape (n_histories); infinite where some time has no answer, NaN where the full order has no
  !> solution at any time, and for strains that no material has.
  type :: history_errors_t
    !> contact forces before and behind the correction
    real(rk), allocatable :: raw_forces(:)
    real(rk), allocatable :: forces(:)
    !> what the model says of raw_forces
    real(rk), allocatable :: estimate(:)
    !> displacement in the norm of the stiffness, von Mises stress anywhere, and equivalent strains anywhere
    real(rk), allocatable :: displacement(:)
    real(rk), allocatable :: stress(:)
    real(rk), allocatable :: plastic_strain(:)
    real(rk), allocatable :: creep_strain(:)
  end type history_errors_t

  !> How well estimates tell errors. The ratio of both is defined at n_histories.
  type :: estimate_quality_t
    integer :: n_histories = 0
    !> [-] median of the estimate over the error; NaN without histories
    real(rk) :: median_ratio = 0
    !> [-] share of the histories whose ratio is in near_ratios; NaN without histories
    real(rk) :: share_near = 0
    !> [-] Spearman's rank correlation of estimates and errors; NaN with less than three histories or where all are equal
    real(rk) :: rank_correlation = 0
  end type estimate_quality_t

contains

  !> Returns for each state the largest value of its history among the times that count; 0 where none counts. Shape (n_states).
  pure function largest_of_history(values, n_times, counts) result(largest)
    !> at least 0; the times of a history follow each other
    real(rk), intent(in) :: values(:)
    integer, intent(in) :: n_times
    !> shape (n_states)
    logical, intent(in) :: counts(:)
    real(rk) :: largest(size(values))
    integer :: first

    do first = 1, size(values), n_times
      associate (last => first + n_times - 1)
        largest(first:last) = max(0.0_rk, maxval(values(first:last), mask=counts(first:last)))
      end associate
    end do
  end function largest_of_history

  !> [-] Returns the error of each history, as in history_errors_t. Zero over zero is zero.
  pure function over_histories(differences, sizes, n_times, is_solved, is_answered) result(errors)
    !> in the same unit, shape (n_states); the times of a history follow each other
    real(rk), intent(in) :: differences(:)
    real(rk), intent(in) :: sizes(:)
    integer, intent(in) :: n_times
    !> whether the full order has a solution, and the model an answer; shape (n_states)
    logical, intent(in) :: is_solved(:)
    logical, intent(in) :: is_answered(:)
    real(rk) :: errors(size(differences) / n_times)
    real(rk) :: floor
    integer :: i

    floor = least_share * max(0.0_rk, maxval(sizes, mask=is_solved))
    do i = 1, size(errors)
      associate (times => [n_times * (i - 1) + 1, n_times * i])
        errors(i) = error_of(differences(times(1):times(2)), sizes(times(1):times(2)), is_solved(times(1):times(2)), &
          is_answered(times(1):times(2)), floor)
      end associate
    end do
  end function over_histories

  !> Does the work of over_histories for one history.
  pure real(rk) function error_of(differences, sizes, is_solved, is_answered, floor) result(error)
    real(rk), intent(in) :: differences(:)
    real(rk), intent(in) :: sizes(:)
    logical, intent(in) :: is_solved(:)
    logical, intent(in) :: is_answered(:)
    !> least size
    real(rk), intent(in) :: floor

    if (.not. any(is_solved)) then
      error = ieee_value(error, ieee_quiet_nan)
    else if (any(is_solved .and. .not. is_answered)) then
      error = ieee_value(error, ieee_positive_inf)
    else if (all(differences <= 0 .or. .not. is_solved)) then
      error = 0
    else if (any(is_solved .and. .not. differences >= 0)) then
      error = ieee_value(error, ieee_quiet_nan)
    else
      error = maxval(differences, mask=is_solved) / max(maxval(sizes, mask=is_solved), floor)
    end if
  end function error_of

  !> Compares estimates with errors at the histories where both are finite and the error is not zero.
  pure function quality_of_estimates(estimates, errors) result(quality)
    !> [-] shape (n_histories)
    real(rk), intent(in) :: estimates(:)
    real(rk), intent(in) :: errors(:)
    type(estimate_quality_t) :: quality
    type(statistics_t) :: statistics
    real(rk), allocatable :: estimated(:), ratios(:), true(:)
    logical :: counts(size(errors))

    counts = errors > 0 .and. errors <= huge(errors) .and. estimates >= 0 .and. estimates <= huge(estimates)
    estimated = pack(estimates, counts)
    true = pack(errors, counts)
    ratios = estimated / true
    quality%n_histories = size(true)
    statistics = measured_statistics(ratios)
    quality%median_ratio = statistics%median
    quality%share_near = ieee_value(1.0_rk, ieee_quiet_nan)
    if (size(ratios) > 0) quality%share_near = real(count(ratios >= near_ratios(1) .and. ratios <= near_ratios(2)), rk) / &
      size(ratios)
    quality%rank_correlation = correlation(ranks_of(estimated), ranks_of(true))
  end function quality_of_estimates

  !> Returns the rank of each value, 1 for the smallest; equal values share the mean of their ranks.
  pure function ranks_of(values) result(ranks)
    real(rk), intent(in) :: values(:)
    real(rk) :: ranks(size(values))
    integer :: i

    do i = 1, size(values)
      ranks(i) = count(values < values(i)) + (count(values <= values(i) .and. values >= values(i)) + 1) / 2.0_rk
    end do
  end function ranks_of

  !> [-] Returns Pearson's correlation; NaN with less than three values or where all of one side are equal.
  pure real(rk) function correlation(a, b)
    real(rk), intent(in) :: a(:)
    !> shape (size(a))
    real(rk), intent(in) :: b(:)
    real(rk) :: da(size(a)), db(size(b))

    correlation = ieee_value(correlation, ieee_quiet_nan)
    if (size(a) < 3) return
    da = a - sum(a) / size(a)
    db = b - sum(b) / size(b)
    if (norm2(da) > 0 .and. norm2(db) > 0) correlation = dot_product(da, db) / (norm2(da) * norm2(db))
  end function correlation
end module sig_history_errors
