! SPDX-License-Identifier: BSD-3-Clause
!> Reads points from a CSV file or a pipe, as a stream or all at once. The first line names the parameters, in any order. Empty
!> lines and lines that start with # are left out. Names and numbers may stand in double quotes (RFC 4180).
!>
!> Errors, with line and column where they have a place: the file is missing, a folder, binary or cannot be read; an unknown,
!> repeated or missing column; a line with too few or too many values; a value that is no number or outside of the box; no point at
!> all.
module sig_point_list
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_size_t
  use sig_csv_fields, only: split_fields, without_end
  use sig_errors, only: error_t, make_error
  use sig_file_system, only: file_exists, is_directory
  use sig_system, only: system_reason
  use sig_kinds, only: rk
  use sig_text, only: are, counted, did_you_mean, join, read_real, string_t, to_text
  implicit none(type, external)
  private
  public :: point_list_t, read_points

  !> number of points that read_points reads at a time
  integer, parameter :: block_size = 1000
  !> bytes that some programs put before the first line of a UTF-8 file
  character(*), parameter :: byte_order_mark = char(239) // char(187) // char(191)

  !> A file of points. Call open, then next until it returns no point, then close.
  type :: point_list_t
    private
    character(:), allocatable :: path
    type(string_t), allocatable :: names(:)
    !> number of the parameter in each column
    integer, allocatable :: columns(:)
    integer(c_int) :: descriptor = -1
    integer :: i_line = 0
    !> number of points read so far
    integer :: n_points = 0
    logical :: is_open = .false.
    !> bytes that were read last, their number, and the position of the first one that belongs to no line yet
    character(32768) :: block
    integer :: n_block = 0
    integer :: i_next = 1
  contains
    procedure :: open => open_list
    procedure :: next
    procedure :: close => close_list
  end type point_list_t

  ! include/signorom/file_system.h describes these procedures in C.
  interface
    integer(c_int) function sig_open_to_read(path, length, descriptor) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      integer(c_int), intent(out) :: descriptor
    end function sig_open_to_read

    integer(c_int) function sig_read_some(descriptor, bytes, size, n_read) bind(c)
      import :: c_char, c_int, c_size_t
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(inout) :: bytes(*)
      integer(c_size_t), value :: size
      integer(c_size_t), intent(out) :: n_read
    end function sig_read_some

    subroutine sig_close_descriptor(descriptor) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor
    end subroutine sig_close_descriptor
  end interface

contains

  !> Opens the file and reads the line with the names; a list that is open must be closed before. Errors: the file is missing, a
  !> folder, binary, empty or cannot be read; an unknown, repeated or missing column. The list is then closed.
  subroutine open_list(self, path, names, error)
    class(point_list_t), intent(inout) :: self
    character(*), intent(in) :: path
    !> of the parameters
    type(string_t), intent(in) :: names(:)
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: line
    integer(c_int) :: code
    logical :: is_found

    self%path = path
    self%names = names
    self%n_block = 0
    self%i_next = 1
    self%i_line = 0
    self%n_points = 0
    if (is_directory(path)) then
      call make_error(error, 'this is a folder; a text file is needed', file=path)
    else if (.not. file_exists(path)) then
      call make_error(error, 'no such file', file=path)
    else
      code = sig_open_to_read(path, len(path, c_size_t), self%descriptor)
      if (code /= 0) call make_error(error, 'cannot read the file: ' // system_reason(code), file=path)
    end if
    if (allocated(error)) return
    self%is_open = .true.
    call read_content(self, line, is_found, error)
    if (is_found) call read_header(path, self%i_line, line, names, self%columns, error)
    if (.not. (is_found .or. allocated(error))) call report_nothing(self, error)
    if (allocated(error)) call self%close()
  end subroutine open_list

  subroutine report_nothing(self, error)
    class(point_list_t), intent(in) :: self
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: what

    what = 'the file holds no point'
    if (self%i_line == 0) what = 'the file is empty'
    call make_error(error, what // '; a first line with the names of the columns (' // join(self%names, ', ') // &
      ') and a line per point are needed', file=self%path)
  end subroutine report_nothing

  !> Reads the next points, at most as many as `points` has columns. n_points is 0 at the end of the list. Requires: open.
  !>
  !> Errors: a line with too few or too many values, or with a value that is no number or outside of the box; no point in the whole
  !> file; the file cannot be read, or is binary. Points of the lines before a bad one are set, but n_points counts the bad one,
  !> too. The list stays open then.
  subroutine next(self, points, n_points, error, box)
    class(point_list_t), intent(inout) :: self
    !> in the order of the names; only n_points columns are set; shape (n_parameters, most points at a time)
    real(rk), intent(inout) :: points(:, :)
    !> number of points that were read
    integer, intent(out) :: n_points
    type(error_t), allocatable, intent(out) :: error
    !> smallest and largest value of each parameter, shape (2, n_parameters); not checked where absent
    real(rk), intent(in), optional :: box(:, :)
    character(:), allocatable :: line
    logical :: is_found

    n_points = 0
    do while (n_points < size(points, 2))
      call read_content(self, line, is_found, error)
      if (allocated(error) .or. .not. is_found) exit
      n_points = n_points + 1
      call read_row(self%path, self%i_line, line, self%names, self%columns, points(:, n_points), error, box)
      if (allocated(error)) exit
    end do
    self%n_points = self%n_points + n_points
    if (self%n_points == 0 .and. .not. allocated(error)) call report_nothing(self, error)
  end subroutine next

  !> Closes the file. Harmless if it is not open.
  subroutine close_list(self)
    class(point_list_t), intent(inout) :: self

    if (self%is_open) call sig_close_descriptor(self%descriptor)
    self%is_open = .false.
  end subroutine close_list

  !> Reads all points of a CSV file or a pipe, also equal ones. Errors: the file is missing, a folder, binary or cannot be read; an
  !> unknown, repeated or missing column; a line with a wrong number of values; a value that is no number or outside of the box; no
  !> point at all.
  subroutine read_points(path, names, points, error, box)
    character(*), intent(in) :: path
    !> of the parameters
    type(string_t), intent(in) :: names(:)
    !> shape (n_parameters, n_points), in the order of names
    real(rk), allocatable, intent(out) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    !> smallest and largest value of each parameter, shape (2, n_parameters); not checked where absent
    real(rk), intent(in), optional :: box(:, :)
    type(point_list_t) :: list
    real(rk) :: block(size(names), block_size)
    integer :: n

    allocate (points(size(names), 0))
    call list%open(path, names, error)
    do while (.not. allocated(error))
      call list%next(block, n, error, box)
      if (n == 0 .or. allocated(error)) exit
      points = reshape([points, block(:, :n)], [size(names), size(points, 2) + n])
    end do
    call list%close()
  end subroutine read_points

  !> Reads the next line that is neither blank nor a comment, whose first letter is #. Removes a byte order mark from the first line
  !> of the file; a carriage return at the end of the line stays. is_found is false at the end of the file and after an error.
  subroutine read_content(self, line, is_found, error)
    class(point_list_t), intent(inout) :: self
    character(:), allocatable, intent(out) :: line
    logical, intent(out) :: is_found
    type(error_t), allocatable, intent(out) :: error
    logical :: is_line

    is_found = .false.
    do while (.not. is_found)
      call read_line(self, line, is_line, error)
      if (.not. is_line) return
      self%i_line = self%i_line + 1
      if (self%i_line == 1 .and. index(line, byte_order_mark) == 1) line = line(len(byte_order_mark) + 1:)
      is_found = has_content(line)
    end do
  end subroutine read_content

  !> Reads the next line, without its line feed; is_line is false at the end of the file and after an error. Does not count it in
  !> self%i_line. The file is read in blocks of bytes, because libgfortran would keep everything in memory that it reads from a
  !> pipe without advancing.
  !>
  !> Errors: the file cannot be read further, or holds null bytes.
  subroutine read_line(self, line, is_line, error)
    class(point_list_t), intent(inout) :: self
    character(:), allocatable, intent(out) :: line
    logical, intent(out) :: is_line
    type(error_t), allocatable, intent(out) :: error
    integer :: i_end

    line = ''
    is_line = .false.
    do
      if (self%i_next > self%n_block) call read_block(self, error)
      if (allocated(error) .or. self%n_block == 0) exit
      is_line = .true.
      i_end = index(self%block(self%i_next:self%n_block), new_line('a'))
      if (i_end > 0) then
        line = line // self%block(self%i_next:self%i_next + i_end - 2)
        self%i_next = self%i_next + i_end
        exit
      end if
      line = line // self%block(self%i_next:self%n_block)
      self%i_next = self%n_block + 1
    end do
    if (index(line, achar(0)) > 0) call make_error(error, 'the file has null bytes, so it is binary or UTF-16; a text ' // &
      'file in UTF-8 is needed', file=self%path)
    if (allocated(error)) is_line = .false.
  end subroutine read_line

  !> Reads the next block of bytes; self%n_block, their number, is 0 at the end of the file. Errors: the file cannot be read.
  subroutine read_block(self, error)
    class(point_list_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error
    integer(c_size_t) :: n_read
    integer(c_int) :: code

    self%i_next = 1
    code = sig_read_some(self%descriptor, self%block, len(self%block, c_size_t), n_read)
    self%n_block = int(n_read)
    if (code /= 0) call make_error(error, 'cannot read the file: ' // system_reason(code), file=self%path)
  end subroutine read_block

  pure logical function has_content(line)
    character(*), intent(in) :: line

    has_content = len_trim(without_end(line)) > 0 .and. index(adjustl(line), '#') /= 1
  end function has_content

  !> Finds which parameter each column of the line with the names holds; any order. Errors: an unknown or repeated column, a
  !> parameter without a column.
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
        call make_error(error, 'unknown column ''' // fields(i_field)%text // '''' // separator_text(fields(i_field)%text) // &
          '; the columns must be ' // join(names, ', '), path, i_line, starts(i_field), suggestion(fields(i_field)%text, names))
      else if (any(columns == i_name)) then
        call make_error(error, 'the column ''' // names(i_name)%text // ''' occurs twice', path, i_line, starts(i_field))
      end if
      if (allocated(error)) return
      columns(i_field) = i_name
    end do
    do i_name = 1, size(names)
      if (any(columns == i_name)) cycle
      call make_error(error, 'there is no column for ''' // names(i_name)%text // '''', path, i_line, 1)
      return
    end do
  end subroutine read_header

  pure function suggestion(word, names) result(hint)
    character(*), intent(in) :: word
    type(string_t), intent(in) :: names(:)
    character(:), allocatable :: hint

    hint = separator_hint(word)
    if (len(word) == 0) hint = 'leave columns without a name out: write.csv of R writes row names unless it has row.names = FALSE'
    if (len(hint) > 0) return
    hint = did_you_mean(word, names)
    if (len(hint) > 0) hint = 'did you mean ''' // hint // '''?'
  end function suggestion

  !> Returns what is wrong with a name in which semicolons or tabs stand; empty for other names.
  pure function separator_text(name) result(text)
    character(*), intent(in) :: name
    character(:), allocatable :: text

    text = ''
    if (index(name, achar(9)) > 0) text = ': tabs do not separate columns'
    if (index(name, ';') > 0) text = ': semicolons do not separate columns'
  end function separator_text

  !> Returns a hint for a line, or a part of it, with semicolons or tabs; empty for other texts.
  pure function separator_hint(line) result(hint)
    character(*), intent(in) :: line
    character(:), allocatable :: hint

    hint = ''
    if (scan(line, ';' // achar(9)) > 0) hint = 'separate the values by commas, and write decimals with a point (0.5,1.25)'
  end function separator_hint

  !> Returns a hint for a line whose number of values differs from the number of columns: about semicolons, tabs or decimal commas.
  !> Empty if there are too few values and neither semicolons nor tabs.
  pure function count_hint(line, n_values, n_columns) result(hint)
    character(*), intent(in) :: line
    integer, intent(in) :: n_values
    integer, intent(in) :: n_columns
    character(:), allocatable :: hint

    hint = separator_hint(line)
    if (n_values > n_columns .and. len(hint) == 0) hint = 'commas separate the values: write decimals with a point (0.5)'
  end function count_hint

  !> Returns a hint for a text that is no number: about semicolons, tabs or a decimal comma, which can stand between quotes. Empty
  !> for other texts.
  pure function number_hint(word) result(hint)
    character(*), intent(in) :: word
    character(:), allocatable :: hint

    hint = separator_hint(word)
    if (index(word, ',') > 0 .and. len(hint) == 0) hint = 'write decimals with a point (0.5)'
  end function number_hint

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
      call make_error(error, 'this line has ' // counted(size(fields), 'value') // '; ' // to_text(size(columns)) // &
        ' ' // are(size(columns)) // ' needed', path, i_line, starts(min(size(fields), size(columns) + 1)), &
        count_hint(line, size(fields), size(columns)))
      return
    end if
    do i_field = 1, size(fields)
      associate (word => fields(i_field)%text, i_name => columns(i_field))
        call read_real(word, point(i_name), is_valid)
        if (.not. is_valid) then
          call make_error(error, '''' // word // ''' is not a number', path, i_line, starts(i_field), number_hint(word))
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
end module sig_point_list
