! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Splits one cluster of a division into two, by two medoids among its own cells or snapshots.
module sig_cluster_split
  use mpi, only: MPI_COMM_WORLD
  use sig_cluster_division, only: medoid_options
  use sig_clustering, only: cell_subspaces, cluster_t, clusters_of_cells
  use sig_deck_config, only: deck_config_t
  use sig_dissimilarity, only: dissimilarity_of_snapshots, dissimilarity_of_subspaces, snapshot_coordinates
  use sig_errors, only: error_t
  use sig_forest_training, only: train_forest
  use sig_grassmann, only: subspace_t
  use sig_k_medoids, only: find_medoids, medoids_t
  use sig_kinds, only: rk
  use sig_model_choice, only: model_choice_t
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: division_t, split_cluster, restore_forest

  !> The snapshots of each cluster, and the rule by which a query chooses a cluster.
  type :: division_t
    type(cluster_t), allocatable :: clusters(:)
    type(model_choice_t) :: choice
    !> number of snapshots on which the forest was trained, the first ones
    integer :: n_labeled = 0
    !> communicator of the ranks that share the work of a split; the dofs of the snapshots are spread over them
    integer :: comm = MPI_COMM_WORLD
  end type division_t

contains

  !> Splits cluster k: it keeps those of its items (cells of the grid, or snapshots) that are nearer to the first of two medoids;
  !> the others become a new last cluster. For irregular clusters the forest is trained again on all snapshots, which also writes
  !> the files of the forest. For regular clusters the rule of choice gets new labels of the cells. Collective on division%comm,
  !> with the same result on each rank.
  !>
  !> Requires: for regular clusters, the snapshots of the whole grid come first. Errors: the forest cannot be trained; the clusters
  !> are split nevertheless.
  subroutine split_cluster(deck, snapshots, k, division, is_split, error, ierr)
    type(deck_config_t), intent(in) :: deck
    !> all snapshots of the training
    type(training_set_t), intent(in) :: snapshots
    !> number of the cluster
    integer, intent(in) :: k
    type(division_t), intent(inout) :: division
    !> false where a half would have fewer snapshots than clusters.min_snapshots, or none; then no cluster changes
    logical, intent(out) :: is_split
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(cluster_t) :: halves(2)
    integer, allocatable :: labels(:)

    ierr = 0
    is_split = .false.
    if (deck%clusters%method == 'regular') then
      PetscCall(halve_cells(deck, snapshots, k, division, labels, halves, ierr))
    else
      PetscCall(halve_snapshots(deck, snapshots, division%clusters(k), division%comm, halves, ierr))
    end if
    if (min(size(halves(1)%snapshots), size(halves(2)%snapshots)) < max(1, deck%clusters%min_snapshots)) return
    is_split = .true.
    division%clusters(k) = halves(1)
    division%clusters = [division%clusters, halves(2)]
    if (allocated(labels)) then
      division%choice%labels = labels
    else
      division%n_labeled = snapshots%n_snapshots()
      PetscCall(restore_forest(deck, snapshots, division, error, ierr))
    end if
  end subroutine split_cluster

  !> Trains division%choice%forest again on the first division%n_labeled snapshots and their clusters, and writes its files
  !> labels.csv and forest.h5 into the results folder. Collective on division%comm. Requires: irregular clusters; each of these
  !> snapshots is in a cluster. Errors: the forest cannot be trained.
  subroutine restore_forest(deck, snapshots, division, error, ierr)
    type(deck_config_t), intent(in) :: deck
    type(training_set_t), intent(in) :: snapshots
    type(division_t), intent(inout) :: division
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: labels(:)

    labels = labels_of(division%clusters)
    associate (n => division%n_labeled)
      PetscCall(train_forest(deck, snapshots%parameters(:, :n), labels(:n), division%comm, division%choice%forest, error, ierr))
    end associate
  end subroutine restore_forest

  !> Halves a cluster by the principal angles between the POD modes of its cells. The division gets cells and labels if it has none.
  !> A snapshot that was added to the grid goes to the half of the cell that contains its point. Collective on division%comm.
  subroutine halve_cells(deck, snapshots, k, division, labels, halves, ierr)
    type(deck_config_t), intent(in) :: deck
    !> all of the training, those of the whole grid first
    type(training_set_t), intent(in) :: snapshots
    !> number of the cluster
    integer, intent(in) :: k
    type(division_t), intent(inout) :: division
    !> cluster of each cell of the grid after the split, 1-based
    integer, allocatable, intent(out) :: labels(:)
    !> snapshots of cluster k and of the new cluster; a snapshot at the corners of cells of both is in both
    type(cluster_t), intent(out) :: halves(2)
    PetscErrorCode, intent(out) :: ierr
    type(subspace_t), allocatable :: subspaces(:)
    type(cluster_t), allocatable :: clusters(:)
    real(rk), allocatable :: coordinates(:, :), dissimilarity(:, :)
    integer, allocatable :: added(:), label_of_added(:), own(:)
    integer :: i, n_clusters, n_grid

    call need_labels(deck, division%choice)
    associate (cells => division%choice%cells)
      labels = division%choice%labels
      n_grid = product(cells%n_values)
      n_clusters = size(division%clusters) + 1
      PetscCall(snapshot_coordinates(snapshots%select([(i, i=1, n_grid)]), division%comm, coordinates, ierr))
      own = pack([(i, i=1, size(labels))], labels == k)
      subspaces = cell_subspaces(coordinates, cells, own, deck%clusters%cell_pod_tolerance)
      PetscCall(dissimilarity_of_subspaces(subspaces, division%comm, dissimilarity, ierr))
      where (second_half(deck, dissimilarity)) labels(own) = n_clusters
      clusters = clusters_of_cells(labels, n_clusters, cells)
      added = pack(division%clusters(k)%snapshots, division%clusters(k)%snapshots > n_grid)
      label_of_added = [(labels(cells%find(snapshots%parameters(:, added(i)))), i=1, size(added))]
      halves(1)%snapshots = [clusters(k)%snapshots, pack(added, label_of_added == k)]
      halves(2)%snapshots = [clusters(n_clusters)%snapshots, pack(added, label_of_added == n_clusters)]
    end associate
  end subroutine halve_cells

  !> Fills cells and labels of the choice where they are missing, because a division into one cluster has none: all labels are 1.
  subroutine need_labels(deck, choice)
    type(deck_config_t), intent(in) :: deck
    type(model_choice_t), intent(inout) :: choice

    if (allocated(choice%labels)) return
    choice%cells%n_values = deck%training%grid
    associate (parameters => deck%state_parameters)
      choice%cells%box = transpose(reshape([parameters%minimum, parameters%maximum], [size(parameters), 2]))
    end associate
    allocate (choice%labels(choice%cells%n_cells()), source=1)
  end subroutine need_labels

  !> Halves a cluster by the angles between its snapshots. Collective on comm.
  subroutine halve_snapshots(deck, snapshots, cluster, comm, halves, ierr)
    type(deck_config_t), intent(in) :: deck
    type(training_set_t), intent(in) :: snapshots
    type(cluster_t), intent(in) :: cluster
    MPI_Comm, intent(in) :: comm
    !> each snapshot of the cluster is in one of them; the second is empty for a single snapshot
    type(cluster_t), intent(out) :: halves(2)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: coordinates(:, :), dissimilarity(:, :)
    logical :: is_second(size(cluster%snapshots))

    PetscCall(snapshot_coordinates(snapshots%select(cluster%snapshots), comm, coordinates, ierr))
    associate (is_signed => deck%clusters%opposite_snapshots == 'different')
      PetscCall(dissimilarity_of_snapshots(coordinates, is_signed, comm, dissimilarity, ierr))
    end associate
    is_second = second_half(deck, dissimilarity)
    halves(1)%snapshots = pack(cluster%snapshots, .not. is_second)
    halves(2)%snapshots = pack(cluster%snapshots, is_second)
  end subroutine halve_snapshots

  !> Whether each item belongs to the second of two medoids; false for a single item, and for all items where find_medoids fails.
  function second_half(deck, dissimilarity) result(is_second)
    type(deck_config_t), intent(in) :: deck
    !> as in find_medoids
    real(rk), intent(in), contiguous :: dissimilarity(:, :)
    logical :: is_second(size(dissimilarity, 1))
    type(medoids_t) :: found
    type(error_t), allocatable :: error

    is_second = .false.
    if (size(is_second) < 2) return
    call find_medoids(dissimilarity, 2, medoid_options(deck%clusters), found, error)
    if (.not. allocated(error)) is_second = found%labels == 2
  end function second_half

  !> Returns the cluster of each snapshot up to the last one that is in a cluster; 0 for a snapshot in none. Each snapshot must be
  !> in one cluster at most.
  pure function labels_of(clusters) result(labels)
    type(cluster_t), intent(in) :: clusters(:)
    integer, allocatable :: labels(:)
    integer :: k, n

    n = 0
    do k = 1, size(clusters)
      n = max(n, maxval(clusters(k)%snapshots))
    end do
    allocate (labels(n), source=0)
    do k = 1, size(clusters)
      labels(clusters(k)%snapshots) = k
    end do
  end function labels_of
end module sig_cluster_split
