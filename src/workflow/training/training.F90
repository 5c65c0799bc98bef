! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Trains a hyper-reduced model: divides the snapshots into clusters and trains a local model for each cluster.
module sig_training
  use sig_cluster_division, only: divide_snapshots
  use sig_cluster_training, only: log_cluster_warnings, train_clusters
  use sig_clustering, only: cluster_t
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_hhr_data, only: hhr_data_t
  use sig_log, only: log_warning
  use sig_model, only: model_t
  use sig_model_parts, only: set_clusters
  use sig_model_header, only: fill_model_header
  use sig_parameter_space, only: format_point
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged
  use sig_snapshot_store, only: snapshot_set_t
  use sig_text, only: to_text
  use sig_training_set, only: take_snapshots, training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: train, take_solved

contains

  !> Divides the solved snapshots into clusters.number clusters (0: divide_snapshots chooses the number) and builds the
  !> hyper-reduced model of each. Warns of points without a solution (take_solved) and of doubtful clusters. The model gets no
  !> fallback. Collective on all ranks; the model is the same on each.
  !>
  !> Errors: no training point has a solution; those of divide_snapshots and train_clusters.
  subroutine train(problem, snapshots, model, error, ierr, is_draft)
    type(problem_t), intent(in) :: problem
    !> full-order solutions at the training points; each rank has some of their dofs
    type(snapshot_set_t), intent(in), target :: snapshots
    type(model_t), intent(out) :: model
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    !> the model is only used to choose training points: it has one cluster, and there are no warnings; default: false
    logical, intent(in), optional :: is_draft
    type(cluster_t), allocatable :: clusters(:)
    type(hhr_data_t), allocatable :: models(:)
    type(training_set_t) :: solved
    logical :: is_silent
    integer :: k, n_clusters

    ierr = 0
    is_silent = .false.
    if (present(is_draft)) is_silent = is_draft
    n_clusters = merge(1, problem%deck%clusters%number, is_silent)
    call take_solved(problem, snapshots, is_silent, solved, error)
    if (allocated(error)) return
    call fill_model_header(problem, solved, model)
    PetscCall(divide_snapshots(problem%deck, n_clusters, solved, model, clusters, error, ierr))
    if (allocated(error)) return
    allocate (models(size(clusters)))
    PetscCall(train_clusters(problem, solved, clusters, [(k, k=1, size(clusters))], models, error, ierr))
    if (allocated(error)) return
    call set_clusters(model, models)
    if (.not. is_silent) call log_cluster_warnings(model)
  end subroutine train

  !> Selects the snapshots with a converged full-order solution and, unless is_silent, warns of each of the others. Local. Errors:
  !> no point has such a solution; then there are no warnings.
  subroutine take_solved(problem, snapshots, is_silent, solved, error)
    type(problem_t), intent(in) :: problem
    !> must outlive `solved`, which points to it
    type(snapshot_set_t), intent(in), target :: snapshots
    !> gives no warnings
    logical, intent(in) :: is_silent
    type(training_set_t), intent(out) :: solved
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    solved = take_snapshots(snapshots, pack([(i, i=1, size(snapshots%reasons))], snapshots%reasons == reason_converged))
    if (solved%n_snapshots() == 0) then
      call make_error(error, 'none of the ' // to_text(size(snapshots%reasons)) // ' training points has a full-order solution', &
        problem%deck%path, exit_code=exit_not_converged)
      return
    end if
    do i = 1, size(snapshots%reasons)
      if (snapshots%reasons(i) == reason_converged .or. is_silent) cycle
      call log_warning('training without ' // format_point(problem%deck%parameters, snapshots%parameters(:, i)) // &
        ', which the full-order model did not solve')
    end do
  end subroutine take_solved
end module sig_training
