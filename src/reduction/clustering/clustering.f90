! SPDX-License-Identifier: BSD-3-Clause
!> From labels to clusters of snapshots: what is clustered (cells of a grid, or snapshots), and what each cluster holds.
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

  !> Every snapshot must have a direction. Errors: a snapshot that is zero, named by its point.
  subroutine check_snapshots(lengths, names, points, error)
    !> Euclidean norms, shape (n_snapshots)
    real(rk), intent(in) :: lengths(:)
    !> of the parameters
    type(string_t), intent(in) :: names(:)
    !> shape (n_parameters, n_snapshots)
    real(rk), intent(in) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(lengths)
      if (lengths(i) > 0) cycle
      call make_error(error, 'snapshot ' // to_text(i) // ' (' // format_point(names, points(:, i)) // &
        ') is zero: it cannot be compared with others', &
        hint='leave points without load and without prescribed displacement out of the training set')
      return
    end do
  end subroutine check_snapshots

  !> POD of the snapshots at the corners of each wanted cell. Source: section 4.1. Local.
  function cell_subspaces(coordinates, cells, wanted, pod_tolerance) result(subspaces)
    !> of the snapshots of the whole grid, in its order, shape (n_coordinates, n_snapshots)
    real(rk), intent(in) :: coordinates(:, :)
    type(grid_cells_t), intent(in) :: cells
    !> numbers of cells, 1-based
    integer, intent(in) :: wanted(:)
    !> [-] energy tail
    real(rk), intent(in) :: pod_tolerance
    type(subspace_t) :: subspaces(size(wanted))
    real(rk), allocatable :: left(:, :), right_rows(:, :), sigma(:)
    integer :: i

    do i = 1, size(wanted)
      call svd(coordinates(:, cells%corners(wanted(i))), left, sigma, right_rows)
      subspaces(i)%basis = left(:, :max(1, pod_rank(sigma, pod_tolerance)))
    end do
  end function cell_subspaces

  !> The corners of all its cells are a cluster's snapshots: one on a border belongs to all clusters that meet there.
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

  !> Each snapshot belongs to one cluster. Source: section 4.2.
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

  !> Each cluster needs snapshots for a basis of its own. Errors: a cluster with too few, named by its number.
  pure subroutine check_clusters(clusters, min_snapshots, error)
    type(cluster_t), intent(in) :: clusters(:)
    integer, intent(in) :: min_snapshots
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(clusters)
      if (size(clusters(i)%snapshots) >= min_snapshots) cycle
      call make_error(error, 'cluster ' // to_text(i) // ' of ' // to_text(size(clusters)) // ' has ' // &
        counted(size(clusters(i)%snapshots), 'snapshot') // '; its basis needs at least ' // to_text(min_snapshots) // &
        ' (clusters.min_snapshots)', hint='ask for fewer clusters, for more training points, or for small_clusters: merge')
      return
    end do
  end subroutine check_clusters
end module sig_clustering
