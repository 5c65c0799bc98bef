! SPDX-License-Identifier: BSD-3-Clause
!> The sections of a deck that say how it is solved and written: solver, training, test, output; and, by its own reader, reduction.
module sig_deck_read_study
  use sig_deck_config, only: deck_config_t, greedy_config_t, output_config_t, parameter_config_t, point_set_config_t, &
    solver_config_t
  use sig_deck_read_problem, only: path_below
  use sig_deck_read_reduction, only: read_clusters, read_count_or_word, read_reduction, read_tolerance_or_none
  use sig_deck_tree, only: deck_tree_t, kind_mapping, kind_scalar, root_node
  use sig_deck_values, only: choice_of, get_choice, get_integer, get_list, get_mapping, get_number, get_word, integer_of
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model
  use sig_text, only: append_text, join, string_t, to_text
  implicit none(type, external)
  private
  public :: read_study

  !> the last one of training only
  character(*), parameter :: point_sets(5) = [character(15) :: 'grid', 'file', 'sobol', 'latin_hypercube', 'greedy']
  character(*), parameter :: seeded(2) = point_sets(3:4)
  character(*), parameter :: indicators(2) = [character(10) :: 'projection', 'defect']
  character(*), parameter :: solver_types(4) = [character(10) :: 'auto', 'condensed', 'active_set', 'snesvi']
  character(*), parameter :: linear_solvers(3) = [character(8) :: 'auto', 'cholesky', 'gamg']
  character(*), parameter :: field_names(3) = [character(12) :: 'displacement', 'stress', 'contact']

contains

  !> Reads these sections; the parameters must be known.
  subroutine read_study(tree, config)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(inout) :: config

    call read_solver(tree, config%solver)
    call read_point_set(tree, 'training', config%parameters, config%has_training, config%training, config%greedy)
    call read_point_set(tree, 'test', config%parameters, config%has_test, config%test)
    call read_clusters(tree, config%clusters)
    call read_reduction(tree, mechanical_model(config%mesh%model), config%reduction)
    call read_output(tree, config)
  end subroutine read_study

  subroutine read_solver(tree, solver)
    type(deck_tree_t), intent(inout) :: tree
    type(solver_config_t), intent(inout) :: solver
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
    call tree%close_mapping(i_solver)
  end subroutine read_solver

  !> The greedy choice below a section, if there is one.
  subroutine read_greedy(tree, i_section, parameters, greedy, candidates)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_section
    type(parameter_config_t), intent(in) :: parameters(:)
    type(greedy_config_t), intent(inout) :: greedy
    type(point_set_config_t), intent(inout) :: candidates
    type(point_set_config_t) :: found
    integer :: i_candidates, i_greedy

    greedy%indicator = trim(indicators(1))
    i_greedy = get_mapping(tree, i_section, 'greedy', .false.)
    greedy%is_used = i_greedy > 0
    if (.not. greedy%is_used) return
    i_candidates = get_mapping(tree, i_greedy, 'candidates', .true.)
    if (i_candidates > 0) then
      call read_kinds(tree, i_candidates, parameters, found)
      found%line = candidates%line
      found%column = candidates%column
      candidates = found
      call tree%close_mapping(i_candidates)
      call check_kind(tree, i_candidates, 'training.greedy.candidates', point_sets(:4))
    end if
    call get_choice(tree, i_greedy, 'indicator', .false., indicators, greedy%indicator)
    call read_count(tree, i_greedy, 'initial', greedy%n_initial)
    call read_tolerance_or_none(tree, i_greedy, 'tolerance', greedy%tolerance)
    call read_count_or_word(tree, i_greedy, 'max_points', 'none', 1, greedy%max_points)
    call read_count(tree, i_greedy, 'batch', greedy%batch)
    call tree%close_mapping(i_greedy)
    if (greedy%indicator == 'projection' .and. tree%find(i_greedy, 'batch') > 0) call tree%report(tree%find(i_greedy, 'batch'), &
      'is for indicator: defect; with projection the errors are known anew after each point')
    if (tree%find(i_greedy, 'tolerance') == 0 .and. tree%find(i_greedy, 'max_points') == 0) call tree%report_key(i_greedy, &
      'training.greedy has no end; it must have tolerance, max_points or both')
  end subroutine read_greedy

  subroutine read_point_set(tree, key, parameters, is_there, points, greedy)
    type(deck_tree_t), intent(inout) :: tree
    character(*), intent(in) :: key
    type(parameter_config_t), intent(in) :: parameters(:)
    logical, intent(out) :: is_there
    !> the candidates where greedy%is_used
    type(point_set_config_t), intent(inout) :: points
    !> where points may be chosen
    type(greedy_config_t), intent(inout), optional :: greedy
    integer :: i_section

    i_section = get_mapping(tree, root_node, key, .false.)
    is_there = i_section > 0
    if (.not. is_there) return
    points%line = tree%nodes(i_section)%line
    points%column = tree%nodes(i_section)%column
    call read_kinds(tree, i_section, parameters, points)
    if (present(greedy)) call read_greedy(tree, i_section, parameters, greedy, points)
    call read_groups(tree, i_section, points%n_groups)
    call tree%close_mapping(i_section)
    call check_kind(tree, i_section, key, point_sets(:merge(5, 4, present(greedy))))
  end subroutine read_point_set

  !> Each kind of point set that there is.
  subroutine read_kinds(tree, i_section, parameters, points)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_section
    type(parameter_config_t), intent(in) :: parameters(:)
    type(point_set_config_t), intent(inout) :: points
    integer :: i_grid

    i_grid = get_mapping(tree, i_section, 'grid', .false.)
    if (i_grid > 0) call read_grid(tree, i_grid, parameters, points)
    call get_word(tree, i_section, 'file', .false., points%file)
    if (allocated(points%file)) points%path = path_below(tree%path, points%file)
    call read_count(tree, i_section, 'sobol', points%n_sobol)
    call read_count(tree, i_section, 'latin_hypercube', points%n_latin_hypercube)
    call get_integer(tree, i_section, 'seed', .false., points%seed)
  end subroutine read_kinds

  !> Exactly one kind of point set, and a seed only where it means something.
  subroutine check_kind(tree, i_section, key, kinds)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_section
    character(*), intent(in) :: key
    !> those that may be there
    character(*), intent(in) :: kinds(:)
    character(:), allocatable :: allowed
    type(string_t), allocatable :: all_kinds(:), found(:)
    integer :: i

    allocate (all_kinds(0), found(0))
    do i = 1, size(kinds)
      call append_text(all_kinds, trim(kinds(i)))
      if (tree%find(i_section, trim(kinds(i))) > 0) call append_text(found, trim(kinds(i)))
    end do
    allowed = '; it must have one of ' // join(all_kinds, ', ')
    if (size(found) > 1) then
      call tree%report_key(i_section, key // ' has ' // join(found, ' and ') // allowed)
    else if (size(found) == 0) then
      call tree%report_key(i_section, key // ' has no points' // allowed)
    else if (tree%find(i_section, 'seed') > 0 .and. .not. any(found(1)%text == seeded)) then
      call tree%report(tree%find(i_section, 'seed'), 'is not for ' // found(1)%text // '; it belongs to sobol and latin_hypercube')
    end if
  end subroutine check_kind

  !> A number of points: at least one.
  subroutine read_count(tree, i_section, key, n_points)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_section
    character(*), intent(in) :: key
    integer, intent(inout) :: n_points
    integer :: i_node

    i_node = tree%find(i_section, key)
    if (i_node == 0) return
    n_points = 1
    call get_integer(tree, i_section, key, .false., n_points)
    if (n_points < 1) call tree%report(i_node, 'is ' // to_text(n_points) // '; it must be at least 1')
  end subroutine read_count

  !> Points per parameter; each parameter needs its count.
  subroutine read_grid(tree, i_grid, parameters, points)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_grid
    type(parameter_config_t), intent(in) :: parameters(:)
    type(point_set_config_t), intent(inout) :: points
    integer :: i

    allocate (points%grid(size(parameters)), source=2)
    do i = 1, size(parameters)
      call get_integer(tree, i_grid, parameters(i)%name, .true., points%grid(i))
    end do
    call tree%close_mapping(i_grid)
  end subroutine read_grid

  !> `auto` or a whole number from 1 on.
  subroutine read_groups(tree, i_section, n_groups)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_section
    integer, intent(inout) :: n_groups
    integer :: i_node

    i_node = tree%find(i_section, 'groups')
    if (i_node == 0) return
    if (tree%nodes(i_node)%kind == kind_scalar) then
      if (tree%nodes(i_node)%text == 'auto') return
    end if
    n_groups = 1
    call integer_of(tree, i_node, n_groups)
    if (n_groups < 1) call tree%report(i_node, 'is ' // tree%nodes(i_node)%text // '; it must be auto or at least 1')
  end subroutine read_groups

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

  !> The default output point: the middle of the box.
  subroutine set_middle(parameters, points)
    type(parameter_config_t), intent(in) :: parameters(:)
    real(rk), allocatable, intent(out) :: points(:, :)

    integer :: i

    allocate (points(size(parameters), 1))
    do i = 1, size(parameters)
      points(i, 1) = middle_of(parameters(i))
    end do
  end subroutine set_middle

  !> Rounded to 12 digits, because it becomes a label: 0.06 rather than 0.060000000000000005.
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
      if (is_wanted(i_field)) call tree%report(i_node, 'is ''' // name // ''', which the list holds already')
      is_wanted(i_field) = .true.
    end do
  end subroutine read_field

  !> Points with a value for each parameter.
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
    ! where a value is missing or faulty, the middle of the box stands in
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
