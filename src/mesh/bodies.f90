! SPDX-License-Identifier: BSD-3-Clause
!> Finds the bodies of a mesh. A body is a set of cells that are connected by common nodes.
module sig_bodies
  use sig_mesh, only: mesh_t
  use sig_text, only: append_text, string_t
  implicit none(type, external)
  private
  public :: find_bodies, regions_of_body

contains

  !> Finds the body of each node. Two nodes of a cell belong to one body, and so cells with a common node do, too. Bodies are
  !> numbered in the order of their lowest node. Cost: nearly linear in the number of cells.
  pure subroutine find_bodies(mesh, body_of_node, n_bodies)
    type(mesh_t), intent(in) :: mesh
    !> number of the body of each node, 1-based, shape (n_nodes)
    integer, allocatable, intent(out) :: body_of_node(:)
    integer, intent(out) :: n_bodies
    integer :: i, i_cell, root, lowest(mesh%n_nodes)

    ! each node refers to a lower node of its body, the lowest node to itself
    lowest = [(i, i=1, mesh%n_nodes)]
    do i_cell = 1, mesh%n_cells
      do i = mesh%cell_offsets(i_cell) + 2, mesh%cell_offsets(i_cell + 1)
        call join(lowest, mesh%cell_nodes(i - 1), mesh%cell_nodes(i))
      end do
    end do
    allocate (body_of_node(mesh%n_nodes))
    n_bodies = 0
    do i = 1, mesh%n_nodes
      root = lowest(i)
      if (root == i) n_bodies = n_bodies + 1
      if (root == i) body_of_node(i) = n_bodies
      if (root /= i) body_of_node(i) = body_of_node(root)
    end do
  end subroutine find_bodies

  !> Joins the bodies of two nodes (1-based) in `lowest`, where each node refers to a lower node of its body, and the lowest node to
  !> itself. Nothing changes if both nodes are in one body already.
  pure subroutine join(lowest, first, second)
    integer, intent(inout) :: lowest(:)
    integer, intent(in) :: first, second
    integer :: a, b

    call find_root(lowest, first, a)
    call find_root(lowest, second, b)
    lowest(max(a, b)) = min(a, b)
  end subroutine join

  !> Finds the lowest node (root) of a node's body, and halves the path to it in `lowest` for later searches.
  pure subroutine find_root(lowest, node, root)
    integer, intent(inout) :: lowest(:)
    integer, intent(in) :: node
    integer, intent(out) :: root

    root = node
    do while (lowest(root) /= root)
      lowest(root) = lowest(lowest(root))
      root = lowest(root)
    end do
  end subroutine find_root

  !> Returns the names of all regions that have at least one cell of a body, in the order of the mesh's groups.
  pure function regions_of_body(mesh, body_of_node, i_body) result(names)
    type(mesh_t), intent(in) :: mesh
    !> of find_bodies
    integer, intent(in) :: body_of_node(:)
    !> number of the body, 1-based
    integer, intent(in) :: i_body
    type(string_t), allocatable :: names(:)
    integer :: i, i_group

    allocate (names(0))
    do i_group = 1, size(mesh%groups)
      associate (group => mesh%groups(i_group))
        if (group%n_dim /= mesh%n_dim) cycle
        do i = 1, size(group%entities)
          if (body_of_node(mesh%cell_nodes(mesh%cell_offsets(group%entities(i)) + 1)) /= i_body) cycle
          call append_text(names, group%name)
          exit
        end do
      end associate
    end do
  end function regions_of_body
end module sig_bodies
