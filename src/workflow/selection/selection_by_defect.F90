! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Greedy selection among candidates that are not solved: the next points are those with the largest defects of the reduced model of
!> the points chosen so far. Only chosen points are solved.
!>
!> A round trains a model, measures its defects at all candidates, and solves greedy.batch new points at full order. selection.csv
!> is written after each round, so that a killed run repeats one round at most.
module sig_selection_by_defect
  use sig_errors, only: error_t, exit_internal, make_error
  use sig_full_order, only: full_order_t, team_t
  use sig_greedy_record, only: keep_selection
  use sig_greedy_rules, only: begin_far_apart, cut_at_end, pick_worst
  use sig_kinds, only: rk
  use sig_log, only: log_info
  use sig_model_defect, only: model_defect_t
  use sig_rooms, only: rooms_t
  use sig_online_model, only: online_model_t
  use sig_problem, only: problem_t
  use sig_answer, only: answer_t
  use sig_query, only: query_t
  use sig_reconstruction, only: reconstruct_displacement, reconstruct_multipliers
  use sig_sampling, only: sampler_t, sampling_result_t
  use sig_selection, only: selection_t
  use sig_snapshot_merge, only: put_in_order, read_spread, read_store, snapshot_store, store_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_hhr_start_sets, only: fill_start_sets
  use sig_stop_request, only: agree_to_stop
  use sig_text, only: counted
  use sig_training, only: train
  use petsc
  implicit none(type, external)
  private
  public :: select_by_defect

  !> Data that one round hands to the next.
  type :: rounds_t
    type(problem_t), pointer :: problem => null()
    type(sampler_t) :: sampler
    type(store_t) :: store
    type(model_defect_t) :: defect
    !> number of points of the last round, and [length], [force] the answers that the model had there, shape (n_dofs, n_new) and
    !> (n_multipliers, n_new); none in the first round
    integer :: n_new = 0
    real(rk), allocatable :: displacement(:, :)
    real(rk), allocatable :: multipliers(:, :)
  end type rounds_t

contains

  !> Selects and solves the training points: writes selection.csv and snapshots.h5, with the selected points first, into the folder.
  !> Collective on all ranks; the selection is the same on each. A signal ends it early (outcome%is_stopped).
  !>
  !> Errors: those of solve_new_points, choose_new_points and put_in_order; selection.csv cannot be written.
  subroutine select_by_defect(full_order, folder, candidates, outcome, selection, error, ierr)
    !> loaded
    type(full_order_t), target, intent(inout) :: full_order
    character(*), intent(in) :: folder
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    type(sampling_result_t), intent(out) :: outcome
    !> in: what an earlier run has chosen, from begin_selection (cut_at_end shortens it); out: all chosen points
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(rounds_t) :: rounds
    type(team_t), pointer :: whole_team

    ierr = 0
    rounds%problem => full_order%problem
    rounds%store = store_t(folder, snapshot_store)
    associate (greedy => rounds%problem%deck%greedy)
      PetscCall(rounds%sampler%create(full_order, max(greedy%n_initial, greedy%batch), ierr))
    end associate
    PetscCall(full_order%whole_team(whole_team, ierr))
    PetscCall(rounds%defect%create(rounds%problem, whole_team%solver, ierr))
    if (.not. rounds%defect%is_bound) call log_info('the defect is the size of the residuals, which is no bound of the ' // &
      'error, because ' // why_no_bound(rounds%problem))
    call cut_at_end(rounds%problem%deck, selection)
    if (size(selection%indicators) == 0) call begin_far_apart(rounds%problem%deck, candidates, selection)
    do while (selection%stopped_by == '')
      PetscCall(solve_new_points(rounds, folder, outcome, selection, error, ierr))
      if (allocated(error) .or. outcome%is_stopped) return
      PetscCall(choose_new_points(rounds, candidates, selection, error, ierr))
      if (allocated(error)) return
    end do
    if (rounds%sampler%team%groups%world_rank == 0) call put_in_order(rounds%problem, rounds%store, selection%points, error)
    PetscCall(keep_selection(rounds%problem, folder, selection, rounds%sampler%team%groups%world_rank == 0, error, ierr))
  end subroutine select_by_defect

  !> Returns why the defect is no bound, as the words behind `because`. If the stiffness is fixed, it names all possible reasons
  !> without telling which one holds.
  pure function why_no_bound(problem) result(reason)
    type(problem_t), intent(in) :: problem
    character(:), allocatable :: reason

    reason = 'solver.linear is gamg, or a body is held by contact only, or the stiffness or the matrix of all contacts is too ' // &
      'large or cannot be factored'
    if (.not. problem%has_fixed_stiffness) reason = 'the stiffness depends on the parameters'
  end function why_no_bound

  !> Solves the points of the selection that have no converged solution yet. Then compares them with the model's answers
  !> (compare_answers) and writes selection.csv; it leaves both out if a signal came while it solved. After a signal
  !> outcome%is_stopped is true. Collective on all ranks. Errors: those of solve_missing and compare_answers; selection.csv cannot
  !> be written.
  subroutine solve_new_points(rounds, folder, outcome, selection, error, ierr)
    type(rounds_t), intent(inout) :: rounds
    character(*), intent(in) :: folder
    !> n_points becomes the number of selected points so far; n_failed and is_stopped become those of this round; n_found stays that
    !> of the first round; rotation and deformation become the largest of all rounds; n_stiffnesses as solve_missing returns it
    type(sampling_result_t), intent(inout) :: outcome
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(sampling_result_t) :: round

    PetscCall(rounds%sampler%solve_missing(rounds%store, selection%points, round, error, ierr))
    if (allocated(error)) return
    if (outcome%n_points == 0) outcome%n_found = round%n_found
    outcome%n_points = round%n_points
    outcome%n_failed = round%n_failed
    outcome%n_stiffnesses = round%n_stiffnesses
    outcome%is_stopped = round%is_stopped
    outcome%rotation = max(outcome%rotation, round%rotation)
    outcome%deformation = max(outcome%deformation, round%deformation)
    if (outcome%is_stopped) return
    PetscCall(compare_answers(rounds, selection, error, ierr))
    PetscCall(keep_selection(rounds%problem, folder, selection, rounds%sampler%team%groups%world_rank == 0, error, ierr))
    PetscCall(agree_to_stop(PETSC_COMM_WORLD, outcome%is_stopped, ierr))
  end subroutine solve_new_points

  !> Sets selection%errors at the points that the last round chose and that are solved now: true_errors of the answers that the
  !> model had there (keep_answers). The errors stay NaN where the defect was infinite, as without an answer, and where the
  !> full-order solution did not converge. Does nothing in the first round of a run. Collective on all ranks.
  !> Errors: the store cannot be read.
  subroutine compare_answers(rounds, selection, error, ierr)
    type(rounds_t), intent(inout) :: rounds
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t) :: solved
    logical :: is_missing(rounds%n_new)
    integer :: i, n_before

    ierr = 0
    if (rounds%n_new == 0) return
    n_before = size(selection%indicators) - rounds%n_new
    call read_store(rounds%problem, rounds%store, selection%points(:, n_before + 1:), solved, is_missing, error)
    if (allocated(error)) return
    do i = 1, rounds%n_new
      ! where the model had no answer there is nothing to compare
      if (selection%indicators(n_before + i) > huge(1.0_rk) .or. solved%reasons(i) < 0) cycle
      associate (errors => selection%errors(:, n_before + i), u => rounds%displacement(:, i), &
        point => selection%points(:, n_before + i), lambda => rounds%multipliers(:, i))
        PetscCall(rounds%defect%true_errors(point, u, solved%displacement(:, i), lambda, solved%multipliers(:, i), errors, ierr))
      end associate
    end do
  end subroutine compare_answers

  !> Trains a model of the solved points of the selection and measures its defects at the candidates. Appends the candidates with
  !> the largest defects to the selection (pick_worst) and keeps the model's answers at them in `rounds`; if there are none, sets
  !> selection%stopped_by. Collective on all ranks. Errors: those of train_draft; the model cannot answer (an internal error).
  subroutine choose_new_points(rounds, candidates, selection, error, ierr)
    type(rounds_t), intent(inout) :: rounds
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(online_model_t) :: online
    type(query_t) :: query
    character(:), allocatable :: message
    real(rk) :: defects(size(candidates, 2))
    integer, allocatable :: chosen(:)

    PetscCall(train_draft(rounds, selection, online, error, ierr))
    if (allocated(error)) return
    call online%prepare(message)
    if (.not. allocated(message)) call query%create(online, message)
    if (allocated(message)) then
      call make_error(error, 'the model of the points chosen so far cannot answer: ' // message, rounds%problem%deck%path, &
        exit_code=exit_internal)
      return
    end if
    PetscCall(rounds%defect%measure(online, query, candidates, defects, ierr))
    call pick_worst(rounds%problem%deck, rounds%problem%deck%greedy, candidates, defects, selection, chosen)
    call keep_answers(rounds, online, query, candidates(:, chosen))
    call query%destroy()
  end subroutine choose_new_points

  !> Trains a hyper-reduced model of one cluster, without fallback, from the points of the selection that have converged.
  !> online%model gets it, with the active sets from which queries start (fill_start_sets); the caller must call online%prepare.
  !> Collective on all ranks. Errors: the store cannot be read; those of train.
  subroutine train_draft(rounds, selection, online, error, ierr)
    type(rounds_t), intent(in) :: rounds
    type(selection_t), intent(in) :: selection
    type(online_model_t), intent(inout) :: online
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t) :: snapshots
    logical :: is_missing(size(selection%indicators))

    ierr = 0
    PetscCall(read_spread(rounds%problem, rounds%store, selection%points, snapshots, is_missing, error, ierr))
    if (allocated(error)) return
    PetscCall(train(rounds%problem, snapshots, online%model, error, ierr, is_draft=.true.))
    if (allocated(error)) then
      error%message = 'the model of the first ' // counted(size(is_missing), 'point') // ': ' // error%message
      return
    end if
    call fill_start_sets(online%model)
  end subroutine train_draft

  !> Keeps in `rounds` the displacements and contact forces that the model answers at the points that will be solved next, and the
  !> number of these points. Where there is no answer, the displacement means nothing and the forces are 0. Local.
  subroutine keep_answers(rounds, online, query, points)
    type(rounds_t), intent(inout) :: rounds
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    !> shape (n_parameters, n_new)
    real(rk), intent(in) :: points(:, :)
    type(answer_t) :: answer
    type(rooms_t) :: rooms
    real(rk), allocatable :: displacement(:)
    integer :: i

    rounds%n_new = size(points, 2)
    if (allocated(rounds%displacement)) deallocate (rounds%displacement, rounds%multipliers)
    allocate (rounds%displacement(online%model%n_dofs, rounds%n_new), rounds%multipliers(online%model%n_multipliers, rounds%n_new))
    do i = 1, rounds%n_new
      call query%evaluate(online, points(:, i), answer)
      call reconstruct_displacement(online%model, answer, displacement)
      call reconstruct_multipliers(online, answer, rooms, rounds%multipliers(:, i))
      rounds%displacement(:, i) = displacement
    end do
  end subroutine keep_answers
end module sig_selection_by_defect
