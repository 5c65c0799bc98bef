! SPDX-License-Identifier: BSD-3-Clause
!> Computes sizes and outward normals of the facets of a named surface.
module sig_surface_geometry
  use sig_cross_products, only: cross_product
  use sig_element_types, only: element_type_with, element_types
  use sig_kinds, only: rk
  use sig_mesh, only: cells_around_nodes, mesh_t, nodes_of_cell, nodes_of_facet
  use sig_rounding, only: rounding_of_data
  use sig_shape_functions, only: shape_coefficients, shape_slopes
  use sig_text, only: fine_digits, short_number
  implicit none(type, external)
  private
  public :: surface_geometry_t, measure_surface, averaged_normals, normal_in_symmetry, is_flat, flat_direction, direction_text

  !> The geometry of one surface.
  type :: surface_geometry_t
    !> [length or length**2] outward unit normal of each facet times its length or area, shape (n_dim, number of facets of the
    !> group)
    real(rk), allocatable :: area_vectors(:, :)
    !> [length] mean size of the facets: the length of an edge, the square root of the area of a face
    real(rk) :: mesh_size = 0
    !> number in the mesh of the first facet that is not a side of exactly one cell, and then the geometry is not complete; 0 if
    !> there is none
    integer :: inner_facet = 0
  end type surface_geometry_t

  !> [-] rounding of a flat surface: of 1 - cosine between a normal and the mean one, and of a component that is 0
  real(rk), parameter :: flat_rounding = 1.0e-8_rk

contains

  !> Whether all facets of a surface have the same outward normal: the cosine between each and the mean one is at least 1 - 1e-8.
  pure logical function is_flat(geometry)
    type(surface_geometry_t), intent(in) :: geometry
    integer :: i

    associate (vectors => geometry%area_vectors, whole => sum(geometry%area_vectors, dim=2))
      is_flat = all([(dot_product(vectors(:, i), whole) >= (1 - flat_rounding) * norm2(vectors(:, i)) * norm2(whole), &
        i=1, size(vectors, 2))])
      ! the vectors of a closed surface cancel
      is_flat = is_flat .and. norm2(whole) > 0
    end associate
  end function is_flat

  !> Returns the direction that points from outside into the body behind a flat surface: the opposite of the mean outward normal, a
  !> unit vector [-], whose components below 1e-8 in size are set to 0. Requires: is_flat.
  pure function flat_direction(geometry) result(direction)
    type(surface_geometry_t), intent(in) :: geometry
    real(rk) :: direction(size(geometry%area_vectors, 1))

    direction = -sum(geometry%area_vectors, dim=2)
    direction = direction / norm2(direction)
    where (abs(direction) < flat_rounding) direction = 0
  end function flat_direction

  !> Returns a direction as a deck has it, such as `[0.0, 1.0]`, rounded to six digits.
  pure function direction_text(direction) result(text)
    real(rk), intent(in) :: direction(:)
    character(:), allocatable :: text
    integer :: i

    text = '[' // short_number(direction(1), fine_digits)
    do i = 2, size(direction)
      text = text // ', ' // short_number(direction(i), fine_digits)
    end do
    text = text // ']'
  end function direction_text

  !> Computes the geometry of a group of facets. Stops at the first facet that is not a side of exactly one cell, and sets
  !> inner_facet to it; the rest of the geometry must then not be used.
  pure subroutine measure_surface(mesh, i_group, geometry)
    type(mesh_t), intent(in) :: mesh
    !> index in mesh%groups
    integer, intent(in) :: i_group
    type(surface_geometry_t), intent(out) :: geometry
    integer, allocatable :: offsets(:), cells(:), sides(:)
    integer :: i, i_facet, i_node
    real(rk) :: outward(mesh%n_dim)

    call cells_around_nodes(mesh, offsets, cells)
    associate (facets => mesh%groups(i_group)%entities)
      allocate (geometry%area_vectors(mesh%n_dim, size(facets)))
      do i = 1, size(facets)
        i_facet = facets(i)
        i_node = mesh%facet_nodes(mesh%facet_offsets(i_facet) + 1)
        sides = cells_with_facet(mesh, i_facet, cells(offsets(i_node) + 1:offsets(i_node + 1)))
        if (size(sides) /= 1) then
          geometry%inner_facet = i_facet
          return
        end if
        geometry%area_vectors(:, i) = area_vector(mesh, i_facet)
        outward = center(mesh, nodes_of_facet(mesh, i_facet)) - center(mesh, nodes_of_cell(mesh, sides(1)))
        if (dot_product(outward, geometry%area_vectors(:, i)) < 0) geometry%area_vectors(:, i) = -geometry%area_vectors(:, i)
        geometry%mesh_size = geometry%mesh_size + norm2(geometry%area_vectors(:, i))**(1.0_rk / (mesh%n_dim - 1)) / size(facets)
      end do
    end associate
  end subroutine measure_surface

  !> Returns those of the given cells that have all nodes of the facet.
  pure function cells_with_facet(mesh, i_facet, cells) result(found)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_facet
    integer, intent(in) :: cells(:)
    integer, allocatable :: found(:)
    logical :: has_all(size(cells))
    integer :: i, n

    do i = 1, size(cells)
      has_all(i) = .true.
      do n = mesh%facet_offsets(i_facet) + 1, mesh%facet_offsets(i_facet + 1)
        has_all(i) = has_all(i) .and. any(nodes_of_cell(mesh, cells(i)) == mesh%facet_nodes(n))
      end do
    end do
    found = pack(cells, has_all)
  end function cells_with_facet

  !> Returns the unit normal of a facet times its length or area. Whether it is inward or outward depends on the order of the nodes.
  !> Only the corners of a quadratic facet count.
  pure function area_vector(mesh, i_facet) result(vector)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_facet
    real(rk) :: vector(mesh%n_dim)
    real(rk) :: a(mesh%n_dim), b(mesh%n_dim)
    integer, allocatable :: nodes(:)
    integer :: n

    nodes = nodes_of_facet(mesh, i_facet)
    n = element_types(element_type_with(mesh%n_dim - 1, size(nodes)))%n_corners
    if (mesh%n_dim == 2) then
      a = mesh%coordinates(:, nodes(2)) - mesh%coordinates(:, nodes(1))
      vector = [a(2), -a(1)]
    else
      ! half the cross product of two sides of a triangle or of the diagonals of a quadrilateral
      a = mesh%coordinates(:, nodes(n - 1)) - mesh%coordinates(:, nodes(1))
      b = mesh%coordinates(:, nodes(n)) - mesh%coordinates(:, nodes(n - 2))
      vector = 0.5_rk * cross_product(a, b)
    end if
  end function area_vector

  !> Returns the outward unit normal at each node of a group: the direction of the sum of the area vectors of the group's facets
  !> around the node, each divided by the number of nodes of its facet, and zero if they cancel. The area vector of a quadratic
  !> facet is turned to its normal at the node. A facet counts by its area, in axisymmetry by the length of its edge in the mesh, so
  !> that the normals on a circle of equal edges are exactly radial there, too.
  pure function averaged_normals(mesh, i_group, area_vectors) result(normals)
    type(mesh_t), intent(in) :: mesh
    !> index in mesh%groups
    integer, intent(in) :: i_group
    !> of measure_surface, without an inner facet
    real(rk), intent(in) :: area_vectors(:, :)
    !> [-] normals in the order of the group's nodes, shape (n_dim, number of nodes of the group)
    real(rk), allocatable :: normals(:, :)
    real(rk), allocatable :: vectors(:, :), areas(:), own(:, :)
    integer :: i, j

    allocate (vectors(mesh%n_dim, mesh%n_nodes), source=0.0_rk)
    allocate (areas(mesh%n_nodes), source=0.0_rk)
    associate (facets => mesh%groups(i_group)%entities, group_nodes => mesh%groups(i_group)%nodes)
      do i = 1, size(facets)
        associate (nodes => nodes_of_facet(mesh, facets(i)))
          own = nodal_normals(mesh%coordinates(:, nodes), area_vectors(:, i))
          do j = 1, size(nodes)
            vectors(:, nodes(j)) = vectors(:, nodes(j)) + own(:, j) / size(nodes)
            areas(nodes(j)) = areas(nodes(j)) + norm2(area_vectors(:, i)) / size(nodes)
          end do
        end associate
      end do
      allocate (normals(mesh%n_dim, size(group_nodes)), source=0.0_rk)
      do i = 1, size(group_nodes)
        associate (vector => vectors(:, group_nodes(i)))
          if (norm2(vector) > rounding_of_data * areas(group_nodes(i))) normals(:, i) = vector / norm2(vector)
        end associate
      end do
    end associate
  end function averaged_normals

  !> Returns a normal whose components along prescribed dofs are 0, if the rest is longer than 0.9: the node is then on a plane of
  !> symmetry, and so is its normal. Otherwise the normal stays.
  pure function normal_in_symmetry(normal, is_prescribed) result(turned)
    !> unit vector
    real(rk), intent(in) :: normal(:)
    !> of each component of the node
    logical, intent(in) :: is_prescribed(:)
    real(rk) :: turned(size(normal))
    real(rk), parameter :: nearly_free = 0.9_rk

    turned = merge(0.0_rk, normal, is_prescribed)
    if (norm2(turned) > nearly_free) then
      turned = turned / norm2(turned)
    else
      turned = normal
    end if
  end function normal_in_symmetry

  !> Returns the area vector of one facet at each of its nodes. At a node of a quadratic facet it is turned to the normal there,
  !> with the same length; elsewhere it is area_vector.
  pure function nodal_normals(vertices, area_vector) result(vectors)
    !> [length] places of the facet's nodes in the element's order, shape (n_dim, number of nodes)
    real(rk), intent(in) :: vertices(:, :)
    !> that of the facet by measure_surface, shape (n_dim)
    real(rk), intent(in) :: area_vector(:)
    real(rk) :: vectors(size(vertices, 1), size(vertices, 2))
    real(rk) :: normal(3), tangents(3, 2)
    integer :: i, i_dim, i_type

    vectors = spread(area_vector, 2, size(vertices, 2))
    i_type = element_type_with(size(vertices, 1) - 1, size(vertices, 2))
    if (element_types(i_type)%order == 1) return
    tangents = 0
    do i = 1, size(vertices, 2)
      do i_dim = 1, size(vertices, 1) - 1
        tangents(:size(vertices, 1), i_dim) = matmul(vertices, shape_slopes(i_type, shape_coefficients(i_type), &
          element_types(i_type)%reference_nodes(:size(vertices, 1) - 1, i), i_dim))
      end do
      if (size(vertices, 1) == 2) tangents(3, 2) = 1
      normal = cross_product(tangents(:, 1), tangents(:, 2))
      associate (normal => normal(:size(vertices, 1)))
        if (norm2(normal) > 0) vectors(:, i) = sign(norm2(area_vector) / norm2(normal), dot_product(normal, area_vector)) * normal
      end associate
    end do
  end function nodal_normals

  pure function center(mesh, nodes) result(place)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: nodes(:)
    real(rk) :: place(mesh%n_dim)

    place = sum(mesh%coordinates(:, nodes), dim=2) / size(nodes)
  end function center
end module sig_surface_geometry
