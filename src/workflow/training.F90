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
  use sig_problem, only: problem_t
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
    type(pod_modes_t) :: modes
    real(rk), allocatable :: dual_modes(:, :)
    type(reduced_domain_t) :: domain
    integer, allocatable :: anchors(:)

    PetscCall(compute_modes(problem, snapshots, modes, error, ierr))
    if (allocated(error)) return
    PetscCall(compute_dual_modes(problem, snapshots, dual_modes, ierr))
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
