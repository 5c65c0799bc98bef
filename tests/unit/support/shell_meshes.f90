! SPDX-License-Identifier: BSD-3-Clause
!> Two concentric shells, one layer of cells each: arcs in the plane, patches of spheres in space.
module shell_meshes
  use sig_element_types, only: element_type_of_gmsh
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  implicit none(type, external)
  private
  public :: shell_mesh, shell_node

  !> [rad] opening of the shells along each angle
  real(rk), parameter, public :: opening = 0.8_rk

contains

  !> Shells between radii(1) and radii(2), and between radii(3) and radii(4), each angle in n equal parts from 0 on.
  !>
  !> Surfaces `inside` (radius 1), `inner` (2), `outer` (3), `outside` (4). Node tags are 100 + the node's number.
  subroutine shell_mesh(n_dim, n, radii, mesh)
    integer, intent(in) :: n_dim
    !> cells along each angle
    integer, intent(in) :: n
    !> [length] shape (4)
    real(rk), intent(in) :: radii(:)
    type(mesh_t), intent(out) :: mesh
    integer :: i, j, i_shell

    mesh%n_dim = n_dim
    mesh%n_nodes = 4 * (n + 1)**(n_dim - 1)
    allocate (mesh%coordinates(n_dim, mesh%n_nodes), mesh%groups(4))
    do i_shell = 1, 4
      do j = 0, merge(n, 0, n_dim == 3)
        do i = 0, n
          mesh%coordinates(:, shell_node(n, i_shell, i, j)) = radii(i_shell) * ray(n_dim, opening * i / n, opening * j / n)
        end do
      end do
    end do
    call add_cells(n, mesh)
    mesh%n_cells = 2 * n**(n_dim - 1)
    mesh%cell_types = spread(element_type_of_gmsh(merge(3, 5, n_dim == 2)), 1, mesh%n_cells)
    mesh%cell_offsets = [(2**n_dim * i, i=0, mesh%n_cells)]
    mesh%n_facets = 4 * n**(n_dim - 1)
    mesh%facet_types = spread(element_type_of_gmsh(merge(1, 3, n_dim == 2)), 1, mesh%n_facets)
    mesh%facet_offsets = [(2**(n_dim - 1) * i, i=0, mesh%n_facets)]
    mesh%node_tags = [(100 + i, i=1, mesh%n_nodes)]
    mesh%cell_tags = [(i, i=1, mesh%n_cells)]
  end subroutine shell_mesh

  !> Node on radius i_shell (1 to 4) at the angles i and j (from 0).
  pure integer function shell_node(n, i_shell, i, j)
    integer, intent(in) :: n
    integer, intent(in) :: i_shell, i, j

    ! in the plane j is 0, and the shells follow each other
    shell_node = 4 * (n + 1) * j + (i_shell - 1) * (n + 1) + i + 1
  end function shell_node

  !> Unit vector; in space the angles turn about z and y.
  pure function ray(n_dim, a, b)
    integer, intent(in) :: n_dim
    real(rk), intent(in) :: a, b
    real(rk) :: ray(n_dim)

    ray(:2) = [cos(a), sin(a)]
    if (n_dim == 3) ray = [cos(a) * cos(b), sin(a), cos(a) * sin(b)]
  end function ray

  subroutine add_cells(n, mesh)
    integer, intent(in) :: n
    type(mesh_t), intent(inout) :: mesh
    character(7), parameter :: names(4) = ['inside ', 'inner  ', 'outer  ', 'outside']
    integer :: i, i_shell, j, k, n_corners, n_facets

    n_corners = 2**(mesh%n_dim - 1)
    n_facets = n**(mesh%n_dim - 1)
    allocate (mesh%facet_nodes(4 * n_corners * n_facets), mesh%cell_nodes(4 * n_corners * n_facets))
    k = 0
    do i_shell = 1, 4
      mesh%groups(i_shell)%name = trim(names(i_shell))
      mesh%groups(i_shell)%n_dim = mesh%n_dim - 1
      mesh%groups(i_shell)%entities = (i_shell - 1) * n_facets + [(i, i=1, n_facets)]
      mesh%groups(i_shell)%nodes = [((shell_node(n, i_shell, i, j), i=0, n), j=0, merge(n, 0, mesh%n_dim == 3))]
      do j = 0, merge(n - 1, 0, mesh%n_dim == 3)
        do i = 0, n - 1
          mesh%facet_nodes(n_corners * k + 1:n_corners * (k + 1)) = corners(mesh%n_dim, n, i_shell, i, j)
          k = k + 1
        end do
      end do
    end do
    k = 0
    do i_shell = 1, 3, 2
      do j = 0, merge(n - 1, 0, mesh%n_dim == 3)
        do i = 0, n - 1
          associate (near => corners(mesh%n_dim, n, i_shell, i, j), far => corners(mesh%n_dim, n, i_shell + 1, i, j))
            ! around a quadrilateral, but layer by layer in a hexahedron
            mesh%cell_nodes(k + 1:k + 2 * n_corners) = [near, merge(far(n_corners:1:-1), far, mesh%n_dim == 2)]
          end associate
          k = k + 2 * n_corners
        end do
      end do
    end do
  end subroutine add_cells

  !> Nodes of a facet between the angles i and i + 1 (and j, j + 1).
  pure function corners(n_dim, n, i_shell, i, j) result(nodes)
    integer, intent(in) :: n_dim, n
    integer, intent(in) :: i_shell, i, j
    integer, allocatable :: nodes(:)

    nodes = [shell_node(n, i_shell, i, j), shell_node(n, i_shell, i + 1, j)]
    if (n_dim == 3) nodes = [nodes, shell_node(n, i_shell, i + 1, j + 1), shell_node(n, i_shell, i, j + 1)]
  end function corners
end module shell_meshes
