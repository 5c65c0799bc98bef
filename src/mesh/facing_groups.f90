! SPDX-License-Identifier: BSD-3-Clause
!> Guesses which named surfaces of a mesh face each other, by the centers of their facets. `signorom init` needs it for a first
!> deck.
module sig_facing_groups
  use sig_bodies, only: find_bodies
  use sig_k_d_tree, only: k_d_tree_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t, nodes_of_facet
  use sig_rounding, only: rounding_of_data
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
    !> [-] the same share of its front alone: of the facets whose normals are within 60 degrees of the mean one of the facets that
    !> face. A surface that wraps around its body, as the rim of a wheel or a sphere, has a back that can never face.
    real(rk) :: front_share = 0
    !> [length or length**2] the area that faces, and that of both whole surfaces
    real(rk) :: facing_area = 0
    real(rk) :: whole_area = 0
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

  !> [-] smallest share of the front of a surface that faces the other one
  real(rk), parameter :: enough = 0.2_rk
  !> [-] pairs that overlap: of those with at least this share of the largest facing area the smallest surfaces are taken
  real(rk), parameter :: nearly_all = 0.9_rk
  !> [-] normals whose cosine is not above this count as opposite: they are within 60 degrees of opposite directions
  real(rk), parameter :: opposite = -0.5_rk
  !> [-] reach of the search: the larger of this share of the surface's length and this number of facet sizes
  real(rk), parameter :: of_length = 0.1_rk
  real(rk), parameter :: of_facets = 2
  !> [-] a surface at a gap that is smaller by at most this share of the mean facet size is not between
  real(rk), parameter :: between = 0.1_rk
  !> [-] deepest overlap, as a share of the larger mean facet size of both surfaces, of the smaller one if both are flat
  real(rk), parameter :: deepest = 0.5_rk
  !> [-] facets overlap if their centers are closer across the normal than this share of the larger one's size: facets side by side
  !> have 1
  real(rk), parameter :: beside = 0.9_rk

contains

  !> Finds all pairs of named surfaces without a common body of which one faces the other with at least a fifth of its front. The
  !> pairs are in the order of the groups; in each pair the surface with the larger share of facing area is the first one. Surfaces
  !> without facets are left out, and so are those with a facet that is not a side of exactly one cell. Where the same facets have
  !> several names, one pair remains (without_overlaps).
  !>
  !> A facet faces the other surface if gaps_between finds a gap, and no third surface lies between. A third surface lies between if
  !> it has no body in common with the facet's surface, and the gap to it is less than half as wide, and smaller by more than a
  !> tenth of the mean facet size of the facet's surface.
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
        if (max(one%front_share, other%front_share) < enough) cycle
        if (other%share > one%share) one = other
        pairs = [pairs, one]
      end do
    end do
    pairs = without_overlaps(mesh, pairs)
  end subroutine find_facing_groups

  !> Returns the pairs, in the same order, without those that overlap with a better one: that have facets of both its surfaces. The
  !> better pair has the larger facing area; of pairs with at least 0.9 times the largest one, that with the smaller surfaces, then
  !> the first one.
  function without_overlaps(mesh, pairs) result(kept)
    type(mesh_t), intent(in) :: mesh
    type(facing_groups_t), intent(in) :: pairs(:)
    type(facing_groups_t), allocatable :: kept(:)
    logical :: is_left(size(pairs)), is_kept(size(pairs))
    integer :: best, i

    is_left = .true.
    is_kept = .false.
    do while (any(is_left))
      associate (is_large => is_left .and. pairs%facing_area >= nearly_all * maxval(pairs%facing_area, mask=is_left))
        best = minloc(pairs%whole_area, dim=1, mask=is_large)
      end associate
      is_kept(best) = .true.
      do i = 1, size(pairs)
        if (is_left(i)) is_left(i) = .not. overlap(mesh, pairs(i), pairs(best))
      end do
    end do
    kept = pack(pairs, is_kept)
  end function without_overlaps

  !> Whether two pairs have common facets on both sides. A pair overlaps with itself.
  pure logical function overlap(mesh, one, other)
    type(mesh_t), intent(in) :: mesh
    type(facing_groups_t), intent(in) :: one, other

    overlap = (have_common_facet(mesh, one%first, other%first) .and. have_common_facet(mesh, one%second, other%second)) .or. &
      (have_common_facet(mesh, one%first, other%second) .and. have_common_facet(mesh, one%second, other%first))
  end function overlap

  !> Whether two groups of facets have a facet in common.
  pure logical function have_common_facet(mesh, i_group, i_other)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_group, i_other
    logical :: is_in(mesh%n_facets)

    is_in = .false.
    is_in(mesh%groups(i_group)%entities) = .true.
    have_common_facet = any(is_in(mesh%groups(i_other)%entities))
  end function have_common_facet

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
  !> size if this is more). Facets that overlap by more than half the larger mean facet size of both surfaces (the smaller one if
  !> both are flat, because then the gap has no error of coarse facets), or overlap side by side, as the opposite sides of two thin
  !> plates in a row, have a huge gap, too.
  pure function gaps_between(surface, other) result(gaps)
    type(surface_t), intent(in) :: surface
    type(surface_t), intent(in) :: other
    real(rk) :: gaps(size(surface%centers, 2))
    real(rk) :: distance, gap, least, size_here
    integer :: i, nearest

    gaps = huge(gaps)
    least = -deepest * max(surface%facet_size, other%facet_size)
    if (surface%is_flat .and. other%is_flat) least = -deepest * min(surface%facet_size, other%facet_size)
    do i = 1, size(gaps)
      call other%tree%nearest(surface%centers(:, i), nearest, distance)
      associate (normal => surface%area_vectors(:, i) / norm2(surface%area_vectors(:, i)), across => other%area_vectors(:, nearest))
        if (distance > max(surface%reach, other%reach) .or. dot_product(normal, across) > opposite * norm2(across)) cycle
        gap = dot_product(normal, other%centers(:, nearest) - surface%centers(:, i))
        if (gap < least) cycle
        size_here = max(norm2(surface%area_vectors(:, i)), norm2(across))**(1.0_rk / (size(normal) - 1))
        if (gap < 0 .and. distance**2 - gap**2 > (beside * size_here)**2) cycle
      end associate
      gaps(i) = gap
    end do
  end function gaps_between

  !> Returns the pair with `surface` as the first one: the share of its area that faces the other surface, and the gaps there. Where
  !> nothing faces the share is 0, and the gaps must not be used. Requires: surface%least_gap counts all surfaces of other bodies.
  pure type(facing_groups_t) function face(surface, other) result(pair)
    type(surface_t), intent(in) :: surface
    type(surface_t), intent(in) :: other
    real(rk), dimension(size(surface%centers, 2)) :: areas, gaps
    logical, dimension(size(areas)) :: is_facing, is_front
    real(rk) :: toward(size(surface%centers, 1))

    areas = norm2(surface%area_vectors, dim=1)
    gaps = gaps_between(surface, other)
    is_facing = gaps < huge(gaps)
    where (is_facing) is_facing = gaps <= surface%least_gap + max(abs(surface%least_gap), between * surface%facet_size)
    toward = matmul(surface%area_vectors, merge(1.0_rk, 0.0_rk, is_facing))
    is_front = is_facing .or. matmul(toward, surface%area_vectors) > -opposite * norm2(toward) * areas
    pair%first = surface%group
    pair%second = other%group
    pair%facing_area = sum(areas, mask=is_facing)
    pair%whole_area = sum(areas) + sum(norm2(other%area_vectors, dim=1))
    pair%share = pair%facing_area / sum(areas)
    if (any(is_facing)) pair%front_share = pair%facing_area / sum(areas, mask=is_front)
    pair%gap = [minval(gaps, mask=is_facing), maxval(gaps, mask=is_facing)]
    pair%is_flat = surface%is_flat .and. other%is_flat
    where (abs(pair%gap) < rounding_of_data * surface%reach) pair%gap = 0
    if (other%is_flat .and. .not. surface%is_flat) pair%direction = other%direction
  end function face
end module sig_facing_groups
