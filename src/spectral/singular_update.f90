! SPDX-License-Identifier: BSD-3-Clause
!> Extreme singular values of a matrix with one more column, computed from the decomposition of the matrix without it.
module sig_singular_update
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use sig_kinds, only: rk
  use sig_singular_values, only: svd
  implicit none(type, external)
  private
  public :: column_space_t, decompose_columns, keep_largest, ratio_with_column

  !> largest number of halvings of an interval; roots near zero need more than 53, the number of bits of a mantissa
  integer, parameter :: n_halvings = 200

  !> The parts of A = U diag(s) V' that are needed.
  type :: column_space_t
    !> orthonormal columns, shape (n_rows, min(n_rows, n_columns))
    real(rk), allocatable :: left(:, :)
    !> descending, shape (min(n_rows, n_columns))
    real(rk), allocatable :: values(:)
  end type column_space_t

contains

  !> Computes the left singular vectors and the singular values of a matrix A. If A is not finite or LAPACK fails, the values are
  !> NaN and the vectors of no use.
  subroutine decompose_columns(matrix, space)
    !> shape (n_rows, n_columns)
    real(rk), intent(in) :: matrix(:, :)
    type(column_space_t), intent(out) :: space
    real(rk), allocatable :: right(:, :)

    call svd(matrix, space%left, space%values, right)
  end subroutine decompose_columns

  !> Keeps only the n largest singular values of A and their left vectors, as if all others were zero. Requires: n is at most the
  !> number of values.
  pure subroutine keep_largest(space, n)
    type(column_space_t), intent(inout) :: space
    integer, intent(in) :: n

    space%left = space%left(:, :n)
    space%values = space%values(:n)
  end subroutine keep_largest

  !> Returns the ratio of the largest to the smallest singular value of [A, c], the matrix A of decompose_columns with one more
  !> column c; infinite where the smallest is zero or not a number. With n values in `space`, only the min(n_rows, n + 1) largest
  !> ones of [A, c] count: zeros that keep_largest made of values of A do not. Requires: at least one row.
  !>
  !> The squares of the singular values of [A, c] are the roots x of 1 + sum_i z_i**2 / (d_i**2 - x) = 0. The d_i are the singular
  !> values of A, and z = U' c. Where there are fewer values than rows, there is one more d_i = 0, whose z_i is the length of the
  !> part of c outside of the columns of A. The equation is solved for x**(1/2) with differences of the d_i. Nothing is squared, so
  !> that small values are as exact as in the decomposition of A.
  !> Source: Golub, SIAM Review 15 (1973), section 5. Local. Cost: n_rows * size of d.
  pure real(rk) function ratio_with_column(space, column) result(ratio)
    !> of A
    type(column_space_t), intent(in) :: space
    !> c, shape (n_rows); finite
    real(rk), intent(in) :: column(:)
    real(rk), allocatable :: poles(:), weights(:)
    real(rk) :: components(size(space%values)), smallest
    integer :: n

    n = size(space%values)
    if (n < size(column)) then
      allocate (poles(n + 1), weights(n + 1))
      weights(1) = outside_part(space%left, column)
      poles(1) = 0
    else
      allocate (poles(n), weights(n))
    end if
    associate (first => size(poles) - n)
      poles(first + 1:) = space%values(n:1:-1)
      ! gfortran's matmul writes beyond its work space where a long matrix comes with reversed columns
      components = matmul(column, space%left)
      weights(first + 1:) = components(n:1:-1)
    end associate
    smallest = smallest_root(poles, weights)
    ratio = ieee_value(ratio, ieee_positive_inf)
    if (smallest > 0) ratio = largest_root(poles, weights) / smallest
  end function ratio_with_column

  !> Returns the length of a column after its part in the span of orthonormal columns is taken away; 0 if only rounding is left.
  pure real(rk) function outside_part(basis, column) result(length)
    !> the orthonormal columns, shape (n_rows, n)
    real(rk), intent(in) :: basis(:, :)
    real(rk), intent(in) :: column(:)
    real(rk) :: rest(size(column))
    integer :: repetition

    rest = column
    ! two passes, because the first one leaves rounding relative to the part that it takes away
    do repetition = 1, 2
      rest = rest - matmul(basis, matmul(rest, basis))
    end do
    length = norm2(rest)
    if (length <= epsilon(length) * norm2(column)) length = 0
  end function outside_part

  !> Returns the smallest root x^(1/2) of the equation of ratio_with_column. It lies between the two lowest poles (above the pole,
  !> if there is one only). It is the lowest pole itself where the weight of this pole is zero.
  pure real(rk) function smallest_root(poles, weights) result(root)
    !> d_i, ascending, >= 0
    real(rk), intent(in) :: poles(:)
    !> z_i
    real(rk), intent(in) :: weights(:)
    real(rk) :: upper

    root = poles(1)
    if (abs(weights(1)) <= 0) return
    if (size(poles) == 1) then
      root = hypot(poles(1), weights(1))
      return
    end if
    upper = poles(2)
    root = poles(1) + offset_of_root(poles, weights, 1, upper - poles(1))
  end function smallest_root

  !> Returns the root x^(1/2) above the highest pole, or that pole where no root lies above it.
  pure real(rk) function largest_root(poles, weights) result(root)
    !> poles and weights as in smallest_root
    real(rk), intent(in) :: poles(:)
    real(rk), intent(in) :: weights(:)

    associate (top => poles(size(poles)))
      root = top + offset_of_root(poles, weights, size(poles), hypot(top, norm2(weights)) - top)
    end associate
  end function largest_root

  !> Finds by halving the offset, 0 < offset < widest, where 1 + sum_i z_i**2 / ((d_i - s) (d_i + s)) changes from negative to
  !> positive, with the singular value s = d_k + offset. If it is positive everywhere, the result is next to 0.
  pure real(rk) function offset_of_root(poles, weights, i_pole, widest) result(offset)
    !> poles and weights as in smallest_root
    real(rk), intent(in) :: poles(:)
    real(rk), intent(in) :: weights(:)
    !> k
    integer, intent(in) :: i_pole
    !> upper limit of the offset; also the result if the sum is negative everywhere below it
    real(rk), intent(in) :: widest
    real(rk) :: differences(size(poles)), sums(size(poles)), lower, upper
    integer :: i

    differences = poles - poles(i_pole)
    sums = poles + poles(i_pole)
    lower = 0
    upper = widest
    do i = 1, n_halvings
      offset = lower + (upper - lower) / 2
      if (offset <= lower .or. offset >= upper) exit
      if (1 + sum(weights**2 / ((differences - offset) * (sums + offset))) > 0) then
        upper = offset
      else
        lower = offset
      end if
    end do
    offset = upper
  end function offset_of_root
end module sig_singular_update
