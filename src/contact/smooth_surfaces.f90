! SPDX-License-Identifier: BSD-3-Clause
!> Heights of the smooth surface that facets represent, at any place of a facet.
module sig_smooth_surfaces
  use sig_element_types, only: element_type_with
  use sig_facet_shapes, only: facet_shape_t
  use sig_kinds, only: rk
  use sig_mortar_sides, only: mortar_side_t
  use sig_rounding, only: rounding
  implicit none(type, external)
  private
  public :: bulge_along, bulge_at

contains

  !> Returns how far [length] the surface stands out from a facet against a direction: bulge_at over the cosine of the angle between
  !> the facet and the direction, or over 0.1 if the cosine is smaller.
  pure real(rk) function bulge_along(shapes, side, i_facet, place, direction) result(bulge)
    type(facet_shape_t), intent(in) :: shapes(:)
    type(mortar_side_t), intent(in) :: side
    integer, intent(in) :: i_facet
    !> [-] in the reference element
    real(rk), intent(in) :: place(:)
    !> [-] unit vector that points into the body behind the facet, shape (n_dim)
    real(rk), intent(in) :: direction(:)
    !> [-] facets that lean more do not face each other
    real(rk), parameter :: least_cosine = 0.1_rk

    bulge = bulge_at(shapes, side, i_facet, place) / max(least_cosine, -dot_product(direction, side%outward(:, i_facet)))
  end function bulge_along

  !> Returns how far [length] the surface stands out from a facet: in the plane it is an arc of a circle, over edges of two nodes by
  !> the height of its middle, over edges of three nodes the circle through them; in space, it is given by the functions of a
  !> quadratic facet's mid-side nodes over linear facets, and quadratic facets are the surface themselves.
  pure real(rk) function bulge_at(shapes, side, i_facet, place) result(bulge)
    !> result of create_shapes
    type(facet_shape_t), intent(in) :: shapes(:)
    type(mortar_side_t), intent(in) :: side
    integer, intent(in) :: i_facet
    !> [-] in the reference element
    real(rk), intent(in) :: place(:)
    integer :: n_edges, n_nodes

    bulge = 0
    associate (from => side%offsets(i_facet) + 1, to => side%offsets(i_facet + 1))
      associate (bulges => side%bulges(from:to), vertices => side%vertices(:, from:to))
        n_nodes = size(bulges)
        if (size(place) == 1 .and. n_nodes == 3) then
          associate (values => shapes(side%types(i_facet))%values(place))
            bulge = height_of_circle(vertices, values, side%outward(:, i_facet))
          end associate
          return
        end if
        if (.not. any(abs(bulges) > 0)) return
        n_edges = merge(1, n_nodes, n_nodes == 2)
        associate (values => shapes(element_type_with(size(place), n_nodes + n_edges))%values(place))
          if (n_edges == 1) then
            bulge = height_of_arc(sum((vertices(:, 2) - vertices(:, 1))**2) / 4, bulges(1), values(3))
          else
            bulge = dot_product(bulges(:n_edges), values(n_nodes + 1:))
          end if
        end associate
      end associate
    end associate
  end function bulge_at

  !> Returns the distance [length] along `outward` from a point of an edge of three nodes to the circle through them; 0 if the edge
  !> is straight. With the third node as origin, the circle with the center c is |x|**2 = 2 c.x.
  pure real(rk) function height_of_circle(vertices, values, outward) result(height)
    !> [length] shape (2, 3)
    real(rk), intent(in) :: vertices(:, :)
    !> [-] values of the edge's functions at the point
    real(rk), intent(in) :: values(:)
    !> [-] unit vector
    real(rk), intent(in) :: outward(:)
    real(rk), dimension(2) :: a, b, center, x
    real(rk) :: determinant, level, power

    height = 0
    a = vertices(:, 1) - vertices(:, 3)
    b = vertices(:, 2) - vertices(:, 3)
    determinant = a(1) * b(2) - a(2) * b(1)
    if (abs(determinant) <= rounding * (sum(a**2) + sum(b**2))) return
    center = [sum(a**2) * b(2) - sum(b**2) * a(2), sum(b**2) * a(1) - sum(a**2) * b(1)] / (2 * determinant)
    x = values(1) * a + values(2) * b
    power = sum(x**2) - 2 * dot_product(center, x)
    level = dot_product(x - center, outward)
    height = -power / (level + sign(sqrt(max(0.0_rk, level**2 - power)), level))
  end function height_of_circle

  !> Returns the height [length] of an arc of a circle over its chord. With c half the chord, s the height in the middle and R the
  !> radius, (R - s + height)**2 + x**2 = R**2 and 2 R s = c**2 + s**2.
  pure real(rk) function height_of_arc(square, middle, share) result(height)
    !> [length**2] c**2
    real(rk), intent(in) :: square
    !> [length] s, also negative
    real(rk), intent(in) :: middle
    !> [-] 1 - (x / c)**2
    real(rk), intent(in) :: share

    associate (level => square - middle**2)
      height = 2 * middle * share * square / (level + sqrt(max(0.0_rk, level**2 + 4 * middle**2 * share * square)))
    end associate
  end function height_of_arc
end module sig_smooth_surfaces
