! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Greedy selection among candidates that are not solved: the next points are those with the largest defects of the reduced model of
!> the points chosen so far. Only chosen points are solved.
!>
!> A round trains a model, measures its defects at all candidates, and solves greedy.batch new points at full order.
module sig_selection_by_defect
  use sig_errors, only: error_t, exit_internal, make_error
  use sig_full_order, only: full_order_t, team_t
  use sig_greedy_rounds, only: greedy_rounds_t
  use sig_greedy_rules, only: pick_worst
  use sig_kinds, only: rk
  use sig_log, only: log_info
  use sig_model_defect, only: model_defect_t
  use sig_rooms, only: rooms_t
  use sig_online_model, only: online_model_t
  use sig_problem, only: problem_t
  use sig_answer, only: answer_t
  use sig_query, only: query_t
  use sig_reconstruction, only: reconstruct_displacement, reconstruct_multipliers
  use sig_sampling, only: sampling_result_t
  use sig_selection, only: selection_t
  use sig_snapshot_merge, only: read_spread, read_store
  use sig_snapshot_store, only: snapshot_set_t
  use sig_hhr_start_sets, only: fill_start_sets
  use sig_text, only: counted
  use sig_training, only: train
  use petsc
  implicit none(type, external)
  private
  public :: select_by_defect

  !> Greedy rounds whose model is judged by its defect.
  type, extends(greedy_rounds_t) :: defect_rounds_t
    type(model_defect_t) :: defect
    !> [length], [force] answers that the model had at the points of the last round, shape (n_dofs, n_new) and
    !> (n_multipliers, n_new); none in the first round
    real(rk), allocatable :: displacement(:, :)
    real(rk), allocatable :: multipliers(:, :)
  contains
    procedure :: compare_answers
    procedure :: choose_new
  end type defect_rounds_t

contains

  !> Selects and solves the training points (greedy_rounds_t%run). Collective on all ranks.
  subroutine select_by_defect(full_order, folder, candidates, outcome, selection, error, ierr)
    !> loaded
    type(full_order_t), target, intent(inout) :: full_order
    character(*), intent(in) :: folder
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    type(sampling_result_t), intent(out) :: outcome
    !> in: what an earlier run has chosen, from begin_selection; out: all chosen points
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(defect_rounds_t), target :: rounds
    type(team_t), pointer :: whole_team

    PetscCall(rounds%begin(full_order, folder, ierr))
    PetscCall(full_order%whole_team(whole_team, ierr))
    PetscCall(rounds%defect%create(rounds%problem, whole_team%solver, ierr))
    if (.not. rounds%defect%is_bound) call log_info('the defect is the size of the residuals, which is no bound of the ' // &
      'error, because ' // why_no_bound(rounds%problem))
    PetscCall(rounds%run(candidates, outcome, selection, error, ierr))
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

  !> Sets selection%errors at the points that the last round chose and that are solved now: true_errors of the answers that the
  !> model had there (keep_answers). The errors stay NaN where the defect was infinite, as without an answer, and where the
  !> full-order solution did not converge.
  subroutine compare_answers(self, selection, error, ierr)
    class(defect_rounds_t), target, intent(inout) :: self
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t) :: solved
    logical :: is_missing(self%n_new)
    integer :: i, n_before

    ierr = 0
    if (self%n_new == 0) return
    n_before = size(selection%indicators) - self%n_new
    call read_store(self%problem, self%store, selection%points(:, n_before + 1:), solved, is_missing, error)
    if (allocated(error)) return
    do i = 1, self%n_new
      ! where the model had no answer there is nothing to compare
      if (selection%indicators(n_before + i) > huge(1.0_rk) .or. solved%reasons(i) < 0) cycle
      associate (errors => selection%errors(:, n_before + i), u => self%displacement(:, i), &
        point => selection%points(:, n_before + i), lambda => self%multipliers(:, i))
        PetscCall(self%defect%true_errors(point, u, solved%displacement(:, i), lambda, solved%multipliers(:, i), errors, ierr))
      end associate
    end do
  end subroutine compare_answers

  !> Trains a model of the solved points of the selection and measures its defects at the candidates. Appends the candidates with
  !> the largest defects to the selection (pick_worst).
  subroutine choose_new(self, candidates, selection, error, ierr)
    class(defect_rounds_t), target, intent(inout) :: self
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

    PetscCall(train_draft(self, selection, online, error, ierr))
    if (allocated(error)) return
    call online%prepare(message)
    if (.not. allocated(message)) call query%create(online, message)
    if (allocated(message)) then
      call make_error(error, 'the model of the points chosen so far cannot answer: ' // message, self%problem%deck%path, &
        exit_code=exit_internal)
      return
    end if
    PetscCall(self%defect%measure(online, query, candidates, defects, ierr))
    call pick_worst(self%problem%deck, self%problem%deck%greedy, candidates, defects, selection, chosen)
    call keep_answers(self, online, query, candidates(:, chosen))
    call query%destroy()
  end subroutine choose_new

  !> Trains a hyper-reduced model of one cluster, without fallback, from the points of the selection that have converged.
  !> online%model gets it, with the active sets from which queries start (fill_start_sets); the caller must call online%prepare.
  !> Collective on all ranks. Errors: the store cannot be read; those of train.
  subroutine train_draft(rounds, selection, online, error, ierr)
    type(defect_rounds_t), intent(in) :: rounds
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
    type(defect_rounds_t), intent(inout) :: rounds
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
