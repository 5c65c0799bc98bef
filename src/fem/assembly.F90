! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Assembles the stiffness matrix K of (3) on all dofs. The solvers take care of prescribed displacements.
module sig_assembly
  use sig_cell_stiffness, only: cell_dofs, cell_stiffness
  use sig_dof_map, only: dof_map_t
  use sig_elastic_body, only: elastic_body_t
  use sig_flowing_cells, only: flowing_cells_t
  use sig_kinds, only: rk
  use sig_mesh, only: cells_around_nodes, mesh_t, nodes_of_cell
  use sig_petsc_support, only: create_matrix
  use petsc
  implicit none(type, external)
  private
  public :: add_cells, add_tangents, assemble_stiffness, fill_stiffness

contains

  !> Creates K, with rows distributed over the ranks as `map` says. It has all dofs, the prescribed ones too. Each rank computes the
  !> cells that it owns. Collective on comm.
  subroutine assemble_stiffness(comm, mesh, body, map, stiffness, ierr)
    MPI_Comm, intent(in) :: comm
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(dof_map_t), intent(in) :: map
    !> symmetric, block size n_dim; the caller destroys it
    Mat, intent(out) :: stiffness
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: inside(:), outside(:)

    call count_neighbors(mesh, map, inside, outside)
    PetscCall(create_matrix(comm, map%n_local_dofs, map%n_dim, inside, outside, stiffness, ierr))
    PetscCall(fill_stiffness(mesh, body, map, stiffness, ierr))
  end subroutine assemble_stiffness

  !> Adds the stiffness of all cells, each rank that of its own cells, to a matrix with the pattern of assemble_stiffness and
  !> completes its assembly. To replace old values, the caller sets them to zero before. Collective.
  subroutine fill_stiffness(mesh, body, map, stiffness, ierr)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(dof_map_t), intent(in) :: map
    !> in: matrix of assemble_stiffness; out: with the added values
    Mat, intent(inout) :: stiffness
    PetscErrorCode, intent(out) :: ierr

    PetscCall(add_cells(mesh, body, map, map%own_cells, stiffness, ierr))
  end subroutine fill_stiffness

  !> Does the same as fill_stiffness for some cells. Collective.
  subroutine add_cells(mesh, body, map, cells, stiffness, ierr)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(dof_map_t), intent(in) :: map
    !> cells of this rank, 1-based
    integer, intent(in) :: cells(:)
    Mat, intent(inout) :: stiffness
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: dofs_0(:)
    real(rk), allocatable :: local(:, :)
    integer :: i

    ierr = 0
    do i = 1, size(cells)
      dofs_0 = map%distributed_0(cell_dofs(mesh, cells(i)))
      local = cell_stiffness(mesh, body, cells(i))
      PetscCall(MatSetValues(stiffness, size(dofs_0), dofs_0, size(dofs_0), dofs_0, local, ADD_VALUES, ierr))
    end do
    PetscCall(finish(stiffness, ierr))
  end subroutine add_cells

  !> Adds the tangent stiffness of the flowing cells to a matrix with the pattern of assemble_stiffness, and their forces of
  !> tangent_of_cell to a vector. Collective.
  subroutine add_tangents(mesh, body, map, flowing, stiffness, forces, ierr)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(dof_map_t), intent(in) :: map
    !> those of this rank, after evaluate
    type(flowing_cells_t), intent(in) :: flowing
    Mat, intent(inout) :: stiffness
    !> [force] grows by what the cells of this rank add; natural, shape (n_dofs)
    real(rk), intent(inout) :: forces(:)
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: dofs(:), dofs_0(:)
    real(rk), allocatable :: local(:, :), own(:)
    integer :: i

    ierr = 0
    do i = 1, size(flowing%cells)
      dofs = cell_dofs(mesh, flowing%cells(i))
      dofs_0 = map%distributed_0(dofs)
      call flowing%tangent_of_cell(mesh, body, i, local, own)
      forces(dofs) = forces(dofs) + own
      PetscCall(MatSetValues(stiffness, size(dofs_0), dofs_0, size(dofs_0), dofs_0, local, ADD_VALUES, ierr))
    end do
    PetscCall(finish(stiffness, ierr))
  end subroutine add_tangents

  subroutine finish(stiffness, ierr)
    Mat, intent(inout) :: stiffness
    PetscErrorCode, intent(out) :: ierr

    PetscCall(MatAssemblyBegin(stiffness, MAT_FINAL_ASSEMBLY, ierr))
    PetscCall(MatAssemblyEnd(stiffness, MAT_FINAL_ASSEMBLY, ierr))
    PetscCall(MatSetOption(stiffness, MAT_SYMMETRIC, PETSC_TRUE, ierr))
  end subroutine finish

  !> Counts for each owned node the nodes that share a cell with it, itself included. This gives the exact preallocation.
  subroutine count_neighbors(mesh, map, inside, outside)
    type(mesh_t), intent(in) :: mesh
    type(dof_map_t), intent(in) :: map
    !> numbers of those that this rank owns, and of those of other ranks, for each owned node in the order of map%local_dofs; shape
    !> (number of owned nodes)
    integer, allocatable, intent(out) :: inside(:)
    integer, allocatable, intent(out) :: outside(:)
    integer, allocatable :: offsets(:), cells(:), seen_by(:), nodes(:)
    integer :: i, i_local, i_node, n

    call cells_around_nodes(mesh, offsets, cells)
    allocate (inside(map%n_local_dofs / map%n_dim), outside(map%n_local_dofs / map%n_dim), source=0)
    allocate (seen_by(mesh%n_nodes), source=0)
    do i_local = 1, size(inside)
      i_node = (map%local_dofs(map%n_dim * i_local) - 1) / map%n_dim + 1
      do i = offsets(i_node) + 1, offsets(i_node + 1)
        nodes = nodes_of_cell(mesh, cells(i))
        do n = 1, size(nodes)
          if (seen_by(nodes(n)) == i_node) cycle
          seen_by(nodes(n)) = i_node
          if (map%local_index(map%n_dim * nodes(n)) > 0) then
            inside(i_local) = inside(i_local) + 1
          else
            outside(i_local) = outside(i_local) + 1
          end if
        end do
      end do
    end do
  end subroutine count_neighbors
end module sig_assembly
