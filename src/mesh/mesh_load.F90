! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Loads the mesh of a deck on every rank.
module sig_mesh_load
  use mpi, only: MPI_Bcast, MPI_Comm_rank, MPI_DOUBLE_PRECISION, MPI_INTEGER
  use sig_deck_config, only: mesh_config_t
  use sig_error_broadcast, only: broadcast_error, broadcast_text
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  use sig_mesh, only: mesh_t
  use sig_mesh_axis, only: check_radii
  use sig_mesh_file, only: unreadable_mesh
  use sig_mesh_read, only: read_mesh
  use petsc
  implicit none(type, external)
  private
  public :: load_mesh

contains

  !> Loads the mesh: rank 0 reads and checks it, and all ranks get the mesh or the error. Errors: those of read_mesh, and in an
  !> axisymmetric model those of check_radii; then `mesh` must not be used. Collective on comm.
  subroutine load_mesh(config, deck_path, length_factor, comm, mesh, error, ierr)
    !> section mesh of the deck
    type(mesh_config_t), intent(in) :: config
    !> for messages
    character(*), intent(in) :: deck_path
    !> factor for all coordinates [units.length / mesh.length_unit]
    real(rk), intent(in) :: length_factor
    MPI_Comm, intent(in) :: comm
    type(mesh_t), intent(out) :: mesh
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(mechanical_model_t) :: model
    integer :: rank

    model = mechanical_model(config%model)
    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    work: if (rank == 0) then
      call read_mesh(config%path, model%n_dim, length_factor, mesh, error)
      if (allocated(error)) call blame_deck(config, deck_path, error)
      if (allocated(error)) exit work
      if (model%is_round) call check_radii(mesh, config%path, error)
    end if work
    PetscCall(broadcast_error(error, comm, ierr))
    if (allocated(error)) return
    PetscCall(broadcast_mesh(mesh, comm, ierr))
  end subroutine load_mesh

  !> Sets file, line and column of an error to the place in the deck that names the mesh file, if the error says that this file
  !> cannot be read (unreadable_mesh). Another error stays as it is.
  subroutine blame_deck(config, deck_path, error)
    type(mesh_config_t), intent(in) :: config
    character(*), intent(in) :: deck_path
    type(error_t), intent(inout) :: error

    if (index(error%message, unreadable_mesh) /= 1) return
    error%file = deck_path
    error%line = config%line
    error%column = config%column
  end subroutine blame_deck

  !> Sends the mesh of rank 0 to all other ranks, whose own mesh is replaced. Collective on comm.
  subroutine broadcast_mesh(mesh, comm, ierr)
    type(mesh_t), intent(inout) :: mesh
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    character(:), allocatable :: hash
    integer :: sizes(4)

    sizes = [mesh%n_dim, mesh%n_nodes, mesh%n_cells, mesh%n_facets]
    PetscCallMPI(MPI_Bcast(sizes, size(sizes), MPI_INTEGER, 0, comm, ierr))
    mesh%n_dim = sizes(1)
    mesh%n_nodes = sizes(2)
    mesh%n_cells = sizes(3)
    mesh%n_facets = sizes(4)
    PetscCall(broadcast_coordinates(mesh, comm, ierr))
    PetscCall(broadcast_integers(mesh%node_tags, comm, ierr))
    PetscCall(broadcast_integers(mesh%cell_types, comm, ierr))
    PetscCall(broadcast_integers(mesh%cell_offsets, comm, ierr))
    PetscCall(broadcast_integers(mesh%cell_nodes, comm, ierr))
    PetscCall(broadcast_integers(mesh%cell_tags, comm, ierr))
    PetscCall(broadcast_integers(mesh%facet_types, comm, ierr))
    PetscCall(broadcast_integers(mesh%facet_offsets, comm, ierr))
    PetscCall(broadcast_integers(mesh%facet_nodes, comm, ierr))
    PetscCall(broadcast_groups(mesh, comm, ierr))
    PetscCall(broadcast_notes(mesh, comm, ierr))
    hash = mesh%file_hash
    PetscCall(broadcast_text(hash, comm, ierr))
    mesh%file_hash = hash
  end subroutine broadcast_mesh

  subroutine broadcast_coordinates(mesh, comm, ierr)
    type(mesh_t), intent(inout) :: mesh
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: rank

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    if (rank /= 0) then
      if (allocated(mesh%coordinates)) deallocate (mesh%coordinates)
      allocate (mesh%coordinates(mesh%n_dim, mesh%n_nodes))
    end if
    PetscCallMPI(MPI_Bcast(mesh%coordinates, size(mesh%coordinates), MPI_DOUBLE_PRECISION, 0, comm, ierr))
  end subroutine broadcast_coordinates

  subroutine broadcast_groups(mesh, comm, ierr)
    type(mesh_t), intent(inout) :: mesh
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: i_group, rank, n_groups

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    n_groups = 0
    if (allocated(mesh%groups)) n_groups = size(mesh%groups)
    PetscCallMPI(MPI_Bcast(n_groups, 1, MPI_INTEGER, 0, comm, ierr))
    if (rank /= 0) then
      if (allocated(mesh%groups)) deallocate (mesh%groups)
      allocate (mesh%groups(n_groups))
    end if
    do i_group = 1, n_groups
      PetscCall(broadcast_text(mesh%groups(i_group)%name, comm, ierr))
      PetscCallMPI(MPI_Bcast(mesh%groups(i_group)%n_dim, 1, MPI_INTEGER, 0, comm, ierr))
      PetscCallMPI(MPI_Bcast(mesh%groups(i_group)%n_left_out, 1, MPI_INTEGER, 0, comm, ierr))
      PetscCall(broadcast_integers(mesh%groups(i_group)%entities, comm, ierr))
      PetscCall(broadcast_integers(mesh%groups(i_group)%nodes, comm, ierr))
    end do
  end subroutine broadcast_groups

  subroutine broadcast_notes(mesh, comm, ierr)
    type(mesh_t), intent(inout) :: mesh
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: i, n_notes, rank

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    if (.not. allocated(mesh%notes)) allocate (mesh%notes(0))
    n_notes = size(mesh%notes)
    PetscCallMPI(MPI_Bcast(n_notes, 1, MPI_INTEGER, 0, comm, ierr))
    if (rank /= 0) then
      deallocate (mesh%notes)
      allocate (mesh%notes(n_notes))
    end if
    do i = 1, n_notes
      PetscCall(broadcast_text(mesh%notes(i)%text, comm, ierr))
    end do
  end subroutine broadcast_notes

  !> Sends an array of rank 0 to all other ranks, where it replaces `values`. If it is not allocated on rank 0, it is then not
  !> allocated on any rank. Collective on comm.
  subroutine broadcast_integers(values, comm, ierr)
    integer, allocatable, intent(inout) :: values(:)
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: rank, n_values

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    n_values = -1
    if (allocated(values)) n_values = size(values)
    PetscCallMPI(MPI_Bcast(n_values, 1, MPI_INTEGER, 0, comm, ierr))
    if (rank /= 0 .and. allocated(values)) deallocate (values)
    if (n_values < 0) return
    if (rank /= 0) allocate (values(n_values))
    PetscCallMPI(MPI_Bcast(values, n_values, MPI_INTEGER, 0, comm, ierr))
  end subroutine broadcast_integers
end module sig_mesh_load
