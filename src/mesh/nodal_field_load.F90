! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Loads the fields of a deck's imposed strains on every rank.
module sig_nodal_field_load
  use mpi, only: MPI_Bcast, MPI_Comm_rank, MPI_DOUBLE_PRECISION
  use sig_deck_config, only: imposed_strain_config_t
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_nodal_field, only: nodal_field_t, read_nodal_field
  use petsc
  implicit none(type, external)
  private
  public :: load_nodal_fields

contains

  !> Loads the fields: rank 0 reads and checks them, and all ranks get the fields or the error. Errors: those of read_nodal_field,
  !> for the first entry that has one; then `fields` is not complete. Collective on comm.
  subroutine load_nodal_fields(mesh, strains, deck_path, length_factor, comm, fields, error, ierr)
    type(mesh_t), intent(in) :: mesh
    !> section imposed_strains of the deck
    type(imposed_strain_config_t), intent(in) :: strains(:)
    !> for messages
    character(*), intent(in) :: deck_path
    !> factor for the coordinates of the files [units.length / mesh.length_unit]
    real(rk), intent(in) :: length_factor
    MPI_Comm, intent(in) :: comm
    !> one field per entry; its values are not allocated if the entry has no file
    type(nodal_field_t), allocatable, intent(out) :: fields(:)
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    integer :: i, rank

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    allocate (fields(size(strains)))
    do i = 1, size(strains)
      if (.not. strains(i)%has_field) cycle
      if (rank == 0) call read_nodal_field(mesh, strains(i), deck_path, fields(i), error, length_factor)
      PetscCall(broadcast_error(error, comm, ierr))
      if (allocated(error)) return
      if (rank /= 0) allocate (fields(i)%values(mesh%n_nodes))
      PetscCallMPI(MPI_Bcast(fields(i)%values, mesh%n_nodes, MPI_DOUBLE_PRECISION, 0, comm, ierr))
    end do
  end subroutine load_nodal_fields
end module sig_nodal_field_load
