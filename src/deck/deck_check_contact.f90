! SPDX-License-Identifier: BSD-3-Clause
!> Checks of the entries of the section `contact`.
module sig_deck_check_contact
  use sig_deck_check_values, only: check_field, check_range
  use sig_deck_config, only: contact_config_t, deck_config_t, value_config_t
  use sig_deck_tree, only: deck_tree_t, shown
  use sig_kinds, only: rk
  use sig_mechanical_models, only: components_text, mechanical_model, mechanical_model_t
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: check_contact

contains

  !> Checks one entry of the section contact. With an obstacle: as check_obstacle describes. Without one: its two surfaces must
  !> differ, and no entry before it may have the same two, in either order; its direction (if given), pairing_tolerance,
  !> search_distance and initial_gap (if given) must be valid. Names of surfaces are checked when the mesh is read.
  subroutine check_contact(tree, config, i_contact)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    !> number of the entry, 1-based
    integer, intent(in) :: i_contact
    character(:), allocatable :: path
    integer :: i

    path = 'contact[' // to_text(i_contact) // ']'
    associate (entry => config%contact(i_contact))
      if (len(entry%first%text) > 0 .and. entry%first%text == entry%second%text) call tree%report_at(path // '.second', &
        'is ' // shown(entry%second%text) // ', the same as first; it must be another surface')
      do i = 1, i_contact - 1
        if (.not. are_same_surfaces(config%contact(i), entry)) cycle
        call tree%report_at(path // '.first', 'and second are the two surfaces of contact[' // to_text(i) // &
          ']; a pair may be given only once, in either order')
        ! one message is enough: a deck may repeat the entry hundreds of times
        exit
      end do
      call check_law(tree, path, config, entry)
      if (entry%has_obstacle) then
        call check_obstacle(tree, path, config, entry)
        return
      end if
      call check_direction(tree, path // '.direction', entry%direction, mechanical_model(config%mesh%model))
      if (entry%pairing_tolerance <= 0 .or. entry%pairing_tolerance > 0.5_rk) call tree%report_at(path // '.pairing_tolerance', &
        'is ' // to_text(entry%pairing_tolerance) // '; it must be greater than 0 and at most 0.5 (times the mesh size of first)')
      if (entry%has_search_distance .and. entry%search_distance <= 0) call tree%report_at(path // '.search_distance', &
        'is ' // to_text(entry%search_distance) // '; it must be greater than 0')
      if (entry%has_initial_gap) call check_field(tree, path // '.initial_gap', config, entry%initial_gap)
    end associate
  end subroutine check_contact

  !> Checks that the coefficient of friction is finite and not negative, and that a tied entry has neither this nor a gap.
  subroutine check_law(tree, path, config, entry)
    type(deck_tree_t), intent(inout) :: tree
    !> key path of the contact entry
    character(*), intent(in) :: path
    type(deck_config_t), intent(in) :: config
    type(contact_config_t), intent(in) :: entry

    if (entry%tied /= 'false' .and. entry%has_initial_gap) call tree%report_at(path // '.initial_gap', &
      'and tied exclude each other', 'tied surfaces keep the gaps and overlaps of the mesh as they are')
    if (.not. entry%has_friction) return
    if (entry%tied == 'false') then
      call check_range(tree, path // '.friction', config, entry%friction, 0.0_rk, huge(1.0_rk), '', may_be_bound=.true.)
    else
      call tree%report_at(path // '.friction', 'and tied exclude each other', &
        'surfaces that are bonded do not slip (tied: true), and those that slip with friction may open')
    end if
  end subroutine check_law

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
    !> direction of the entry; empty if it is not given or could not be read
    real(rk), intent(in) :: direction(:)
    type(mechanical_model_t), intent(in) :: model

    if (size(direction) == 0) return
    if (size(direction) /= model%n_dim) then
      call tree%report_at(path, 'has length ' // to_text(size(direction)) // '; ' // components_text(model))
    else if (norm2(direction) < tiny(1.0_rk)) then
      call tree%report_at(path, 'is a zero vector; it must have a direction')
    end if
  end subroutine check_direction

  !> Checks an obstacle. Its point or center needs finite components, one for each axis; nothing else is checked if their number
  !> is wrong. A half space must have a valid normal; a sphere a radius above 0 and, in the entry, a valid direction. In an
  !> axisymmetric model check_level and check_on_axis say what else must hold. Vectors that could not be read are not checked.
  subroutine check_obstacle(tree, path, config, entry)
    type(deck_tree_t), intent(inout) :: tree
    !> key path of the contact entry
    character(*), intent(in) :: path
    type(deck_config_t), intent(in) :: config
    !> the contact entry, which has an obstacle
    type(contact_config_t), intent(in) :: entry
    type(mechanical_model_t) :: model
    character(:), allocatable :: key
    integer :: i

    model = mechanical_model(config%mesh%model)
    key = path // '.obstacle.center'
    if (entry%obstacle%type == 'half_space') key = path // '.obstacle.point'
    associate (obstacle => entry%obstacle)
      if (size(obstacle%place) > 0 .and. size(obstacle%place) /= model%n_dim) then
        call tree%report_at(key, 'has length ' // to_text(size(obstacle%place)) // '; ' // components_text(model))
        return
      end if
      do i = 1, size(obstacle%place)
        call check_field(tree, key // '[' // to_text(i) // ']', config, obstacle%place(i))
      end do
      if (obstacle%type == 'half_space') then
        call check_direction(tree, path // '.obstacle.normal', obstacle%normal, model)
        if (model%is_round) call check_level(tree, path // '.obstacle.normal', obstacle%normal)
      else
        call check_direction(tree, path // '.direction', entry%direction, model)
        call check_range(tree, path // '.obstacle.radius', config, obstacle%radius, 0.0_rk, huge(1.0_rk), &
          ' ' // config%units%length)
        if (model%is_round .and. size(obstacle%place) > 0) call check_on_axis(tree, key // '[1]', obstacle%place(1), &
          config%units%length)
      end if
    end associate
  end subroutine check_obstacle

  !> Checks that the face of a half space is normal to the axis of an axisymmetric model: the radial component of its normal is
  !> exactly 0. Does nothing if the normal has not two components. Requires: the model is axisymmetric.
  subroutine check_level(tree, path, normal)
    type(deck_tree_t), intent(inout) :: tree
    !> key path of the normal
    character(*), intent(in) :: path
    !> components r and z
    real(rk), intent(in) :: normal(:)

    if (size(normal) /= 2) return
    if (abs(normal(1)) > 0) call tree%report_at(path, 'has the radial component ' // to_text(normal(1)) // &
      '; in an axisymmetric model a half space must be normal to the axis', 'write normal: [0, 1] or [0, -1]')
  end subroutine check_level

  !> Checks that the center of a sphere lies on the axis of an axisymmetric model: its coordinate r is a constant and exactly 0.
  !> Requires: the model is axisymmetric.
  subroutine check_on_axis(tree, path, radius, unit)
    type(deck_tree_t), intent(inout) :: tree
    !> key path of the coordinate r
    character(*), intent(in) :: path
    !> coordinate r of the center, not the radius of the sphere
    type(value_config_t), intent(in) :: radius
    !> unit of length for the message, without a blank before it
    character(*), intent(in) :: unit
    character(*), parameter :: rule = '; in an axisymmetric model the center must lie on the axis r = 0'

    if (.not. radius%is_constant) then
      call tree%report_at(path, 'is ' // shown(radius%text) // rule)
    else if (abs(radius%constant) > 0) then
      call tree%report_at(path, 'is ' // to_text(radius%constant) // ' ' // unit // rule)
    end if
  end subroutine check_on_axis
end module sig_deck_check_contact
