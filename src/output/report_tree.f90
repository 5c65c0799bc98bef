! SPDX-License-Identifier: BSD-3-Clause
!> A tree of keys with values in YAML. The keys keep the order in which they were set first.
module sig_report_tree
  use sig_checksum, only: fnv1a
  use sig_kinds, only: lk
  use sig_report_yaml, only: yaml_of_text
  use sig_text, only: split, string_t
  use sig_text_buffer, only: text_buffer_t
  implicit none(type, external)
  private
  public :: report_tree_t

  !> One key; a key with others below it has no value of its own. Entry 1 is the top, which has no key.
  type :: entry_t
    character(:), allocatable :: key
    integer :: i_parent = 0
    !> the first and the last key below it, the next key of the same parent; 0 where there is none
    integer :: i_first = 0
    integer :: i_last = 0
    integer :: i_next = 0
    !> value in YAML: one line or, if is_block, several lines
    character(:), allocatable :: yaml
    logical :: is_block = .false.
  end type entry_t

  !> On average, the time to set or find a key does not depend on the number of keys.
  type :: report_tree_t
    private
    type(entry_t), allocatable :: entries(:)
    integer :: n_entries = 0
    !> hash table: the position comes from the hash of key and parent, the value is the number of the entry, 0 = free; its size is a
    !> power of two
    integer, allocatable :: slots(:)
  contains
    procedure :: set
    procedure :: find
    procedure :: has_keys
    procedure :: text => tree_text
  end type report_tree_t

contains

  !> Sets the value of a key, or replaces it. Keys above it are made if they are missing. The value of a key that has keys below it
  !> is not written.
  subroutine set(self, key, yaml, is_block)
    class(report_tree_t), intent(inout) :: self
    !> path of keys: `errors/e_u/median`
    character(*), intent(in) :: key
    !> value in YAML: one line or, if is_block, lines that start at column 1
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

  !> Starts an empty tree.
  pure subroutine start(self)
    class(report_tree_t), intent(inout) :: self
    integer, parameter :: n_first = 64

    allocate (self%entries(n_first))
    allocate (self%slots(4 * n_first), source=0)
    self%n_entries = 1
    self%entries(1)%key = ''
  end subroutine start

  !> Returns the position in `slots` of a key directly below a parent, or the free position for it if the parent does not have it.
  !> i_parent is the number of an entry.
  pure integer function slot_of(self, key, i_parent) result(i_slot)
    class(report_tree_t), intent(in) :: self
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

  !> Appends a new key, without a value, behind the other keys of a parent. May change the positions of all keys in `slots`.
  pure subroutine append(self, key, i_parent, i_slot)
    class(report_tree_t), intent(inout) :: self
    character(*), intent(in) :: key
    !> number of the entry of the parent
    integer, intent(in) :: i_parent
    !> a free slot, from slot_of
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

  !> Makes the array of entries twice as long. Texts are moved and not copied, because copies would take long.
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

  !> Makes the table of slots four times as large, and finds the new positions of all keys.
  pure subroutine spread_out(self)
    class(report_tree_t), intent(inout) :: self
    integer, allocatable :: slots(:)
    integer :: i

    allocate (slots(4 * size(self%slots)), source=0)
    call move_alloc(slots, self%slots)
    do i = 2, self%n_entries
      self%slots(slot_of(self, self%entries(i)%key, self%entries(i)%i_parent)) = i
    end do
  end subroutine spread_out

  !> Returns the number of the entry of a key at the top or directly below a given entry, 0 if there is none.
  pure integer function find(self, key, i_parent) result(i)
    class(report_tree_t), intent(in) :: self
    !> one key, not a path
    character(*), intent(in) :: key
    !> number of the entry above it; default: the top
    integer, intent(in), optional :: i_parent

    i = 0
    if (self%n_entries == 0) return
    if (present(i_parent)) then
      i = self%slots(slot_of(self, key, i_parent))
    else
      i = self%slots(slot_of(self, key, 1))
    end if
  end function find

  !> Whether there are keys below entry i.
  pure logical function has_keys(self, i)
    class(report_tree_t), intent(in) :: self
    !> number of an entry, from `find`
    integer, intent(in) :: i

    has_keys = self%entries(i)%i_first > 0
  end function has_keys

  !> Returns an entry, that is, its key with the value or everything below it, as YAML, or the whole tree. Every line, the last one
  !> too, ends with a line break; an empty tree gives an empty text.
  function tree_text(self, i_entry) result(text)
    class(report_tree_t), intent(in) :: self
    !> number of the entry; default: the whole tree
    integer, intent(in), optional :: i_entry
    character(:), allocatable :: text
    type(text_buffer_t) :: buffer

    if (present(i_entry)) then
      call add_entry(self, i_entry, '', buffer)
    else if (self%n_entries > 0) then
      call add_below(self, 1, '', buffer)
    end if
    text = buffer%text()
  end function tree_text

  recursive subroutine add_below(self, i_parent, indent, buffer)
    class(report_tree_t), intent(in) :: self
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

  !> Adds a key with everything below it to the buffer; if there is nothing below it, with its value or block.
  recursive subroutine add_entry(self, i, indent, buffer)
    class(report_tree_t), intent(in) :: self
    !> number of the entry
    integer, intent(in) :: i
    !> blanks before the key
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

  !> Adds the lines with an indent; leaves out empty lines.
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
end module sig_report_tree
