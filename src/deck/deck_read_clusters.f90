! SPDX-License-Identifier: BSD-3-Clause
!> Reads the section `clusters` of a deck.
module sig_deck_read_clusters
  use sig_deck_config, only: clusters_config_t, parameter_config_t, refine_config_t, target_config_t
  use sig_deck_read_points, only: read_candidates, read_count
  use sig_deck_read_reduction, only: read_count_or_word
  use sig_deck_tree, only: deck_tree_t, root_node
  use sig_deck_values, only: get_choice, get_integer, get_mapping, get_number
  implicit none(type, external)
  private
  public :: read_clusters

  character(*), parameter :: cluster_methods(2) = [character(9) :: 'regular', 'irregular']
  character(*), parameter :: opposites(2) = [character(9) :: 'equal', 'different']
  character(*), parameter :: small_treatments(2) = [character(6) :: 'refuse', 'merge']
  character(*), parameter :: measures(3) = [character(12) :: 'e_lambda_all', 'e_lambda_rid', 'e_u']
  character(*), parameter :: statistics(3) = [character(6) :: 'p95', 'median', 'max']

contains

  !> Reads the section clusters. Without it, or for keys that are missing, sets or keeps the defaults. Errors: a section without
  !> `number`, unknown keys, faulty values.
  subroutine read_clusters(tree, parameters, clusters)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(parameter_config_t), intent(in) :: parameters(:)
    !> on entry with the defaults of its type
    type(clusters_config_t), intent(inout) :: clusters
    integer :: i_clusters

    clusters%method = trim(cluster_methods(1))
    clusters%opposite_snapshots = trim(opposites(1))
    clusters%small_clusters = trim(small_treatments(1))
    i_clusters = get_mapping(tree, root_node, 'clusters', .false.)
    if (i_clusters == 0) return
    if (tree%find(i_clusters, 'number') == 0) then
      call get_integer(tree, i_clusters, 'number', .true., clusters%number)
    else
      clusters%number = 0
      call read_count_or_word(tree, i_clusters, 'number', 'auto', 1, clusters%number)
    end if
    call get_integer(tree, i_clusters, 'max_number', .false., clusters%max_number)
    call get_choice(tree, i_clusters, 'method', .false., cluster_methods, clusters%method)
    call get_number(tree, i_clusters, 'cell_pod_tolerance', .false., clusters%cell_pod_tolerance)
    call get_choice(tree, i_clusters, 'opposite_snapshots', .false., opposites, clusters%opposite_snapshots)
    call get_integer(tree, i_clusters, 'min_snapshots', .false., clusters%min_snapshots)
    call get_choice(tree, i_clusters, 'small_clusters', .false., small_treatments, clusters%small_clusters)
    call tree%refuse_key(i_clusters, 'algorithm', 'earlier versions had it; clusters are always found as by faster_pam')
    call get_integer(tree, i_clusters, 'seed', .false., clusters%seed)
    call read_target(tree, i_clusters, parameters, clusters%target)
    call read_refine(tree, i_clusters, clusters%refine)
    call tree%close_mapping(i_clusters)
  end subroutine read_clusters

  !> Reads the key target: the target error, its measure and statistic, and the points where it is measured. Without the key, or if
  !> its value is no mapping (an error), sets only defaults. Other errors: its key error or candidates is missing, unknown keys,
  !> faulty values. target%error is 1 where the key error is missing or no number.
  subroutine read_target(tree, i_clusters, parameters, target)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_clusters
    type(parameter_config_t), intent(in) :: parameters(:)
    type(target_config_t), intent(inout) :: target
    integer :: i_target

    target%measure = trim(measures(1))
    target%statistic = trim(statistics(1))
    i_target = get_mapping(tree, i_clusters, 'target', .false.)
    target%is_used = i_target > 0
    if (.not. target%is_used) return
    ! value in place of a faulty one
    target%error = 1
    call get_number(tree, i_target, 'error', .true., target%error)
    call get_choice(tree, i_target, 'measure', .false., measures, target%measure)
    call get_choice(tree, i_target, 'statistic', .false., statistics, target%statistic)
    call read_candidates(tree, i_target, 'clusters.target.candidates', parameters, target%candidates)
    call tree%close_mapping(i_target)
  end subroutine read_target

  subroutine read_refine(tree, i_clusters, refine)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_clusters
    type(refine_config_t), intent(inout) :: refine
    integer :: i_refine

    i_refine = get_mapping(tree, i_clusters, 'refine', .false.)
    refine%is_used = i_refine > 0
    if (.not. refine%is_used) return
    call get_integer(tree, i_refine, 'max_points', .false., refine%max_points)
    call read_count(tree, i_refine, 'points_per_round', refine%points_per_round)
    call tree%close_mapping(i_refine)
  end subroutine read_refine
end module sig_deck_read_clusters
