! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The model of the deck: trained once, or refined to a target error; with the full-order operator and the sets that queries need.
module sig_model_building
  use sig_errors, only: error_t, make_error
  use sig_file_system, only: file_exists
  use sig_full_order, only: full_order_t
  use sig_full_order_operator, only: condense_full_order
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_parameter_space, only: build_points
  use sig_problem, only: problem_t
  use sig_refinement, only: refine, refinement_result_t
  use sig_snapshot_merge, only: candidate_store, read_store, store_in, store_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_start_sets, only: fill_start_sets
  use sig_text, only: counted, to_text
  use sig_training, only: train
  use petsc
  implicit none(type, external)
  private
  public :: build_model

contains

  !> Collective on all ranks; the model is the same on each.
  !>
  !> Errors: those of the training; candidates of clusters.target that are not solved yet.
  subroutine build_model(full_order, folder, snapshots, model, refinement, error, ierr)
    !> loaded
    type(full_order_t), intent(inout) :: full_order
    !> results folder
    character(*), intent(in) :: folder
    type(snapshot_set_t), intent(in) :: snapshots
    type(model_t), intent(out) :: model
    !> without rounds where the deck has no target
    type(refinement_result_t), intent(out) :: refinement
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t) :: candidates

    ierr = 0
    allocate (refinement%rounds(0))
    if (full_order%problem%deck%clusters%target%is_used) then
      call read_candidates(full_order%problem, store_in(folder, candidate_store), candidates, error)
      if (allocated(error)) return
      ! its queries need it
      PetscCall(condense_full_order(full_order, model%full_order, ierr))
      PetscCall(refine(full_order%problem, snapshots, candidates, model, refinement, error, ierr))
    else
      PetscCall(train(full_order%problem, snapshots, model, error, ierr))
      if (allocated(error)) return
      PetscCall(condense_full_order(full_order, model%full_order, ierr))
      call fill_start_sets(model)
    end if
  end subroutine build_model

  !> Local; the same on all ranks.
  subroutine read_candidates(problem, store, candidates, error)
    type(problem_t), intent(in) :: problem
    type(store_t), intent(in) :: store
    type(snapshot_set_t), intent(out) :: candidates
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: hint
    real(rk), allocatable :: points(:, :)
    logical, allocatable :: is_missing(:)

    hint = 'run first: signorom sample ' // problem%deck%path
    if (.not. file_exists(store%path())) then
      call make_error(error, 'there are no solved candidates yet', store%path(), hint=hint)
      return
    end if
    call build_points(problem%deck%clusters%target%candidates, problem%deck%parameters, points, error)
    if (allocated(error)) return
    allocate (is_missing(size(points, 2)))
    call read_store(problem, store, points, candidates, is_missing, error)
    if (any(is_missing) .and. .not. allocated(error)) call make_error(error, 'the file lacks ' // to_text(count(is_missing)) // &
      ' of the ' // counted(size(is_missing), 'candidate') // ' of the deck', store%path(), hint=hint)
  end subroutine read_candidates
end module sig_model_building
