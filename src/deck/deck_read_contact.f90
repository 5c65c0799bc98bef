! SPDX-License-Identifier: BSD-3-Clause
!> Reads the section `contact` of a deck: surfaces that may touch each other or a rigid obstacle.
module sig_deck_read_contact
  use sig_deck_config, only: averaged_tolerance, contact_config_t, obstacle_config_t, value_config_t
  use sig_deck_tree, only: deck_tree_t, kind_scalar, root_node
  use sig_deck_values, only: get_choice, get_list, get_list_entries, get_mapping, get_name, get_number, is_mapping, &
    number_of, value_of
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: read_contact

  character(*), parameter :: obstacle_types(2) = [character(10) :: 'half_space', 'sphere']
  character(*), parameter :: formulations(3) = [character(12) :: 'auto', 'node_to_node', 'mortar']
  character(*), parameter :: ties(3) = [character(6) :: 'false', 'true', 'normal']
  character(*), parameter :: switches(6) = [character(5) :: 'true', 'false', 'yes', 'no', 'on', 'off']
  character(*), parameter :: of_parameters = 'a number or an expression of the parameters'

contains

  !> Reads the section contact, one element of `contact` per entry; none without the section. Errors: an unknown key, a value that
  !> is missing or faulty (a harmless value stands in its place).
  subroutine read_contact(tree, contact)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(contact_config_t), allocatable, intent(out) :: contact(:)
    character(:), allocatable :: formulation
    integer, allocatable :: nodes(:)
    integer :: i

    call get_list_entries(tree, root_node, 'contact', .false., .true., nodes)
    allocate (contact(size(nodes)))
    do i = 1, size(nodes)
      contact(i)%first%text = ''
      contact(i)%second%text = ''
      allocate (contact(i)%direction(0))
      if (.not. is_mapping(tree, nodes(i))) cycle
      call get_name(tree, nodes(i), 'first', contact(i)%first)
      contact(i)%has_obstacle = tree%find(nodes(i), 'obstacle') > 0
      if (contact(i)%has_obstacle) then
        call read_obstacle(tree, nodes(i), contact(i))
      else
        call get_name(tree, nodes(i), 'second', contact(i)%second)
        contact(i)%has_direction = tree%find(nodes(i), 'direction') > 0
        if (.not. contact(i)%has_direction) contact(i)%pairing_tolerance = averaged_tolerance
        call read_direction(tree, nodes(i), .false., contact(i))
        formulation = trim(contact(i)%formulation)
        call get_choice(tree, nodes(i), 'formulation', .false., formulations, formulation)
        contact(i)%formulation = formulation
        call get_number(tree, nodes(i), 'pairing_tolerance', .false., contact(i)%pairing_tolerance)
        contact(i)%has_search_distance = tree%find(nodes(i), 'search_distance') > 0
        call get_number(tree, nodes(i), 'search_distance', .false., contact(i)%search_distance)
        call read_initial_gap(tree, nodes(i), contact(i))
      end if
      call read_law(tree, nodes(i), contact(i))
      call tree%close_mapping(nodes(i))
    end do
  end subroutine read_contact

  !> Reads what the surfaces do along and across each other: friction, or that they are tied.
  subroutine read_law(tree, i_entry, contact)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    type(contact_config_t), intent(inout) :: contact
    character(:), allocatable :: tied
    integer :: i_friction

    i_friction = tree%find(i_entry, 'friction')
    contact%has_friction = i_friction > 0
    if (contact%has_friction) call read_friction(tree, i_friction, contact%friction)
    tied = trim(contact%tied)
    call get_choice(tree, i_entry, 'tied', .false., ties, tied)
    contact%tied = tied
  end subroutine read_law

  !> Reads a coefficient of friction. Errors: those of value_of; a word that switches something on or off.
  subroutine read_friction(tree, i_node, friction)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    type(value_config_t), intent(inout) :: friction
    logical :: is_switch

    is_switch = tree%nodes(i_node)%kind == kind_scalar
    if (is_switch) is_switch = any(tree%nodes(i_node)%text == switches)
    if (is_switch) then
      call tree%report(i_node, 'is ' // tree%kind_name(i_node) // '; it must be the coefficient of friction, a number of at ' // &
        'least 0 or an expression of the parameters and the time', 'write friction: 0.3, or leave the key out where there is ' // &
        'no friction')
      friction = value_config_t(text='0', constant=0.0_rk, line=tree%nodes(i_node)%line, column=tree%nodes(i_node)%column)
      return
    end if
    call read_value(tree, i_node, friction)
  end subroutine read_friction

  subroutine read_direction(tree, i_entry, is_required, contact)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    logical, intent(in) :: is_required
    type(contact_config_t), intent(inout) :: contact
    integer :: i_list

    i_list = get_list(tree, i_entry, 'direction', is_required, .false.)
    if (i_list == 0) return
    contact%direction_line = tree%nodes(i_list)%line
    contact%direction_column = tree%nodes(i_list)%column
    call read_vector(tree, i_list, contact%direction)
  end subroutine read_direction

  !> Reads a list of numbers. If an entry is not a number, adds an error and leaves the vector as it is. Callers pass an empty
  !> vector, so it stays empty after an error, and later checks leave an empty vector out.
  subroutine read_vector(tree, i_list, vector)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_list
    real(rk), allocatable, intent(inout) :: vector(:)
    integer, allocatable :: nodes(:)
    real(rk), allocatable :: numbers(:)
    integer :: i
    logical :: is_valid, are_all_valid

    nodes = tree%children(i_list)
    allocate (numbers(size(nodes)), source=0.0_rk)
    are_all_valid = .true.
    do i = 1, size(nodes)
      call number_of(tree, nodes(i), numbers(i), is_valid)
      are_all_valid = are_all_valid .and. is_valid
    end do
    if (are_all_valid) vector = numbers
  end subroutine read_vector

  subroutine read_initial_gap(tree, i_entry, contact)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    type(contact_config_t), intent(inout) :: contact
    integer :: i_gap
    logical :: is_valid

    i_gap = tree%find(i_entry, 'initial_gap')
    contact%has_initial_gap = i_gap > 0
    if (i_gap == 0) return
    call value_of(tree, i_gap, 'a number or an expression of the parameters and the coordinates', contact%initial_gap, is_valid, &
      may_use_coordinates=.true.)
    ! the error was reported; later checks must not fail on the value
    if (.not. is_valid) contact%initial_gap%is_constant = .true.
  end subroutine read_initial_gap

  !> Reads the obstacle of a contact entry and the direction to it. The direction of a half space is opposite to its normal; for a
  !> sphere the contact entry must have the key direction. Errors: missing or unknown keys, faulty values.
  subroutine read_obstacle(tree, i_entry, contact)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    type(contact_config_t), intent(inout) :: contact
    integer :: i_list, i_obstacle

    contact%has_direction = .true.
    associate (obstacle => contact%obstacle)
      obstacle%type = trim(obstacle_types(1))
      allocate (obstacle%place(0), obstacle%normal(0))
      i_obstacle = get_mapping(tree, i_entry, 'obstacle', .true.)
      if (i_obstacle == 0) return
      obstacle%line = tree%nodes(i_obstacle)%line
      obstacle%column = tree%nodes(i_obstacle)%column
      call get_choice(tree, i_obstacle, 'type', .true., obstacle_types, obstacle%type)
      if (obstacle%type == 'sphere') then
        call read_place(tree, i_obstacle, 'center', obstacle)
        if (tree%find(i_obstacle, 'radius') > 0) then
          call read_value(tree, tree%find(i_obstacle, 'radius'), obstacle%radius)
        else
          obstacle%radius%constant = 1
          call tree%report_key(i_obstacle, tree%key_path(i_obstacle) // '.radius is missing')
        end if
        call read_direction(tree, i_entry, .true., contact)
      else
        call read_place(tree, i_obstacle, 'point', obstacle)
        i_list = get_list(tree, i_obstacle, 'normal', .true., .false.)
        if (i_list > 0) call read_vector(tree, i_list, obstacle%normal)
        contact%direction = -obstacle%normal
      end if
      call tree%close_mapping(i_obstacle)
    end associate
  end subroutine read_obstacle

  subroutine read_place(tree, i_obstacle, key, obstacle)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_obstacle
    character(*), intent(in) :: key
    type(obstacle_config_t), intent(inout) :: obstacle
    integer, allocatable :: nodes(:)
    integer :: i, i_list

    i_list = get_list(tree, i_obstacle, key, .true., .false.)
    if (i_list == 0) return
    nodes = tree%children(i_list)
    deallocate (obstacle%place)
    allocate (obstacle%place(size(nodes)))
    do i = 1, size(nodes)
      call read_value(tree, nodes(i), obstacle%place(i))
    end do
  end subroutine read_place

  !> Reads a number or an expression of the parameters; the number 1 replaces a faulty one.
  subroutine read_value(tree, i_node, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    type(value_config_t), intent(inout) :: value
    logical :: is_valid

    call value_of(tree, i_node, of_parameters, value, is_valid)
    if (.not. is_valid) value = value_config_t(text='1', constant=1.0_rk, line=value%line, column=value%column)
  end subroutine read_value
end module sig_deck_read_contact
