! SPDX-License-Identifier: BSD-3-Clause
!> Says of each node of which corners of elements it is the middle. The linear elements with the same corners move it by their mean.
module sig_corner_means
  use sig_element_types, only: element_types, max_element_nodes, n_element_types
  use sig_mesh, only: mesh_t
  use sig_shape_functions, only: corners_of_node
  implicit none(type, external)
  private
  public :: corner_means_t, find_corner_means

  !> The corners of all nodes; a corner is the middle of itself.
  type :: corner_means_t
    !> number of corners of each node, shape (n_nodes)
    integer, allocatable :: n_corners(:)
    !> nodes of the mesh, 1-based; corners(:n_corners(i), i) are those of node i
    integer, allocatable :: corners(:, :)
  contains
    procedure :: has_middles
  end type corner_means_t

  !> the middle of a hexahedron has most corners
  integer, parameter :: most_corners = 8

contains

  !> Finds the corners of all nodes. A node that no cell has counts as a corner.
  pure subroutine find_corner_means(mesh, means)
    type(mesh_t), intent(in) :: mesh
    type(corner_means_t), intent(out) :: means
    integer :: n_corners(max_element_nodes, n_element_types), corners(most_corners, max_element_nodes, n_element_types)
    integer :: i, i_cell, i_node, n

    call tabulate_corners(n_corners, corners)
    allocate (means%n_corners(mesh%n_nodes), source=1)
    allocate (means%corners(most_corners, mesh%n_nodes), source=0)
    means%corners(1, :) = [(i_node, i_node=1, mesh%n_nodes)]
    do i_cell = 1, mesh%n_cells
      associate (nodes => mesh%cell_nodes(mesh%cell_offsets(i_cell) + 1:mesh%cell_offsets(i_cell + 1)), &
                 i_type => mesh%cell_types(i_cell))
        do i = 1, size(nodes)
          n = n_corners(i, i_type)
          means%n_corners(nodes(i)) = n
          means%corners(:n, nodes(i)) = nodes(corners(:n, i, i_type))
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

  !> Whether there is a node that is no corner.
  pure logical function has_middles(self)
    class(corner_means_t), intent(in) :: self

    has_middles = any(self%n_corners > 1)
  end function has_middles
end module sig_corner_means
