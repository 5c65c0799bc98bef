! SPDX-License-Identifier: BSD-3-Clause
!> Reads the sections of a deck on solving, reduction and output: solver, validation and output here, training, test, clusters and
!> reduction in modules of their own.
module sig_deck_read_study
  use sig_deck_config, only: deck_config_t, output_config_t, parameter_config_t, solver_config_t, &
    validation_config_t
  use sig_deck_read_clusters, only: read_clusters
  use sig_deck_read_points, only: read_point_set
  use sig_deck_read_reduction, only: read_reduction
  use sig_deck_tree, only: deck_tree_t, kind_mapping, root_node
  use sig_deck_values, only: choice_of, get_choice, get_integer, get_list, get_mapping, get_number, get_word
  use sig_file_system, only: path_below
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model
  implicit none(type, external)
  private
  public :: read_study

  character(*), parameter :: solver_types(4) = [character(10) :: 'auto', 'condensed', 'active_set', 'snesvi']
  character(*), parameter :: linear_solvers(3) = [character(8) :: 'auto', 'cholesky', 'gamg']
  character(*), parameter :: switches(2) = [character(5) :: 'false', 'true']
  character(*), parameter :: field_names(3) = [character(12) :: 'displacement', 'stress', 'contact']

contains

  !> Reads solver, training, test, clusters, reduction, certificate, validation and output into the configuration. A harmless value
  !> replaces a faulty one. Requires: read_problem has read parameters, mesh and materials.
  subroutine read_study(tree, config)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(inout) :: config
    integer :: i

    call read_solver(tree, config%solver)
    config%greedy%indicator = 'projection'
    if (any([(config%materials(i)%flows(), i=1, size(config%materials))])) config%greedy%indicator = 'audit'
    call read_point_set(tree, 'training', config%parameters, config%has_training, config%training, config%greedy)
    call read_point_set(tree, 'test', config%parameters, config%has_test, config%test)
    call read_clusters(tree, config%parameters, config%clusters)
    call read_reduction(tree, mechanical_model(config%mesh%model), config%reduction)
    call read_validation(tree, config%validation)
    call read_output(tree, config)
  end subroutine read_study

  subroutine read_validation(tree, validation)
    type(deck_tree_t), intent(inout) :: tree
    type(validation_config_t), intent(inout) :: validation
    integer :: i_validation

    i_validation = get_mapping(tree, root_node, 'validation', .false.)
    if (i_validation == 0) return
    call get_number(tree, i_validation, 'accept', .false., validation%accepted_forces)
    call get_number(tree, i_validation, 'accept_fields', .false., validation%accepted_fields)
    call get_number(tree, i_validation, 'accept_strains', .false., validation%accepted_strains)
    call tree%close_mapping(i_validation)
  end subroutine read_validation

  subroutine read_solver(tree, solver)
    type(deck_tree_t), intent(inout) :: tree
    type(solver_config_t), intent(inout) :: solver
    character(:), allocatable :: switch
    integer :: i_solver

    solver%type = trim(solver_types(1))
    solver%linear = trim(linear_solvers(1))
    i_solver = get_mapping(tree, root_node, 'solver', .false.)
    if (i_solver == 0) return
    solver%line = tree%nodes(i_solver)%line
    solver%column = tree%nodes(i_solver)%column
    call get_choice(tree, i_solver, 'type', .false., solver_types, solver%type)
    call get_choice(tree, i_solver, 'linear', .false., linear_solvers, solver%linear)
    call get_integer(tree, i_solver, 'max_iterations', .false., solver%max_iterations)
    switch = trim(switches(2))
    call get_choice(tree, i_solver, 'hold_unloaded_motions', .false., switches, switch)
    solver%holds_unloaded_motions = switch == switches(2)
    call tree%close_mapping(i_solver)
  end subroutine read_solver

  subroutine read_output(tree, config)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(inout) :: config
    integer :: i_output

    config%output%directory = 'auto'
    call set_middle(config%parameters, config%output%points)
    i_output = get_mapping(tree, root_node, 'output', .false.)
    if (i_output > 0) then
      call get_word(tree, i_output, 'directory', .false., config%output%directory)
      call read_fields(tree, i_output, config%output)
      call read_points(tree, i_output, config%parameters, config%output)
      call tree%close_mapping(i_output)
    end if
    config%output%path = path_below(tree%path, config%output%directory)
    if (config%output%directory == 'auto') config%output%path = 'results/' // config%name
  end subroutine read_output

  !> Sets the default output point, the middle of the box.
  subroutine set_middle(parameters, points)
    type(parameter_config_t), intent(in) :: parameters(:)
    !> shape (n_parameters, 1)
    real(rk), allocatable, intent(out) :: points(:, :)

    integer :: i

    allocate (points(size(parameters), 1))
    do i = 1, size(parameters)
      points(i, 1) = middle_of(parameters(i))
    end do
  end subroutine set_middle

  !> Returns the middle of a parameter's range, rounded to 12 digits because it becomes a label: 0.06 and not 0.060000000000000005.
  !> It never lies outside of the range.
  real(rk) function middle_of(parameter) result(middle)
    type(parameter_config_t), intent(in) :: parameter
    character(24) :: digits

    write (digits, '(es24.11e3)') parameter%minimum / 2 + parameter%maximum / 2
    read (digits, *) middle
    middle = min(max(middle, parameter%minimum), parameter%maximum)
  end function middle_of

  subroutine read_fields(tree, i_output, output)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_output
    type(output_config_t), intent(inout) :: output
    integer, allocatable :: nodes(:)
    integer :: i, i_list
    logical :: is_wanted(size(field_names))

    i_list = get_list(tree, i_output, 'fields', .false., .false.)
    if (i_list == 0) return
    nodes = tree%children(i_list)
    is_wanted = .false.
    do i = 1, size(nodes)
      call read_field(tree, nodes(i), is_wanted)
    end do
    output%has_displacement = is_wanted(1)
    output%has_stress = is_wanted(2)
    output%has_contact = is_wanted(3)
  end subroutine read_fields

  subroutine read_field(tree, i_node, is_wanted)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    logical, intent(inout) :: is_wanted(:)
    character(:), allocatable :: name
    integer :: i_field

    name = ''
    call choice_of(tree, i_node, field_names, name)
    do i_field = 1, size(field_names)
      if (field_names(i_field) /= name) cycle
      if (is_wanted(i_field)) call tree%report(i_node, 'is ''' // name // ''', which is already in the list')
      is_wanted(i_field) = .true.
    end do
  end subroutine read_field

  !> Reads output.points, each with a value for each parameter; without the key they stay as they are. Errors: no list, an empty
  !> list, a point that is no mapping, a parameter without a number, unknown keys. The default point's value replaces a missing or
  !> faulty one. check_study checks that the points lie in the box.
  subroutine read_points(tree, i_output, parameters, output)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_output
    type(parameter_config_t), intent(in) :: parameters(:)
    type(output_config_t), intent(inout) :: output
    integer, allocatable :: nodes(:)
    real(rk), allocatable :: points(:, :)
    integer :: i, i_list, j

    i_list = get_list(tree, i_output, 'points', .false., .false.)
    if (i_list == 0) return
    nodes = tree%children(i_list)
    ! the middle of the box replaces a missing or faulty value
    points = spread(output%points(:, 1), 2, size(nodes))
    do i = 1, size(nodes)
      if (tree%nodes(nodes(i))%kind /= kind_mapping) then
        call tree%report(nodes(i), 'is ' // tree%kind_name(nodes(i)) // '; it must be a mapping {parameter: value, ...}')
        cycle
      end if
      do j = 1, size(parameters)
        call get_number(tree, nodes(i), parameters(j)%name, .true., points(j, i))
      end do
      call tree%close_mapping(nodes(i))
    end do
    call move_alloc(points, output%points)
  end subroutine read_points
end module sig_deck_read_study
