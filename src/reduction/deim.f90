! SPDX-License-Identifier: BSD-3-Clause
!> Discrete empirical interpolation: as many rows of a basis as it has columns, so that the basis is known from them.
module sig_deim
  use sig_kinds, only: rk
  use sig_ties, only: first_largest
  implicit none(type, external)
  private
  public :: deim_rows

contains

  !> Interpolation rows of a basis, one per column, in the order in which they are found.
  !>
  !> Row k is where column k differs most from its interpolation by the columns before it in the rows before it. With residuals
  !> scaled to 1 in their own row, the interpolation is the elimination step of Gauss: no linear system.
  !> Source: Chaturantabut and Sorensen, SIAM J. Sci. Comput. 32 (2010), algorithm 1. Local. Cost: n_dofs * n_modes**2.
  !> Ties go to the lowest natural number, so that rounding (rank count, BLAS) does not change the choice.
  !> Requires: independent columns, not more than rows.
  pure function deim_rows(basis) result(rows)
    !> shape (n_dofs, n_modes)
    real(rk), intent(in) :: basis(:, :)
    !> shape (n_modes), natural numbers
    integer :: rows(size(basis, 2))
    real(rk) :: residuals(size(basis, 1), size(basis, 2))
    integer :: i_mode, j_mode

    residuals = basis
    do i_mode = 1, size(basis, 2)
      associate (residual => residuals(:, i_mode))
        do j_mode = 1, i_mode - 1
          residual = residual - residual(rows(j_mode)) * residuals(:, j_mode)
        end do
        rows(i_mode) = first_largest(abs(residual))
        residual = residual / residual(rows(i_mode))
      end associate
    end do
  end function deim_rows
end module sig_deim
