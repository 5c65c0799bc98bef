! SPDX-License-Identifier: BSD-3-Clause
!> Writes the cells of a mesh into an HDF5 file, in the types and node order that viewers expect.
module sig_field_topology
  use sig_element_types, only: element_types, n_output_nodes
  use sig_hdf5_writer, only: h5_writer_t
  use sig_mesh, only: mesh_t, nodes_of_cell
  use sig_xdmf, only: xdmf_mesh_t
  implicit none(type, external)
  private
  public :: write_topology

contains

  !> Writes /mesh/cell_types and, if there are cells, /mesh/topology: a matrix with the nodes of a cell in each column if all cells
  !> have one type, else the list of mixed_topology. Local. The writer keeps a failure until `file` is closed.
  subroutine write_topology(mesh, file, described)
    type(mesh_t), intent(in) :: mesh
    type(h5_writer_t), intent(inout) :: file
    !> sizes and type of the cells for the XDMF file
    type(xdmf_mesh_t), intent(out) :: described
    integer, allocatable :: uniform(:, :)
    integer :: i_cell

    described = xdmf_mesh_t(n_nodes=mesh%n_nodes, n_cells=mesh%n_cells)
    call file%write('/mesh/cell_types', [(element_types(mesh%cell_types(i_cell))%xdmf_type, i_cell=1, mesh%n_cells)], &
      '-', 'XDMF number of the type of each cell')
    if (mesh%n_cells == 0) return
    if (all(mesh%cell_types == mesh%cell_types(1))) then
      described%cell_type = element_types(mesh%cell_types(1))%xdmf_type
      described%n_cell_nodes = n_output_nodes(mesh%cell_types(1))
      allocate (uniform(described%n_cell_nodes, mesh%n_cells))
      do i_cell = 1, mesh%n_cells
        uniform(:, i_cell) = output_nodes(mesh, i_cell)
      end do
      call file%write('/mesh/topology', uniform, '-', 'nodes of each cell in VTK''s order, from 0')
    else
      associate (topology => mixed_topology(mesh))
        described%n_mixed_entries = size(topology)
        call file%write('/mesh/topology', topology, '', 'per cell its XDMF type, then its nodes in VTK''s order, from 0')
      end associate
    end if
  end subroutine write_topology

  !> Returns the XDMF number of the type and the nodes (output_nodes) of each cell, one cell after the other. Points and lines of
  !> two nodes have their number of nodes in between.
  pure function mixed_topology(mesh) result(topology)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable :: topology(:)
    integer :: buffer(3 * mesh%n_cells + size(mesh%cell_nodes))
    integer :: i_cell, n, n_entries, xdmf_type

    n_entries = 0
    do i_cell = 1, mesh%n_cells
      xdmf_type = element_types(mesh%cell_types(i_cell))%xdmf_type
      n = n_output_nodes(mesh%cell_types(i_cell))
      n_entries = n_entries + 1
      buffer(n_entries) = xdmf_type
      if (xdmf_type <= 2) then
        n_entries = n_entries + 1
        buffer(n_entries) = n
      end if
      buffer(n_entries + 1:n_entries + n) = output_nodes(mesh, i_cell)
      n_entries = n_entries + n
    end do
    topology = buffer(:n_entries)
  end function mixed_topology

  !> Returns the nodes of a cell, counted from 0, in VTK's order (n_output_nodes).
  pure function output_nodes(mesh, i_cell) result(nodes)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_cell
    integer, allocatable :: nodes(:)

    nodes = nodes_of_cell(mesh, i_cell) - 1
    nodes = nodes(element_types(mesh%cell_types(i_cell))%output_order(:n_output_nodes(mesh%cell_types(i_cell))))
  end function output_nodes
end module sig_field_topology
