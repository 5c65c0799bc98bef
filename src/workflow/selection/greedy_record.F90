! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Keeps a greedy selection in the results folder: reads and writes selection.csv, and finds out whether its snapshots are there.
module sig_greedy_record
  use sig_checksum, only: fnv1a, fnv1a_seed, hash_digits
  use sig_deck_box, only: names_of
  use sig_deck_config, only: deck_config_t
  use sig_deck_echo, only: reduction_section
  use sig_deck_echo_words, only: count_or_word, tolerance_or_none
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t, make_error
  use sig_greedy_rules, only: box_of
  use sig_kinds, only: rk
  use sig_parameter_space, only: build_points, find_states
  use sig_problem, only: problem_t
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

  !> Returns the indicator and the limits of the deck's selection as text: `by projection, tolerance none, max_points 200`.
  pure function rule_of(deck) result(rule)
    type(deck_config_t), intent(in) :: deck
    character(:), allocatable :: rule

    associate (greedy => deck%greedy, reduction => deck%reduction)
      rule = 'by ' // greedy%indicator // ', tolerance ' // tolerance_or_none(merge(reduction%inelastic_tolerance, &
        greedy%tolerance, greedy%indicator == 'audit')) // ', max_points ' // count_or_word(greedy%max_points, huge(1), 'none')
    end associate
  end function rule_of

  !> Returns a hash (hexadecimal) of all on which the choice depends, except for max_points and tolerance: the provenance (physics
  !> of the deck and mesh), the box, the candidates with all their states, greedy.indicator and greedy.initial; with indicator:
  !> projection also reduction.dirichlet, with the others also greedy.batch, the linear solver and the section reduction.
  function settings_of(problem, states) result(settings)
    type(problem_t), intent(in) :: problem
    !> of the candidates, shape (n_parameters, n_states)
    real(rk), intent(in) :: states(:, :)
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
    settings = hash_digits(fnv1a(text, fnv1a(states, fnv1a(box_of(problem%deck), fnv1a_seed))))
  end function settings_of

  !> Reads from selection.csv what an earlier run has chosen. If the file is missing, or its hash is not that of settings_of, the
  !> selection has no points and is not finished. If max_points or tolerance were others, or the earlier run did not reach the end,
  !> it has points and is not finished (stopped_by is empty). Local; the same on all ranks.
  !>
  !> Errors: selection.csv cannot be read, or a line is damaged; those of find_states.
  subroutine begin_selection(problem, candidates, folder, selection, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_candidates)
    real(rk), intent(in) :: candidates(:, :)
    !> results folder
    character(*), intent(in) :: folder
    type(selection_t), intent(out) :: selection
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: states(:, :)

    call find_states(problem%deck, candidates, states, error)
    if (allocated(error)) return
    call read_selection(selection_path(folder), settings_of(problem, states), rule_of(problem%deck), size(candidates, 1), &
      selection, error)
    if (problem%deck%greedy%indicator == 'audit') selection%error_name = 'error_stress'
  end subroutine begin_selection

  !> Finds out whether nothing is left to do: the selection is finished, all its points have converged, and there are no shards of
  !> snapshots. Collective on all ranks.
  !>
  !> Errors: if the selection is finished, those of find_finished_points.
  subroutine is_complete(problem, folder, selection, is_done, error, ierr)
    type(problem_t), intent(in) :: problem
    !> results folder
    character(*), intent(in) :: folder
    type(selection_t), intent(in) :: selection
    !> the same on all ranks
    logical, intent(out) :: is_done
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: states(:, :)
    logical, allocatable :: is_solved(:)
    logical :: is_merged

    ierr = 0
    is_done = .false.
    if (selection%stopped_by == '') return
    call find_states(problem%deck, selection%points, states, error)
    if (allocated(error)) return
    PetscCall(find_finished_points(problem, store_t(folder, snapshot_store), states, is_solved, is_merged, error, ierr))
    is_done = is_merged
  end subroutine is_complete

  !> Writes selection.csv anew, unless the writer has an error already. Afterwards all ranks have an error if any rank had one, or
  !> if the file cannot be written. Collective on all ranks.
  subroutine keep_selection(problem, folder, selection, is_writer, error, ierr)
    type(problem_t), intent(in) :: problem
    !> results folder
    character(*), intent(in) :: folder
    type(selection_t), intent(in) :: selection
    !> this rank writes; true on one rank
    logical, intent(in) :: is_writer
    type(error_t), allocatable, intent(inout) :: error
    PetscErrorCode, intent(out) :: ierr

    if (is_writer .and. .not. allocated(error)) &
      call write_selection(selection_path(folder), names_of(problem%deck%parameters), selection, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
  end subroutine keep_selection

  !> Finds the states of the training points: of those of the deck or, with a greedy selection, of those that it has chosen among
  !> them, in the order of the choice. Local; the same on all ranks.
  !>
  !> Errors: those of build_points and find_states; there is no finished selection with these settings and limits in selection.csv,
  !> or it cannot be read.
  subroutine training_points(problem, folder, states, selection, error)
    type(problem_t), intent(in) :: problem
    !> results folder
    character(*), intent(in) :: folder
    !> shape (n_parameters, n_states)
    real(rk), allocatable, intent(out) :: states(:, :)
    !> what is chosen; without a greedy selection in the deck its arrays are not allocated
    type(selection_t), intent(out) :: selection
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: points(:, :)

    call build_points(problem%deck%training, problem%deck%parameters, points, error)
    if (allocated(error)) return
    if (problem%deck%greedy%is_used) then
      call begin_selection(problem, points, folder, selection, error)
      if (allocated(error)) return
      if (selection%stopped_by == '') call make_error(error, 'there is no finished selection of training points for this deck', &
        selection_path(folder), hint='run first: signorom sample ' // problem%deck%path)
      if (allocated(error)) return
      points = selection%points
    end if
    call find_states(problem%deck, points, states, error)
  end subroutine training_points
end module sig_greedy_record
