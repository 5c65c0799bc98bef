! SPDX-License-Identifier: BSD-3-Clause
!> Points of the parameter box: tensor grids, sequences, lists from CSV files, and how a point is written for people.
module sig_parameter_space
  use sig_deck_config, only: parameter_config_t, point_set_config_t
  use sig_errors, only: error_t, make_error
  use sig_file_system, only: read_text_file
  use sig_kinds, only: rk
  use sig_latin_hypercube, only: latin_hypercube_points
  use sig_sobol, only: sobol_points
  use sig_text, only: did_you_mean, join, read_real, split, string_t, to_text
  implicit none(type, external)
  private
  public :: build_points, read_points, format_point

  interface format_point
    procedure format_point_of_deck, format_point_of_names
  end interface format_point

contains

  !> The points that a deck asks for.
  !>
  !> Grid: the first parameter varies slowest, ends included, value i of n is minimum + (maximum - minimum) * (i - 1) / (n - 1);
  !> a grid of one value takes the minimum. Errors: those of read_points, and a listed point outside the box.
  subroutine build_points(point_set, parameters, points, error)
    type(point_set_config_t), intent(in) :: point_set
    type(parameter_config_t), intent(in) :: parameters(:)
    !> [unit of each parameter] shape (n_parameters, n_points)
    real(rk), allocatable, intent(out) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    type(string_t) :: names(size(parameters))
    integer :: i_parameter

    if (allocated(point_set%grid)) then
      points = grid_points(point_set%grid, parameters%minimum, parameters%maximum)
    else if (point_set%n_sobol > 0) then
      points = in_box(sobol_points(size(parameters), point_set%n_sobol, point_set%seed), parameters)
    else if (point_set%n_latin_hypercube > 0) then
      points = in_box(latin_hypercube_points(size(parameters), point_set%n_latin_hypercube, point_set%seed), parameters)
    end if
    if (.not. allocated(point_set%path)) return
    do i_parameter = 1, size(parameters)
      names(i_parameter)%text = parameters(i_parameter)%name
    end do
    call read_points(point_set%path, names, points, error, transpose(reshape([parameters%minimum, parameters%maximum], &
      [size(parameters), 2])))
  end subroutine build_points

  !> From the unit cube into the box of the parameters.
  pure function in_box(fractions, parameters) result(points)
    !> [-] in [0, 1), shape (n_parameters, n_points)
    real(rk), intent(in) :: fractions(:, :)
    type(parameter_config_t), intent(in) :: parameters(:)
    real(rk) :: points(size(fractions, 1), size(fractions, 2))
    integer :: i

    do i = 1, size(fractions, 2)
      points(:, i) = parameters%minimum + fractions(:, i) * (parameters%maximum - parameters%minimum)
    end do
  end function in_box

  pure function grid_points(n_values, minima, maxima) result(points)
    !> shape (n_parameters)
    integer, intent(in) :: n_values(:)
    real(rk), intent(in) :: minima(:)
    real(rk), intent(in) :: maxima(:)
    real(rk), allocatable :: points(:, :)
    integer :: i_parameter, i_point, i_rest

    allocate (points(size(n_values), product(n_values)))
    do i_point = 1, size(points, 2)
      i_rest = i_point - 1
      do i_parameter = size(n_values), 1, -1
        associate (n => n_values(i_parameter))
          points(i_parameter, i_point) = grid_value(modulo(i_rest, n), n, minima(i_parameter), maxima(i_parameter))
          i_rest = i_rest / n
        end associate
      end do
    end do
  end function grid_points

  !> Value number i_value_0 (from 0) of n_values from minimum to maximum; the ends are exact.
  pure real(rk) function grid_value(i_value_0, n_values, minimum, maximum) result(value)
    integer, intent(in) :: i_value_0
    integer, intent(in) :: n_values
    real(rk), intent(in) :: minimum
    real(rk), intent(in) :: maximum

    value = minimum
    if (n_values == 1) return
    value = minimum + (maximum - minimum) * i_value_0 / (n_values - 1)
    if (i_value_0 == n_values - 1) value = maximum
  end function grid_value

  !> Points from a CSV file whose first line names the parameters, in any order.
  !>
  !> Empty lines and lines that start with # are left out.
  !>
  !> Errors, each with line and column: the file's own (missing, a folder, ...), an unknown, repeated or missing column, a line
  !> with too few or too many values, something that is no number, a value outside the box, no point at all.
  subroutine read_points(path, names, points, error, box)
    character(*), intent(in) :: path
    type(string_t), intent(in) :: names(:)
    !> shape (n_parameters, n_points), in the order of names
    real(rk), allocatable, intent(out) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    !> smallest and largest value of each parameter, shape (2, n_parameters); not checked where absent
    real(rk), intent(in), optional :: box(:, :)
    character(:), allocatable :: text
    type(string_t), allocatable :: lines(:)
    integer, allocatable :: numbers(:), columns(:)
    integer :: i_line

    allocate (points(size(names), 0))
    call read_text_file(path, text, error)
    if (allocated(error)) return
    lines = split(text, new_line('a'))
    numbers = pack([(i_line, i_line=1, size(lines))], [(has_content(lines(i_line)%text), i_line=1, size(lines))])
    if (size(numbers) > 0) then
      call read_header(path, numbers(1), lines(numbers(1))%text, names, columns, error)
      if (allocated(error)) return
    end if
    if (size(numbers) < 2) then
      call make_error(error, 'the file holds no point; a first line with the names of the parameters (' // join(names, ', ') // &
        ') and a line per point are needed', file=path)
      return
    end if
    deallocate (points)
    allocate (points(size(names), size(numbers) - 1))
    do i_line = 2, size(numbers)
      call read_row(path, numbers(i_line), lines(numbers(i_line))%text, names, columns, points(:, i_line - 1), error, box)
      if (allocated(error)) return
    end do
  end subroutine read_points

  pure logical function has_content(line)
    character(*), intent(in) :: line

    has_content = len_trim(without_end(line)) > 0 .and. index(adjustl(line), '#') /= 1
  end function has_content

  !> The line without a carriage return (files from Windows).
  pure function without_end(line) result(text)
    character(*), intent(in) :: line
    character(:), allocatable :: text

    text = line
    if (len(text) == 0) return
    if (text(len(text):) == achar(13)) text = text(:len(text) - 1)
  end function without_end

  !> Which parameter each column holds.
  subroutine read_header(path, i_line, line, names, columns, error)
    character(*), intent(in) :: path
    integer, intent(in) :: i_line
    character(*), intent(in) :: line
    type(string_t), intent(in) :: names(:)
    !> index into names, shape (number of columns)
    integer, allocatable, intent(out) :: columns(:)
    type(error_t), allocatable, intent(out) :: error
    type(string_t), allocatable :: fields(:)
    integer, allocatable :: starts(:)
    integer :: i_field, i_name

    call split_fields(line, fields, starts)
    allocate (columns(size(fields)), source=0)
    do i_field = 1, size(fields)
      do i_name = 1, size(names)
        if (names(i_name)%text == fields(i_field)%text) exit
      end do
      if (i_name > size(names)) then
        call make_error(error, 'unknown column ''' // fields(i_field)%text // '''; the parameters are ' // join(names, ', '), &
          path, i_line, starts(i_field), suggestion(fields(i_field)%text, names))
      else if (any(columns == i_name)) then
        call make_error(error, 'the column ''' // names(i_name)%text // ''' occurs twice', path, i_line, starts(i_field))
      end if
      if (allocated(error)) return
      columns(i_field) = i_name
    end do
    do i_name = 1, size(names)
      if (any(columns == i_name)) cycle
      call make_error(error, 'there is no column for the parameter ''' // names(i_name)%text // '''', path, i_line, 1)
      return
    end do
  end subroutine read_header

  pure function suggestion(word, names) result(hint)
    character(*), intent(in) :: word
    type(string_t), intent(in) :: names(:)
    character(:), allocatable :: hint

    hint = did_you_mean(word, names)
    if (len(hint) > 0) hint = 'did you mean ''' // hint // '''?'
  end function suggestion

  subroutine read_row(path, i_line, line, names, columns, point, error, box)
    character(*), intent(in) :: path
    integer, intent(in) :: i_line
    character(*), intent(in) :: line
    type(string_t), intent(in) :: names(:)
    integer, intent(in) :: columns(:)
    real(rk), intent(out) :: point(:)
    type(error_t), allocatable, intent(out) :: error
    real(rk), intent(in), optional :: box(:, :)
    type(string_t), allocatable :: fields(:)
    integer, allocatable :: starts(:)
    integer :: i_field
    logical :: is_valid

    point = 0
    call split_fields(line, fields, starts)
    if (size(fields) /= size(columns)) then
      call make_error(error, 'this line has ' // to_text(size(fields)) // ' values; ' // to_text(size(columns)) // &
        ' are needed', path, i_line, starts(min(size(fields), size(columns) + 1)))
      return
    end if
    do i_field = 1, size(fields)
      associate (word => fields(i_field)%text, i_name => columns(i_field))
        call read_real(word, point(i_name), is_valid)
        if (.not. is_valid) then
          call make_error(error, '''' // word // ''' is not a number', path, i_line, starts(i_field))
          return
        end if
        if (.not. present(box)) cycle
        if (point(i_name) >= box(1, i_name) .and. point(i_name) <= box(2, i_name)) cycle
        call make_error(error, names(i_name)%text // ' is ' // word // '; the deck allows ' // to_text(box(1, i_name)) // &
          ' to ' // to_text(box(2, i_name)), path, i_line, starts(i_field))
        return
      end associate
    end do
  end subroutine read_row

  !> What stands between the commas, without blanks around it, and the column of its first character.
  pure subroutine split_fields(line, fields, starts)
    character(*), intent(in) :: line
    type(string_t), allocatable, intent(out) :: fields(:)
    !> 1-based
    integer, allocatable, intent(out) :: starts(:)
    integer :: i_field, n_before

    fields = split(without_end(line), ',')
    allocate (starts(size(fields)))
    n_before = 0
    do i_field = 1, size(fields)
      starts(i_field) = n_before + max(1, verify(fields(i_field)%text, ' '))
      n_before = n_before + len(fields(i_field)%text) + 1
      fields(i_field)%text = trim(adjustl(fields(i_field)%text))
    end do
  end subroutine split_fields

  !> `squeeze = 0.2 m, angle = 3`, for logs and messages.
  pure function format_point_of_deck(parameters, point) result(text)
    type(parameter_config_t), intent(in) :: parameters(:)
    real(rk), intent(in) :: point(:)
    character(:), allocatable :: text
    type(string_t) :: parts(size(parameters))
    integer :: i

    do i = 1, size(parameters)
      parts(i)%text = parameters(i)%name // ' = ' // rounded(point(i))
      if (.not. allocated(parameters(i)%unit)) cycle
      if (len(parameters(i)%unit) > 0) parts(i)%text = parts(i)%text // ' ' // parameters(i)%unit
    end do
    text = join(parts, ', ')
  end function format_point_of_deck

  !> The same where only the names are known.
  pure function format_point_of_names(names, point) result(text)
    type(string_t), intent(in) :: names(:)
    real(rk), intent(in) :: point(:)
    character(:), allocatable :: text
    type(string_t) :: parts(size(names))
    integer :: i

    do i = 1, size(names)
      parts(i)%text = names(i)%text // ' = ' // rounded(point(i))
    end do
    text = join(parts, ', ')
  end function format_point_of_names

  !> Ten digits are enough to tell points apart; more would show the rounding of grid values.
  pure function rounded(value) result(text)
    real(rk), intent(in) :: value
    character(:), allocatable :: text
    character(24) :: buffer
    real(rk) :: short_value

    write (buffer, '(es24.9e3)') value
    read (buffer, *) short_value
    text = to_text(short_value)
  end function rounded
end module sig_parameter_space
