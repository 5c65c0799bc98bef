! SPDX-License-Identifier: BSD-3-Clause
!> Explicit interfaces of the BLAS and LAPACK routines in use. Nobody calls them without one.
module sig_lapack_interfaces
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: dasum, dgecon, dgemm, dgemv, dgesdd, dgetrf, dgetrs, dlange, dpocon, dpotrf, dpotrs, idamax

  interface
    !> Reciprocal condition number of a matrix that dgetrf factored; norm '1' or 'I'; anorm is the norm of the matrix itself.
    subroutine dgecon(norm, n, a, lda, anorm, rcond, work, iwork, info)
      import :: rk
      implicit none(type, external)
      character(1), intent(in) :: norm
      integer, intent(in) :: n
      integer, intent(in) :: lda
      real(rk), intent(in) :: a(lda, *)
      real(rk), intent(in) :: anorm
      real(rk), intent(out) :: rcond
      real(rk), intent(inout) :: work(*)
      integer, intent(inout) :: iwork(*)
      integer, intent(out) :: info
    end subroutine dgecon

    !> c = alpha * op(a) * op(b) + beta * c, op(a) of shape (m, k).
    subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
      import :: rk
      implicit none(type, external)
      character(1), intent(in) :: transa
      character(1), intent(in) :: transb
      integer, intent(in) :: m
      integer, intent(in) :: n
      integer, intent(in) :: k
      real(rk), intent(in) :: alpha
      integer, intent(in) :: lda
      real(rk), intent(in) :: a(lda, *)
      integer, intent(in) :: ldb
      real(rk), intent(in) :: b(ldb, *)
      real(rk), intent(in) :: beta
      integer, intent(in) :: ldc
      real(rk), intent(inout) :: c(ldc, *)
    end subroutine dgemm

    !> y = alpha op(a) x + beta y; trans 'N' or 'T'.
    subroutine dgemv(trans, m, n, alpha, a, lda, x, incx, beta, y, incy)
      import :: rk
      implicit none(type, external)
      character(1), intent(in) :: trans
      integer, intent(in) :: m
      integer, intent(in) :: n
      real(rk), intent(in) :: alpha
      integer, intent(in) :: lda
      real(rk), intent(in) :: a(lda, *)
      real(rk), intent(in) :: x(*)
      integer, intent(in) :: incx
      real(rk), intent(in) :: beta
      real(rk), intent(inout) :: y(*)
      integer, intent(in) :: incy
    end subroutine dgemv

    !> Singular value decomposition by divide and conquer; jobz 'N' (values only) or 'S' (thin).
    subroutine dgesdd(jobz, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, iwork, info)
      import :: rk
      implicit none(type, external)
      character(1), intent(in) :: jobz
      integer, intent(in) :: m
      integer, intent(in) :: n
      integer, intent(in) :: lda
      real(rk), intent(inout) :: a(lda, *)
      real(rk), intent(inout) :: s(*)
      integer, intent(in) :: ldu
      real(rk), intent(inout) :: u(ldu, *)
      integer, intent(in) :: ldvt
      real(rk), intent(inout) :: vt(ldvt, *)
      real(rk), intent(inout) :: work(*)
      integer, intent(in) :: lwork
      integer, intent(inout) :: iwork(*)
      integer, intent(out) :: info
    end subroutine dgesdd

    !> LU with row exchanges.
    subroutine dgetrf(m, n, a, lda, ipiv, info)
      import :: rk
      implicit none(type, external)
      integer, intent(in) :: m
      integer, intent(in) :: n
      integer, intent(in) :: lda
      real(rk), intent(inout) :: a(lda, *)
      integer, intent(inout) :: ipiv(*)
      integer, intent(out) :: info
    end subroutine dgetrf

    !> Solves with the factors of dgetrf.
    subroutine dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
      import :: rk
      implicit none(type, external)
      character(1), intent(in) :: trans
      integer, intent(in) :: n
      integer, intent(in) :: nrhs
      integer, intent(in) :: lda
      real(rk), intent(in) :: a(lda, *)
      integer, intent(in) :: ipiv(*)
      integer, intent(in) :: ldb
      real(rk), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dgetrs

    !> Reciprocal condition number of a matrix that dpotrf factored; anorm is the 1-norm of the matrix itself.
    subroutine dpocon(uplo, n, a, lda, anorm, rcond, work, iwork, info)
      import :: rk
      implicit none(type, external)
      character(1), intent(in) :: uplo
      integer, intent(in) :: n
      integer, intent(in) :: lda
      real(rk), intent(in) :: a(lda, *)
      real(rk), intent(in) :: anorm
      real(rk), intent(out) :: rcond
      real(rk), intent(inout) :: work(*)
      integer, intent(inout) :: iwork(*)
      integer, intent(out) :: info
    end subroutine dpocon

    !> Cholesky factor of a symmetric matrix, in its lower ('L') triangle; info > 0 where it is not positive definite.
    subroutine dpotrf(uplo, n, a, lda, info)
      import :: rk
      implicit none(type, external)
      character(1), intent(in) :: uplo
      integer, intent(in) :: n
      integer, intent(in) :: lda
      real(rk), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotrf

    !> Solves with the factor of dpotrf.
    subroutine dpotrs(uplo, n, nrhs, a, lda, b, ldb, info)
      import :: rk
      implicit none(type, external)
      character(1), intent(in) :: uplo
      integer, intent(in) :: n
      integer, intent(in) :: nrhs
      integer, intent(in) :: lda
      real(rk), intent(in) :: a(lda, *)
      integer, intent(in) :: ldb
      real(rk), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dpotrs

    !> Sum of the sizes of the entries.
    pure function dasum(n, x, incx) result(value)
      import :: rk
      implicit none(type, external)
      integer, intent(in) :: n
      real(rk), intent(in) :: x(*)
      integer, intent(in) :: incx
      real(rk) :: value
    end function dasum

    !> Index of the entry of the largest size.
    pure function idamax(n, x, incx) result(i)
      import :: rk
      implicit none(type, external)
      integer, intent(in) :: n
      real(rk), intent(in) :: x(*)
      integer, intent(in) :: incx
      integer :: i
    end function idamax

    !> Norm of a matrix: norm 'M' (largest entry), '1', 'I' or 'F'.
    function dlange(norm, m, n, a, lda, work) result(value)
      import :: rk
      implicit none(type, external)
      character(1), intent(in) :: norm
      integer, intent(in) :: m
      integer, intent(in) :: n
      integer, intent(in) :: lda
      real(rk), intent(in) :: a(lda, *)
      real(rk), intent(inout) :: work(*)
      real(rk) :: value
    end function dlange
  end interface
end module sig_lapack_interfaces
