! SPDX-License-Identifier: BSD-3-Clause
!> Columns of a matrix that do not depend linearly on each other.
module sig_independent_columns
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: independent_columns

contains

  !> Returns the numbers of independent columns on which all other columns depend, 1-based, in the order of choice; their number is
  !> the rank. Each time it takes the column of which most is left after its parts along the chosen columns are removed (modified
  !> Gram-Schmidt). The cost is 4 m n rank operations for a matrix of shape (m, n).
  pure function independent_columns(matrix, least) result(chosen)
    !> shape (m, n)
    real(rk), intent(in) :: matrix(:, :)
    !> what is left of a column is rounding if its norm is at most this
    real(rk), intent(in) :: least
    integer, allocatable :: chosen(:)
    real(rk) :: rest(size(matrix, 1), size(matrix, 2)), left(size(matrix, 2))
    integer :: best, i, k

    allocate (chosen(0))
    rest = matrix
    do k = 1, minval(shape(matrix))
      left = [(sqrt(dot_product(rest(:, i), rest(:, i))), i=1, size(left))]
      best = maxloc(left, dim=1)
      if (left(best) <= least) return
      chosen = [chosen, best]
      rest(:, best) = rest(:, best) / left(best)
      do i = 1, size(left)
        if (all(chosen /= i)) rest(:, i) = rest(:, i) - dot_product(rest(:, best), rest(:, i)) * rest(:, best)
      end do
      rest(:, best) = 0
    end do
  end function independent_columns
end module sig_independent_columns
