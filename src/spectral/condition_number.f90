! SPDX-License-Identifier: BSD-3-Clause
!> Condition number of the projected contact matrix. It shows how well the multipliers are determined.
module sig_condition_number
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use sig_kinds, only: rk
  use sig_singular_values, only: singular_values
  implicit none(type, external)
  private
  public :: condition_number, condition_of_values

contains

  !> Computes kappa = sigma_max / sigma_n_rows and the rank of a matrix. Source: (11). Paper: it gives no convention for rank <
  !> n_rows; here kappa is infinite then. A matrix without rows has kappa 1 and rank 0, because no row is badly determined. If a
  !> matrix with rows is not finite, or LAPACK fails, the rank is 0 and kappa is infinite.
  subroutine condition_number(matrix, rank_tolerance, kappa, rank)
    !> shape (n_rows, n_columns): multipliers by modes
    real(rk), intent(in) :: matrix(:, :)
    !> [-] singular values below this times the largest one count as zero, and so does 0
    real(rk), intent(in) :: rank_tolerance
    !> [-] at least 1; infinite where the rank is smaller than n_rows
    real(rk), intent(out) :: kappa
    !> number of singular values that do not count as zero
    integer, intent(out) :: rank

    call condition_of_values(singular_values(matrix), size(matrix, 1), rank_tolerance, kappa, rank)
  end subroutine condition_number

  !> Computes the same as condition_number from the singular values of a matrix with n_rows rows. If these are NaN, the rank is 0
  !> and kappa is infinite.
  pure subroutine condition_of_values(sigma, n_rows, rank_tolerance, kappa, rank)
    !> singular values, descending, not more than n_rows values
    real(rk), intent(in) :: sigma(:)
    integer, intent(in) :: n_rows
    !> as for condition_number, like kappa and rank
    real(rk), intent(in) :: rank_tolerance
    real(rk), intent(out) :: kappa
    integer, intent(out) :: rank

    kappa = 1
    rank = 0
    if (n_rows == 0) return
    if (size(sigma) > 0) rank = count(sigma > 0 .and. sigma >= rank_tolerance * sigma(1))
    kappa = ieee_value(kappa, ieee_positive_inf)
    if (rank == n_rows) kappa = sigma(1) / sigma(rank)
  end subroutine condition_of_values
end module sig_condition_number
