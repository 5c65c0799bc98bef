! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Refines local models until they reach a target error: by more clusters, or by more snapshots and splits where errors are largest.
module sig_refinement
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use sig_candidate_pool, only: pool_errors_t, worst_candidates
  use sig_cluster_division, only: need_whole_grid
  use sig_cluster_split, only: restore_forest, split_cluster
  use sig_cluster_training, only: log_cluster_warnings
  use sig_clustering, only: check_snapshots
  use sig_deck_config, only: clusters_config_t
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_log, only: log_info, log_warning
  use sig_model, only: model_t
  use sig_model_attempt, only: attempt_t, share_candidates, start_attempt, train_attempt
  use sig_problem, only: problem_t
  use sig_refinement_rounds, only: make_round, n_failed, refinement_round_t, round_text, &
    statistic_of, three_digits, worst_cluster
  use sig_reduced, only: reduced_t
  use sig_snapshot_lengths, only: snapshot_lengths
  use sig_snapshot_store, only: snapshot_set_t
  use sig_stop_request, only: agree_to_stop
  use sig_text, only: counted, to_text
  use sig_ties, only: tie_tolerance
  use sig_training, only: take_solved
  use sig_training_set, only: take_snapshots, training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: refine, refinement_result_t

  !> [-] new snapshots of a cluster helped enough if its error is now at most this share of the one before
  real(rk), parameter :: clear_gain = 0.7_rk

  !> How a refinement went and ended.
  type :: refinement_result_t
    !> all rounds; the first one is number 0
    type(refinement_round_t), allocatable :: rounds(:)
    !> number of the round that gave the model, from 0 on, and [-] the error of this model, as clusters.target measures it
    integer :: best_round = 0
    real(rk) :: error = 0
    !> how it ended, a sentence without its full stop
    character(:), allocatable :: ending
    !> the error is at most clusters.target.error
    logical :: is_reached = .false.
    !> a signal ended the refinement: there is no model
    logical :: is_stopped = .false.
  end type refinement_result_t

  !> What may still be done with a cluster: add snapshots, split it.
  type :: prospect_t
    logical :: may_grow = .true.
    logical :: may_split = .true.
    !> its last snapshots did not help enough
    logical :: is_split_next = .false.
  end type prospect_t

contains

  !> Builds models in rounds until the error at the candidates is at most clusters.target.error, or nothing more can be tried. The
  !> model is that of the best round, with a warning if it misses the target. A signal ends it without a model (outcome%is_stopped).
  !> Collective on all ranks; the same on each. Errors: those of take_solved, check_start, share_candidates and of the training in
  !> the first round; the forest cannot be trained again. A later round that cannot be trained is undone.
  subroutine refine(problem, snapshots, candidates, fallback, model, outcome, error, ierr)
    type(problem_t), intent(in) :: problem
    !> full-order solutions at the training points; each rank has some of their dofs
    type(snapshot_set_t), intent(in), target :: snapshots
    !> the same at clusters.target.candidates
    type(snapshot_set_t), intent(in), target :: candidates
    !> answers where the clusters cannot; not allocated: there is none
    class(reduced_t), allocatable, intent(in) :: fallback
    !> does not change if there is an error or a signal
    type(model_t), intent(inout) :: model
    type(refinement_result_t), intent(out) :: outcome
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(attempt_t) :: best

    ierr = 0
    allocate (outcome%rounds(0))
    call take_solved(problem, snapshots, best%snapshots, error)
    if (allocated(error)) return
    PetscCall(check_start(problem, best%snapshots, error, ierr))
    if (allocated(error)) return
    PetscCall(share_candidates(problem, candidates, best, error, ierr))
    if (allocated(error)) return
    if (problem%deck%clusters%refine%is_used) then
      PetscCall(grow(problem, candidates, fallback, best, outcome, error, ierr))
    else
      PetscCall(raise_number(problem, candidates, fallback, best, outcome, error, ierr))
    end if
    if (allocated(error) .or. outcome%is_stopped) return
    if (allocated(best%model%choice%forest%shares)) then
      ! the files may be those of a later round, or of a division that was given up
      PetscCall(restore_forest(problem%deck, best%snapshots, best%division, error, ierr))
      if (allocated(error)) return
    end if
    model = best%model
    call log_cluster_warnings(model)
    if (outcome%is_reached) then
      call log_info(outcome%ending)
    else
      call log_warning(outcome%ending)
    end if
  end subroutine refine

  !> Checks what later divisions into clusters need. Collective on all ranks. Errors: a snapshot is zero; a point of the grid has no
  !> solution (regular clusters).
  subroutine check_start(problem, snapshots, error, ierr)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: lengths(:)

    PetscCall(snapshot_lengths(snapshots, PETSC_COMM_WORLD, lengths, ierr))
    work: block
      if (problem%deck%clusters%method == 'regular') call need_whole_grid(problem%deck, size(lengths), error)
      if (allocated(error)) exit work
      call check_snapshots(lengths, snapshots%parameter_names, snapshots%parameters, error)
    end block work
    if (.not. allocated(error)) return
    if (len(error%file) == 0) error%file = problem%deck%path
  end subroutine check_start

  !> Tries 1, 2, ... clusters of all snapshots (at most max_number and n_items) until one reaches the target or a signal comes;
  !> keeps the best model. A number that gives no model ends this with a warning, or, if it is 1, an error. Collective.
  subroutine raise_number(problem, candidates, fallback, best, outcome, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: candidates
    class(reduced_t), allocatable, intent(in) :: fallback
    !> in: snapshots and candidates
    type(attempt_t), intent(inout) :: best
    type(refinement_result_t), intent(inout) :: outcome
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(attempt_t) :: attempt
    integer :: largest, n_clusters

    ierr = 0
    attempt = best
    largest = min(problem%deck%clusters%max_number, n_items(problem, attempt%snapshots))
    do n_clusters = 1, largest
      PetscCall(start_attempt(problem, candidates, fallback, n_clusters, attempt, error, ierr))
      if (allocated(error)) then
        if (n_clusters == 1) return
        ! fewer clusters have a model, which may be the best one
        call log_warning(to_text(n_clusters) // ' clusters give no model, so larger numbers are not tried: ' // error%message)
        deallocate (error)
        largest = n_clusters - 1
        exit
      end if
      call keep_round(problem%deck%clusters, 'number', 0, attempt, best, outcome)
      PetscCall(agree_to_stop(PETSC_COMM_WORLD, outcome%is_stopped, ierr))
      if (outcome%is_reached .or. outcome%is_stopped) exit
    end do
    call end_with(problem%deck%clusters, 'no number of clusters up to ' // to_text(largest) // ' does better', outcome)
  end subroutine raise_number

  !> Returns the largest possible number of clusters: one per snapshot, or per cell of the grid (regular clusters).
  pure integer function n_items(problem, snapshots)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots

    n_items = snapshots%n_snapshots()
    if (problem%deck%clusters%method == 'regular') n_items = product(problem%deck%training%grid - 1)
  end function n_items

  !> In each round adds snapshots to the cluster with the largest error, or splits it if its last snapshots did not help enough or
  !> it can get none (choose_step). A cluster that cannot be trained with its new snapshots, or whose halves cannot be trained,
  !> stays as it was, with a warning. A round can make the model worse, so the model of the best round is kept. Collective.
  !> Errors: those of start_attempt; the forest cannot be trained again.
  subroutine grow(problem, candidates, fallback, best, outcome, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in), target :: candidates
    class(reduced_t), allocatable, intent(in) :: fallback
    !> in: snapshots and candidates
    type(attempt_t), intent(inout) :: best
    type(refinement_result_t), intent(inout) :: outcome
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(attempt_t) :: attempt
    type(prospect_t), allocatable :: prospects(:)
    integer :: k, n_first
    logical :: is_done, is_split

    attempt = best
    n_first = attempt%snapshots%n_snapshots()
    PetscCall(start_attempt(problem, candidates, fallback, problem%deck%clusters%number, attempt, error, ierr))
    if (allocated(error)) return
    call keep_round(problem%deck%clusters, 'start', 0, attempt, best, outcome)
    allocate (prospects(size(attempt%division%clusters)))
    do
      PetscCall(agree_to_stop(PETSC_COMM_WORLD, outcome%is_stopped, ierr))
      if (outcome%is_reached .or. outcome%is_stopped) exit
      call choose_step(problem%deck%clusters, attempt, attempt%snapshots%n_snapshots() - n_first, prospects, k, is_split)
      if (k == 0) exit
      if (is_split) then
        PetscCall(try_split(problem, candidates, k, attempt, prospects, is_done, error, ierr))
      else
        PetscCall(try_growth(problem, candidates, k, n_first, attempt, prospects, is_done, ierr))
      end if
      if (allocated(error)) return
      if (is_done) call keep_round(problem%deck%clusters, trim(merge('split', 'add  ', is_split)), k, attempt, best, outcome)
    end do
    associate (config => problem%deck%clusters)
      call end_with(config, 'no cluster can be split (max_number ' // to_text(config%max_number) // ', min_snapshots) or get ' // &
        'more candidates (max_points ' // to_text(config%refine%max_points) // '), unless its training failed', outcome)
    end associate
  end subroutine grow

  !> Chooses the cluster k that grows or is split next: of those that can, the one whose errors at its open candidates have the
  !> largest statistic (clusters.target.statistic: p95, median or max); k = 0: none. A cluster can grow if an open candidate of it
  !> has an error above 0, max_points is not reached, and its last growth could be trained. It can be split if max_number is not
  !> reached and no split of it has failed. It is split if it can be, and its last growth did not help enough or it cannot grow.
  pure subroutine choose_step(config, attempt, n_added, prospects, k, is_split)
    type(clusters_config_t), intent(in) :: config
    type(attempt_t), intent(in) :: attempt
    !> snapshots that earlier rounds added
    integer, intent(in) :: n_added
    type(prospect_t), intent(in) :: prospects(:)
    integer, intent(out) :: k
    logical, intent(out) :: is_split
    logical :: can_grow(size(prospects)), can_split(size(prospects))
    integer :: i

    can_split = prospects%may_split .and. size(prospects) < config%max_number
    do i = 1, size(prospects)
      can_grow(i) = prospects(i)%may_grow .and. n_added < config%refine%max_points .and. &
        size(worst_candidates(attempt%open_errors(), i, 1)) > 0
    end do
    k = worst_cluster(config%target%statistic, attempt%open_errors(), size(prospects), can_grow .or. can_split)
    is_split = .false.
    if (k > 0) is_split = can_split(k) .and. (prospects(k)%is_split_next .or. .not. can_grow(k))
  end subroutine choose_step

  !> Adds the worst open candidates of cluster k, as many as points_per_round and max_points allow, to its snapshots and trains it.
  !> prospects(k)%is_split_next then says whether this did not help enough (has_gained at its other open candidates). Collective.
  subroutine try_growth(problem, candidates, k, n_first, attempt, prospects, is_done, ierr)
    type(problem_t), intent(in) :: problem
    !> outlives the attempt
    type(snapshot_set_t), intent(in), target :: candidates
    integer, intent(in) :: k
    !> number of snapshots before the first round
    integer, intent(in) :: n_first
    type(attempt_t), intent(inout) :: attempt
    type(prospect_t), intent(inout) :: prospects(:)
    !> false if the cluster cannot be trained with them: then the attempt stays, and the cluster gets no more unless it is split
    logical, intent(out) :: is_done
    PetscErrorCode, intent(out) :: ierr
    type(attempt_t) :: next
    type(error_t), allocatable :: failure
    integer, allocatable :: numbers(:)
    integer :: i, n

    n = attempt%snapshots%n_snapshots()
    associate (config => problem%deck%clusters%refine)
      numbers = worst_candidates(attempt%open_errors(), k, min(config%points_per_round, config%max_points - (n - n_first)))
    end associate
    next = attempt
    next%is_open(numbers) = .false.
    call next%snapshots%append(take_snapshots(candidates, numbers))
    next%division%clusters(k)%snapshots = [next%division%clusters(k)%snapshots, [(n + i, i=1, size(numbers))]]
    PetscCall(train_attempt(problem, candidates, [k], next, failure, ierr))
    is_done = .not. allocated(failure)
    prospects(k)%may_grow = is_done
    if (is_done) then
      prospects(k)%is_split_next = .not. has_gained(problem%deck%clusters%target%statistic, own_errors(attempt%errors), &
        own_errors(next%errors))
      attempt = next
    else
      call log_warning('cluster ' // to_text(k) // ' stays as it was; its new snapshots cannot be used: ' // failure%message)
    end if

  contains

    function own_errors(errors) result(values)
      type(pool_errors_t), intent(in) :: errors
      real(rk), allocatable :: values(:)

      values = pack(errors%values, errors%cluster == k .and. next%is_open)
    end function own_errors
  end subroutine try_growth

  !> Whether new snapshots reduced the statistic (median, p95 or max) of the errors to at most 0.7 times the one before; if it is
  !> infinite afterwards, whether they did so with the number of infinite errors.
  pure logical function has_gained(statistic, before, after)
    character(*), intent(in) :: statistic
    !> [-] errors at the candidates of the cluster, before and after
    real(rk), intent(in) :: before(:)
    real(rk), intent(in) :: after(:)
    real(rk) :: error

    error = statistic_of(statistic, after)
    if (error > huge(error)) then
      has_gained = n_failed(after) <= clear_gain * n_failed(before)
    else
      has_gained = error <= clear_gain * statistic_of(statistic, before)
    end if
  end function has_gained

  !> Splits cluster k and trains both halves: cluster k and a new last cluster. Collective. Errors: those of split_cluster.
  subroutine try_split(problem, candidates, k, attempt, prospects, is_done, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: candidates
    integer, intent(in) :: k
    type(attempt_t), intent(inout) :: attempt
    type(prospect_t), allocatable, intent(inout) :: prospects(:)
    !> false if a half has too few snapshots or cannot be trained: then the attempt stays as it was, and k is not split later
    logical, intent(out) :: is_done
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(attempt_t) :: next
    type(error_t), allocatable :: failure

    next = attempt
    PetscCall(split_cluster(problem%deck, next%snapshots, k, next%division, is_done, error, ierr))
    if (allocated(error)) return
    prospects(k)%may_split = is_done
    if (.not. is_done) return
    PetscCall(train_attempt(problem, candidates, [k, size(next%division%clusters)], next, failure, ierr))
    is_done = .not. allocated(failure)
    prospects(k)%may_split = is_done
    if (is_done) then
      attempt = next
      prospects(k) = prospect_t()
      prospects = [prospects, prospect_t()]
    else
      call log_warning('cluster ' // to_text(k) // ' is not split: ' // failure%message)
    end if
  end subroutine try_split

  !> Adds a round (`action` as in refinement_round_t) to the outcome, logs it, and sets outcome%is_reached. The first round and each
  !> that is_better give the best model. Its error is the target's statistic at the candidates of is_measure; all NaN: infinite.
  subroutine keep_round(config, action, k, attempt, best, outcome)
    type(clusters_config_t), intent(in) :: config
    character(*), intent(in) :: action
    !> cluster that was changed, 0 = all
    integer, intent(in) :: k
    type(attempt_t), intent(in) :: attempt
    type(attempt_t), intent(inout) :: best
    type(refinement_result_t), intent(inout) :: outcome
    type(refinement_round_t) :: latest
    integer :: n, n_before, n_clusters, worst
    real(rk) :: error

    n = size(outcome%rounds)
    associate (n_snapshots => attempt%snapshots%n_snapshots())
      n_before = n_snapshots
      if (n > 0) n_before = outcome%rounds(n)%n_snapshots
      n_clusters = size(attempt%division%clusters)
      worst = worst_cluster(config%target%statistic, attempt%open_errors(), n_clusters, spread(.true., 1, n_clusters))
      latest = make_round(action, k, n_clusters, n_snapshots, worst, attempt%measured())
      call log_info(round_text(n, latest, n_snapshots - n_before, config%target%measure))
      outcome%rounds = [outcome%rounds, latest]
    end associate
    error = statistic_of(config%target%statistic, attempt%measured())
    ! no contact at any candidate proves nothing
    if (latest%errors%n_values == 0) error = ieee_value(error, ieee_positive_inf)
    outcome%is_reached = error <= config%target%error
    if (n > 0) then
      if (.not. is_better(error, latest%n_failed, outcome%error, outcome%rounds(outcome%best_round + 1)%n_failed)) return
    end if
    outcome%best_round = n
    outcome%error = error
    best = attempt
  end subroutine keep_round

  !> Whether the error is below the best one by more than 1e-8 of it; if both are infinite, whether fewer errors are (n_failed).
  pure logical function is_better(error, n_failed, best_error, best_n_failed)
    real(rk), intent(in) :: error
    integer, intent(in) :: n_failed
    real(rk), intent(in) :: best_error
    integer, intent(in) :: best_n_failed

    is_better = error < best_error * (1 - tie_tolerance)
    if (error > huge(error)) is_better = best_error > huge(error) .and. n_failed < best_n_failed
  end function is_better

  subroutine end_with(config, reason, outcome)
    type(clusters_config_t), intent(in) :: config
    !> why there is no further round, where the target is not reached
    character(*), intent(in) :: reason
    type(refinement_result_t), intent(inout) :: outcome

    outcome%ending = 'the model is that of round ' // to_text(outcome%best_round) // ': ' // config%target%statistic // ' of ' // &
      config%target%measure // ' is ' // three_digits(outcome%error)
    if (outcome%rounds(outcome%best_round + 1)%errors%n_values == 0) then
      outcome%ending = 'the model is that of round ' // to_text(outcome%best_round) // ': ' // config%target%measure // &
        ' cannot be measured, because no candidate that measures has contact forces'
      return
    end if
    associate (failed => outcome%rounds(outcome%best_round + 1)%n_failed)
      if (failed > 0) outcome%ending = outcome%ending // ' (' // counted(failed, 'candidate') // ' failed)'
    end associate
    if (outcome%is_reached) then
      outcome%ending = outcome%ending // ', within the target of ' // to_text(config%target%error)
    else
      outcome%ending = outcome%ending // ', above the target of ' // to_text(config%target%error) // '; ' // reason
    end if
  end subroutine end_with
end module sig_refinement
