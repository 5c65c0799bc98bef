! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Greedy selection among histories of materials that flow: the next ones are those at which the model of the histories chosen so
!> far estimates its own error as largest. Only chosen histories are solved.
!>
!> A model corrects the contact forces lambda_r to lambda* (sig_inelastic_model). The estimate of a history is the largest
!> |lambda* - lambda_r| over the largest |lambda*| of all its times. It estimates the error of lambda_r, but the tolerance is for
!> what the model answers. So the answers at each new history are kept until it is solved; then their true errors, of lambda* and
!> of the stresses, over the estimate say what an estimate means. The largest of these ratios times the largest estimate is what is
!> compared with the tolerance. Before one is measured the selection goes on.
module sig_selection_by_audit
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use sig_answer, only: answer_t
  use sig_deck_config, only: greedy_config_t
  use sig_errors, only: error_t, exit_internal, make_error
  use sig_flow_stresses, only: answered_stresses, solved_stresses
  use sig_full_order, only: full_order_t
  use sig_greedy_rounds, only: greedy_rounds_t
  use sig_greedy_rules, only: measured_ratio, pick_worst
  use sig_history_errors, only: least_share
  use sig_inelastic_model, only: inelastic_model_t
  use sig_kinds, only: rk
  use sig_log, only: log_info
  use sig_model_building, only: build_condensed
  use sig_online_model, only: online_model_t
  use sig_petsc_support, only: rank_and_size, sum_over_ranks
  use sig_query, only: query_t
  use sig_reasons, only: reason_converged
  use sig_sampling, only: sampling_result_t
  use sig_selection, only: selection_t
  use sig_snapshot_merge, only: read_spread, read_store
  use sig_snapshot_store, only: snapshot_set_t
  use sig_text, only: counted, short_number, to_text
  use petsc
  implicit none(type, external)
  private
  public :: select_by_audit

  !> Greedy rounds whose points are histories.
  type, extends(greedy_rounds_t) :: audit_rounds_t
    type(full_order_t), pointer :: full_order => null()
    !> model of the histories chosen so far
    type(online_model_t) :: online
    type(query_t) :: query
    !> what the model answered at the times of the histories of the last round: [force] contact forces, shape
    !> (n_multipliers, n_times * n_new), and [force/length**2] stresses, shape (n_points, .); none in the first round
    real(rk), allocatable :: multipliers(:, :)
    real(rk), allocatable :: stresses(:, :)
    !> [force] least size to which differences of forces are related
    real(rk) :: least_force = 0
  contains
    procedure :: compare_answers
    procedure :: choose_new
  end type audit_rounds_t

contains

  !> Selects and solves the training histories (greedy_rounds_t%run). Collective on all ranks.
  subroutine select_by_audit(full_order, folder, candidates, outcome, selection, error, ierr)
    !> loaded
    type(full_order_t), target, intent(inout) :: full_order
    character(*), intent(in) :: folder
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    type(sampling_result_t), intent(out) :: outcome
    !> in: what an earlier run has chosen, from begin_selection; out: all chosen histories
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(audit_rounds_t), target :: rounds

    rounds%full_order => full_order
    PetscCall(rounds%begin(full_order, folder, ierr))
    PetscCall(rounds%run(candidates, outcome, selection, error, ierr))
  end subroutine select_by_audit

  !> Sets selection%errors at the histories that the last round chose and that are solved now: the largest errors of the answers
  !> that the model had there (keep_answers), over the history. The errors stay NaN where the model had no answer, and where the
  !> full order has none. Local; each rank does the same.
  subroutine compare_answers(self, selection, error, ierr)
    class(audit_rounds_t), target, intent(inout) :: self
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t) :: solved
    real(rk), allocatable :: states(:, :), stresses(:, :)
    logical, allocatable :: is_missing(:)
    integer :: first, i, last, n_before, n_times

    ierr = 0
    if (self%n_new == 0) return
    n_before = size(selection%indicators) - self%n_new
    states = self%states_at(selection%points(:, n_before + 1:))
    n_times = size(states, 2) / self%n_new
    allocate (is_missing(size(states, 2)))
    call read_store(self%problem, self%store, states, solved, is_missing, error)
    if (allocated(error)) return
    do i = 1, self%n_new
      first = n_times * (i - 1) + 1
      last = n_times * i
      if (selection%indicators(n_before + i) > huge(1.0_rk) .or. any(solved%reasons(first:last) /= reason_converged)) cycle
      call solved_stresses(self%problem, part_of(self), states(:, first:last), solved%displacement(:, first:last), stresses)
      associate (found => self%multipliers(:, first:last), exact => solved%multipliers(:, first:last))
        selection%errors(1, n_before + i) = maxval(abs(self%stresses(:, first:last) - stresses)) / maxval(stresses)
        selection%errors(2, n_before + i) = maxval(norm2(found - exact, dim=1)) / &
          max(maxval(norm2(exact, dim=1)), self%least_force)
      end associate
    end do
  end subroutine compare_answers

  !> Returns the only part of the model.
  function part_of(rounds) result(part)
    type(audit_rounds_t), target, intent(in) :: rounds
    type(inelastic_model_t), pointer :: part

    part => null()
    select type (reduced => rounds%online%model%parts(1)%reduced)
    type is (inelastic_model_t)
      part => reduced
    end select
  end function part_of

  !> Trains a model of the histories of the selection, those of their states that have converged, and prepares it. Collective on all
  !> ranks. Errors: the store cannot be read; those of build_condensed; the model cannot answer (an internal error).
  subroutine train_draft(rounds, selection, error, ierr)
    type(audit_rounds_t), target, intent(inout) :: rounds
    type(selection_t), intent(in) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t), target :: snapshots
    type(inelastic_model_t), pointer :: part
    character(:), allocatable :: message
    real(rk), allocatable :: states(:, :)
    logical, allocatable :: is_missing(:)

    states = rounds%states_at(selection%points)
    allocate (is_missing(size(states, 2)))
    PetscCall(read_spread(rounds%problem, rounds%store, states, snapshots, is_missing, error, ierr))
    if (allocated(error)) return
    message = ''
    call rounds%query%destroy()
    PetscCall(build_condensed(rounds%full_order, snapshots, 'inelastic', rounds%online%model, message, error, ierr))
    if (allocated(error)) then
      error%message = 'the model of the first ' // to_text(size(selection%indicators)) // ' histories: ' // error%message
      return
    end if
    deallocate (message)
    ! candidates may flow where the histories that the check points were chosen for do not
    part => part_of(rounds)
    part%checks_all = .true.
    call rounds%online%prepare(message)
    if (.not. allocated(message)) call rounds%query%create(rounds%online, message)
    if (allocated(message)) call make_error(error, 'the model of the histories chosen so far cannot answer: ' // message, &
      rounds%problem%deck%path, exit_code=exit_internal)
  end subroutine train_draft

  !> Trains a model, asks it at all candidates, and appends those with the largest estimates to the selection (pick_worst).
  subroutine choose_new(self, candidates, selection, error, ierr)
    class(audit_rounds_t), target, intent(inout) :: self
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(greedy_config_t) :: limits
    real(rk) :: estimates(size(candidates, 2)), ratio
    integer, allocatable :: chosen(:)

    PetscCall(train_draft(self, selection, error, ierr))
    if (allocated(error)) return
    PetscCall(audit_candidates(self, candidates, estimates, ierr))
    limits = self%problem%deck%greedy
    ratio = measured_ratio(selection)
    if (ratio > 0) limits%tolerance = self%problem%deck%reduction%inelastic_tolerance / ratio
    call tell_estimates(self, estimates, ratio, size(selection%indicators))
    call pick_worst(self%problem%deck, limits, candidates, estimates, selection, chosen)
    call keep_answers(self, candidates(:, chosen))
  end subroutine choose_new

  !> Says in the log how large the estimates are, and what errors they stand for.
  subroutine tell_estimates(rounds, estimates, ratio, n_histories)
    type(audit_rounds_t), intent(in) :: rounds
    real(rk), intent(in) :: estimates(:)
    !> of measured_ratio
    real(rk), intent(in) :: ratio
    integer, intent(in) :: n_histories
    character(:), allocatable :: text
    integer :: n_lost

    n_lost = count(estimates > huge(estimates))
    text = counted(n_histories, 'training history') // ': largest estimate of ' // &
      counted(size(estimates), 'candidate') // ' ' // short_number(maxval(estimates, mask=estimates <= huge(estimates)))
    if (n_lost > 0) text = text // ', no answer at ' // to_text(n_lost) // ' of them'
    if (ratio > 0) then
      text = text // '; errors behind the correction were up to ' // short_number(ratio) // ' of the estimates, so about ' // &
        short_number(ratio * maxval(estimates, mask=estimates <= huge(estimates))) // ' (reduction.inelastic_tolerance is ' // &
        short_number(rounds%problem%deck%reduction%inelastic_tolerance) // ')'
    else
      text = text // '; no error behind the correction is measured yet'
    end if
    call log_info(text)
  end subroutine tell_estimates

  !> Estimates the errors of the model at the candidates, which the ranks share; infinite where some time has no answer. Collective
  !> on all ranks; the same on each.
  subroutine audit_candidates(rounds, candidates, estimates, ierr)
    type(audit_rounds_t), intent(inout) :: rounds
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    !> [-] shape (n_candidates)
    real(rk), intent(out) :: estimates(:)
    PetscErrorCode, intent(out) :: ierr
    type(answer_t) :: answer
    real(rk), allocatable :: states(:, :)
    real(rk) :: differences(size(estimates)), sizes(size(estimates))
    integer :: i, n_ranks, rank, t

    PetscCall(rank_and_size(PETSC_COMM_WORLD, rank, n_ranks, ierr))
    differences = 0
    sizes = 0
    do i = rank + 1, size(estimates), n_ranks
      states = rounds%states_at(candidates(:, i:i))
      do t = 1, size(states, 2)
        call rounds%query%continue(rounds%online, states(:, t), answer)
        if (answer%reason <= 0) then
          differences(i) = ieee_value(1.0_rk, ieee_positive_inf)
          exit
        end if
        differences(i) = max(differences(i), norm2(answer%multipliers - answer%raw_multipliers))
        sizes(i) = max(sizes(i), norm2(answer%multipliers))
      end do
    end do
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, differences, ierr))
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, sizes, ierr))
    rounds%least_force = least_share * maxval(sizes)
    ! where nothing touches there is no estimate either
    estimates = differences / max(sizes, rounds%least_force, tiny(1.0_rk))
  end subroutine audit_candidates

  !> Keeps in `rounds` what the model answers at the histories that will be solved next, and their number. Where there is no answer,
  !> it means nothing. Local; each rank does the same.
  subroutine keep_answers(rounds, points)
    type(audit_rounds_t), target, intent(inout) :: rounds
    !> shape (n_parameters, n_new)
    real(rk), intent(in) :: points(:, :)
    type(answer_t) :: answer
    type(inelastic_model_t), pointer :: part
    real(rk), allocatable :: states(:, :)
    integer :: i

    rounds%n_new = size(points, 2)
    if (rounds%n_new == 0) return
    part => part_of(rounds)
    states = rounds%states_at(points)
    if (allocated(rounds%multipliers)) deallocate (rounds%multipliers, rounds%stresses)
    allocate (rounds%multipliers(rounds%online%model%n_multipliers, size(states, 2)), &
      rounds%stresses(part%all%n_points(), size(states, 2)), source=0.0_rk)
    do i = 1, size(states, 2)
      call rounds%query%continue(rounds%online, states(:, i), answer)
      if (answer%reason <= 0) cycle
      rounds%multipliers(:, i) = answer%multipliers
      rounds%stresses(:, i) = answered_stresses(part, answer, states(:, i))
    end do
  end subroutine keep_answers
end module sig_selection_by_audit
