! SPDX-License-Identifier: BSD-3-Clause
!> The deck as a tree of nodes, with the place of every value in the text. The tree also keeps which keys were read, and the errors.
module sig_deck_tree
  use sig_errors, only: error_list_t, error_t, make_error
  use sig_text, only: did_you_mean, join, string_t, to_text
  implicit none(type, external)
  private
  public :: deck_tree_t, deck_node_t, kind_scalar, kind_mapping, kind_list, root_node
  public :: append_text, shown, parenthesis_balance

  !> Kinds of nodes, as in include/signorom/yaml_reader.h.
  integer, parameter :: kind_scalar = 1
  integer, parameter :: kind_mapping = 2
  integer, parameter :: kind_list = 3

  integer, parameter :: root_node = 1
  !> number of bytes after which a text of the user is cut in messages
  integer, parameter :: max_shown = 60

  !> One value of the deck: a scalar, a mapping or a list, with its key.
  type :: deck_node_t
    !> kind_scalar, kind_mapping or kind_list
    integer :: kind = 0
    !> node above this one; 0 for the root
    integer :: parent = 0
    !> last node below this one; the node itself if there is none
    integer :: last = 0
    !> line and column of the value, 1-based
    integer :: line = 0
    integer :: column = 0
    !> line and column of the key; for an entry of a list those of the value
    integer :: key_line = 0
    integer :: key_column = 0
    !> whether the text stands in quotes, or is a block after | or >
    logical :: is_quoted = .false.
    !> whether `find` has returned this node, or refuse_key has reported it
    logical :: was_read = .false.
    !> key in the mapping above; empty in a list
    character(:), allocatable :: key
    !> text of a scalar
    character(:), allocatable :: text
    !> for a mapping: the keys for which `find` was called, which are the valid ones
    type(string_t), allocatable :: asked_keys(:)
  end type deck_node_t

  !> The nodes are in the order of the text; node 1 is the root. Errors are collected here while the deck is read.
  type :: deck_tree_t
    !> file name for the messages
    character(:), allocatable :: path
    type(deck_node_t), allocatable :: nodes(:)
    !> names of parameters that expressions may use, then with a history those of the time and its tables; none before they are read
    type(string_t), allocatable :: parameter_names(:)
    !> number of these names that belong to parameters
    integer :: n_parameters = 0
    !> whether an expression that was read has the name, shape (size(parameter_names))
    logical, allocatable :: is_parameter_used(:)
    !> names of the model's coordinates, which some expressions may use, too
    type(string_t), allocatable :: coordinate_names(:)
    type(error_list_t) :: errors
  contains
    procedure :: find
    procedure :: misspelt
    procedure :: children
    procedure :: is_empty
    procedure :: key_path
    procedure :: node_at
    procedure :: kind_name
    procedure :: report
    procedure :: report_key
    procedure :: report_at
    procedure :: refuse_key
    procedure :: close_mapping
  end type deck_tree_t

contains

  !> Returns the node of a key's value, 0 if the mapping has no such key. From then on the key counts as valid and as read.
  integer function find(this, i_mapping, key) result(i_node)
    class(deck_tree_t), intent(inout) :: this
    !> node of the mapping
    integer, intent(in) :: i_mapping
    character(*), intent(in) :: key
    integer :: i

    i_node = 0
    if (.not. was_asked(this%nodes(i_mapping), key)) call append_text(this%nodes(i_mapping)%asked_keys, key)
    do i = i_mapping + 1, this%nodes(i_mapping)%last
      if (this%nodes(i)%parent /= i_mapping .or. this%nodes(i)%key /= key) cycle
      ! Fortran ignores trailing blanks in comparisons
      if (len(this%nodes(i)%key) /= len(key)) cycle
      i_node = i
      this%nodes(i)%was_read = .true.
      return
    end do
  end function find

  !> Returns the mapping below an unknown key that looks like this one, in the place of a missing key; otherwise 0. Then
  !> close_mapping reports the key, with the hint `did you mean`.
  integer function misspelt(this, i_mapping, key) result(i_node)
    class(deck_tree_t), intent(inout) :: this
    !> node of the mapping
    integer, intent(in) :: i_mapping
    !> a key that is valid in the mapping
    character(*), intent(in) :: key
    type(string_t) :: wanted(1)
    integer, allocatable :: nodes(:)
    integer :: i

    i_node = 0
    if (this%find(i_mapping, key) > 0) return
    wanted(1)%text = key
    nodes = this%children(i_mapping)
    do i = 1, size(nodes)
      if (this%nodes(nodes(i))%was_read .or. this%nodes(nodes(i))%kind /= kind_mapping) cycle
      if (did_you_mean(this%nodes(nodes(i))%key, wanted) == '') cycle
      i_node = nodes(i)
      return
    end do
  end function misspelt

  pure logical function was_asked(node, key)
    type(deck_node_t), intent(in) :: node
    character(*), intent(in) :: key
    integer :: i

    was_asked = .false.
    if (.not. allocated(node%asked_keys)) return
    do i = 1, size(node%asked_keys)
      if (node%asked_keys(i)%text == key) was_asked = .true.
    end do
  end function was_asked

  !> Returns the nodes of a mapping's values or of a list's entries, in their order in the text.
  pure function children(this, i_parent) result(nodes)
    class(deck_tree_t), intent(in) :: this
    integer, intent(in) :: i_parent
    integer, allocatable :: nodes(:)
    integer :: i

    nodes = pack([(i, i=i_parent + 1, this%nodes(i_parent)%last)], &
      this%nodes(i_parent + 1:this%nodes(i_parent)%last)%parent == i_parent)
  end function children

  !> Whether a scalar is empty or YAML's null, and not in quotes. A mapping or a list is never empty in this sense.
  pure logical function is_empty(this, i_node)
    class(deck_tree_t), intent(in) :: this
    integer, intent(in) :: i_node

    is_empty = .false.
    if (this%nodes(i_node)%kind /= kind_scalar .or. this%nodes(i_node)%is_quoted) return
    select case (this%nodes(i_node)%text)
    case ('', '~', 'null', 'Null', 'NULL')
      is_empty = .true.
    case default
      is_empty = .false.
    end select
  end function is_empty

  !> Returns the key path of a node, such as `materials.disk.poisson_ratio` or `contact[1].direction[2]` (entries of lists count
  !> from 1); for the root `the deck`. A key of more than 60 bytes is cut as in `shown`.
  pure recursive function key_path(this, i_node) result(path)
    class(deck_tree_t), intent(in) :: this
    integer, intent(in) :: i_node
    character(:), allocatable :: path
    integer :: i_parent

    path = 'the deck'
    i_parent = this%nodes(i_node)%parent
    if (i_parent == 0) return
    path = ''
    if (i_parent /= root_node) path = this%key_path(i_parent)
    if (this%nodes(i_parent)%kind == kind_list) then
      path = path // '[' // to_text(count(this%nodes(i_parent + 1:i_node)%parent == i_parent)) // ']'
    else
      if (len(path) > 0) path = path // '.'
      path = path // cut(this%nodes(i_node)%key)
    end if
  end function key_path

  !> Returns the node with this key path. If the deck does not have it, returns the nearest node above it, at last the root.
  pure integer function node_at(this, path) result(i_node)
    class(deck_tree_t), intent(in) :: this
    character(*), intent(in) :: path
    integer :: i_end

    i_end = len(path)
    do while (i_end > 0)
      do i_node = 1, size(this%nodes)
        if (this%key_path(i_node) == path(:i_end)) return
      end do
      i_end = scan(path(:i_end), '.[', back=.true.) - 1
    end do
    i_node = root_node
  end function node_at

  !> Returns what a value is, for messages such as `solver is a list; it must be ...`: `a mapping`, `a list`, `empty`, or the text
  !> of a scalar in quotes.
  pure function kind_name(this, i_node) result(name)
    class(deck_tree_t), intent(in) :: this
    integer, intent(in) :: i_node
    character(:), allocatable :: name

    select case (this%nodes(i_node)%kind)
    case (kind_mapping)
      name = 'a mapping'
    case (kind_list)
      name = 'a list'
    case default
      name = shown(this%nodes(i_node)%text)
      if (this%is_empty(i_node)) name = 'empty'
    end select
  end function kind_name

  !> Adds the error `<key path> <message>` at the place of the value.
  subroutine report(this, i_node, message, hint)
    class(deck_tree_t), intent(inout) :: this
    integer, intent(in) :: i_node
    character(*), intent(in) :: message
    character(*), intent(in), optional :: hint

    call add(this, this%key_path(i_node) // ' ' // message, this%nodes(i_node)%line, this%nodes(i_node)%column, hint)
  end subroutine report

  !> Adds an error at the place of a node's key, or without a place for the root. The sentence is the whole message.
  subroutine report_key(this, i_node, sentence, hint)
    class(deck_tree_t), intent(inout) :: this
    integer, intent(in) :: i_node
    character(*), intent(in) :: sentence
    character(*), intent(in), optional :: hint

    if (i_node == root_node) then
      call add(this, sentence, 0, 0, hint)
    else
      call add(this, sentence, this%nodes(i_node)%key_line, this%nodes(i_node)%key_column, hint)
    end if
  end subroutine report_key

  !> Adds the error `<key path> <message>` at the value with this key path. If the deck does not have it, because its default is
  !> meant, the error is at the nearest node above it.
  subroutine report_at(this, path, message, hint)
    class(deck_tree_t), intent(inout) :: this
    character(*), intent(in) :: path
    character(*), intent(in) :: message
    character(*), intent(in), optional :: hint
    integer :: i_node

    i_node = this%node_at(path)
    call add(this, path // ' ' // message, this%nodes(i_node)%line, this%nodes(i_node)%column, hint)
  end subroutine report_at

  subroutine add(this, sentence, line, column, hint)
    class(deck_tree_t), intent(inout) :: this
    character(*), intent(in) :: sentence
    integer, intent(in) :: line
    integer, intent(in) :: column
    character(*), intent(in), optional :: hint
    type(error_t), allocatable :: error

    call make_error(error, sentence, this%path, line, column, hint)
    call this%errors%add(error)
  end subroutine add

  !> Adds the error `<key path> is not available: <reason>` if a mapping has this key. close_mapping then does not report the key
  !> as unknown. It is for keys that users may expect, because other programs or earlier versions have them.
  subroutine refuse_key(this, i_mapping, key, reason)
    class(deck_tree_t), intent(inout) :: this
    integer, intent(in) :: i_mapping
    character(*), intent(in) :: key
    !> reason, as the second half of a sentence
    character(*), intent(in) :: reason
    integer, allocatable :: nodes(:)
    integer :: i

    nodes = this%children(i_mapping)
    do i = 1, size(nodes)
      if (this%nodes(nodes(i))%key /= key) cycle
      this%nodes(nodes(i))%was_read = .true.
      call this%report_key(nodes(i), this%key_path(nodes(i)) // ' is not available: ' // reason, 'leave the key out')
    end do
  end subroutine refuse_key

  !> Adds an error for each key of a mapping that was not read, with the valid keys. The rest of an expression that a comma has cut
  !> in two is no key and gets no error. Requires: `find` was called for all valid keys.
  subroutine close_mapping(this, i_mapping)
    class(deck_tree_t), intent(inout) :: this
    integer, intent(in) :: i_mapping
    integer, allocatable :: nodes(:)
    integer :: i

    nodes = this%children(i_mapping)
    do i = 1, size(nodes)
      if (this%nodes(nodes(i))%was_read) cycle
      if (i > 1) then
        if (is_split_expression(this, nodes(i - 1), nodes(i))) cycle
      end if
      call this%report_key(nodes(i), 'unknown key ' // shown(this%nodes(nodes(i))%key) // ' in ' // this%key_path(i_mapping) // &
        '; allowed: ' // join(this%nodes(i_mapping)%asked_keys, ', '), hint_for_key(this, i_mapping, nodes(i)))
    end do
  end subroutine close_mapping

  !> Whether the key is the rest of an expression: YAML reads `{x: max(a, b)}` as the pair `x: max(a` and a key `b)`. The pair is
  !> reported with a hint, so the key needs no message.
  pure logical function is_split_expression(this, i_before, i_node)
    type(deck_tree_t), intent(in) :: this
    !> node before it in the mapping, and the key's node
    integer, intent(in) :: i_before
    integer, intent(in) :: i_node

    is_split_expression = .false.
    if (this%nodes(i_before)%kind /= kind_scalar .or. .not. this%is_empty(i_node)) return
    is_split_expression = parenthesis_balance(this%nodes(i_before)%text) > 0 .and. parenthesis_balance(this%nodes(i_node)%key) < 0
  end function is_split_expression

  pure function hint_for_key(this, i_mapping, i_node) result(hint)
    type(deck_tree_t), intent(in) :: this
    integer, intent(in) :: i_mapping
    integer, intent(in) :: i_node
    character(:), allocatable :: hint
    character(:), allocatable :: guess

    guess = ''
    if (len(this%nodes(i_node)%key) <= max_shown) guess = did_you_mean(this%nodes(i_node)%key, this%nodes(i_mapping)%asked_keys)
    hint = ''
    if (len(guess) > 0) then
      hint = 'did you mean ''' // guess // '''?'
    else if (this%is_empty(i_node)) then
      hint = 'a key without a value may be the rest of an entry: inside { } a comma separates entries; numbers take a decimal ' // &
        'point, and an expression with a comma needs quotes'
    end if
  end function hint_for_key

  !> Appends a text to a list, which must be allocated. Use it because gfortran 12 loses the text in `[list, string_t(text)]`.
  pure subroutine append_text(list, text)
    type(string_t), allocatable, intent(inout) :: list(:)
    character(*), intent(in) :: text
    type(string_t), allocatable :: longer(:)

    allocate (longer(size(list) + 1))
    longer(:size(list)) = list
    longer(size(longer))%text = text
    call move_alloc(longer, list)
  end subroutine append_text

  !> Returns a user's text for messages: in single quotes and on one line. If it is longer than 60 bytes (max_shown), it is
  !> cut there, or before the character that does not fit, and `...` follows.
  pure function shown(text) result(quoted)
    character(*), intent(in) :: text
    character(:), allocatable :: quoted

    quoted = '''' // cut(text) // ''''
  end function shown

  pure function cut(text) result(short)
    character(*), intent(in) :: text
    character(:), allocatable :: short
    integer :: i

    short = text
    if (len(text) > max_shown) then
      i = max_shown
      ! do not cut inside a UTF-8 character
      do while (iand(ichar(text(i + 1:i + 1)), 192) == 128)
        i = i - 1
      end do
      short = text(:i) // '...'
    end if
    do i = 1, len(short)
      if (ichar(short(i:i)) < 32) short(i:i) = ' '
    end do
  end function cut

  !> Returns the number of opening minus closing parentheses.
  pure integer function parenthesis_balance(text) result(balance)
    character(*), intent(in) :: text
    integer :: i

    balance = 0
    do i = 1, len(text)
      if (text(i:i) == '(') balance = balance + 1
      if (text(i:i) == ')') balance = balance - 1
    end do
  end function parenthesis_balance
end module sig_deck_tree
