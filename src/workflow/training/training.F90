! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Trains a hyper-reduced model: divides the snapshots into clusters and trains a local model for each cluster.
module sig_training
  use sig_accuracy_warnings, only: open_contact_warnings
  use sig_cluster_division, only: divide_snapshots
  use sig_cluster_training, only: log_cluster_warnings, train_clusters
  use sig_clustering, only: cluster_t
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_hhr_data, only: hhr_data_t
  use sig_log, only: log_warning, log_warnings
  use sig_model, only: model_t
  use sig_model_parts, only: set_clusters
  use sig_model_header, only: fill_model_header
  use sig_parameter_space, only: format_point
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged, reason_text
  use sig_snapshot_store, only: snapshot_set_t
  use sig_text, only: counted, string_t, to_text
  use sig_training_set, only: take_snapshots, training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: train, take_solved, warn_of_snapshots

contains

  !> Divides the solved snapshots into clusters.number clusters (0: divide_snapshots chooses the number) and builds the
  !> hyper-reduced model of each. Warns of doubtful clusters. The model gets no fallback. Collective on all ranks; the model is the
  !> same on each.
  !>
  !> Errors: no training point has a solution; those of divide_snapshots and train_clusters.
  subroutine train(problem, snapshots, model, error, ierr, is_draft)
    type(problem_t), intent(in) :: problem
    !> full-order solutions at the training points; each rank has some of their dofs
    type(snapshot_set_t), intent(in), target :: snapshots
    type(model_t), intent(out) :: model
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    !> the model is only used to choose training points: it has one cluster, and there are no warnings of clusters; default: false
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
    call take_solved(problem, snapshots, solved, error)
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

  !> Selects the snapshots with a converged full-order solution. Local. Errors: no point has such a solution.
  subroutine take_solved(problem, snapshots, solved, error)
    type(problem_t), intent(in) :: problem
    !> must outlive `solved`, which points to it
    type(snapshot_set_t), intent(in), target :: snapshots
    type(training_set_t), intent(out) :: solved
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    solved = take_snapshots(snapshots, pack([(i, i=1, size(snapshots%reasons))], snapshots%reasons == reason_converged))
    if (solved%n_snapshots() == 0) then
      call make_error(error, 'none of the ' // to_text(size(snapshots%reasons)) // ' training points has a full-order solution', &
        problem%deck%path, exit_code=exit_not_converged)
    end if
  end subroutine take_solved

  !> Warns of each training point without a full-order solution, where states remember once for each history, and of contacts that
  !> are open at all others (open_contact_warnings). Without any solution there are no warnings, because training then ends with an
  !> error. Local.
  subroutine warn_of_snapshots(problem, snapshots)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(string_t), allocatable :: warnings(:)
    integer :: i, n_times

    n_times = 1
    if (problem%remembers()) n_times = max(1, problem%deck%history%states%n_times())
    associate (is_solved => snapshots%reasons == reason_converged)
      if (.not. any(is_solved)) return
      do i = 1, size(is_solved)
        if (is_solved(i)) cycle
        if (n_times == 1) then
          call log_warning('training without ' // format_point(problem%deck%state_parameters, snapshots%parameters(:, i)) // &
            ', which the full-order model did not solve')
        else
          if (i > 1) then
            if (.not. (is_solved(i - 1) .or. modulo(i - 1, n_times) == 0)) cycle
          end if
          call log_warning(lost_history(problem, snapshots, i, n_times))
        end if
      end do
      warnings = open_contact_warnings(problem%deck, problem%rows, &
        snapshots%multipliers(:, pack([(i, i=1, size(is_solved))], is_solved)))
      call log_warnings(warnings)
    end associate
  end subroutine warn_of_snapshots

  !> Returns a sentence about a history that remembers and has no solutions from one of its states on.
  function lost_history(problem, snapshots, i_state, n_times) result(text)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    !> the first state without a solution, 1-based
    integer, intent(in) :: i_state
    integer, intent(in) :: n_times
    character(:), allocatable :: text

    associate (n => size(problem%deck%parameters), all => problem%deck%state_parameters, point => snapshots%parameters(:, i_state))
      text = 'training without ' // format_point(all(:n), point(:n)) // ' from ' // format_point(all(n + 1:n + 1), &
        point(n + 1:n + 1)) // ' on (' // to_text(n_times - modulo(i_state - 1, n_times)) // ' of ' // &
        counted(n_times, 'state') // '): ' // reason_text(snapshots%reasons(i_state))
    end associate
  end function lost_history
end module sig_training
