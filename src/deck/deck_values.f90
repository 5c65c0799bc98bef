! SPDX-License-Identifier: BSD-3-Clause
!> Reads values by their types: get_* below a key of the mapping i_parent, *_of from a node. Errors are added to the tree. A missing
!> key is an error if is_required. After an error, or without the key, the value is unchanged if the procedure says nothing else.
module sig_deck_values
  use sig_deck_config, only: name_config_t, temperature_name, value_config_t
  use sig_deck_tree, only: append_text, deck_tree_t, kind_list, kind_mapping, kind_scalar, parenthesis_balance, &
    root_node, shown
  use sig_expression, only: expression_t
  use sig_kinds, only: rk
  use sig_text, only: did_you_mean, join, read_real, string_t, to_text
  implicit none(type, external)
  private
  public :: get_entries, get_mapping, get_list, get_list_entries, is_mapping, get_text, get_word, get_choice
  public :: get_number, get_value, get_integer, get_name, get_names
  public :: choice_of, number_of, integer_of, name_of, value_of

contains

  !> Returns the node of the mapping below a key; 0 if it is missing (an error if required) or not a mapping (an error).
  integer function get_mapping(tree, i_parent, key, is_required) result(i_node)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    logical, intent(in) :: is_required

    i_node = get_node(tree, i_parent, key, is_required)
    if (i_node == 0) return
    if (.not. is_mapping(tree, i_node)) i_node = 0
  end function get_mapping

  !> Whether a node is a mapping; adds an error if it is not.
  logical function is_mapping(tree, i_node)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node

    is_mapping = tree%nodes(i_node)%kind == kind_mapping
    if (.not. is_mapping) call tree%report(i_node, 'is ' // tree%kind_name(i_node) // '; it must be a mapping {key: value, ...}')
  end function is_mapping

  !> Returns the node of the list below a key; 0 if it is missing (an error if required), or no list or wrongly empty (errors).
  integer function get_list(tree, i_parent, key, is_required, may_be_empty) result(i_node)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    logical, intent(in) :: is_required
    logical, intent(in) :: may_be_empty

    i_node = get_node(tree, i_parent, key, is_required)
    if (i_node == 0) return
    if (tree%nodes(i_node)%kind /= kind_list) then
      call tree%report(i_node, 'is ' // tree%kind_name(i_node) // '; it must be a list [...]')
    else if (tree%nodes(i_node)%last == i_node .and. .not. may_be_empty) then
      call tree%report(i_node, 'is an empty list; it needs at least one entry')
    else
      return
    end if
    i_node = 0
  end function get_list

  !> Returns the nodes of the entries of the list below a key; none if get_list returns 0. Errors: those of get_list.
  subroutine get_list_entries(tree, i_parent, key, is_required, may_be_empty, nodes)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    logical, intent(in) :: is_required
    logical, intent(in) :: may_be_empty
    integer, allocatable, intent(out) :: nodes(:)
    integer :: i_list

    allocate (nodes(0))
    i_list = get_list(tree, i_parent, key, is_required, may_be_empty)
    if (i_list > 0) nodes = tree%children(i_list)
  end subroutine get_list_entries

  !> Returns the nodes of the entries of a required section, a mapping whose keys are names of the user; none after an error.
  !> Errors: the section is missing, no mapping, or empty.
  subroutine get_entries(tree, key, nodes)
    type(deck_tree_t), intent(inout) :: tree
    character(*), intent(in) :: key
    integer, allocatable, intent(out) :: nodes(:)
    integer :: i_mapping

    allocate (nodes(0))
    ! the misspelt key is an error of its own; without its entries all their names would be errors, too
    i_mapping = tree%misspelt(root_node, key)
    if (i_mapping == 0) i_mapping = get_mapping(tree, root_node, key, .true.)
    if (i_mapping == 0) return
    nodes = tree%children(i_mapping)
    if (size(nodes) == 0) call tree%report(i_mapping, 'is an empty mapping; it needs at least one entry')
  end subroutine get_entries

  !> Reads the text below a key on one line, without blanks around it. Errors (value unchanged): unquoted and empty, mapping, list.
  subroutine get_text(tree, i_parent, key, is_required, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    logical, intent(in) :: is_required
    character(:), allocatable, intent(inout) :: value
    integer :: i_node

    i_node = get_node(tree, i_parent, key, is_required)
    if (i_node > 0) call text_of(tree, i_node, value)
  end subroutine get_text

  !> Reads the text below a key as get_text does, but an empty or blank text in quotes is an error, too; the value is then empty.
  subroutine get_word(tree, i_parent, key, is_required, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    logical, intent(in) :: is_required
    character(:), allocatable, intent(inout) :: value
    integer :: i_node

    i_node = get_node(tree, i_parent, key, is_required)
    if (i_node > 0) call word_of(tree, i_node, value)
  end subroutine get_word

  !> Reads a word below a key. It must be one of the choices (blanks at their ends do not count); otherwise an error, the value
  !> unchanged.
  subroutine get_choice(tree, i_parent, key, is_required, choices, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    logical, intent(in) :: is_required
    character(*), intent(in) :: choices(:)
    character(:), allocatable, intent(inout) :: value
    integer :: i_node

    i_node = get_node(tree, i_parent, key, is_required)
    if (i_node > 0) call choice_of(tree, i_node, choices, value)
  end subroutine get_choice

  !> Reads a number, or an expression without parameters, below a key. Errors (value unchanged): anything else, or not finite.
  subroutine get_number(tree, i_parent, key, is_required, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    logical, intent(in) :: is_required
    real(rk), intent(inout) :: value
    integer :: i_node

    i_node = get_node(tree, i_parent, key, is_required)
    if (i_node > 0) call number_of(tree, i_node, value)
  end subroutine get_number

  !> Reads a number or an expression of the parameters below a required key. After an error the value is the constant that it had.
  subroutine get_value(tree, i_parent, key, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    type(value_config_t), intent(inout) :: value
    type(value_config_t) :: found
    integer :: i_node
    logical :: is_valid

    value%text = to_text(value%constant)
    i_node = get_node(tree, i_parent, key, .true.)
    if (i_node == 0) return
    call value_of(tree, i_node, 'a number or an expression of the parameters', found, is_valid)
    if (is_valid) value = found
  end subroutine get_value

  !> Reads the whole number below a key, also as an expression (2^6). Errors (value unchanged): another value; beyond +-2147483647.
  subroutine get_integer(tree, i_parent, key, is_required, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    logical, intent(in) :: is_required
    integer, intent(inout) :: value
    integer :: i_node

    i_node = get_node(tree, i_parent, key, is_required)
    if (i_node > 0) call integer_of(tree, i_node, value)
  end subroutine get_integer

  !> Reads a name of the mesh, or of a field, below a required key, with its line and column. The name is empty after an error.
  subroutine get_name(tree, i_parent, key, name)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    type(name_config_t), intent(out) :: name
    integer :: i_node

    name%text = ''
    i_node = get_node(tree, i_parent, key, .true.)
    if (i_node > 0) call name_of(tree, i_node, name)
  end subroutine get_name

  !> Reads names of the mesh below a key; none without a list. Errors: missing or empty if is_required; no list; a name twice; an
  !> entry that is no text, or an empty one. The name of such an entry is empty.
  subroutine get_names(tree, i_parent, key, is_required, names)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    logical, intent(in) :: is_required
    type(name_config_t), allocatable, intent(out) :: names(:)
    integer, allocatable :: nodes(:)
    integer :: i, i_list, j

    allocate (names(0))
    i_list = get_list(tree, i_parent, key, is_required, may_be_empty=.not. is_required)
    if (i_list == 0) return
    nodes = tree%children(i_list)
    deallocate (names)
    allocate (names(size(nodes)))
    do i = 1, size(nodes)
      names(i)%text = ''
      call name_of(tree, nodes(i), names(i))
      do j = 1, i - 1
        if (len(names(i)%text) == 0 .or. names(j)%text /= names(i)%text) cycle
        call tree%report(nodes(i), 'is ' // shown(names(i)%text) // ', which is already in the list')
        exit
      end do
    end do
  end subroutine get_names

  !> Returns the node of the value below a key, 0 if the key is missing (an error if required).
  integer function get_node(tree, i_parent, key, is_required) result(i_node)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    logical, intent(in) :: is_required
    character(:), allocatable :: path

    i_node = tree%find(i_parent, key)
    if (i_node > 0 .or. .not. is_required) return
    path = key
    if (tree%nodes(i_parent)%parent > 0) path = tree%key_path(i_parent) // '.' // key
    call tree%report_key(i_parent, path // ' is missing')
  end function get_node

  subroutine text_of(tree, i_node, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    character(:), allocatable, intent(inout) :: value

    if (tree%nodes(i_node)%kind /= kind_scalar .or. tree%is_empty(i_node)) then
      call tree%report(i_node, 'is ' // tree%kind_name(i_node) // '; it must be a text')
    else
      value = on_one_line(tree%nodes(i_node)%text)
    end if
  end subroutine text_of

  subroutine word_of(tree, i_node, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    character(:), allocatable, intent(inout) :: value

    call text_of(tree, i_node, value)
    if (.not. tree%nodes(i_node)%is_quoted) return
    if (len_trim(tree%nodes(i_node)%text) == 0) call tree%report(i_node, 'is an empty text; a value is needed')
  end subroutine word_of

  !> Reads a word that must be one of the choices (blanks at their ends do not count). Otherwise adds an error.
  subroutine choice_of(tree, i_node, choices, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    character(*), intent(in) :: choices(:)
    character(:), allocatable, intent(inout) :: value
    type(string_t), allocatable :: names(:)
    character(:), allocatable :: allowed, guess
    integer :: i

    allocate (names(size(choices)))
    do i = 1, size(choices)
      names(i)%text = trim(choices(i))
      if (tree%nodes(i_node)%kind /= kind_scalar) cycle
      if (tree%nodes(i_node)%text /= names(i)%text) cycle
      value = names(i)%text
      return
    end do
    allowed = '; it must be '
    if (size(names) > 1) allowed = '; it must be one of '
    guess = ''
    if (tree%nodes(i_node)%kind == kind_scalar) then
      if (len(tree%nodes(i_node)%text) <= 60) guess = did_you_mean(tree%nodes(i_node)%text, names)
    end if
    if (len(guess) > 0) guess = 'did you mean ''' // guess // '''?'
    call tree%report(i_node, 'is ' // tree%kind_name(i_node) // allowed // join(names, ', '), guess)
  end subroutine choice_of

  !> Reads a number or an expression without parameters. Otherwise, or if it is not finite, adds an error; the value is unchanged.
  subroutine number_of(tree, i_node, value, is_valid)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    real(rk), intent(inout) :: value
    logical, intent(out), optional :: is_valid
    type(value_config_t) :: number
    logical :: has_value

    call value_of(tree, i_node, 'a number', number, has_value)
    if (has_value .and. .not. number%is_constant) then
      call tree%report(i_node, 'is ' // tree%kind_name(i_node) // '; it must be a number, and parameters are not allowed here')
      has_value = .false.
    end if
    if (has_value) value = number%constant
    if (present(is_valid)) is_valid = has_value
  end subroutine number_of

  !> Reads a whole number as get_integer does. After an error the value is unchanged.
  subroutine integer_of(tree, i_node, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    integer, intent(inout) :: value
    real(rk) :: number
    logical :: is_valid

    number = 0
    call number_of(tree, i_node, number, is_valid)
    if (.not. is_valid) return
    if (abs(number) > real(huge(value), rk)) then
      call tree%report(i_node, 'is ' // tree%nodes(i_node)%text // '; it must be a whole number from -2147483647 to 2147483647')
    else if (abs(number - anint(number)) > 0) then
      call tree%report(i_node, 'is ' // tree%nodes(i_node)%text // '; it must be a whole number')
    else
      value = nint(number)
    end if
  end subroutine integer_of

  !> Reads a name as get_word does, and sets its line and column, also after an error.
  subroutine name_of(tree, i_node, name)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    type(name_config_t), intent(inout) :: name

    call word_of(tree, i_node, name%text)
    name%line = tree%nodes(i_node)%line
    name%column = tree%nodes(i_node)%column
  end subroutine name_of

  !> Reads a number or an expression, in quotes or not. Errors: no valid expression of the allowed names; a constant that is not
  !> finite. is_valid: whether there was no error.
  subroutine value_of(tree, i_node, wanted, value, is_valid, may_use_coordinates, may_use_temperature)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    !> what the message asks for: `a number`, or `a number or an expression of the parameters`
    character(*), intent(in) :: wanted
    !> unless is_valid, only its line and column may be used
    type(value_config_t), intent(inout) :: value
    logical, intent(out) :: is_valid
    !> whether coordinates are allowed; default no
    logical, intent(in), optional :: may_use_coordinates
    !> whether the temperature of the region is allowed, but no coordinates; default no. Requires: no parameter has its name
    logical, intent(in), optional :: may_use_temperature
    type(string_t), allocatable :: more_names(:)

    allocate (more_names(0))
    if (present(may_use_coordinates)) then
      if (may_use_coordinates) more_names = tree%coordinate_names
    end if
    if (present(may_use_temperature)) then
      if (may_use_temperature) call append_text(more_names, temperature_name)
    end if
    is_valid = .false.
    value%line = tree%nodes(i_node)%line
    value%column = tree%nodes(i_node)%column
    if (tree%nodes(i_node)%kind /= kind_scalar .or. tree%is_empty(i_node)) then
      call tree%report(i_node, 'is ' // tree%kind_name(i_node) // '; it must be ' // wanted)
      return
    end if
    call read_real(tree%nodes(i_node)%text, value%constant, is_valid)
    value%is_constant = .true.
    if (.not. is_valid) call read_expression(tree, i_node, wanted, more_names, value, is_valid)
    if (is_valid .and. value%is_constant) value%text = to_text(value%constant)
  end subroutine value_of

  subroutine read_expression(tree, i_node, wanted, more_names, value, is_valid)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    character(*), intent(in) :: wanted
    !> coordinates, or the temperature of the region
    type(string_t), intent(in) :: more_names(:)
    type(value_config_t), intent(inout) :: value
    logical, intent(out) :: is_valid
    type(expression_t) :: expression
    character(:), allocatable :: message

    value%uses_temperature = .false.
    value%text = on_one_line(tree%nodes(i_node)%text)
    call expression%create(value%text, [tree%parameter_names, more_names], message)
    is_valid = .not. allocated(message)
    if (.not. is_valid) then
      call tree%report(i_node, 'is ' // tree%kind_name(i_node) // '; it must be ' // wanted // ': ' // message, &
        hint_of(tree, i_node))
      return
    end if
    associate (places => expression%used_places(), n_parameters => size(tree%parameter_names))
      value%uses_parameters = any(places <= n_parameters)
      if (size(more_names) > 0) value%uses_temperature = any(places > n_parameters) .and. more_names(1)%text == temperature_name
      value%uses_coordinates = any(places > n_parameters) .and. .not. value%uses_temperature
      value%uses_history = any(places > tree%n_parameters .and. places <= n_parameters)
      tree%is_parameter_used(pack(places, places <= n_parameters)) = .true.
    end associate
    value%is_constant = .not. (value%uses_parameters .or. value%uses_coordinates .or. value%uses_temperature)
    if (value%is_constant) then
      call expression%evaluate(spread(0.0_rk, 1, size(tree%parameter_names) + size(more_names)), value%constant, is_valid)
      if (.not. is_valid) call tree%report(i_node, 'is ' // tree%kind_name(i_node) // ', which is not finite')
    end if
    call expression%destroy()
  end subroutine read_expression

  !> Returns a hint if a comma inside { } or [ ] has cut an expression in two; otherwise an empty text.
  pure function hint_of(tree, i_node) result(hint)
    type(deck_tree_t), intent(in) :: tree
    integer, intent(in) :: i_node
    character(:), allocatable :: hint

    hint = ''
    if (tree%nodes(i_node)%is_quoted .or. i_node == size(tree%nodes)) return
    if (tree%nodes(i_node + 1)%parent /= tree%nodes(i_node)%parent) return
    if (parenthesis_balance(tree%nodes(i_node)%text) > 0 .and. &
      parenthesis_balance(tree%nodes(i_node + 1)%key // tree%nodes(i_node + 1)%text) < 0) &
      hint = 'an expression with a comma needs quotes inside { } and [ ], such as "max(a, 0.1)"'
  end function hint_of

  pure function on_one_line(text) result(line)
    character(*), intent(in) :: text
    character(:), allocatable :: line
    integer :: i

    line = text
    do i = 1, len(line)
      if (ichar(line(i:i)) < 32) line(i:i) = ' '
    end do
    line = trim(adjustl(line))
  end function on_one_line
end module sig_deck_values
