! SPDX-License-Identifier: BSD-3-Clause
!> One surface of a mortar contact: its facets with their places, and a tree that finds those near a line.
!>
!> If a face of the first surface has weak corners, all faces of this surface use the basis of sig_changed_basis, because a side
!> that two faces of different kinds share must have one basis. In axisymmetry an edge of three nodes that ends on the axis uses
!> this basis, too, because the integral of r N_j is zero at its node on the axis.
module sig_mortar_sides
  use sig_changed_basis, only: ends_of_side, has_weak_corners
  use sig_element_types, only: element_types
  use sig_facet_bulges, only: find_bulges
  use sig_k_d_tree, only: k_d_tree_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t, nodes_of_facet
  use sig_mesh_axis, only: ends_on_axis
  use sig_surface_geometry, only: surface_geometry_t
  implicit none(type, external)
  private
  public :: mortar_side_t, create_side

  !> The facets of one surface, with copies of all data of their nodes, facet by facet.
  type :: mortar_side_t
    integer :: n_facets = 0
    !> values at the nodes of facet i are entries offsets(i) + 1 ... offsets(i + 1)
    integer, allocatable :: offsets(:)
    !> natural, 1-based
    integer, allocatable :: nodes(:)
    !> [length] places of these nodes, shape (n_dim, size(nodes))
    real(rk), allocatable :: vertices(:, :)
    !> [-] contact normals from the first body to the second, same shape; of the first surface only
    real(rk), allocatable :: normals(:, :)
    !> row of element_types, shape (n_facets)
    integer, allocatable :: types(:)
    !> [-] outward, shape (n_dim, n_facets)
    real(rk), allocatable :: outward(:, :)
    !> [length] how far the surface stands out over the middles of the edges, from each corner to the next; shape (size(nodes))
    real(rk), allocatable :: bulges(:)
    !> [length] the longest edge
    real(rk) :: longest = 0
    !> whether the facet's functions are those of the changed basis; of the first surface only, shape (n_facets)
    logical, allocatable :: is_changed(:)
    !> natural numbers of the corners on both sides of a node whose coefficient in that basis is not its value, 0 elsewhere; of the
    !> first surface only, shape (2, n_nodes)
    integer, allocatable :: ends(:, :)
    !> a ball around each facet
    type(k_d_tree_t) :: balls
  end type mortar_side_t

contains

  !> Collects the data of one surface. If `normals` is present, as for the first surface, the data include the normals and the
  !> changed basis.
  pure subroutine create_side(mesh, facets, geometry, side, normals, is_round)
    type(mesh_t), intent(in) :: mesh
    !> facets of the surface, 1-based in the mesh
    integer, intent(in) :: facets(:)
    !> geometry of the same facets
    type(surface_geometry_t), intent(in) :: geometry
    type(mortar_side_t), intent(out) :: side
    !> [-] contact normals at the nodes of the mesh, shape (n_dim, n_nodes)
    real(rk), intent(in), optional :: normals(:, :)
    !> whether the mesh turns around the axis x = 0; default: no; used with normals only
    logical, intent(in), optional :: is_round
    real(rk) :: middles(mesh%n_dim, size(facets)), radii(size(facets))
    integer :: i

    side%n_facets = size(facets)
    side%types = mesh%facet_types(facets)
    side%outward = geometry%area_vectors / spread(norm2(geometry%area_vectors, dim=1), 1, mesh%n_dim)
    call list_nodes(mesh, facets, side)
    side%vertices = mesh%coordinates(:, side%nodes)
    if (present(normals)) then
      side%normals = normals(:, side%nodes)
      call find_changed(side, is_round)
      call find_ends(mesh%n_nodes, side)
    end if
    do i = 1, side%n_facets
      associate (vertices => side%vertices(:, side%offsets(i) + 1:side%offsets(i + 1)))
        middles(:, i) = sum(vertices, dim=2) / size(vertices, 2)
        radii(i) = maxval(norm2(vertices - spread(middles(:, i), 2, size(vertices, 2)), dim=1))
        side%longest = max(side%longest, longest_edge(vertices(:, :element_types(side%types(i))%n_corners)))
      end associate
    end do
    call find_bulges(side%offsets, side%nodes, side%vertices, side%outward, &
      merge(element_types(side%types)%n_corners, 0, element_types(side%types)%order == 1), side%bulges)
    call side%balls%create(middles, radii)
  end subroutine create_side

  pure subroutine list_nodes(mesh, facets, side)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: facets(:)
    type(mortar_side_t), intent(inout) :: side
    integer :: i

    allocate (side%offsets(size(facets) + 1), source=0)
    do i = 1, size(facets)
      side%offsets(i + 1) = side%offsets(i) + mesh%facet_offsets(facets(i) + 1) - mesh%facet_offsets(facets(i))
    end do
    allocate (side%nodes(side%offsets(size(facets) + 1)))
    do i = 1, size(facets)
      side%nodes(side%offsets(i) + 1:side%offsets(i + 1)) = nodes_of_facet(mesh, facets(i))
    end do
  end subroutine list_nodes

  !> Finds the facets with the changed basis: all, if at least one of them has weak corners; in axisymmetry the quadratic edges that
  !> end on the axis.
  pure subroutine find_changed(side, is_round)
    type(mortar_side_t), intent(inout) :: side
    logical, intent(in), optional :: is_round
    integer :: i, last_type

    allocate (side%is_changed(side%n_facets), source=.false.)
    last_type = 0
    do i = 1, side%n_facets
      if (side%types(i) == last_type) cycle
      last_type = side%types(i)
      if (has_weak_corners(last_type)) side%is_changed = .true.
    end do
    if (.not. present(is_round)) return
    if (.not. is_round) return
    do i = 1, side%n_facets
      associate (radii => side%vertices(1, side%offsets(i) + 1:side%offsets(i + 1)))
        if (element_types(side%types(i))%order > 1) side%is_changed(i) = ends_on_axis(radii)
      end associate
    end do
  end subroutine find_changed

  !> Finds the two corners beside each node whose coefficient in the changed basis is not its value.
  pure subroutine find_ends(n_nodes, side)
    !> number of nodes of the mesh
    integer, intent(in) :: n_nodes
    type(mortar_side_t), intent(inout) :: side
    integer :: ends(2), i, j

    allocate (side%ends(2, n_nodes), source=0)
    do i = 1, side%n_facets
      if (.not. side%is_changed(i)) cycle
      associate (nodes => side%nodes(side%offsets(i) + 1:side%offsets(i + 1)))
        do j = 1, size(nodes)
          ends = ends_of_side(side%types(i), j)
          if (ends(1) > 0) side%ends(:, nodes(j)) = nodes(ends)
        end do
      end associate
    end do
  end subroutine find_ends

  !> Returns the longest distance [length] from a corner of a facet to the next one.
  pure real(rk) function longest_edge(corners) result(longest)
    !> [length] shape (n_dim, n_corners)
    real(rk), intent(in) :: corners(:, :)

    longest = maxval(norm2(corners - cshift(corners, 1, dim=2), dim=1))
  end function longest_edge
end module sig_mortar_sides
