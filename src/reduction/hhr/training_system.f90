! SPDX-License-Identifier: BSD-3-Clause
!> Builds the reduced system of a domain and its modes: imposes prescribed displacements, adds hats, projects the equations, and
!> checks that they have one solution.
module sig_training_system
  use sig_dirichlet_rows, only: impose_dirichlet_rows
  use sig_elastic_body, only: elastic_body_t
  use sig_enrichment, only: choose_hats, enrichment_path_t, enrichment_rule_t
  use sig_errors, only: error_t, make_error
  use sig_hat_functions, only: hat_columns, hat_set_t, hats_of_all_nodes, hats_of_rows, select_hats
  use sig_kinds, only: rk
  use sig_hhr_data, only: hhr_data_t
  use sig_hhr_stiffness, only: bulk_modulus, shear_modulus, thin_bulk_modulus
  use sig_load_pattern, only: load_pattern_t
  use sig_problem, only: problem_t
  use sig_projection, only: expected_stiffness_rank, project, project_contact_rows, project_part, projected_blocks_t
  use sig_reduced_domain, only: reduced_domain_t
  use sig_solvability, only: hang_bodies, is_undetermined, measure_stiffness, rank_on_domain, solvability_warnings, &
    undetermined_text
  use sig_stiffness_terms, only: body_of_rest, body_of_term
  use sig_term_values, only: evaluate_points
  use sig_text, only: to_text
  use sig_training_set, only: training_set_t
  use sig_zone_nodes, only: find_loaded_nodes
  implicit none(type, external)
  private
  public :: build_system

contains

  !> Fills in `cluster` the domain, the basis with hats, the lifting, the blocks of (10) with their parts for varying moduli, and
  !> what tells whether the reduced problem is solvable: kappa and the rank of (11), the rank and condition number of K_r, the
  !> anchors, the warnings.
  !>
  !> Errors: the modes miss the prescribed displacements (split_prescribed); the equations of the domain do not determine all modes;
  !> the mesh lacks a loaded boundary.
  subroutine build_system(problem, snapshots, domain, moved_nodes, modes, cluster, error)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(reduced_domain_t), intent(in) :: domain
    !> nodes on which prescribed displacements are imposed as equations, natural; not used with a lifting
    integer, intent(in) :: moved_nodes(:)
    !> POD modes V, shape (n_dofs, n_modes)
    real(rk), intent(in) :: modes(:, :)
    type(hhr_data_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(out) :: error
    type(projected_blocks_t) :: blocks
    type(hat_set_t) :: hats
    type(load_pattern_t) :: forces
    type(elastic_body_t) :: rest

    call keep_domain(domain, cluster)
    call split_prescribed(problem, snapshots, moved_nodes, modes, cluster, error)
    if (allocated(error)) return
    call enrich(problem, domain, modes, hats, cluster)
    call problem%boundary%get_forces(forces)
    call body_of_rest(problem%stiffness_terms, problem%body, rest)
    call project(problem%mesh, rest, problem%rows, forces, domain, cluster%basis, cluster%lifting, cluster%lifted_terms, blocks)
    call keep_blocks(blocks, cluster)
    call project_varying(problem, domain, cluster)
    call count_equations(problem, domain, cluster)
    call check_solvable(problem, snapshots%parameters, domain, cluster, error)
  end subroutine build_system

  !> Fills cluster%varying: the parts of the system for each modulus that depends on the parameters, and the values of these moduli
  !> in the middle of the box.
  subroutine project_varying(problem, domain, cluster)
    type(problem_t), intent(in) :: problem
    type(reduced_domain_t), intent(in) :: domain
    type(hhr_data_t), intent(inout) :: cluster
    type(elastic_body_t) :: body
    real(rk), allocatable :: theta(:, :)
    integer :: i, i_bad_point, i_bad_source

    associate (parts => problem%stiffness_terms, varying => cluster%varying, parameters => problem%deck%state_parameters)
      allocate (varying%kinds(size(parts)), varying%young_terms(size(parts)), varying%poisson_terms(size(parts)))
      allocate (varying%reference(size(parts)), varying%parts(cluster%n_modes**2, size(parts)))
      allocate (varying%lifting_parts(cluster%n_modes * size(cluster%lifted_terms), size(parts)))
      if (size(parts) == 0) return
      do i = 1, size(parts)
        varying%kinds(i) = modulus_kind(problem%body%mechanics%is_thin, parts(i)%i_hooke)
        varying%young_terms(i) = problem%constant_terms(2 * parts(i)%material - 1)
        varying%poisson_terms(i) = problem%constant_terms(2 * parts(i)%material)
        call body_of_term(parts(i), problem%body, body)
        call project_part(problem%mesh, body, domain, cluster%basis, cluster%lifting, varying%parts(:, i), &
          varying%lifting_parts(:, i))
      end do
      call evaluate_points(problem%terms, reshape(parameters%minimum / 2 + parameters%maximum / 2, [size(parameters), 1]), theta, &
        i_bad_point, i_bad_source)
      call varying%moduli_at(theta(:, 1), varying%reference)
    end associate
  end subroutine project_varying

  !> Returns the kind of modulus of a part of the stiffness: bulk_modulus, thin_bulk_modulus or shear_modulus.
  pure integer function modulus_kind(is_thin, i_hooke) result(kind)
    !> plane stress
    logical, intent(in) :: is_thin
    !> 2: shear modulus; otherwise bulk modulus
    integer, intent(in) :: i_hooke

    kind = merge(thin_bulk_modulus, bulk_modulus, is_thin)
    if (i_hooke == 2) kind = shear_modulus
  end function modulus_kind

  !> Sets cluster%primal_rank_expected, the largest number of modes that the equations can determine. Where the stiffness depends on
  !> the parameters, every dof of A counts, because snapshots of another stiffness are not in equilibrium.
  subroutine count_equations(problem, domain, cluster)
    type(problem_t), intent(in) :: problem
    type(reduced_domain_t), intent(in) :: domain
    type(hhr_data_t), intent(inout) :: cluster
    integer :: n_patterns

    n_patterns = 0
    if (problem%deck%reduction%dirichlet == 'multiplier') n_patterns = problem%boundary%strain_forces%n_terms()
    cluster%primal_rank_expected = expected_stiffness_rank(domain, &
      problem%boundary%loads%loaded_dofs(size(cluster%basis, 1)), n_patterns, cluster%n_hats, cluster%n_modes)
    if (cluster%varying%is_there()) cluster%primal_rank_expected = min(cluster%n_modes, size(domain%interior_dofs))
  end subroutine count_equations

  !> Adds hat functions to cluster%basis by reduction.enrichment of the deck, and keeps the history of the choice in `cluster`. The
  !> choice uses the POD modes before prescribed displacements were imposed on them.
  subroutine enrich(problem, domain, modes, hats, cluster)
    type(problem_t), intent(in) :: problem
    type(reduced_domain_t), intent(in) :: domain
    !> POD modes V, shape (n_dofs, n_modes)
    real(rk), intent(in) :: modes(:, :)
    !> those that were added, in this order
    type(hat_set_t), intent(out) :: hats
    type(hhr_data_t), intent(inout) :: cluster
    type(enrichment_rule_t) :: rule
    type(enrichment_path_t) :: path

    associate (config => problem%deck%reduction%enrichment)
      rule%is_greedy = config%type /= 'all'
      rule%is_auto = config%type == 'auto'
      rule%max_condition_number = config%max_condition_number
      rule%max_hats = merge(0, config%max_hats, config%type == 'none')
      rule%rank_tolerance = problem%deck%reduction%rank_tolerance
      if (rule%is_greedy) then
        hats = hats_of_rows(problem%rows, domain, problem%boundary%is_prescribed, config%side == 'second')
      else
        hats = hats_of_all_nodes(problem%rows, domain, problem%boundary%is_prescribed, config%side == 'second')
      end if
    end associate
    call choose_hats(project_contact_rows(problem%rows, domain, modes), hats%rows, hats%entries, rule, path)
    hats = select_hats(hats, path%chosen)
    call append_columns(cluster%basis, hat_columns(hats, size(modes, 1)))
    call keep_path(path, hats, domain, size(modes, 2), cluster)
  end subroutine enrich

  !> Appends columns to a matrix.
  pure subroutine append_columns(matrix, columns)
    !> shape (n, n_columns); afterwards wider
    real(rk), allocatable, intent(inout) :: matrix(:, :)
    real(rk), intent(in) :: columns(:, :)
    real(rk), allocatable :: wider(:, :)
    integer :: n

    n = size(matrix, 2)
    allocate (wider(size(matrix, 1), n + size(columns, 2)))
    wider(:, :n) = matrix
    wider(:, n + 1:) = columns
    call move_alloc(wider, matrix)
  end subroutine append_columns

  !> Keeps the history of the choice of hats in `cluster`, and n_hats, rank and condition_number after the last hat.
  pure subroutine keep_path(path, hats, domain, n_pod_columns, cluster)
    type(enrichment_path_t), intent(in) :: path
    !> the chosen hats
    type(hat_set_t), intent(in) :: hats
    type(reduced_domain_t), intent(in) :: domain
    !> number of POD modes, before prescribed displacements were imposed on them
    integer, intent(in) :: n_pod_columns
    type(hhr_data_t), intent(inout) :: cluster
    integer :: i

    cluster%n_hats = size(hats%rows)
    cluster%history%rows = [0, domain%contact_rows(hats%rows)]
    cluster%history%nodes = [0, hats%nodes]
    cluster%history%n_columns = [(n_pod_columns + i, i=0, cluster%n_hats)]
    cluster%history%ranks = path%ranks
    cluster%history%condition_numbers = path%condition_numbers
    cluster%history%singular_ratios = path%ratios
    cluster%rank = path%ranks(cluster%n_hats + 1)
    cluster%condition_number = path%condition_numbers(cluster%n_hats + 1)
  end subroutine keep_path

  subroutine keep_domain(domain, cluster)
    type(reduced_domain_t), intent(in) :: domain
    type(hhr_data_t), intent(inout) :: cluster

    cluster%seed_nodes = domain%seed_nodes
    cluster%facing_nodes = domain%facing_nodes
    cluster%cells = domain%cells
    cluster%interior_dofs = domain%interior_dofs
    cluster%interface_dofs = domain%interface_dofs
    cluster%contact_dofs = domain%contact_dofs
    cluster%contact_rows = domain%contact_rows
    cluster%n_rows = size(domain%contact_rows)
  end subroutine keep_domain

  subroutine keep_blocks(blocks, cluster)
    type(projected_blocks_t), intent(in) :: blocks
    type(hhr_data_t), intent(inout) :: cluster

    cluster%n_modes = size(blocks%reduced_stiffness, 1)
    cluster%reduced_stiffness = blocks%reduced_stiffness
    cluster%contact_matrix = blocks%contact_matrix
    cluster%load = blocks%load
    cluster%gap = blocks%gap
  end subroutine keep_blocks

  !> Sets basis and lifting of the displacement = lifting * theta + basis * gamma, for both values of reduction.dirichlet. Errors:
  !> the modes miss the prescribed displacements at moved_nodes by more than 1e-6 of the largest one (prescribed_misfit).
  subroutine split_prescribed(problem, snapshots, moved_nodes, modes, cluster, error)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    !> as in build_system
    integer, intent(in) :: moved_nodes(:)
    !> POD modes V, shape (n_dofs, n_modes)
    real(rk), intent(in) :: modes(:, :)
    type(hhr_data_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(out) :: error
    !> [-] largest relative error of the prescribed displacements that is accepted
    real(rk), parameter :: representable = 1.0e-6_rk
    integer, allocatable :: rows(:)
    real(rk) :: misfit
    integer :: rank, i

    if (problem%deck%reduction%dirichlet /= 'multiplier') then
      cluster%basis = modes
      cluster%lifting = snapshots%free_response
      cluster%lifted_terms = problem%lifted_terms(:size(cluster%lifting, 2))
      return
    end if
    rows = pack([(i, i=1, size(problem%boundary%prescribed_dofs))], &
      [(any(moved_nodes == (problem%boundary%prescribed_dofs(i) - 1) / problem%mesh%n_dim + 1), &
      i=1, size(problem%boundary%prescribed_dofs))])
    call impose_dirichlet_rows(modes, problem%boundary%prescribed_dofs(rows), problem%boundary%prescribed_values(rows, :), &
      problem%deck%reduction%rank_tolerance, cluster%basis, cluster%lifting, rank)
    cluster%lifted_terms = [(i, i=1, size(cluster%lifting, 2))]
    misfit = prescribed_misfit(problem, snapshots, rows, cluster%lifting)
    if (misfit > representable) call make_error(error, 'the modes miss the prescribed displacements by up to ' // &
      to_text(misfit) // ' of the largest one', problem%deck%path, &
      hint='use reduction.dirichlet: elastic_lifting, or more modes (a smaller reduction.pod_tolerance, or a larger n_modes)')
  end subroutine split_prescribed

  !> [-] Returns the largest difference between the lifting and the prescribed values over the training points and the given rows,
  !> divided by the largest size of these values; 0 where there is no difference.
  !>
  !> The modes need not take the values of each term alone, for example where both sides of a symmetric body always move together.
  !> Only the sum over the terms must be right.
  real(rk) function prescribed_misfit(problem, snapshots, rows, lifting) result(misfit)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    !> indices of boundary%prescribed_dofs
    integer, intent(in) :: rows(:)
    !> [length] displacement per term, shape (n_dofs, n_lifted_terms)
    real(rk), intent(in) :: lifting(:, :)
    real(rk), allocatable :: theta(:, :), wanted(:, :), found(:, :)
    integer :: i_bad_point, i_bad_source

    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    wanted = matmul(problem%boundary%prescribed_values(rows, :), theta(:size(lifting, 2), :))
    found = matmul(lifting(problem%boundary%prescribed_dofs(rows), :), theta(:size(lifting, 2), :))
    misfit = maxval([0.0_rk, abs(found - wanted)])
    if (misfit > 0) misfit = misfit / max(tiny(misfit), maxval(abs(wanted)))
  end function prescribed_misfit

  !> Measures ranks and condition numbers, chooses anchors, and sets cluster%warnings. Errors: the equations do not determine all
  !> modes; the mesh lacks a loaded boundary.
  subroutine check_solvable(problem, training_points, domain, cluster, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: training_points(:, :)
    type(reduced_domain_t), intent(in) :: domain
    type(hhr_data_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: loaded(:)
    integer :: i, n_missed

    associate (rank_tolerance => problem%deck%reduction%rank_tolerance)
      call measure_stiffness(rank_tolerance, cluster)
      call hang_bodies(problem%motions%n_free, rank_tolerance, cluster)
      cluster%basis_rank = rank_on_domain(cluster%basis, [domain%interior_dofs, domain%interface_dofs], rank_tolerance)
    end associate
    call find_loaded_nodes(problem, training_points, loaded, error)
    if (allocated(error)) return
    associate (nodes => (domain%interior_dofs - 1) / problem%mesh%n_dim + 1)
      n_missed = count([(.not. any(nodes == loaded(i)), i=1, size(loaded))])
    end associate
    cluster%warnings = solvability_warnings(cluster, problem%deck%reduction%enrichment%type == 'all', size(loaded), n_missed)
    if (is_undetermined(cluster)) call make_error(error, undetermined_text(cluster), problem%deck%path, &
      hint='add the contact surfaces and the loaded surfaces to reduction.zones_of_interest, or take fewer modes (a larger ' // &
      'extended_pod_tolerance if the deck has it, else a larger pod_tolerance, or a smaller n_modes or extra_modes)')
  end subroutine check_solvable
end module sig_training_system
