! SPDX-License-Identifier: BSD-3-Clause
!> The section `contact` of a deck: surfaces that may touch.
module sig_deck_read_contact
  use sig_deck_config, only: averaged_tolerance, contact_config_t
  use sig_deck_tree, only: deck_tree_t, kind_mapping, root_node
  use sig_deck_values, only: get_list, get_name, get_number, number_of, value_of
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: read_contact

contains

  !> Surfaces that may touch.
  subroutine read_contact(tree, contact)
    type(deck_tree_t), intent(inout) :: tree
    type(contact_config_t), allocatable, intent(out) :: contact(:)
    integer, allocatable :: nodes(:)
    integer :: i, i_list

    nodes = [integer ::]
    i_list = get_list(tree, root_node, 'contact', .true., .false.)
    if (i_list > 0) nodes = tree%children(i_list)
    allocate (contact(size(nodes)))
    do i = 1, size(nodes)
      contact(i)%first%text = ''
      contact(i)%second%text = ''
      allocate (contact(i)%direction(0))
      if (tree%nodes(nodes(i))%kind /= kind_mapping) then
        call tree%report(nodes(i), 'is ' // tree%kind_name(nodes(i)) // '; it must be a mapping {key: value, ...}')
        cycle
      end if
      call get_name(tree, nodes(i), 'first', contact(i)%first)
      call get_name(tree, nodes(i), 'second', contact(i)%second)
      call read_direction(tree, nodes(i), contact(i))
      call get_number(tree, nodes(i), 'pairing_tolerance', .false., contact(i)%pairing_tolerance)
      call read_initial_gap(tree, nodes(i), contact(i))
      call tree%close_mapping(nodes(i))
    end do
  end subroutine read_contact

  subroutine read_direction(tree, i_entry, contact)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    type(contact_config_t), intent(inout) :: contact
    integer, allocatable :: nodes(:)
    real(rk), allocatable :: direction(:)
    integer :: i, i_list
    logical :: is_valid, are_all_valid

    contact%has_direction = tree%find(i_entry, 'direction') > 0
    if (.not. contact%has_direction) contact%pairing_tolerance = averaged_tolerance
    i_list = get_list(tree, i_entry, 'direction', .false., .false.)
    if (i_list == 0) return
    contact%direction_line = tree%nodes(i_list)%line
    contact%direction_column = tree%nodes(i_list)%column
    nodes = tree%children(i_list)
    allocate (direction(size(nodes)), source=0.0_rk)
    are_all_valid = .true.
    do i = 1, size(nodes)
      call number_of(tree, nodes(i), direction(i), is_valid)
      are_all_valid = are_all_valid .and. is_valid
    end do
    ! left empty otherwise, so that its length is not checked
    if (are_all_valid) contact%direction = direction
  end subroutine read_direction

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
    ! reported; the checks that follow must not trip over it
    if (.not. is_valid) contact%initial_gap%is_constant = .true.
  end subroutine read_initial_gap
end module sig_deck_read_contact
