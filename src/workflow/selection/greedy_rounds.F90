! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Greedy selection among candidates that are not solved, in rounds: each solves the points chosen last, compares them with what the
!> model answered there, trains a model of all points chosen so far, and chooses the next points by it. Only chosen points are
!> solved. How a model judges candidates is left to the types that extend greedy_rounds_t.
!>
!> selection.csv is written after each round, so that a killed run repeats one round at most.
module sig_greedy_rounds
  use sig_errors, only: error_t
  use sig_full_order, only: full_order_t
  use sig_greedy_record, only: keep_selection
  use sig_greedy_rules, only: begin_far_apart, cut_at_end
  use sig_kinds, only: rk
  use sig_parameter_space, only: find_states
  use sig_problem, only: problem_t
  use sig_sampling, only: sampler_t, sampling_result_t
  use sig_selection, only: selection_t
  use sig_snapshot_merge, only: put_in_order, snapshot_store, store_t
  use sig_stop_request, only: agree_to_stop
  use petsc
  implicit none(type, external)
  private
  public :: greedy_rounds_t

  !> Data that one round hands to the next. Call begin, then run.
  type, abstract :: greedy_rounds_t
    type(problem_t), pointer :: problem => null()
    type(sampler_t) :: sampler
    type(store_t) :: store
    !> results folder
    character(:), allocatable :: folder
    !> number of points that the last round chose; none in the first round
    integer :: n_new = 0
  contains
    procedure :: begin
    procedure :: run
    procedure :: states_at
    procedure(compare_i), deferred :: compare_answers
    procedure(choose_i), deferred :: choose_new
  end type greedy_rounds_t

  abstract interface
    !> Sets selection%errors at the points that the last round chose and that are solved now, by the answers that the model had
    !> there; they stay NaN where there is nothing to compare. Does nothing in the first round of a run. Collective on all ranks.
    !> Errors: the store cannot be read.
    subroutine compare_i(self, selection, error, ierr)
      import :: error_t, greedy_rounds_t, selection_t
      class(greedy_rounds_t), target, intent(inout) :: self
      type(selection_t), intent(inout) :: selection
      type(error_t), allocatable, intent(out) :: error
      PetscErrorCode, intent(out) :: ierr
    end subroutine compare_i

    !> Trains a model of the solved points of the selection, judges the candidates by it, and appends the worst ones to the
    !> selection (pick_worst); if there are none, sets selection%stopped_by. Keeps what compare_answers needs of the model.
    !> Collective on all ranks. Errors: the model cannot be trained, or cannot answer (an internal error).
    subroutine choose_i(self, candidates, selection, error, ierr)
      import :: error_t, greedy_rounds_t, rk, selection_t
      class(greedy_rounds_t), target, intent(inout) :: self
      !> shape (n_parameters, n_candidates)
      real(rk), intent(in) :: candidates(:, :)
      type(selection_t), intent(inout) :: selection
      type(error_t), allocatable, intent(out) :: error
      PetscErrorCode, intent(out) :: ierr
    end subroutine choose_i
  end interface

contains

  !> Collective on all ranks.
  subroutine begin(self, full_order, folder, ierr)
    class(greedy_rounds_t), intent(inout) :: self
    !> loaded
    type(full_order_t), target, intent(inout) :: full_order
    !> results folder, which this run has locked
    character(*), intent(in) :: folder
    PetscErrorCode, intent(out) :: ierr

    self%problem => full_order%problem
    self%folder = folder
    self%store = store_t(folder, snapshot_store)
    associate (greedy => self%problem%deck%greedy)
      PetscCall(self%sampler%create(full_order, max(greedy%n_initial, greedy%batch), ierr))
    end associate
  end subroutine begin

  !> Selects and solves the training points: writes selection.csv and snapshots.h5, with the selected points first, into the folder.
  !> Collective on all ranks; the selection is the same on each. A signal ends it early (outcome%is_stopped).
  !>
  !> Errors: those of solve_new, choose_new and put_in_order; selection.csv cannot be written.
  subroutine run(self, candidates, outcome, selection, error, ierr)
    class(greedy_rounds_t), target, intent(inout) :: self
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    type(sampling_result_t), intent(out) :: outcome
    !> in: what an earlier run has chosen, from begin_selection (cut_at_end shortens it); out: all chosen points
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    logical :: is_writer

    ierr = 0
    is_writer = self%sampler%team%groups%world_rank == 0
    call cut_at_end(self%problem%deck, selection)
    if (size(selection%indicators) == 0) call begin_far_apart(self%problem%deck, candidates, selection)
    do while (selection%stopped_by == '')
      PetscCall(solve_new(self, outcome, selection, is_writer, error, ierr))
      if (allocated(error) .or. outcome%is_stopped) return
      PetscCall(self%choose_new(candidates, selection, error, ierr))
      if (allocated(error)) return
    end do
    if (is_writer) call put_in_order(self%problem, self%store, self%states_at(selection%points), error)
    PetscCall(keep_selection(self%problem, self%folder, selection, is_writer, error, ierr))
  end subroutine run

  !> Returns the states of points: those of all times of a history, otherwise the points. Shape (n_numbers, n_states). Requires:
  !> those of all candidates can be found.
  function states_at(self, points) result(states)
    class(greedy_rounds_t), intent(in) :: self
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    real(rk), allocatable :: states(:, :)
    type(error_t), allocatable :: error

    call find_states(self%problem%deck, points, states, error)
  end function states_at

  !> Solves the points of the selection that have no converged solution yet. Then compares them with the model's answers
  !> (compare_answers) and writes selection.csv; it leaves both out if a signal came while it solved. After a signal
  !> outcome%is_stopped is true. Collective on all ranks. Errors: those of solve_missing and compare_answers; selection.csv cannot
  !> be written.
  subroutine solve_new(self, outcome, selection, is_writer, error, ierr)
    class(greedy_rounds_t), target, intent(inout) :: self
    !> n_points becomes the number of selected states so far; n_failed and is_stopped become those of this round; n_found stays that
    !> of the first round; rotation and deformation become the largest of all rounds; n_stiffnesses as solve_missing returns it
    type(sampling_result_t), intent(inout) :: outcome
    type(selection_t), intent(inout) :: selection
    !> this rank writes selection.csv
    logical, intent(in) :: is_writer
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(sampling_result_t) :: round

    PetscCall(self%sampler%solve_missing(self%store, self%states_at(selection%points), round, error, ierr))
    if (allocated(error)) return
    if (outcome%n_points == 0) outcome%n_found = round%n_found
    outcome%n_points = round%n_points
    outcome%n_failed = round%n_failed
    outcome%n_stiffnesses = round%n_stiffnesses
    outcome%is_stopped = round%is_stopped
    outcome%rotation = max(outcome%rotation, round%rotation)
    outcome%deformation = max(outcome%deformation, round%deformation)
    if (outcome%is_stopped) return
    PetscCall(self%compare_answers(selection, error, ierr))
    PetscCall(keep_selection(self%problem, self%folder, selection, is_writer, error, ierr))
    PetscCall(agree_to_stop(PETSC_COMM_WORLD, outcome%is_stopped, ierr))
  end subroutine solve_new
end module sig_greedy_rounds
