! SPDX-License-Identifier: BSD-3-Clause
!> Checks the values of a deck for the sections on solving, reduction and output, alone and against each other.
module sig_deck_check_study
  use sig_deck_config, only: clusters_config_t, deck_config_t, displacement_config_t, greedy_config_t, max_sobol_parameters, &
    parameter_config_t, point_set_config_t, reduction_config_t
  use sig_deck_option_safety, only: complaint_about_writing
  use sig_deck_tree, only: deck_tree_t, shown
  use sig_kinds, only: rk
  use sig_text, only: are, counted, lower, split, string_t, to_text
  implicit none(type, external)
  private
  public :: check_study, complaint_about_options

  !> largest number of points of a set; more could be neither solved nor stored
  integer, parameter :: max_points = 1000000
  character(*), parameter :: too_many = 'has more than 1000000 points'
  character(*), parameter :: option_prefixes(4) = [character(12) :: '-fom_', '-active_set_', '-vi_', '-pod_']

contains

  !> Checks values and combinations of values in solver, training, test, reduction, validation, clusters, output and petsc_options,
  !> as far as they were not checked when they were read and no mesh is needed.
  subroutine check_study(tree, config)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    character(:), allocatable :: complaint

    if (config%solver%max_iterations < 1) call tree%report_at('solver.max_iterations', 'is ' // &
      to_text(config%solver%max_iterations) // '; it must be at least 1')
    if (config%solver%type == 'condensed' .and. config%solver%linear == 'gamg' .and. flows(config)) &
      call tree%report_at('solver.linear', 'is ''gamg''; with type condensed, where materials yield or creep, it must be ' // &
      'cholesky or auto', 'gamg goes with type: auto or active_set')
    if (config%solver%type == 'snesvi' .and. flows(config)) &
      call tree%report_at('solver.type', 'is ''snesvi'', which does not solve for materials that yield or creep; it must be ' // &
      'auto, condensed or active_set', 'leave type out, or write auto')
    if (config%greedy%is_used) then
      call check_point_set(tree, 'training.greedy.candidates', config%parameters, config%training)
      call check_greedy(tree, config%greedy, config%training)
    else
      call check_point_set(tree, 'training', config%parameters, config%training)
    end if
    call check_point_set(tree, 'test', config%parameters, config%test)
    if (config%reduction%has_fields .and. .not. (is_hyper_reduced(config) .or. &
                                                 has_all_nodes(config%reduction%displacement))) call tree%report_at( &
      'reduction.fields', 'is true, and reduction.displacement may leave nodes without a displacement; fields need those of ' // &
      'all nodes: displacement must be auto, or {boundaries: [...], elsewhere: modes}')
    if (config%reduction%max_full_order_size < 0) call tree%report_at('reduction.max_full_order_size', &
      'is ' // to_text(config%reduction%max_full_order_size) // ' MB; it must not be negative (0 = keep no full-order operator)')
    if (.not. (config%reduction%displacement_tolerance >= 0 .and. config%reduction%displacement_tolerance < 1)) &
      call tree%report_at('reduction.displacement_tolerance', 'is ' // to_text(config%reduction%displacement_tolerance) // &
      '; it must be at least 0 and less than 1 (0 = keep the responses of all nodes as they are)')
    if (config%reduction%max_transforms_size < 0) call tree%report_at('reduction.max_transforms_size', &
      'is ' // to_text(config%reduction%max_transforms_size) // ' MB; it must not be negative (0 = keep no transforms)')
    if (.not. (config%reduction%stiffness_tolerance > 0 .and. config%reduction%stiffness_tolerance < 1)) call tree%report_at( &
      'reduction.stiffness_tolerance', 'is ' // to_text(config%reduction%stiffness_tolerance) // &
      '; it must be greater than 0 and less than 1')
    if (.not. config%validation%accepted_forces > 0) call tree%report_at('validation.accept', &
      'is ' // to_text(config%validation%accepted_forces) // '; it must be greater than 0')
    if (.not. config%validation%accepted_fields > 0) call tree%report_at('validation.accept_fields', &
      'is ' // to_text(config%validation%accepted_fields) // '; it must be greater than 0')
    if (.not. config%validation%accepted_strains > 0) call tree%report_at('validation.accept_strains', &
      'is ' // to_text(config%validation%accepted_strains) // '; it must be greater than 0')
    call check_clusters(tree, config)
    call check_indicator(tree, config)
    if (config%history%states%is_there()) call refuse_selection(tree, config)
    if (flows(config)) call refuse_hyper_reduction(tree, config)
    call check_reduction(tree, config%reduction)
    call check_output_points(tree, config%parameters, config%output%points)
    call check_petsc_options(tree, config%petsc_options)
    complaint = complaint_about_options(config%petsc_options, config%solver%linear)
    if (len(complaint) > 0) call tree%report_at('petsc_options', 'has ' // complaint)
    complaint = complaint_about_writing(config%petsc_options)
    if (len(complaint) > 0) call tree%report_at('petsc_options', 'has ' // complaint)
  end subroutine check_study

  !> Whether the model is hyper-reduced whatever the mesh, as choose_model_kind of the reduction decides.
  pure logical function is_hyper_reduced(config)
    type(deck_config_t), intent(in) :: config

    associate (clusters => config%clusters, method => config%reduction%method)
      is_hyper_reduced = method == 'hhr' .or. (method == 'auto' .and. &
                                               (clusters%number /= 1 .or. clusters%target%is_used .or. clusters%refine%is_used))
    end associate
  end function is_hyper_reduced

  !> Whether the deck asks for the displacement of every node, exact or by modes, from a condensed model.
  pure logical function has_all_nodes(displacement)
    type(displacement_config_t), intent(in) :: displacement

    has_all_nodes = displacement%type == 'auto' .or. (displacement%type == 'boundaries' .and. displacement%elsewhere == 'modes')
  end function has_all_nodes

  subroutine check_point_set(tree, section, parameters, points)
    type(deck_tree_t), intent(inout) :: tree
    character(*), intent(in) :: section
    type(parameter_config_t), intent(in) :: parameters(:)
    type(point_set_config_t), intent(in) :: points

    call check_grid(tree, section, parameters, points)
    if (points%n_sobol > max_points) call tree%report_at(section // '.sobol', too_many)
    if (points%n_latin_hypercube > max_points) call tree%report_at(section // '.latin_hypercube', too_many)
    if (points%n_sobol > 0 .and. size(parameters) > max_sobol_parameters) call tree%report_at(section // '.sobol', &
      'works for up to ' // to_text(max_sobol_parameters) // ' parameters; the deck has ' // to_text(size(parameters)) // &
      ' (latin_hypercube has no limit)')
    if (points%seed < 0) call tree%report_at(section // '.seed', 'is ' // to_text(points%seed) // '; it must be at least 0')
  end subroutine check_point_set

  !> Checks a greedy selection: max_points must not be below the number of initial points, and there must be at least as many
  !> candidates as initial points, unless a file has the candidates.
  subroutine check_greedy(tree, greedy, candidates)
    type(deck_tree_t), intent(inout) :: tree
    type(greedy_config_t), intent(in) :: greedy
    type(point_set_config_t), intent(in) :: candidates

    if (greedy%max_points < greedy%n_initial) call tree%report_at('training.greedy.max_points', 'is ' // &
      to_text(greedy%max_points) // '; it must be at least initial, which is ' // to_text(greedy%n_initial))
    if (greedy%n_initial > n_points_of(candidates)) call tree%report_at('training.greedy', 'begins with ' // &
      counted(greedy%n_initial, 'point') // ' (initial); there ' // are(n_points_of(candidates)) // ' only ' // &
      counted(n_points_of(candidates), 'candidate'))
  end subroutine check_greedy

  subroutine check_grid(tree, section, parameters, points)
    type(deck_tree_t), intent(inout) :: tree
    character(*), intent(in) :: section
    type(parameter_config_t), intent(in) :: parameters(:)
    type(point_set_config_t), intent(in) :: points
    real(rk) :: n_points
    integer :: i

    if (.not. allocated(points%grid)) return
    do i = 1, size(parameters)
      if (points%grid(i) < 2) call tree%report_at(section // '.grid.' // parameters(i)%name, 'is ' // to_text(points%grid(i)) // &
        '; it must be at least 2, as both ends of the range belong to the grid')
    end do
    n_points = product(real(points%grid, rk))
    if (n_points > max_points) call tree%report_at(section // '.grid', too_many)
  end subroutine check_grid

  subroutine check_clusters(tree, config)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    integer :: n_items

    associate (clusters => config%clusters, training => config%training)
      call check_tolerance(tree, 'clusters.cell_pod_tolerance', clusters%cell_pod_tolerance)
      if (clusters%seed < 0) call tree%report_at('clusters.seed', 'is ' // to_text(clusters%seed) // '; it must be at least 0')
      if (clusters%max_number < 1) call tree%report_at('clusters.max_number', 'is ' // to_text(clusters%max_number) // &
        '; it must be at least 1')
      if (clusters%min_snapshots < 1) call tree%report_at('clusters.min_snapshots', 'is ' // &
        to_text(clusters%min_snapshots) // '; it must be at least 1')
      if (clusters%opposite_snapshots == 'different' .and. clusters%method == 'regular') call tree%report_at( &
        'clusters.opposite_snapshots', 'is ''different''; it belongs to method: irregular, which compares snapshots')
      if (clusters%target%is_used) call check_target(tree, config)
      if (clusters%refine%is_used) call check_refine(tree, clusters)
      if ((clusters%number == 1 .and. .not. clusters%target%is_used) .or. .not. config%has_training) return
      if (clusters%method == 'irregular') then
        n_items = min(n_points_of(training), config%greedy%max_points)
        if (clusters%number > n_items) call tree%report_at('clusters.number', 'is ' // to_text(clusters%number) // &
          '; there ' // are(n_items) // trim(merge(' at most', ' only   ', config%greedy%is_used)) // ' ' // &
          counted(n_items, 'training point'))
      else if (config%greedy%is_used .or. .not. allocated(training%grid)) then
        call tree%report_at('clusters', 'has method: regular (the default), which needs the cells of training.grid; ' // &
          'there is no such grid', 'use method: irregular, or training: {grid: ...}')
      else if (real(clusters%number, rk) > product(real(training%grid - 1, rk))) then
        call tree%report_at('clusters.number', 'is ' // to_text(clusters%number) // '; the training grid has only ' // &
          counted(product(training%grid - 1), 'cell'))
      end if
    end associate
  end subroutine check_clusters

  !> Whether some material yields or creeps.
  pure logical function flows(config)
    type(deck_config_t), intent(in) :: config
    integer :: i

    flows = any([(config%materials(i)%flows(), i=1, size(config%materials))])
  end function flows

  !> Checks that the indicator of a greedy selection is that of the materials: audit where they flow, and only there.
  subroutine check_indicator(tree, config)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config

    if (.not. config%greedy%is_used) return
    if (flows(config) .and. config%greedy%indicator /= 'audit') then
      call tree%report_at('training.greedy.indicator', 'is ''' // config%greedy%indicator // '''; where materials yield or ' // &
        'creep it must be audit: whole histories are chosen, by the error that the model estimates of itself', &
        'leave indicator out')
    else if (config%greedy%indicator == 'audit' .and. .not. flows(config)) then
      call tree%report_at('training.greedy.indicator', 'is ''audit'', but no material yields or creeps; it must be projection ' // &
        'or defect')
    end if
  end subroutine check_indicator

  !> Refuses what chooses single states of a history, or divides their box into cells.
  subroutine refuse_selection(tree, config)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    character(*), parameter :: reason = ' does not go with history; '

    if (config%greedy%is_used .and. .not. flows(config)) call tree%report_at('training.greedy', 'is given, and a greedy ' // &
      'selection' // reason // 'give the training points by grid, sobol, latin_hypercube or file', &
      'it chooses histories only where materials yield or creep')
    if (config%clusters%target%is_used) call tree%report_at('clusters.target', 'is given, and a target' // reason // &
      'give the number of clusters')
    if (config%clusters%number /= 1 .and. config%clusters%method == 'regular') call tree%report_at('clusters', &
      'has method: regular (the default), which' // reason // 'it needs the cells of a grid', 'use method: irregular')
  end subroutine refuse_selection

  !> Refuses hyper-reduced models of materials that yield or creep. Measured on pellet and cladding: 20 to 54 % of the steps had no
  !> answer with a reduced domain of 7 to 14 % of the elements, and 4 to 18 % error with a third of them.
  subroutine refuse_hyper_reduction(tree, config)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    character(*), parameter :: reason = '; hyper-reduction does not go with materials that yield or creep: contact forces are ' // &
      'the reactions of a stiff system, so that small errors of displacements on a few cells become large ones of the forces'

    if (config%reduction%method == 'hhr') call tree%report_at('reduction.method', 'is ''hhr''' // reason, &
      'leave method out, or write auto')
    associate (clusters => config%clusters)
      if (clusters%number /= 1 .or. clusters%target%is_used .or. clusters%refine%is_used) call tree%report_at('clusters', &
        'gives several local models, which are hyper-reduced' // reason, 'leave clusters out')
    end associate
  end subroutine refuse_hyper_reduction

  subroutine check_target(tree, config)
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config

    associate (clusters => config%clusters)
      if (clusters%target%error <= 0) call tree%report_at('clusters.target.error', 'is ' // to_text(clusters%target%error) // &
        '; it must be greater than 0')
      call check_point_set(tree, 'clusters.target.candidates', config%parameters, clusters%target%candidates)
      if (clusters%number > 0 .and. .not. clusters%refine%is_used) call tree%report_at('clusters.target', &
        'is given for a fixed number of clusters; it goes with number: auto, or with refine', &
        'refine: {max_points: 100} adds up to 100 snapshots and splits clusters to meet the target')
    end associate
  end subroutine check_target

  subroutine check_refine(tree, clusters)
    type(deck_tree_t), intent(inout) :: tree
    type(clusters_config_t), intent(in) :: clusters

    if (.not. clusters%target%is_used) call tree%report_at('clusters.refine', 'does not say when to stop; ' // &
      'it needs clusters.target', &
      'for example: target: {error: 0.05, candidates: {sobol: 200}}')
    if (clusters%refine%max_points < 0) call tree%report_at('clusters.refine.max_points', 'is ' // &
      to_text(clusters%refine%max_points) // '; it must be at least 0', 'max_points: 0 only splits clusters and adds no snapshots')
    if (clusters%number > clusters%max_number) call tree%report_at('clusters.number', 'is ' // to_text(clusters%number) // &
      '; it must be at most max_number, which is ' // to_text(clusters%max_number))
  end subroutine check_refine

  !> Returns the number of points of a set, but 1000000 for a larger grid; huge if a file has the points, because their number is
  !> not known yet, or if there is no set.
  pure integer function n_points_of(points) result(n_points)
    type(point_set_config_t), intent(in) :: points

    n_points = huge(n_points)
    if (points%n_sobol > 0) n_points = points%n_sobol
    if (points%n_latin_hypercube > 0) n_points = points%n_latin_hypercube
    if (allocated(points%grid)) n_points = nint(min(product(real(points%grid, rk)), real(max_points, rk)))
  end function n_points_of

  subroutine check_reduction(tree, reduction)
    type(deck_tree_t), intent(inout) :: tree
    type(reduction_config_t), intent(in) :: reduction

    call check_tolerance(tree, 'reduction.pod_tolerance', reduction%pod_tolerance)
    call check_tolerance(tree, 'reduction.rank_tolerance', reduction%rank_tolerance)
    call check_tolerance(tree, 'reduction.inelastic_tolerance', reduction%inelastic_tolerance)
    if (reduction%extra_modes < 0) call tree%report_at('reduction.extra_modes', 'is ' // to_text(reduction%extra_modes) // &
      '; it must be at least 0')
    if (reduction%extra_modes > 0 .and. reduction%extended_pod_tolerance > 0) call tree%report_at('reduction.extra_modes', &
      'is given together with extended_pod_tolerance; only one of them may set the number of extra modes')
    if (reduction%extended_pod_tolerance > 0 .and. reduction%n_modes == 0 .and. &
        reduction%extended_pod_tolerance >= reduction%pod_tolerance) call tree%report_at( &
      'reduction.extended_pod_tolerance', 'is ' // to_text(reduction%extended_pod_tolerance) // &
      '; it must be less than pod_tolerance, ' // to_text(reduction%pod_tolerance))
    if (reduction%enrichment%max_condition_number < 1) call tree%report_at('reduction.enrichment.max_condition_number', 'is ' // &
      to_text(reduction%enrichment%max_condition_number) // '; it must be at least 1', &
      'with type: greedy, 1 usually adds all hat functions that are possible, up to max_hats')
  end subroutine check_reduction

  subroutine check_tolerance(tree, path, tolerance)
    type(deck_tree_t), intent(inout) :: tree
    character(*), intent(in) :: path
    real(rk), intent(in) :: tolerance

    if (tolerance <= 0 .or. tolerance >= 1) call tree%report_at(path, 'is ' // to_text(tolerance) // &
      '; it must be greater than 0 and less than 1')
  end subroutine check_tolerance

  subroutine check_output_points(tree, parameters, points)
    type(deck_tree_t), intent(inout) :: tree
    type(parameter_config_t), intent(in) :: parameters(:)
    real(rk), intent(in) :: points(:, :)
    character(:), allocatable :: path, unit
    integer :: i, j

    do i = 1, size(points, 2)
      path = 'output.points[' // to_text(i) // ']'
      do j = 1, size(parameters)
        if (parameters(j)%minimum >= parameters(j)%maximum) cycle
        if (points(j, i) >= parameters(j)%minimum .and. points(j, i) <= parameters(j)%maximum) cycle
        unit = ''
        if (len(parameters(j)%unit) > 0) unit = ' ' // parameters(j)%unit
        call tree%report_at(path // '.' // parameters(j)%name, 'is ' // to_text(points(j, i)) // unit // &
          '; it must lie between ' // to_text(parameters(j)%minimum) // ' and ' // to_text(parameters(j)%maximum) // unit)
      end do
      do j = 1, i - 1
        if (any(abs(points(:, i) - points(:, j)) > 0)) cycle
        call tree%report_at(path, 'is the same point as output.points[' // to_text(j) // ']')
        exit
      end do
    end do
  end subroutine check_output_points

  !> Checks that each option begins with -fom_, -active_set_, -vi_ or -pod_, and that each value directly follows an option.
  !> is_option says which words are options; all others are values. Stops at the first value that does not follow an option.
  subroutine check_petsc_options(tree, options)
    type(deck_tree_t), intent(inout) :: tree
    !> options and values with blanks between them
    character(*), intent(in) :: options
    type(string_t), allocatable :: words(:)
    integer :: i
    logical :: is_value_allowed

    words = words_of(options)
    is_value_allowed = .false.
    do i = 1, size(words)
      if (is_option(words(i)%text)) then
        is_value_allowed = .true.
        if (.not. has_known_prefix(words(i)%text)) call tree%report_at('petsc_options', 'has ' // shown(words(i)%text) // &
          '; an option must start with one of -fom_, -active_set_, -vi_, -pod_')
      else
        if (.not. is_value_allowed) then
          call tree%report_at('petsc_options', 'has ' // shown(words(i)%text) // &
            '; write each option with its minus sign, and at most one value behind it, as in -fom_ksp_rtol 1e-8')
          return
        end if
        is_value_allowed = .false.
      end if
    end do
  end subroutine check_petsc_options

  !> Returns a complaint about the first option with `_pc_type` in its name and a value other than cholesky and lu, because answers
  !> would lose accuracy. The next word counts as the value; an option at the end is not checked. The complaint begins with option
  !> and value, as in `-fom_pc_type jacobi; it must be ...`. It is empty if there is no such option, or if `linear` is gamg.
  pure function complaint_about_options(options, linear) result(complaint)
    !> names and values with blanks between them
    character(*), intent(in) :: options
    !> solver.linear of the deck
    character(*), intent(in) :: linear
    character(:), allocatable :: complaint
    type(string_t), allocatable :: words(:)
    integer :: i

    complaint = ''
    if (linear == 'gamg') return
    words = words_of(options)
    do i = 1, size(words) - 1
      ! PETSc ignores upper and lower case in names
      if (index(lower(words(i)%text), '_pc_type') == 0) cycle
      if (words(i + 1)%text == 'cholesky' .or. words(i + 1)%text == 'lu') cycle
      complaint = words(i)%text // ' ' // words(i + 1)%text // '; it must be cholesky or lu unless solver.linear is gamg'
      return
    end do
  end function complaint_about_options

  !> Returns the words of a text that blanks separate.
  pure function words_of(text) result(words)
    character(*), intent(in) :: text
    type(string_t), allocatable :: words(:)
    integer :: i

    words = split(text, ' ')
    words = pack(words, [(len(words(i)%text) > 0, i=1, size(words))])
  end function words_of

  !> Whether a word begins with a minus sign and a character other than a digit or a point, so that `-1e-3` counts as a value. A
  !> minus sign alone is no option.
  pure logical function is_option(word)
    character(*), intent(in) :: word

    is_option = .false.
    if (len(word) > 1) is_option = word(1:1) == '-' .and. scan(word(2:2), '0123456789.') == 0
  end function is_option

  pure logical function has_known_prefix(word)
    character(*), intent(in) :: word
    integer :: i

    has_known_prefix = .false.
    do i = 1, size(option_prefixes)
      if (index(lower(word), trim(option_prefixes(i))) == 1) has_known_prefix = .true.
    end do
  end function has_known_prefix
end module sig_deck_check_study
