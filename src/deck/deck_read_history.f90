! SPDX-License-Identifier: BSD-3-Clause
!> Reads and checks the section `history` of a deck: tables, which are piecewise linear functions of the time, and the steps, which
!> give the times of the states.
module sig_deck_read_history
  use sig_deck_box, only: corners_to_try, in_box, names_of, point_text
  use sig_deck_config, only: history_config_t, parameter_config_t, step_config_t, value_config_t
  use sig_deck_tree, only: append_text, deck_tree_t, root_node
  use sig_deck_values, only: get_integer, get_list_entries, get_mapping, get_number, get_word, is_mapping, value_of
  use sig_errors, only: error_t
  use sig_expression, only: is_function_name, is_identifier
  use sig_file_system, only: path_below
  use sig_history, only: history_t, step_times, table_t, table_values_t, time_name
  use sig_kinds, only: rk
  use sig_point_list, only: read_points
  use sig_text, only: counted, short_number, string_t, to_text
  implicit none(type, external)
  private
  public :: check_tables, read_history, state_parameters

  character(*), parameter :: section = 'history'
  !> largest number of times of a history; more could be neither solved nor stored
  integer, parameter :: max_times = 100000
  !> number of points inside of the box times the number of times at which tables are tried
  integer, parameter :: most_samples = 100000

contains

  !> Reads the section history; without it there are no times and no tables. From then on expressions may use `time` and the tables.
  !>
  !> Errors: a key that is missing, unknown or faulty; no steps, steps that do not go forward, increments below 1 or more than
  !> 100000 times, growth that is not positive; a table without nodes or with lists of different length, or whose file cannot be
  !> read; a parameter or a table whose name is `time`, or a table with the name of a parameter.
  subroutine read_history(tree, parameters, unit, history)
    !> gets the errors, and the names that expressions may use
    type(deck_tree_t), intent(inout) :: tree
    type(parameter_config_t), intent(in) :: parameters(:)
    !> units.time
    character(*), intent(in) :: unit
    type(history_config_t), intent(out) :: history
    integer :: i, i_section

    allocate (history%states%times(0), history%states%tables(0), history%steps(0), history%files(0))
    history%states%unit = unit
    i_section = get_mapping(tree, root_node, section, .false.)
    if (i_section == 0) return
    call read_tables(tree, i_section, parameters, history)
    call read_steps(tree, i_section, history)
    call tree%close_mapping(i_section)
    do i = 1, size(parameters)
      if (parameters(i)%name == time_name) call tree%report_key(tree%node_at('parameters.' // time_name), &
        'parameters.time has the name of the time of the history; choose another name')
    end do
    call append_text(tree%parameter_names, time_name)
    tree%is_parameter_used = [tree%is_parameter_used, .true.]
    do i = 1, size(history%states%tables)
      ! check_deck reports names that muParser would refuse
      if (.not. is_identifier(history%states%tables(i)%name) .or. is_function_name(history%states%tables(i)%name)) cycle
      call append_text(tree%parameter_names, history%states%tables(i)%name)
      tree%is_parameter_used = [tree%is_parameter_used, .false.]
    end do
  end subroutine read_history

  subroutine read_steps(tree, i_section, history)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_section
    type(history_config_t), intent(inout) :: history
    integer, allocatable :: nodes(:)
    integer :: i
    real(rk) :: start

    call get_list_entries(tree, i_section, 'steps', .true., .false., nodes)
    deallocate (history%steps)
    allocate (history%steps(size(nodes)))
    start = 0
    do i = 1, size(nodes)
      if (.not. is_mapping(tree, nodes(i))) cycle
      call get_number(tree, nodes(i), 'until', .true., history%steps(i)%until)
      call get_integer(tree, nodes(i), 'increments', .true., history%steps(i)%n_increments)
      call get_number(tree, nodes(i), 'growth', .false., history%steps(i)%growth)
      call tree%close_mapping(nodes(i))
      call check_step(tree, nodes(i), start, history%steps(i), size(history%states%times))
      associate (step => history%steps(i))
        if (step%until > start .and. step%n_increments >= 1 .and. step%growth > 0 .and. &
            size(history%states%times) + real(step%n_increments, rk) <= max_times) &
          history%states%times = [history%states%times, step_times(start, step%until, step%n_increments, step%growth)]
        start = step%until
      end associate
    end do
  end subroutine read_steps

  subroutine check_step(tree, i_node, start, step, n_before)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    !> end of the step before, 0 for the first step
    real(rk), intent(in) :: start
    type(step_config_t), intent(in) :: step
    !> number of times of the steps before
    integer, intent(in) :: n_before
    integer :: i_key

    i_key = tree%find(i_node, 'until')
    if (i_key > 0 .and. step%until <= start) call tree%report(i_key, 'is ' // short_number(step%until) // &
      '; it must be greater than ' // short_number(start) // ', where the step begins')
    i_key = tree%find(i_node, 'increments')
    if (i_key > 0 .and. step%n_increments < 1) call tree%report(i_key, 'is ' // to_text(step%n_increments) // &
      '; it must be at least 1')
    if (i_key > 0 .and. n_before + real(step%n_increments, rk) > max_times) call tree%report(i_key, 'is ' // &
      to_text(step%n_increments) // '; a history may have at most ' // to_text(max_times) // ' times')
    i_key = tree%find(i_node, 'growth')
    if (i_key > 0 .and. .not. step%growth > 0) call tree%report(i_key, 'is ' // short_number(step%growth) // &
      '; it must be greater than 0 (growth: 3 makes the last increment three times the first)')
  end subroutine check_step

  subroutine read_tables(tree, i_section, parameters, history)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_section
    type(parameter_config_t), intent(in) :: parameters(:)
    type(history_config_t), intent(inout) :: history
    integer, allocatable :: nodes(:)
    integer :: i, i_tables, k
    logical, allocatable :: has_own_name(:)

    i_tables = get_mapping(tree, i_section, 'tables', .false.)
    if (i_tables == 0) return
    nodes = tree%children(i_tables)
    deallocate (history%states%tables, history%files)
    allocate (history%states%tables(size(nodes)), history%files(size(nodes)))
    allocate (has_own_name(size(nodes)), source=.true.)
    do i = 1, size(nodes)
      associate (table => history%states%tables(i))
        table%name = tree%nodes(nodes(i))%key
        history%files(i)%text = ''
        allocate (table%times(1), table%values(1))
        table%times(1)%text = '0'
        table%values(1)%text = '0'
        has_own_name(i) = table%name /= time_name .and. .not. any([(parameters(k)%name == table%name, k=1, size(parameters))])
        if (.not. has_own_name(i)) call tree%report_key(nodes(i), tree%key_path(nodes(i)) // ' has the name of ' // &
          trim(merge('the time   ', 'a parameter', table%name == time_name)) // '; choose another name')
        if (.not. is_mapping(tree, nodes(i))) cycle
        call read_table(tree, nodes(i), history%files(i)%text, table)
        call tree%close_mapping(nodes(i))
      end associate
    end do
    ! later checks take the name for the parameter, or the time
    k = 0
    do i = 1, size(nodes)
      if (.not. has_own_name(i)) cycle
      k = k + 1
      if (k == i) cycle
      history%states%tables(k) = history%states%tables(i)
      history%files(k) = history%files(i)
    end do
    history%states%tables = history%states%tables(:k)
    history%files = history%files(:k)
  end subroutine read_tables

  !> Reads the nodes of a table from the lists time and value, or from a CSV file with these columns.
  subroutine read_table(tree, i_node, file, table)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    character(:), allocatable, intent(inout) :: file
    type(table_t), intent(inout) :: table

    if (tree%find(i_node, 'file') > 0) then
      if (tree%find(i_node, time_name) + tree%find(i_node, 'value') > 0) then
        call tree%report_key(i_node, tree%key_path(i_node) // ' has a file and lists; it must have either file, or time and value')
        return
      end if
      call get_word(tree, i_node, 'file', .true., file)
      call read_table_file(tree, i_node, file, table)
      return
    end if
    call read_nodes(tree, i_node, time_name, table%times)
    call read_nodes(tree, i_node, 'value', table%values)
    if (size(table%times) == size(table%values)) return
    call tree%report_key(i_node, tree%key_path(i_node) // ' has ' // counted(size(table%times), 'time') // ' and ' // &
      counted(size(table%values), 'value') // '; it must have as many times as values')
    table%values = table%times
  end subroutine read_table

  subroutine read_nodes(tree, i_node, key, texts)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    character(*), intent(in) :: key
    !> one text of harmless value after an error
    type(string_t), allocatable, intent(inout) :: texts(:)
    type(value_config_t) :: value
    integer, allocatable :: nodes(:)
    integer :: i
    logical :: is_valid

    call get_list_entries(tree, i_node, key, .true., .false., nodes)
    if (size(nodes) == 0) return
    deallocate (texts)
    allocate (texts(size(nodes)))
    do i = 1, size(nodes)
      call value_of(tree, nodes(i), 'a number or an expression of the parameters', value, is_valid)
      texts(i)%text = '0'
      if (is_valid) texts(i)%text = value%text
    end do
  end subroutine read_nodes

  subroutine read_table_file(tree, i_node, file, table)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    !> path as the deck has it
    character(*), intent(in) :: file
    type(table_t), intent(inout) :: table
    type(error_t), allocatable :: error
    type(string_t) :: columns(2)
    real(rk), allocatable :: nodes(:, :)
    integer :: i

    if (file == '') return
    columns(1)%text = time_name
    columns(2)%text = 'value'
    call read_points(path_below(tree%path, file), columns, nodes, error)
    if (allocated(error)) then
      call tree%errors%add(error)
      return
    end if
    deallocate (table%times, table%values)
    allocate (table%times(size(nodes, 2)), table%values(size(nodes, 2)))
    do i = 1, size(nodes, 2)
      table%times(i)%text = to_text(nodes(1, i))
      table%values(i)%text = to_text(nodes(2, i))
    end do
  end subroutine read_table_file

  !> Checks that all tables have finite nodes and ascending times at the middle and the corners of the box of the parameters (with
  !> more than 10 parameters at the middle and two corners). Requires: each parameter has a valid range.
  subroutine check_tables(tree, parameters, history)
    !> gets the error
    type(deck_tree_t), intent(inout) :: tree
    type(parameter_config_t), intent(in) :: parameters(:)
    type(history_config_t), intent(in) :: history
    type(table_values_t) :: tables
    character(:), allocatable :: fault
    integer :: i, i_table
    real(rk), allocatable :: corners(:, :)

    if (.not. history%states%is_there()) return
    call tables%create(history%states, names_of(parameters), fault)
    ! a name that cannot be used was reported already
    if (allocated(fault)) return
    corners = corners_to_try(parameters)
    do i = 1, size(corners, 2)
      call tables%begin(corners(:, i), i_table, fault)
      if (i_table == 0) cycle
      call tree%report_at('history.tables.' // history%states%tables(i_table)%name, fault // ' at ' // &
        point_text(parameters, corners(:, i)))
      exit
    end do
    call tables%destroy()
  end subroutine check_tables

  !> Returns what the numbers of a state are: the parameters, and with a history the time and its tables. The range of the time is
  !> from 0 to the end of the steps, and the range of a table is that of find_ranges.
  function state_parameters(parameters, history, has_ranges) result(all)
    type(parameter_config_t), intent(in) :: parameters(:)
    type(history_config_t), intent(in) :: history
    !> whether check_tables has found no error; otherwise the ranges are empty
    logical, intent(in) :: has_ranges
    type(parameter_config_t), allocatable :: all(:)
    real(rk), dimension(history%states%n_values()) :: lowest, highest
    integer :: i, n

    n = size(parameters)
    allocate (all(n + history%states%n_values()))
    all(:n) = parameters
    if (.not. history%states%is_there()) return
    lowest = 0
    highest = 0
    if (has_ranges) call find_ranges(parameters, history%states, lowest, highest)
    lowest(1) = 0
    do i = 1, size(lowest)
      all(n + i)%name = time_name
      if (i > 1) all(n + i)%name = history%states%tables(i - 1)%name
      all(n + i)%unit = ''
      if (i == 1) all(n + i)%unit = history%states%unit
      all(n + i)%minimum = lowest(i)
      all(n + i)%maximum = highest(i)
    end do
  end function state_parameters

  !> Finds the smallest and largest values of the time and the tables at the times of the states, over the middle, the corners and
  !> points inside of the box of the parameters, widened by 1 %.
  subroutine find_ranges(parameters, history, lowest, highest)
    type(parameter_config_t), intent(in) :: parameters(:)
    type(history_t), intent(in) :: history
    !> shape (n_values)
    real(rk), intent(out) :: lowest(:)
    real(rk), intent(out) :: highest(:)
    type(table_values_t) :: tables
    character(:), allocatable :: fault
    real(rk), allocatable :: corners(:, :), inside(:, :), points(:, :)
    real(rk) :: margins(size(lowest))
    real(rk) :: values(size(lowest))
    integer :: i, i_table, i_time

    call tables%create(history, names_of(parameters), fault)
    inside = points_inside(parameters, min(1000, max(20, most_samples / history%n_times())))
    corners = corners_to_try(parameters)
    points = reshape([corners, inside], [size(parameters), size(corners, 2) + size(inside, 2)])
    lowest = huge(lowest)
    highest = -huge(highest)
    do i = 1, size(points, 2)
      call tables%begin(points(:, i), i_table, fault)
      if (i_table > 0) cycle
      do i_time = 1, history%n_times()
        values = tables%at(history%times(i_time))
        lowest = min(lowest, values)
        highest = max(highest, values)
      end do
    end do
    call tables%destroy()
    ! between these points a table may go a little further
    margins = 0.01_rk * (highest - lowest)
    margins(1) = 0
    lowest = lowest - margins
    highest = highest + margins
  end subroutine find_ranges

  !> Returns points inside of the box that fill it evenly (an additive recurrence with the square roots of primes), shape
  !> (n_parameters, n); the same in each call.
  pure function points_inside(parameters, n) result(points)
    type(parameter_config_t), intent(in) :: parameters(:)
    integer, intent(in) :: n
    real(rk) :: points(size(parameters), n)
    integer, parameter :: primes(10) = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29]
    integer :: i, k

    do i = 1, n
      do k = 1, size(parameters)
        points(k, i) = modulo(0.5_rk + i * sqrt(real(primes(modulo(k - 1, size(primes)) + 1), rk)), 1.0_rk)
      end do
    end do
    points = in_box(points, parameters)
  end function points_inside
end module sig_deck_read_history
