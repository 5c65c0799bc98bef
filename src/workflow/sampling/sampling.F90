! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Solves points and stores the solutions. Groups of ranks solve different points. The solutions are written to disk during the run,
!> so that the same command goes on after a killed run.
module sig_sampling
  use sig_body_rotations, only: largest_deformation, largest_rotation
  use sig_contact_state, only: contact_state_t
  use sig_deck_config, only: point_set_config_t
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t
  use sig_full_order, only: full_order_t, team_t
  use sig_kinds, only: rk
  use sig_materials, only: varying_constants
  use sig_parameter_space, only: build_states
  use sig_point_batches, only: deal_points, point_batches_t
  use sig_point_checks, only: check_points
  use sig_problem, only: problem_t
  use sig_problem_texts, only: announce_plan
  use sig_progress, only: progress_t
  use sig_rank_groups, only: rank_groups_t
  use sig_reasons, only: reason_converged
  use sig_sampled_responses, only: sampled_responses_t
  use sig_sampling_shares, only: points_of_share, warn_of_missing_points
  use sig_snapshot_buffer, only: snapshot_buffer_t
  use sig_snapshot_merge, only: find_finished_points, merge_snapshots, store_t
  use sig_snapshot_shard, only: shard_content_t, snapshot_record_t
  use sig_petsc_support, only: max_over_ranks, sum_over_ranks
  use sig_solver_options, only: refuse_unused_options
  use sig_stop_request, only: agree_to_stop
  use petsc
  implicit none(type, external)
  private
  public :: sample, sampler_t, sampling_result_t

  !> How a sampling ended.
  type :: sampling_result_t
    !> number of points that were wanted
    integer :: n_points = 0
    !> points whose converged solutions were on disk already
    integer :: n_found = 0
    !> points that this run tried and that did not converge
    integer :: n_failed = 0
    !> a signal came: some points may be left to do, and the shards are not merged
    logical :: is_stopped = .false.
    !> [rad] largest rotation of a body that only contact holds, over the points that this run solved
    real(rk) :: rotation = 0
    !> [-] largest deformation of a body over the same points
    real(rk) :: deformation = 0
    !> how often all groups together assembled and factored a stiffness since the team got its solver
    integer :: n_stiffnesses = 0
  end type sampling_result_t

  !> Solves one or several sets of points. The problem and the team of groups belong to the full_order of create.
  type :: sampler_t
    type(problem_t), pointer :: problem => null()
    type(team_t), pointer :: team => null()
    !> responses of the bodies, by which points are solved without a factorization for each stiffness
    type(sampled_responses_t), private :: responses
    type(progress_t), private :: progress
    !> number of points that the call of solve_points has finished before the present call of solve_some
    integer, private :: n_before = 0
  contains
    procedure :: create
    procedure :: solve_missing
  end type sampler_t

contains

  !> Solves a set of points of the deck, or the store's share of them, and keeps the solutions in the store. Collective on all
  !> ranks; errors are known to all.
  !>
  !> Errors: those of build_states and solve_missing; with a share also those of check_points at all points.
  subroutine sample(full_order, point_set, store, outcome, error, ierr)
    !> loaded
    type(full_order_t), target, intent(inout) :: full_order
    type(point_set_config_t), intent(in) :: point_set
    !> in the results folder, which this run has locked
    type(store_t), intent(in) :: store
    type(sampling_result_t), intent(out) :: outcome
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(sampler_t) :: sampler
    real(rk), allocatable :: points(:, :)

    ierr = 0
    call build_states(full_order%problem%deck, point_set, points, error)
    if (allocated(error)) return
    if (store%share%is_used()) then
      call check_points(full_order%problem, points, error)
      if (allocated(error)) return
      points = points(:, points_of_share(full_order%problem, points, store%share))
      if (size(points, 2) == 0) return
    end if
    PetscCall(sampler%create(full_order, size(points, 2), ierr))
    PetscCall(sampler%solve_missing(store, points, outcome, error, ierr))
  end subroutine sample

  !> Chooses the team of groups by training.groups of the deck, also for other sets of points. Its solver is made by solve_missing,
  !> if there is something to do. Collective on all ranks.
  subroutine create(self, full_order, n_points, ierr)
    class(sampler_t), intent(inout) :: self
    !> loaded
    type(full_order_t), target, intent(inout) :: full_order
    !> largest number of points that are solved in one call; there are not more groups than points
    integer, intent(in) :: n_points
    PetscErrorCode, intent(out) :: ierr

    self%problem => full_order%problem
    PetscCall(full_order%team_for(self%problem%deck%training%n_groups, n_points, self%team, ierr))
  end subroutine create

  !> Solves the points of which the store has no converged solution, then merges the store into one file, but where it has a share
  !> leaves the solutions in shards; does nothing if all are solved and merged. A point that does not converge is stored with its
  !> reason, and the next call tries it again. After a signal (outcome%is_stopped) or an error the finished points stay in shards.
  !> Collective on all ranks; errors are known to all.
  !>
  !> Errors: those of check_points and find_finished_points; the solver does not use one of its PETSc options; a file cannot be
  !> written; the elastic response to the prescribed values cannot be computed.
  subroutine solve_missing(self, store, points, outcome, error, ierr)
    class(sampler_t), intent(inout) :: self
    type(store_t), intent(in) :: store
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(sampling_result_t), intent(out) :: outcome
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: to_do(:)
    logical, allocatable :: is_done(:)
    logical :: is_merged
    integer :: i, n_stored

    ierr = 0
    outcome%n_points = size(points, 2)
    call check_points(self%problem, points, error)
    if (allocated(error)) return
    PetscCall(find_finished_points(self%problem, store, points, is_done, is_merged, error, ierr, n_stored))
    if (allocated(error)) return
    if (is_merged) then
      outcome%n_found = count(is_done)
      return
    end if
    call ask_whole_histories(self%problem, is_done)
    if (.not. store%share%is_used()) call warn_of_missing_points(self%problem, points, is_done, store%shares_there())
    to_do = pack([(i, i=1, size(is_done))], .not. is_done)
    outcome%n_found = count(is_done)
    if (size(to_do) > 0 .and. .not. self%team%is_ready) call announce_plan(self%problem, points)
    PetscCall(self%team%make_ready(self%problem, ierr))
    PetscCall(solve_and_merge(self, store, points, to_do, n_stored, outcome, error, ierr))
  end subroutine solve_missing

  !> Where the states of a history remember, a history of which one state is missing is solved as a whole.
  pure subroutine ask_whole_histories(problem, is_done)
    type(problem_t), intent(in) :: problem
    !> of each point, shape (n_points)
    logical, intent(inout) :: is_done(:)
    integer :: first, n_times

    if (.not. problem%remembers()) return
    n_times = max(1, problem%deck%history%states%n_times())
    do first = 1, size(is_done), n_times
      associate (own => is_done(first:first + n_times - 1))
        own = all(own)
      end associate
    end do
  end subroutine ask_whole_histories

  !> Solves some of the points and merges the store; where this has a share, and after a signal or an error, it only writes the
  !> shards. Collective on all ranks. Errors: those of solve_points, close_buffer and merge_snapshots.
  subroutine solve_and_merge(self, store, points, to_do, n_stored, outcome, error, ierr)
    type(sampler_t), intent(inout) :: self
    type(store_t), intent(in) :: store
    !> all, shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> numbers of the points to solve, 1-based
    integer, intent(in) :: to_do(:)
    !> number of dofs of which the store keeps displacements: all or 0
    integer, intent(in) :: n_stored
    type(sampling_result_t), intent(inout) :: outcome
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_buffer_t) :: buffer
    real(rk) :: stopped, counts(2)
    logical :: is_last

    PetscCall(solve_points(self, store, points(:, to_do), n_stored, buffer, outcome, error, ierr))
    stopped = merge(1.0_rk, 0.0_rk, outcome%is_stopped)
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, stopped, ierr))
    outcome%is_stopped = stopped > 0
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, outcome%rotation, ierr))
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, outcome%deformation, ierr))
    counts = [outcome%n_failed, merge(self%team%solver%n_stiffnesses, 0, self%team%groups%is_leader())]
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, counts, ierr))
    outcome%n_failed = nint(counts(1))
    outcome%n_stiffnesses = nint(counts(2)) + self%responses%n_factorizations()
    is_last = allocated(error) .or. outcome%is_stopped .or. store%share%is_used()
    PetscCall(close_buffer(self%team%groups, is_last, buffer, error, ierr))
    if (allocated(error) .or. is_last) return
    PetscCall(merge_snapshots(self%problem, self%team, store, points, n_stored, buffer%records, error, ierr))
  end subroutine solve_and_merge

  !> Closes the buffers of the leaders of the groups. The first rank, which merges, keeps the records that it has not written; all
  !> others write theirs. If nothing will be merged, all write. Collective on all ranks. Errors: a shard cannot be written.
  subroutine close_buffer(groups, is_last, buffer, error, ierr)
    type(rank_groups_t), intent(in) :: groups
    !> nothing will be merged, because of an error, a signal or a share
    logical, intent(in) :: is_last
    type(snapshot_buffer_t), intent(inout) :: buffer
    !> if there is an error already, it stays
    type(error_t), allocatable, intent(inout) :: error
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: close_error

    if (groups%is_leader() .and. allocated(buffer%records)) &
      call buffer%close(groups%world_rank == 0 .and. .not. is_last, close_error)
    PetscCall(broadcast_error(close_error, PETSC_COMM_WORLD, ierr))
    if (.not. allocated(error)) call move_alloc(close_error, error)
    if (.not. allocated(buffer%records)) allocate (buffer%records(0))
  end subroutine close_buffer

  !> Solves the points. If the responses are used, some points are solved first with their own stiffness, then the responses are
  !> made, and the other points are solved by them if they are ready. After a signal or an error in any group, no group begins the
  !> other points. Collective on all ranks. Errors: a shard cannot be written; the solver does not use one of its PETSc options.
  subroutine solve_points(self, store, points, n_stored, buffer, outcome, error, ierr)
    type(sampler_t), intent(inout) :: self
    type(store_t), intent(in) :: store
    !> those that are left to do, shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> number of dofs whose displacements are kept: all or 0
    integer, intent(in) :: n_stored
    type(snapshot_buffer_t), intent(inout) :: buffer
    !> n_failed, rotation, deformation and is_stopped are those of this group
    type(sampling_result_t), intent(inout) :: outcome
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: first(:), rest(:)
    logical :: is_ended
    integer :: i

    if (self%team%groups%is_leader()) then
      call buffer%create(store%shard_path(self%team%groups%i_group), shard_content_t(self%problem%provenance, size(points, 1), &
        n_stored, self%team%solver%system%rows%n_rows), error)
    end if
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    if (allocated(error)) return
    call self%responses%choose(self%problem, points, self%team%groups%n_ranks, first)
    call self%progress%start('sampling', size(points, 2))
    self%n_before = 0
    if (size(first) > 0) then
      PetscCall(solve_some(self, points, first, n_stored, buffer, outcome, error, ierr))
      PetscCall(agree_to_end(outcome, error, is_ended, ierr))
      if (.not. is_ended) then
        PetscCall(self%responses%create(self%problem, self%team, ierr))
      end if
      self%n_before = size(first)
    end if
    PetscCall(agree_to_end(outcome, error, is_ended, ierr))
    if (.not. is_ended) then
      rest = pack([(i, i=1, size(points, 2))], [(all(first /= i), i=1, size(points, 2))])
      PetscCall(solve_some(self, points, rest, n_stored, buffer, outcome, error, ierr))
    end if
    call self%progress%finish()
    ! this process may be ended by force while it waits for the other groups
    if (outcome%is_stopped .and. self%team%groups%is_leader() .and. .not. allocated(error)) call buffer%flush(error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
  end subroutine solve_points

  !> Finds out whether any rank has an error or was stopped. Collective on all ranks.
  subroutine agree_to_end(outcome, error, is_ended, ierr)
    type(sampling_result_t), intent(in) :: outcome
    type(error_t), allocatable, intent(in) :: error
    logical, intent(out) :: is_ended
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: ended

    ended = merge(1.0_rk, 0.0_rk, outcome%is_stopped .or. allocated(error))
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, ended, ierr))
    is_ended = ended > 0
  end subroutine agree_to_end

  !> Solves this group's share of some points (deal_points), as many at once as the solver takes. A point that did not converge is
  !> kept with its reason. A signal or an error of the group ends the loop after a batch. Collective on the group. Errors: a shard
  !> cannot be written; the solver does not use one of its PETSc options.
  subroutine solve_some(self, points, numbers, n_stored, buffer, outcome, error, ierr)
    type(sampler_t), intent(inout) :: self
    !> all that are left to do, shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> numbers of the points to solve, 1-based
    integer, intent(in) :: numbers(:)
    !> number of dofs whose displacements are kept: all or 0
    integer, intent(in) :: n_stored
    type(snapshot_buffer_t), intent(inout) :: buffer
    type(sampling_result_t), intent(inout) :: outcome
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(point_batches_t) :: own
    integer :: first, i, last

    ierr = 0
    call deal_points(varying_constants(self%problem%deck, self%problem%material_terms, points(:, numbers)), &
      self%team%groups%i_group, self%team%groups%n_groups, self%team%solver%n_points_at_once(), self%team%solver%n_times(), own)
    last = 0
    do i = 1, size(own%ends)
      first = last + 1
      last = own%ends(i)
      associate (places => own%points(first:last))
        PetscCall(solve_batch(self, points(:, numbers(places)), places, n_stored, buffer, outcome, error, ierr))
      end associate
      ! responses may solve all points without the solver, which then has not read its options
      if (i == 1 .and. .not. (self%responses%is_ready .or. allocated(error))) then
        PetscCall(refuse_unused_options(self%problem%plan%type, error, ierr))
      end if
      PetscCall(agree_to_stop(self%team%groups%comm, outcome%is_stopped, ierr))
      call self%progress%advance(self%n_before + min(last * self%team%groups%n_groups, size(numbers)))
      if (allocated(error) .or. outcome%is_stopped) exit
    end do
  end subroutine solve_some

  !> Solves the points of one batch, by the responses if they are ready. The leader of the group adds the solutions to the buffer of
  !> its shard, also those that did not converge, counts the latter in outcome%n_failed, and updates outcome%rotation and
  !> outcome%deformation. While n_before is 0, it also gives the solutions to responses%collect. Collective on the group. Errors:
  !> the shard cannot be written.
  subroutine solve_batch(self, points, places, n_stored, buffer, outcome, error, ierr)
    type(sampler_t), intent(inout) :: self
    !> those of the batch, shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> their positions in `numbers` of solve_some
    integer, intent(in) :: places(:)
    !> number of dofs whose displacements are kept: all or 0
    integer, intent(in) :: n_stored
    type(snapshot_buffer_t), intent(inout) :: buffer
    type(sampling_result_t), intent(inout) :: outcome
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(contact_state_t) :: states(size(points, 2))
    type(snapshot_record_t) :: records(size(points, 2))
    integer :: i

    if (self%responses%is_ready) then
      do i = 1, size(states)
        PetscCall(self%responses%solve(self%problem, self%team%solver, points(:, i), states(i), ierr))
      end do
    else
      PetscCall(self%team%solver%solve_points(self%problem, points, states, ierr))
    end if
    if (self%team%groups%is_leader()) then
      outcome%n_failed = outcome%n_failed + count(states%reason /= reason_converged)
      outcome%rotation = max(outcome%rotation, largest_rotation(self%problem%motions, states))
      outcome%deformation = max(outcome%deformation, largest_deformation(self%problem%motions, states))
      do i = 1, size(states)
        if (self%n_before == 0) call self%responses%collect(places(i), states(i))
        call make_record(points(:, i), n_stored > 0, states(i), records(i))
      end do
      call buffer%add(records, error)
    end if
    PetscCall(broadcast_error(error, self%team%groups%comm, ierr))
  end subroutine solve_batch

  !> Makes a record of a point and its solution. The multipliers and, with has_displacement, the displacement move from the state to
  !> the record; the state loses them. Without has_displacement the record's displacement has size 0, and the state keeps its own.
  pure subroutine make_record(point, has_displacement, state, record)
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    logical, intent(in) :: has_displacement
    type(contact_state_t), intent(inout) :: state
    type(snapshot_record_t), intent(out) :: record

    record%parameters = point
    if (has_displacement) then
      call move_alloc(state%displacement, record%displacement)
    else
      allocate (record%displacement(0))
    end if
    call move_alloc(state%multipliers, record%multipliers)
    record%n_iterations = state%n_iterations
    record%reason = state%reason
    record%residuals = [state%residuals%equilibrium, state%residuals%penetration, state%residuals%negative_multiplier, &
      state%residuals%complementarity, state%residuals%force_balance]
    record%seconds = state%seconds
  end subroutine make_record
end module sig_sampling
