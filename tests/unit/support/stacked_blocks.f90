! SPDX-License-Identifier: BSD-3-Clause
!> Blocks stacked along y, each a gap above the one below: the bars and blocks of the contact and solver tests.
module stacked_blocks
  use sig_boundary_conditions, only: boundary_conditions_t
  use sig_element_types, only: element_type_of_gmsh
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_node_pairs, only: node_pairs_t
  implicit none(type, external)
  private
  public :: stack_t, stack_mesh, stack_pairs, prescribe, node_at

  !> Blocks of n_x by n_y unit squares; odd blocks of T3 (two per square), even ones of Q4.
  type :: stack_t
    integer :: n_x = 4
    integer :: n_y = 2
    integer :: n_blocks = 2
    real(rk) :: gap = 0
  end type stack_t

contains

  !> Node in column i and row j (from 0) of a block (from 1): row by row from the lower left, block by block.
  pure integer function node_at(stack, i_block, i, j)
    type(stack_t), intent(in) :: stack
    integer, intent(in) :: i_block, i, j

    node_at = ((i_block - 1) * (stack%n_y + 1) + j) * (stack%n_x + 1) + i + 1
  end function node_at

  !> Without names and owners.
  subroutine stack_mesh(stack, mesh)
    type(stack_t), intent(in) :: stack
    type(mesh_t), intent(out) :: mesh
    integer :: i, j, i_block

    mesh%n_dim = 2
    mesh%n_nodes = stack%n_blocks * (stack%n_x + 1) * (stack%n_y + 1)
    allocate (mesh%coordinates(2, mesh%n_nodes), mesh%cell_types(0), mesh%cell_nodes(0), mesh%groups(0))
    mesh%cell_offsets = [0]
    do i_block = 1, stack%n_blocks
      do j = 0, stack%n_y
        do i = 0, stack%n_x
          mesh%coordinates(:, node_at(stack, i_block, i, j)) = &
            [real(i, rk), j + (i_block - 1) * (stack%n_y + stack%gap)]
          if (i < stack%n_x .and. j < stack%n_y) call add_square(stack, i_block, i, j, mesh)
        end do
      end do
    end do
    mesh%n_cells = size(mesh%cell_types)
    mesh%node_tags = [(i, i=1, mesh%n_nodes)]
    mesh%cell_tags = [(i, i=1, mesh%n_cells)]
  end subroutine stack_mesh

  subroutine add_square(stack, i_block, i, j, mesh)
    type(stack_t), intent(in) :: stack
    integer, intent(in) :: i_block, i, j
    type(mesh_t), intent(inout) :: mesh
    integer :: a, b, c, d

    a = node_at(stack, i_block, i, j)
    b = node_at(stack, i_block, i + 1, j)
    c = node_at(stack, i_block, i + 1, j + 1)
    d = node_at(stack, i_block, i, j + 1)
    if (modulo(i_block, 2) == 1) then
      call add_cell('T3', [a, b, c], mesh)
      call add_cell('T3', [a, c, d], mesh)
    else
      call add_cell('Q4', [a, b, c, d], mesh)
    end if
  end subroutine add_square

  subroutine add_cell(name, nodes, mesh)
    character(*), intent(in) :: name
    integer, intent(in) :: nodes(:)
    type(mesh_t), intent(inout) :: mesh

    mesh%cell_types = [mesh%cell_types, element_type_of_gmsh(merge(2, 3, name == 'T3'))]
    mesh%cell_nodes = [mesh%cell_nodes, nodes]
    mesh%cell_offsets = [mesh%cell_offsets, size(mesh%cell_nodes)]
  end subroutine add_cell

  !> Each top node with the bottom node above it; normals and gaps as the mesh's coordinates have them along the direction.
  subroutine stack_pairs(stack, mesh, direction, pairs)
    type(stack_t), intent(in) :: stack
    type(mesh_t), intent(in) :: mesh
    real(rk), intent(in) :: direction(2)
    type(node_pairs_t), intent(out) :: pairs
    integer :: i, i_block, k

    pairs%n_pairs = (stack%n_blocks - 1) * (stack%n_x + 1)
    allocate (pairs%first_node(pairs%n_pairs), pairs%second_node(pairs%n_pairs), pairs%initial_gap(pairs%n_pairs))
    allocate (pairs%contact_entry(pairs%n_pairs), source=1)
    allocate (pairs%gap_factors(pairs%n_pairs, 0))
    pairs%normal = spread(direction / norm2(direction), 2, pairs%n_pairs)
    k = 0
    do i_block = 1, stack%n_blocks - 1
      do i = 0, stack%n_x
        k = k + 1
        pairs%first_node(k) = node_at(stack, i_block, i, stack%n_y)
        pairs%second_node(k) = node_at(stack, i_block + 1, i, 0)
        pairs%initial_gap(k) = dot_product(pairs%normal(:, k), &
          mesh%coordinates(:, pairs%second_node(k)) - mesh%coordinates(:, pairs%first_node(k)))
      end do
    end do
  end subroutine stack_pairs

  !> Prescribes one component on nodes: constant + push * theta_2. Terms are `1` and `push`.
  subroutine prescribe(boundary, mesh, nodes, component, constant, push)
    type(boundary_conditions_t), intent(inout) :: boundary
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: nodes(:)
    integer, intent(in) :: component
    real(rk), intent(in) :: constant, push
    real(rk), allocatable :: all_values(:, :)
    integer :: i

    if (.not. allocated(boundary%is_prescribed)) call start(boundary, mesh)
    allocate (all_values(mesh%n_dim * mesh%n_nodes, 2), source=0.0_rk)
    all_values(boundary%prescribed_dofs, :) = boundary%prescribed_values
    associate (dofs => mesh%n_dim * (nodes - 1) + component)
      all_values(dofs, 1) = constant
      all_values(dofs, 2) = push
      boundary%is_prescribed(dofs) = .true.
    end associate
    boundary%prescribed_dofs = pack([(i, i=1, size(all_values, 1))], boundary%is_prescribed)
    boundary%prescribed_values = all_values(boundary%prescribed_dofs, :)
  end subroutine prescribe

  subroutine start(boundary, mesh)
    type(boundary_conditions_t), intent(inout) :: boundary
    type(mesh_t), intent(in) :: mesh

    boundary%n_terms = 2
    boundary%n_driving_terms = 2
    allocate (boundary%is_prescribed(mesh%n_dim * mesh%n_nodes), source=.false.)
    allocate (boundary%prescribed_dofs(0), boundary%prescribed_values(0, 2))
  end subroutine start
end module stacked_blocks
