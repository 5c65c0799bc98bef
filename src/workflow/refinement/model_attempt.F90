! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> One model of a refinement: its snapshots are divided into clusters, the clusters are trained, and its errors are measured at the
!> candidates.
module sig_model_attempt
  use sig_candidate_pool, only: draw_half, errors_among, finish_displacement_errors, measure_candidates, pool_errors_t, &
    usable_candidates
  use sig_cluster_division, only: divide_snapshots
  use sig_cluster_split, only: division_t
  use sig_cluster_training, only: train_clusters
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_hhr_data, only: hhr_data_t
  use sig_model, only: model_t
  use sig_model_parts, only: set_clusters, set_fallback
  use sig_model_header, only: fill_model_header
  use sig_petsc_support, only: sum_over_ranks
  use sig_problem, only: problem_t
  use sig_reduced, only: reduced_t
  use sig_snapshot_lengths, only: snapshot_lengths
  use sig_snapshot_store, only: snapshot_set_t
  use sig_hhr_start_sets, only: fill_start_sets
  use sig_text, only: to_text
  use sig_training_set, only: take_snapshots, training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: attempt_t, share_candidates, start_attempt, train_attempt

  !> A model with its snapshots, its division into clusters, its local models, and its errors.
  type :: attempt_t
    type(training_set_t) :: snapshots
    type(division_t) :: division
    type(hhr_data_t), allocatable :: models(:)
    type(model_t) :: model
    !> candidates that are kept for measuring, and candidates that may become snapshots (the same ones if the deck adds none); shape
    !> (n_candidates)
    logical, allocatable :: is_measure(:)
    logical, allocatable :: is_open(:)
    type(pool_errors_t) :: errors
  contains
    procedure :: measured
    procedure :: open_errors
  end type attempt_t

contains

  !> Divides the usable candidates: a random half (draw_half, by clusters.seed) measures the errors, the others may become
  !> snapshots. If the deck adds no snapshots (no clusters.refine, or its max_points is 0), all usable candidates measure and count
  !> as open, too. Collective on all ranks.
  !>
  !> Errors: no candidate is usable.
  subroutine share_candidates(problem, candidates, attempt, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: candidates
    !> in: its snapshots; out: also is_measure and is_open
    type(attempt_t), intent(inout) :: attempt
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(training_set_t) :: pool
    real(rk), allocatable :: lengths(:)
    integer :: i

    pool = take_snapshots(candidates, [(i, i=1, size(candidates%reasons))])
    PetscCall(snapshot_lengths(pool, PETSC_COMM_WORLD, lengths, ierr))
    associate (clusters => problem%deck%clusters)
      attempt%is_open = usable_candidates(candidates, lengths, attempt%snapshots%parameters)
      attempt%is_measure = attempt%is_open
      if (.not. any(attempt%is_measure)) call make_error(error, 'no candidate can measure the error: each of the ' // &
        to_text(size(attempt%is_open)) // ' is a training point, causes no displacement, or has no full-order solution', &
        problem%deck%path, clusters%target%candidates%line, clusters%target%candidates%column)
      if (.not. clusters%refine%is_used .or. clusters%refine%max_points == 0) return
      attempt%is_measure = draw_half(attempt%is_open, clusters%seed)
      attempt%is_open = attempt%is_open .and. .not. attempt%is_measure
    end associate
  end subroutine share_candidates

  !> Divides the snapshots into n_clusters clusters, trains the model, and measures its errors at the candidates of is_measure and
  !> is_open. Collective on all ranks.
  !>
  !> Errors: those of divide_snapshots and train_attempt.
  subroutine start_attempt(problem, candidates, fallback, n_clusters, attempt, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: candidates
    !> the model gets a copy; not allocated: the model has none
    class(reduced_t), allocatable, intent(in) :: fallback
    !> as in divide_snapshots; 0: it chooses the number
    integer, intent(in) :: n_clusters
    !> in: its snapshots, is_measure and is_open; out: all the rest, too
    type(attempt_t), intent(inout) :: attempt
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    class(reduced_t), allocatable :: own
    type(model_t) :: model
    integer :: k

    call fill_model_header(problem, attempt%snapshots, model)
    PetscCall(divide_snapshots(problem%deck, n_clusters, attempt%snapshots, model, attempt%division%clusters, error, ierr))
    if (allocated(error)) return
    if (allocated(fallback)) allocate (own, source=fallback) ! an assignment would share its arrays (gfortran 12)
    call set_fallback(model, own)
    attempt%division%choice = model%choice
    attempt%division%n_labeled = attempt%snapshots%n_snapshots()
    attempt%model = model
    if (allocated(attempt%models)) deallocate (attempt%models)
    allocate (attempt%models(0))
    PetscCall(train_attempt(problem, candidates, [(k, k=1, size(attempt%division%clusters))], attempt, error, ierr))
  end subroutine start_attempt

  !> Trains the clusters `which`, keeps the local models of all others, and measures the errors of the whole model at the candidates
  !> of is_measure and is_open. Collective on all ranks.
  !>
  !> Errors: a cluster cannot be trained; the model cannot answer.
  subroutine train_attempt(problem, candidates, which, attempt, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: candidates
    !> numbers of the clusters whose snapshots are new, 1-based
    integer, intent(in) :: which(:)
    !> in: snapshots, division, local models of the other clusters, is_measure, is_open; out: all local models, the model, its
    !> errors
    type(attempt_t), intent(inout) :: attempt
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    character(:), allocatable :: message
    type(hhr_data_t), allocatable :: models(:)
    integer :: k

    allocate (models(size(attempt%division%clusters)))
    do k = 1, size(attempt%models)
      models(k) = attempt%models(k)
    end do
    PetscCall(train_clusters(problem, attempt%snapshots, attempt%division%clusters, which, models, error, ierr))
    if (allocated(error)) return
    call move_alloc(models, attempt%models)
    call set_clusters(attempt%model, attempt%models)
    attempt%model%training_points = attempt%snapshots%parameters
    attempt%model%choice = attempt%division%choice
    call fill_start_sets(attempt%model)
    associate (measure => problem%deck%clusters%target%measure)
      call measure_candidates(candidates, attempt%is_measure .or. attempt%is_open, attempt%model, measure, attempt%errors, message)
      if (allocated(message)) call make_error(error, message, problem%deck%path)
      if (measure /= 'e_u' .or. allocated(message)) return
    end associate
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, attempt%errors%squares, ierr))
    call finish_displacement_errors(candidates, attempt%errors)
  end subroutine train_attempt

  !> [-] Returns the errors at the candidates of is_measure, in their order; infinite and NaN as in pool_errors_t.
  pure function measured(self) result(values)
    class(attempt_t), intent(in) :: self
    real(rk), allocatable :: values(:)

    values = pack(self%errors%values, self%is_measure)
  end function measured

  !> Returns the errors at the candidates of is_open; all others count as not measured.
  pure function open_errors(self) result(errors)
    class(attempt_t), intent(in) :: self
    type(pool_errors_t) :: errors

    errors = errors_among(self%errors, self%is_open)
  end function open_errors
end module sig_model_attempt
