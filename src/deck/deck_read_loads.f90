! SPDX-License-Identifier: BSD-3-Clause
!> Reads the section `loads` of a deck: pressures and tractions on boundaries, body forces in regions.
module sig_deck_read_loads
  use sig_deck_config, only: load_config_t, value_config_t
  use sig_deck_tree, only: deck_tree_t, root_node
  use sig_deck_values, only: get_choice, get_list_entries, get_mapping, get_name, is_mapping, value_of
  use sig_mechanical_models, only: components_text, mechanical_model_t
  implicit none(type, external)
  private
  public :: read_axis, read_loads

  character(*), parameter :: load_modes(2) = [character(11) :: 'cut', 'whole_edges']
  !> axes of all mechanical models
  character(*), parameter :: axes(4) = ['x', 'y', 'z', 'r']
  character(*), parameter :: field = 'a number or an expression of the parameters and the coordinates'

contains

  !> Reads the section loads, one element of `loads` per entry; none without the section. Errors: an unknown key, a value that is
  !> missing or faulty (a harmless value stands in its place).
  subroutine read_loads(tree, model, loads)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(mechanical_model_t), intent(in) :: model
    type(load_config_t), allocatable, intent(out) :: loads(:)
    integer, allocatable :: nodes(:)
    integer :: i

    call get_list_entries(tree, root_node, 'loads', .false., .true., nodes)
    allocate (loads(size(nodes)))
    do i = 1, size(nodes)
      loads(i)%target%text = ''
      loads(i)%axes = model%axes
      if (.not. is_mapping(tree, nodes(i))) cycle
      loads(i)%is_body_force = tree%find(nodes(i), 'body_force') > 0
      if (loads(i)%is_body_force) then
        call get_name(tree, nodes(i), 'region', loads(i)%target)
        call read_components(tree, nodes(i), 'body_force', model, loads(i))
      else
        call read_surface_load(tree, nodes(i), model, loads(i))
      end if
      call tree%close_mapping(nodes(i))
    end do
  end subroutine read_loads

  subroutine read_surface_load(tree, i_entry, model, load)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    type(mechanical_model_t), intent(in) :: model
    type(load_config_t), intent(inout) :: load
    character(:), allocatable :: mode
    integer :: i_pressure

    call tree%refuse_key(i_entry, 'region', 'a region takes a body_force; pressure and traction act on a boundary')
    call get_name(tree, i_entry, 'boundary', load%target)
    i_pressure = tree%find(i_entry, 'pressure')
    load%has_pressure = i_pressure > 0
    if (load%has_pressure) call read_field(tree, i_pressure, load%pressure)
    if (tree%find(i_entry, 'traction') > 0) then
      call read_components(tree, i_entry, 'traction', model, load)
    else if (.not. load%has_pressure) then
      call tree%report(i_entry, 'has no load; it needs pressure, traction or body_force')
    end if
    call read_window(tree, i_entry, model, load)
    mode = trim(load_modes(1))
    call get_choice(tree, i_entry, 'load', .false., load_modes, mode)
    load%is_cut = mode == load_modes(1)
  end subroutine read_surface_load

  subroutine read_components(tree, i_entry, key, model, load)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    character(*), intent(in) :: key
    type(mechanical_model_t), intent(in) :: model
    type(load_config_t), intent(inout) :: load
    integer :: i_axis, i_component, i_mapping, i_value

    i_mapping = get_mapping(tree, i_entry, key, .true.)
    if (i_mapping == 0) return
    do i_axis = 1, size(axes)
      i_component = findloc(model%axes, axes(i_axis), dim=1)
      i_value = tree%find(i_mapping, axes(i_axis))
      if (i_value == 0) cycle
      if (i_component == 0) then
        call tree%report(i_value, 'is given; ' // components_text(model))
        cycle
      end if
      load%has_component(i_component) = .true.
      call read_field(tree, i_value, load%components(i_component))
    end do
    call tree%close_mapping(i_mapping)
    if (size(tree%children(i_mapping)) == 0) call tree%report(i_mapping, 'is an empty mapping; ' // components_text(model))
  end subroutine read_components

  !> Reads a number or an expression of parameters and coordinates; the number 0 replaces a faulty one.
  subroutine read_field(tree, i_node, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    type(value_config_t), intent(inout) :: value
    logical :: is_valid

    call value_of(tree, i_node, field, value, is_valid, may_use_coordinates=.true.)
    if (.not. is_valid) value = value_config_t(text='0', line=value%line, column=value%column)
  end subroutine read_field

  subroutine read_window(tree, i_entry, model, load)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    type(mechanical_model_t), intent(in) :: model
    type(load_config_t), intent(inout) :: load
    integer :: i_window

    i_window = get_mapping(tree, i_entry, 'window', .false.)
    if (i_window == 0) return
    call read_axis(tree, i_window, model, load%axis)
    call read_bound(tree, i_window, 'min', load%has_minimum, load%minimum)
    call read_bound(tree, i_window, 'max', load%has_maximum, load%maximum)
    call tree%close_mapping(i_window)
    if (tree%find(i_window, 'min') == 0 .and. tree%find(i_window, 'max') == 0) &
      call tree%report(i_window, 'has no bound; it needs min, max or both')
  end subroutine read_window

  !> Reads the required key `axis` of a window: the coordinate that the window bounds. After an error it is the first one.
  subroutine read_axis(tree, i_window, model, i_axis)
    !> gets the error
    type(deck_tree_t), intent(inout) :: tree
    !> node of the window
    integer, intent(in) :: i_window
    type(mechanical_model_t), intent(in) :: model
    !> number of the coordinate, 1-based
    integer, intent(out) :: i_axis
    character(:), allocatable :: axis

    axis = model%axes(1)
    call get_choice(tree, i_window, 'axis', .true., model%axes(:model%n_dim), axis)
    ! the loop ends at 1 where the coordinate is none of the others
    do i_axis = model%n_dim, 2, -1
      if (model%axes(i_axis) == axis) exit
    end do
  end subroutine read_axis

  !> Reads a bound of a window. Errors: it is neither a number nor an expression of the parameters.
  subroutine read_bound(tree, i_window, key, has_bound, bound)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_window
    character(*), intent(in) :: key
    !> false also after an error, so that no check takes the bound for what stands in the deck
    logical, intent(out) :: has_bound
    type(value_config_t), intent(inout) :: bound
    integer :: i_node

    i_node = tree%find(i_window, key)
    has_bound = i_node > 0
    if (has_bound) call value_of(tree, i_node, 'a number or an expression of the parameters', bound, has_bound)
  end subroutine read_bound
end module sig_deck_read_loads
