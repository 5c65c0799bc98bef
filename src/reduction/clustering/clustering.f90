! SPDX-License-Identifier: BSD-3-Clause
!> Makes clusters of snapshots from labels. The labels belong to the items that are clustered: cells of the training grid, or
!> snapshots.
module sig_clustering
  use sig_errors, only: error_t, make_error
  use sig_grassmann, only: subspace_t
  use sig_grid_cells, only: grid_cells_t
  use sig_kinds, only: rk
  use sig_parameter_space, only: format_point
  use sig_pod_rank, only: pod_rank
  use sig_singular_values, only: svd
  use sig_text, only: counted, string_t, to_text
  implicit none(type, external)
  private
  public :: cluster_t, check_snapshots, cell_subspaces, clusters_of_cells, clusters_of_snapshots, check_clusters

  !> Snapshots of one cluster.
  type :: cluster_t
    !> numbers of snapshots, ascending
    integer, allocatable :: snapshots(:)
  end type cluster_t

contains

  !> Checks that no snapshot is zero, because angles between snapshots need a direction. Errors: a snapshot is zero; the message
  !> gives the number and the point of the first one.
  subroutine check_snapshots(lengths, names, points, error)
    !> Euclidean norms of the snapshots, shape (n_snapshots)
    real(rk), intent(in) :: lengths(:)
    !> names of the parameters
    type(string_t), intent(in) :: names(:)
    !> values of the parameters, shape (n_parameters, n_snapshots)
    real(rk), intent(in) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(lengths)
      if (lengths(i) > 0) cycle
      call make_error(error, 'snapshot ' // to_text(i) // ' (' // format_point(names, points(:, i)) // &
        ') is zero: it cannot be compared with others', &
        hint='leave points at which nothing loads or moves the bodies out of the training set: let the range of the load ' // &
          'begin above 0, or take other training points')
      return
    end do
  end subroutine check_snapshots

  !> Returns for each wanted cell the POD modes of the snapshots at its corners, at least one mode. Source: section 4.1. Local.
  function cell_subspaces(coordinates, cells, wanted, pod_tolerance) result(subspaces)
    !> snapshot_coordinates of the snapshots of the whole grid, in its order, shape (n_coordinates, n_snapshots)
    real(rk), intent(in) :: coordinates(:, :)
    type(grid_cells_t), intent(in) :: cells
    !> numbers of cells, 1-based
    integer, intent(in) :: wanted(:)
    !> [-] tolerance of pod_rank
    real(rk), intent(in) :: pod_tolerance
    type(subspace_t) :: subspaces(size(wanted))
    real(rk), allocatable :: left(:, :), right_rows(:, :), sigma(:)
    integer :: i

    do i = 1, size(wanted)
      call svd(coordinates(:, cells%corners(wanted(i))), left, sigma, right_rows)
      subspaces(i)%basis = left(:, :max(1, pod_rank(sigma, pod_tolerance)))
    end do
  end function cell_subspaces

  !> Returns the clusters of snapshots of labeled cells. A cluster has the snapshots at the corners of all its cells, so a snapshot
  !> on the border between clusters belongs to each of them.
  pure function clusters_of_cells(labels, n_clusters, cells) result(clusters)
    !> cluster of each cell, 1-based
    integer, intent(in) :: labels(:)
    integer, intent(in) :: n_clusters
    type(grid_cells_t), intent(in) :: cells
    type(cluster_t) :: clusters(n_clusters)
    logical :: is_member(product(cells%n_values), n_clusters)
    integer :: i

    is_member = .false.
    do i = 1, size(labels)
      is_member(cells%corners(i), labels(i)) = .true.
    end do
    do i = 1, n_clusters
      clusters(i)%snapshots = numbers_of(is_member(:, i))
    end do
  end function clusters_of_cells

  !> Returns the clusters of labeled snapshots. Each snapshot belongs to one cluster. Source: section 4.2.
  pure function clusters_of_snapshots(labels, n_clusters) result(clusters)
    !> cluster of each snapshot, 1-based
    integer, intent(in) :: labels(:)
    integer, intent(in) :: n_clusters
    type(cluster_t) :: clusters(n_clusters)
    integer :: i

    do i = 1, n_clusters
      clusters(i)%snapshots = numbers_of(labels == i)
    end do
  end function clusters_of_snapshots

  pure function numbers_of(is_member) result(numbers)
    logical, intent(in) :: is_member(:)
    integer, allocatable :: numbers(:)
    integer :: i

    numbers = pack([(i, i=1, size(is_member))], is_member)
  end function numbers_of

  !> Checks the number of snapshots of each cluster. Errors: a cluster has fewer than min_snapshots; the message names the first.
  pure subroutine check_clusters(clusters, min_snapshots, error)
    type(cluster_t), intent(in) :: clusters(:)
    integer, intent(in) :: min_snapshots
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(clusters)
      if (size(clusters(i)%snapshots) >= min_snapshots) cycle
      call make_error(error, 'cluster ' // to_text(i) // ' of ' // to_text(size(clusters)) // ' has ' // &
        counted(size(clusters(i)%snapshots), 'snapshot') // '; its basis needs at least ' // to_text(min_snapshots) // &
        ' (clusters.min_snapshots)', &
        hint='take fewer clusters, more training points, a smaller min_snapshots, or small_clusters: merge')
      return
    end do
  end subroutine check_clusters
end module sig_clustering
