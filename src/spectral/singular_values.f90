! SPDX-License-Identifier: BSD-3-Clause
!> Singular value decomposition, by LAPACK. Training needs it; a query does not.
module sig_singular_values
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
  use sig_kinds, only: rk
  use sig_lapack_interfaces, only: dgesdd
  implicit none(type, external)
  private
  public :: singular_values, svd

contains

  !> Returns the singular values in descending order; all are NaN where the matrix is not finite or LAPACK fails.
  function singular_values(a) result(values)
    !> shape (n_rows, n_columns)
    real(rk), intent(in) :: a(:, :)
    !> shape (min(n_rows, n_columns))
    real(rk), allocatable :: values(:)
    real(rk) :: no_vectors(1, 1)

    allocate (values(minval(shape(a))), source=0.0_rk)
    call run_dgesdd('N', a, values, no_vectors, no_vectors)
  end function singular_values

  !> Computes the thin singular value decomposition a = u diag(s) vt. If it fails, s is NaN, and u and vt are of no use.
  subroutine svd(a, u, s, vt)
    !> shape (n_rows, n_columns)
    real(rk), intent(in) :: a(:, :)
    !> orthonormal columns, shape (n_rows, min(n_rows, n_columns))
    real(rk), allocatable, intent(out) :: u(:, :)
    !> descending, shape (min(n_rows, n_columns)); NaN where a is not finite or LAPACK fails
    real(rk), allocatable, intent(out) :: s(:)
    !> orthonormal rows, shape (min(n_rows, n_columns), n_columns)
    real(rk), allocatable, intent(out) :: vt(:, :)
    integer :: n

    n = minval(shape(a))
    allocate (u(size(a, 1), n), s(n), vt(n, size(a, 2)), source=0.0_rk)
    call run_dgesdd('S', a, s, u, vt)
  end subroutine svd

  !> Calls dgesdd with its work space. The values s are NaN if the matrix is not finite (LAPACK might not return then) or the method
  !> does not converge.
  subroutine run_dgesdd(job, a, s, u, vt)
    !> N: values only, u and vt are not used; S: the thin decomposition
    character(1), intent(in) :: job
    real(rk), intent(in) :: a(:, :)
    !> s, u and vt as in svd; they do not change where the matrix has no entries
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
end module sig_singular_values
