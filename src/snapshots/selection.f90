! SPDX-License-Identifier: BSD-3-Clause
!> The points that a greedy selection has chosen, in their order. The table selection.csv is for people, and a run goes on from it.
module sig_selection
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
  use sig_errors, only: error_t, make_error
  use sig_file_system, only: file_exists, read_text_file, write_text_file
  use sig_kinds, only: rk
  use sig_text, only: csv_number, read_real, split, string_t, to_text
  implicit none(type, external)
  private
  public :: selection_t, read_selection, write_selection

  !> why a selection ended, as in the file
  character(*), parameter, public :: stopped_by_tolerance = 'tolerance'
  character(*), parameter, public :: stopped_by_budget = 'max_points'
  character(*), parameter, public :: stopped_by_candidates = 'candidates'

  character(*), parameter :: rule_line = '# greedy selection '
  character(*), parameter :: settings_line = '# settings '
  character(*), parameter :: stop_line = '# stopped by '
  character(*), parameter :: rest_line = '# largest indicator left '

  !> The chosen points. Call start, then append for new points.
  type :: selection_t
    !> hash of all settings on which the choice depends, except for those of its end
    character(16) :: settings = ''
    !> indicator, tolerance and largest number of points, as text for people
    character(:), allocatable :: rule
    !> shape (n_parameters, n_chosen)
    real(rk), allocatable :: points(:, :)
    !> [-] indicator of each point when it was chosen; NaN for the initial points, infinite if the model had no answer; shape
    !> (n_chosen)
    real(rk), allocatable :: indicators(:)
    !> [-] errors of the answer that the model had at the point before it was chosen, first that of error_name, then that of contact
    !> forces; NaN if there was no such answer; shape (2, n_chosen)
    real(rk), allocatable :: errors(:, :)
    !> column of the first error: `error_u` (displacement, like that of forces as an energy) or `error_stress` (over a history, like
    !> that of forces)
    character(:), allocatable :: error_name
    !> one of stopped_by_*; empty if the selection is not finished
    character(:), allocatable :: stopped_by
    !> [-] largest indicator of the candidates that were not chosen
    real(rk) :: largest_left = 0
  contains
    procedure :: start
    procedure :: append
    procedure :: shorten
  end type selection_t

contains

  !> Starts a selection without points, which is not finished.
  subroutine start(self, settings, rule, n_parameters)
    class(selection_t), intent(out) :: self
    !> hash of all settings on which the choice depends, except for those of its end
    character(16), intent(in) :: settings
    !> indicator, tolerance and largest number of points, as text for people
    character(*), intent(in) :: rule
    integer, intent(in) :: n_parameters

    self%settings = settings
    self%rule = rule
    self%stopped_by = ''
    self%error_name = 'error_u'
    allocate (self%points(n_parameters, 0), self%indicators(0), self%errors(2, 0))
  end subroutine start

  !> Appends points. Their errors are NaN until the caller sets them.
  subroutine append(self, points, indicators)
    class(selection_t), intent(inout) :: self
    !> shape (n_parameters, n)
    real(rk), intent(in) :: points(:, :)
    !> [-] as in selection_t, NaN for initial points; shape (n)
    real(rk), intent(in) :: indicators(:)
    real(rk) :: errors(2, size(indicators))

    errors = ieee_value(1.0_rk, ieee_quiet_nan)
    self%points = reshape([self%points, points], [size(points, 1), size(self%points, 2) + size(points, 2)])
    self%indicators = [self%indicators, indicators]
    self%errors = reshape([self%errors, errors], [2, size(self%indicators)])
  end subroutine append

  !> Keeps the first n points; the selection counts as not finished.
  subroutine shorten(self, n)
    class(selection_t), intent(inout) :: self
    integer, intent(in) :: n

    self%points = self%points(:, :n)
    self%indicators = self%indicators(:n)
    self%errors = self%errors(:, :n)
    self%stopped_by = ''
  end subroutine shorten

  !> Writes the table selection.csv, and replaces an existing one as a whole: rule and settings, a line per point with its indicator
  !> and errors, and, if the selection is finished, why it ended. Errors: the file cannot be written.
  subroutine write_selection(path, names, selection, error)
    character(*), intent(in) :: path
    !> names of the parameters
    type(string_t), intent(in) :: names(:)
    type(selection_t), intent(in) :: selection
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: eol = new_line('a')
    character(:), allocatable :: text
    integer :: i, k

    text = rule_line // selection%rule // eol // settings_line // selection%settings // eol // 'order,'
    do k = 1, size(names)
      text = text // names(k)%text // ','
    end do
    text = text // 'indicator,' // selection%error_name // ',error_lambda' // eol
    do i = 1, size(selection%indicators)
      text = text // to_text(i) // ','
      do k = 1, size(names)
        text = text // to_text(selection%points(k, i)) // ','
      end do
      text = text // csv_number(selection%indicators(i)) // ',' // csv_number(selection%errors(1, i)) // ',' // &
        csv_number(selection%errors(2, i)) // eol
    end do
    if (selection%stopped_by /= '') text = text // stop_line // selection%stopped_by // eol // rest_line // &
      csv_number(selection%largest_left) // eol
    call write_text_file(path, text, error)
  end subroutine write_selection

  !> Reads the table of a selection, selection.csv. The result has no points if the file is missing or lacks the line of these
  !> settings. Its settings and rule are those of the arguments.
  !>
  !> Errors: the file cannot be read, or a line is damaged: it has a wrong number of values, or one that is no number.
  subroutine read_selection(path, settings, rule, n_parameters, selection, error)
    character(*), intent(in) :: path
    !> as for start
    character(16), intent(in) :: settings
    !> as for start; if the rule of the table differs, the selection counts as not finished
    character(*), intent(in) :: rule
    integer, intent(in) :: n_parameters
    type(selection_t), intent(out) :: selection
    type(error_t), allocatable, intent(out) :: error
    type(string_t), allocatable :: lines(:)
    character(:), allocatable :: text
    logical :: is_of_rule
    integer :: i

    call selection%start(settings, rule, n_parameters)
    if (.not. file_exists(path)) return
    call read_text_file(path, text, error)
    if (allocated(error)) return
    lines = split(text, new_line('a'))
    if (.not. any([(lines(i)%text == settings_line // settings, i=1, size(lines))])) return
    is_of_rule = .false.
    do i = 1, size(lines)
      associate (line => lines(i)%text)
        if (line == rule_line // rule) is_of_rule = .true.
        if (index(line, '#') == 1 .or. index(line, 'order,') == 1 .or. len_trim(line) == 0) cycle
        call read_row(path, i, line, selection, error)
        if (allocated(error)) return
      end associate
    end do
    if (is_of_rule) call read_end(lines, selection)
  end subroutine read_selection

  subroutine read_row(path, i_line, line, selection, error)
    character(*), intent(in) :: path
    integer, intent(in) :: i_line
    character(*), intent(in) :: line
    type(selection_t), intent(inout) :: selection
    type(error_t), allocatable, intent(out) :: error
    type(string_t), allocatable :: words(:)
    real(rk), allocatable :: values(:)
    logical :: is_valid
    integer :: k, n

    words = split(line, ',')
    n = size(selection%points, 1)
    is_valid = size(words) == n + 4
    allocate (values(size(words)), source=0.0_rk)
    do k = 1, size(words)
      if (is_valid) call read_csv_number(words(k)%text, values(k), is_valid)
    end do
    if (is_valid) then
      call selection%append(reshape(values(2:n + 1), [n, 1]), values(n + 2:n + 2))
      selection%errors(:, size(selection%indicators)) = values(n + 3:)
    else
      call make_error(error, 'the table of selected points is damaged', path, i_line, &
        hint='remove it; the selection then starts again and uses the points that are solved already')
    end if
  end subroutine read_row

  !> Reads a number that csv_number wrote: also `nan` and `inf`. is_valid: the text is a number; else do not use the value.
  subroutine read_csv_number(word, value, is_valid)
    character(*), intent(in) :: word
    real(rk), intent(out) :: value
    logical, intent(out) :: is_valid

    is_valid = .true.
    select case (word)
    case ('nan')
      value = ieee_value(value, ieee_quiet_nan)
    case ('inf')
      value = ieee_value(value, ieee_positive_inf)
    case default
      call read_real(word, value, is_valid)
    end select
  end subroutine read_csv_number

  subroutine read_end(lines, selection)
    type(string_t), intent(in) :: lines(:)
    type(selection_t), intent(inout) :: selection
    logical :: is_valid
    integer :: i

    do i = 1, size(lines)
      associate (line => lines(i)%text)
        if (index(line, stop_line) == 1) selection%stopped_by = line(len(stop_line) + 1:)
        if (index(line, rest_line) == 1) call read_csv_number(line(len(rest_line) + 1:), selection%largest_left, is_valid)
      end associate
    end do
  end subroutine read_end
end module sig_selection
