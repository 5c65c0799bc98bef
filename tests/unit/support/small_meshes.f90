! SPDX-License-Identifier: BSD-3-Clause
!> Small meshes built in code, so that a test of what comes after the mesh needs no file.
module small_meshes
  use sig_contact_rows, only: contact_rows_t, create_contact_rows
  use sig_element_types, only: element_type_of_gmsh
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  implicit none(type, external)
  private
  public :: two_block_mesh, two_block_rows

contains

  !> Two blocks of n_x by n_y unit squares, the upper one a gap above the lower one; each square is two T3.
  !>
  !> Nodes row by row from the lower left, first the lower block, then the upper one. Square (i, j) of a block with corners
  !> a b c d (from the lower left, counterclockwise) is the triangle a b c, then the triangle a c d.
  subroutine two_block_mesh(n_x, n_y, gap, mesh)
    integer, intent(in) :: n_x, n_y
    real(rk), intent(in) :: gap
    type(mesh_t), intent(out) :: mesh
    integer :: i, j, i_block, i_cell, i_node, a

    mesh%n_dim = 2
    mesh%n_nodes = 2 * (n_x + 1) * (n_y + 1)
    mesh%n_cells = 4 * n_x * n_y
    allocate (mesh%coordinates(2, mesh%n_nodes), mesh%cell_nodes(3 * mesh%n_cells))
    i_node = 0
    i_cell = 0
    do i_block = 0, 1
      do j = 0, n_y
        do i = 0, n_x
          i_node = i_node + 1
          mesh%coordinates(:, i_node) = [real(i, rk), j + i_block * (n_y + gap)]
          if (i == n_x .or. j == n_y) cycle
          a = i_node
          mesh%cell_nodes(3 * i_cell + 1:3 * i_cell + 6) = [a, a + 1, a + n_x + 2, a, a + n_x + 2, a + n_x + 1]
          i_cell = i_cell + 2
        end do
      end do
    end do
    mesh%cell_offsets = [(3 * i, i=0, mesh%n_cells)]
    allocate (mesh%cell_types(mesh%n_cells), source=element_type_of_gmsh(2))
    mesh%node_tags = [(i, i=1, mesh%n_nodes)]
    mesh%cell_tags = [(i, i=1, mesh%n_cells)]
    allocate (mesh%groups(0))
  end subroutine two_block_mesh

  !> Contact between the two blocks along y: one row per node of the faces, from the left; the second term of the gap is 0.
  subroutine two_block_rows(n_x, n_y, gap, n_terms, rows)
    integer, intent(in) :: n_x, n_y
    real(rk), intent(in) :: gap
    integer, intent(in) :: n_terms
    type(contact_rows_t), intent(out) :: rows
    real(rk) :: gaps(n_x + 1, n_terms)
    integer :: i, ones(n_x + 1)

    gaps = 0
    gaps(:, 1) = gap
    ones = 1
    associate (first => n_y * (n_x + 1) + [(i, i=1, n_x + 1)], normals => spread([0.0_rk, 1.0_rk, 0.0_rk, -1.0_rk], 2, n_x + 1))
      call create_contact_rows(ones, ones, [(first(i), first(i) + n_x + 1, i=1, n_x + 1)], &
        reshape(normals, [2, 2 * (n_x + 1)]), gaps, 0.0_rk * gaps(:, 1) + 1, ones, rows)
    end associate
  end subroutine two_block_rows
end module small_meshes
