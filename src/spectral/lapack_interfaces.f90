! SPDX-License-Identifier: BSD-3-Clause
!> Explicit interfaces of the LAPACK routines in use. The code calls no LAPACK routine without one.
module sig_lapack_interfaces
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: dgesdd, dgetrf

  interface
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

    !> Factors a matrix with row exchanges.
    subroutine dgetrf(m, n, a, lda, ipiv, info)
      import :: rk
      implicit none(type, external)
      integer, intent(in) :: m
      integer, intent(in) :: n
      integer, intent(in) :: lda
      real(rk), intent(inout) :: a(lda, *)
      integer, intent(out) :: ipiv(*)
      integer, intent(out) :: info
    end subroutine dgetrf
  end interface
end module sig_lapack_interfaces
