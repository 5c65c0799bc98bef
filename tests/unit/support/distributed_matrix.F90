! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Distributed matrices as replicated dense ones, so that tests compare them entry by entry.
module distributed_matrix
  use mpi, only: MPI_Allreduce, MPI_DOUBLE_PRECISION, MPI_IN_PLACE, MPI_SUM
  use sig_dof_map, only: dof_map_t
  use sig_kinds, only: rk
  use petsc
  implicit none(type, external)
  private
  public :: gather_matrix

contains

  !> Entries in natural numbering on every rank. Collective on comm.
  subroutine gather_matrix(comm, map, matrix, dense, ierr)
    MPI_Comm, intent(in) :: comm
    type(dof_map_t), intent(in) :: map
    Mat, intent(in) :: matrix
    !> shape (n_dofs, n_dofs)
    real(rk), allocatable, intent(out) :: dense(:, :)
    PetscErrorCode, intent(out) :: ierr
    PetscScalar, pointer :: values(:)
    Vec :: unit, column
    integer :: j

    allocate (dense(map%n_dofs, map%n_dofs), source=0.0_rk)
    PetscCall(VecCreateMPI(comm, map%n_local_dofs, PETSC_DETERMINE, unit, ierr))
    PetscCall(VecDuplicate(unit, column, ierr))
    do j = 1, map%n_dofs
      PetscCall(VecGetArrayF90(unit, values, ierr))
      values = merge(1.0_rk, 0.0_rk, map%local_dofs == j)
      PetscCall(VecRestoreArrayF90(unit, values, ierr))
      PetscCall(MatMult(matrix, unit, column, ierr))
      PetscCall(VecGetArrayReadF90(column, values, ierr))
      dense(map%local_dofs, j) = values
      PetscCall(VecRestoreArrayReadF90(column, values, ierr))
    end do
    PetscCall(VecDestroy(unit, ierr))
    PetscCall(VecDestroy(column, ierr))
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, dense, size(dense), MPI_DOUBLE_PRECISION, MPI_SUM, comm, ierr))
  end subroutine gather_matrix
end module distributed_matrix
