! SPDX-License-Identifier: BSD-3-Clause
!> Guesses which named surfaces of a mesh face each other, by the centers of their facets. `signorom init` needs it for a first
!> deck.
module sig_facing_groups
  use sig_bodies, only: find_bodies
  use sig_k_d_tree, only: k_d_tree_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t, nodes_of_facet
  use sig_surface_geometry, only: measure_surface, surface_geometry_t
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
    !> overlap; 0 below 1e-9 of the reach
    real(rk) :: gap(2) = 0
  end type facing_groups_t

  !> A named surface with the data for the search.
  type :: surface_t
    integer :: group = 0
    integer :: body = 0
    !> [length] largest distance at which another surface counts as facing
    real(rk) :: reach = 0
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

  !> Finds all pairs of named surfaces of different bodies of which one faces the other with at least a fifth of its area. A facet
  !> counts as facing if the nearest facet of the other surface (by their centers) has a normal within 60 degrees of the opposite
  !> direction and is not farther away than the larger `reach` of both surfaces: 0.1 times the diagonal of the box around a surface,
  !> or 2 times its mean facet size if this is more. The pairs are in the order of the groups. A surface that is not the outside of
  !> exactly one body is left out.
  subroutine find_facing_groups(mesh, pairs)
    type(mesh_t), intent(in) :: mesh
    type(facing_groups_t), allocatable, intent(out) :: pairs(:)
    type(surface_t), allocatable :: surfaces(:)
    type(facing_groups_t) :: one, other
    integer :: i, k

    call measure_surfaces(mesh, surfaces)
    allocate (pairs(0))
    do i = 1, size(surfaces)
      do k = i + 1, size(surfaces)
        if (surfaces(i)%body == surfaces(k)%body) cycle
        one = face(surfaces(i), surfaces(k))
        other = face(surfaces(k), surfaces(i))
        if (other%share > one%share) one = other
        if (one%share >= enough) pairs = [pairs, one]
      end do
    end do
  end subroutine find_facing_groups

  !> Measures the named surfaces that are the outside of exactly one body.
  subroutine measure_surfaces(mesh, surfaces)
    type(mesh_t), intent(in) :: mesh
    type(surface_t), allocatable, intent(out) :: surfaces(:)
    type(surface_geometry_t) :: geometry
    type(surface_t) :: surface
    integer, allocatable :: body_of_node(:)
    integer :: i, k, n_bodies

    call find_bodies(mesh, body_of_node, n_bodies)
    allocate (surfaces(0))
    do i = 1, size(mesh%groups)
      associate (group => mesh%groups(i))
        if (group%n_dim /= mesh%n_dim - 1 .or. size(group%entities) == 0) cycle
        call measure_surface(mesh, i, geometry)
        if (geometry%inner_facet > 0) cycle
        surface = surface_t(group=i, body=body_of_node(group%nodes(1)))
        if (any(body_of_node(group%nodes) /= surface%body)) cycle
        allocate (surface%centers(mesh%n_dim, size(group%entities)))
        do k = 1, size(group%entities)
          associate (nodes => nodes_of_facet(mesh, group%entities(k)))
            surface%centers(:, k) = sum(mesh%coordinates(:, nodes), dim=2) / size(nodes)
          end associate
        end do
        surface%area_vectors = geometry%area_vectors
        surface%reach = max(of_facets * geometry%mesh_size, of_length * length_of(mesh%coordinates(:, group%nodes)))
        call surface%tree%create(surface%centers)
        surfaces = [surfaces, surface]
      end associate
    end do
  end subroutine measure_surfaces

  !> Returns the diagonal [length] of the box around points.
  pure real(rk) function length_of(points)
    real(rk), intent(in) :: points(:, :)

    length_of = norm2(maxval(points, dim=2) - minval(points, dim=2))
  end function length_of

  !> Computes the share of a surface's area that faces another surface, and the gaps there. Where nothing faces the share is 0, and
  !> the gaps must not be used.
  pure type(facing_groups_t) function face(surface, other) result(pair)
    type(surface_t), intent(in) :: surface
    type(surface_t), intent(in) :: other
    real(rk) :: area, distance, gap, total
    integer :: i, nearest

    pair = facing_groups_t(surface%group, other%group, 0.0_rk, [huge(gap), -huge(gap)])
    total = 0
    do i = 1, size(surface%centers, 2)
      area = norm2(surface%area_vectors(:, i))
      total = total + area
      call other%tree%nearest(surface%centers(:, i), nearest, distance)
      associate (normal => surface%area_vectors(:, i) / area, across => other%area_vectors(:, nearest))
        if (distance > max(surface%reach, other%reach) .or. dot_product(normal, across) > opposite * norm2(across)) cycle
        gap = dot_product(normal, other%centers(:, nearest) - surface%centers(:, i))
      end associate
      pair%share = pair%share + area
      pair%gap = [min(pair%gap(1), gap), max(pair%gap(2), gap)]
    end do
    pair%share = pair%share / total
    where (abs(pair%gap) < rounding * surface%reach) pair%gap = 0
  end function face
end module sig_facing_groups
