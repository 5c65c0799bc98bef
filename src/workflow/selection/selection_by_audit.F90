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
!>
!> selection.csv is written after each round, so that a killed run repeats one round at most.
module sig_selection_by_audit
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use sig_answer, only: answer_t
  use sig_deck_config, only: greedy_config_t
  use sig_errors, only: error_t, exit_internal, make_error
  use sig_flow_stresses, only: answered_stresses, solved_stresses
  use sig_full_order, only: full_order_t
  use sig_greedy_record, only: keep_selection
  use sig_greedy_rules, only: begin_far_apart, cut_at_end, measured_ratio, pick_worst
  use sig_history_errors, only: least_share
  use sig_inelastic_model, only: inelastic_model_t
  use sig_kinds, only: rk
  use sig_log, only: log_info
  use sig_model_building, only: build_condensed
  use sig_online_model, only: online_model_t
  use sig_parameter_space, only: find_states
  use sig_petsc_support, only: rank_and_size, sum_over_ranks
  use sig_problem, only: problem_t
  use sig_query, only: query_t
  use sig_reasons, only: reason_converged
  use sig_sampling, only: sampler_t, sampling_result_t
  use sig_selection, only: selection_t
  use sig_snapshot_merge, only: put_in_order, read_spread, read_store, snapshot_store, store_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_stop_request, only: agree_to_stop
  use sig_text, only: counted, short_number, to_text
  use petsc
  implicit none(type, external)
  private
  public :: select_by_audit

  !> Data that one round hands to the next.
  type :: rounds_t
    type(full_order_t), pointer :: full_order => null()
    type(problem_t), pointer :: problem => null()
    type(sampler_t) :: sampler
    type(store_t) :: store
    !> model of the histories chosen so far
    type(online_model_t) :: online
    type(query_t) :: query
    !> number of histories of the last round, and what the model answered at their times: [force] contact forces, shape
    !> (n_multipliers, n_times * n_new), and [force/length**2] stresses, shape (n_points, .); none in the first round
    integer :: n_new = 0
    real(rk), allocatable :: multipliers(:, :)
    real(rk), allocatable :: stresses(:, :)
    !> [force] least size to which differences of forces are related
    real(rk) :: least_force = 0
  end type rounds_t

contains

  !> Selects and solves the training histories: writes selection.csv and snapshots.h5, with the selected histories first, into the
  !> folder. Collective on all ranks; the selection is the same on each. A signal ends it early (outcome%is_stopped).
  !>
  !> Errors: those of solve_new_histories, train_draft and put_in_order; selection.csv cannot be written.
  subroutine select_by_audit(full_order, folder, candidates, outcome, selection, error, ierr)
    !> loaded
    type(full_order_t), target, intent(inout) :: full_order
    character(*), intent(in) :: folder
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    type(sampling_result_t), intent(out) :: outcome
    !> in: what an earlier run has chosen, from begin_selection (cut_at_end shortens it); out: all chosen histories
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(rounds_t), target :: rounds
    integer, allocatable :: chosen(:)

    ierr = 0
    rounds%full_order => full_order
    rounds%problem => full_order%problem
    rounds%store = store_t(folder, snapshot_store)
    associate (greedy => rounds%problem%deck%greedy)
      PetscCall(rounds%sampler%create(full_order, max(greedy%n_initial, greedy%batch), ierr))
    end associate
    call cut_at_end(rounds%problem%deck, selection)
    if (size(selection%indicators) == 0) call begin_far_apart(rounds%problem%deck, candidates, selection)
    do while (selection%stopped_by == '')
      PetscCall(solve_new_histories(rounds, folder, outcome, selection, error, ierr))
      if (allocated(error) .or. outcome%is_stopped) return
      PetscCall(train_draft(rounds, selection, error, ierr))
      if (allocated(error)) return
      PetscCall(choose_new_histories(rounds, candidates, selection, chosen, ierr))
      call keep_answers(rounds, candidates(:, chosen))
    end do
    associate (is_writer => rounds%sampler%team%groups%world_rank == 0)
      if (is_writer) call put_in_order(rounds%problem, rounds%store, states_at(rounds, selection%points), error)
      PetscCall(keep_selection(rounds%problem, folder, selection, is_writer, error, ierr))
    end associate
  end subroutine select_by_audit

  !> Returns the states of histories, shape (n_numbers, n_times * n_histories). Requires: those of all candidates can be found.
  function states_at(rounds, points) result(states)
    type(rounds_t), intent(in) :: rounds
    !> shape (n_parameters, n_histories)
    real(rk), intent(in) :: points(:, :)
    real(rk), allocatable :: states(:, :)
    type(error_t), allocatable :: error

    call find_states(rounds%problem%deck, points, states, error)
  end function states_at

  !> Solves the histories of the selection that have no converged solution yet. Then compares them with the model's answers
  !> (compare_answers) and writes selection.csv; it leaves both out if a signal came while it solved. After a signal
  !> outcome%is_stopped is true. Collective on all ranks. Errors: those of solve_missing and compare_answers; selection.csv cannot
  !> be written.
  subroutine solve_new_histories(rounds, folder, outcome, selection, error, ierr)
    type(rounds_t), target, intent(inout) :: rounds
    character(*), intent(in) :: folder
    !> n_points becomes the number of selected states so far; n_failed and is_stopped become those of this round; n_found stays that
    !> of the first round; rotation and deformation become the largest of all rounds; n_stiffnesses as solve_missing returns it
    type(sampling_result_t), intent(inout) :: outcome
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(sampling_result_t) :: round

    PetscCall(rounds%sampler%solve_missing(rounds%store, states_at(rounds, selection%points), round, error, ierr))
    if (allocated(error)) return
    if (outcome%n_points == 0) outcome%n_found = round%n_found
    outcome%n_points = round%n_points
    outcome%n_failed = round%n_failed
    outcome%n_stiffnesses = round%n_stiffnesses
    outcome%is_stopped = round%is_stopped
    outcome%rotation = max(outcome%rotation, round%rotation)
    outcome%deformation = max(outcome%deformation, round%deformation)
    if (outcome%is_stopped) return
    call compare_answers(rounds, selection, error)
    PetscCall(keep_selection(rounds%problem, folder, selection, rounds%sampler%team%groups%world_rank == 0, error, ierr))
    PetscCall(agree_to_stop(PETSC_COMM_WORLD, outcome%is_stopped, ierr))
  end subroutine solve_new_histories

  !> Sets selection%errors at the histories that the last round chose and that are solved now: the largest errors of the answers
  !> that the model had there (keep_answers), over the history. The errors stay NaN where the model had no answer, and where the
  !> full order has none. Does nothing in the first round of a run. Local; each rank does the same.
  !> Errors: the store cannot be read.
  subroutine compare_answers(rounds, selection, error)
    type(rounds_t), target, intent(in) :: rounds
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    type(snapshot_set_t) :: solved
    real(rk), allocatable :: states(:, :), stresses(:, :)
    logical, allocatable :: is_missing(:)
    integer :: first, i, last, n_before, n_times

    if (rounds%n_new == 0) return
    n_before = size(selection%indicators) - rounds%n_new
    states = states_at(rounds, selection%points(:, n_before + 1:))
    n_times = size(states, 2) / rounds%n_new
    allocate (is_missing(size(states, 2)))
    call read_store(rounds%problem, rounds%store, states, solved, is_missing, error)
    if (allocated(error)) return
    do i = 1, rounds%n_new
      first = n_times * (i - 1) + 1
      last = n_times * i
      if (selection%indicators(n_before + i) > huge(1.0_rk) .or. any(solved%reasons(first:last) /= reason_converged)) cycle
      call solved_stresses(rounds%problem, part_of(rounds), states(:, first:last), solved%displacement(:, first:last), stresses)
      associate (found => rounds%multipliers(:, first:last), exact => solved%multipliers(:, first:last))
        selection%errors(1, n_before + i) = maxval(abs(rounds%stresses(:, first:last) - stresses)) / maxval(stresses)
        selection%errors(2, n_before + i) = maxval(norm2(found - exact, dim=1)) / &
          max(maxval(norm2(exact, dim=1)), rounds%least_force)
      end associate
    end do
  end subroutine compare_answers

  !> Returns the only part of the model.
  function part_of(rounds) result(part)
    type(rounds_t), target, intent(in) :: rounds
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
    type(rounds_t), target, intent(inout) :: rounds
    type(selection_t), intent(in) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t), target :: snapshots
    type(inelastic_model_t), pointer :: part
    character(:), allocatable :: message
    real(rk), allocatable :: states(:, :)
    logical, allocatable :: is_missing(:)

    states = states_at(rounds, selection%points)
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
    part%check = part%all
    call rounds%online%prepare(message)
    if (.not. allocated(message)) call rounds%query%create(rounds%online, message)
    if (allocated(message)) call make_error(error, 'the model of the histories chosen so far cannot answer: ' // message, &
      rounds%problem%deck%path, exit_code=exit_internal)
  end subroutine train_draft

  !> Asks the model at all candidates, and appends those with the largest estimates to the selection (pick_worst); if none, sets
  !> selection%stopped_by. Collective on all ranks.
  subroutine choose_new_histories(rounds, candidates, selection, chosen, ierr)
    type(rounds_t), intent(inout) :: rounds
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    type(selection_t), intent(inout) :: selection
    !> numbers of the candidates of this round, 1-based
    integer, allocatable, intent(out) :: chosen(:)
    PetscErrorCode, intent(out) :: ierr
    type(greedy_config_t) :: limits
    real(rk) :: estimates(size(candidates, 2)), ratio

    PetscCall(audit_candidates(rounds, candidates, estimates, ierr))
    limits = rounds%problem%deck%greedy
    ratio = measured_ratio(selection)
    if (ratio > 0) limits%tolerance = rounds%problem%deck%reduction%inelastic_tolerance / ratio
    call tell_estimates(rounds, estimates, ratio, size(selection%indicators))
    call pick_worst(rounds%problem%deck, limits, candidates, estimates, selection, chosen)
  end subroutine choose_new_histories

  !> Says in the log how large the estimates are, and what errors they stand for.
  subroutine tell_estimates(rounds, estimates, ratio, n_histories)
    type(rounds_t), intent(in) :: rounds
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
    type(rounds_t), intent(inout) :: rounds
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
      states = states_at(rounds, candidates(:, i:i))
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
    type(rounds_t), target, intent(inout) :: rounds
    !> shape (n_parameters, n_new)
    real(rk), intent(in) :: points(:, :)
    type(answer_t) :: answer
    type(inelastic_model_t), pointer :: part
    real(rk), allocatable :: states(:, :)
    integer :: i

    rounds%n_new = size(points, 2)
    if (rounds%n_new == 0) return
    part => part_of(rounds)
    states = states_at(rounds, points)
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
