! SPDX-License-Identifier: BSD-3-Clause
!> Reads the text of a deck into a configuration and finds its errors.
module sig_deck_read
  use sig_deck_checks, only: check_deck
  use sig_deck_config, only: deck_config_t
  use sig_deck_parse, only: parse_deck
  use sig_deck_read_history, only: check_tables, state_parameters
  use sig_deck_read_problem, only: read_problem
  use sig_deck_read_study, only: read_study
  use sig_deck_tree, only: deck_tree_t, root_node
  use sig_deck_unfilled, only: report_unfilled
  use sig_deck_values, only: get_text
  use sig_errors, only: error_list_t, error_t, make_error
  use sig_file_system, only: base_name
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: read_deck

  !> largest number of errors that are reported at once
  integer, parameter :: max_errors = 40

contains

  !> Reads the text of a deck and checks all that needs no other file. Local, and the same text gives the same result on every rank.
  !>
  !> Errors: all errors in the order of the lines, but if they are more than 41 only the first 40 and how many more there are; none
  !> if the deck is valid. If there is one, the configuration must not be used. The search ends early after invalid YAML, after
  !> values that are still FILL_IN, and without parameters.
  subroutine read_deck(path, text, config, errors)
    !> path as the user gave it: for messages, for the deck's name, and because paths in a deck are relative to it
    character(*), intent(in) :: path
    !> content of the deck
    character(*), intent(in) :: text
    type(deck_config_t), intent(out) :: config
    type(error_list_t), intent(out) :: errors
    type(deck_tree_t) :: tree

    config%path = path
    config%name = base_name(path)
    call parse_deck(path, text, tree)
    if (tree%errors%n_errors() == 0) call report_unfilled(tree)
    if (tree%errors%n_errors() == 0) call read_sections(tree, config)
    if (tree%errors%n_errors() == 0) return
    call sort_by_line(tree%errors%errors)
    call take_first(tree%errors, path, errors)
  end subroutine read_deck

  !> Keeps all errors if they are at most max_errors + 1; otherwise the first max_errors, and adds one that says how many were left
  !> out.
  subroutine take_first(found, path, errors)
    type(error_list_t), intent(in) :: found
    character(*), intent(in) :: path
    type(error_list_t), intent(out) :: errors
    type(error_t), allocatable :: error
    integer :: n_left

    n_left = found%n_errors() - max_errors
    if (n_left <= 1) then
      errors = found
    else
      errors%errors = found%errors(:max_errors)
      call make_error(error, 'there are ' // to_text(n_left) // ' more errors', path)
      call errors%add(error)
    end if
  end subroutine take_first

  subroutine read_sections(tree, config)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(inout) :: config

    config%title = config%name
    config%petsc_options = ''
    call get_text(tree, root_node, 'title', .false., config%title)
    call read_problem(tree, config)
    if (size(config%parameters) == 0) then
      call report_unknown_sections(tree)
      return
    end if
    call read_study(tree, config)
    call get_text(tree, root_node, 'petsc_options', .false., config%petsc_options)
    call tree%close_mapping(root_node)
    call list_state_parameters(tree, config)
    call check_deck(tree, config)
  end subroutine read_sections

  !> Sets state_parameters, and which of them expressions of the deck use. After an error their ranges may be empty.
  subroutine list_state_parameters(tree, config)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(inout) :: config
    integer :: n
    logical :: has_marks

    n = size(config%parameters)
    ! a name that cannot be used is an error, which check_deck adds; then the others need no marks
    has_marks = size(tree%is_parameter_used) == n + config%history%states%n_values()
    if (has_marks) config%parameters%is_used = tree%is_parameter_used(:n)
    if (tree%errors%n_errors() == 0) call check_tables(tree, config%parameters, config%history)
    config%state_parameters = state_parameters(config%parameters, config%history, tree%errors%n_errors() == 0)
    if (has_marks) config%state_parameters(n + 1:)%is_used = tree%is_parameter_used(n + 1:)
  end subroutine list_state_parameters

  !> Reports unknown keys of the deck itself, where its sections are not read because there are no parameters.
  subroutine report_unknown_sections(tree)
    type(deck_tree_t), intent(inout) :: tree
    character(*), parameter :: others(15) = [character(19) :: 'history', 'materials', 'boundary_conditions', 'loads', &
      'imposed_strains', 'contact', 'solver', 'training', 'test', 'clusters', 'reduction', &
      'certificate', 'validation', 'output', 'petsc_options']
    integer :: i, i_node

    do i = 1, size(others)
      i_node = tree%find(root_node, trim(others(i)))
    end do
    call tree%close_mapping(root_node)
  end subroutine report_unknown_sections

  !> Sorts errors by line and column, by insertion, which is stable: errors of one place stay in the order in which they were found.
  pure subroutine sort_by_line(errors)
    type(error_t), intent(inout) :: errors(:)
    type(error_t) :: error
    integer :: i, j

    do i = 2, size(errors)
      error = errors(i)
      j = i - 1
      do while (j > 0)
        if (.not. stands_before(error, errors(j))) exit
        errors(j + 1) = errors(j)
        j = j - 1
      end do
      errors(j + 1) = error
    end do
  end subroutine sort_by_line

  pure logical function stands_before(one, other)
    type(error_t), intent(in) :: one
    type(error_t), intent(in) :: other

    stands_before = one%line < other%line .or. (one%line == other%line .and. one%column < other%column)
  end function stands_before
end module sig_deck_read
