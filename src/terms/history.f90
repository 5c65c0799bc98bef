! SPDX-License-Identifier: BSD-3-Clause
!> The history of a deck: times at which states are wanted, and tables, which are piecewise linear functions of the time.
!>
!> A state is a point s = (mu, t, tables at t): the parameters, the time and the value of each table. Loads, gaps and prescribed
!> values are functions of these numbers. So only this module knows that the last ones follow from mu and t.
module sig_history
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_expression, only: expression_t
  use sig_kinds, only: rk
  use sig_rounding, only: rounding_of_data
  use sig_text, only: read_real, short_number, string_t, to_text
  implicit none(type, external)
  private
  public :: history_t, table_t, table_values_t, states_of, step_times, time_name, value_at

  !> name of the time in expressions and tables of results
  character(*), parameter :: time_name = 'time'

  !> A function of the time, given at nodes. Before the first node it has the value there, behind the last node the value there.
  type :: table_t
    character(:), allocatable :: name
    !> [unit of time] times of the nodes, numbers or expressions of the parameters, shape (n_nodes)
    type(string_t), allocatable :: times(:)
    !> values there, shape (n_nodes)
    type(string_t), allocatable :: values(:)
  end type table_t

  !> Times and tables; none of both where a deck has no history.
  type :: history_t
    !> [unit of time] times of the states, > 0, ascending
    real(rk), allocatable :: times(:)
    type(table_t), allocatable :: tables(:)
    !> unit of the time, for people; may be empty
    character(:), allocatable :: unit
  contains
    procedure :: is_there
    procedure :: n_times
    procedure :: n_values
    procedure :: at_start
  end type history_t

  !> A number, or an expression of the parameters.
  type :: entry_t
    real(rk) :: number = 0
    logical :: is_number = .true.
    type(expression_t) :: expression
  end type entry_t

  !> The tables of a history for one point of the parameters at a time. Call create, then begin for each point.
  type :: table_values_t
    private
    integer, allocatable :: starts(:)
    type(entry_t), allocatable :: entries(:, :)
    !> times and values of the nodes of all tables at the point, shape (2, n_nodes)
    real(rk), allocatable :: nodes(:, :)
  contains
    procedure :: create
    procedure :: begin
    procedure :: at
    procedure :: turn_between
    procedure :: n_values => n_values_of_tables
    procedure :: destroy
  end type table_values_t

contains

  pure logical function is_there(self)
    class(history_t), intent(in) :: self

    is_there = self%n_times() > 0
  end function is_there

  !> Returns the number of states of one point of the parameters; 0 without a history.
  pure integer function n_times(self)
    class(history_t), intent(in) :: self

    n_times = 0
    if (allocated(self%times)) n_times = size(self%times)
  end function n_times

  !> Returns how many numbers a state has behind the parameters: the time and the value of each table; 0 without a history.
  pure integer function n_values(self)
    class(history_t), intent(in) :: self

    n_values = 0
    if (self%is_there()) n_values = 1 + size(self%tables)
  end function n_values

  !> Returns an expression of the parameters and the history with the time and the tables replaced by their values at the time 0.
  pure function at_start(self, text) result(started)
    class(history_t), intent(in) :: self
    character(*), intent(in) :: text
    character(:), allocatable :: started
    character(*), parameter :: word_letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.'
    integer :: first, last

    started = ''
    first = 1
    do while (first <= len(text))
      last = first + verify(text(first:) // ' ', word_letters) - 2
      if (last < first) then
        started = started // text(first:first)
        first = first + 1
      else
        started = started // value_of_word(text(first:last))
        first = last + 1
      end if
    end do

  contains

    pure function value_of_word(word) result(value)
      character(*), intent(in) :: word
      character(:), allocatable :: value
      integer :: k

      value = word
      if (.not. self%is_there()) return
      if (word == time_name) value = '0'
      do k = 1, size(self%tables)
        if (word == self%tables(k)%name) value = '(' // start_of_table(self%tables(k)) // ')'
      end do
    end function value_of_word
  end function at_start

  !> Returns the value of a table at the time 0, an expression of the parameters.
  pure function start_of_table(table) result(text)
    type(table_t), intent(in) :: table
    character(:), allocatable :: text
    integer :: i

    associate (times => table%times, values => table%values, n => size(table%times))
      text = '(' // values(n)%text // ')'
      do i = n - 1, 1, -1
        associate (t => '(' // times(i)%text // ')', v => '(' // values(i)%text // ')', next => '(' // times(i + 1)%text // ')')
          call take_where(times(i + 1)%text, '<', v // ' + ((' // values(i + 1)%text // ') - ' // v // ')*(0 - ' // t // ')/(' // &
            next // ' - ' // t // ')')
        end associate
      end do
      call take_where(times(1)%text, '<=', '(' // values(1)%text // ')')
    end associate

  contains

    !> Takes a value where 0 < time or 0 <= time. Where the time is a number, this is known.
    pure subroutine take_where(time, relation, value)
      character(*), intent(in) :: time, relation, value
      real(rk) :: number
      logical :: is_number

      call read_real(time, number, is_number)
      if (.not. is_number) then
        text = '(0 ' // relation // ' (' // time // ') ? ' // value // ' : ' // text // ')'
      else if (number > 0 .or. (number >= 0 .and. relation == '<=')) then
        text = value
      end if
    end subroutine take_where
  end function start_of_table

  !> Returns the times of one stretch: n times behind `start`, the last one `until`, whose increments grow by a constant factor, so
  !> that the last increment is `growth` times the first. Requires: start < until, n >= 1, growth > 0.
  pure function step_times(start, until, n, growth) result(times)
    real(rk), intent(in) :: start
    real(rk), intent(in) :: until
    integer, intent(in) :: n
    real(rk), intent(in) :: growth
    real(rk) :: times(n), lengths(n), passed, total
    integer :: i

    lengths = 1
    if (n > 1) lengths = [(growth**(real(i - 1, rk) / (n - 1)), i=1, n)]
    total = sum(lengths)
    passed = 0
    do i = 1, n
      passed = passed + lengths(i)
      ! where increments are equal, `passed` and `total` are whole numbers, and the times as exact as numbers can be
      times(i) = start + (until - start) * passed / total
    end do
    times(n) = until
  end function step_times

  !> Returns the value of a piecewise linear function, which is constant before its first and behind its last node. A time that
  !> differs from a node by rounding is the node, and a value that is only rounding beside those of its nodes is zero: a load that
  !> ends must be no load, because a body that only contact holds has no equilibrium under some smallest forces. Requires: the times
  !> ascend.
  pure real(rk) function value_at(times, values, time) result(value)
    real(rk), intent(in) :: times(:)
    !> shape (size(times))
    real(rk), intent(in) :: values(:)
    real(rk), intent(in) :: time
    real(rk), parameter :: rounding = 8 * epsilon(1.0_rk)
    real(rk) :: least
    integer :: i

    least = rounding * abs(time)
    i = count(times <= time + least)
    if (i == 0) then
      value = values(1)
    else if (i == size(times) .or. time <= times(max(1, i)) + least) then
      value = values(i)
    else
      value = values(i) + (values(i + 1) - values(i)) * ((time - times(i)) / (times(i + 1) - times(i)))
      if (abs(value) <= rounding * maxval(abs(values(i:i + 1)))) value = 0
    end if
  end function value_at

  !> Compiles the texts of the tables. Errors: message says which text is no number and no expression of the parameters.
  subroutine create(self, history, parameter_names, message)
    class(table_values_t), intent(inout) :: self
    type(history_t), intent(in) :: history
    type(string_t), intent(in) :: parameter_names(:)
    character(:), allocatable, intent(out) :: message
    integer :: i, k

    call self%destroy()
    allocate (self%starts(size(history%tables) + 1), source=1)
    do k = 1, size(history%tables)
      self%starts(k + 1) = self%starts(k) + size(history%tables(k)%times)
    end do
    allocate (self%entries(2, self%starts(size(self%starts)) - 1), self%nodes(2, self%starts(size(self%starts)) - 1))
    do k = 1, size(history%tables)
      associate (table => history%tables(k))
        do i = 1, size(table%times)
          if (.not. allocated(message)) call read_entry(table%times(i)%text, self%entries(1, self%starts(k) + i - 1), message)
          if (.not. allocated(message)) call read_entry(table%values(i)%text, self%entries(2, self%starts(k) + i - 1), message)
          if (.not. allocated(message)) cycle
          message = 'the table ''' // table%name // ''': ' // message
          return
        end do
      end associate
    end do
  contains
    subroutine read_entry(text, entry, problem)
      character(*), intent(in) :: text
      type(entry_t), intent(inout) :: entry
      character(:), allocatable, intent(inout) :: problem

      call read_real(text, entry%number, entry%is_number)
      if (.not. entry%is_number) call entry%expression%create(text, parameter_names, problem)
    end subroutine read_entry
  end subroutine create

  !> Computes the nodes of all tables at a point of the parameters. Errors: i_table is the first table with a node that is not
  !> finite, or whose times do not ascend, 1-based, and `fault` says which; 0 = none.
  subroutine begin(self, parameters, i_table, fault)
    class(table_values_t), intent(inout) :: self
    !> shape (n_parameters)
    real(rk), intent(in) :: parameters(:)
    integer, intent(out) :: i_table
    !> behind the name of the table, such as `has the times 2, 1, which do not ascend`
    character(:), allocatable, intent(out) :: fault
    integer :: i, k
    logical :: is_valid

    do i_table = 1, size(self%starts) - 1
      do i = self%starts(i_table), self%starts(i_table + 1) - 1
        do k = 1, 2
          associate (entry => self%entries(k, i))
            self%nodes(k, i) = entry%number
            is_valid = ieee_is_finite(entry%number)
            if (.not. entry%is_number) call entry%expression%evaluate(parameters, self%nodes(k, i), is_valid)
          end associate
          if (.not. is_valid) fault = 'has a ' // trim(merge('time ', 'value', k == 1)) // ' that is not finite (node ' // &
            to_text(i - self%starts(i_table) + 1) // ')'
          if (.not. is_valid) return
        end do
        if (i == self%starts(i_table)) cycle
        if (self%nodes(1, i) > self%nodes(1, i - 1)) cycle
        fault = 'has the times ' // short_number(self%nodes(1, i - 1)) // ', ' // short_number(self%nodes(1, i)) // &
          ', which do not ascend'
        return
      end do
    end do
    i_table = 0
  end subroutine begin

  !> Returns how many values `at` gives: the time and each table. Requires: create.
  pure integer function n_values_of_tables(self)
    class(table_values_t), intent(in) :: self

    n_values_of_tables = size(self%starts)
  end function n_values_of_tables

  !> Returns the time and the values of all tables there, the part of a state behind the parameters. Requires: begin.
  pure function at(self, time) result(values)
    class(table_values_t), intent(in) :: self
    real(rk), intent(in) :: time
    !> shape (1 + n_tables)
    real(rk) :: values(size(self%starts))
    integer :: k

    values(1) = time
    do k = 1, size(self%starts) - 1
      associate (nodes => self%nodes(:, self%starts(k):self%starts(k + 1) - 1))
        values(k + 1) = value_at(nodes(1, :), nodes(2, :), time)
      end associate
    end do
  end function at

  !> Returns the first time at which a table turns round (rises before it and falls behind it, or the other way) strictly between
  !> two of the given times, or before the first one; -1 if there is none. Requires: begin.
  pure real(rk) function turn_between(self, i_table, times) result(time)
    class(table_values_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: i_table
    !> ascending, > 0
    real(rk), intent(in) :: times(:)
    real(rk) :: before
    integer :: i

    before = 0
    associate (nodes => self%nodes(:, self%starts(i_table):self%starts(i_table + 1) - 1), last => times(size(times)))
      do i = 1, size(nodes, 2) - 1
        time = nodes(1, i)
        associate (change => nodes(2, i + 1) - nodes(2, i))
          if (before * change < 0 .and. time > 0 .and. time < last .and. minval(abs(times - time)) > rounding_of_data * last) return
          if (abs(change) > 0) before = change
        end associate
      end do
    end associate
    time = -1
  end function turn_between

  !> Frees the expressions. Does nothing before create.
  subroutine destroy(self)
    class(table_values_t), intent(inout) :: self
    integer :: i, k

    if (.not. allocated(self%starts)) return
    do i = 1, size(self%entries, 2)
      do k = 1, 2
        call self%entries(k, i)%expression%destroy()
      end do
    end do
    deallocate (self%starts, self%entries, self%nodes)
  end subroutine destroy

  !> Returns the states of some points of the parameters: those of the first point in the order of the times, then those of the
  !> second point, and so on. Without a history, the states are the points.
  !>
  !> Errors: `fault` names a table that is not valid at the point number i_bad_point, 1-based; the states are then incomplete.
  subroutine states_of(history, parameter_names, points, states, i_bad_point, fault)
    type(history_t), intent(in) :: history
    !> shape (n_parameters)
    type(string_t), intent(in) :: parameter_names(:)
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> shape (n_parameters + n_values, n_points * n_times), without a history that of the points
    real(rk), allocatable, intent(out) :: states(:, :)
    !> 0 = none
    integer, intent(out) :: i_bad_point
    character(:), allocatable, intent(out) :: fault
    type(table_values_t) :: tables
    integer :: i, i_table, i_time, n

    i_bad_point = 0
    states = points
    if (.not. history%is_there()) return
    n = history%n_times()
    deallocate (states)
    allocate (states(size(points, 1) + history%n_values(), n * size(points, 2)), source=0.0_rk)
    call tables%create(history, parameter_names, fault)
    if (allocated(fault)) i_bad_point = 1
    do i = 1, size(points, 2)
      if (allocated(fault)) exit
      call tables%begin(points(:, i), i_table, fault)
      if (i_table > 0) fault = 'the table ''' // history%tables(i_table)%name // ''' ' // fault
      if (i_table > 0) i_bad_point = i
      if (i_table > 0) exit
      do i_time = 1, n
        states(:, (i - 1) * n + i_time) = [points(:, i), tables%at(history%times(i_time))]
      end do
    end do
    call tables%destroy()
  end subroutine states_of
end module sig_history
