! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The command init: writes a first deck for a mesh, with places to fill in.
module sig_init
  use mpi, only: MPI_Comm_rank
  use sig_command_line, only: command_t
  use sig_deck_draft, only: draft_deck, drafted_model
  use sig_deck_unfilled, only: placeholder
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_report, error_t, exit_success, make_error
  use sig_facing_groups, only: facing_groups_t, find_facing_groups
  use sig_file_system, only: base_name, file_exists, write_text_file
  use sig_guessed_contacts, only: try_contacts
  use sig_kinds, only: rk
  use sig_log, only: log_error, log_info
  use sig_mesh, only: mesh_t
  use sig_mesh_read, only: read_mesh
  use sig_region_cover, only: choose_regions, find_shared_nodes, shared_nodes_t
  use sig_text, only: counted, string_t
  use petsc
  implicit none(type, external)
  private
  public :: init_deck

contains

  !> Writes a first deck in the folder of the mesh that the command names. Rank 0 does the work. Collective on all ranks, which all
  !> get the exit code.
  !>
  !> Errors are printed and give the exit code: those of read_mesh; the deck exists already or cannot be written.
  subroutine init_deck(command, exit_code, ierr)
    type(command_t), intent(in) :: command
    integer, intent(out) :: exit_code
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: error
    integer :: rank

    call MPI_Comm_rank(PETSC_COMM_WORLD, rank, ierr)
    if (rank == 0) call write_draft(command%file, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    exit_code = exit_success
    if (.not. allocated(error)) return
    call log_error(error_report(error))
    exit_code = error%exit_code
  end subroutine init_deck

  !> Writes the deck beside the mesh, with the name of the mesh and the ending .yaml, and logs its path and the numbers of regions
  !> and guessed contacts. Errors: those of read_mesh; the deck exists already or cannot be written.
  subroutine write_draft(mesh_path, error)
    character(*), intent(in) :: mesh_path
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: deck_path, mesh_file
    type(mesh_t) :: mesh
    type(facing_groups_t), allocatable :: pairs(:)
    type(shared_nodes_t), allocatable :: shared(:)
    type(string_t), allocatable :: why_not(:)
    integer, allocatable :: regions(:)
    integer :: i

    mesh_file = mesh_path(index(mesh_path, '/', back=.true.) + 1:)
    deck_path = mesh_path(:len(mesh_path) - len(mesh_file)) // base_name(mesh_path) // '.yaml'
    if (file_exists(deck_path)) then
      call make_error(error, 'this deck exists already; init does not overwrite it', deck_path)
      return
    end if
    call read_mesh(mesh_path, 0, 1.0_rk, mesh, error)
    if (allocated(error)) return
    call find_facing_groups(mesh, pairs)
    call try_contacts(mesh, drafted_model(mesh), pairs, why_not)
    call write_text_file(deck_path, draft_deck(mesh, mesh_file, deck_path, pairs, why_not), error)
    if (allocated(error)) return
    regions = choose_regions(mesh)
    call log_info(deck_path // ': ' // counted(size(regions), 'region') // ', ' // &
      counted(count([(len(why_not(i)%text) == 0, i=1, size(pairs))]), 'contact') // &
      ' guessed. Replace every ' // placeholder // ' and ask: signorom check ' // deck_path)
    do i = 1, size(mesh%notes)
      call log_info('note: ' // mesh%notes(i)%text)
    end do
    call find_shared_nodes(mesh, regions, shared)
    if (size(shared) > 0) call log_info('note: ' // counted(size(shared), 'pair') // ' of regions ' // &
      trim(merge('shares', 'share ', size(shared) == 1)) // ' nodes, so that they cannot part; the deck says which, ' // &
      'and how to split them')
  end subroutine write_draft
end module sig_init
