! SPDX-License-Identifier: BSD-3-Clause
!> Checks the values of a deck for the sections that define the problem, alone and against each other.
module sig_deck_checks
  use sig_deck_check_contact, only: check_contact
  use sig_deck_check_flow, only: check_flow
  use sig_deck_check_strains, only: check_imposed_strain, check_products
  use sig_deck_check_study, only: check_study
  use sig_deck_check_values, only: check_field, check_range
  use sig_deck_config, only: deck_config_t, parameter_config_t, value_config_t
  use sig_deck_echo_words, only: yaml_words
  use sig_deck_tree, only: deck_tree_t, shown
  use sig_expression, only: is_function_name, is_identifier
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  use sig_text, only: lower, to_text
  implicit none(type, external)
  private
  public :: check_deck

  !> names that no parameter may have: coordinates in expressions (now or later), columns of the tables that have the parameters as
  !> columns, outputs of an FMU, arguments of the Python interface
  character(*), parameter :: reserved_names(36) = [character(27) :: 'x', 'y', 'z', 'r', 'cluster', 'solver', 'e_u', &
    'e_lambda_rid', 'e_lambda_all', 'e_energy', 'e_energy_rid', 'e_energy_relative', 'e_energy_rid_relative', 'e_u_energy', &
    'e_u_energy_relative', 'n_active', 'n_active_full_order', 'full_order', 'n_solutions', 'error_bound', 'displacement_bound', &
    'status', 'next_cluster', 'contact_force', 'order', 'indicator', 'error_u', 'error_lambda', 'is_inside_box', &
    'relative_bound', 'nodes', 'self', &
    'e_von_mises_largest', 'e_von_mises', 'e_pressure', 'relative_displacement_bound']

contains

  !> Checks what reading a deck does not check and what needs no mesh: names of parameters, ranges of values, and values that
  !> exclude each other. Requires: values that could not be read have harmless values in their place.
  subroutine check_deck(tree, config)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    integer :: i

    do i = 1, size(config%parameters)
      call check_name(tree, 'parameters', config%parameters(i)%name)
      call check_box(tree, config%parameters(i))
    end do
    do i = 1, size(config%history%states%tables)
      call check_name(tree, 'history.tables', config%history%states%tables(i)%name)
    end do
    do i = 1, size(config%materials)
      call check_material(tree, config, i, stress_unit(config))
      call check_flow(tree, config, i)
    end do
    call check_displacements(tree, config)
    do i = 1, size(config%loads)
      call check_load(tree, config, i)
    end do
    do i = 1, size(config%imposed_strains)
      call check_imposed_strain(tree, config, i)
    end do
    do i = 1, size(config%contact)
      call check_contact(tree, config, i)
    end do
    call check_study(tree, config)
  end subroutine check_deck

  pure function stress_unit(config) result(unit)
    type(deck_config_t), intent(in) :: config
    character(:), allocatable :: unit

    unit = config%units%force // '/' // config%units%length // '^2'
  end function stress_unit

  !> Checks that the name of a parameter or a table can stand in expressions and in the tables of results.
  subroutine check_name(tree, section, name)
    type(deck_tree_t), intent(inout) :: tree
    !> key path of the mapping whose key is the name
    character(*), intent(in) :: section
    character(*), intent(in) :: name
    integer :: i_node

    i_node = tree%find(tree%node_at(section), name)
    if (.not. is_identifier(name)) then
      call tree%report_key(i_node, tree%key_path(i_node) // &
        ' cannot be used in expressions; a name is a letter, then letters, digits and _')
    else if (is_function_name(name)) then
      call tree%report_key(i_node, tree%key_path(i_node) // ' is the name of a function; choose another name')
    else if (any(reserved_names == name) .or. any(yaml_words == lower(name)) .or. is_numbered_column(name)) then
      call tree%report_key(i_node, tree%key_path(i_node) // ' is a reserved name; choose another name')
    end if
  end subroutine check_name

  subroutine check_box(tree, parameter)
    type(deck_tree_t), intent(inout) :: tree
    type(parameter_config_t), intent(in) :: parameter
    character(:), allocatable :: unit

    if (.not. is_identifier(parameter%name) .or. parameter%minimum < parameter%maximum) return
    unit = ''
    if (len(parameter%unit) > 0) unit = ' ' // parameter%unit
    call tree%report_at('parameters.' // parameter%name // '.max', 'is ' // to_text(parameter%maximum) // unit // &
      '; it must be greater than min, which is ' // to_text(parameter%minimum) // unit)
  end subroutine check_box

  !> Whether the name is that of a column of the table of predict, lambda_<number>, tau_<number>... or contact_<number>_..., or
  !> looks like one.
  pure logical function is_numbered_column(name)
    character(*), intent(in) :: name
    character(*), parameter :: digits = '0123456789', force = 'lambda_'
    character(*), parameter :: beginnings(2) = [character(8) :: 'contact_', 'tau_']
    integer :: i

    is_numbered_column = .false.
    if (index(name, force) == 1 .and. len(name) > len(force)) is_numbered_column = verify(name(len(force) + 1:), digits) == 0
    do i = 1, size(beginnings)
      associate (n => len_trim(beginnings(i)))
        if (index(name, beginnings(i) (:n)) == 1 .and. len(name) > n) is_numbered_column = is_numbered_column .or. &
          scan(name(n + 1:), digits) == 1
      end associate
    end do
  end function is_numbered_column

  !> Adds an error if a constant of a material depends on the time or a table of the history.
  subroutine refuse_history(tree, path, value)
    type(deck_tree_t), intent(inout) :: tree
    !> key path of the value
    character(*), intent(in) :: path
    type(value_config_t), intent(in) :: value

    if (value%uses_history) call tree%report_at(path, 'is ' // shown(value%text) // &
      ', which depends on the time; constants of a material may depend on parameters only')
  end subroutine refuse_history

  subroutine check_material(tree, config, i_material, unit)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    integer, intent(in) :: i_material
    !> unit of a stress
    character(*), intent(in) :: unit
    character(:), allocatable :: path
    integer :: i, j, k

    associate (material => config%materials(i_material), materials => config%materials)
      path = 'materials.' // material%name
      call refuse_history(tree, path // '.young_modulus', material%young_modulus)
      call refuse_history(tree, path // '.poisson_ratio', material%poisson_ratio)
      call refuse_history(tree, path // '.thermal_expansion', material%thermal_expansion)
      call check_range(tree, path // '.young_modulus', config, material%young_modulus, 0.0_rk, huge(1.0_rk), ' ' // unit)
      call check_range(tree, path // '.poisson_ratio', config, material%poisson_ratio, -1.0_rk, 0.5_rk, '')
      if (material%has_thermal_expansion) &
        call check_field(tree, path // '.thermal_expansion', config, material%thermal_expansion)
      do i = 1, size(material%regions)
        others: do j = 1, i_material - 1
          do k = 1, size(materials(j)%regions)
            if (len(material%regions(i)%text) == 0 .or. materials(j)%regions(k)%text /= material%regions(i)%text) cycle
            call tree%report_at(path // '.regions[' // to_text(i) // ']', 'is ' // shown(material%regions(i)%text) // &
              ', which belongs to materials.' // materials(j)%name // ' already')
            exit others
          end do
        end do others
      end do
    end associate
  end subroutine check_material

  subroutine check_displacements(tree, config)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    character(:), allocatable :: path
    integer :: i, i_axis, j

    do i = 1, size(config%boundary_conditions)
      do i_axis = 1, 3
        if (.not. config%boundary_conditions(i)%is_prescribed(i_axis)) cycle
        path = 'boundary_conditions[' // to_text(i) // '].displacement.' // config%boundary_conditions(i)%axes(i_axis)
        do j = 1, i - 1
          if (.not. config%boundary_conditions(j)%is_prescribed(i_axis)) cycle
          if (config%boundary_conditions(j)%boundary%text /= config%boundary_conditions(i)%boundary%text) cycle
          call tree%report_at(path, 'is prescribed twice for ' // shown(config%boundary_conditions(i)%boundary%text) // &
            '; boundary_conditions[' // to_text(j) // '] has it already')
          ! one message is enough: a deck may repeat the entry hundreds of times
          exit
        end do
        call check_field(tree, path, config, config%boundary_conditions(i)%displacement(i_axis))
      end do
    end do
  end subroutine check_displacements

  subroutine check_load(tree, config, i_load)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    integer, intent(in) :: i_load
    type(mechanical_model_t) :: model
    character(:), allocatable :: path, key
    integer :: i_axis

    model = mechanical_model(config%mesh%model)
    path = 'loads[' // to_text(i_load) // ']'
    associate (load => config%loads(i_load))
      key = '.traction.'
      if (load%is_body_force) key = '.body_force.'
      if (load%has_pressure) call check_field(tree, path // '.pressure', config, load%pressure)
      do i_axis = 1, 3
        if (.not. load%has_component(i_axis)) cycle
        associate (value => load%components(i_axis))
          call check_field(tree, path // key // model%axes(i_axis), config, value)
          if (load%is_body_force) call check_products(tree, path // key // model%axes(i_axis), value, 'a body force')
        end associate
      end do
      if (load%has_minimum) call check_field(tree, path // '.window.min', config, load%minimum)
      if (load%has_maximum) call check_field(tree, path // '.window.max', config, load%maximum)
      if (.not. (load%has_minimum .and. load%has_maximum)) return
      if (.not. (load%minimum%is_constant .and. load%maximum%is_constant)) return
      if (load%minimum%constant >= load%maximum%constant) call tree%report_at(path // '.window.max', 'is ' // &
        to_text(load%maximum%constant) // ' ' // config%units%length // '; it must be greater than min, which is ' // &
        to_text(load%minimum%constant) // ' ' // config%units%length)
    end associate
  end subroutine check_load
end module sig_deck_checks
