! SPDX-License-Identifier: BSD-3-Clause
!> Collects cells of bodies, facets, lines and points in one mesh for pictures.
module sig_cell_collection
  use sig_element_types, only: element_type_with
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  implicit none(type, external)
  private
  public :: cell_collection_t

  !> Call `start`, then the add procedures. They set n_cells, types, offsets and nodes of the cells of the mesh; the caller sets
  !> n_nodes and coordinates. The mesh has neither facets nor groups nor numbers of gmsh.
  type :: cell_collection_t
    type(mesh_t) :: mesh
    !> whole numbers that the caller gives to each cell, shape (n_labels, n_cells)
    integer, allocatable :: labels(:, :)
  contains
    procedure :: start
    procedure :: add_bodies
    procedure :: add_facets
    procedure :: add_lines
    procedure :: add_points
    procedure, private :: add
  end type cell_collection_t

contains

  !> Starts a collection without cells; what was collected before is dropped.
  pure subroutine start(self, n_dim, n_labels)
    class(cell_collection_t), intent(inout) :: self
    !> number of dimensions of space
    integer, intent(in) :: n_dim
    !> number of labels (whole numbers) that each cell gets
    integer, intent(in) :: n_labels

    self%mesh = mesh_t()
    self%mesh%n_dim = n_dim
    allocate (self%mesh%cell_types(0), self%mesh%cell_nodes(0))
    self%mesh%cell_offsets = [0]
    if (allocated(self%labels)) deallocate (self%labels)
    allocate (self%labels(n_labels, 0))
  end subroutine start

  !> Adds all cells of a mesh. The numbers of their nodes in the mesh are those in the collection.
  pure subroutine add_bodies(self, mesh, labels)
    class(cell_collection_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    !> shape (n_labels, n_cells)
    integer, intent(in) :: labels(:, :)

    call self%add(mesh%cell_types, mesh%cell_offsets(2:) - mesh%cell_offsets(:mesh%n_cells), mesh%cell_nodes, labels)
  end subroutine add_bodies

  !> Adds some facets of a mesh as cells. All of them get the same labels.
  pure subroutine add_facets(self, mesh, facets, numbers, labels)
    class(cell_collection_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    !> numbers of the facets, 1-based
    integer, intent(in) :: facets(:)
    !> number in the collection of each node of the mesh, shape (n_nodes); only those of nodes of the facets are used
    integer, intent(in) :: numbers(:)
    !> shape (n_labels)
    integer, intent(in) :: labels(:)
    integer :: sizes(size(facets)), i, k
    integer, allocatable :: nodes(:)

    sizes = mesh%facet_offsets(facets + 1) - mesh%facet_offsets(facets)
    nodes = [((mesh%facet_nodes(mesh%facet_offsets(facets(i)) + k), k=1, sizes(i)), i=1, size(facets))]
    call self%add(mesh%facet_types(facets), sizes, numbers(nodes), spread(labels, 2, size(facets)))
  end subroutine add_facets

  !> Adds lines, each as a cell of two nodes.
  pure subroutine add_lines(self, from, to, labels)
    class(cell_collection_t), intent(inout) :: self
    !> first and second node of each line, as numbers in the collection, 1-based; shape (n_lines)
    integer, intent(in) :: from(:), to(:)
    !> shape (n_labels, n_lines)
    integer, intent(in) :: labels(:, :)
    integer :: i

    call self%add([(element_type_with(1, 2), i=1, size(from))], [(2, i=1, size(from))], &
      [(from(i), to(i), i=1, size(from))], labels)
  end subroutine add_lines

  !> Adds single nodes, each as a cell of one node.
  pure subroutine add_points(self, nodes, labels)
    class(cell_collection_t), intent(inout) :: self
    !> their numbers in the collection, 1-based
    integer, intent(in) :: nodes(:)
    !> the same for all of them, shape (n_labels)
    integer, intent(in) :: labels(:)
    integer :: i

    call self%add([(element_type_with(0, 1), i=1, size(nodes))], [(1, i=1, size(nodes))], nodes, spread(labels, 2, size(nodes)))
  end subroutine add_points

  pure subroutine add(self, types, sizes, nodes, labels)
    class(cell_collection_t), intent(inout) :: self
    !> row of element_types of each cell
    integer, intent(in) :: types(:)
    !> number of nodes of each cell, same shape
    integer, intent(in) :: sizes(:)
    !> nodes of all cells, one cell after the other
    integer, intent(in) :: nodes(:)
    integer, intent(in) :: labels(:, :)
    integer :: offsets(size(sizes)), i, n

    n = size(self%mesh%cell_nodes)
    do i = 1, size(sizes)
      n = n + sizes(i)
      offsets(i) = n
    end do
    self%mesh%cell_types = [self%mesh%cell_types, types]
    self%mesh%cell_nodes = [self%mesh%cell_nodes, nodes]
    self%mesh%cell_offsets = [self%mesh%cell_offsets, offsets]
    self%mesh%n_cells = self%mesh%n_cells + size(types)
    self%labels = reshape([self%labels, labels], [size(self%labels, 1), self%mesh%n_cells])
  end subroutine add
end module sig_cell_collection
