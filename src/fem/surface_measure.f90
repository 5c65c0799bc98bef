! SPDX-License-Identifier: BSD-3-Clause
!> Computes the area of each node of a surface, the integral of its shape function. A nodal force over this area is a pressure.
module sig_surface_measure
  use sig_elastic_body, only: elastic_body_t
  use sig_kinds, only: rk
  use sig_mechanical_models, only: circumference
  use sig_mesh, only: mesh_t
  implicit none(type, external)
  private
  public :: nodal_areas

contains

  !> Returns for each node the integral of its shape function over the facets: per unit thickness in the plane, with the factor 2 pi
  !> r in axisymmetry. It is zero at nodes of no facet, and zero or negative at corners of some quadratic facets (see
  !> has_weak_corners). Local.
  pure function nodal_areas(mesh, body, facets) result(areas)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: facets(:)
    !> [length**2, length in the plane] shape (n_nodes)
    real(rk) :: areas(mesh%n_nodes)
    integer :: i, i_point
    integer, allocatable :: nodes(:)

    areas = 0
    do i = 1, size(facets)
      nodes = mesh%facet_nodes(mesh%facet_offsets(facets(i)) + 1:mesh%facet_offsets(facets(i) + 1))
      associate (table => body%tables(mesh%facet_types(facets(i))))
        do i_point = 1, table%n_points
          areas(nodes) = areas(nodes) + table%values(:, i_point) * table%weights(i_point) * &
            stretch(matmul(mesh%coordinates(:, nodes), transpose(table%gradients(:, :, i_point)))) * &
            circumference(body%mechanics, matmul(mesh%coordinates(:, nodes), table%values(:, i_point)))
        end do
      end associate
    end do
  end function nodal_areas

  !> Returns the length of one tangent, or the area between two of them: square root of det(J' J).
  pure real(rk) function stretch(tangents)
    !> [length] shape (n_dim, n_dim - 1)
    real(rk), intent(in) :: tangents(:, :)

    if (size(tangents, 2) == 1) then
      stretch = norm2(tangents(:, 1))
    else
      stretch = sqrt(max(0.0_rk, sum(tangents(:, 1)**2) * sum(tangents(:, 2)**2) - &
        dot_product(tangents(:, 1), tangents(:, 2))**2))
    end if
  end function stretch
end module sig_surface_measure
