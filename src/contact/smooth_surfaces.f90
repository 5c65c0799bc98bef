! SPDX-License-Identifier: BSD-3-Clause
!> Heights of the smooth surface that linear facets represent, at any place of a facet.
module sig_smooth_surfaces
  use sig_element_types, only: element_type_with
  use sig_facet_shapes, only: facet_shape_t
  use sig_kinds, only: rk
  use sig_mortar_sides, only: mortar_side_t
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

  !> Returns how far [length] the surface stands out from a linear facet, by the functions of a quadratic facet's mid-side nodes; 0
  !> for a facet that is quadratic itself.
  pure real(rk) function bulge_at(shapes, side, i_facet, place) result(bulge)
    !> result of create_shapes
    type(facet_shape_t), intent(in) :: shapes(:)
    type(mortar_side_t), intent(in) :: side
    integer, intent(in) :: i_facet
    !> [-] in the reference element
    real(rk), intent(in) :: place(:)
    integer :: n_edges, n_nodes

    bulge = 0
    associate (bulges => side%bulges(side%offsets(i_facet) + 1:side%offsets(i_facet + 1)))
      if (.not. any(abs(bulges) > 0)) return
      n_nodes = size(bulges)
      n_edges = merge(1, n_nodes, n_nodes == 2)
      associate (values => shapes(element_type_with(size(place), n_nodes + n_edges))%values(place))
        bulge = dot_product(bulges(:n_edges), values(n_nodes + 1:))
      end associate
    end associate
  end function bulge_at
end module sig_smooth_surfaces
