! SPDX-License-Identifier: BSD-3-Clause
!> Small dense linear algebra on top of LAPACK: factors that are kept, solves, inverses, singular values.
module sig_linear_algebra
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
  use sig_kinds, only: rk
  use sig_lapack_interfaces, only: dasum, dgecon, dgemm, dgemv, dgesdd, dgetrf, dgetrs, dlange, idamax
  implicit none(type, external)
  private
  public :: lu_t, add_product, multiply, multiply_transpose, transposed_product, solve_dense, invert, reciprocal_condition
  public :: singular_values, svd, unit_vector, largest_size, sum_of_sizes

  !> below this reciprocal condition number (1-norm) the solution has no correct digit left
  real(rk), parameter, public :: singular_reciprocal = 4.0_rk * epsilon(1.0_rk)

  !> LU factors of a square matrix, for any number of solves.
  type :: lu_t
    integer :: n = 0
    !> [-] of the matrix in the 1-norm; 0 when singular or not finite, 1 when empty
    real(rk) :: reciprocal_condition = 1
    !> numerically: no digit of a solution would be right
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

  !> y = alpha a x + beta y, without a temporary array.
  subroutine multiply(alpha, a, x, beta, y)
    real(rk), intent(in) :: alpha
    !> shape (m, n)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (n)
    real(rk), contiguous, intent(in) :: x(:)
    real(rk), intent(in) :: beta
    !> shape (m); with beta = 0 what it holds does not matter
    real(rk), contiguous, intent(inout) :: y(:)

    if (size(y) == 0) return
    if (size(x) == 0) then
      if (abs(beta) <= 0) y = 0
      return
    end if
    call dgemv('N', size(a, 1), size(a, 2), alpha, a, size(a, 1), x, 1, beta, y, 1)
  end subroutine multiply

  !> y = alpha a' x + beta y, without a temporary array.
  subroutine multiply_transpose(alpha, a, x, beta, y)
    real(rk), intent(in) :: alpha
    !> shape (m, n)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (m)
    real(rk), contiguous, intent(in) :: x(:)
    real(rk), intent(in) :: beta
    !> shape (n); with beta = 0 what it holds does not matter
    real(rk), contiguous, intent(inout) :: y(:)

    if (size(y) == 0) return
    if (size(x) == 0) then
      y = beta * y
      return
    end if
    call dgemv('T', size(a, 1), size(a, 2), alpha, a, size(a, 1), x, 1, beta, y, 1)
  end subroutine multiply_transpose

  !> Factors a square matrix; look at is_singular before a solve.
  subroutine lu_factor(self, a)
    class(lu_t), intent(inout) :: self
    !> shape (n, n)
    real(rk), intent(in) :: a(:, :)
    integer :: info

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
    call dgetrf(self%n, self%n, self%factors, self%n, self%pivots, info)
    if (info /= 0) return
    self%reciprocal_condition = factored_reciprocal(a, self%factors)
    self%is_singular = .not. self%reciprocal_condition > singular_reciprocal
  end subroutine lu_factor

  !> 1-norm reciprocal condition number of a from its factors.
  function factored_reciprocal(a, factors) result(reciprocal)
    real(rk), intent(in) :: a(:, :)
    real(rk), intent(in) :: factors(:, :)
    real(rk) :: reciprocal
    real(rk) :: norm, work(4 * size(a, 1))
    integer :: info, iwork(size(a, 1)), n

    n = size(a, 1)
    norm = dlange('1', n, n, a, n, work)
    call dgecon('1', n, factors, n, norm, reciprocal, work, iwork, info)
    if (info /= 0) reciprocal = 0
  end function factored_reciprocal

  !> x = A^-1 b.
  function lu_solve_vector(self, b) result(x)
    class(lu_t), intent(in) :: self
    !> shape (n)
    real(rk), intent(in) :: b(:)
    !> shape (n)
    real(rk) :: x(size(b))
    integer :: info

    x = b
    if (self%n == 0) return
    call dgetrs('N', self%n, 1, self%factors, self%n, self%pivots, x, self%n, info)
  end function lu_solve_vector

  !> X = A^-1 B.
  function lu_solve_matrix(self, b) result(x)
    class(lu_t), intent(in) :: self
    !> shape (n, m)
    real(rk), intent(in) :: b(:, :)
    !> shape (n, m)
    real(rk), allocatable :: x(:, :)
    integer :: info

    x = b
    if (size(x) == 0) return
    call dgetrs('N', self%n, size(b, 2), self%factors, self%n, self%pivots, x, self%n, info)
  end function lu_solve_matrix

  !> Solves a x = b once; x is zero when the matrix is numerically singular.
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

  !> Solves a X = B once; X is zero when the matrix is numerically singular.
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

  !> Inverse of a square matrix; zero when it is numerically singular.
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

  !> Reciprocal condition number in the 1-norm (estimate); 1 for an empty matrix, 0 for a singular one.
  function reciprocal_condition(a) result(reciprocal)
    !> shape (n, n)
    real(rk), intent(in) :: a(:, :)
    !> [-]
    real(rk) :: reciprocal
    type(lu_t) :: lu

    call lu%factor(a)
    reciprocal = lu%reciprocal_condition
  end function reciprocal_condition

  !> c = c + factor * a b.
  subroutine add_product(factor, a, b, c)
    real(rk), intent(in) :: factor
    !> shape (m, k)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (k, n)
    real(rk), contiguous, intent(in) :: b(:, :)
    !> shape (m, n)
    real(rk), contiguous, intent(inout) :: c(:, :)

    if (size(c) == 0 .or. size(b) == 0) return
    call dgemm('N', 'N', size(a, 1), size(b, 2), size(a, 2), factor, a, size(a, 1), b, size(b, 1), 1.0_rk, c, size(c, 1))
  end subroutine add_product

  !> c = a' b.
  function transposed_product(a, b) result(c)
    !> shape (k, m)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (k, n)
    real(rk), contiguous, intent(in) :: b(:, :)
    !> shape (m, n)
    real(rk), allocatable :: c(:, :)

    allocate (c(size(a, 2), size(b, 2)), source=0.0_rk)
    if (size(c) == 0 .or. size(a, 1) == 0) return
    call dgemm('T', 'N', size(a, 2), size(b, 2), size(a, 1), 1.0_rk, a, size(a, 1), b, size(b, 1), 0.0_rk, c, size(c, 1))
  end function transposed_product

  !> Singular values in descending order; all NaN when the matrix is not finite.
  function singular_values(a) result(values)
    !> shape (n_rows, n_columns)
    real(rk), intent(in) :: a(:, :)
    !> shape (min(n_rows, n_columns))
    real(rk), allocatable :: values(:)
    real(rk) :: no_vectors(1, 1)

    allocate (values(minval(shape(a))), source=0.0_rk)
    call run_dgesdd('N', a, values, no_vectors, no_vectors)
  end function singular_values

  !> Thin singular value decomposition a = u diag(s) vt.
  subroutine svd(a, u, s, vt)
    !> shape (n_rows, n_columns)
    real(rk), intent(in) :: a(:, :)
    !> orthonormal columns, shape (n_rows, min(n_rows, n_columns))
    real(rk), allocatable, intent(out) :: u(:, :)
    !> descending, shape (min(n_rows, n_columns)); NaN when a is not finite
    real(rk), allocatable, intent(out) :: s(:)
    !> orthonormal rows, shape (min(n_rows, n_columns), n_columns)
    real(rk), allocatable, intent(out) :: vt(:, :)
    integer :: n

    n = minval(shape(a))
    allocate (u(size(a, 1), n), s(n), vt(n, size(a, 2)), source=0.0_rk)
    call run_dgesdd('S', a, s, u, vt)
  end subroutine svd

  !> dgesdd with its work space; a matrix that is not finite (LAPACK might not return) or no convergence gives NaN.
  subroutine run_dgesdd(job, a, s, u, vt)
    character(1), intent(in) :: job
    real(rk), intent(in) :: a(:, :)
    real(rk), intent(inout) :: s(:)
    real(rk), intent(inout) :: u(:, :)
    real(rk), intent(inout) :: vt(:, :)
    real(rk), allocatable :: copy(:, :), work(:)
    real(rk) :: work_size(1)
    integer, allocatable :: iwork(:)
    integer :: info, m, n

    m = size(a, 1)
    n = size(a, 2)
    if (m == 0 .or. n == 0) return
    s = ieee_value(s, ieee_quiet_nan)
    if (.not. all(ieee_is_finite(a))) return
    copy = a
    allocate (iwork(8 * min(m, n)))
    call dgesdd(job, m, n, copy, m, s, u, size(u, 1), vt, size(vt, 1), work_size, -1, iwork, info)
    allocate (work(int(work_size(1))))
    call dgesdd(job, m, n, copy, m, s, u, size(u, 1), vt, size(vt, 1), work, size(work), iwork, info)
    if (info /= 0) s = ieee_value(s, ieee_quiet_nan)
  end subroutine run_dgesdd

  !> Largest |x_i|, 0 of none. Several times as fast as maxval(abs(x)), which waits for each comparison.
  pure real(rk) function largest_size(x)
    real(rk), contiguous, intent(in) :: x(:)

    largest_size = 0
    if (size(x) > 0) largest_size = abs(x(max(1, idamax(size(x), x, 1))))
  end function largest_size

  !> Sum of |x_i|.
  pure real(rk) function sum_of_sizes(x)
    real(rk), contiguous, intent(in) :: x(:)

    sum_of_sizes = dasum(size(x), x, 1)
  end function sum_of_sizes

  !> Column i of the unit matrix.
  pure function unit_vector(n, i) result(vector)
    integer, intent(in) :: n
    integer, intent(in) :: i
    real(rk) :: vector(n)

    vector = 0
    vector(i) = 1
  end function unit_vector
end module sig_linear_algebra
