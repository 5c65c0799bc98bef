! SPDX-License-Identifier: BSD-3-Clause
!> Turns all loads of a deck into terms and patterns of nodal forces.
module sig_loads
  use sig_body_load, only: add_body_load
  use sig_deck_config, only: load_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_errors, only: error_t
  use sig_load_pattern, only: load_pattern_t
  use sig_mesh, only: mesh_t
  use sig_surface_load, only: add_surface_load
  use sig_term_set, only: term_set_t
  implicit none(type, external)
  private
  public :: create_loads

contains

  !> Makes the pattern of all loads of the deck, and adds their terms behind those that are there.
  !>
  !> Errors: an unknown surface or region, or another one that group_of_surface or group_of_region refuses; a facet under a pressure
  !> or traction that is not the side of exactly one cell; a function of the place that is not finite. A value that gets one term
  !> per loaded dof is not evaluated here.
  subroutine create_loads(mesh, body, loads, deck_path, terms, pattern, error)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> section loads of the deck
    type(load_config_t), intent(in) :: loads(:)
    !> for messages
    character(*), intent(in) :: deck_path
    !> gets functions of the parameters, and single nodal forces (see add_surface_load)
    type(term_set_t), intent(inout) :: terms
    !> the nodal forces
    type(load_pattern_t), intent(out) :: pattern
    type(error_t), allocatable, intent(out) :: error
    integer :: i, term_of_dof(mesh%n_dim * mesh%n_nodes)

    term_of_dof = 0
    do i = 1, size(loads)
      if (loads(i)%is_body_force) then
        call add_body_load(mesh, body, loads(i), deck_path, terms, pattern, error)
      else
        call add_surface_load(mesh, loads(i), deck_path, terms, term_of_dof, pattern, error)
      end if
      if (allocated(error)) return
    end do
  end subroutine create_loads
end module sig_loads
