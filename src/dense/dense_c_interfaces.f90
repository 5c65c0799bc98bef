! SPDX-License-Identifier: BSD-3-Clause
!> Fortran interfaces of the C functions of the dense layer; include/signorom/dense_kernels.h describes them.
module sig_dense_c_interfaces
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  implicit none(type, external)
  private
  public :: sig_multiply, sig_multiply_transpose, sig_add_product, sig_factor_lu, sig_solve_lu, sig_reciprocal_condition_lu
  public :: sig_add_few_columns, sig_reduce_cholesky
  public :: sig_factor_cholesky, sig_solve_cholesky, sig_reciprocal_condition_cholesky, sig_largest_size, sig_sum_of_sizes

  interface
    pure subroutine sig_multiply(m, n, alpha, a, lda, x, beta, y) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: m, n, lda
      real(c_double), value, intent(in) :: alpha, beta
      real(c_double), intent(in) :: a(*), x(*)
      real(c_double), intent(inout) :: y(*)
    end subroutine sig_multiply

    pure subroutine sig_add_few_columns(m, n, a, lda, x, y) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: m, n, lda
      real(c_double), intent(in) :: a(*), x(*)
      real(c_double), intent(inout) :: y(*)
    end subroutine sig_add_few_columns

    pure subroutine sig_reduce_cholesky(n, factor, ldf, b) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: n, ldf
      real(c_double), intent(in) :: factor(*)
      real(c_double), intent(inout) :: b(*)
    end subroutine sig_reduce_cholesky

    pure subroutine sig_multiply_transpose(m, n, alpha, a, lda, x, beta, y) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: m, n, lda
      real(c_double), value, intent(in) :: alpha, beta
      real(c_double), intent(in) :: a(*), x(*)
      real(c_double), intent(inout) :: y(*)
    end subroutine sig_multiply_transpose

    pure subroutine sig_add_product(a_is_transposed, b_is_transposed, m, n, k, alpha, a, lda, b, ldb, c, ldc) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: a_is_transposed, b_is_transposed, m, n, k, lda, ldb, ldc
      real(c_double), value, intent(in) :: alpha
      real(c_double), intent(in) :: a(*), b(*)
      real(c_double), intent(inout) :: c(*)
    end subroutine sig_add_product

    integer(c_int) function sig_factor_lu(n, a, lda, pivots) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: n, lda
      real(c_double), intent(inout) :: a(*)
      integer(c_int), intent(inout) :: pivots(*)
    end function sig_factor_lu

    pure subroutine sig_solve_lu(n, n_rhs, factors, ldf, pivots, b, ldb) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: n, n_rhs, ldf, ldb
      real(c_double), intent(in) :: factors(*)
      integer(c_int), intent(in) :: pivots(*)
      real(c_double), intent(inout) :: b(*)
    end subroutine sig_solve_lu

    real(c_double) function sig_reciprocal_condition_lu(n, factors, ldf, norm, work, signs) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: n, ldf
      real(c_double), intent(in) :: factors(*)
      real(c_double), value, intent(in) :: norm
      real(c_double), intent(inout) :: work(*)
      integer(c_int), intent(inout) :: signs(*)
    end function sig_reciprocal_condition_lu

    integer(c_int) function sig_factor_cholesky(n, a, lda) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: n, lda
      real(c_double), intent(inout) :: a(*)
    end function sig_factor_cholesky

    pure subroutine sig_solve_cholesky(n, n_rhs, factor, ldf, b, ldb) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: n, n_rhs, ldf, ldb
      real(c_double), intent(in) :: factor(*)
      real(c_double), intent(inout) :: b(*)
    end subroutine sig_solve_cholesky

    real(c_double) function sig_reciprocal_condition_cholesky(n, factor, ldf, norm, work, signs) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: n, ldf
      real(c_double), intent(in) :: factor(*)
      real(c_double), value, intent(in) :: norm
      real(c_double), intent(inout) :: work(*)
      integer(c_int), intent(inout) :: signs(*)
    end function sig_reciprocal_condition_cholesky

    pure real(c_double) function sig_largest_size(n, x) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: n
      real(c_double), intent(in) :: x(*)
    end function sig_largest_size

    pure real(c_double) function sig_sum_of_sizes(n, x) bind(c)
      import :: c_double, c_int
      implicit none(type, external)
      integer(c_int), value, intent(in) :: n
      real(c_double), intent(in) :: x(*)
    end function sig_sum_of_sizes
  end interface
end module sig_dense_c_interfaces
