! SPDX-License-Identifier: BSD-3-Clause
!> Guesses which named surfaces of a mesh face each other, by the centers of their facets. `signorom init` needs it for a first
!> deck.
module sig_facing_groups
  use sig_bodies, only: find_bodies
  use sig_k_d_tree, only: k_d_tree_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t, nodes_of_facet
  use sig_surface_geometry, only: flat_direction, is_flat, measure_surface, surface_geometry_t
  implicit none(type, external)
  private
  public :: facing_groups_t, find_facing_groups

  !> Two surfaces of different bodies that face each other. The first one is that whose share of facing area is larger.
  type :: facing_groups_t
    !> numbers of the groups in the mesh
    integer :: first = 0
    integer :: second = 0
    !> [-] share of the first surface's area that faces the second one
    real(rk) :: share = 0
    !> [length] least and largest distance of the facing facets' centers along the normals of the first surface, negative where they
    !> overlap; 0 if the size is below 1e-9 of the reach
    real(rk) :: gap(2) = 0
    !> whether both surfaces are flat. Between curved surfaces the gaps have an error of about the distance from facet to surface
    logical :: is_flat = .false.
    !> [-] flat_direction of the second surface, if it is flat and the first one is not; otherwise 0
    real(rk) :: direction(3) = 0
  end type facing_groups_t

  !> A named surface with the data for the search.
  type :: surface_t
    integer :: group = 0
    !> numbers of its bodies, without repeats
    integer, allocatable :: bodies(:)
    !> whether it is flat, and then [-] its direction (flat_direction)
    logical :: is_flat = .false.
    real(rk) :: direction(3) = 0
    !> [length] mean facet size, and largest distance at which another surface counts as facing
    real(rk) :: facet_size = 0
    real(rk) :: reach = 0
    !> [length] least gap of each facet to a surface that faces it; huge if there is none
    real(rk), allocatable :: least_gap(:)
    !> [length] center of each facet, and its outward normal times its length or area; shape (n_dim, n_facets)
    real(rk), allocatable :: centers(:, :)
    real(rk), allocatable :: area_vectors(:, :)
    type(k_d_tree_t) :: tree
  end type surface_t

  !> [-] smallest share of the area that faces the other surface; for two disks that touch it is a quarter
  real(rk), parameter :: enough = 0.2_rk
  !> [-] normals whose cosine is not above this count as opposite: they are within 60 degrees of opposite directions
  real(rk), parameter :: opposite = -0.5_rk
  !> [-] reach of the search: the larger of this share of the surface's length and this number of facet sizes
  real(rk), parameter :: of_length = 0.1_rk
  real(rk), parameter :: of_facets = 2
  !> [-] share of the reach below which a gap counts as zero
  real(rk), parameter :: rounding = 1.0e-9_rk

contains

  !> Finds all pairs of named surfaces without a common body of which one faces the other with at least a fifth of its area. The
  !> pairs are in the order of the groups; in each pair the surface with the larger share of facing area is the first one. Surfaces
  !> without facets are left out, and so are those with a facet that is not a side of exactly one cell.
  !>
  !> A facet faces the other surface if gaps_between finds a gap, and no third surface lies between. A third surface lies between if
  !> it has no body in common with the facet's surface, and the gap to it is smaller by more than the mean facet size of the facet's
  !> surface.
  subroutine find_facing_groups(mesh, pairs)
    type(mesh_t), intent(in) :: mesh
    type(facing_groups_t), allocatable, intent(out) :: pairs(:)
    type(surface_t), allocatable :: surfaces(:)
    type(facing_groups_t) :: one, other
    integer :: i, k

    call measure_surfaces(mesh, surfaces)
    do i = 1, size(surfaces)
      do k = 1, size(surfaces)
        if (have_common_body(surfaces(i), surfaces(k))) cycle
        surfaces(i)%least_gap = min(surfaces(i)%least_gap, gaps_between(surfaces(i), surfaces(k)))
      end do
    end do
    allocate (pairs(0))
    do i = 1, size(surfaces)
      do k = i + 1, size(surfaces)
        if (have_common_body(surfaces(i), surfaces(k))) cycle
        one = face(surfaces(i), surfaces(k))
        other = face(surfaces(k), surfaces(i))
        if (other%share > one%share) one = other
        if (one%share >= enough) pairs = [pairs, one]
      end do
    end do
  end subroutine find_facing_groups

  !> Whether some body has nodes of both surfaces; also true if both are the same surface.
  pure logical function have_common_body(one, other)
    type(surface_t), intent(in) :: one
    type(surface_t), intent(in) :: other
    integer :: i

    have_common_body = any([(any(other%bodies == one%bodies(i)), i=1, size(one%bodies))])
  end function have_common_body

  !> Measures the named surfaces, in the order of the groups. Surfaces without facets are left out, and so are those with a facet
  !> that is not a side of exactly one cell.
  subroutine measure_surfaces(mesh, surfaces)
    type(mesh_t), intent(in) :: mesh
    type(surface_t), allocatable, intent(out) :: surfaces(:)
    type(surface_geometry_t) :: geometry
    type(surface_t) :: surface
    integer, allocatable :: body_of_node(:)
    integer :: i, n_bodies

    call find_bodies(mesh, body_of_node, n_bodies)
    allocate (surfaces(0))
    do i = 1, size(mesh%groups)
      if (mesh%groups(i)%n_dim /= mesh%n_dim - 1 .or. size(mesh%groups(i)%entities) == 0) cycle
      call measure_surface(mesh, i, geometry)
      if (geometry%inner_facet > 0) cycle
      ! gfortran 12 leaks a function result in a constructor
      surface = surface_of(mesh, i, geometry, body_of_node)
      surfaces = [surfaces, surface]
    end do
  end subroutine measure_surfaces

  !> Returns the data of one surface; its least gaps are huge, because nothing faces it yet.
  function surface_of(mesh, i_group, geometry, body_of_node) result(surface)
    type(mesh_t), intent(in) :: mesh
    !> index in mesh%groups
    integer, intent(in) :: i_group
    !> of measure_surface, without an inner facet
    type(surface_geometry_t), intent(in) :: geometry
    !> of find_bodies, shape (n_nodes)
    integer, intent(in) :: body_of_node(:)
    type(surface_t) :: surface
    integer :: i

    associate (group => mesh%groups(i_group))
      surface%group = i_group
      surface%bodies = pack([(i, i=1, maxval(body_of_node))], [(any(body_of_node(group%nodes) == i), i=1, maxval(body_of_node))])
      allocate (surface%centers(mesh%n_dim, size(group%entities)))
      do i = 1, size(group%entities)
        associate (nodes => nodes_of_facet(mesh, group%entities(i)))
          surface%centers(:, i) = sum(mesh%coordinates(:, nodes), dim=2) / size(nodes)
        end associate
      end do
      surface%area_vectors = geometry%area_vectors
      surface%is_flat = is_flat(geometry)
      if (surface%is_flat) surface%direction(:mesh%n_dim) = flat_direction(geometry)
      surface%facet_size = geometry%mesh_size
      surface%reach = max(of_facets * geometry%mesh_size, of_length * length_of(mesh%coordinates(:, group%nodes)))
      allocate (surface%least_gap(size(group%entities)), source=huge(1.0_rk))
    end associate
    call surface%tree%create(surface%centers)
  end function surface_of

  !> Returns the diagonal [length] of the box around points.
  pure real(rk) function length_of(points)
    !> [length] shape (n_dim, n_points)
    real(rk), intent(in) :: points(:, :)

    length_of = norm2(maxval(points, dim=2) - minval(points, dim=2))
  end function length_of

  !> Returns the gap [length] of each facet of a surface to another surface: the distance to the center of the facet whose center is
  !> nearest, along the facet's own outward normal, negative where both overlap.
  !>
  !> The gap is huge if the normals of both facets are not within 60 degrees of opposite directions, if their centers are farther
  !> apart than the larger `reach` of both surfaces (0.1 times the diagonal of the box around a surface, or 2 times its mean facet
  !> size if this is more), or if they overlap by more than the larger mean facet size of both surfaces.
  pure function gaps_between(surface, other) result(gaps)
    type(surface_t), intent(in) :: surface
    type(surface_t), intent(in) :: other
    real(rk) :: gaps(size(surface%centers, 2))
    real(rk) :: distance, gap
    integer :: i, nearest

    gaps = huge(gaps)
    do i = 1, size(gaps)
      call other%tree%nearest(surface%centers(:, i), nearest, distance)
      associate (normal => surface%area_vectors(:, i) / norm2(surface%area_vectors(:, i)), across => other%area_vectors(:, nearest))
        if (distance > max(surface%reach, other%reach) .or. dot_product(normal, across) > opposite * norm2(across)) cycle
        gap = dot_product(normal, other%centers(:, nearest) - surface%centers(:, i))
      end associate
      if (gap >= -max(surface%facet_size, other%facet_size)) gaps(i) = gap
    end do
  end function gaps_between

  !> Returns the pair with `surface` as the first one: the share of its area that faces the other surface, and the gaps there. Where
  !> nothing faces the share is 0, and the gaps must not be used. Requires: surface%least_gap counts all surfaces of other bodies.
  pure type(facing_groups_t) function face(surface, other) result(pair)
    type(surface_t), intent(in) :: surface
    type(surface_t), intent(in) :: other
    real(rk), dimension(size(surface%centers, 2)) :: areas, gaps
    logical :: is_facing(size(areas))

    areas = norm2(surface%area_vectors, dim=1)
    gaps = gaps_between(surface, other)
    is_facing = gaps < huge(gaps) .and. gaps <= surface%least_gap + surface%facet_size
    pair = facing_groups_t(surface%group, other%group, sum(areas, mask=is_facing) / sum(areas), &
      [minval(gaps, mask=is_facing), maxval(gaps, mask=is_facing)], surface%is_flat .and. other%is_flat)
    where (abs(pair%gap) < rounding * surface%reach) pair%gap = 0
    if (other%is_flat .and. .not. surface%is_flat) pair%direction = other%direction
  end function face
end module sig_facing_groups
