! SPDX-License-Identifier: BSD-3-Clause
!> Reads the sections `reduction` and `certificate` of a deck.
module sig_deck_read_reduction
  use sig_deck_config, only: displacement_config_t, enrichment_config_t, reduction_config_t, zone_config_t
  use sig_deck_read_loads, only: read_axis
  use sig_deck_tree, only: deck_tree_t, kind_list, kind_mapping, kind_scalar, root_node, shown
  use sig_deck_values, only: choice_of, get_choice, get_mapping, get_name, get_names, get_number, get_integer, integer_of, &
    name_of, number_of
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model_t
  use sig_memory, only: machine_memory
  implicit none(type, external)
  private
  public :: read_reduction, read_count_or_word, read_tolerance_or_none

  character(*), parameter :: methods(3) = [character(9) :: 'auto', 'condensed', 'hhr']
  character(*), parameter :: dirichlet_treatments(2) = [character(15) :: 'elastic_lifting', 'multiplier']
  character(*), parameter :: enrichments(4) = [character(6) :: 'auto', 'none', 'greedy', 'all']
  character(*), parameter :: sides(2) = [character(6) :: 'first', 'second']
  character(*), parameter :: reconstructions(2) = [character(29) :: 'multipliers_and_displacements', 'multipliers']
  character(*), parameter :: displacements(2) = [character(4) :: 'auto', 'none']
  character(*), parameter :: elsewhere(2) = [character(5) :: 'none', 'modes']
  character(*), parameter :: switches(2) = [character(5) :: 'false', 'true']

contains

  !> Reads the sections reduction and certificate. For sections and keys that are missing, sets or keeps the defaults.
  subroutine read_reduction(tree, model, reduction)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(mechanical_model_t), intent(in) :: model
    !> on entry with the defaults of its type
    type(reduction_config_t), intent(inout) :: reduction
    character(:), allocatable :: switch
    integer :: i_reduction

    reduction%method = trim(methods(1))
    reduction%dirichlet = trim(dirichlet_treatments(1))
    reduction%reconstruction = trim(reconstructions(1))
    reduction%displacement%type = displacements(1)
    reduction%displacement%elsewhere = trim(elsewhere(1))
    allocate (reduction%displacement%boundaries(0))
    reduction%enrichment%type = trim(enrichments(1))
    reduction%enrichment%side = trim(sides(1))
    allocate (reduction%zones_of_interest(0))
    reduction%max_full_order_size = usual_full_order_size()
    i_reduction = get_mapping(tree, root_node, 'reduction', .false.)
    call read_certificate(tree, reduction)
    if (i_reduction == 0) return
    call get_choice(tree, i_reduction, 'method', .false., methods, reduction%method)
    call read_modes(tree, i_reduction, reduction)
    call get_choice(tree, i_reduction, 'dirichlet', .false., dirichlet_treatments, reduction%dirichlet)
    call read_zones(tree, i_reduction, model, reduction)
    call tree%refuse_key(i_reduction, 'unpaired_nodes', 'earlier versions had it; partners of contact nodes always join the domain')
    call read_enrichment(tree, i_reduction, reduction%enrichment)
    call get_number(tree, i_reduction, 'rank_tolerance', .false., reduction%rank_tolerance)
    call get_choice(tree, i_reduction, 'reconstruction', .false., reconstructions, reduction%reconstruction)
    call read_displacement(tree, i_reduction, reduction%displacement)
    call get_number(tree, i_reduction, 'displacement_tolerance', .false., reduction%displacement_tolerance)
    switch = trim(switches(1))
    call get_choice(tree, i_reduction, 'fields', .false., switches, switch)
    reduction%has_fields = switch == switches(2)
    call read_size(tree, i_reduction, 'max_full_order_size', reduction%max_full_order_size, reduction%is_size_auto)
    call read_size(tree, i_reduction, 'max_transforms_size', reduction%max_transforms_size, reduction%is_transforms_size_auto)
    call get_number(tree, i_reduction, 'stiffness_tolerance', .false., reduction%stiffness_tolerance)
    call get_number(tree, i_reduction, 'inelastic_tolerance', .false., reduction%inelastic_tolerance)
    call tree%close_mapping(i_reduction)
  end subroutine read_reduction

  !> [MB] Returns the largest size of the full-order operator unless the deck sets it: an eighth of the memory of this machine. The
  !> model file is about as large, and each rank has a copy of the model.
  real(rk) function usual_full_order_size() result(megabytes)
    real(rk), parameter :: share = 1.0_rk / 8, bytes_per_megabyte = 1.0e6_rk

    megabytes = share * machine_memory() / bytes_per_megabyte
  end function usual_full_order_size

  !> Reads a size; `auto` leaves the default. Errors: another word.
  subroutine read_size(tree, i_reduction, key, megabytes, is_auto)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_reduction
    character(*), intent(in) :: key
    !> [MB]
    real(rk), intent(inout) :: megabytes
    logical, intent(inout) :: is_auto
    integer :: i_node
    logical :: is_valid

    i_node = tree%find(i_reduction, key)
    if (i_node == 0) return
    if (is_word(tree, i_node, 'auto')) return
    call number_of(tree, i_node, megabytes, is_valid)
    is_auto = .false.
  end subroutine read_size

  !> Reads the section `certificate`: `max_error: none` sets reduction%max_error to 0, which means no limit, and `auto` leaves its
  !> default. Errors: any other value that is no number greater than 0, an unknown key.
  subroutine read_certificate(tree, reduction)
    type(deck_tree_t), intent(inout) :: tree
    type(reduction_config_t), intent(inout) :: reduction
    integer :: i_certificate, i_node
    logical :: is_valid

    i_certificate = get_mapping(tree, root_node, 'certificate', .false.)
    if (i_certificate == 0) return
    i_node = tree%find(i_certificate, 'max_error')
    if (i_node > 0) then
      if (is_word(tree, i_node, 'none')) then
        reduction%max_error = 0
      else if (.not. is_word(tree, i_node, 'auto')) then
        call number_of(tree, i_node, reduction%max_error, is_valid)
        if (is_valid .and. reduction%max_error <= 0) call tree%report(i_node, 'is ' // tree%nodes(i_node)%text // &
          '; it must be auto, none, or greater than 0')
      end if
    end if
    call tree%close_mapping(i_certificate)
  end subroutine read_certificate

  !> Reads the keys for the modes of the domain, the basis and the multipliers: pod_tolerance, n_modes, extended_pod_tolerance,
  !> extra_modes, dual_pod_tolerance and normalize.
  subroutine read_modes(tree, i_reduction, reduction)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_reduction
    type(reduction_config_t), intent(inout) :: reduction
    character(:), allocatable :: switch

    call get_number(tree, i_reduction, 'pod_tolerance', .false., reduction%pod_tolerance)
    call read_count_or_word(tree, i_reduction, 'n_modes', 'auto', 1, reduction%n_modes)
    call read_tolerance_or_none(tree, i_reduction, 'extended_pod_tolerance', reduction%extended_pod_tolerance)
    call get_integer(tree, i_reduction, 'extra_modes', .false., reduction%extra_modes)
    call read_tolerance_or_none(tree, i_reduction, 'dual_pod_tolerance', reduction%dual_pod_tolerance)
    switch = trim(switches(1))
    call get_choice(tree, i_reduction, 'normalize', .false., switches, switch)
    reduction%is_normalized = switch == switches(2)
  end subroutine read_modes

  !> Reads a number greater than 0 and less than 1, or `none`, below a key. Errors: another value; a number is stored all the same.
  subroutine read_tolerance_or_none(tree, i_parent, key, tolerance)
    !> gets the error
    type(deck_tree_t), intent(inout) :: tree
    !> node of the mapping that has the key
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    !> unchanged for `none`, if the key is missing and if the value is no number
    real(rk), intent(inout) :: tolerance
    integer :: i_node
    logical :: is_valid

    i_node = tree%find(i_parent, key)
    if (i_node == 0) return
    if (is_word(tree, i_node, 'none')) return
    call number_of(tree, i_node, tolerance, is_valid)
    if (is_valid .and. (tolerance <= 0 .or. tolerance >= 1)) call tree%report(i_node, 'is ' // tree%nodes(i_node)%text // &
      '; it must be none, or greater than 0 and less than 1')
  end subroutine read_tolerance_or_none

  !> Reads a whole number of at least `minimum`, or a word, below a key. Errors: another value.
  subroutine read_count_or_word(tree, i_parent, key, word, minimum, count)
    !> gets the error
    type(deck_tree_t), intent(inout) :: tree
    !> node of the mapping that has the key
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    !> word that may stand in place of the number
    character(*), intent(in) :: word
    character(1) :: digit
    !> from 0 to 9
    integer, intent(in) :: minimum
    !> unchanged for the word, if the key is missing, and after an error
    integer, intent(inout) :: count
    integer :: i_node, value, n_errors

    i_node = tree%find(i_parent, key)
    if (i_node == 0) return
    if (is_word(tree, i_node, word)) return
    n_errors = tree%errors%n_errors()
    value = minimum
    call integer_of(tree, i_node, value)
    write (digit, '(i1)') minimum
    if (value < minimum) call tree%report(i_node, 'is ' // tree%nodes(i_node)%text // '; it must be ' // word // &
      ' or at least ' // digit)
    if (tree%errors%n_errors() == n_errors) count = value
  end subroutine read_count_or_word

  pure logical function is_word(tree, i_node, word)
    type(deck_tree_t), intent(in) :: tree
    integer, intent(in) :: i_node
    character(*), intent(in) :: word

    is_word = tree%nodes(i_node)%kind == kind_scalar
    if (is_word) is_word = tree%nodes(i_node)%text == word
  end function is_word

  !> Reads the key displacement: `auto`, `none`, or a mapping such as {boundaries: [top], elsewhere: modes}; elsewhere is none
  !> (default) or modes. Unchanged if the key is missing. Errors: another value, boundaries missing or empty, an unknown key.
  subroutine read_displacement(tree, i_reduction, displacement)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_reduction
    type(displacement_config_t), intent(inout) :: displacement
    character(*), parameter :: allowed = &
      '; it must be auto, none or a mapping such as {boundaries: [top], elsewhere: modes}, where elsewhere is none or modes'
    integer :: i_node

    i_node = tree%find(i_reduction, 'displacement')
    if (i_node == 0) return
    if (tree%nodes(i_node)%kind /= kind_mapping) then
      if (is_word(tree, i_node, displacements(1)) .or. is_word(tree, i_node, displacements(2))) then
        displacement%type = tree%nodes(i_node)%text
      else if (tree%nodes(i_node)%kind == kind_scalar) then
        call tree%report(i_node, 'is ' // shown(tree%nodes(i_node)%text) // allowed)
      else
        call tree%report(i_node, 'is ' // tree%kind_name(i_node) // allowed)
      end if
      return
    end if
    displacement%type = 'boundaries'
    call get_names(tree, i_node, 'boundaries', .true., displacement%boundaries)
    call get_choice(tree, i_node, 'elsewhere', .false., elsewhere, displacement%elsewhere)
    call tree%close_mapping(i_node)
  end subroutine read_displacement

  !> Reads the key enrichment: a type alone, or a mapping with settings, which may have the type. What is missing is unchanged.
  !> Errors: another value, unknown keys, faulty values.
  subroutine read_enrichment(tree, i_reduction, enrichment)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_reduction
    type(enrichment_config_t), intent(inout) :: enrichment
    integer :: i_enrichment

    i_enrichment = tree%find(i_reduction, 'enrichment')
    if (i_enrichment == 0) return
    if (tree%nodes(i_enrichment)%kind == kind_scalar) then
      call choice_of(tree, i_enrichment, enrichments, enrichment%type)
      return
    end if
    i_enrichment = get_mapping(tree, i_reduction, 'enrichment', .false.)
    if (i_enrichment == 0) return
    call get_choice(tree, i_enrichment, 'type', .false., enrichments, enrichment%type)
    call get_number(tree, i_enrichment, 'max_condition_number', .false., enrichment%max_condition_number)
    call get_choice(tree, i_enrichment, 'side', .false., sides, enrichment%side)
    call read_count_or_word(tree, i_enrichment, 'max_hats', 'none', 0, enrichment%max_hats)
    call tree%close_mapping(i_enrichment)
  end subroutine read_enrichment

  !> Reads the key zones_of_interest: `auto`, or a list, perhaps empty, whose entries are boundary names, mappings {boundary: name,
  !> window: {...}}, or the word auto. has_loaded_zones is true if the key is missing, auto, or a list with auto. Errors: another
  !> value; auto, or a boundary without a window, twice in the list; those of read_zone.
  subroutine read_zones(tree, i_reduction, model, reduction)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_reduction
    type(mechanical_model_t), intent(in) :: model
    type(reduction_config_t), intent(inout) :: reduction
    integer, allocatable :: nodes(:)
    logical, allocatable :: is_auto(:)
    integer :: i, i_list, n

    i_list = tree%find(i_reduction, 'zones_of_interest')
    if (i_list == 0) return
    if (is_word(tree, i_list, 'auto')) return
    reduction%has_loaded_zones = .false.
    if (tree%nodes(i_list)%kind /= kind_list) then
      call tree%report(i_list, 'is ' // tree%kind_name(i_list) // '; it must be auto or a list of boundaries [...]')
      return
    end if
    nodes = tree%children(i_list)
    is_auto = [(is_word(tree, nodes(i), 'auto'), i=1, size(nodes))]
    reduction%has_loaded_zones = any(is_auto)
    deallocate (reduction%zones_of_interest)
    allocate (reduction%zones_of_interest(count(.not. is_auto)))
    n = 0
    do i = 1, size(nodes)
      if (is_auto(i)) then
        if (any(is_auto(:i - 1))) call tree%report(nodes(i), 'is auto, which is already in the list')
        cycle
      end if
      n = n + 1
      call read_zone(tree, nodes(i), model, reduction%zones_of_interest(n))
      if (is_there(reduction%zones_of_interest(:n - 1), reduction%zones_of_interest(n))) call tree%report(nodes(i), &
        'is ' // shown(reduction%zones_of_interest(n)%boundary%text) // ', which is already in the list')
    end do
  end subroutine read_zones

  !> Reads a name, or {boundary: name, window: {...}}, where window may be missing. Errors: no name; a window without axis or bound,
  !> or with min >= max; unknown keys; faulty values.
  subroutine read_zone(tree, i_node, model, zone)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    type(mechanical_model_t), intent(in) :: model
    type(zone_config_t), intent(inout) :: zone

    zone%boundary%text = ''
    zone%axes = model%axes
    if (tree%nodes(i_node)%kind == kind_mapping) then
      call get_name(tree, i_node, 'boundary', zone%boundary)
      call read_window(tree, i_node, model, zone)
      call tree%close_mapping(i_node)
    else
      call name_of(tree, i_node, zone%boundary)
    end if
  end subroutine read_zone

  !> Whether the list already has the boundary of this zone without a window; false if this zone has a window or no name.
  pure logical function is_there(zones, zone)
    type(zone_config_t), intent(in) :: zones(:)
    type(zone_config_t), intent(in) :: zone
    integer :: i

    is_there = .false.
    if (zone%axis > 0 .or. len(zone%boundary%text) == 0) return
    do i = 1, size(zones)
      is_there = is_there .or. (zones(i)%axis == 0 .and. zones(i)%boundary%text == zone%boundary%text)
    end do
  end function is_there

  subroutine read_window(tree, i_zone, model, zone)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_zone
    type(mechanical_model_t), intent(in) :: model
    type(zone_config_t), intent(inout) :: zone
    integer :: i_window, n_errors
    logical :: are_read

    i_window = get_mapping(tree, i_zone, 'window', .false.)
    if (i_window == 0) return
    call read_axis(tree, i_window, model, zone%axis)
    zone%has_minimum = tree%find(i_window, 'min') > 0
    zone%has_maximum = tree%find(i_window, 'max') > 0
    n_errors = tree%errors%n_errors()
    call get_number(tree, i_window, 'min', .false., zone%minimum)
    call get_number(tree, i_window, 'max', .false., zone%maximum)
    are_read = tree%errors%n_errors() == n_errors
    call tree%close_mapping(i_window)
    if (.not. (zone%has_minimum .or. zone%has_maximum)) then
      call tree%report(i_window, 'has no bound; it needs min, max or both')
    else if (are_read .and. zone%has_minimum .and. zone%has_maximum .and. zone%minimum >= zone%maximum) then
      call tree%report(i_window, 'has a min that is not less than its max')
    end if
  end subroutine read_window
end module sig_deck_read_reduction
