! SPDX-License-Identifier: BSD-3-Clause
!> Collects what a run found below paths of keys, and writes it as YAML.
module sig_run_report
  use sig_errors, only: error_t
  use sig_file_system, only: write_text_file
  use sig_kinds, only: rk
  use sig_report_tree, only: report_tree_t
  use sig_report_yaml, only: yaml_of_real, yaml_of_text
  use sig_text, only: join, split, string_t, to_text
  use sig_text_buffer, only: text_buffer_t
  implicit none(type, external)
  private
  public :: run_report_t

  !> Keys are written in the order in which they were added first; if a key is added twice, the last value counts.
  !>
  !> `add('errors/e_u/median', value)`: value is a text, integer, real, logical, or a list of integers, reals or texts.
  !> `add_yaml(key, text)` puts a block of YAML below the key. On average, the time for a key does not depend on the number of
  !> keys.
  type :: run_report_t
    private
    type(report_tree_t) :: tree
  contains
    generic :: add => add_text, add_integer, add_real, add_logical, add_integers, add_reals, add_texts
    procedure, private :: add_text, add_integer, add_real, add_logical, add_integers, add_reals, add_texts
    procedure :: add_yaml
    procedure :: complete
    procedure :: text => report_text
    procedure :: write => write_report
  end type run_report_t

contains

  !> Sets a key, a path such as `errors/e_u/median`, to a text, or replaces its value. Keys above it are made if they are missing.
  subroutine add_text(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    character(*), intent(in) :: value

    call self%tree%set(key, yaml_of_text(value), .false.)
  end subroutine add_text

  !> Sets a key, as add_text does, to a whole number.
  subroutine add_integer(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    integer, intent(in) :: value

    call self%tree%set(key, to_text(value), .false.)
  end subroutine add_integer

  !> Sets a key, as add_text does, to a real number, which may be infinite or NaN.
  subroutine add_real(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    real(rk), intent(in) :: value

    call self%tree%set(key, yaml_of_real(value), .false.)
  end subroutine add_real

  !> Sets a key, as add_text does, to true or false.
  subroutine add_logical(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    logical, intent(in) :: value

    call self%tree%set(key, trim(merge('true ', 'false', value)), .false.)
  end subroutine add_logical

  !> Sets a key, as add_text does, to a list of whole numbers.
  subroutine add_integers(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    integer, intent(in) :: value(:)
    type(string_t) :: words(size(value))
    integer :: i

    do i = 1, size(value)
      words(i)%text = to_text(value(i))
    end do
    call self%tree%set(key, '[' // join(words, ', ') // ']', .false.)
  end subroutine add_integers

  !> Sets a key, as add_text does, to a list of real numbers.
  subroutine add_reals(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    real(rk), intent(in) :: value(:)
    type(string_t) :: words(size(value))
    integer :: i

    do i = 1, size(value)
      words(i)%text = yaml_of_real(value(i))
    end do
    call self%tree%set(key, '[' // join(words, ', ') // ']', .false.)
  end subroutine add_reals

  !> Sets a key, as add_text does, to a list of texts.
  subroutine add_texts(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    type(string_t), intent(in) :: value(:)
    type(string_t) :: words(size(value))
    integer :: i

    do i = 1, size(value)
      words(i)%text = yaml_of_text(value(i)%text)
    end do
    call self%tree%set(key, '[' // join(words, ', ') // ']', .false.)
  end subroutine add_texts

  !> Puts lines of YAML below a key without a change, except for their indent; empty lines are left out.
  subroutine add_yaml(self, key, yaml)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    !> block of lines that starts at column 1
    character(*), intent(in) :: yaml

    call self%tree%set(key, yaml, .true.)
  end subroutine add_yaml

  !> Returns the whole report as YAML.
  function report_text(self) result(text)
    class(run_report_t), intent(in) :: self
    character(:), allocatable :: text

    text = self%tree%text()
  end function report_text

  !> Adds sections (keys at the top), and keys of sections, that an earlier report of the same deck and provenance has and this one
  !> has not. A key of a section comes with all that is below it; if this report has the key, nothing below it is added. Nothing is
  !> added to a section that is a value or a block here. A report of another deck or provenance adds nothing.
  subroutine complete(self, earlier, left_out)
    class(run_report_t), intent(inout) :: self
    !> text of the earlier report, as text() makes it
    character(*), intent(in) :: earlier
    !> sections (`errors`) and keys of sections (`times/query`) that are not added because they are out of date
    type(string_t), intent(in) :: left_out(:)
    type(string_t), allocatable :: lines(:)
    type(text_buffer_t) :: block
    character(:), allocatable :: section, key, value
    integer :: i

    if (.not. is_same_study(self, earlier)) return
    lines = split(earlier, new_line('a'))
    section = ''
    key = ''
    value = ''
    do i = 1, size(lines)
      associate (line => lines(i)%text, depth => verify(lines(i)%text // 'x', ' ') - 1)
        if (depth > 2) then
          call block%add(line(5:) // new_line('a'))
          cycle
        end if
        call add_missing(self, section, key, value, block, left_out)
        if (depth == 0) then
          call split_line(line, section, value)
          key = ''
        else
          call split_line(line(depth + 1:), key, value)
        end if
      end associate
    end do
    call add_missing(self, section, key, value, block, left_out)
  end subroutine complete

  !> Whether this report has a deck (with its defaults) and a provenance, and an earlier report has the same ones.
  logical function is_same_study(self, earlier)
    class(run_report_t), intent(in) :: self
    character(*), intent(in) :: earlier
    integer :: i, k
    character(*), parameter :: keys(2) = [character(10) :: 'deck', 'provenance']

    is_same_study = .true.
    do k = 1, size(keys)
      i = self%tree%find(trim(keys(k)))
      is_same_study = i > 0
      if (.not. is_same_study) return
      is_same_study = index(new_line('a') // earlier, new_line('a') // self%tree%text(i)) > 0
      if (.not. is_same_study) return
    end do
  end function is_same_study

  !> Adds a key of a section, or a value at the top, unless the report has it, left_out names it or its section as out of date, or
  !> value and block are empty. Adds no key to a section that is a value or a block in this report. Empties the block.
  subroutine add_missing(self, section, key, value, block, left_out)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: section
    !> key below the section; empty: the section itself
    character(*), intent(in) :: key
    !> value on the line of the key; empty if a block follows
    character(*), intent(in) :: value
    type(text_buffer_t), intent(inout) :: block
    type(string_t), intent(in) :: left_out(:)
    character(:), allocatable :: path, lines
    integer :: i_section, k

    lines = block%text()
    call block%clear()
    if (len(value) + len(lines) == 0) return
    path = section
    if (len(key) > 0) path = section // '/' // key
    if (any([(left_out(k)%text == section .or. left_out(k)%text == path, k=1, size(left_out))])) return
    i_section = self%tree%find(section)
    if (i_section > 0) then
      ! a block, such as the deck, has no keys of its own
      if (.not. self%tree%has_keys(i_section) .or. len(key) == 0) return
      if (self%tree%find(key, i_section) > 0) return
    end if
    if (len(value) > 0) then
      call self%tree%set(path, value, .false.)
    else
      call self%tree%set(path, lines, .true.)
    end if
  end subroutine add_missing

  !> Splits `key: value` or `key:` at the first colon before a blank or the end, and removes quotes around the key. The value is
  !> empty if there is none.
  pure subroutine split_line(line, key, value)
    character(*), intent(in) :: line
    character(:), allocatable, intent(out) :: key
    character(:), allocatable, intent(out) :: value
    integer :: i

    i = index(line // ' ', ': ')
    key = line(:max(0, i - 1))
    value = trim(adjustl(line(i + 1:)))
    if (len(key) > 1) then
      if (key(1:1) == '"') key = key(2:len(key) - 1)
    end if
  end subroutine split_line

  !> Writes the report and replaces the whole file. Errors: the file cannot be written.
  subroutine write_report(self, path, error)
    class(run_report_t), intent(in) :: self
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call write_text_file(path, self%text(), error)
  end subroutine write_report
end module sig_run_report
