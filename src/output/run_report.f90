! SPDX-License-Identifier: BSD-3-Clause
!> What a run found, gathered under key paths and written as YAML.
module sig_run_report
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
  use sig_errors, only: error_t
  use sig_file_system, only: write_text_file
  use sig_kinds, only: rk
  use sig_text, only: join, lower, split, string_t, to_text
  implicit none(type, external)
  private
  public :: run_report_t

  !> One key; a key with others below it has no value of its own.
  type :: entry_t
    character(:), allocatable :: key
    !> index of the key above, 0 at the top
    integer :: i_parent = 0
    !> ready YAML: one line, or (is_block) whole lines
    character(:), allocatable :: yaml
    logical :: is_block = .false.
  end type entry_t

  !> Keys come out in the order in which they were first named; a value given twice counts as given last.
  !>
  !> `add('errors/e_u/median', value)`: value is a text, integer, real, logical, or a list of integers, reals or texts.
  !> `add_yaml(key, text)` puts a block of YAML below the key.
  type :: run_report_t
    private
    type(entry_t), allocatable :: entries(:)
  contains
    generic :: add => add_text, add_integer, add_real, add_logical, add_integers, add_reals, add_texts
    procedure, private :: add_text, add_integer, add_real, add_logical, add_integers, add_reals, add_texts
    procedure :: add_yaml
    procedure :: text => report_text
    procedure :: write => write_report
  end type run_report_t

contains

  pure subroutine add_text(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    character(*), intent(in) :: value

    call set(self, key, yaml_of_text(value), .false.)
  end subroutine add_text

  pure subroutine add_integer(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    integer, intent(in) :: value

    call set(self, key, to_text(value), .false.)
  end subroutine add_integer

  pure subroutine add_real(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    real(rk), intent(in) :: value

    call set(self, key, yaml_of_real(value), .false.)
  end subroutine add_real

  pure subroutine add_logical(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    logical, intent(in) :: value

    call set(self, key, trim(merge('true ', 'false', value)), .false.)
  end subroutine add_logical

  pure subroutine add_integers(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    integer, intent(in) :: value(:)
    type(string_t) :: words(size(value))
    integer :: i

    do i = 1, size(value)
      words(i)%text = to_text(value(i))
    end do
    call set(self, key, '[' // join(words, ', ') // ']', .false.)
  end subroutine add_integers

  pure subroutine add_reals(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    real(rk), intent(in) :: value(:)
    type(string_t) :: words(size(value))
    integer :: i

    do i = 1, size(value)
      words(i)%text = yaml_of_real(value(i))
    end do
    call set(self, key, '[' // join(words, ', ') // ']', .false.)
  end subroutine add_reals

  pure subroutine add_texts(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    type(string_t), intent(in) :: value(:)
    type(string_t) :: words(size(value))
    integer :: i

    do i = 1, size(value)
      words(i)%text = yaml_of_text(value(i)%text)
    end do
    call set(self, key, '[' // join(words, ', ') // ']', .false.)
  end subroutine add_texts

  !> Puts YAML lines, as they are, below a key.
  pure subroutine add_yaml(self, key, yaml)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    !> block of lines that starts at column 1
    character(*), intent(in) :: yaml

    call set(self, key, yaml, .true.)
  end subroutine add_yaml

  pure subroutine set(self, key, yaml, is_block)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    character(*), intent(in) :: yaml
    logical, intent(in) :: is_block
    type(string_t), allocatable :: words(:)
    integer :: i_entry, i_parent, i_word

    if (.not. allocated(self%entries)) allocate (self%entries(0))
    words = split(key, '/')
    i_entry = 0
    do i_word = 1, size(words)
      i_parent = i_entry
      i_entry = find_entry(self%entries, words(i_word)%text, i_parent)
      if (i_entry == 0) call append(self%entries, words(i_word)%text, i_parent, i_entry)
    end do
    self%entries(i_entry)%yaml = yaml
    self%entries(i_entry)%is_block = is_block
  end subroutine set

  ! By hand: gfortran 12 loses the text of a constructor inside an array constructor.
  pure subroutine append(entries, key, i_parent, i_entry)
    type(entry_t), allocatable, intent(inout) :: entries(:)
    character(*), intent(in) :: key
    integer, intent(in) :: i_parent
    !> the new one
    integer, intent(out) :: i_entry
    type(entry_t), allocatable :: longer(:)

    i_entry = size(entries) + 1
    allocate (longer(i_entry))
    longer(:size(entries)) = entries
    longer(i_entry)%key = key
    longer(i_entry)%i_parent = i_parent
    call move_alloc(longer, entries)
  end subroutine append

  pure integer function find_entry(entries, key, i_parent) result(i_entry)
    type(entry_t), intent(in) :: entries(:)
    character(*), intent(in) :: key
    integer, intent(in) :: i_parent

    do i_entry = 1, size(entries)
      if (entries(i_entry)%i_parent == i_parent .and. entries(i_entry)%key == key) return
    end do
    i_entry = 0
  end function find_entry

  !> The whole report as YAML.
  pure function report_text(self) result(text)
    class(run_report_t), intent(in) :: self
    character(:), allocatable :: text

    text = ''
    if (allocated(self%entries)) text = text_below(self%entries, 0, '')
  end function report_text

  pure recursive function text_below(entries, i_parent, indent) result(text)
    type(entry_t), intent(in) :: entries(:)
    integer, intent(in) :: i_parent
    character(*), intent(in) :: indent
    character(:), allocatable :: text, head
    integer :: i

    text = ''
    do i = 1, size(entries)
      if (entries(i)%i_parent /= i_parent) cycle
      head = indent // yaml_of_text(entries(i)%key) // ':'
      if (any(entries%i_parent == i)) then
        text = text // head // new_line('a') // text_below(entries, i, indent // '  ')
      else if (entries(i)%is_block) then
        text = text // head // new_line('a') // indented(entries(i)%yaml, indent // '  ')
      else
        text = text // head // ' ' // entries(i)%yaml // new_line('a')
      end if
    end do
  end function text_below

  !> Each line that is not empty, shifted to the right.
  pure function indented(lines, indent) result(text)
    character(*), intent(in) :: lines
    character(*), intent(in) :: indent
    character(:), allocatable :: text
    type(string_t), allocatable :: pieces(:)
    integer :: i_line

    text = ''
    pieces = split(lines, new_line('a'))
    do i_line = 1, size(pieces)
      if (len(pieces(i_line)%text) > 0) text = text // indent // pieces(i_line)%text // new_line('a')
    end do
  end function indented

  !> YAML has words of its own for what is no number; readers of YAML 1.1 (PyYAML) want the sign of an exponent.
  pure function yaml_of_real(value) result(yaml)
    real(rk), intent(in) :: value
    character(:), allocatable :: yaml
    integer :: i_e

    if (ieee_is_finite(value)) then
      yaml = to_text(value)
      i_e = index(yaml, 'e')
      if (i_e > 0 .and. index(yaml, 'e-') == 0) yaml = yaml(:i_e) // '+' // yaml(i_e + 1:)
    else if (ieee_is_nan(value)) then
      yaml = '.nan'
    else
      yaml = trim(merge('-.inf', '.inf ', value < 0))
    end if
  end function yaml_of_real

  !> Plain where YAML can take it for nothing but this text, else between double quotes.
  pure function yaml_of_text(value) result(yaml)
    character(*), intent(in) :: value
    character(:), allocatable :: yaml
    integer :: i

    if (is_plain(value)) then
      yaml = value
      return
    end if
    yaml = '"'
    do i = 1, len(value)
      yaml = yaml // escaped(value(i:i))
    end do
    yaml = yaml // '"'
  end function yaml_of_text

  pure logical function is_plain(value)
    character(*), intent(in) :: value
    character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_'
    ! words that one YAML version or the other reads as something else
    character(*), parameter :: taken = ' y n yes no on off true false null nan inf '

    is_plain = .false.
    if (len(value) == 0) return
    if (scan(value(1:1), letters) == 0 .or. value(len(value):) == ' ') return
    if (verify(value, letters // '0123456789 ./()+*-') > 0) return
    is_plain = index(taken, ' ' // lower(value) // ' ') == 0
  end function is_plain

  pure function escaped(letter) result(text)
    character(1), intent(in) :: letter
    character(:), allocatable :: text
    character(4) :: code

    select case (letter)
    case ('"', achar(92))
      text = achar(92) // letter
    case (achar(10))
      text = achar(92) // 'n'
    case (achar(9))
      text = achar(92) // 't'
    case default
      text = letter
      if (iachar(letter) < 32) then
        write (code, '(a, z2.2)') achar(92) // 'x', iachar(letter)
        text = code
      end if
    end select
  end function escaped

  !> Replaces the file as a whole. Errors: it cannot be written.
  subroutine write_report(self, path, error)
    class(run_report_t), intent(in) :: self
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call write_text_file(path, self%text(), error)
  end subroutine write_report
end module sig_run_report
