! SPDX-License-Identifier: BSD-3-Clause
!> Clusters around medoids. Only the dissimilarity of each pair of items is known. k_medoids.c does the work.
module sig_k_medoids
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_text, only: are, counted, to_text
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: medoids_t, k_medoids_options_t, find_medoids, choose_n_clusters, merge_cluster
  public :: start_build, start_random

  integer(c_int), parameter :: k_medoids_ok = 0
  integer(c_int), parameter :: k_medoids_bad_count = 2
  integer(c_int), parameter :: k_medoids_bad_dissimilarity = 3

  !> the values of start
  integer(c_int), parameter :: start_build = 0
  integer(c_int), parameter :: start_random = 1

  !> How to look for medoids: sig_k_medoids_options of the header.
  type, bind(c) :: k_medoids_options_t
    integer(c_int) :: start = start_build
    !> number of starts, of which the best is taken
    integer(c_int) :: n_starts = 10
    integer(c_int) :: seed = 1
  end type k_medoids_options_t

  !> Clusters of items, all numbers 1-based.
  type :: medoids_t
    !> item that is the medoid of each cluster, ascending, shape (n_clusters)
    integer, allocatable :: medoids(:)
    !> cluster of each item, shape (n_items)
    integer, allocatable :: labels(:)
    !> [as the dissimilarity] sum over all items of the dissimilarity to the medoid of their cluster
    real(rk) :: loss = 0
    !> [-] mean silhouette, in [-1, 1], large = well separated; 0 for one cluster
    real(rk) :: silhouette = 0
  end type medoids_t

  ! include/signorom/k_medoids.h describes these procedures in C.
  interface
    function sig_find_medoids(n_items, dissimilarity, n_clusters, options, medoids, labels, loss) result(status) bind(c)
      import :: c_double, c_int, k_medoids_options_t
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
      import :: c_double, c_int
      integer(c_int), value :: n_items
      real(c_double), intent(in) :: dissimilarity(*)
      integer(c_int), value :: n_clusters
      integer(c_int), intent(in) :: labels(*)
      real(c_double), intent(out) :: silhouette
      integer(c_int) :: status
    end function sig_silhouette
  end interface

contains

  !> Finds n_clusters clusters with a small loss (medoids_t): the best result of options%n_starts starts.
  !>
  !> Local; the same options give the same clusters. Cost: a few n_items**2 per start. Errors, without a place in a file: fewer than
  !> one cluster, or more clusters than items; a dissimilarity is negative or not finite; wrong options; no memory.
  subroutine find_medoids(dissimilarity, n_clusters, options, found, error)
    !> symmetric, zero diagonal, shape (n_items, n_items)
    real(rk), intent(in), contiguous :: dissimilarity(:, :)
    integer, intent(in) :: n_clusters
    type(k_medoids_options_t), intent(in) :: options
    type(medoids_t), intent(out) :: found
    type(error_t), allocatable, intent(out) :: error
    integer :: n_items, status

    n_items = size(dissimilarity, 1)
    allocate (found%medoids(max(0, n_clusters)), found%labels(n_items), source=0)
    status = sig_find_medoids(n_items, dissimilarity, n_clusters, options, found%medoids, found%labels, found%loss)
    if (status == k_medoids_ok) &
      status = sig_silhouette(n_items, dissimilarity, n_clusters, found%labels, found%silhouette)
    found%medoids = found%medoids + 1
    found%labels = found%labels + 1
    if (status /= k_medoids_ok) call explain(status, n_clusters, n_items, error)
  end subroutine find_medoids

  !> Makes the error of a status of k_medoids.h that is not k_medoids_ok.
  pure subroutine explain(status, n_clusters, n_items, error)
    integer, intent(in) :: status
    integer, intent(in) :: n_clusters
    integer, intent(in) :: n_items
    type(error_t), allocatable, intent(out) :: error

    select case (status)
    case (k_medoids_bad_count)
      call make_error(error, 'there ' // are(n_items) // ' ' // counted(n_items, 'item') // &
        ' to cluster (training points with a solution, or cells of their grid); ' // counted(n_clusters, 'cluster') // &
        ' cannot be made from them')
    case (k_medoids_bad_dissimilarity)
      call make_error(error, 'the clusters cannot be made: a distance of two items (training points, or cells of their ' // &
        'grid) is negative, infinite or not a number')
    case default
      call make_error(error, 'k-medoids failed with status ' // to_text(status))
    end select
  end subroutine explain

  !> Finds clusters for each number from 2 to max_clusters, or to the number of items if this is smaller. Returns the clusters with
  !> the largest mean silhouette; of nearly equal ones (1e-8) those with the fewest clusters. Returns one cluster where max_clusters
  !> is 1 or there is only one item. Errors: as find_medoids.
  subroutine choose_n_clusters(dissimilarity, max_clusters, options, best, error)
    !> as in find_medoids
    real(rk), intent(in), contiguous :: dissimilarity(:, :)
    !> may be larger than the number of items
    integer, intent(in) :: max_clusters
    type(k_medoids_options_t), intent(in) :: options
    type(medoids_t), intent(out) :: best
    type(error_t), allocatable, intent(out) :: error
    type(medoids_t) :: found
    integer :: n_clusters

    call find_medoids(dissimilarity, 1, options, best, error)
    if (allocated(error)) return
    do n_clusters = 2, min(max_clusters, size(dissimilarity, 1))
      call find_medoids(dissimilarity, n_clusters, options, found, error)
      if (allocated(error)) return
      if (n_clusters == 2 .or. found%silhouette > best%silhouette + tie_tolerance) best = found
    end do
  end subroutine choose_n_clusters

  !> Merges cluster i_cluster into the cluster whose medoid is nearest to its own medoid; of equally near ones the first. That
  !> cluster keeps its medoid. The numbers of clusters after i_cluster become smaller by one. Loss and silhouette are computed
  !> again.
  !>
  !> Requires: two clusters or more.
  subroutine merge_cluster(dissimilarity, i_cluster, found, i_target)
    !> as in find_medoids
    real(rk), intent(in), contiguous :: dissimilarity(:, :)
    !> number of the cluster, 1-based
    integer, intent(in) :: i_cluster
    type(medoids_t), intent(inout) :: found
    !> number, before the merge, of the cluster that gets the items
    integer, intent(out) :: i_target
    integer :: i, status

    associate (distances => dissimilarity(found%medoids, found%medoids(i_cluster)))
      i_target = minloc(distances, dim=1, mask=[(i /= i_cluster, i=1, size(found%medoids))])
    end associate
    where (found%labels == i_cluster) found%labels = i_target
    where (found%labels > i_cluster) found%labels = found%labels - 1
    found%medoids = pack(found%medoids, [(i /= i_cluster, i=1, size(found%medoids))])
    found%loss = 0
    do i = 1, size(found%labels)
      found%loss = found%loss + dissimilarity(i, found%medoids(found%labels(i)))
    end do
    status = sig_silhouette(size(found%labels), dissimilarity, size(found%medoids), found%labels - 1, found%silhouette)
  end subroutine merge_cluster
end module sig_k_medoids
