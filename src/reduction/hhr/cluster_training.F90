! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Trains the hyper-reduced model of each cluster: POD of its snapshots, reduced integration domain, reduced system. Groups of ranks
!> train different clusters at the same time.
module sig_cluster_training
  use mpi, only: MPI_Allreduce, MPI_INTEGER, MPI_MIN
  use sig_hhr_file, only: pack_cluster, unpack_cluster
  use sig_clustering, only: cluster_t
  use sig_error_broadcast, only: broadcast_bytes, broadcast_error
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_log, only: log_warning
  use sig_hhr_data, only: complete_cluster, hhr_data_t
  use sig_model, only: model_t
  use sig_problem, only: problem_t
  use sig_rank_groups, only: create_rank_groups, rank_groups_t
  use sig_reduced_domain, only: reduced_domain_t
  use sig_text, only: append_text, string_t, to_text
  use sig_training_domain, only: choose_domain
  use sig_training_duals, only: keep_dual_snapshots, snapshot_contact_values
  use sig_training_modes, only: compute_dual_modes, compute_modes, pod_modes_t
  use sig_training_set, only: training_set_t
  use sig_training_system, only: build_system
  use petsc
  implicit none(type, external)
  private
  public :: train_clusters, log_cluster_warnings

contains

  !> Trains the models of some clusters, each by one group of ranks. Afterwards every rank has all of them. Collective on all ranks.
  !>
  !> Errors: the error of the first cluster in `which` that could not be trained, with its number where there are several clusters;
  !> those of share_cluster. Then no model changes.
  subroutine train_clusters(problem, snapshots, clusters, which, models, error, ierr)
    type(problem_t), intent(in) :: problem
    !> full-order solutions, whose dofs are spread over all ranks
    type(training_set_t), intent(in) :: snapshots
    type(cluster_t), intent(in) :: clusters(:)
    !> numbers of the clusters to be trained
    integer, intent(in) :: which(:)
    !> models of all clusters; only those in `which` change
    type(hhr_data_t), intent(inout) :: models(:)
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(rank_groups_t) :: groups
    type(hhr_data_t) :: trained(size(which))
    integer :: first, i, i_failed, last

    PetscCall(create_rank_groups(0, size(which), groups, ierr))
    do first = 1, size(which), groups%n_groups
      last = min(first + groups%n_groups - 1, size(which))
      PetscCall(train_round(problem, snapshots, clusters, which(first:last), groups, trained(first:last), i_failed, error, ierr))
      PetscCallMPI(MPI_Allreduce(i_failed, i, 1, MPI_INTEGER, MPI_MIN, PETSC_COMM_WORLD, ierr))
      if (i <= last - first + 1) exit
    end do
    if (allocated(error) .and. size(clusters) > 1) error%message = 'cluster ' // to_text(which(first + i_failed - 1)) // ': ' // &
      error%message
    PetscCall(exchange_clusters(problem, groups, first + i_failed - 1, trained, error, ierr))
    PetscCall(groups%destroy(ierr))
    if (allocated(error)) return
    do i = 1, size(which)
      models(which(i)) = trained(i)
    end do
  end subroutine train_clusters

  !> Trains at most one cluster per group. First all ranks together compute the modes of each cluster, because each rank has only
  !> some dofs of the snapshots. Then each group trains its cluster. Collective on all ranks.
  subroutine train_round(problem, snapshots, clusters, which, groups, trained, i_failed, error, ierr)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(cluster_t), intent(in) :: clusters(:)
    !> numbers of the clusters of this round
    integer, intent(in) :: which(:)
    type(rank_groups_t), intent(in) :: groups
    !> models of these clusters; each group sets only its own
    type(hhr_data_t), intent(inout) :: trained(:)
    !> first cluster of the round that could not be trained, as far as this rank knows; size(which) + 1 where there is none
    integer, intent(out) :: i_failed
    !> the error of this cluster
    type(error_t), allocatable, intent(inout) :: error
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: own_error
    type(pod_modes_t) :: modes, own_modes
    type(training_set_t) :: own, some
    real(rk), allocatable :: contact_values(:, :)

    ierr = 0
    do i_failed = 1, size(which)
      some = snapshots%select(clusters(which(i_failed))%snapshots)
      PetscCall(compute_modes(problem, some, PETSC_COMM_WORLD, modes, error, ierr))
      if (allocated(error)) exit
      PetscCall(snapshot_contact_values(problem%rows, some, PETSC_COMM_WORLD, contact_values, ierr))
      if (i_failed /= groups%i_group) cycle
      own = some
      own_modes = modes
      trained(i_failed)%training_points = clusters(which(i_failed))%snapshots
      call move_alloc(contact_values, trained(i_failed)%contact_displacement_snapshots)
    end do
    if (groups%i_group >= i_failed) return
    PetscCall(train_cluster(problem, own, groups%comm, own_modes, trained(groups%i_group), own_error, ierr))
    if (.not. allocated(own_error)) return
    i_failed = groups%i_group
    call move_alloc(own_error, error)
  end subroutine train_round

  !> Sends every trained cluster to all ranks; after an error no further ones. Collective on all ranks.
  !>
  !> Errors: the error of the first cluster that could not be trained. It is the same for any number of groups, because each group
  !> trains its clusters in their order. Those of share_cluster.
  subroutine exchange_clusters(problem, groups, i_failed, trained, error, ierr)
    type(problem_t), intent(in) :: problem
    type(rank_groups_t), intent(in) :: groups
    !> number in `trained` of the cluster that this group could not train, where it has an error
    integer, intent(in) :: i_failed
    type(hhr_data_t), intent(inout) :: trained(:)
    !> on entry the error of this group
    type(error_t), allocatable, intent(inout) :: error
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: own_error
    integer :: i

    ierr = 0
    call move_alloc(error, own_error)
    do i = 1, size(trained)
      if (allocated(own_error) .and. i == i_failed) call move_alloc(own_error, error)
      PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
      if (allocated(error)) return
      call complete_cluster(trained(i), problem%mesh%n_dim * problem%mesh%n_nodes, problem%rows%n_rows)
      if (groups%n_groups == 1) cycle
      PetscCall(share_cluster(groups%leader_of(i), groups%world_rank, trained(i), error, ierr))
      if (allocated(error)) return
    end do
  end subroutine exchange_clusters

  !> Sends a cluster from one rank to all. Collective on all ranks. Errors: it cannot be packed into bytes or unpacked.
  subroutine share_cluster(root, rank, cluster, error, ierr)
    !> 0-based: the rank that has the cluster, and this rank
    integer, intent(in) :: root
    integer, intent(in) :: rank
    type(hhr_data_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    character(1), allocatable :: bytes(:)

    if (rank == root) call pack_cluster(cluster, bytes, error)
    PetscCall(broadcast_bytes(root, bytes, PETSC_COMM_WORLD, ierr))
    if (rank /= root .and. size(bytes) > 0) call unpack_cluster(bytes, cluster, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
  end subroutine share_cluster

  !> Writes the warnings of the training of each cluster to the log, with the number of the cluster where there are several.
  subroutine log_cluster_warnings(model)
    type(model_t), intent(in) :: model
    type(string_t), allocatable :: warnings(:)
    character(:), allocatable :: name
    integer :: i, k

    name = ''
    do k = 1, model%n_clusters()
      if (model%n_clusters() > 1) name = 'cluster ' // to_text(k) // ': '
      warnings = model%parts(k)%reduced%warnings()
      do i = 1, size(warnings)
        call log_warning(name // warnings(i)%text)
      end do
    end do
  end subroutine log_cluster_warnings

  !> Trains the model of one cluster. Collective on comm. Errors: those of choose_domain and build_system; no modes are left.
  subroutine train_cluster(problem, snapshots, comm, modes, cluster, error, ierr)
    type(problem_t), intent(in) :: problem
    !> those of this cluster; of their displacements each rank has some dofs
    type(training_set_t), intent(in) :: snapshots
    !> the group of ranks that trains this cluster
    MPI_Comm, intent(in) :: comm
    !> modes of the snapshots, all dofs
    type(pod_modes_t), intent(in) :: modes
    !> training_points and contact_displacement_snapshots are set before
    type(hhr_data_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: dual_modes(:, :)
    type(reduced_domain_t) :: domain
    integer, allocatable :: moved_nodes(:)

    PetscCall(compute_dual_modes(problem, snapshots, comm, dual_modes, ierr))
    associate (values => cluster%contact_displacement_snapshots, vectors => modes%vectors(:, :modes%n_domain))
      call choose_domain(problem, snapshots, values, vectors, dual_modes, domain, moved_nodes, error)
    end associate
    if (allocated(error)) return
    cluster%singular_values = modes%singular_values
    cluster%n_pod_modes = modes%n_domain
    cluster%n_extra_modes = modes%n_extra
    call build_system(problem, snapshots, domain, moved_nodes, modes%vectors, cluster, error)
    if (allocated(error)) return
    call need_unknowns(problem, cluster, error)
    if (allocated(error)) return
    if (snapshots%n_snapshots() == 1) call append_text(cluster%warnings, 'trained on one snapshot: the model knows no other ' // &
      'state than that of its training point; take more training points')
    call keep_dual_snapshots(problem, snapshots, cluster)
    cluster%fits_displacements = problem%deck%reduction%reconstruction == 'multipliers_and_displacements'
  end subroutine train_cluster

  !> Checks that modes, hats included, are left after the prescribed rows are imposed. Errors: none is left.
  subroutine need_unknowns(problem, cluster, error)
    type(problem_t), intent(in) :: problem
    type(hhr_data_t), intent(in) :: cluster
    type(error_t), allocatable, intent(out) :: error

    if (cluster%n_modes > 0) return
    call make_error(error, 'the reduced model has no unknowns: the prescribed displacements fix all its POD modes (' // &
      to_text(cluster%n_pod_modes + cluster%n_extra_modes) // ')', problem%deck%path, &
      hint='take reduction.dirichlet: elastic_lifting, more modes (a smaller reduction.pod_tolerance, or a larger ' // &
      'n_modes), or more training points')
  end subroutine need_unknowns
end module sig_cluster_training
