! SPDX-License-Identifier: BSD-3-Clause
!> Gaps of a mortar contact at the nodes of its first surface: the distance to the second surface along the contact normal.
!>
!> Means of the gap with the dual functions would be less, because these are negative in places: at the node that touches, by
!> h**2 / (12 R) for a cylinder of radius R on edges of length h, so that bodies which only touch would press each other.
module sig_node_gaps
  use sig_cross_products, only: cross_product
  use sig_element_types, only: element_types, n_element_types
  use sig_facet_shapes, only: create_shapes, facet_shape_t
  use sig_kinds, only: rk
  use sig_mortar_sides, only: mortar_side_t
  use sig_rounding, only: rounding
  use sig_smooth_surfaces, only: bulge_at
  implicit none(type, external)
  private
  public :: find_node_gaps

  !> [-] two normals are opposite enough for contact if their product is at most this
  real(rk), parameter :: grazing = -0.1_rk
  !> [-] in the reference element: a place may be outside by this much, when the line meets the edge of a facet
  real(rk), parameter :: margin = 1.0e-6_rk

contains

  !> Finds where the line through each node along its normal meets the second surface, in front or behind. The nearest of several
  !> places counts. Facets are those of the smooth surface that they represent (sig_smooth_surfaces). Cost: O(n log n).
  pure subroutine find_node_gaps(places, normals, second, limit, gaps, is_met)
    !> [length] places of the nodes, shape (n_dim, n)
    real(rk), intent(in) :: places(:, :)
    !> [-] their contact normals, unit vectors from the first body to the second, same shape
    real(rk), intent(in) :: normals(:, :)
    type(mortar_side_t), intent(in) :: second
    !> [length] search distance: what is farther away is not met
    real(rk), intent(in) :: limit
    !> [length] negative where the surfaces overlap; of no use at nodes that meet nothing; shape (n)
    real(rk), intent(out) :: gaps(:)
    !> whether the line of a node meets the second surface, shape (n)
    logical, intent(out) :: is_met(:)
    type(facet_shape_t) :: shapes(n_element_types)
    integer, allocatable :: near(:)
    real(rk) :: gap
    logical :: is_hit
    integer :: i, k

    call create_shapes(size(places, 1), shapes)
    gaps = huge(gaps)
    do i = 1, size(gaps)
      call second%balls%within(places(:, i), 0.0_rk, near, normals(:, i))
      do k = 1, size(near)
        if (dot_product(normals(:, i), second%outward(:, near(k))) > grazing) cycle
        call meet_facet(shapes, places(:, i), normals(:, i), second, near(k), gap, is_hit)
        if (is_hit .and. abs(gap) < abs(gaps(i))) gaps(i) = gap
      end do
    end do
    is_met = abs(gaps) <= limit
  end subroutine find_node_gaps

  !> Finds where the line through a point along a normal meets a facet or, of a linear one, the smooth surface over it: the place of
  !> the facet over which the line meets the surface, in a few rounds, because the surface stands out by little.
  pure subroutine meet_facet(shapes, point, normal, side, i_facet, gap, is_hit)
    !> result of create_shapes
    type(facet_shape_t), intent(in) :: shapes(:)
    !> [length] and [-], shape (n_dim)
    real(rk), intent(in) :: point(:), normal(:)
    type(mortar_side_t), intent(in) :: side
    integer, intent(in) :: i_facet
    !> [length] from the point to the surface along the normal; of no use without is_hit
    real(rk), intent(out) :: gap
    logical, intent(out) :: is_hit
    integer, parameter :: most_rounds = 20
    real(rk) :: axes(size(point) - 1, size(point)), place(size(point) - 1), bulge, bulge_before
    integer :: i_round

    axes = axes_across(normal)
    gap = 0
    bulge = 0
    associate (shape => shapes(side%types(i_facet)), outward => side%outward(:, i_facet), from => side%offsets(i_facet) + 1, &
      to => side%offsets(i_facet + 1))
      associate (vertices => side%vertices(:, from:to) - spread(point, 2, to - from + 1))
        do i_round = 1, most_rounds
          call shape%find_place(matmul(axes, vertices), -bulge * matmul(axes, outward), place, is_hit)
          if (.not. is_hit) return
          bulge_before = bulge
          bulge = bulge_at(shapes, side, i_facet, place)
          if (abs(bulge - bulge_before) <= rounding * abs(bulge)) exit
        end do
        is_hit = i_round <= most_rounds .and. is_inside(shape%i_type, place)
        if (is_hit) gap = dot_product(normal, matmul(vertices, shape%values(place)) + bulge * outward)
      end associate
    end associate
  end subroutine meet_facet

  !> Whether a place lies in the reference element of a facet, or outside of it by rounding.
  pure logical function is_inside(i_type, place)
    !> row of element_types
    integer, intent(in) :: i_type
    !> [-]
    real(rk), intent(in) :: place(:)

    if (element_types(i_type)%n_corners == 3) then
      is_inside = all(place > -margin) .and. sum(place) < 1 + margin
    else
      is_inside = all(abs(place) < 1 + margin)
    end if
  end function is_inside

  !> Returns unit vectors across a normal and each other [-], one per row, shape (n_dim - 1, n_dim).
  pure function axes_across(normal) result(axes)
    real(rk), intent(in) :: normal(:)
    real(rk) :: axes(size(normal) - 1, size(normal))
    integer :: least

    if (size(normal) == 2) then
      axes(1, :) = [normal(2), -normal(1)]
      return
    end if
    least = minloc(abs(normal), dim=1)
    axes(1, :) = -normal(least) * normal
    axes(1, least) = axes(1, least) + 1
    axes(1, :) = axes(1, :) / norm2(axes(1, :))
    axes(2, :) = cross_product(normal, axes(1, :))
  end function axes_across
end module sig_node_gaps
