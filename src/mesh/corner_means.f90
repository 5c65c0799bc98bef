! SPDX-License-Identifier: BSD-3-Clause
!> Says of each node of which corners of elements it is the middle. The linear elements with the same corners move it by their mean.
module sig_corner_means
  use sig_element_types, only: element_types, max_element_nodes, n_element_types
  use sig_mesh, only: mesh_t
  use sig_shape_functions, only: corners_of_node
  implicit none(type, external)
  private
  public :: corner_means_t, find_corner_means

  !> The corners of some nodes, which a rank owns; a corner is the middle of itself. Nothing is allocated where all nodes of the
  !> mesh are corners.
  type :: corner_means_t
    !> number of corners of each node of the mesh, shape (n_nodes)
    integer, allocatable :: n_corners(:)
    !> nodes of the mesh, 1-based; corners(:n_corners(nodes(i)), i) are those of nodes(i), shape (most_corners, size(nodes))
    integer, allocatable :: corners(:, :)
  contains
    procedure :: has_middles
  end type corner_means_t

  !> the middle of a hexahedron has most corners
  integer, parameter :: most_corners = 8

contains

  !> Finds the corners of some nodes, and how many corners all nodes have. A node that no cell has counts as a corner.
  pure subroutine find_corner_means(mesh, nodes_wanted, means)
    type(mesh_t), intent(in) :: mesh
    !> 1-based, each once
    integer, intent(in) :: nodes_wanted(:)
    type(corner_means_t), intent(out) :: means
    !> position of each node in nodes_wanted, 0 where it is not there
    integer, allocatable :: place(:)
    integer :: n_corners(max_element_nodes, n_element_types), corners(most_corners, max_element_nodes, n_element_types)
    integer :: i, i_cell, n

    if (all(element_types(mesh%cell_types)%order == 1)) return
    call tabulate_corners(n_corners, corners)
    allocate (means%n_corners(mesh%n_nodes), source=1)
    allocate (means%corners(most_corners, size(nodes_wanted)), source=0)
    allocate (place(mesh%n_nodes), source=0)
    means%corners(1, :) = nodes_wanted
    place(nodes_wanted) = [(i, i=1, size(nodes_wanted))]
    do i_cell = 1, mesh%n_cells
      associate (nodes => mesh%cell_nodes(mesh%cell_offsets(i_cell) + 1:mesh%cell_offsets(i_cell + 1)), &
                 i_type => mesh%cell_types(i_cell))
        do i = 1, size(nodes)
          n = n_corners(i, i_type)
          means%n_corners(nodes(i)) = n
          if (place(nodes(i)) > 0) means%corners(:n, place(nodes(i))) = nodes(corners(:n, i, i_type))
        end do
      end associate
    end do
  end subroutine find_corner_means

  !> Lists the corners of the nodes of all element types, as corners_of_node does.
  pure subroutine tabulate_corners(n_corners, corners)
    integer, intent(out) :: n_corners(:, :)
    integer, intent(out) :: corners(:, :, :)
    integer, allocatable :: found(:)
    integer :: i, i_type

    n_corners = 1
    corners = 0
    do i_type = 1, n_element_types
      if (element_types(i_type)%n_dim == 0) cycle
      do i = 1, element_types(i_type)%n_nodes
        found = corners_of_node(i_type, i)
        n_corners(i, i_type) = size(found)
        corners(:size(found), i, i_type) = found
      end do
    end do
  end subroutine tabulate_corners

  !> Whether the mesh has a node that is no corner.
  pure logical function has_middles(self)
    class(corner_means_t), intent(in) :: self

    has_middles = allocated(self%n_corners)
  end function has_middles
end module sig_corner_means
