! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> What a greedy selection leaves in the results folder: the table of its choices and the snapshots in their order.
module sig_greedy_record
  use sig_checksum, only: fnv1a, fnv1a_seed, hash_digits
  use sig_deck_config, only: deck_config_t
  use sig_deck_echo, only: reduction_section
  use sig_deck_echo_words, only: count_or_word, tolerance_or_none
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t, make_error
  use sig_greedy_rules, only: box_of
  use sig_kinds, only: rk
  use sig_parameter_space, only: build_points
  use sig_problem, only: parameter_names, problem_t
  use sig_selection, only: read_selection, selection_t, write_selection
  use sig_snapshot_merge, only: find_finished_points, snapshot_store, store_t
  use sig_text, only: to_text
  use petsc
  implicit none(type, external)
  private
  public :: begin_selection, is_complete, keep_selection, training_points

contains

  pure function selection_path(folder) result(path)
    character(*), intent(in) :: folder
    character(:), allocatable :: path

    path = folder // '/selection.csv'
  end function selection_path

  !> `projection, tolerance none, max_points 200`
  pure function rule_of(deck) result(rule)
    type(deck_config_t), intent(in) :: deck
    character(:), allocatable :: rule

    rule = 'by ' // deck%greedy%indicator // ', tolerance ' // tolerance_or_none(deck%greedy%tolerance) // ', max_points ' // &
      count_or_word(deck%greedy%max_points, huge(1), 'none')
  end function rule_of

  !> Hash of all that decides about the choice, but for its end.
  function settings_of(problem, candidates) result(settings)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: candidates(:, :)
    character(16) :: settings
    character(:), allocatable :: text

    associate (greedy => problem%deck%greedy)
      text = problem%provenance // ' ' // greedy%indicator // ' ' // to_text(greedy%n_initial) // ' '
      if (greedy%indicator == 'projection') then
        text = text // problem%deck%reduction%dirichlet
      else
        ! with multigrid the defect is another one
        text = text // to_text(greedy%batch) // ' ' // problem%plan%linear // ' ' // reduction_section(problem%deck%reduction)
      end if
    end associate
    settings = hash_digits(fnv1a(text, fnv1a(candidates, fnv1a(box_of(problem%deck), fnv1a_seed))))
  end function settings_of

  !> What an earlier run has chosen, perhaps nothing. Local; the same on all ranks.
  !>
  !> Errors: a table that cannot be read.
  subroutine begin_selection(problem, candidates, folder, selection, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    character(*), intent(in) :: folder
    type(selection_t), intent(out) :: selection
    type(error_t), allocatable, intent(out) :: error

    call read_selection(selection_path(folder), settings_of(problem, candidates), rule_of(problem%deck), size(candidates, 1), &
      selection, error)
  end subroutine begin_selection

  !> Nothing is left to do: the end is reached, and all snapshots are there. Collective on all ranks.
  subroutine is_complete(problem, folder, selection, is_done, error, ierr)
    type(problem_t), intent(in) :: problem
    character(*), intent(in) :: folder
    type(selection_t), intent(in) :: selection
    logical, intent(out) :: is_done
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    logical, allocatable :: is_solved(:)
    logical :: is_merged

    ierr = 0
    is_done = .false.
    if (selection%stopped_by == '') return
    PetscCall(find_finished_points(problem, store_t(folder, snapshot_store), selection%points, is_solved, is_merged, error, ierr))
    is_done = is_merged
  end subroutine is_complete

  !> Replaces selection.csv. Collective on all ranks.
  subroutine keep_selection(problem, folder, selection, is_writer, error, ierr)
    type(problem_t), intent(in) :: problem
    character(*), intent(in) :: folder
    type(selection_t), intent(in) :: selection
    logical, intent(in) :: is_writer
    type(error_t), allocatable, intent(inout) :: error
    PetscErrorCode, intent(out) :: ierr

    if (is_writer .and. .not. allocated(error)) &
      call write_selection(selection_path(folder), parameter_names(problem%deck), selection, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
  end subroutine keep_selection

  !> The points that the deck trains on: its set, or what a selection has chosen. Local.
  !>
  !> Errors: those of build_points; a selection that is missing or not finished.
  subroutine training_points(problem, folder, points, selection, error)
    type(problem_t), intent(in) :: problem
    character(*), intent(in) :: folder
    !> shape (n_parameters, n_points)
    real(rk), allocatable, intent(out) :: points(:, :)
    !> without points where the deck has a set
    type(selection_t), intent(out) :: selection
    type(error_t), allocatable, intent(out) :: error

    call build_points(problem%deck%training, problem%deck%parameters, points, error)
    if (allocated(error) .or. .not. problem%deck%greedy%is_used) return
    call begin_selection(problem, points, folder, selection, error)
    if (allocated(error)) return
    if (selection%stopped_by == '') call make_error(error, 'there is no finished selection of training points for this deck', &
      selection_path(folder), hint='run first: signorom sample ' // problem%deck%path)
    points = selection%points
  end subroutine training_points
end module sig_greedy_record
