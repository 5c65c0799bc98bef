! SPDX-License-Identifier: BSD-3-Clause
!> Returns a configuration as YAML with every default. `check` prints this text, reports and models keep it, and reading it gives
!> the same configuration.
module sig_deck_echo
  use sig_deck_config, only: boundary_config_t, clusters_config_t, contact_config_t, deck_config_t, displacement_config_t, &
    history_config_t, imposed_strain_config_t, load_config_t, material_config_t, name_config_t, obstacle_config_t, &
    output_config_t, parameter_config_t, plasticity_config_t, reduction_config_t, target_config_t, value_config_t
  use sig_deck_echo_points, only: candidate_set, point_set, training_set
  use sig_deck_echo_words, only: count_or_word, tolerance_or_none, yaml_text
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  use sig_text, only: join, read_real, string_t, to_text
  implicit none(type, external)
  private
  public :: echo_deck, echo_physics, differing_setting, reduction_section

  character(*), parameter :: eol = new_line('a')

contains

  !> Returns the whole deck with all defaults as YAML; each line ends with a line end. Sections and keys that the deck does not have
  !> and that have no default value, such as test, are left out.
  pure function echo_deck(config) result(yaml)
    type(deck_config_t), intent(in) :: config
    character(:), allocatable :: yaml

    yaml = 'title: ' // yaml_text(config%title) // eol // units_section(config) // &
      'mesh: {file: ' // yaml_text(config%mesh%file) // ', model: ' // config%mesh%model // ', length_unit: ' // &
      config%mesh%length_unit // '}' // eol // parameters_section(config%parameters) // &
      history_section(config%history) // body_sections(config)
    if (size(config%loads) == 0) yaml = yaml // 'loads: []' // eol
    if (size(config%imposed_strains) == 0) yaml = yaml // 'imposed_strains: []' // eol
    yaml = yaml // &
      'solver: {type: ' // config%solver%type // ', linear: ' // config%solver%linear // &
      ', max_iterations: ' // to_text(config%solver%max_iterations) // &
      ', hold_unloaded_motions: ' // trim(merge('true ', 'false', config%solver%holds_unloaded_motions)) // '}' // eol
    if (config%has_training) yaml = yaml // 'training: ' // training_set(config%greedy, config%training, config%parameters) // eol
    if (config%has_test) yaml = yaml // 'test: ' // point_set(config%test, config%parameters) // eol
    yaml = yaml // clusters_section(config%clusters, config%parameters) // reduction_section(config%reduction)
    yaml = yaml // 'validation: {accept: ' // to_text(config%validation%accepted_forces) // ', accept_fields: ' // &
      to_text(config%validation%accepted_fields) // ', accept_strains: ' // &
      to_text(config%validation%accepted_strains) // '}' // eol
    yaml = yaml // output_section(config%output, config%parameters) // &
      'petsc_options: ' // yaml_text(config%petsc_options) // eol
  end function echo_deck

  !> Returns the settings that determine the full-order answer at a parameter point: units, the mesh's model and length_unit, names
  !> of the parameters of a state, what body_sections returns, and whether motions that nothing holds are refused. All else is left
  !> out, such as the ranges of the parameters, times and tables (a state holds their values), the solver, and path and content of
  !> the mesh file. A snapshot's provenance is the hash of this text, of the mesh and of the fields, which the caller adds.
  pure function echo_physics(config) result(text)
    type(deck_config_t), intent(in) :: config
    character(:), allocatable :: text
    integer :: i

    text = units_section(config) // config%mesh%model // ' ' // config%mesh%length_unit // eol
    do i = 1, size(config%state_parameters)
      text = text // config%state_parameters(i)%name // eol
    end do
    text = text // body_sections(config)
    if (.not. config%solver%holds_unloaded_motions) text = text // 'hold_unloaded_motions: false' // eol
  end function echo_physics

  !> Returns the first line of this deck's sections parameters, clusters, reduction and certificate (with all defaults, in this
  !> order) that is not a line of another deck, without the blanks around it; empty if there is none. A line whose first key begins
  !> no line of the other deck does not count: the key belongs to a later version. The sections clusters and certificate have one
  !> line each. Requires: both decks have the same parameters.
  pure function differing_setting(config, other_deck) result(setting)
    type(deck_config_t), intent(in) :: config
    !> text from echo_deck of this version or of an older one
    character(*), intent(in) :: other_deck
    character(:), allocatable :: setting
    character(:), allocatable :: lines, line, other
    integer :: length

    other = without_gone_key(other_deck)
    lines = parameters_section(config%parameters) // history_section(config%history) // &
      clusters_section(config%clusters, config%parameters) // reduction_section(config%reduction)
    do while (len(lines) > 0)
      length = index(lines, eol)
      line = lines(:length - 1)
      lines = lines(length + 1:)
      setting = trim(adjustl(line))
      if (index(other, eol // line(:index(line, ':'))) > 0 .and. index(other, eol // line // eol) == 0) return
    end do
    setting = ''
  end function differing_setting

  !> Returns the text without a key that stood in the line of the clusters, with its usual value. Decks of version 0.1 have it.
  pure function without_gone_key(deck) result(text)
    character(*), intent(in) :: deck
    character(:), allocatable :: text
    character(*), parameter :: gone = ', algorithm: faster_pam'
    integer :: i

    i = index(deck, gone)
    text = deck
    if (i > 0) text = deck(:i - 1) // deck(i + len(gone):)
  end function without_gone_key

  pure function units_section(config) result(yaml)
    type(deck_config_t), intent(in) :: config
    character(:), allocatable :: yaml

    yaml = 'units: {length: ' // config%units%length // ', force: ' // config%units%force
    if (config%units%time /= '') yaml = yaml // ', time: ' // config%units%time
    yaml = yaml // '}' // eol
  end function units_section

  !> Returns the sections materials, boundary_conditions, loads, imposed_strains and contact as YAML; each line ends with a line
  !> end. Without loads the section loads is left out, and so is imposed_strains without imposed strains.
  pure function body_sections(config) result(yaml)
    type(deck_config_t), intent(in) :: config
    character(:), allocatable :: yaml
    integer :: i

    yaml = 'materials:' // eol
    do i = 1, size(config%materials)
      yaml = yaml // '  ' // material_entry(config%materials(i)) // eol
    end do
    yaml = yaml // 'boundary_conditions:' // eol
    do i = 1, size(config%boundary_conditions)
      yaml = yaml // '  - ' // boundary_entry(config%boundary_conditions(i)) // eol
    end do
    if (size(config%loads) > 0) yaml = yaml // 'loads:' // eol
    do i = 1, size(config%loads)
      yaml = yaml // '  - ' // load_entry(config%loads(i)) // eol
    end do
    if (size(config%imposed_strains) > 0) yaml = yaml // 'imposed_strains:' // eol
    do i = 1, size(config%imposed_strains)
      yaml = yaml // '  - ' // strain_entry(config%imposed_strains(i), mechanical_model(config%mesh%model)) // eol
    end do
    if (size(config%contact) > 0) yaml = yaml // 'contact:' // eol
    do i = 1, size(config%contact)
      yaml = yaml // '  - ' // contact_entry(config%contact(i)) // eol
    end do
  end function body_sections

  pure function parameters_section(parameters) result(yaml)
    type(parameter_config_t), intent(in) :: parameters(:)
    character(:), allocatable :: yaml
    integer :: i

    yaml = 'parameters:' // eol
    do i = 1, size(parameters)
      yaml = yaml // '  ' // parameters(i)%name // ': {min: ' // to_text(parameters(i)%minimum) // ', max: ' // &
        to_text(parameters(i)%maximum) // ', unit: ' // yaml_text(parameters(i)%unit) // '}' // eol
    end do
  end function parameters_section

  !> Returns the section history in one line; nothing without a history.
  pure function history_section(history) result(yaml)
    type(history_config_t), intent(in) :: history
    character(:), allocatable :: yaml
    type(string_t) :: steps(size(history%steps)), tables(size(history%states%tables))
    integer :: i

    yaml = ''
    if (.not. history%states%is_there()) return
    do i = 1, size(tables)
      associate (table => history%states%tables(i))
        tables(i)%text = yaml_text(table%name) // ': {time: ' // text_list(table%times) // ', value: ' // &
          text_list(table%values) // '}'
        if (history%files(i)%text /= '') tables(i)%text = yaml_text(table%name) // ': {file: ' // &
          yaml_text(history%files(i)%text) // '}'
      end associate
    end do
    do i = 1, size(steps)
      associate (step => history%steps(i))
        steps(i)%text = '{until: ' // to_text(step%until) // ', increments: ' // to_text(step%n_increments) // ', growth: ' // &
          to_text(step%growth) // '}'
      end associate
    end do
    yaml = 'history: {tables: {' // join(tables, ', ') // '}, steps: [' // join(steps, ', ') // ']}' // eol
  end function history_section

  !> Returns numbers and expressions as a list, `[0.0, "P/2"]`.
  pure function text_list(texts) result(yaml)
    type(string_t), intent(in) :: texts(:)
    character(:), allocatable :: yaml
    type(string_t) :: words(size(texts))
    real(rk) :: number
    integer :: i
    logical :: is_number

    do i = 1, size(texts)
      words(i)%text = texts(i)%text
      call read_real(texts(i)%text, number, is_number)
      if (.not. is_number) words(i)%text = yaml_text(texts(i)%text)
    end do
    yaml = '[' // join(words, ', ') // ']'
  end function text_list

  pure function material_entry(material) result(yaml)
    type(material_config_t), intent(in) :: material
    character(:), allocatable :: yaml

    yaml = yaml_text(material%name) // ': {regions: ' // name_list(material%regions) // ', young_modulus: ' // &
      value_text(material%young_modulus) // ', poisson_ratio: ' // value_text(material%poisson_ratio)
    if (material%has_thermal_expansion) yaml = yaml // ', thermal_expansion: ' // value_text(material%thermal_expansion)
    if (material%plasticity%is_used) yaml = yaml // ', plasticity: ' // plasticity_mapping(material%plasticity)
    if (material%creep%is_used) yaml = yaml // ', creep: {norton: {coefficient: ' // value_text(material%creep%coefficient) // &
      ', exponent: ' // value_text(material%creep%exponent) // '}}'
    yaml = yaml // '}'
  end function material_entry

  !> Returns the plasticity of a material; a curve holds the yield stress.
  pure function plasticity_mapping(plasticity) result(yaml)
    type(plasticity_config_t), intent(in) :: plasticity
    character(:), allocatable :: yaml
    type(string_t) :: strains(size(plasticity%curve_strains)), stresses(size(plasticity%curve_strains))
    integer :: i

    if (plasticity%hardening == 'curve') then
      do i = 1, size(strains)
        strains(i)%text = to_text(plasticity%curve_strains(i))
        stresses(i)%text = value_text(plasticity%curve_stresses(i))
      end do
      yaml = '{curve: {plastic_strain: [' // join(strains, ', ') // '], stress: [' // join(stresses, ', ') // ']}}'
      return
    end if
    yaml = '{yield_stress: ' // value_text(plasticity%yield_stress)
    if (plasticity%hardening /= '') yaml = yaml // ', ' // trim(plasticity%hardening) // ': ' // value_text(plasticity%modulus)
    yaml = yaml // '}'
  end function plasticity_mapping

  pure function boundary_entry(condition) result(yaml)
    type(boundary_config_t), intent(in) :: condition
    character(:), allocatable :: yaml

    yaml = '{boundary: ' // yaml_text(condition%boundary%text) // ', displacement: ' // &
      component_mapping(condition%axes, condition%is_prescribed, condition%displacement) // '}'
  end function boundary_entry

  !> Returns the components for which is_given is true, `{x: 0.0, y: push}`.
  pure function component_mapping(axes, is_given, values) result(yaml)
    !> names of the components
    character(*), intent(in) :: axes(:)
    logical, intent(in) :: is_given(:)
    !> one for each component
    type(value_config_t), intent(in) :: values(:)
    character(:), allocatable :: yaml
    type(string_t) :: components(count(is_given))
    integer :: i_axis, n

    n = 0
    do i_axis = 1, size(is_given)
      if (.not. is_given(i_axis)) cycle
      n = n + 1
      components(n)%text = trim(axes(i_axis)) // ': ' // value_text(values(i_axis))
    end do
    yaml = '{' // join(components, ', ') // '}'
  end function component_mapping

  pure function value_text(value) result(yaml)
    type(value_config_t), intent(in) :: value
    character(:), allocatable :: yaml

    if (value%is_constant) then
      yaml = to_text(value%constant)
    else
      yaml = yaml_text(value%text)
    end if
  end function value_text

  pure function load_entry(load) result(yaml)
    type(load_config_t), intent(in) :: load
    character(:), allocatable :: yaml

    if (load%is_body_force) then
      yaml = '{region: ' // yaml_text(load%target%text) // ', body_force: ' // &
        component_mapping(load%axes, load%has_component, load%components) // '}'
      return
    end if
    yaml = '{boundary: ' // yaml_text(load%target%text)
    if (load%has_pressure) yaml = yaml // ', pressure: ' // value_text(load%pressure)
    if (any(load%has_component)) yaml = yaml // ', traction: ' // component_mapping(load%axes, load%has_component, load%components)
    if (load%axis > 0) then
      yaml = yaml // ', window: {axis: ' // load%axes(load%axis)
      if (load%has_minimum) yaml = yaml // ', min: ' // value_text(load%minimum)
      if (load%has_maximum) yaml = yaml // ', max: ' // value_text(load%maximum)
      yaml = yaml // '}'
    end if
    yaml = yaml // ', load: ' // trim(merge('cut        ', 'whole_edges', load%is_cut)) // '}'
  end function load_entry

  pure function strain_entry(strain, model) result(yaml)
    type(imposed_strain_config_t), intent(in) :: strain
    type(mechanical_model_t), intent(in) :: model
    character(:), allocatable :: yaml

    yaml = '{region: ' // yaml_text(strain%region%text)
    if (strain%has_field) then
      yaml = yaml // ', field: {file: ' // yaml_text(strain%field%file) // ', name: ' // yaml_text(strain%field%name%text) // &
        ', quantity: ' // trim(merge('temperature', 'strain     ', strain%is_thermal)) // '}, factor: ' // value_text(strain%value)
    else if (strain%is_thermal) then
      yaml = yaml // ', temperature: ' // value_text(strain%value)
    else if (any(strain%has_component)) then
      yaml = yaml // ', strain: ' // component_mapping(model%strain_names, strain%has_component, strain%components)
    else
      yaml = yaml // ', strain: ' // value_text(strain%value)
    end if
    if (strain%is_thermal) yaml = yaml // ', reference: ' // value_text(strain%reference)
    yaml = yaml // '}'
  end function strain_entry

  pure function contact_entry(contact) result(yaml)
    type(contact_config_t), intent(in) :: contact
    character(:), allocatable :: yaml

    yaml = '{first: ' // yaml_text(contact%first%text)
    if (contact%has_obstacle) then
      yaml = yaml // ', obstacle: ' // obstacle_mapping(contact%obstacle)
      if (contact%obstacle%type == 'sphere') yaml = yaml // ', direction: ' // number_list(contact%direction)
      yaml = yaml // law_keys(contact) // '}'
      return
    end if
    yaml = yaml // ', second: ' // yaml_text(contact%second%text)
    if (contact%has_direction) yaml = yaml // ', direction: ' // number_list(contact%direction)
    yaml = yaml // ', formulation: ' // trim(contact%formulation) // ', pairing_tolerance: ' // to_text(contact%pairing_tolerance)
    if (contact%has_search_distance) yaml = yaml // ', search_distance: ' // to_text(contact%search_distance)
    if (contact%has_initial_gap) yaml = yaml // ', initial_gap: ' // value_text(contact%initial_gap)
    yaml = yaml // law_keys(contact) // '}'
  end function contact_entry

  !> Returns the keys friction and tied with a comma before each; empty for an entry without them.
  pure function law_keys(contact) result(yaml)
    type(contact_config_t), intent(in) :: contact
    character(:), allocatable :: yaml

    yaml = ''
    if (contact%has_friction) yaml = ', friction: ' // value_text(contact%friction)
    if (contact%tied /= 'false') yaml = yaml // ', tied: ' // trim(contact%tied)
  end function law_keys

  pure function obstacle_mapping(obstacle) result(yaml)
    type(obstacle_config_t), intent(in) :: obstacle
    character(:), allocatable :: yaml
    type(string_t) :: place(size(obstacle%place))
    integer :: i

    do i = 1, size(place)
      place(i)%text = value_text(obstacle%place(i))
    end do
    if (obstacle%type == 'sphere') then
      yaml = '{type: sphere, center: [' // join(place, ', ') // '], radius: ' // value_text(obstacle%radius) // '}'
    else
      yaml = '{type: half_space, point: [' // join(place, ', ') // '], normal: ' // number_list(obstacle%normal) // '}'
    end if
  end function obstacle_mapping

  pure function number_list(numbers) result(yaml)
    real(rk), intent(in) :: numbers(:)
    character(:), allocatable :: yaml

    yaml = '[' // join(numbers, ', ') // ']'
  end function number_list

  pure function clusters_section(clusters, parameters) result(yaml)
    type(clusters_config_t), intent(in) :: clusters
    type(parameter_config_t), intent(in) :: parameters(:)
    character(:), allocatable :: yaml

    yaml = 'clusters: {number: ' // count_or_word(clusters%number, 0, 'auto') // ', max_number: ' // &
      to_text(clusters%max_number) // ', method: ' // clusters%method // ', cell_pod_tolerance: ' // &
      to_text(clusters%cell_pod_tolerance) // ', opposite_snapshots: ' // clusters%opposite_snapshots // &
      ', min_snapshots: ' // to_text(clusters%min_snapshots) // ', small_clusters: ' // clusters%small_clusters // &
      ', seed: ' // to_text(clusters%seed)
    if (clusters%target%is_used) yaml = yaml // ', target: ' // target_mapping(clusters%target, parameters)
    if (clusters%refine%is_used) yaml = yaml // ', refine: {max_points: ' // to_text(clusters%refine%max_points) // &
      ', points_per_round: ' // to_text(clusters%refine%points_per_round) // '}'
    yaml = yaml // '}' // eol
  end function clusters_section

  pure function target_mapping(target, parameters) result(yaml)
    type(target_config_t), intent(in) :: target
    type(parameter_config_t), intent(in) :: parameters(:)
    character(:), allocatable :: yaml

    yaml = '{error: ' // to_text(target%error) // ', measure: ' // target%measure // ', statistic: ' // target%statistic // &
      ', candidates: ' // candidate_set(target%candidates, parameters) // '}'
  end function target_mapping

  !> Returns the sections reduction and certificate as YAML; each line ends with a line end.
  pure function reduction_section(reduction) result(yaml)
    type(reduction_config_t), intent(in) :: reduction
    character(:), allocatable :: yaml

    yaml = 'reduction:' // eol // &
      '  method: ' // reduction%method // eol // &
      '  pod_tolerance: ' // to_text(reduction%pod_tolerance) // eol // &
      '  n_modes: ' // count_or_word(reduction%n_modes, 0, 'auto') // eol // &
      '  extended_pod_tolerance: ' // tolerance_or_none(reduction%extended_pod_tolerance) // eol // &
      '  extra_modes: ' // to_text(reduction%extra_modes) // eol // &
      '  normalize: ' // trim(merge('true ', 'false', reduction%is_normalized)) // eol // &
      '  dual_pod_tolerance: ' // tolerance_or_none(reduction%dual_pod_tolerance) // eol // &
      '  dirichlet: ' // reduction%dirichlet // eol // &
      '  zones_of_interest: ' // zone_list(reduction) // eol // &
      '  enrichment: {type: ' // reduction%enrichment%type // ', max_condition_number: ' // &
      to_text(reduction%enrichment%max_condition_number) // ', side: ' // reduction%enrichment%side // ', max_hats: ' // &
      count_or_word(reduction%enrichment%max_hats, huge(1), 'none') // '}' // eol // &
      '  rank_tolerance: ' // to_text(reduction%rank_tolerance) // eol // &
      '  reconstruction: ' // reduction%reconstruction // eol // &
      '  displacement: ' // displacement_text(reduction%displacement) // eol // &
      '  displacement_tolerance: ' // to_text(reduction%displacement_tolerance) // eol // &
      '  fields: ' // trim(merge('true ', 'false', reduction%has_fields)) // eol // &
      '  max_full_order_size: ' // size_or_auto(reduction%max_full_order_size, reduction%is_size_auto) // eol // &
      '  max_transforms_size: ' // size_or_auto(reduction%max_transforms_size, reduction%is_transforms_size_auto) // eol // &
      '  stiffness_tolerance: ' // to_text(reduction%stiffness_tolerance) // eol // &
      '  inelastic_tolerance: ' // to_text(reduction%inelastic_tolerance) // eol // &
      'certificate: {max_error: ' // limit_text(reduction%max_error) // '}' // eol
  end function reduction_section

  !> Returns the size [MB], or `auto` where the deck leaves it to the machine: the text is the same on every machine.
  pure function size_or_auto(megabytes, is_auto) result(text)
    real(rk), intent(in) :: megabytes
    logical, intent(in) :: is_auto
    character(:), allocatable :: text

    text = 'auto'
    if (.not. is_auto) text = to_text(megabytes)
  end function size_or_auto

  pure function limit_text(limit) result(text)
    real(rk), intent(in) :: limit
    character(:), allocatable :: text

    text = 'auto'
    if (limit >= 0) text = tolerance_or_none(limit)
  end function limit_text

  pure function displacement_text(displacement) result(yaml)
    type(displacement_config_t), intent(in) :: displacement
    character(:), allocatable :: yaml

    yaml = displacement%type
    if (yaml == 'boundaries') yaml = '{boundaries: ' // name_list(displacement%boundaries) // ', elsewhere: ' // &
      displacement%elsewhere // '}'
  end function displacement_text

  pure function zone_list(reduction) result(yaml)
    type(reduction_config_t), intent(in) :: reduction
    character(:), allocatable :: yaml
    type(string_t) :: entries(size(reduction%zones_of_interest))
    integer :: i

    do i = 1, size(entries)
      associate (zone => reduction%zones_of_interest(i))
        entries(i)%text = yaml_text(zone%boundary%text)
        ! this is a boundary with the name `auto`
        if (zone%axis == 0 .and. zone%boundary%text == 'auto') entries(i)%text = '{boundary: auto}'
        if (zone%axis == 0) cycle
        entries(i)%text = '{boundary: ' // entries(i)%text // ', window: {axis: ' // zone%axes(zone%axis)
        if (zone%has_minimum) entries(i)%text = entries(i)%text // ', min: ' // to_text(zone%minimum)
        if (zone%has_maximum) entries(i)%text = entries(i)%text // ', max: ' // to_text(zone%maximum)
        entries(i)%text = entries(i)%text // '}}'
      end associate
    end do
    yaml = '[' // join(entries, ', ') // ']'
    if (.not. reduction%has_loaded_zones) return
    yaml = 'auto'
    if (size(entries) > 0) yaml = '[auto, ' // join(entries, ', ') // ']'
  end function zone_list

  pure function output_section(output, parameters) result(yaml)
    type(output_config_t), intent(in) :: output
    type(parameter_config_t), intent(in) :: parameters(:)
    character(:), allocatable :: yaml
    type(string_t) :: values(size(parameters))
    integer :: i, j

    yaml = 'output:' // eol // '  directory: ' // yaml_text(output%directory)
    if (output%directory == 'auto') yaml = yaml // '  # ' // output%path // ' below the current directory'
    yaml = yaml // eol // '  fields: [' // field_list(output) // ']' // eol // '  points:' // eol
    do i = 1, size(output%points, 2)
      do j = 1, size(parameters)
        values(j)%text = parameters(j)%name // ': ' // to_text(output%points(j, i))
      end do
      yaml = yaml // '    - {' // join(values, ', ') // '}' // eol
    end do
  end function output_section

  pure function field_list(output) result(yaml)
    type(output_config_t), intent(in) :: output
    character(:), allocatable :: yaml

    yaml = ''
    if (output%has_displacement) yaml = yaml // ', displacement'
    if (output%has_stress) yaml = yaml // ', stress'
    if (output%has_contact) yaml = yaml // ', contact'
    ! the list is never empty: a deck may leave it out, but it must not be empty
    yaml = yaml(3:)
  end function field_list

  pure function name_list(names) result(yaml)
    type(name_config_t), intent(in) :: names(:)
    character(:), allocatable :: yaml
    type(string_t) :: texts(size(names))
    integer :: i

    do i = 1, size(names)
      texts(i)%text = yaml_text(names(i)%text)
    end do
    yaml = '[' // join(texts, ', ') // ']'
  end function name_list
end module sig_deck_echo
