! SPDX-License-Identifier: BSD-3-Clause
!> Element types as data: a new type is a new row of this table, not a new branch.
module sig_element_types
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: element_type_t, element_types, element_type_of_gmsh
  public :: n_element_types, max_element_nodes

  integer, parameter :: max_element_nodes = 8
  integer, parameter :: n_element_types = 6

  !> Linear elements: shape functions span the listed monomials and are 1 at one reference node, 0 at the others.
  type :: element_type_t
    character(8) :: name = ''
    integer :: gmsh_type = 0
    integer :: xdmf_type = 0
    integer :: n_dim = 0
    integer :: n_nodes = 0
    !> reference nodes in gmsh's (= VTK's) order, shape (3, n_nodes) used
    real(rk) :: reference_nodes(3, max_element_nodes) = 0
    !> exponents of xi, eta, zeta in each monomial, shape (3, n_nodes) used
    integer :: monomials(3, max_element_nodes) = 0
    !> volume of the reference element
    real(rk) :: reference_volume = 0
    !> per node the n_dim nodes at the other end of its edges, so turned that their directions are right-handed;
    !> shape (n_dim, n_nodes) used, cells of dimension 2 and 3 only
    integer :: corner_neighbors(3, max_element_nodes) = 0
    !> order of the nodes that turns the element inside out, shape (n_nodes) used
    integer :: mirrored_order(max_element_nodes) = 0
  end type element_type_t

  real(rk), parameter :: point_nodes(3, 8) = 0
  real(rk), parameter :: line_nodes(3, 8) = reshape([real(rk) :: -1, 0, 0, 1, 0, 0, &
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], [3, 8])
  real(rk), parameter :: simplex_nodes(3, 8) = reshape([real(rk) :: 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, &
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], [3, 8])
  real(rk), parameter :: box_nodes(3, 8) = reshape([real(rk) :: -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, &
    -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1], [3, 8])
  real(rk), parameter :: quadrilateral_nodes(3, 8) = reshape([real(rk) :: -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, &
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], [3, 8])
  integer, parameter :: simplex_monomials(3, 8) = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, &
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], [3, 8])
  integer, parameter :: box_monomials(3, 8) = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, &
    0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1], [3, 8])

  integer, parameter :: no_neighbors(3, 8) = 0
  integer, parameter :: triangle_neighbors(3, 8) = reshape([2, 3, 0, 3, 1, 0, 1, 2, 0, &
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], [3, 8])
  integer, parameter :: quadrilateral_neighbors(3, 8) = reshape([2, 4, 0, 3, 1, 0, 4, 2, 0, 1, 3, 0, &
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], [3, 8])
  integer, parameter :: tetrahedron_neighbors(3, 8) = reshape([2, 3, 4, 1, 4, 3, 1, 2, 4, 1, 3, 2, &
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], [3, 8])
  integer, parameter :: hexahedron_neighbors(3, 8) = reshape([2, 4, 5, 3, 1, 6, 4, 2, 7, 1, 3, 8, &
    8, 6, 1, 5, 7, 2, 6, 8, 3, 7, 5, 4], [3, 8])

  !> Points and lines serve as facets; the rest are cells or facets by the dimension of the mesh.
  type(element_type_t), parameter :: element_types(n_element_types) = [ &
    element_type_t('point', 15, 1, 0, 1, point_nodes, simplex_monomials, 1.0_rk, no_neighbors, [1, 0, 0, 0, 0, 0, 0, 0]), &
    element_type_t('line', 1, 2, 1, 2, line_nodes, simplex_monomials, 2.0_rk, no_neighbors, [2, 1, 0, 0, 0, 0, 0, 0]), &
    element_type_t('T3', 2, 4, 2, 3, simplex_nodes, simplex_monomials, 0.5_rk, triangle_neighbors, [1, 3, 2, 0, 0, 0, 0, 0]), &
    element_type_t('Q4', 3, 5, 2, 4, quadrilateral_nodes, box_monomials, 4.0_rk, quadrilateral_neighbors, &
                   [1, 4, 3, 2, 0, 0, 0, 0]), &
    element_type_t('T4', 4, 6, 3, 4, simplex_nodes, simplex_monomials, 1.0_rk / 6, tetrahedron_neighbors, &
                   [1, 3, 2, 4, 0, 0, 0, 0]), &
    element_type_t('H8', 5, 9, 3, 8, box_nodes, box_monomials, 8.0_rk, hexahedron_neighbors, [1, 4, 3, 2, 5, 8, 7, 6])]

contains

  !> Row of the table with this gmsh number; 0 where the code has no such element.
  pure integer function element_type_of_gmsh(gmsh_type) result(i_type)
    integer, intent(in) :: gmsh_type

    do i_type = 1, n_element_types
      if (element_types(i_type)%gmsh_type == gmsh_type) return
    end do
    i_type = 0
  end function element_type_of_gmsh
end module sig_element_types
