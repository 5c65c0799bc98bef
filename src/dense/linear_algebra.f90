! SPDX-License-Identifier: BSD-3-Clause
!> Small dense linear algebra: LU factors for several solves, single solves, inverses, products.
module sig_linear_algebra
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_dense_kernels, only: add_columns_and_sizes, add_product, factor_lu, largest_size, multiply, multiply_transpose, &
    reciprocal_condition_lu, solve_lu, sum_of_sizes, transposed_product
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: lu_t, add_product, multiply, multiply_transpose, transposed_product, solve_dense, invert
  public :: unit_vector, largest_size, sum_of_sizes, sum_rows

  !> [-] a matrix with at most this reciprocal condition number (1-norm) is singular: a solution would have no correct digit
  real(rk), parameter, public :: singular_reciprocal = 4.0_rk * epsilon(1.0_rk)

  !> LU factors of a square matrix, for any number of solves.
  type :: lu_t
    integer :: n = 0
    !> [-] estimate in the 1-norm; 0 where the matrix cannot be factored or is not finite, 1 where it is empty
    real(rk) :: reciprocal_condition = 1
    !> whether the matrix is numerically singular (singular_reciprocal) or not finite
    logical :: is_singular = .false.
    real(rk), allocatable, private :: factors(:, :)
    integer, allocatable, private :: pivots(:)
  contains
    procedure :: factor => lu_factor
    procedure, private :: lu_solve_vector, lu_solve_matrix
    generic :: solve => lu_solve_vector, lu_solve_matrix
  end type lu_t

  interface solve_dense
    procedure solve_dense_vector, solve_dense_matrix
  end interface solve_dense

contains

  !> Factors a square matrix. Where is_singular is true afterwards (numerically singular or not finite), `solve` must not be called.
  !> An empty matrix is not singular.
  subroutine lu_factor(self, a)
    class(lu_t), intent(inout) :: self
    !> shape (n, n)
    real(rk), intent(in) :: a(:, :)
    real(rk) :: work(size(a, 1))
    integer :: info, signs(size(a, 1))

    self%n = size(a, 1)
    self%factors = a
    if (allocated(self%pivots)) deallocate (self%pivots)
    allocate (self%pivots(self%n))
    self%reciprocal_condition = 1
    self%is_singular = .false.
    if (self%n == 0) return
    self%reciprocal_condition = 0
    self%is_singular = .true.
    if (.not. all(ieee_is_finite(a))) return
    call factor_lu(self%n, self%factors, self%pivots, info)
    if (info /= 0) return
    self%reciprocal_condition = reciprocal_condition_lu(self%n, self%factors, maxval(sum(abs(a), dim=1)), work, signs)
    self%is_singular = .not. self%reciprocal_condition > singular_reciprocal
  end subroutine lu_factor

  !> Returns x = A^-1 b. Requires: `factor`, and is_singular is false.
  function lu_solve_vector(self, b) result(x)
    class(lu_t), intent(in) :: self
    !> shape (n)
    real(rk), intent(in) :: b(:)
    !> shape (n)
    real(rk) :: x(size(b))

    x = b
    call solve_lu(self%n, self%factors, self%pivots, x)
  end function lu_solve_vector

  !> Returns X = A^-1 B. Requires: `factor`, and is_singular is false.
  function lu_solve_matrix(self, b) result(x)
    class(lu_t), intent(in) :: self
    !> shape (n, m)
    real(rk), intent(in) :: b(:, :)
    !> shape (n, m)
    real(rk), allocatable :: x(:, :)

    x = b
    call solve_lu(self%n, self%factors, self%pivots, x)
  end function lu_solve_matrix

  !> Solves a x = b. Where the matrix is numerically singular or not finite, is_singular is true and x is zero.
  subroutine solve_dense_vector(a, b, x, is_singular)
    !> shape (n, n)
    real(rk), intent(in) :: a(:, :)
    !> shape (n)
    real(rk), intent(in) :: b(:)
    !> shape (n)
    real(rk), intent(out) :: x(:)
    logical, intent(out) :: is_singular
    type(lu_t) :: lu

    call lu%factor(a)
    is_singular = lu%is_singular
    x = 0
    if (.not. is_singular) x = lu%solve(b)
  end subroutine solve_dense_vector

  !> Solves a X = B. Where the matrix is numerically singular or not finite, is_singular is true and X is zero.
  subroutine solve_dense_matrix(a, b, x, is_singular)
    !> shape (n, n)
    real(rk), intent(in) :: a(:, :)
    !> shape (n, m)
    real(rk), intent(in) :: b(:, :)
    !> shape (n, m)
    real(rk), intent(out) :: x(:, :)
    logical, intent(out) :: is_singular
    type(lu_t) :: lu

    call lu%factor(a)
    is_singular = lu%is_singular
    x = 0
    if (.not. is_singular) x = lu%solve(b)
  end subroutine solve_dense_matrix

  !> Computes the inverse of a square matrix. Where the matrix is numerically singular or not finite, is_singular is true and the
  !> inverse is zero.
  subroutine invert(a, inverse, is_singular)
    !> shape (n, n)
    real(rk), intent(in) :: a(:, :)
    !> shape (n, n)
    real(rk), intent(out) :: inverse(:, :)
    logical, intent(out) :: is_singular
    real(rk), allocatable :: identity(:, :)
    integer :: i_row

    allocate (identity(size(a, 1), size(a, 1)), source=0.0_rk)
    do i_row = 1, size(a, 1)
      identity(i_row, i_row) = 1
    end do
    call solve_dense(a, identity, inverse, is_singular)
  end subroutine invert

  !> Returns column i of the unit matrix of order n: zeros with a 1 at i.
  pure function unit_vector(n, i) result(vector)
    integer, intent(in) :: n
    !> 1 to n
    integer, intent(in) :: i
    real(rk) :: vector(n)

    vector = 0
    vector(i) = 1
  end function unit_vector

  !> Computes w = A x + b, and for each row the sum of the absolute values of the terms, |b_i| + sum_j |A_ij x_j|.
  pure subroutine sum_rows(a, x, b, w, row_size)
    !> shape (n, n)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (n)
    real(rk), contiguous, intent(in) :: x(:)
    !> n or more elements, as w and row_size
    real(rk), intent(in) :: b(:)
    real(rk), contiguous, intent(inout) :: w(:)
    real(rk), contiguous, intent(inout) :: row_size(:)

    associate (n => size(x))
      w(:n) = b(:n)
      row_size(:n) = abs(b(:n))
      call add_columns_and_sizes(a, x, w(:n), row_size(:n))
    end associate
  end subroutine sum_rows
end module sig_linear_algebra
