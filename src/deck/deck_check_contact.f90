! SPDX-License-Identifier: BSD-3-Clause
!> What the entries of the section `contact` must satisfy.
module sig_deck_check_contact
  use sig_deck_check_values, only: check_field
  use sig_deck_config, only: contact_config_t, deck_config_t
  use sig_deck_tree, only: deck_tree_t, shown
  use sig_kinds, only: rk
  use sig_mechanical_models, only: components_text, mechanical_model, mechanical_model_t
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: check_contact

contains

  !> One entry, by itself and against those before it.
  subroutine check_contact(tree, config, i_contact)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    integer, intent(in) :: i_contact
    character(:), allocatable :: path
    integer :: i

    path = 'contact[' // to_text(i_contact) // ']'
    associate (entry => config%contact(i_contact))
      if (len(entry%first%text) > 0 .and. entry%first%text == entry%second%text) call tree%report_at(path // '.second', &
        'is ' // shown(entry%second%text) // ' like first; it must be another surface')
      do i = 1, i_contact - 1
        if (are_same_surfaces(config%contact(i), entry)) call tree%report_at(path // '.first', &
          'and second are the surfaces of contact[' // to_text(i) // '] already')
      end do
      call check_direction(tree, path // '.direction', entry%direction, mechanical_model(config%mesh%model))
      if (entry%pairing_tolerance <= 0 .or. entry%pairing_tolerance > 0.5_rk) call tree%report_at(path // '.pairing_tolerance', &
        'is ' // to_text(entry%pairing_tolerance) // '; it must be greater than 0 and at most 0.5 (times the mesh size)')
      if (entry%has_initial_gap) call check_field(tree, path // '.initial_gap', config%parameters, entry%initial_gap)
    end associate
  end subroutine check_contact

  pure logical function are_same_surfaces(one, other)
    type(contact_config_t), intent(in) :: one
    type(contact_config_t), intent(in) :: other

    are_same_surfaces = .false.
    if (len(one%first%text) == 0 .or. len(one%second%text) == 0) return
    are_same_surfaces = (one%first%text == other%first%text .and. one%second%text == other%second%text) .or. &
      (one%first%text == other%second%text .and. one%second%text == other%first%text)
  end function are_same_surfaces

  subroutine check_direction(tree, path, direction, model)
    type(deck_tree_t), intent(inout) :: tree
    character(*), intent(in) :: path
    !> empty where it could not be read
    real(rk), intent(in) :: direction(:)
    type(mechanical_model_t), intent(in) :: model

    if (size(direction) == 0) return
    if (size(direction) /= model%n_dim) then
      call tree%report_at(path, 'has length ' // to_text(size(direction)) // '; ' // components_text(model))
    else if (norm2(direction) < tiny(1.0_rk)) then
      call tree%report_at(path, 'is a zero vector; it must point from the first surface to the second')
    end if
  end subroutine check_direction
end module sig_deck_check_contact
