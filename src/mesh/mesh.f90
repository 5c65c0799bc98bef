! SPDX-License-Identifier: BSD-3-Clause
!> The data of a mesh, which every rank has completely. A partition says which rank works on which cells and nodes.
module sig_mesh
  use sig_kinds, only: rk
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: mesh_t, mesh_partition_t, group_t, find_group, cells_around_nodes, nodes_of_cell, nodes_of_facet

  !> A group of the mesh file: a physical group, or a geometric entity of gmsh whose elements are in no physical group.
  type :: group_t
    character(:), allocatable :: name
    !> dimension of its elements; 0 for points
    integer :: n_dim = 0
    !> elements of the group, ascending: cells if n_dim is that of the mesh, facets if it is one less; empty for lower dimensions
    integer, allocatable :: entities(:)
    !> all nodes of the group, ascending
    integer, allocatable :: nodes(:)
    !> number of elements of the group in the file that are left out, because a node of theirs belongs to no cell
    integer :: n_left_out = 0
  end type group_t

  !> The mesh. Nodes keep the order of the file ("natural"), so results do not depend on the rank count. All indices are 1-based.
  type :: mesh_t
    integer :: n_dim = 0
    integer :: n_nodes = 0
    integer :: n_cells = 0
    integer :: n_facets = 0
    !> [units.length] shape (n_dim, n_nodes)
    real(rk), allocatable :: coordinates(:, :)
    !> gmsh's node numbers, for messages, shape (n_nodes)
    integer, allocatable :: node_tags(:)
    !> row of element_types, shape (n_cells)
    integer, allocatable :: cell_types(:)
    !> nodes of cell c: cell_nodes(cell_offsets(c) + 1 : cell_offsets(c + 1)); the first offset is 0
    integer, allocatable :: cell_offsets(:)
    integer, allocatable :: cell_nodes(:)
    !> gmsh's element numbers of the cells, for messages, shape (n_cells)
    integer, allocatable :: cell_tags(:)
    !> types, offsets and nodes of the facets of groups, as those of the cells
    integer, allocatable :: facet_types(:)
    integer, allocatable :: facet_offsets(:)
    integer, allocatable :: facet_nodes(:)
    type(group_t), allocatable :: groups(:)
    !> sentences about what the user should know of the file: names that were made up, a turned plane
    type(string_t), allocatable :: notes(:)
    !> FNV-1a hash of the file's bytes, 16 hexadecimal digits
    character(16) :: file_hash = ''
  end type mesh_t

  !> Which rank of one communicator (0-based) has which cells and nodes.
  type :: mesh_partition_t
    !> rank that assembles the cell, shape (n_cells)
    integer, allocatable :: cell_owner(:)
    !> rank that owns the unknowns of the node, shape (n_nodes)
    integer, allocatable :: node_owner(:)
  end type mesh_partition_t

contains

  !> Returns the nodes of one cell (1-based), in the element's order.
  pure function nodes_of_cell(mesh, i_cell) result(nodes)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_cell
    integer :: nodes(mesh%cell_offsets(i_cell + 1) - mesh%cell_offsets(i_cell))

    nodes = mesh%cell_nodes(mesh%cell_offsets(i_cell) + 1:mesh%cell_offsets(i_cell + 1))
  end function nodes_of_cell

  !> Returns the nodes of one facet (1-based), in the element's order.
  pure function nodes_of_facet(mesh, i_facet) result(nodes)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_facet
    integer :: nodes(mesh%facet_offsets(i_facet + 1) - mesh%facet_offsets(i_facet))

    nodes = mesh%facet_nodes(mesh%facet_offsets(i_facet) + 1:mesh%facet_offsets(i_facet + 1))
  end function nodes_of_facet

  !> Returns the index of the first group with this name and dimension, 0 if there is none. A region and a surface may have the same
  !> name.
  pure integer function find_group(mesh, name, n_dim) result(i_group)
    type(mesh_t), intent(in) :: mesh
    character(*), intent(in) :: name
    !> dimension of the group's elements: mesh%n_dim for cells, one less for facets; default: any
    integer, intent(in), optional :: n_dim

    do i_group = 1, size(mesh%groups)
      if (mesh%groups(i_group)%name /= name) cycle
      if (.not. present(n_dim)) return
      if (mesh%groups(i_group)%n_dim == n_dim) return
    end do
    i_group = 0
  end function find_group

  !> Lists the cells of each node, ascending: those of node i are cells(offsets(i) + 1 : offsets(i + 1)).
  pure subroutine cells_around_nodes(mesh, offsets, cells)
    type(mesh_t), intent(in) :: mesh
    !> the first offset is 0, shape (n_nodes + 1)
    integer, allocatable, intent(out) :: offsets(:)
    !> 1-based
    integer, allocatable, intent(out) :: cells(:)
    integer :: i_cell, i_node, n
    integer, allocatable :: next(:)

    allocate (offsets(mesh%n_nodes + 1), source=0)
    do n = 1, size(mesh%cell_nodes)
      offsets(mesh%cell_nodes(n) + 1) = offsets(mesh%cell_nodes(n) + 1) + 1
    end do
    do i_node = 1, mesh%n_nodes
      offsets(i_node + 1) = offsets(i_node + 1) + offsets(i_node)
    end do
    next = offsets
    allocate (cells(size(mesh%cell_nodes)))
    do i_cell = 1, mesh%n_cells
      do n = mesh%cell_offsets(i_cell) + 1, mesh%cell_offsets(i_cell + 1)
        i_node = mesh%cell_nodes(n)
        next(i_node) = next(i_node) + 1
        cells(next(i_node)) = i_cell
      end do
    end do
  end subroutine cells_around_nodes
end module sig_mesh
