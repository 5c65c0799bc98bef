! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Snapshots -> clusters -> local models -> model.
module sig_training
  use sig_cluster_division, only: divide_snapshots
  use sig_cluster_training, only: log_cluster_warnings, train_clusters
  use sig_clustering, only: cluster_t
  use sig_contact_state, only: reason_converged
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_hhr_data, only: hhr_data_t
  use sig_log, only: log_warning
  use sig_model, only: model_t
  use sig_model_parts, only: set_clusters
  use sig_model_header, only: fill_model_header
  use sig_parameter_space, only: format_point
  use sig_problem, only: problem_t
  use sig_snapshot_store, only: columns_of, snapshot_set_t
  use sig_text, only: to_text
  use petsc
  implicit none(type, external)
  private
  public :: train, select_converged

contains

  !> Builds the reduced model of each cluster of snapshots. Collective on all ranks; the model is the same on each.
  subroutine train(problem, snapshots, model, error, ierr, is_draft)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(model_t), intent(out) :: model
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    !> a model on the way to another one has one cluster and says no warnings
    logical, intent(in), optional :: is_draft
    type(cluster_t), allocatable :: clusters(:)
    type(hhr_data_t), allocatable :: models(:)
    type(snapshot_set_t) :: converged
    logical :: is_silent
    integer :: k, n_clusters

    ierr = 0
    is_silent = .false.
    if (present(is_draft)) is_silent = is_draft
    n_clusters = merge(1, problem%deck%clusters%number, is_silent)
    call select_converged(problem, snapshots, is_silent, converged, error)
    if (allocated(error)) return
    call fill_model_header(problem, converged, model)
    PetscCall(divide_snapshots(problem%deck, n_clusters, converged, model, clusters, error, ierr))
    if (allocated(error)) return
    allocate (models(size(clusters)))
    PetscCall(train_clusters(problem, converged, clusters, [(k, k=1, size(clusters))], models, error, ierr))
    if (allocated(error)) return
    call set_clusters(model, models)
    if (.not. is_silent) call log_cluster_warnings(model)
  end subroutine train

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
end module sig_training
