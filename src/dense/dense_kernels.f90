! SPDX-License-Identifier: BSD-3-Clause
!> Products and factorizations of dense matrices without BLAS and LAPACK. They call the C functions of
!> include/signorom/dense_kernels.h, which describes them in more detail.
!>
!> Any number of threads may call these procedures, because they keep nothing. Only transposed_product allocates memory. The same
!> numbers give the same bits on the same kind of processor.
module sig_dense_kernels
  use, intrinsic :: iso_c_binding, only: c_double, c_float, c_int
  use sig_kinds, only: rk, sk
  implicit none(type, external)
  private
  public :: multiply, multiply_transpose, add_few_columns, add_columns_and_sizes
  public :: add_single_columns, add_single_products
  public :: add_product, add_transposed_product, transposed_product
  public :: factor_lu, solve_lu, reciprocal_condition_lu, factor_cholesky, solve_cholesky, reduce_cholesky
  public :: extend_cholesky, reciprocal_condition_cholesky
  public :: largest_size, sum_of_sizes

  interface solve_lu
    procedure solve_lu_vector, solve_lu_matrix
  end interface solve_lu

  interface solve_cholesky
    procedure solve_cholesky_vector, solve_cholesky_matrix
  end interface solve_cholesky

  ! include/signorom/dense_kernels.h describes these procedures in C.
  interface
    pure subroutine sig_multiply(m, n, alpha, a, lda, x, beta, y) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: m, n, lda
      real(c_double), value, intent(in) :: alpha, beta
      real(c_double), intent(in) :: a(*), x(*)
      real(c_double), intent(inout) :: y(*)
    end subroutine sig_multiply

    pure subroutine sig_add_few_columns(m, n, a, lda, x, y) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: m, n, lda
      real(c_double), intent(in) :: a(*), x(*)
      real(c_double), intent(inout) :: y(*)
    end subroutine sig_add_few_columns

    pure subroutine sig_add_columns_and_sizes(m, n, a, lda, x, y, sizes) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: m, n, lda
      real(c_double), intent(in) :: a(*), x(*)
      real(c_double), intent(inout) :: y(*), sizes(*)
    end subroutine sig_add_columns_and_sizes

    pure subroutine sig_reduce_cholesky(n, factor, ldf, b) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: n, ldf
      real(c_double), intent(in) :: factor(*)
      real(c_double), intent(inout) :: b(*)
    end subroutine sig_reduce_cholesky

    pure subroutine sig_multiply_transpose(m, n, alpha, a, lda, x, beta, y) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: m, n, lda
      real(c_double), value, intent(in) :: alpha, beta
      real(c_double), intent(in) :: a(*), x(*)
      real(c_double), intent(inout) :: y(*)
    end subroutine sig_multiply_transpose

    pure subroutine sig_add_single_columns(m, n, a, x, y) bind(c)
      import :: c_double, c_float, c_int
      integer(c_int), value, intent(in) :: m, n
      real(c_float), intent(in) :: a(*)
      real(c_double), intent(in) :: x(*)
      real(c_double), intent(inout) :: y(*)
    end subroutine sig_add_single_columns

    pure subroutine sig_add_single_products(m, n, a, x, y) bind(c)
      import :: c_double, c_float, c_int
      integer(c_int), value, intent(in) :: m, n
      real(c_float), intent(in) :: a(*)
      real(c_double), intent(in) :: x(*)
      real(c_double), intent(inout) :: y(*)
    end subroutine sig_add_single_products

    pure subroutine sig_add_product(a_is_transposed, b_is_transposed, m, n, k, alpha, a, lda, b, ldb, c, ldc) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: a_is_transposed, b_is_transposed, m, n, k, lda, ldb, ldc
      real(c_double), value, intent(in) :: alpha
      real(c_double), intent(in) :: a(*), b(*)
      real(c_double), intent(inout) :: c(*)
    end subroutine sig_add_product

    integer(c_int) function sig_factor_lu(n, a, lda, pivots) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: n, lda
      real(c_double), intent(inout) :: a(*)
      integer(c_int), intent(inout) :: pivots(*)
    end function sig_factor_lu

    pure subroutine sig_solve_lu(n, n_rhs, factors, ldf, pivots, b, ldb) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: n, n_rhs, ldf, ldb
      real(c_double), intent(in) :: factors(*)
      integer(c_int), intent(in) :: pivots(*)
      real(c_double), intent(inout) :: b(*)
    end subroutine sig_solve_lu

    real(c_double) function sig_reciprocal_condition_lu(n, factors, ldf, norm, work, signs) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: n, ldf
      real(c_double), intent(in) :: factors(*)
      real(c_double), value, intent(in) :: norm
      real(c_double), intent(inout) :: work(*)
      integer(c_int), intent(inout) :: signs(*)
    end function sig_reciprocal_condition_lu

    integer(c_int) function sig_factor_cholesky(n, a, lda) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: n, lda
      real(c_double), intent(inout) :: a(*)
    end function sig_factor_cholesky

    integer(c_int) function sig_extend_cholesky(n_columns, n_rows, n, a, lda) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: n_columns, n_rows, n, lda
      real(c_double), intent(inout) :: a(*)
    end function sig_extend_cholesky

    pure subroutine sig_solve_cholesky(n, n_rhs, factor, ldf, b, ldb) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: n, n_rhs, ldf, ldb
      real(c_double), intent(in) :: factor(*)
      real(c_double), intent(inout) :: b(*)
    end subroutine sig_solve_cholesky

    real(c_double) function sig_reciprocal_condition_cholesky(n, factor, ldf, norm, work, signs) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: n, ldf
      real(c_double), intent(in) :: factor(*)
      real(c_double), value, intent(in) :: norm
      real(c_double), intent(inout) :: work(*)
      integer(c_int), intent(inout) :: signs(*)
    end function sig_reciprocal_condition_cholesky

    pure real(c_double) function sig_largest_size(n, x) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: n
      real(c_double), intent(in) :: x(*)
    end function sig_largest_size

    pure real(c_double) function sig_sum_of_sizes(n, x) bind(c)
      import :: c_double, c_int
      integer(c_int), value, intent(in) :: n
      real(c_double), intent(in) :: x(*)
    end function sig_sum_of_sizes
  end interface

contains

  !> Computes y = alpha a x + beta y, without a temporary array.
  subroutine multiply(alpha, a, x, beta, y)
    real(rk), intent(in) :: alpha
    !> shape (m, n)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (n)
    real(rk), contiguous, intent(in) :: x(:)
    real(rk), intent(in) :: beta
    !> shape (m); with beta = 0 its values before the call do not matter
    real(rk), contiguous, intent(inout) :: y(:)

    call sig_multiply(size(y), size(x), alpha, a, size(a, 1), x, beta, y)
  end subroutine multiply

  !> Computes y = y + a x for an x that is mostly zero. The columns of a that belong to zeros are not read.
  subroutine add_few_columns(a, x, y)
    !> shape (m, n)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (n)
    real(rk), contiguous, intent(in) :: x(:)
    !> shape (m)
    real(rk), contiguous, intent(inout) :: y(:)

    call sig_add_few_columns(size(y), size(x), a, size(a, 1), x, y)
  end subroutine add_few_columns

  !> Computes y = y + a x, and adds the sizes of all terms of this sum to sizes. Columns that belong to zeros in x are not read.
  pure subroutine add_columns_and_sizes(a, x, y, sizes)
    !> shape (m, n)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (n)
    real(rk), contiguous, intent(in) :: x(:)
    !> shape (m)
    real(rk), contiguous, intent(inout) :: y(:)
    !> shape (m)
    real(rk), contiguous, intent(inout) :: sizes(:)

    call sig_add_columns_and_sizes(size(y), size(x), a, size(a, 1), x, y, sizes)
  end subroutine add_columns_and_sizes

  !> Computes y = y + a x for a matrix in single precision, with sums in double precision. Columns that belong to zeros in x are
  !> not read.
  pure subroutine add_single_columns(a, x, y)
    !> column by column, shape (m * n)
    real(sk), contiguous, intent(in) :: a(:)
    !> shape (n)
    real(rk), contiguous, intent(in) :: x(:)
    !> shape (m)
    real(rk), contiguous, intent(inout) :: y(:)

    call sig_add_single_columns(size(y), size(x), a, x, y)
  end subroutine add_single_columns

  !> Computes y = y + a' x for a matrix in single precision, with sums in double precision.
  pure subroutine add_single_products(a, x, y)
    !> column by column, shape (m * n)
    real(sk), contiguous, intent(in) :: a(:)
    !> shape (m)
    real(rk), contiguous, intent(in) :: x(:)
    !> shape (n)
    real(rk), contiguous, intent(inout) :: y(:)

    call sig_add_single_products(size(x), size(y), a, x, y)
  end subroutine add_single_products

  !> Computes y = alpha a' x + beta y, without a temporary array.
  subroutine multiply_transpose(alpha, a, x, beta, y)
    real(rk), intent(in) :: alpha
    !> shape (m, n)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (m)
    real(rk), contiguous, intent(in) :: x(:)
    real(rk), intent(in) :: beta
    !> shape (n); with beta = 0 its values before the call do not matter
    real(rk), contiguous, intent(inout) :: y(:)

    call sig_multiply_transpose(size(x), size(y), alpha, a, size(a, 1), x, beta, y)
  end subroutine multiply_transpose

  !> Computes c = c + factor * a b.
  subroutine add_product(factor, a, b, c)
    real(rk), intent(in) :: factor
    !> shape (m, k)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (k, n)
    real(rk), contiguous, intent(in) :: b(:, :)
    !> shape (m, n)
    real(rk), contiguous, intent(inout) :: c(:, :)

    call sig_add_product(0_c_int, 0_c_int, size(c, 1), size(c, 2), size(b, 1), factor, a, size(a, 1), b, size(b, 1), c, size(c, 1))
  end subroutine add_product

  !> Computes c = c + factor * a' b.
  subroutine add_transposed_product(factor, a, b, c)
    real(rk), intent(in) :: factor
    !> shape (k, m)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (k, n)
    real(rk), contiguous, intent(in) :: b(:, :)
    !> shape (m, n)
    real(rk), contiguous, intent(inout) :: c(:, :)

    call sig_add_product(1_c_int, 0_c_int, size(c, 1), size(c, 2), size(b, 1), factor, a, size(a, 1), b, size(b, 1), c, size(c, 1))
  end subroutine add_transposed_product

  !> Returns c = a' b.
  function transposed_product(a, b) result(c)
    !> shape (k, m)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> shape (k, n)
    real(rk), contiguous, intent(in) :: b(:, :)
    !> shape (m, n)
    real(rk), allocatable :: c(:, :)

    allocate (c(size(a, 2), size(b, 2)), source=0.0_rk)
    call add_transposed_product(1.0_rk, a, b, c)
  end function transposed_product

  !> Computes the LU factors of a square matrix with row exchanges (partial pivoting), in place.
  subroutine factor_lu(n, a, pivots, info)
    !> order of the matrix
    integer, intent(in) :: n
    !> on entry the matrix, on exit its factors, in the first n rows and columns, shape (>= n, >= n)
    real(rk), contiguous, intent(inout) :: a(:, :)
    !> row exchanges, for solve_lu, shape (>= n)
    integer, contiguous, intent(inout) :: pivots(:)
    !> 0, or the number of the first pivot that is zero or not a number; then the factors are of no use
    integer, intent(out) :: info

    info = sig_factor_lu(n, a, size(a, 1), pivots)
  end subroutine factor_lu

  !> Computes b = A^-1 b, with the factors of factor_lu.
  subroutine solve_lu_vector(n, factors, pivots, b)
    !> order of the matrix
    integer, intent(in) :: n
    real(rk), contiguous, intent(in) :: factors(:, :)
    integer, contiguous, intent(in) :: pivots(:)
    !> shape (>= n)
    real(rk), contiguous, intent(inout) :: b(:)

    call sig_solve_lu(n, 1_c_int, factors, size(factors, 1), pivots, b, size(b))
  end subroutine solve_lu_vector

  !> Computes b = A^-1 b for the columns of b, with the factors of factor_lu.
  subroutine solve_lu_matrix(n, factors, pivots, b)
    !> order of the matrix
    integer, intent(in) :: n
    real(rk), contiguous, intent(in) :: factors(:, :)
    integer, contiguous, intent(in) :: pivots(:)
    !> shape (>= n, n_columns)
    real(rk), contiguous, intent(inout) :: b(:, :)

    call sig_solve_lu(n, size(b, 2), factors, size(factors, 1), pivots, b, size(b, 1))
  end subroutine solve_lu_matrix

  !> [-] Returns an estimate of the reciprocal condition number 1 / (|A| |A^-1|) in the 1-norm, from the factors of factor_lu. The
  !> estimate is hardly ever three times too large. It is 1 for an empty matrix, and 0 where the inverse or the norm is not finite.
  real(rk) function reciprocal_condition_lu(n, factors, norm, work, signs) result(reciprocal)
    !> order of the matrix
    integer, intent(in) :: n
    real(rk), contiguous, intent(in) :: factors(:, :)
    !> |A| in the 1-norm, of the matrix before it was factored
    real(rk), intent(in) :: norm
    !> work spaces, shape (>= n)
    real(rk), contiguous, intent(inout) :: work(:)
    integer, contiguous, intent(inout) :: signs(:)

    reciprocal = sig_reciprocal_condition_lu(n, factors, size(factors, 1), norm, work, signs)
  end function reciprocal_condition_lu

  !> Computes the Cholesky factor L of A = L L', in place. Only the lower triangle is read and written.
  subroutine factor_cholesky(n, a, info)
    !> order of the matrix
    integer, intent(in) :: n
    !> on entry the matrix, on exit L, in the first n rows and columns, shape (>= n, >= n)
    real(rk), contiguous, intent(inout) :: a(:, :)
    !> 0, or the number of the first pivot that is not positive; then the matrix is not positive definite, and L is of no use
    integer, intent(out) :: info

    info = sig_factor_cholesky(n, a, size(a, 1))
  end subroutine factor_cholesky

  !> Computes the Cholesky factor of a matrix of which part is known: the first n_columns columns, of the first n_rows rows.
  subroutine extend_cholesky(n_columns, n_rows, n, a, info)
    !> a multiple of 8, at most n_rows
    integer, intent(in) :: n_columns
    !> at most n
    integer, intent(in) :: n_rows
    !> order of the matrix
    integer, intent(in) :: n
    !> on entry what is known of L, and the matrix in the other entries, on exit L, shape (>= n, >= n)
    real(rk), contiguous, intent(inout) :: a(:, :)
    !> as of factor_cholesky
    integer, intent(out) :: info

    info = sig_extend_cholesky(n_columns, n_rows, n, a, size(a, 1))
  end subroutine extend_cholesky

  !> Computes b = A^-1 b, with the factor of factor_cholesky.
  subroutine solve_cholesky_vector(n, factor, b)
    !> order of the matrix
    integer, intent(in) :: n
    real(rk), contiguous, intent(in) :: factor(:, :)
    !> shape (>= n)
    real(rk), contiguous, intent(inout) :: b(:)

    call sig_solve_cholesky(n, 1_c_int, factor, size(factor, 1), b, size(b))
  end subroutine solve_cholesky_vector

  !> Computes b = A^-1 b for the columns of b, with the factor of factor_cholesky.
  subroutine solve_cholesky_matrix(n, factor, b)
    !> order of the matrix
    integer, intent(in) :: n
    real(rk), contiguous, intent(in) :: factor(:, :)
    !> shape (>= n, n_columns)
    real(rk), contiguous, intent(inout) :: b(:, :)

    call sig_solve_cholesky(n, size(b, 2), factor, size(factor, 1), b, size(b, 1))
  end subroutine solve_cholesky_matrix

  !> Computes b = L^-1 b, with the factor of factor_cholesky. The sum of squares of the result is b' A^-1 b of the original b.
  subroutine reduce_cholesky(n, factor, b)
    !> order of the matrix
    integer, intent(in) :: n
    real(rk), contiguous, intent(in) :: factor(:, :)
    !> shape (>= n)
    real(rk), contiguous, intent(inout) :: b(:)

    call sig_reduce_cholesky(n, factor, size(factor, 1), b)
  end subroutine reduce_cholesky

  !> [-] Returns the same estimate of 1 / (|A| |A^-1|) as reciprocal_condition_lu, from the factor of factor_cholesky.
  real(rk) function reciprocal_condition_cholesky(n, factor, norm, work, signs) result(reciprocal)
    !> order of the matrix
    integer, intent(in) :: n
    real(rk), contiguous, intent(in) :: factor(:, :)
    !> |A| in the 1-norm, of the matrix before it was factored
    real(rk), intent(in) :: norm
    !> work spaces, shape (>= n)
    real(rk), contiguous, intent(inout) :: work(:)
    integer, contiguous, intent(inout) :: signs(:)

    reciprocal = sig_reciprocal_condition_cholesky(n, factor, size(factor, 1), norm, work, signs)
  end function reciprocal_condition_cholesky

  !> Returns the largest |x_i|; 0 for an empty array, NaN where an entry is NaN. It is several times as fast as maxval(abs(x)).
  pure real(rk) function largest_size(x)
    real(rk), contiguous, intent(in) :: x(:)

    largest_size = sig_largest_size(size(x), x)
  end function largest_size

  !> Returns the sum of |x_i|.
  pure real(rk) function sum_of_sizes(x)
    real(rk), contiguous, intent(in) :: x(:)

    sum_of_sizes = sig_sum_of_sizes(size(x), x)
  end function sum_of_sizes
end module sig_dense_kernels
