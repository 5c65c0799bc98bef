! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Divides the training points into the clusters that the deck asks for, and prepares the rule by which a query chooses a cluster.
module sig_cluster_division
  use sig_clustering, only: cell_subspaces, check_clusters, check_snapshots, cluster_t, clusters_of_cells, clusters_of_snapshots
  use sig_deck_config, only: clusters_config_t, deck_config_t
  use sig_dissimilarity, only: dissimilarity_of_snapshots, dissimilarity_of_subspaces, snapshot_coordinates
  use sig_errors, only: error_t, make_error
  use sig_forest_training, only: train_forest
  use sig_grassmann, only: subspace_t
  use sig_grid_cells, only: grid_cells_t
  use sig_k_medoids, only: choose_n_clusters, find_medoids, k_medoids_options_t, medoids_t, merge_cluster
  use sig_kinds, only: rk
  use sig_log, only: log_info, log_warning
  use sig_model, only: model_t
  use sig_parameter_space, only: format_point
  use sig_snapshot_lengths, only: find_identical, snapshot_lengths
  use sig_text, only: counted, to_text
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: divide_snapshots, medoid_options, need_whole_grid

contains

  !> Makes the clusters of the snapshots. With n_clusters = 1 this is one cluster of all, and nothing else happens. Otherwise it
  !> fills model%choice, and writes a warning to the log if two snapshots are equal. With small_clusters: merge there may be fewer
  !> clusters than asked for. Collective on all ranks, with the same result on each.
  !>
  !> Source: section 4. Errors, unless n_clusters is 1: a snapshot is zero; a point of the grid has no solution (regular clusters);
  !> n_clusters is larger than the number of items, which are the cells of the grid (regular) or the snapshots (irregular); a
  !> cluster has fewer snapshots than clusters.min_snapshots; the forest cannot be trained (irregular clusters).
  subroutine divide_snapshots(deck, n_clusters, snapshots, model, clusters, error, ierr)
    type(deck_config_t), intent(in) :: deck
    !> 0: the number from 2 to clusters.max_number with the best separated clusters is chosen; 1 if max_number is 1, or if there is
    !> only one item
    integer, intent(in) :: n_clusters
    !> all snapshots that have a full-order solution, in the order of the training points of the deck
    type(training_set_t), intent(in) :: snapshots
    !> its header is filled (fill_model_header); of the model only `choice` changes
    type(model_t), intent(inout) :: model
    type(cluster_t), allocatable, intent(out) :: clusters(:)
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(medoids_t) :: found
    real(rk), allocatable :: coordinates(:, :), dissimilarity(:, :), lengths(:)
    integer :: i

    ierr = 0
    if (n_clusters == 1) then
      allocate (clusters(1))
      clusters(1)%snapshots = [(i, i=1, snapshots%n_snapshots())]
      return
    end if
    PetscCall(snapshot_lengths(snapshots, PETSC_COMM_WORLD, lengths, ierr))
    work: block
      call check_snapshots(lengths, model%parameter_names, snapshots%parameters, error)
      if (allocated(error)) exit work
      PetscCall(warn_of_identical(deck, snapshots, lengths, ierr))
      PetscCall(snapshot_coordinates(snapshots, PETSC_COMM_WORLD, coordinates, ierr))
      PetscCall(compare(deck, coordinates, model, dissimilarity, error, ierr))
      if (allocated(error)) exit work
      call find_clusters(deck, n_clusters, dissimilarity, model%choice%cells, found, clusters, error)
      if (allocated(error)) exit work
      call check_clusters(clusters, deck%clusters%min_snapshots, error)
      if (allocated(error)) exit work
      model%choice%loss = found%loss
      model%choice%silhouette = found%silhouette
      if (deck%clusters%method == 'regular') then
        model%choice%labels = found%labels
      else if (size(clusters) > 1) then
        PetscCall(train_forest(deck, model%training_points, found%labels, PETSC_COMM_WORLD, model%choice%forest, error, ierr))
      end if
    end block work
    if (.not. allocated(error)) return
    if (len(error%file) == 0) error%file = deck%path
  end subroutine divide_snapshots

  !> Writes a warning to the log if some snapshot equals an earlier one, with the points of the first such pair (find_identical).
  !> Collective on all ranks.
  subroutine warn_of_identical(deck, snapshots, lengths, ierr)
    type(deck_config_t), intent(in) :: deck
    type(training_set_t), intent(in) :: snapshots
    !> [length] from snapshot_lengths
    real(rk), intent(in) :: lengths(:)
    PetscErrorCode, intent(out) :: ierr
    integer :: i_earlier, i_snapshot

    PetscCall(find_identical(snapshots, lengths, PETSC_COMM_WORLD, i_snapshot, i_earlier, ierr))
    if (i_snapshot == 0) return
    call log_warning('the snapshots at ' // format_point(deck%state_parameters, snapshots%parameters(:, i_earlier)) // &
      ' and at ' // format_point(deck%state_parameters, snapshots%parameters(:, i_snapshot)) // &
      ' are equal; one of them adds no information')
  end subroutine warn_of_identical

  !> Computes how different each two of the items are that are clustered: cells of the grid, which go to model%choice, by the
  !> principal angles between their POD modes (regular; source: section 4.1), or snapshots by the angles between them (irregular;
  !> section 4.2). Collective on all ranks. Errors: those of need_whole_grid.
  subroutine compare(deck, coordinates, model, dissimilarity, error, ierr)
    type(deck_config_t), intent(in) :: deck
    !> of snapshot_coordinates, shape (n_coordinates, n_snapshots)
    real(rk), intent(in) :: coordinates(:, :)
    type(model_t), intent(inout) :: model
    !> as in find_medoids
    real(rk), allocatable, intent(out) :: dissimilarity(:, :)
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(subspace_t), allocatable :: subspaces(:)
    integer :: i

    ierr = 0
    if (deck%clusters%method == 'irregular') then
      PetscCall(dissimilarity_of_snapshots(coordinates, deck%clusters%opposite_snapshots == 'different', PETSC_COMM_WORLD, dissimilarity, ierr))
      return
    end if
    call need_whole_grid(deck, size(coordinates, 2), error)
    if (allocated(error)) return
    associate (cells => model%choice%cells)
      cells%n_values = deck%training%grid
      cells%box = model%box
      subspaces = cell_subspaces(coordinates, cells, [(i, i=1, cells%n_cells())], deck%clusters%cell_pod_tolerance)
    end associate
    PetscCall(dissimilarity_of_subspaces(subspaces, PETSC_COMM_WORLD, dissimilarity, ierr))
  end subroutine compare

  !> Checks that every point of the training grid has a solution. Errors: a point has none.
  subroutine need_whole_grid(deck, n_points, error)
    type(deck_config_t), intent(in) :: deck
    !> number of training points that have a solution
    integer, intent(in) :: n_points
    type(error_t), allocatable, intent(out) :: error

    if (n_points < product(deck%training%grid)) call make_error(error, 'clusters of grid cells need a solution at each of the ' // &
      counted(product(deck%training%grid), 'training point') // '; ' // to_text(n_points) // ' have one', deck%path, &
      hint='use clusters: {method: irregular, ...}')
  end subroutine need_whole_grid

  !> Finds n_clusters clusters, or, with n_clusters = 0, the number of choose_n_clusters, at most clusters.max_number. Small
  !> clusters are merged if the deck asks for it. Local, with the same result on every rank. Errors: those of find_medoids.
  subroutine find_clusters(deck, n_clusters, dissimilarity, cells, found, clusters, error)
    type(deck_config_t), intent(in) :: deck
    integer, intent(in) :: n_clusters
    !> as in find_medoids
    real(rk), intent(in), contiguous :: dissimilarity(:, :)
    !> of the items, where these are cells
    type(grid_cells_t), intent(in) :: cells
    type(medoids_t), intent(out) :: found
    !> the snapshots of each cluster
    type(cluster_t), allocatable, intent(out) :: clusters(:)
    type(error_t), allocatable, intent(out) :: error

    if (n_clusters == 0) then
      call choose_n_clusters(dissimilarity, deck%clusters%max_number, medoid_options(deck%clusters), found, error)
    else
      call find_medoids(dissimilarity, n_clusters, medoid_options(deck%clusters), found, error)
    end if
    if (allocated(error)) return
    clusters = clusters_of(deck, found, cells)
    do while (has_small_cluster(deck, clusters, found))
      call dissolve_small(deck, dissimilarity, clusters, found)
      clusters = clusters_of(deck, found, cells)
    end do
  end subroutine find_clusters

  !> Returns the clusters of snapshots of labeled cells (regular) or snapshots.
  function clusters_of(deck, found, cells) result(clusters)
    type(deck_config_t), intent(in) :: deck
    type(medoids_t), intent(in) :: found
    type(grid_cells_t), intent(in) :: cells
    type(cluster_t) :: clusters(size(found%medoids))

    if (deck%clusters%method == 'regular') then
      clusters = clusters_of_cells(found%labels, size(found%medoids), cells)
    else
      clusters = clusters_of_snapshots(found%labels, size(found%medoids))
    end if
  end function clusters_of

  !> Returns the options of k-medoids: the seed from the deck, defaults for the others.
  pure function medoid_options(clusters) result(options)
    type(clusters_config_t), intent(in) :: clusters
    type(k_medoids_options_t) :: options

    options%seed = clusters%seed
  end function medoid_options

  !> Whether some cluster has fewer snapshots than clusters.min_snapshots and the deck asks to merge such clusters. False where
  !> there is only one cluster.
  pure logical function has_small_cluster(deck, clusters, found)
    type(deck_config_t), intent(in) :: deck
    type(cluster_t), intent(in) :: clusters(:)
    !> the medoids and labels from which `clusters` were made
    type(medoids_t), intent(in) :: found

    has_small_cluster = deck%clusters%small_clusters == 'merge' .and. size(found%medoids) > 1 .and. &
      minval(sizes_of(clusters)) < deck%clusters%min_snapshots
  end function has_small_cluster

  pure function sizes_of(clusters) result(sizes)
    type(cluster_t), intent(in) :: clusters(:)
    integer :: sizes(size(clusters))
    integer :: i

    do i = 1, size(clusters)
      sizes(i) = size(clusters(i)%snapshots)
    end do
  end function sizes_of

  !> Merges the cluster with the fewest snapshots (of equal ones the first) by merge_cluster, and writes to the log into which
  !> cluster. Changes only `found`; the caller makes `clusters` again from it.
  subroutine dissolve_small(deck, dissimilarity, clusters, found)
    type(deck_config_t), intent(in) :: deck
    !> as in find_medoids
    real(rk), intent(in), contiguous :: dissimilarity(:, :)
    type(cluster_t), intent(in) :: clusters(:)
    type(medoids_t), intent(inout) :: found
    integer :: i_small, i_target, sizes(size(clusters))

    sizes = sizes_of(clusters)
    i_small = minloc(sizes, dim=1)
    call merge_cluster(dissimilarity, i_small, found, i_target)
    call log_info('cluster ' // to_text(i_small) // ' of ' // to_text(size(sizes)) // ' has ' // &
      counted(sizes(i_small), 'snapshot') // ', fewer than ' // to_text(deck%clusters%min_snapshots) // &
      ': merged into cluster ' // to_text(i_target) // ' (' // counted(sizes(i_target), 'snapshot') // '), whose medoid is nearest')
  end subroutine dissolve_small
end module sig_cluster_division
