! SPDX-License-Identifier: BSD-3-Clause
!> Checks that axisymmetric bodies lie on one side of the axis x = 0.
module sig_mesh_axis
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_rounding, only: rounding, rounding_of_data
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: check_radii, ends_on_axis

contains

  !> Sets each negative x to 0, if all of them are only rounding errors. Errors: the lowest x is below -1e-12 times the largest size
  !> of a coordinate. Then the message names the node with the lowest x, and no x is changed.
  pure subroutine check_radii(mesh, path, error)
    type(mesh_t), intent(inout) :: mesh
    !> mesh file, for messages
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    integer :: i_node

    i_node = minloc(mesh%coordinates(1, :), dim=1)
    if (mesh%coordinates(1, i_node) < -rounding * maxval(abs(mesh%coordinates))) then
      call make_error(error, 'node ' // to_text(mesh%node_tags(i_node)) // ' has x = ' // &
        to_text(mesh%coordinates(1, i_node)) // '; in an axisymmetric model x is the radius, which must not be negative', &
        file=path, hint='the axis is x = 0: mesh one half of the section, with x >= 0')
    else
      mesh%coordinates(1, :) = max(0.0_rk, mesh%coordinates(1, :))
    end if
  end subroutine check_radii

  !> Whether an edge has a node on the axis, that is, at most 1e-9 of its largest radius away from it.
  pure logical function ends_on_axis(radii)
    !> [length] radii of the edge's nodes, not negative
    real(rk), intent(in) :: radii(:)

    ends_on_axis = minval(radii) <= rounding_of_data * maxval(radii)
  end function ends_on_axis
end module sig_mesh_axis
