! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Loads the mesh of a deck on every rank.
module sig_mesh_load
  use mpi, only: MPI_Comm_rank
  use sig_deck_config, only: mesh_config_t
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  use sig_mesh, only: mesh_t
  use sig_mesh_axis, only: check_radii
  use sig_mesh_broadcast, only: broadcast_mesh
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
end module sig_mesh_load
