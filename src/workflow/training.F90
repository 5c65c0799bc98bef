! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Snapshots -> clusters -> POD -> reduced integration domain -> reduced system -> model; groups of ranks train different clusters.
module sig_training
  use sig_cluster_division, only: divide_snapshots
  use sig_cluster_file, only: pack_cluster, unpack_cluster
  use sig_clustering, only: cluster_t
  use sig_contact_state, only: reason_converged
  use sig_error_broadcast, only: broadcast_bytes, broadcast_error
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_kinds, only: rk
  use sig_log, only: log_warning
  use sig_model, only: complete_cluster, model_t, reduced_model_t
  use sig_model_header, only: fill_model_header
  use sig_parameter_space, only: format_point
  use sig_problem, only: problem_t
  use sig_rank_groups, only: create_rank_groups, rank_groups_t
  use sig_reduced_domain, only: reduced_domain_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_text, only: to_text
  use sig_training_domain, only: choose_domain
  use sig_training_duals, only: keep_dual_snapshots
  use sig_training_modes, only: compute_dual_modes, compute_modes, pod_modes_t
  use sig_training_system, only: build_system
  use petsc
  implicit none(type, external)
  private
  public :: train

contains

  !> Builds the reduced model of each cluster of snapshots. Collective on all ranks; the model is the same on each.
  subroutine train(problem, snapshots, model, error, ierr, is_draft)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(model_t), intent(out) :: model
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    !> a model on the way to another one says no warnings
    logical, intent(in), optional :: is_draft
    type(cluster_t), allocatable :: clusters(:)
    type(snapshot_set_t) :: converged
    logical :: is_silent

    ierr = 0
    is_silent = .false.
    if (present(is_draft)) is_silent = is_draft
    call select_converged(problem, snapshots, is_silent, converged, error)
    if (allocated(error)) return
    call fill_model_header(problem, converged, model)
    PetscCall(divide_snapshots(problem%deck, converged, model, clusters, error, ierr))
    if (allocated(error)) return
    PetscCall(train_clusters(problem, converged, clusters, is_silent, model, error, ierr))
  end subroutine train

  !> The local models, each by one group of ranks, then on every rank. Collective on all ranks.
  subroutine train_clusters(problem, snapshots, clusters, is_silent, model, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(cluster_t), intent(in) :: clusters(:)
    logical, intent(in) :: is_silent
    type(model_t), intent(inout) :: model
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(rank_groups_t) :: groups
    integer :: k

    PetscCall(create_rank_groups(0, size(clusters), groups, ierr))
    allocate (model%clusters(size(clusters)))
    do k = 1, size(clusters)
      if (.not. groups%has_point(k)) cycle
      model%clusters(k)%training_points = clusters(k)%snapshots
      PetscCall(train_cluster(problem, columns_of(snapshots, clusters(k)%snapshots), groups%comm, model%clusters(k), error, ierr))
      if (allocated(error)) exit
    end do
    PetscCall(exchange_clusters(groups, k, is_silent, model, error, ierr))
    PetscCall(groups%destroy(ierr))
  end subroutine train_clusters

  !> Makes every cluster known to all ranks, and says its warnings. Collective on all ranks.
  !>
  !> Errors: of the first cluster that could not be trained; those before it are there in every division of the ranks, because a
  !> group trains its clusters in their order.
  subroutine exchange_clusters(groups, k_failed, is_silent, model, error, ierr)
    type(rank_groups_t), intent(in) :: groups
    !> cluster that this group could not train, where it has an error
    integer, intent(in) :: k_failed
    logical, intent(in) :: is_silent
    type(model_t), intent(inout) :: model
    !> in: of this group
    type(error_t), allocatable, intent(inout) :: error
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: own_error
    character(:), allocatable :: name
    integer :: i, k

    ierr = 0
    call move_alloc(error, own_error)
    name = ''
    do k = 1, size(model%clusters)
      if (size(model%clusters) > 1) name = 'cluster ' // to_text(k) // ': '
      if (allocated(own_error) .and. k == k_failed) call move_alloc(own_error, error)
      PetscCall(share_cluster(groups, k, model%n_dofs, model%n_multipliers, model%clusters(k), error, ierr))
      do i = 1, size(model%clusters(k)%warnings)
        if (.not. is_silent) call log_warning(name // model%clusters(k)%warnings(i)%text)
      end do
      if (.not. allocated(error)) cycle
      error%message = name // error%message
      return
    end do
  end subroutine exchange_clusters

  !> From the group that has it to all ranks. Collective on all ranks.
  subroutine share_cluster(groups, k, n_dofs, n_multipliers, cluster, error, ierr)
    type(rank_groups_t), intent(in) :: groups
    integer, intent(in) :: k, n_dofs, n_multipliers
    !> in: trained, perhaps in part, where this group has it
    type(reduced_model_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(inout) :: error
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: share_error
    character(1), allocatable :: bytes(:)
    integer :: root

    ierr = 0
    call complete_cluster(cluster, n_dofs, n_multipliers)
    if (groups%n_groups == 1) return
    root = groups%leader_of(k)
    if (groups%world_rank == root) call pack_cluster(cluster, bytes, share_error)
    PetscCall(broadcast_bytes(root, bytes, PETSC_COMM_WORLD, ierr))
    if (groups%world_rank /= root .and. size(bytes) > 0) call unpack_cluster(bytes, cluster, share_error)
    if (.not. allocated(error)) call move_alloc(share_error, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
  end subroutine share_cluster

  !> Leaves out the points that the full-order model did not solve.
  subroutine select_converged(problem, snapshots, is_silent, converged, error)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    logical, intent(in) :: is_silent
    type(snapshot_set_t), intent(out) :: converged
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: kept(:)
    integer :: i

    kept = pack([(i, i=1, size(snapshots%reasons))], snapshots%reasons == reason_converged)
    if (size(kept) == 0) then
      call make_error(error, 'none of the ' // to_text(size(snapshots%reasons)) // ' training points has a full-order solution', &
        problem%deck%path, exit_code=exit_not_converged)
      return
    end if
    do i = 1, size(snapshots%reasons)
      if (snapshots%reasons(i) == reason_converged .or. is_silent) cycle
      call log_warning('training without ' // format_point(problem%deck%parameters, snapshots%parameters(:, i)) // &
        ', which the full-order model did not solve')
    end do
    converged = columns_of(snapshots, kept)
  end subroutine select_converged

  !> The snapshots with these numbers, as far as a training looks at them.
  pure function columns_of(snapshots, numbers) result(chosen)
    type(snapshot_set_t), intent(in) :: snapshots
    !> 1-based
    integer, intent(in) :: numbers(:)
    type(snapshot_set_t) :: chosen

    chosen%parameters = snapshots%parameters(:, numbers)
    chosen%displacement = snapshots%displacement(:, numbers)
    chosen%multipliers = snapshots%multipliers(:, numbers)
    chosen%free_response = snapshots%free_response
  end function columns_of

  !> One local model. Collective on comm.
  subroutine train_cluster(problem, snapshots, comm, cluster, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    MPI_Comm, intent(in) :: comm
    !> training_points is set
    type(reduced_model_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(pod_modes_t) :: modes
    real(rk), allocatable :: dual_modes(:, :)
    type(reduced_domain_t) :: domain
    integer, allocatable :: anchors(:)

    PetscCall(compute_modes(problem, snapshots, comm, modes, error, ierr))
    if (allocated(error)) return
    PetscCall(compute_dual_modes(problem, snapshots, comm, dual_modes, ierr))
    call choose_domain(problem, snapshots%parameters, modes%vectors(:, :modes%n_domain), dual_modes, domain, anchors, error)
    if (allocated(error)) return
    cluster%singular_values = modes%singular_values
    cluster%n_pod_modes = modes%n_domain
    cluster%n_extra_modes = modes%n_extra
    call build_system(problem, snapshots, domain, anchors, modes%vectors, cluster, error)
    if (allocated(error)) return
    call keep_dual_snapshots(problem%operator, snapshots, cluster)
  end subroutine train_cluster
end module sig_training
