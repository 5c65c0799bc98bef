! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Snapshots -> POD -> reduced integration domain -> reduced system -> model.
module sig_training
  use sig_contact_state, only: reason_converged
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_kinds, only: rk
  use sig_log, only: log_warning
  use sig_model, only: model_t, reduced_model_t
  use sig_model_header, only: fill_model_header
  use sig_parameter_space, only: format_point
  use sig_pod, only: compute_pod
  use sig_pod_rank, only: pod_rank
  use sig_problem, only: problem_t
  use sig_reduced_domain, only: reduced_domain_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: to_text
  use sig_training_domain, only: choose_domain
  use sig_training_duals, only: keep_dual_snapshots
  use sig_training_system, only: build_system
  use petsc
  implicit none(type, external)
  private
  public :: train

contains

  !> Builds the reduced model of all snapshots. Collective on all ranks; the model is the same on each.
  subroutine train(problem, snapshots, model, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(model_t), intent(out) :: model
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t) :: converged

    ierr = 0
    call select_converged(problem, snapshots, converged, error)
    if (allocated(error)) return
    call fill_model_header(problem, converged, model)
    allocate (model%clusters(1))
    PetscCall(train_cluster(problem, converged, model%clusters(1), error, ierr))
  end subroutine train

  !> Leaves out the points that the full-order model did not solve.
  subroutine select_converged(problem, snapshots, converged, error)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(snapshot_set_t), intent(out) :: converged
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: kept(:)
    integer :: i

    converged = snapshots
    kept = pack([(i, i=1, size(snapshots%reasons))], snapshots%reasons == reason_converged)
    if (size(kept) == 0) then
      call make_error(error, 'none of the ' // to_text(size(snapshots%reasons)) // ' training points has a full-order solution', &
        problem%deck%path, exit_code=exit_not_converged)
      return
    end if
    do i = 1, size(snapshots%reasons)
      if (snapshots%reasons(i) == reason_converged) cycle
      call log_warning('training without ' // format_point(problem%deck%parameters, snapshots%parameters(:, i)) // &
        ', which the full-order model did not solve')
    end do
    converged%parameters = snapshots%parameters(:, kept)
    converged%displacement = snapshots%displacement(:, kept)
    converged%multipliers = snapshots%multipliers(:, kept)
  end subroutine select_converged

  !> One local model. Collective on all ranks.
  subroutine train_cluster(problem, snapshots, cluster, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(reduced_model_t), intent(out) :: cluster
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: fields(:, :), vectors(:, :)
    integer, allocatable :: anchors(:)
    type(reduced_domain_t) :: domain
    integer :: n_modes

    ierr = 0
    call fields_to_compress(problem, snapshots, fields)
    PetscCall(compute_pod(fields, PETSC_COMM_WORLD, cluster%singular_values, vectors, ierr))
    n_modes = pod_rank(cluster%singular_values, problem%deck%reduction%pod_tolerance)
    if (n_modes == 0) then
      call make_error(error, 'all snapshots are zero: no training point loads the bodies', problem%deck%path)
      return
    end if
    call choose_domain(problem, vectors(:, :n_modes), domain, anchors, error)
    if (allocated(error)) return
    call build_system(problem, snapshots, domain, anchors, vectors(:, :n_modes), cluster, error)
    if (allocated(error)) return
    call keep_dual_snapshots(problem%operator, snapshots, cluster)
  end subroutine train_cluster

  !> Whole fields, or what contact adds to the elastic response.
  subroutine fields_to_compress(problem, snapshots, fields)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    real(rk), allocatable, intent(out) :: fields(:, :)
    real(rk), allocatable :: theta(:, :)
    integer :: i_bad_point, i_bad_source

    fields = snapshots%displacement
    if (problem%deck%reduction%dirichlet == 'multiplier') return
    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    fields = fields - matmul(snapshots%free_response, theta(:size(snapshots%free_response, 2), :))
  end subroutine fields_to_compress
end module sig_training
