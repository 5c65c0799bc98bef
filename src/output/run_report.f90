! SPDX-License-Identifier: BSD-3-Clause
!> What a run found, gathered under key paths and written as YAML.
module sig_run_report
  use sig_checksum, only: fnv1a
  use sig_errors, only: error_t
  use sig_file_system, only: write_text_file
  use sig_kinds, only: lk, rk
  use sig_report_yaml, only: yaml_of_real, yaml_of_text
  use sig_text, only: join, split, string_t, to_text
  use sig_text_buffer, only: text_buffer_t
  implicit none(type, external)
  private
  public :: run_report_t

  !> One key; a key with others below it has no value of its own. Entry 1 is the top, which has no key.
  type :: entry_t
    character(:), allocatable :: key
    integer :: i_parent = 0
    !> the first and the last key below it, the next key of the same parent; 0 where there is none
    integer :: i_first = 0
    integer :: i_last = 0
    integer :: i_next = 0
    !> ready YAML: one line, or (is_block) whole lines
    character(:), allocatable :: yaml
    logical :: is_block = .false.
  end type entry_t

  !> Keys come out in the order in which they were first named; a value given twice counts as given last.
  !>
  !> `add('errors/e_u/median', value)`: value is a text, integer, real, logical, or a list of integers, reals or texts.
  !> `add_yaml(key, text)` puts a block of YAML below the key. Cost: the same for each key, however many there are.
  type :: run_report_t
    private
    type(entry_t), allocatable :: entries(:)
    integer :: n_entries = 0
    !> entries by the hash of their key and parent, 0 where free; a power of two of them
    integer, allocatable :: slots(:)
  contains
    generic :: add => add_text, add_integer, add_real, add_logical, add_integers, add_reals, add_texts
    procedure, private :: add_text, add_integer, add_real, add_logical, add_integers, add_reals, add_texts
    procedure :: add_yaml
    procedure :: complete
    procedure :: text => report_text
    procedure :: write => write_report
  end type run_report_t

contains

  subroutine add_text(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    character(*), intent(in) :: value

    call set(self, key, yaml_of_text(value), .false.)
  end subroutine add_text

  subroutine add_integer(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    integer, intent(in) :: value

    call set(self, key, to_text(value), .false.)
  end subroutine add_integer

  subroutine add_real(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    real(rk), intent(in) :: value

    call set(self, key, yaml_of_real(value), .false.)
  end subroutine add_real

  subroutine add_logical(self, key, value)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    logical, intent(in) :: value

    call set(self, key, trim(merge('true ', 'false', value)), .false.)
  end subroutine add_logical

  subroutine add_integers(self, key, value)
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

  subroutine add_reals(self, key, value)
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

  subroutine add_texts(self, key, value)
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
  subroutine add_yaml(self, key, yaml)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    !> block of lines that starts at column 1
    character(*), intent(in) :: yaml

    call set(self, key, yaml, .true.)
  end subroutine add_yaml

  subroutine set(self, key, yaml, is_block)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    character(*), intent(in) :: yaml
    logical, intent(in) :: is_block
    type(string_t), allocatable :: words(:)
    integer :: i_entry, i_slot, i_word

    if (self%n_entries == 0) call start(self)
    words = split(key, '/')
    i_entry = 1
    do i_word = 1, size(words)
      i_slot = slot_of(self, words(i_word)%text, i_entry)
      if (self%slots(i_slot) == 0) then
        call append(self, words(i_word)%text, i_entry, i_slot)
        i_entry = self%n_entries
      else
        i_entry = self%slots(i_slot)
      end if
    end do
    self%entries(i_entry)%yaml = yaml
    self%entries(i_entry)%is_block = is_block
  end subroutine set

  !> The top.
  pure subroutine start(self)
    class(run_report_t), intent(inout) :: self
    integer, parameter :: n_first = 64

    allocate (self%entries(n_first))
    allocate (self%slots(4 * n_first), source=0)
    self%n_entries = 1
    self%entries(1)%key = ''
  end subroutine start

  !> Where a key below a parent stands, or the free slot where it belongs.
  pure integer function slot_of(self, key, i_parent) result(i_slot)
    class(run_report_t), intent(in) :: self
    character(*), intent(in) :: key
    integer, intent(in) :: i_parent

    i_slot = int(iand(fnv1a(key, int(i_parent, lk)), int(size(self%slots) - 1, lk))) + 1
    do while (self%slots(i_slot) > 0)
      associate (entry => self%entries(self%slots(i_slot)))
        if (entry%i_parent == i_parent .and. entry%key == key) return
      end associate
      i_slot = modulo(i_slot, size(self%slots)) + 1
    end do
  end function slot_of

  !> A new last key below a parent.
  pure subroutine append(self, key, i_parent, i_slot)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: key
    integer, intent(in) :: i_parent
    !> free
    integer, intent(in) :: i_slot
    integer :: i

    i = self%n_entries + 1
    if (i > size(self%entries)) call grow(self%entries)
    self%n_entries = i
    self%entries(i)%key = key
    self%entries(i)%i_parent = i_parent
    associate (parent => self%entries(i_parent))
      if (parent%i_first == 0) then
        parent%i_first = i
      else
        self%entries(parent%i_last)%i_next = i
      end if
      parent%i_last = i
    end associate
    self%slots(i_slot) = i
    if (2 * i > size(self%slots)) call spread_out(self)
  end subroutine append

  !> Twice the room. Texts move: copies of so many would take their time.
  pure subroutine grow(entries)
    type(entry_t), allocatable, intent(inout) :: entries(:)
    type(entry_t), allocatable :: longer(:)
    integer :: i

    allocate (longer(2 * size(entries)))
    do i = 1, size(entries)
      call move_alloc(entries(i)%key, longer(i)%key)
      call move_alloc(entries(i)%yaml, longer(i)%yaml)
      longer(i)%i_parent = entries(i)%i_parent
      longer(i)%i_first = entries(i)%i_first
      longer(i)%i_last = entries(i)%i_last
      longer(i)%i_next = entries(i)%i_next
      longer(i)%is_block = entries(i)%is_block
    end do
    call move_alloc(longer, entries)
  end subroutine grow

  !> Four times the slots.
  pure subroutine spread_out(self)
    class(run_report_t), intent(inout) :: self
    integer, allocatable :: slots(:)
    integer :: i

    allocate (slots(4 * size(self%slots)), source=0)
    call move_alloc(slots, self%slots)
    do i = 2, self%n_entries
      self%slots(slot_of(self, self%entries(i)%key, self%entries(i)%i_parent)) = i
    end do
  end subroutine spread_out

  !> The whole report as YAML.
  function report_text(self) result(text)
    class(run_report_t), intent(in) :: self
    character(:), allocatable :: text
    type(text_buffer_t) :: buffer

    if (self%n_entries > 0) call add_below(self, 1, '', buffer)
    text = buffer%text()
  end function report_text

  recursive subroutine add_below(self, i_parent, indent, buffer)
    class(run_report_t), intent(in) :: self
    integer, intent(in) :: i_parent
    character(*), intent(in) :: indent
    type(text_buffer_t), intent(inout) :: buffer
    integer :: i

    i = self%entries(i_parent)%i_first
    do while (i > 0)
      call add_entry(self, i, indent, buffer)
      i = self%entries(i)%i_next
    end do
  end subroutine add_below

  !> A key with its value, its block or all below it.
  recursive subroutine add_entry(self, i, indent, buffer)
    class(run_report_t), intent(in) :: self
    integer, intent(in) :: i
    character(*), intent(in) :: indent
    type(text_buffer_t), intent(inout) :: buffer

    associate (entry => self%entries(i))
      call buffer%add(indent // yaml_of_text(entry%key) // ':')
      if (entry%i_first > 0) then
        call buffer%add(new_line('a'))
        call add_below(self, i, indent // '  ', buffer)
      else if (entry%is_block) then
        call buffer%add(new_line('a'))
        call add_indented(entry%yaml, indent // '  ', buffer)
      else
        call buffer%add(' ' // entry%yaml // new_line('a'))
      end if
    end associate
  end subroutine add_entry

  !> Each line that is not empty, shifted to the right.
  subroutine add_indented(lines, indent, buffer)
    character(*), intent(in) :: lines
    character(*), intent(in) :: indent
    type(text_buffer_t), intent(inout) :: buffer
    type(string_t), allocatable :: pieces(:)
    integer :: i_line

    pieces = split(lines, new_line('a'))
    do i_line = 1, size(pieces)
      if (len(pieces(i_line)%text) > 0) call buffer%add(indent // pieces(i_line)%text // new_line('a'))
    end do
  end subroutine add_indented
  !> Adds what an earlier report of the same deck says and this one does not: sections, and keys of sections.
  !>
  !> Reads what text() makes, two blanks per level. A report of another deck or another problem adds nothing.
  subroutine complete(self, earlier, left_out)
    class(run_report_t), intent(inout) :: self
    !> text of the earlier report
    character(*), intent(in) :: earlier
    !> sections (`errors`) and keys of sections (`times/query`) that are out of date
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

  !> The same deck with its defaults, and the same provenance.
  logical function is_same_study(self, earlier)
    class(run_report_t), intent(in) :: self
    character(*), intent(in) :: earlier
    type(text_buffer_t) :: buffer
    integer :: i, k
    character(*), parameter :: keys(2) = [character(10) :: 'deck', 'provenance']

    is_same_study = self%n_entries > 0
    do k = 1, size(keys)
      if (.not. is_same_study) return
      i = self%slots(slot_of(self, trim(keys(k)), 1))
      is_same_study = i > 0
      if (.not. is_same_study) return
      call buffer%clear()
      call add_entry(self, i, '', buffer)
      is_same_study = index(new_line('a') // earlier, new_line('a') // buffer%text()) > 0
    end do
  end function is_same_study

  !> One key of a section, or a value at the top, unless it is there or out of date. Empties the block.
  subroutine add_missing(self, section, key, value, block, left_out)
    class(run_report_t), intent(inout) :: self
    character(*), intent(in) :: section
    !> empty: the section itself
    character(*), intent(in) :: key
    !> on its line; empty where a block is below
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
    i_section = self%slots(slot_of(self, section, 1))
    if (i_section > 0) then
      ! a block, such as the deck, has no keys of its own
      if (self%entries(i_section)%i_first == 0 .or. len(key) == 0) return
      if (self%slots(slot_of(self, key, i_section)) > 0) return
    end if
    if (len(value) > 0) then
      call set(self, path, value, .false.)
    else
      call set(self, path, lines, .true.)
    end if
  end subroutine add_missing

  !> `key: value` or `key:`; quotes around a key go.
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

  !> Replaces the file as a whole. Errors: it cannot be written.
  subroutine write_report(self, path, error)
    class(run_report_t), intent(in) :: self
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call write_text_file(path, self%text(), error)
  end subroutine write_report
end module sig_run_report
