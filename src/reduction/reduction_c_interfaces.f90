! SPDX-License-Identifier: BSD-3-Clause
!> Fortran interfaces of the C functions of the reduction. include/signorom/snapshot_svd.h and include/signorom/k_medoids.h describe
!> them.
module sig_reduction_c_interfaces
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none(type, external)
  private
  public :: k_medoids_options_t, sig_find_medoids, sig_gather_rows, sig_silhouette, sig_thin_svd
  public :: sig_snapshot_svd_create, sig_snapshot_svd_decompose, sig_snapshot_svd_destroy, sig_snapshot_svd_left, &
    sig_snapshot_svd_set_column, sig_snapshot_svd_triangle

  integer(c_int), parameter, public :: k_medoids_ok = 0
  integer(c_int), parameter, public :: k_medoids_bad_count = 2
  integer(c_int), parameter, public :: k_medoids_bad_dissimilarity = 3

  !> the values of method and start
  integer(c_int), parameter, public :: method_faster_pam = 0
  integer(c_int), parameter, public :: method_alternating = 1
  integer(c_int), parameter, public :: start_build = 0
  integer(c_int), parameter, public :: start_random = 1
  integer(c_int), parameter, public :: start_lab = 2
  integer(c_int), parameter, public :: start_central = 3

  !> How to look for medoids: sig_k_medoids_options of the header.
  type, bind(c) :: k_medoids_options_t
    integer(c_int) :: method = method_faster_pam
    integer(c_int) :: start = start_build
    !> number of starts, of which the best is taken
    integer(c_int) :: n_starts = 10
    integer(c_int) :: seed = 1
  end type k_medoids_options_t

  interface
    function sig_snapshot_svd_create(comm, n_local, n_columns, svd) result(status) bind(c)
      use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
      integer(c_int), value :: comm, n_local, n_columns
      integer(c_intptr_t), intent(out) :: svd
      integer(c_int) :: status
    end function sig_snapshot_svd_create

    function sig_snapshot_svd_set_column(svd, column, rows) result(status) bind(c)
      use, intrinsic :: iso_c_binding, only: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: svd
      integer(c_int), value :: column
      real(c_double), intent(in) :: rows(*)
      integer(c_int) :: status
    end function sig_snapshot_svd_set_column

    function sig_snapshot_svd_triangle(svd, triangle) result(status) bind(c)
      use, intrinsic :: iso_c_binding, only: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: svd
      real(c_double), intent(out) :: triangle(*)
      integer(c_int) :: status
    end function sig_snapshot_svd_triangle

    function sig_snapshot_svd_decompose(svd, singular_values) result(status) bind(c)
      use, intrinsic :: iso_c_binding, only: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: svd
      real(c_double), intent(out) :: singular_values(*)
      integer(c_int) :: status
    end function sig_snapshot_svd_decompose

    function sig_snapshot_svd_left(svd, n_vectors, left) result(status) bind(c)
      use, intrinsic :: iso_c_binding, only: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: svd
      integer(c_int), value :: n_vectors
      real(c_double), intent(out) :: left(*)
      integer(c_int) :: status
    end function sig_snapshot_svd_left

    function sig_snapshot_svd_destroy(svd) result(status) bind(c)
      use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
      integer(c_intptr_t), intent(inout) :: svd
      integer(c_int) :: status
    end function sig_snapshot_svd_destroy

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

    function sig_find_medoids(n_items, dissimilarity, n_clusters, options, medoids, labels, loss) result(status) bind(c)
      use, intrinsic :: iso_c_binding, only: c_double, c_int
      import :: k_medoids_options_t
      integer(c_int), value :: n_items
      real(c_double), intent(in) :: dissimilarity(*)
      integer(c_int), value :: n_clusters
      type(k_medoids_options_t), intent(in) :: options
      integer(c_int), intent(out) :: medoids(*)
      integer(c_int), intent(out) :: labels(*)
      real(c_double), intent(out) :: loss
      integer(c_int) :: status
    end function sig_find_medoids

    function sig_silhouette(n_items, dissimilarity, n_clusters, labels, silhouette) result(status) bind(c)
      use, intrinsic :: iso_c_binding, only: c_double, c_int
      integer(c_int), value :: n_items
      real(c_double), intent(in) :: dissimilarity(*)
      integer(c_int), value :: n_clusters
      integer(c_int), intent(in) :: labels(*)
      real(c_double), intent(out) :: silhouette
      integer(c_int) :: status
    end function sig_silhouette
  end interface
end module sig_reduction_c_interfaces
