! SPDX-License-Identifier: BSD-3-Clause
!> The table of element types. Most of the code reads this table and has no branches by type. Besides a row here, a new type needs
!> integration points (sig_quadrature), is_supported in gmsh_content.c, and a row in the topology.py of signorom-post.
module sig_element_types
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: element_type_t, element_types, element_type_of_gmsh, element_type_with, corner_type, fullest_type, mirrored_order
  public :: n_output_nodes
  public :: n_element_types, max_element_nodes, max_facet_nodes

  integer, parameter :: max_element_nodes = 27
  integer, parameter :: max_facet_nodes = 9
  integer, parameter :: n_element_types = 19
  integer, parameter :: max_corners = 8

  !> One element type. Its shape functions are combinations of the listed monomials; each is 1 at one reference node and 0 at the
  !> others. Corners are the first nodes.
  !>
  !> Monomials of pyramids also have powers of the ratio w = xi eta / (1 - zeta), which is xi or -xi on a side, so that pyramids fit
  !> to tetrahedra there, and xi eta on the base, where they fit to hexahedra. Source: M. Bergot, G. Cohen, M. Durufle, J. Sci.
  !> Comput. 42 (2010) 345.
  type :: element_type_t
    character(8) :: name = ''
    integer :: gmsh_type = 0
    integer :: xdmf_type = 0
    character(16) :: xdmf_name = ''
    integer :: n_dim = 0
    integer :: n_nodes = 0
    integer :: n_corners = 0
    !> 1 = linear; 2 = quadratic, with nodes in the middle of the edges
    integer :: order = 1
    !> coordinates of the reference nodes in the order of gmsh, of which (3, n_nodes) are used
    real(rk) :: reference_nodes(3, max_element_nodes) = 0
    !> exponents of xi, eta, zeta in each monomial, of which (3, n_nodes) are used
    integer :: monomials(3, max_element_nodes) = 0
    !> volume of the reference element
    real(rk) :: reference_volume = 0
    !> for each corner the n_dim corners at the other ends of its edges, in an order in which the directions of the edges are
    !> right-handed; (n_dim, n_corners) are used; only for elements of dimension 2 and 3
    integer :: corner_neighbors(3, max_corners) = 0
    !> numbers of the nodes of gmsh in the order of VTK; zeros behind them
    integer :: output_order(max_element_nodes) = 0
    !> exponents of the ratio in each monomial, of which n_nodes are used
    integer :: ratio_powers(max_element_nodes) = 0
  end type element_type_t

  ! A linear element has the first nodes and monomials of the quadratic elements of the same shape.
  real(rk), parameter :: line_nodes(3, 27) = reshape([real(rk) :: -1, 0, 0, 1, 0, 0, 0, 0, 0], [3, 27], [0.0_rk])
  real(rk), parameter :: h = 0.5_rk
  real(rk), parameter :: simplex_nodes(3, 27) = reshape([real(rk) :: 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, &
    h, 0, 0, h, h, 0, 0, h, 0, 0, 0, h, 0, h, h, h, 0, h], [3, 27], [0.0_rk])
  real(rk), parameter :: triangle_nodes(3, 27) = reshape([simplex_nodes(:, :3), simplex_nodes(:, 5:7)], [3, 27], [0.0_rk])
  real(rk), parameter :: quadrilateral_nodes(3, 27) = reshape([real(rk) :: -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, &
    0, -1, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, 0, 0], [3, 27], [0.0_rk])
  real(rk), parameter :: box_nodes(3, 27) = reshape([real(rk) :: -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, &
    -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1, &
    0, -1, -1, -1, 0, -1, -1, -1, 0, 1, 0, -1, 1, -1, 0, 0, 1, -1, 1, 1, 0, -1, 1, 0, 0, -1, 1, -1, 0, 1, 1, 0, 1, 0, 1, 1, &
    0, 0, -1, 0, -1, 0, -1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0], [3, 27])

  real(rk), parameter :: prism_nodes(3, 27) = reshape([real(rk) :: 0, 0, -1, 1, 0, -1, 0, 1, -1, 0, 0, 1, 1, 0, 1, 0, 1, 1, &
    h, 0, -1, 0, h, -1, 0, 0, 0, h, h, -1, 1, 0, 0, 0, 1, 0, h, 0, 1, 0, h, 1, h, h, 1, h, 0, 0, 0, h, 0, h, h, 0], &
    [3, 27], [0.0_rk])
  real(rk), parameter :: pyramid_nodes(3, 27) = reshape([real(rk) :: -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, 0, 0, 1, &
    0, -1, 0, -1, 0, 0, -h, -h, h, 1, 0, 0, h, -h, h, 0, 1, 0, h, h, h, -h, h, h, 0, 0, 0], [3, 27], [0.0_rk])

  integer, parameter :: line_monomials(3, 27) = reshape([0, 0, 0, 1, 0, 0, 2, 0, 0], [3, 27], [0])
  integer, parameter :: triangle_monomials(3, 27) = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 2, 0, 0, 0, 2, 0], [3, 27], [0])
  integer, parameter :: simplex_monomials(3, 27) = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, &
    1, 1, 0, 0, 1, 1, 1, 0, 1, 2, 0, 0, 0, 2, 0, 0, 0, 2], [3, 27], [0])
  integer, parameter :: quadrilateral_monomials(3, 27) = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, &
    2, 0, 0, 0, 2, 0, 2, 1, 0, 1, 2, 0, 2, 2, 0], [3, 27], [0])
  integer, parameter :: box_monomials(3, 27) = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1, &
    2, 0, 0, 0, 2, 0, 0, 0, 2, 2, 1, 0, 2, 0, 1, 1, 2, 0, 0, 2, 1, 1, 0, 2, 0, 1, 2, 2, 1, 1, 1, 2, 1, 1, 1, 2, &
    2, 2, 0, 0, 2, 2, 2, 0, 2, 2, 2, 1, 2, 1, 2, 1, 2, 2, 2, 2, 2], [3, 27])

  integer, parameter :: prism_monomials(3, 27) = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, &
    1, 1, 0, 2, 0, 0, 0, 2, 0, 1, 1, 1, 2, 0, 1, 0, 2, 1, 0, 0, 2, 1, 0, 2, 0, 1, 2, 1, 1, 2, 2, 0, 2, 0, 2, 2], [3, 27], [0])
  integer, parameter :: pyramid_monomials(3, 27) = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, &
    1, 1, 0, 0, 1, 1, 1, 0, 1, 2, 0, 0, 0, 2, 0, 0, 0, 2, 1, 0, 0, 0, 1, 0, 0, 0, 0], [3, 27], [0])
  integer, parameter :: pyramid_ratios(27) = [0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 1, 2, &
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]

  integer, parameter :: no_neighbors(3, 8) = 0
  integer, parameter :: triangle_neighbors(3, 8) = reshape([2, 3, 0, 3, 1, 0, 1, 2, 0], [3, 8], [0])
  integer, parameter :: quadrilateral_neighbors(3, 8) = reshape([2, 4, 0, 3, 1, 0, 4, 2, 0, 1, 3, 0], [3, 8], [0])
  integer, parameter :: tetrahedron_neighbors(3, 8) = reshape([2, 3, 4, 1, 4, 3, 1, 2, 4, 1, 3, 2], [3, 8], [0])
  integer, parameter :: hexahedron_neighbors(3, 8) = reshape([2, 4, 5, 3, 1, 6, 4, 2, 7, 1, 3, 8, &
    8, 6, 1, 5, 7, 2, 6, 8, 3, 7, 5, 4], [3, 8])

  integer, parameter :: prism_neighbors(3, 8) = reshape([2, 3, 4, 3, 1, 5, 1, 2, 6, 6, 5, 1, 4, 6, 2, 5, 4, 3], [3, 8], [0])
  ! at the apex three of its four edges
  integer, parameter :: pyramid_neighbors(3, 8) = reshape([2, 4, 5, 3, 1, 5, 4, 2, 5, 1, 3, 5, 1, 4, 2], [3, 8], [0])

  integer, parameter :: same_order(27) = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, &
    25, 26, 27]
  integer, parameter :: tetrahedron_order(27) = [same_order(:8), 10, 9, same_order(11:)]
  integer, parameter :: hexahedron_order(27) = [same_order(:8), 9, 12, 14, 10, 17, 19, 20, 18, 11, 13, 15, 16, &
    23, 24, 22, 25, 21, 26, 27]

  integer, parameter :: prism_order(27) = [same_order(:6), 7, 10, 8, 13, 15, 14, 9, 11, 12, 16, 18, 17, &
    0, 0, 0, 0, 0, 0, 0, 0, 0]
  ! XDMF has no pyramid with a node in the middle of its base: this node is left out
  integer, parameter :: pyramid_order(27) = [same_order(:5), 6, 9, 11, 7, 8, 10, 12, 13, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]

  !> Points and lines are facets only. The others are cells or facets, depending on the dimension of the mesh.
  type(element_type_t), parameter :: element_types(n_element_types) = [ &
    element_type_t('point', 15, 1, 'Polyvertex', 0, 1, 1, 1, simplex_nodes, simplex_monomials, 1.0_rk, no_neighbors, same_order), &
    element_type_t('line', 1, 2, 'Polyline', 1, 2, 2, 1, line_nodes, line_monomials, 2.0_rk, no_neighbors, same_order), &
    element_type_t('T3', 2, 4, 'Triangle', 2, 3, 3, 1, triangle_nodes, triangle_monomials, 0.5_rk, triangle_neighbors, &
                   same_order), &
    element_type_t('Q4', 3, 5, 'Quadrilateral', 2, 4, 4, 1, quadrilateral_nodes, quadrilateral_monomials, 4.0_rk, &
                   quadrilateral_neighbors, same_order), &
    element_type_t('T4', 4, 6, 'Tetrahedron', 3, 4, 4, 1, simplex_nodes, simplex_monomials, 1.0_rk / 6, tetrahedron_neighbors, &
                   same_order), &
    element_type_t('H8', 5, 9, 'Hexahedron', 3, 8, 8, 1, box_nodes, box_monomials, 8.0_rk, hexahedron_neighbors, same_order), &
    element_type_t('line3', 8, 34, 'Edge_3', 1, 3, 2, 2, line_nodes, line_monomials, 2.0_rk, no_neighbors, same_order), &
    element_type_t('T6', 9, 36, 'Triangle_6', 2, 6, 3, 2, triangle_nodes, triangle_monomials, 0.5_rk, triangle_neighbors, &
                   same_order), &
    element_type_t('Q8', 16, 37, 'Quadrilateral_8', 2, 8, 4, 2, quadrilateral_nodes, quadrilateral_monomials, 4.0_rk, &
                   quadrilateral_neighbors, same_order), &
    element_type_t('Q9', 10, 35, 'Quadrilateral_9', 2, 9, 4, 2, quadrilateral_nodes, quadrilateral_monomials, 4.0_rk, &
                   quadrilateral_neighbors, same_order), &
    element_type_t('T10', 11, 38, 'Tetrahedron_10', 3, 10, 4, 2, simplex_nodes, simplex_monomials, 1.0_rk / 6, &
                   tetrahedron_neighbors, tetrahedron_order), &
    element_type_t('H20', 17, 48, 'Hexahedron_20', 3, 20, 8, 2, box_nodes, box_monomials, 8.0_rk, hexahedron_neighbors, &
                   hexahedron_order), &
    element_type_t('H27', 12, 50, 'Hexahedron_27', 3, 27, 8, 2, box_nodes, box_monomials, 8.0_rk, hexahedron_neighbors, &
                   hexahedron_order), &
    element_type_t('W6', 6, 8, 'Wedge', 3, 6, 6, 1, prism_nodes, prism_monomials, 1.0_rk, prism_neighbors, prism_order), &
    element_type_t('W15', 18, 40, 'Wedge_15', 3, 15, 6, 2, prism_nodes, prism_monomials, 1.0_rk, prism_neighbors, prism_order), &
    element_type_t('W18', 13, 41, 'Wedge_18', 3, 18, 6, 2, prism_nodes, prism_monomials, 1.0_rk, prism_neighbors, prism_order), &
    element_type_t('P5', 7, 7, 'Pyramid', 3, 5, 5, 1, pyramid_nodes, pyramid_monomials, 4.0_rk / 3, pyramid_neighbors, &
                   pyramid_order, pyramid_ratios), &
    element_type_t('P13', 19, 39, 'Pyramid_13', 3, 13, 5, 2, pyramid_nodes, pyramid_monomials, 4.0_rk / 3, pyramid_neighbors, &
                   pyramid_order, pyramid_ratios), &
    element_type_t('P14', 14, 39, 'Pyramid_13', 3, 14, 5, 2, pyramid_nodes, pyramid_monomials, 4.0_rk / 3, pyramid_neighbors, &
                   pyramid_order, pyramid_ratios)]

contains

  !> Returns the row of the table with this number of gmsh; 0 if the table has no such element.
  pure integer function element_type_of_gmsh(gmsh_type) result(i_type)
    !> gmsh's number of the element type
    integer, intent(in) :: gmsh_type

    do i_type = 1, n_element_types
      if (element_types(i_type)%gmsh_type == gmsh_type) return
    end do
    i_type = 0
  end function element_type_of_gmsh

  !> Returns the row of the table with the element of this dimension and this number of nodes; 0 if there is none.
  pure integer function element_type_with(n_dim, n_nodes) result(i_type)
    integer, intent(in) :: n_dim
    integer, intent(in) :: n_nodes

    do i_type = 1, n_element_types
      if (element_types(i_type)%n_dim == n_dim .and. element_types(i_type)%n_nodes == n_nodes) return
    end do
    i_type = 0
  end function element_type_with

  !> Returns the row of the table with the linear element of the same shape.
  pure integer function corner_type(i_type)
    !> row of element_types
    integer, intent(in) :: i_type

    corner_type = element_type_with(element_types(i_type)%n_dim, element_types(i_type)%n_corners)
  end function corner_type

  !> Returns the row of the table with the element of the same shape that has the most nodes.
  pure integer function fullest_type(i_type)
    !> row of element_types
    integer, intent(in) :: i_type
    integer :: i_other

    fullest_type = i_type
    do i_other = 1, n_element_types
      if (corner_type(i_other) /= corner_type(i_type)) cycle
      if (element_types(i_other)%n_nodes > element_types(fullest_type)%n_nodes) fullest_type = i_other
    end do
  end function fullest_type

  !> Returns the number of nodes that files for viewers get of an element: all, but for the pyramid of 14 nodes.
  pure integer function n_output_nodes(i_type)
    !> row of element_types
    integer, intent(in) :: i_type

    n_output_nodes = min(element_types(i_type)%n_nodes, count(element_types(i_type)%output_order > 0))
  end function n_output_nodes

  !> Returns the order of the nodes in which they describe the mirrored element, where xi and eta are exchanged: node i of the
  !> mirrored element is node order(i) of the element. The Jacobian changes its sign. Requires: an element of dimension 2 or 3.
  pure function mirrored_order(i_type) result(order)
    !> row of element_types
    integer, intent(in) :: i_type
    integer :: order(element_types(i_type)%n_nodes)
    integer :: i_node, j_node

    associate (nodes => element_types(i_type)%reference_nodes)
      do i_node = 1, size(order)
        do j_node = 1, size(order)
          if (all(abs(nodes([2, 1, 3], j_node) - nodes(:, i_node)) < 0.25_rk)) order(i_node) = j_node
        end do
      end do
    end associate
  end function mirrored_order
end module sig_element_types
