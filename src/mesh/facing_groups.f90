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

  !> Two surfaces of different bodies. The first one faces the other with the larger share of its area.
  type :: facing_groups_t
    !> numbers of the groups in the mesh
    integer :: first = 0
    integer :: second = 0
    !> [-] share of the first surface's area that faces the second one
    real(rk) :: share = 0
    !> [length] least and largest distance along the normals of the first one, negative where they overlap
    real(rk) :: gap(2) = 0
  end type facing_groups_t

  !> A named surface with the data for the search.
  type :: surface_t
    integer :: group = 0
    integer :: body = 0
    !> [length] distance up to which the search looks across a gap
    real(rk) :: reach = 0
    !> [length] center of each facet, and its normal times its size; shape (n_dim, n_facets)
    real(rk), allocatable :: centers(:, :)
    real(rk), allocatable :: area_vectors(:, :)
    type(k_d_tree_t) :: tree
  end type surface_t

  !> [-] share of the area that has to face the other surface; for two disks that touch it is a quarter
  real(rk), parameter :: enough = 0.2_rk
  !> [-] cosine between normals that counts as opposite: 60 degrees
  real(rk), parameter :: opposite = -0.5_rk
  !> [-] share of a surface's length up to which a gap is bridged, and the same limit as a number of facets
  real(rk), parameter :: of_length = 0.1_rk
  real(rk), parameter :: of_facets = 2
  !> [-] share of this distance below which a gap counts as zero
  real(rk), parameter :: rounding = 1.0e-9_rk

contains

  !> Guesses the contact pairs, in the order of the groups.
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

  !> Measures the surfaces that are the outside of one body.
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

  !> Computes how much of a surface faces another one.
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
