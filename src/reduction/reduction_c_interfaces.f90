! SPDX-License-Identifier: BSD-3-Clause
!> The C side of the reduction, as Fortran sees it; what each function does stands in include/signorom/snapshot_svd.h.
module sig_reduction_c_interfaces
  implicit none(type, external)
  private
  public :: sig_tall_svd, sig_thin_svd, sig_gather_rows

  interface
    function sig_tall_svd(comm, n_local, n_columns, rows, singular_values, left) result(status) bind(c)
      use, intrinsic :: iso_c_binding, only: c_double, c_int
      integer(c_int), value :: comm, n_local, n_columns
      real(c_double), intent(in) :: rows(*)
      real(c_double), intent(out) :: singular_values(*)
      real(c_double), intent(out) :: left(*)
      integer(c_int) :: status
    end function sig_tall_svd

    function sig_thin_svd(n_rows, n_columns, matrix, singular_values, left) result(status) bind(c)
      use, intrinsic :: iso_c_binding, only: c_double, c_int
      integer(c_int), value :: n_rows, n_columns
      real(c_double), intent(in) :: matrix(*)
      real(c_double), intent(out) :: singular_values(*)
      real(c_double), intent(out) :: left(*)
      integer(c_int) :: status
    end function sig_thin_svd

    function sig_gather_rows(comm, n_local, n_rows, n_columns, local, gathered) result(status) bind(c)
      use, intrinsic :: iso_c_binding, only: c_double, c_int
      integer(c_int), value :: comm, n_local, n_rows, n_columns
      real(c_double), intent(in) :: local(*)
      real(c_double), intent(out) :: gathered(*)
      integer(c_int) :: status
    end function sig_gather_rows
  end interface
end module sig_reduction_c_interfaces
