! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Greedy selection of training points among the deck's candidates, in rounds. After a killed run the same command goes on.
module sig_greedy_selection
  use sig_condensed_plan, only: choose_model_kind
  use sig_errors, only: error_t, make_error
  use sig_full_order, only: full_order_t
  use sig_greedy_record, only: begin_selection, is_complete
  use sig_kinds, only: rk
  use sig_log, only: log_info
  use sig_parameter_space, only: build_points
  use sig_problem, only: problem_t
  use sig_sampling, only: sampler_t, sampling_result_t
  use sig_selection, only: selection_t
  use sig_selection_by_audit, only: select_by_audit
  use sig_selection_by_defect, only: select_by_defect
  use sig_selection_by_projection, only: select_by_projection
  use sig_text, only: are, counted
  use petsc
  implicit none(type, external)
  private
  public :: select_points

contains

  !> Selects the training points and solves them: writes selection.csv and snapshots.h5 into the folder, and with indicator:
  !> projection also candidates.h5. If an earlier run has finished this, it only reads the selection. A signal ends it early
  !> (outcome%is_stopped). Collective on all ranks; errors are known to all.
  !>
  !> Errors: there are fewer candidates than greedy.initial; those of build_points, begin_selection, is_complete and of the
  !> selection itself.
  subroutine select_points(full_order, folder, outcome, selection, error, ierr)
    !> loaded
    type(full_order_t), target, intent(inout) :: full_order
    !> results folder, which this run has locked
    character(*), intent(in) :: folder
    type(sampling_result_t), intent(out) :: outcome
    !> complete on the first rank; with indicator: projection other ranks get no points if this run selects
    type(selection_t), intent(out) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: candidates(:, :)

    ierr = 0
    associate (deck => full_order%problem%deck)
      call build_points(deck%training, deck%parameters, candidates, error)
      if (allocated(error)) return
      if (size(candidates, 2) < deck%greedy%n_initial) then
        call make_error(error, 'the greedy selection begins with ' // counted(deck%greedy%n_initial, 'point') // &
          ' (initial); there ' // are(size(candidates, 2)) // ' only ' // counted(size(candidates, 2), 'candidate'), &
          deck%path, deck%training%line, deck%training%column)
        return
      end if
    end associate
    PetscCall(select_missing(full_order, folder, candidates, outcome, selection, error, ierr))
  end subroutine select_points

  !> Does what select_points does, for the given candidates, shape (n_parameters, n_candidates). Requires: there are at least
  !> greedy.initial of them.
  subroutine select_missing(full_order, folder, candidates, outcome, selection, error, ierr)
    type(full_order_t), target, intent(inout) :: full_order
    character(*), intent(in) :: folder
    real(rk), intent(in) :: candidates(:, :)
    type(sampling_result_t), intent(inout) :: outcome
    type(selection_t), intent(out) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(sampler_t) :: sampler
    integer :: n_times
    logical :: is_done

    ierr = 0
    n_times = max(1, full_order%problem%deck%history%states%n_times())
    call begin_selection(full_order%problem, candidates, folder, selection, error)
    if (allocated(error)) return
    PetscCall(is_complete(full_order%problem, folder, selection, is_done, error, ierr))
    outcome%n_points = size(selection%indicators) * n_times
    outcome%n_found = outcome%n_points
    if (allocated(error) .or. is_done) return
    select case (full_order%problem%deck%greedy%indicator)
    case ('audit')
      PetscCall(select_by_audit(full_order, folder, candidates, outcome, selection, error, ierr))
    case ('defect')
      call note_other_kind(full_order%problem)
      PetscCall(select_by_defect(full_order, folder, candidates, outcome, selection, error, ierr))
    case default
      ! once the candidates are solved, to choose again takes little time
      call selection%shorten(0)
      PetscCall(sampler%create(full_order, size(candidates, 2), ierr))
      PetscCall(select_by_projection(sampler, folder, candidates, outcome, selection, error, ierr))
    end select
  end subroutine select_missing

  !> Notes in the log if the model of the deck will be of another kind than the one whose defects choose the points.
  subroutine note_other_kind(problem)
    type(problem_t), intent(in) :: problem
    character(:), allocatable :: kind, reason

    call choose_model_kind(problem, kind, reason)
    if (kind /= 'hhr') call log_info('note: indicator: defect judges a hyper-reduced model of the points so far, but the ' // &
      'model of this deck will be ' // kind // '; indicator: projection or plain points (sobol) usually take less time')
  end subroutine note_other_kind
end module sig_greedy_selection
