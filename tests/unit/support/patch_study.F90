! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The contact patch test of tests/integration/decks/patch.yaml and its solution by formula.
module patch_study
  use sig_contact_state, only: contact_state_t
  use sig_deck_config, only: deck_config_t
  use sig_deck_read, only: read_deck
  use sig_errors, only: error_list_t, error_t, make_error
  use sig_file_system, only: read_text_file
  use sig_kinds, only: rk
  use sig_petsc_support, only: rows_of_rank
  use sig_problem, only: parameter_names, problem_t
  use sig_problem_loading, only: load_problem
  use sig_reasons, only: reason_converged
  use sig_snapshot_store, only: snapshot_set_t
  use petsc
  implicit none(type, external)
  private
  public :: read_patch, load_patch, patch_state, patch_snapshots, patch_modulus, patch_gap, spread_rows

  !> [Pa] and [m] of the deck and its mesh
  real(rk), parameter :: patch_modulus = 2.0e6_rk
  real(rk), parameter :: patch_gap = 0.01_rk

contains

  !> The deck with one piece of its text replaced (both empty: as it is). Local.
  subroutine read_patch(source_dir, old, new, deck, error)
    character(*), intent(in) :: source_dir
    character(*), intent(in) :: old, new
    type(deck_config_t), intent(out) :: deck
    type(error_t), allocatable, intent(out) :: error
    type(error_list_t) :: errors
    character(:), allocatable :: path, text
    integer :: i

    path = source_dir // '/tests/integration/decks/patch.yaml'
    call read_text_file(path, text, error)
    if (allocated(error)) return
    ! tests have sections of their own
    text = text(:index(text, 'reduction:') - 1)
    i = index(text, old)
    if (i == 0) then
      call make_error(error, 'the deck of the test has no "' // old // '"')
      return
    end if
    text = text(:i - 1) // new // text(i + len(old):)
    call read_deck(path, text, deck, errors)
    if (errors%n_errors() > 0) error = errors%errors(1)
  end subroutine read_patch

  !> Collective on comm.
  subroutine load_patch(source_dir, old, new, comm, problem, error, ierr)
    character(*), intent(in) :: source_dir
    character(*), intent(in) :: old, new
    MPI_Comm, intent(in) :: comm
    type(problem_t), intent(out) :: problem
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(deck_config_t) :: deck

    ierr = 0
    call read_patch(source_dir, old, new, deck, error)
    if (allocated(error)) return
    PetscCall(load_problem(deck, comm, problem, error, ierr))
  end subroutine load_patch

  !> Pressure p = E (push - gap) / 2: u_y = -p y / E below, -push + p (2.01 - y) / E above; forces p h, and p h / 2 at the ends.
  function patch_state(problem, push) result(state)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: push
    type(contact_state_t) :: state
    !> [m] between the nodes of a face, and for "at an end"
    real(rk), parameter :: spacing = 0.25_rk, close = 1.0e-6_rk
    real(rk) :: strain

    strain = max(0.0_rk, push - patch_gap) / 2
    associate (y => problem%mesh%coordinates(2, :), x => problem%mesh%coordinates(1, problem%rows%owners()))
      allocate (state%displacement(2 * problem%mesh%n_nodes), source=0.0_rk)
      state%displacement(2::2) = merge(-strain * y, strain * (2 + patch_gap - y) - push, y < 1 + patch_gap / 2)
      state%multipliers = patch_modulus * strain * spacing * merge(0.5_rk, 1.0_rk, x < close .or. x > 1 - close)
    end associate
    state%is_active = state%multipliers > 0
    state%reason = reason_converged
  end function patch_state

  !> Snapshots at these pushes by the formulas, spread over all ranks.
  subroutine patch_snapshots(problem, pushes, set)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: pushes(:)
    type(snapshot_set_t), intent(out) :: set
    type(contact_state_t) :: state
    integer :: i, ierr, n_dofs

    n_dofs = 2 * problem%mesh%n_nodes
    set%provenance = problem%provenance
    set%parameter_names = parameter_names(problem%deck)
    set%parameters = reshape(pushes, [1, size(pushes)])
    allocate (set%displacement(n_dofs, size(pushes)), set%multipliers(problem%rows%n_rows, size(pushes)))
    allocate (set%n_iterations(size(pushes)), source=1)
    allocate (set%reasons(size(pushes)), source=reason_converged)
    allocate (set%residuals(5, size(pushes)), set%seconds(size(pushes)), source=0.0_rk)
    do i = 1, size(pushes)
      state = patch_state(problem, pushes(i))
      set%displacement(:, i) = state%displacement
      set%multipliers(:, i) = state%multipliers
    end do
    set%term_texts = problem%terms%names
    ! without contact the upper block follows the push (term 2) as a whole
    allocate (set%free_response(n_dofs, 2), source=0.0_rk)
    set%free_response(2::2, 2) = merge(0.0_rk, 1.0_rk, problem%mesh%coordinates(2, :) < 1 + patch_gap / 2)
    call spread_rows(PETSC_COMM_WORLD, set, ierr)
  end subroutine patch_snapshots

  !> Of displacements that every rank has, each keeps its rows.
  subroutine spread_rows(comm, set, ierr)
    MPI_Comm, intent(in) :: comm
    type(snapshot_set_t), intent(inout) :: set
    PetscErrorCode, intent(out) :: ierr
    integer :: last

    set%n_dofs = size(set%displacement, 1)
    PetscCall(rows_of_rank(set%n_dofs, comm, set%first_dof, last, ierr))
    set%displacement = set%displacement(set%first_dof:last, :)
  end subroutine spread_rows
end module patch_study
