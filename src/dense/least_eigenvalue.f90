! SPDX-License-Identifier: BSD-3-Clause
!> A lower bound of the eigenvalues of a symmetric positive definite matrix.
module sig_least_eigenvalue
  use sig_dense_kernels, only: factor_cholesky, solve_cholesky
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: bound_of_eigenvalues

contains

  !> Returns a number that is at most the smallest eigenvalue of A, and usually a half of it; 0 where A is not positive definite.
  !>
  !> Inverse iteration gives an estimate, which is never below the smallest eigenvalue. A - sigma I is positive definite for the
  !> result sigma: its Cholesky factor exists, and rounding is far below sigma as long as A is not nearly singular.
  real(rk) function bound_of_eigenvalues(matrix) result(sigma)
    !> A, shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> halvings of the estimate before the matrix counts as nearly singular
    integer, parameter :: most_halvings = 10
    real(rk), allocatable :: factor(:, :)
    integer :: i, info, k, n

    n = size(matrix, 1)
    sigma = 0
    if (n == 0) return
    factor = matrix
    call factor_cholesky(n, factor, info)
    if (info /= 0) return
    sigma = estimate(factor)
    do k = 1, most_halvings
      sigma = sigma / 2
      factor = matrix
      do i = 1, n
        factor(i, i) = factor(i, i) - sigma
      end do
      call factor_cholesky(n, factor, info)
      if (info == 0) return
    end do
    sigma = 0
  end function bound_of_eigenvalues

  !> Returns the Rayleigh quotient 1 / (x'A^-1 x) after some steps of inverse iteration from a vector without symmetries.
  real(rk) function estimate(factor)
    !> of factor_cholesky
    real(rk), contiguous, intent(in) :: factor(:, :)
    integer, parameter :: n_steps = 12
    real(rk), parameter :: golden_ratio = 0.5_rk * (1 + sqrt(5.0_rk))
    real(rk) :: before(size(factor, 1)), vector(size(factor, 1))
    integer :: i

    vector = [(modulo(i * golden_ratio, 1.0_rk) - 0.5_rk, i=1, size(vector))]
    estimate = huge(estimate)
    do i = 1, n_steps
      before = vector / norm2(vector)
      vector = before
      call solve_cholesky(size(vector), factor, vector)
      estimate = min(estimate, 1 / dot_product(before, vector))
    end do
  end function estimate
end module sig_least_eigenvalue
