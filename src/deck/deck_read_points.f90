! SPDX-License-Identifier: BSD-3-Clause
!> Reads sets of points: the sections `training` and `test`, and candidates below other keys.
module sig_deck_read_points
  use sig_deck_config, only: greedy_config_t, parameter_config_t, point_set_config_t
  use sig_deck_read_reduction, only: read_count_or_word, read_tolerance_or_none
  use sig_deck_tree, only: deck_tree_t, kind_scalar, root_node
  use sig_deck_values, only: get_choice, get_integer, get_mapping, get_word, integer_of
  use sig_file_system, only: path_below
  use sig_text, only: append_text, join, string_t, to_text
  implicit none(type, external)
  private
  public :: read_point_set, read_candidates, read_count

  !> kinds of point sets; the last one is for training only
  character(*), parameter :: point_sets(5) = [character(15) :: 'grid', 'file', 'sobol', 'latin_hypercube', 'greedy']
  character(*), parameter :: seeded(2) = point_sets(3:4)
  character(*), parameter :: stiffness_kinds(3) = [character(12) :: 'auto', 'factored', 'interpolated']
  character(*), parameter :: indicators(3) = [character(10) :: 'projection', 'defect', 'audit']

contains

  !> Reads the section training or test: one kind of point set, its seed and its groups, for training also stiffness. Errors: no
  !> kind of point set or several, a seed for a kind without one, unknown keys, faulty values.
  subroutine read_point_set(tree, key, parameters, is_there, points, greedy)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    !> training or test
    character(*), intent(in) :: key
    type(parameter_config_t), intent(in) :: parameters(:)
    !> whether the deck has the section as a mapping; otherwise the points and greedy are unchanged
    logical, intent(out) :: is_there
    !> the points, or the candidates if greedy%is_used
    type(point_set_config_t), intent(inout) :: points
    !> greedy selection, with the default indicator; present for training only
    type(greedy_config_t), intent(inout), optional :: greedy
    integer :: i_section

    i_section = get_mapping(tree, root_node, key, .false.)
    is_there = i_section > 0
    if (.not. is_there) return
    points%line = tree%nodes(i_section)%line
    points%column = tree%nodes(i_section)%column
    call read_kinds(tree, i_section, parameters, points)
    if (present(greedy)) call read_greedy(tree, i_section, parameters, greedy, points)
    call read_groups(tree, i_section, points%n_groups)
    if (present(greedy)) then
      points%stiffness = trim(stiffness_kinds(1))
      call get_choice(tree, i_section, 'stiffness', .false., stiffness_kinds, points%stiffness)
    end if
    call tree%close_mapping(i_section)
    call check_kind(tree, i_section, key, point_sets(:merge(5, 4, present(greedy))))
  end subroutine read_point_set

  !> Reads the greedy selection of the section training, if there is one; its candidates then replace `candidates`, but for line and
  !> column. Otherwise sets greedy%is_used to false. Errors: those of read_candidates, neither of the keys tolerance and max_points,
  !> batch with the indicator projection, with audit tolerance or no max_points, unknown keys, faulty values.
  subroutine read_greedy(tree, i_section, parameters, greedy, candidates)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_section
    type(parameter_config_t), intent(in) :: parameters(:)
    !> in: the default indicator
    type(greedy_config_t), intent(inout) :: greedy
    type(point_set_config_t), intent(inout) :: candidates
    type(point_set_config_t) :: found
    integer :: i_batch, i_greedy, i_max_points, i_tolerance

    i_greedy = get_mapping(tree, i_section, 'greedy', .false.)
    greedy%is_used = i_greedy > 0
    if (.not. greedy%is_used) return
    call read_candidates(tree, i_greedy, 'training.greedy.candidates', parameters, found)
    found%line = candidates%line
    found%column = candidates%column
    candidates = found
    call get_choice(tree, i_greedy, 'indicator', .false., indicators, greedy%indicator)
    call read_count(tree, i_greedy, 'initial', greedy%n_initial)
    call read_tolerance_or_none(tree, i_greedy, 'tolerance', greedy%tolerance)
    call read_count_or_word(tree, i_greedy, 'max_points', 'none', 1, greedy%max_points)
    call read_count(tree, i_greedy, 'batch', greedy%batch)
    call tree%close_mapping(i_greedy)
    i_batch = tree%find(i_greedy, 'batch')
    i_max_points = tree%find(i_greedy, 'max_points')
    i_tolerance = tree%find(i_greedy, 'tolerance')
    if (greedy%indicator == 'projection' .and. i_batch > 0) call tree%report(i_batch, &
      'goes only with indicator: defect or audit; with projection the errors are computed again after each point')
    if (greedy%indicator == 'audit') then
      if (i_tolerance > 0) call tree%report(i_tolerance, 'does not go with indicator: audit; reduction.inelastic_tolerance ' // &
        'says which error is small enough')
      if (i_max_points == 0) call tree%report_key(i_greedy, 'training.greedy must have max_points, the largest number of ' // &
        'histories to solve, or max_points: none')
    else if (i_tolerance == 0 .and. i_max_points == 0) then
      call tree%report_key(i_greedy, 'training.greedy does not say when to stop; it must have tolerance, max_points or both')
    end if
  end subroutine read_greedy

  !> Reads the required key `candidates` of a mapping: a set of points without groups. Errors: the key is missing (the candidates
  !> are unchanged), no kind of point set or several, a seed for a kind without one, unknown keys, faulty values.
  subroutine read_candidates(tree, i_parent, path, parameters, candidates)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    !> node of the mapping
    integer, intent(in) :: i_parent
    !> key path of the candidates, for messages
    character(*), intent(in) :: path
    type(parameter_config_t), intent(in) :: parameters(:)
    type(point_set_config_t), intent(inout) :: candidates
    integer :: i_candidates

    i_candidates = get_mapping(tree, i_parent, 'candidates', .true.)
    if (i_candidates == 0) return
    candidates%line = tree%nodes(i_candidates)%line
    candidates%column = tree%nodes(i_candidates)%column
    call read_kinds(tree, i_candidates, parameters, candidates)
    call tree%close_mapping(i_candidates)
    call check_kind(tree, i_candidates, path, point_sets(:4))
  end subroutine read_candidates

  !> Reads all kinds of point sets that the section has, but for greedy, and the seed. check_kind finds whether the kinds are right.
  subroutine read_kinds(tree, i_section, parameters, points)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_section
    type(parameter_config_t), intent(in) :: parameters(:)
    type(point_set_config_t), intent(inout) :: points
    integer :: i_grid

    i_grid = get_mapping(tree, i_section, 'grid', .false.)
    if (i_grid > 0) call read_grid(tree, i_grid, parameters, points)
    call get_word(tree, i_section, 'file', .false., points%file)
    if (allocated(points%file)) points%path = path_below(tree%path, points%file)
    call read_count(tree, i_section, 'sobol', points%n_sobol)
    call read_count(tree, i_section, 'latin_hypercube', points%n_latin_hypercube)
    call get_integer(tree, i_section, 'seed', .false., points%seed)
  end subroutine read_kinds

  !> Checks that there is exactly one kind of point set, and a seed only for kinds that use it.
  subroutine check_kind(tree, i_section, key, kinds)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_section
    !> key path of the section for messages
    character(*), intent(in) :: key
    !> kinds that are allowed
    character(*), intent(in) :: kinds(:)
    character(:), allocatable :: allowed
    type(string_t), allocatable :: all_kinds(:), found(:)
    integer :: i

    allocate (all_kinds(0), found(0))
    do i = 1, size(kinds)
      call append_text(all_kinds, trim(kinds(i)))
      if (tree%find(i_section, trim(kinds(i))) > 0) call append_text(found, trim(kinds(i)))
    end do
    allowed = '; it must have one of ' // join(all_kinds, ', ')
    if (size(found) > 1) then
      call tree%report_key(i_section, key // ' has ' // join(found, ' and ') // allowed)
    else if (size(found) == 0) then
      call tree%report_key(i_section, key // ' has no points' // allowed)
    else if (tree%find(i_section, 'seed') > 0 .and. .not. any(found(1)%text == seeded)) then
      call tree%report(tree%find(i_section, 'seed'), 'is not for ' // found(1)%text // '; it belongs to sobol and latin_hypercube')
    end if
  end subroutine check_kind

  !> Reads a whole number of at least 1 below a key; unchanged if the key is missing. Errors: not a whole number (n_points is then
  !> 1), or below 1 (n_points is then this number).
  subroutine read_count(tree, i_section, key, n_points)
    !> gets the error
    type(deck_tree_t), intent(inout) :: tree
    !> node of the mapping that has the key
    integer, intent(in) :: i_section
    character(*), intent(in) :: key
    integer, intent(inout) :: n_points
    integer :: i_node

    i_node = tree%find(i_section, key)
    if (i_node == 0) return
    n_points = 1
    call get_integer(tree, i_section, key, .false., n_points)
    if (n_points < 1) call tree%report(i_node, 'is ' // to_text(n_points) // '; it must be at least 1')
  end subroutine read_count

  !> Reads the number of points of a grid for each parameter. Errors: a parameter without a number, or with something else than a
  !> whole number (in both cases it gets 2); a key that is no parameter. Numbers below 2 are kept here and refused by check_study.
  subroutine read_grid(tree, i_grid, parameters, points)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_grid
    type(parameter_config_t), intent(in) :: parameters(:)
    type(point_set_config_t), intent(inout) :: points
    integer :: i

    allocate (points%grid(size(parameters)), source=2)
    do i = 1, size(parameters)
      call get_integer(tree, i_grid, parameters(i)%name, .true., points%grid(i))
    end do
    call tree%close_mapping(i_grid)
  end subroutine read_grid

  !> Reads the number of groups: a whole number of at least 1, or `auto`, which leaves n_groups unchanged, as does a missing
  !> key. Errors: not a whole number (n_groups is then 1), or below 1 (n_groups is then this number).
  subroutine read_groups(tree, i_section, n_groups)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_section
    integer, intent(inout) :: n_groups
    integer :: i_node

    i_node = tree%find(i_section, 'groups')
    if (i_node == 0) return
    if (tree%nodes(i_node)%kind == kind_scalar) then
      if (tree%nodes(i_node)%text == 'auto') return
    end if
    n_groups = 1
    call integer_of(tree, i_node, n_groups)
    if (n_groups < 1) call tree%report(i_node, 'is ' // tree%nodes(i_node)%text // '; it must be auto or at least 1')
  end subroutine read_groups
end module sig_deck_read_points
