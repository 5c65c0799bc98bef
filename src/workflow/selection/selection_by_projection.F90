! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Greedy selection among solved candidates: the next point is the one whose solution is approximated worst by the solutions chosen
!> so far.
!>
!> Each candidate has a field as for the POD: its displacement u minus the response without contact, or, with `dirichlet:
!> multiplier`, the whole u. The error of a candidate is the distance of its field from the span of the chosen fields, relative to
!> |u|. No hyper-reduced model of the chosen points has a smaller error (17) there, unless it has hat functions.
module sig_selection_by_projection
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use mpi, only: MPI_Comm_rank
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_farthest_points, only: farthest_points
  use sig_greedy_projection, only: greedy_projection_t
  use sig_greedy_record, only: keep_selection
  use sig_greedy_rules, only: box_of, log_choice, selection_end
  use sig_kinds, only: rk
  use sig_pod, only: contact_part
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged
  use sig_sampling, only: sampler_t, sampling_result_t
  use sig_selection, only: selection_t
  use sig_snapshot_merge, only: candidate_store, read_store, snapshot_store, store_t, write_merged
  use sig_snapshot_shard, only: snapshot_record_t
  use sig_snapshot_store, only: columns_of, records_of_set, snapshot_set_t
  use sig_training_modes, only: terms_at
  use sig_training_set, only: take_snapshots, training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: select_by_projection

contains

  !> Solves all candidates, then selects points among them: writes candidates.h5, snapshots.h5 and selection.csv into the folder.
  !> The first rank selects. A signal while the candidates are solved ends it early (outcome%is_stopped). Collective on all ranks;
  !> errors are known to all.
  !>
  !> Errors: those of the sampling and of choose_from_pool; selection.csv cannot be written.
  subroutine select_by_projection(sampler, folder, candidates, outcome, selection, error, ierr)
    !> created
    type(sampler_t), intent(inout) :: sampler
    !> results folder
    character(*), intent(in) :: folder
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    type(sampling_result_t), intent(out) :: outcome
    !> in: without points; out: complete on the first rank, unchanged on all others
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    integer :: rank

    PetscCall(sampler%solve_missing(store_t(folder, candidate_store), candidates, outcome, error, ierr))
    if (allocated(error) .or. outcome%is_stopped) return
    call MPI_Comm_rank(PETSC_COMM_WORLD, rank, ierr)
    if (rank == 0) call choose_from_pool(sampler%problem, folder, candidates, selection, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    if (allocated(error)) return
    PetscCall(keep_selection(sampler%problem, folder, selection, rank == 0, error, ierr))
  end subroutine select_by_projection

  !> Selects points among the solved candidates and writes snapshots.h5: first the solutions of the selected points, then the other
  !> solutions that the file had.
  !> Local: one rank calls it. Errors: `choose` finds no point; those of read_store and write_merged.
  subroutine choose_from_pool(problem, folder, candidates, selection, error)
    type(problem_t), intent(in) :: problem
    character(*), intent(in) :: folder
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    type(snapshot_set_t) :: pool
    type(snapshot_record_t), allocatable :: records(:)
    real(rk), allocatable :: vectors(:, :)
    integer, allocatable :: chosen(:)
    logical :: is_missing(size(candidates, 2))

    call read_store(problem, store_t(folder, candidate_store), candidates, pool, is_missing, error)
    if (allocated(error)) return
    call vectors_to_represent(problem, pool, vectors)
    call choose(problem, pool%parameters, vectors, selection, chosen)
    if (size(chosen) == 0) then
      call make_error(error, 'no candidate has a full-order solution with a displacement (unless reduction.dirichlet is ' // &
        'multiplier: a displacement by contact forces) above rounding and training.greedy.tolerance', problem%deck%path, &
        problem%deck%training%line, problem%deck%training%column, exit_code=exit_not_converged)
      return
    end if
    records = records_of_set(columns_of(pool, chosen))
    call write_merged(problem, store_t(folder, snapshot_store), selection%points, records, pool%free_response, error)
  end subroutine choose_from_pool

  !> Computes one vector per candidate. It is the field that the POD would get (contact_part): the displacement minus the response
  !> without contact, or, with `dirichlet: multiplier`, the whole displacement. It is divided by the Euclidean norm of the whole
  !> displacement. It is zero if the candidate has no solution, or if its displacement is at most 1e-10 of the largest one. Local.
  subroutine vectors_to_represent(problem, pool, vectors)
    type(problem_t), intent(in) :: problem
    !> solutions with all dofs
    type(snapshot_set_t), intent(in) :: pool
    !> [-] shape (n_dofs, number of solutions in the pool)
    real(rk), allocatable, intent(out) :: vectors(:, :)
    !> [-] share of the largest displacement up to which a displacement is rounding
    real(rk), parameter :: negligible = 1.0e-10_rk
    real(rk) :: sizes(size(pool%reasons))
    type(training_set_t) :: snapshots
    real(rk), allocatable :: theta(:, :)
    integer :: i

    snapshots = take_snapshots(pool, [(i, i=1, size(sizes))])
    theta = terms_at(problem, snapshots)
    sizes = norm2(pool%displacement, dim=1)
    allocate (vectors, mold=pool%displacement)
    do i = 1, size(sizes)
      if (pool%reasons(i) == reason_converged .and. sizes(i) > negligible * maxval(sizes)) then
        vectors(:, i) = contact_part(snapshots, pool%free_response, theta, i) / sizes(i)
      else
        vectors(:, i) = 0
      end if
    end do
  end subroutine vectors_to_represent

  !> Chooses greedy.initial points that are far from each other, and drops those of them whose vector is zero. Then chooses the
  !> candidate with the largest projection error each time until selection_end has a reason. Fills the selection, which must have no
  !> points, with stopped_by and largest_left. Nothing is chosen if all vectors are zero, or if those of the initial points are zero
  !> and no other is longer than the deck's tolerance. Local.
  subroutine choose(problem, candidates, vectors, selection, chosen)
    type(problem_t), intent(in) :: problem
    !> points of the vectors, shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    !> results of vectors_to_represent; moved away
    real(rk), allocatable, intent(inout) :: vectors(:, :)
    type(selection_t), intent(inout) :: selection
    !> numbers of the chosen candidates, 1-based, in the order of the choice
    integer, allocatable, intent(out) :: chosen(:)
    type(greedy_projection_t) :: greedy
    real(rk) :: error, none
    integer, allocatable :: first(:)
    logical :: is_zero(size(vectors, 2))
    integer :: i

    none = ieee_value(none, ieee_quiet_nan)
    is_zero = .not. any(abs(vectors) > 0, dim=1)
    call greedy%create(vectors, min(problem%deck%greedy%max_points, size(candidates, 2)))
    first = farthest_points(candidates, box_of(problem%deck), min(problem%deck%greedy%n_initial, size(candidates, 2)))
    chosen = pack(first, .not. is_zero(first))
    do i = 1, size(chosen)
      call greedy%take(chosen(i))
      call selection%append(candidates(:, chosen(i):chosen(i)), [none])
    end do
    do
      call greedy%find_worst(i, error)
      selection%largest_left = error
      ! without a candidate left there is no worst one
      selection%stopped_by = selection_end(problem%deck%greedy, size(chosen), merge(error, -1.0_rk, i > 0))
      if (selection%stopped_by /= '') exit
      call greedy%take(i)
      call selection%append(candidates(:, i:i), [error])
      chosen = [chosen, i]
      call log_choice(problem%deck, size(chosen), 'projection error', error, candidates(:, i))
    end do
  end subroutine choose
end module sig_selection_by_projection
