! SPDX-License-Identifier: BSD-3-Clause
!> Reads the sections of a deck that define the problem: units, mesh, parameters, history, materials, boundary_conditions,
!> loads, imposed_strains, contact.
module sig_deck_read_problem
  use sig_deck_config, only: boundary_config_t, deck_config_t, mesh_config_t, parameter_config_t, units_config_t
  use sig_deck_read_contact, only: read_contact
  use sig_deck_read_history, only: read_history
  use sig_deck_read_loads, only: read_loads
  use sig_deck_read_materials, only: read_materials
  use sig_deck_read_strains, only: read_imposed_strains
  use sig_deck_tree, only: append_text, deck_tree_t, root_node
  use sig_deck_values, only: get_choice, get_entries, get_list_entries, get_mapping, get_name, get_number, get_text, get_word, &
    is_mapping, value_of
  use sig_expression, only: is_function_name, is_identifier
  use sig_file_system, only: path_below
  use sig_kinds, only: rk
  use sig_mechanical_models, only: components_text, coordinate_names, mechanical_model, mechanical_model_t, mechanical_models
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: read_problem

  character(*), parameter :: length_units(4) = [character(2) :: 'm', 'cm', 'mm', 'um']
  character(*), parameter :: force_units(3) = [character(2) :: 'N', 'kN', 'MN']
  character(*), parameter :: time_units(7) = [character(3) :: 'us', 'ms', 's', 'min', 'h', 'd', 'a']
  !> axes of all mechanical models
  character(*), parameter :: axes(4) = ['x', 'y', 'z', 'r']

contains

  !> Reads units, mesh, parameters, history, materials, boundary_conditions, loads, imposed_strains and contact into the
  !> configuration. A harmless value replaces a faulty one. Returns after the parameters if there are none, which is an error.
  subroutine read_problem(tree, config)
    !> gets the errors, and the names of parameters and coordinates that expressions may use
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(inout) :: config
    integer :: i

    call read_units(tree, config%units)
    call read_mesh(tree, config%units, config%mesh)
    call read_parameters(tree, config%parameters)
    ! the error was reported; every expression and grid would fail for the same reason
    if (size(config%parameters) == 0) return
    call read_history(tree, config%parameters, config%units%time, config%history)
    call read_materials(tree, config%materials)
    tree%coordinate_names = coordinate_names(mechanical_model(config%mesh%model))
    call read_boundary_conditions(tree, mechanical_model(config%mesh%model), config%boundary_conditions)
    call read_loads(tree, mechanical_model(config%mesh%model), config%loads)
    call read_imposed_strains(tree, mechanical_model(config%mesh%model), config%imposed_strains)
    do i = 1, size(config%imposed_strains)
      config%imposed_strains(i)%field%path = path_below(tree%path, config%imposed_strains(i)%field%file)
    end do
    call read_contact(tree, config%contact)
  end subroutine read_problem

  subroutine read_units(tree, units)
    type(deck_tree_t), intent(inout) :: tree
    type(units_config_t), intent(inout) :: units
    integer :: i_units

    units%length = 'm'
    units%force = 'N'
    units%time = ''
    i_units = get_mapping(tree, root_node, 'units', .false.)
    if (i_units == 0) return
    call get_choice(tree, i_units, 'length', .false., length_units, units%length)
    call get_choice(tree, i_units, 'force', .false., force_units, units%force)
    call get_choice(tree, i_units, 'time', .false., time_units, units%time)
    call tree%close_mapping(i_units)
  end subroutine read_units

  subroutine read_mesh(tree, units, mesh)
    type(deck_tree_t), intent(inout) :: tree
    type(units_config_t), intent(in) :: units
    type(mesh_config_t), intent(inout) :: mesh
    integer :: i_mesh, i_file

    mesh%file = ''
    mesh%path = ''
    mesh%model = trim(mechanical_models(1)%name)
    mesh%length_unit = units%length
    i_mesh = get_mapping(tree, root_node, 'mesh', .true.)
    if (i_mesh == 0) return
    call get_word(tree, i_mesh, 'file', .true., mesh%file)
    call get_choice(tree, i_mesh, 'model', .true., mechanical_models%name, mesh%model)
    call get_choice(tree, i_mesh, 'length_unit', .false., length_units, mesh%length_unit)
    call tree%close_mapping(i_mesh)
    mesh%path = path_below(tree%path, mesh%file)
    i_file = tree%find(i_mesh, 'file')
    if (i_file == 0) return
    mesh%line = tree%nodes(i_file)%line
    mesh%column = tree%nodes(i_file)%column
  end subroutine read_mesh

  subroutine read_parameters(tree, parameters)
    type(deck_tree_t), intent(inout) :: tree
    type(parameter_config_t), allocatable, intent(out) :: parameters(:)
    integer, allocatable :: nodes(:)
    integer :: i

    allocate (parameters(0))
    call get_entries(tree, 'parameters', nodes)
    deallocate (parameters)
    allocate (parameters(size(nodes)))
    do i = 1, size(nodes)
      parameters(i)%name = tree%nodes(nodes(i))%key
      parameters(i)%unit = ''
      parameters(i)%line = tree%nodes(nodes(i))%key_line
      parameters(i)%maximum = huge(1.0_rk)
      parameters(i)%minimum = -huge(1.0_rk)
      if (.not. is_mapping(tree, nodes(i))) cycle
      call get_number(tree, nodes(i), 'min', .true., parameters(i)%minimum)
      call get_number(tree, nodes(i), 'max', .true., parameters(i)%maximum)
      call get_text(tree, nodes(i), 'unit', .false., parameters(i)%unit)
      call tree%close_mapping(nodes(i))
    end do
    call offer_names(parameters, tree%parameter_names)
    tree%n_parameters = size(tree%parameter_names)
    tree%is_parameter_used = [(.false., i=1, tree%n_parameters)]
  end subroutine read_parameters

  !> Sets the names that expressions may use. Names that muParser would refuse are left out; check_deck reports them.
  pure subroutine offer_names(parameters, names)
    type(parameter_config_t), intent(in) :: parameters(:)
    type(string_t), allocatable, intent(out) :: names(:)
    integer :: i

    allocate (names(0))
    do i = 1, size(parameters)
      if (is_identifier(parameters(i)%name) .and. .not. is_function_name(parameters(i)%name)) &
        call append_text(names, parameters(i)%name)
    end do
  end subroutine offer_names

  subroutine read_boundary_conditions(tree, model, conditions)
    type(deck_tree_t), intent(inout) :: tree
    type(mechanical_model_t), intent(in) :: model
    type(boundary_config_t), allocatable, intent(out) :: conditions(:)
    integer, allocatable :: nodes(:)
    integer :: i

    call get_list_entries(tree, root_node, 'boundary_conditions', .true., .false., nodes)
    allocate (conditions(size(nodes)))
    do i = 1, size(nodes)
      conditions(i)%boundary%text = ''
      if (.not. is_mapping(tree, nodes(i))) cycle
      call get_name(tree, nodes(i), 'boundary', conditions(i)%boundary)
      call read_displacement(tree, nodes(i), model, conditions(i))
      call tree%close_mapping(nodes(i))
    end do
  end subroutine read_boundary_conditions

  subroutine read_displacement(tree, i_entry, model, condition)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_entry
    type(mechanical_model_t), intent(in) :: model
    type(boundary_config_t), intent(inout) :: condition
    integer :: i_component, i_displacement, i_value
    logical :: is_valid

    condition%axes = model%axes
    i_displacement = get_mapping(tree, i_entry, 'displacement', .true.)
    if (i_displacement == 0) return
    do i_component = 1, model%n_dim
      i_value = tree%find(i_displacement, model%axes(i_component))
      if (i_value == 0) cycle
      condition%is_prescribed(i_component) = .true.
      call value_of(tree, i_value, 'a number or an expression of the parameters and the coordinates', &
        condition%displacement(i_component), is_valid, may_use_coordinates=.true.)
      ! the error was reported; later checks must not fail on the value
      if (.not. is_valid) condition%displacement(i_component)%is_constant = .true.
    end do
    call refuse_other_axes(tree, i_displacement, model)
    call tree%close_mapping(i_displacement)
    if (size(tree%children(i_displacement)) == 0) call tree%report(i_displacement, &
      'is an empty mapping; ' // components_text(model))
  end subroutine read_displacement

  !> Adds an error for each key x, y, z or r that is no component of this model; it says which components the model has.
  subroutine refuse_other_axes(tree, i_mapping, model)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_mapping
    type(mechanical_model_t), intent(in) :: model
    integer, allocatable :: nodes(:)
    integer :: i

    nodes = tree%children(i_mapping)
    do i = 1, size(nodes)
      associate (key => tree%nodes(nodes(i))%key)
        if (.not. any(axes == key) .or. any(model%axes == key)) cycle
        call tree%report(tree%find(i_mapping, key), 'is prescribed; ' // components_text(model))
      end associate
    end do
  end subroutine refuse_other_axes
end module sig_deck_read_problem
