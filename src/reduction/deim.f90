! SPDX-License-Identifier: BSD-3-Clause
!> Discrete empirical interpolation (DEIM): chooses as many rows of a basis as it has columns. The values of a combination of the
!> modes on these rows determine the combination.
module sig_deim
  use sig_kinds, only: rk
  use sig_ties, only: first_largest
  implicit none(type, external)
  private
  public :: deim_rows

contains

  !> Returns the interpolation rows of a basis, one per column, in the order in which they are found.
  !>
  !> Columns 1 to k - 1 interpolate column k from its values on rows 1 to k - 1. Row k is the row where column k differs most from
  !> this interpolation. Each residual is scaled to 1 in its own row; the interpolation is then a step of Gauss elimination, and no
  !> linear system is solved. Of nearly equal rows the one with the lowest number is taken, so that rounding (number of
  !> ranks, BLAS) does not change the choice.
  !>
  !> Source: Chaturantabut and Sorensen, SIAM J. Sci. Comput. 32 (2010), algorithm 1. Local. Cost: n_rows * n_modes**2. Requires:
  !> independent columns, and not more columns than rows.
  pure function deim_rows(basis) result(rows)
    !> modes of displacements (rows: natural dofs) or of contact forces (rows: contact rows), shape (n_rows, n_modes)
    real(rk), intent(in) :: basis(:, :)
    !> numbers of the rows of the basis, 1-based, shape (n_modes)
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
