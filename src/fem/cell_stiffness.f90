! SPDX-License-Identifier: BSD-3-Clause
!> Computes the stiffness of single cells of a mesh, for the assembly and for the reduced integration domain.
module sig_cell_stiffness
  use sig_elastic_body, only: elastic_body_t
  use sig_element_matrices, only: element_stiffness
  use sig_flow_strains, only: strain_matrices, tangent_stiffness
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t, nodes_of_cell
  implicit none(type, external)
  private
  public :: cell_stiffness, cell_dofs

contains

  !> Returns the dofs of a cell in natural numbering, node by node.
  pure function cell_dofs(mesh, i_cell) result(dofs)
    type(mesh_t), intent(in) :: mesh
    !> 1-based
    integer, intent(in) :: i_cell
    !> shape (n_dim * number of nodes of the cell)
    integer, allocatable :: dofs(:)
    integer, allocatable :: nodes(:)
    integer :: i_component

    nodes = nodes_of_cell(mesh, i_cell)
    allocate (dofs(mesh%n_dim * size(nodes)))
    do i_component = 1, mesh%n_dim
      dofs(i_component::mesh%n_dim) = mesh%n_dim * (nodes - 1) + i_component
    end do
  end function cell_dofs

  !> Returns the stiffness matrix of one cell. Rows and columns are ordered as in cell_dofs.
  function cell_stiffness(mesh, body, i_cell) result(stiffness)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: i_cell
    !> [force/length, force/length**2 in the plane] symmetric
    real(rk), allocatable :: stiffness(:, :)

    real(rk), allocatable :: strains(:, :, :), volumes(:)

    if (body%flows_in(i_cell)) then
      call strain_matrices(mesh, body, i_cell, strains, volumes)
      associate (hooke => body%stress_matrix(:, :, body%material_of_cell(i_cell)))
        stiffness = tangent_stiffness(strains, volumes, spread(hooke, 3, size(volumes)))
      end associate
    else
      stiffness = element_stiffness(body%mechanics, body%tables(mesh%cell_types(i_cell)), &
        mesh%coordinates(:, nodes_of_cell(mesh, i_cell)), body%hooke(:, :, body%material_of_cell(i_cell)))
    end if
  end function cell_stiffness
end module sig_cell_stiffness
