! SPDX-License-Identifier: BSD-3-Clause
!> Notes about contact directions of the deck that are far from the normals of the surface.
module sig_direction_notes
  use sig_deck_config, only: contact_config_t
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_checks, only: group_of_surface
  use sig_surface_geometry, only: measure_surface, surface_geometry_t
  use sig_text, only: append_text, string_t, to_text
  implicit none(type, external)
  private
  public :: add_direction_notes

  !> [degrees] contact forces along a direction that is farther from all normals differ much from those along the normals
  real(rk), parameter :: largest_angle = 20

contains

  !> Appends a note for each contact entry whose direction is more than 20 degrees from the outward normals of all facets of its
  !> first surface, such as `direction: [0, 1]` for a ball on a cone. A half space needs none: its forces act along its own normal.
  !> Requires: the surfaces and directions were accepted (open_surfaces).
  pure subroutine add_direction_notes(mesh, deck_path, contact, notes)
    type(mesh_t), intent(in) :: mesh
    character(*), intent(in) :: deck_path
    !> entries of the deck's contact section
    type(contact_config_t), intent(in) :: contact(:)
    type(string_t), allocatable, intent(inout) :: notes(:)
    real(rk) :: angle
    integer :: i

    do i = 1, size(contact)
      if (.not. contact(i)%has_direction) cycle
      if (contact(i)%has_obstacle .and. contact(i)%obstacle%type == 'half_space') cycle
      angle = smallest_angle(mesh, deck_path, contact(i))
      if (angle > largest_angle) call append_text(notes, 'contact[' // to_text(i) // ']: the direction is ' // &
        to_text(nint(angle)) // " degrees or more from the normals of '" // contact(i)%first%text // &
        "', and contact forces act along the direction only: choose the normal where contact is expected")
    end do
  end subroutine add_direction_notes

  !> [degrees] Returns the smallest angle between the direction of an entry and the outward normal of a facet of its first surface.
  pure real(rk) function smallest_angle(mesh, deck_path, entry) result(angle)
    type(mesh_t), intent(in) :: mesh
    character(*), intent(in) :: deck_path
    type(contact_config_t), intent(in) :: entry
    type(surface_geometry_t) :: geometry
    type(error_t), allocatable :: error
    real(rk) :: cosine
    integer :: group, i

    angle = 0
    call group_of_surface(mesh, entry%first, deck_path, group, error)
    if (allocated(error)) return
    call measure_surface(mesh, group, geometry)
    angle = 180
    do i = 1, size(geometry%area_vectors, 2)
      associate (vector => geometry%area_vectors(:, i))
        cosine = dot_product(vector, entry%direction) / max(norm2(vector) * norm2(entry%direction), tiny(cosine))
        angle = min(angle, acos(max(-1.0_rk, min(1.0_rk, cosine))) * 180 / acos(-1.0_rk))
      end associate
    end do
  end function smallest_angle
end module sig_direction_notes
