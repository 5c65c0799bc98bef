! SPDX-License-Identifier: BSD-3-Clause
!> Makes a tree of the deck's text with the YAML reader in C.
module sig_deck_parse
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_ptr, c_size_t
  use sig_c_strings, only: from_c
  use sig_deck_tree, only: deck_node_t, deck_tree_t, kind_mapping, root_node
  use sig_errors, only: error_t, make_error
  use sig_text, only: split, string_t
  implicit none(type, external)
  private
  public :: parse_deck

  !> SIG_YAML_SYNTAX in include/signorom/yaml_reader.h
  integer, parameter :: fault_syntax = 1

  !> The structure sig_yaml_node of yaml_reader.h.
  type, bind(c) :: yaml_node_c_t
    integer(c_int) :: kind
    integer(c_int) :: parent
    integer(c_int) :: line
    integer(c_int) :: column
    integer(c_int) :: key_line
    integer(c_int) :: key_column
    integer(c_int) :: is_quoted
    type(c_ptr) :: key
    integer(c_size_t) :: key_length
    type(c_ptr) :: text
    integer(c_size_t) :: text_length
  end type yaml_node_c_t

  !> The structure sig_yaml_fault of yaml_reader.h.
  type, bind(c) :: yaml_fault_c_t
    integer(c_int) :: kind
    integer(c_int) :: line
    integer(c_int) :: column
    type(c_ptr) :: message
  end type yaml_fault_c_t

  interface
    integer(c_int) function sig_yaml_read(text, length, reading) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      implicit none(type, external)
      character(kind=c_char), intent(in) :: text(*)
      integer(c_size_t), value, intent(in) :: length
      type(c_ptr), intent(out) :: reading
    end function sig_yaml_read

    integer(c_int) function sig_yaml_n_nodes(reading) bind(c)
      import :: c_int, c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: reading
    end function sig_yaml_n_nodes

    integer(c_int) function sig_yaml_n_faults(reading) bind(c)
      import :: c_int, c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: reading
    end function sig_yaml_n_faults

    subroutine sig_yaml_get_node(reading, i, node) bind(c)
      import :: c_int, c_ptr, yaml_node_c_t
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: reading
      integer(c_int), value, intent(in) :: i
      type(yaml_node_c_t), intent(out) :: node
    end subroutine sig_yaml_get_node

    subroutine sig_yaml_get_fault(reading, i, fault) bind(c)
      import :: c_int, c_ptr, yaml_fault_c_t
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: reading
      integer(c_int), value, intent(in) :: i
      type(yaml_fault_c_t), intent(out) :: fault
    end subroutine sig_yaml_get_fault

    subroutine sig_yaml_free(reading) bind(c)
      import :: c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: reading
    end subroutine sig_yaml_free
  end interface

contains

  !> Makes the tree of a deck. If tree%errors is not empty afterwards, the nodes must not be used. Errors, at most 20: bytes that
  !> are not UTF-8 text, not valid YAML, duplicate keys, YAML that a deck may not use (such as anchors, tags, tabs as indentation,
  !> several documents), too many or too deeply nested entries, an empty deck, a deck that is not a mapping, not enough memory.
  subroutine parse_deck(path, text, tree)
    !> file name for messages
    character(*), intent(in) :: path
    !> content of the deck
    character(*), intent(in) :: text
    type(deck_tree_t), intent(out) :: tree
    type(c_ptr) :: reading

    tree%path = path
    allocate (tree%parameter_names(0), tree%is_parameter_used(0), tree%nodes(0))
    if (sig_yaml_read(text, len(text, c_size_t), reading) /= 0) then
      call report(tree, 'out of memory')
      return
    end if
    call take_faults(reading, text, tree)
    if (tree%errors%n_errors() == 0) call take_nodes(reading, tree)
    call sig_yaml_free(reading)
    if (tree%errors%n_errors() > 0) return
    if (size(tree%nodes) == 0) then
      call report(tree, 'the deck is empty')
    else if (tree%nodes(root_node)%kind /= kind_mapping) then
      call tree%report(root_node, 'is ' // tree%kind_name(root_node) // '; it must be a mapping {key: value, ...}', &
        'input/half_disks.yaml shows a whole deck')
    end if
  end subroutine parse_deck

  subroutine take_faults(reading, text, tree)
    type(c_ptr), intent(in) :: reading
    character(*), intent(in) :: text
    type(deck_tree_t), intent(inout) :: tree
    type(yaml_fault_c_t) :: fault
    integer(c_int) :: i_fault
    character(:), allocatable :: message, hint

    do i_fault = 0, sig_yaml_n_faults(reading) - 1
      call sig_yaml_get_fault(reading, i_fault, fault)
      message = from_c(fault%message)
      hint = ''
      if (fault%kind == fault_syntax) then
        message = 'this is not valid YAML: ' // message
        hint = hint_for_slip(message, text, int(fault%line))
      end if
      call report(tree, message, int(fault%line), int(fault%column), hint)
    end do
  end subroutine take_faults

  subroutine report(tree, sentence, line, column, hint)
    type(deck_tree_t), intent(inout) :: tree
    character(*), intent(in) :: sentence
    integer, intent(in), optional :: line
    integer, intent(in), optional :: column
    character(*), intent(in), optional :: hint
    type(error_t), allocatable :: error

    call make_error(error, sentence, tree%path, line, column, hint)
    call tree%errors%add(error)
  end subroutine report

  !> Returns a hint for four mistakes that make a deck invalid YAML: an expression with ? : or a text with a colon and a blank
  !> without quotes, a faulty list or mapping in brackets, and lines in brackets that are not indented enough. The hint is empty for
  !> others, and if there is no such line.
  pure function hint_for_slip(message, text, line) result(hint)
    !> libfyaml's message
    character(*), intent(in) :: message
    !> content of the deck, and the line of the error, 1-based
    character(*), intent(in) :: text
    integer, intent(in) :: line
    character(:), allocatable :: hint
    type(string_t), allocatable :: lines(:)

    hint = ''
    lines = split(text, new_line('a'))
    if (line < 1 .or. line > size(lines)) return
    if (index(lines(line)%text, ' ?') > 0) then
      hint = 'an expression with ? : needs quotes, such as "a > 0.2 ? 1 : 0"'
    else if (index(message, 'nested block mapping') > 0) then
      hint = 'a text with a colon and a blank in it needs quotes; a mapping on the line of its key needs braces: ' // &
        '{min: 0, max: 1}'
    else if (index(message, 'wrongly indented') > 0 .and. index(message, 'flow') > 0) then
      hint = 'close the bracket [ or { that is open here, or indent all lines of it, also the one that closes it, ' // &
        'further than the line that opens it'
    else if (index(message, 'flow') > 0 .and. index(message, 'invalid extra') == 0) then
      hint = 'look for a bracket [ or { that is not closed, or a comma that is missing'
    end if
  end function hint_for_slip

  subroutine take_nodes(reading, tree)
    type(c_ptr), intent(in) :: reading
    type(deck_tree_t), intent(inout) :: tree
    type(yaml_node_c_t) :: node
    integer :: i_node, i_parent

    deallocate (tree%nodes)
    allocate (tree%nodes(sig_yaml_n_nodes(reading)))
    do i_node = 1, size(tree%nodes)
      call sig_yaml_get_node(reading, int(i_node - 1, c_int), node)
      call copy_node(node, tree%nodes(i_node))
      tree%nodes(i_node)%last = i_node
    end do
    ! from the last node to the first: the nodes below a node must be known before it
    do i_node = size(tree%nodes), 2, -1
      i_parent = tree%nodes(i_node)%parent
      tree%nodes(i_parent)%last = max(tree%nodes(i_parent)%last, tree%nodes(i_node)%last)
    end do
  end subroutine take_nodes

  subroutine copy_node(node, copy)
    type(yaml_node_c_t), intent(in) :: node
    type(deck_node_t), intent(out) :: copy

    copy%kind = node%kind
    copy%parent = node%parent + 1
    copy%line = node%line
    copy%column = node%column
    copy%key_line = node%key_line
    copy%key_column = node%key_column
    copy%is_quoted = node%is_quoted /= 0
    copy%key = from_c(node%key, node%key_length)
    copy%text = from_c(node%text, node%text_length)
    allocate (copy%asked_keys(0))
  end subroutine copy_node
end module sig_deck_parse
