! SPDX-License-Identifier: BSD-3-Clause
!> Combinations of contact forces whose displacements are orthonormal in the norm of K. With H = K^-1 B' and C = B H, the product of
!> two displacements H x and H y in this norm is x'C y, so that no displacement is needed to choose them.
module sig_energy_modes
  use sig_dense_kernels, only: factor_cholesky, reduce_cholesky
  use sig_kinds, only: rk
  use sig_linear_algebra, only: add_product, transposed_product
  use sig_singular_values, only: svd
  implicit none(type, external)
  private
  public :: choose_combinations, product_of

  !> [-] principal displacements below this share of the largest one are rounding
  real(rk), parameter :: rounding = 1.0e-6_rk

contains

  !> Finds combinations S with S'C S = 1 for the principal displacements of some states, largest first; those that are rounding are
  !> left out.
  subroutine choose_combinations(states, compliance, combinations)
    !> [force] shape (n_rows, n_states); each counts with its size
    real(rk), contiguous, intent(in) :: states(:, :)
    !> [length/force] C, shape (n_rows, n_rows); symmetric on the rows with forces
    real(rk), contiguous, intent(in) :: compliance(:, :)
    !> S, shape (n_rows, n_modes)
    real(rk), allocatable, intent(out) :: combinations(:, :)
    real(rk), allocatable :: s(:), u(:, :), vt(:, :)
    integer :: i, n

    call svd(transposed_product(states, product_of(compliance, states)), u, s, vt)
    n = count(s > rounding**2 * maxval([0.0_rk, s]))
    do i = 1, n
      u(:, i) = u(:, i) / sqrt(s(i))
    end do
    combinations = product_of(states, u(:, :n))
    call orthonormalize(compliance, combinations)
  end subroutine choose_combinations

  !> Returns the product of two matrices.
  function product_of(a, b) result(c)
    real(rk), contiguous, intent(in) :: a(:, :)
    real(rk), contiguous, intent(in) :: b(:, :)
    real(rk), allocatable :: c(:, :)

    allocate (c(size(a, 1), size(b, 2)), source=0.0_rk)
    call add_product(1.0_rk, a, b, c)
  end function product_of

  !> Makes S'C S = 1 to rounding: of the decomposition it is so only to its rounding over the square of the smallest principal
  !> displacement. It takes its Cholesky factor. The spans of the leading columns stay. Columns behind one that depends on
  !> others are dropped.
  subroutine orthonormalize(compliance, combinations)
    !> C
    real(rk), contiguous, intent(in) :: compliance(:, :)
    !> S
    real(rk), allocatable, intent(inout) :: combinations(:, :)
    real(rk), allocatable :: factor(:, :), transposed(:, :)
    integer :: i, info, n

    n = size(combinations, 2)
    do
      factor = transposed_product(combinations(:, :n), product_of(compliance, combinations(:, :n)))
      call factor_cholesky(n, factor, info)
      if (info == 0) exit
      n = info - 1
    end do
    transposed = transpose(combinations(:, :n))
    do i = 1, size(transposed, 2)
      call reduce_cholesky(n, factor, transposed(:, i))
    end do
    combinations = transpose(transposed)
  end subroutine orthonormalize

end module sig_energy_modes
