! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Builds the full-order problem from deck and mesh, before anything is solved: bodies, prescribed displacements, loads, imposed
!> strains, contact rows, and the choice of the solver.
module sig_problem
  use sig_accuracy_warnings, only: deck_warnings
  use sig_body_checks, only: check_bodies
  use sig_boundary_conditions, only: boundary_conditions_t, create_boundary_conditions
  use sig_checksum, only: fnv1a, fnv1a_seed, hash_digits, hash_of_text
  use sig_clock, only: wall_time
  use sig_contact_building, only: build_contact_rows
  use sig_contact_rows, only: contact_rows_t, create_contact_rows, separate_inert_rows
  use sig_contact_summary, only: contact_lines
  use sig_deck_config, only: deck_config_t, name_config_t
  use sig_deck_echo, only: echo_physics
  use sig_elastic_body, only: create_elastic_body, elastic_body_t
  use sig_element_types, only: element_types
  use sig_errors, only: error_t, make_error
  use sig_factor_size, only: measure_factor
  use sig_idle_work, only: idle_work_t
  use sig_imposed_strain, only: imposed_strains_t, strain_field_t
  use sig_kinds, only: rk
  use sig_length_units, only: length_factor
  use sig_lifted_strains, only: lift_strains
  use sig_load_pattern, only: load_pattern_t
  use sig_load_windows, only: check_fixed_windows, window_warnings
  use sig_loads, only: create_loads
  use sig_log, only: log_info, log_warnings
  use sig_materials, only: add_material_terms, create_material_terms, has_fixed_stiffness, most_points_per_stiffness, set_materials
  use sig_mechanical_models, only: coordinate_names, mechanical_model, mechanical_model_t
  use sig_mesh, only: find_group, mesh_t
  use sig_mesh_checks, only: material_of_cells, nodes_of_boundary, nodes_of_zone
  use sig_mesh_load, only: load_mesh
  use sig_petsc_support, only: has_multigrid_vi, memory_of_ranks, rank_and_size
  use sig_nodal_field, only: nodal_field_t
  use sig_nodal_field_load, only: load_nodal_fields
  use sig_rigid_motions, only: create_free_motions, create_rigid_motions, rigid_motions_t
  use sig_rounding, only: rounding_of_data
  use sig_slipping_motions, only: turn_normals
  use sig_smooth_normals, only: fit_normals
  use sig_solver_costs, only: problem_size_t
  use sig_solver_plan, only: make_solver_plan, plan_text, solver_plan_t
  use sig_stiffness_terms, only: list_stiffness_terms, stiffness_term_t
  use sig_strain_force, only: add_strain_forces, has_numbers
  use sig_strain_parts, only: create_imposed_strains
  use sig_term_set, only: start_terms, term_set_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: append_text, string_t, to_text
  use petsc
  implicit none(type, external)
  private
  public :: problem_t, load_problem, announce_plan, warn_of_plan, body_at, strains_at, surface_of_side
  public :: inert_pair_names, parameter_names, parameter_units, tags_text

  !> The full-order problem.
  type :: problem_t
    type(deck_config_t) :: deck
    type(mesh_t) :: mesh
    !> bodies with their elastic constants in the middle of the box of the parameters; body_at gives those of a point
    type(elastic_body_t) :: body
    !> whether no elastic constant depends on the parameters
    logical :: has_fixed_stiffness = .true.
    !> elastic constants, as functions of the parameters
    type(term_set_t) :: material_terms
    !> indices in `terms` of young_modulus and poisson_ratio of each material, one after the other; empty if has_fixed_stiffness
    integer, allocatable :: constant_terms(:)
    !> parts of the stiffness that depend on the elastic constants of materials that vary
    type(stiffness_term_t), allocatable :: stiffness_terms(:)
    !> strains that temperatures and swelling impose
    type(imposed_strains_t) :: strains
    !> prescribed displacements, loads and forces of imposed strains
    type(boundary_conditions_t) :: boundary
    !> all terms: those of prescribed displacements, loads and forces of imposed strains, then of liftings, constants and gaps
    type(term_set_t) :: terms
    !> indices in `terms` of the terms for which a lifting has a column: those of prescribed displacements, then of imposed strains
    integer, allocatable :: lifted_terms(:)
    !> whether all but the contact rows and what follows from them is there; may be true even after an error of load_problem
    logical :: has_driving = .false.
    !> rows with a multiplier, and inert rows, whose displacements are all prescribed
    type(contact_rows_t) :: rows
    type(contact_rows_t) :: inert
    !> which solver is taken, and why
    type(solver_plan_t) :: plan
    !> what the costs of solvers depend on
    type(problem_size_t) :: sizes
    !> whether the multipliers are at the second surface of each contact entry, shape (size(deck%contact))
    logical, allocatable :: is_swapped(:)
    !> sentences about surfaces whose nodes do not match, and about directions
    type(string_t), allocatable :: contact_notes(:)
    !> sentences about what the mesh file lacks, and about bodies that only contact holds
    type(string_t), allocatable :: notes(:)
    !> sentences about parameters that nothing uses, and about materials that make answers inaccurate
    type(string_t), allocatable :: warnings(:)
    !> [s] wall time of reading the mesh, and of the work after it up to the contact rows
    real(rk) :: mesh_seconds = 0
    real(rk) :: pairing_seconds = 0
    !> rigid motions of the bodies; only contact holds the free ones
    type(rigid_motions_t) :: motions
    !> [rad] by how much the motions in which each body slips on others miss the tangents of their surfaces, shape (n_bodies)
    real(rk), allocatable :: misses(:)
    !> false if bodies slip, but no normals were found that let them (turn_normals)
    logical :: is_settled = .true.
    !> work of the loads on the idle motions, which nothing holds
    type(idle_work_t) :: idle_work
    !> hash of echo_physics, the mesh file and the fields: snapshots with the same hash belong to the same problem
    character(16) :: provenance = ''
  end type problem_t

  !> [-] share of the machine's memory that solvers may take; the rest is for the mesh, results and other programs
  real(rk), parameter :: share_of_memory = 0.6_rk

contains

  !> Reads the mesh and the fields of a deck and builds its problem, which is the same on all ranks of comm. Collective on comm.
  !>
  !> Errors, the same on all ranks, are for example: a mesh or field that cannot be used; names that the mesh does not have; values
  !> that are not finite; different displacements prescribed for one node; surfaces that cannot be in contact; a body that nothing
  !> can hold; a solver that cannot solve this problem. `problem` is then incomplete (see has_driving).
  subroutine load_problem(deck, comm, problem, error, ierr)
    type(deck_config_t), intent(in) :: deck
    MPI_Comm, intent(in) :: comm
    type(problem_t), intent(out) :: problem
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: material_of_cell(:)
    type(nodal_field_t), allocatable :: fields(:)
    real(rk) :: start

    problem%deck = deck
    start = wall_time()
    PetscCall(load_mesh(deck%mesh, deck%path, length_factor(deck), comm, problem%mesh, error, ierr))
    if (allocated(error)) return
    problem%mesh_seconds = wall_time() - start
    start = wall_time()
    call material_of_cells(problem%mesh, deck%materials, deck%path, material_of_cell, error)
    if (allocated(error)) return
    call create_body(deck, material_of_cell, problem)
    PetscCall(load_nodal_fields(problem%mesh, deck%imposed_strains, deck%path, length_factor(deck), comm, fields, error, ierr))
    if (allocated(error)) return
    call create_driving(deck, fields, problem, error)
    if (allocated(error)) return
    problem%has_driving = .true.
    call create_contact(deck, problem, error)
    if (allocated(error)) return
    problem%pairing_seconds = wall_time() - start
    call check_zones(deck, problem%mesh, error)
    if (allocated(error)) return
    PetscCall(plan_solving(problem, comm, error, ierr))
    if (allocated(error)) return
    problem%provenance = hash_of_text(echo_physics(deck) // problem%mesh%file_hash // field_hashes(fields))
  end subroutine load_problem

  !> Returns the hashes of the values of all fields, one after the other; empty without fields.
  pure function field_hashes(fields) result(text)
    !> those without values do not count
    type(nodal_field_t), intent(in) :: fields(:)
    character(:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(fields)
      if (allocated(fields(i)%values)) text = text // hash_digits(fnv1a(fields(i)%values, fnv1a_seed))
    end do
  end function field_hashes

  !> Finds the rigid motions, the notes and the warnings, and chooses the solver. Errors: a body that nothing can hold; a solver
  !> that cannot solve this problem.
  subroutine plan_solving(problem, comm, error, ierr)
    type(problem_t), intent(inout) :: problem
    MPI_Comm, intent(in) :: comm
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(string_t), allocatable :: body_notes(:)
    character(:), allocatable :: message
    integer :: i

    ierr = 0
    call let_bodies_slip(problem)
    call create_rigid_motions(problem%mesh, problem%body%mechanics%is_round, problem%boundary%is_prescribed, problem%rows, &
      problem%motions)
    call measure_idle_work(problem)
    problem%warnings = deck_warnings(problem%deck, problem%mesh, problem%body%material_of_cell)
    if (.not. problem%is_settled) call append_text(problem%warnings, 'round bodies slip on each other in this contact, but no ' // &
      'normals of the mesh were found that let them: the facets resist rotations that the round surfaces would not; a finer ' // &
      'mesh of these surfaces, or a support, helps')
    call check_bodies(problem%deck, problem%mesh, problem%motions, body_notes, error)
    if (allocated(error)) return
    PetscCall(measure_problem(problem, comm, ierr))
    problem%notes = problem%mesh%notes
    if (size(problem%deck%contact) == 0) call append_text(problem%notes, 'the deck has no contact, so that nothing touches: ' // &
      'displacements and stresses are those of linear elasticity')
    do i = 1, size(body_notes)
      call append_text(problem%notes, body_notes(i)%text)
    end do
    associate (solver => problem%deck%solver)
      call make_solver_plan(solver, problem%sizes, problem%plan, message)
      if (allocated(message)) call make_error(error, message, problem%deck%path, solver%line, solver%column)
    end associate
  end subroutine plan_solving

  !> Sets problem%sizes. Collective.
  subroutine measure_problem(problem, comm, ierr)
    type(problem_t), intent(inout) :: problem
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: rank

    associate (sizes => problem%sizes, mesh => problem%mesh)
      sizes%n_dim = mesh%n_dim
      sizes%n_dofs = mesh%n_dim * mesh%n_nodes
      sizes%n_multipliers = problem%rows%n_rows
      sizes%n_points = most_points_per_stiffness(problem%deck, problem%material_terms)
      sizes%is_floating = problem%motions%n_free > 0
      sizes%has_multigrid_vi = has_multigrid_vi()
      sizes%is_quadratic = any(element_types(mesh%cell_types)%order == 2)
      sizes%stiffness_ratio = stiffness_ratio(problem%body)
      PetscCall(rank_and_size(comm, rank, sizes%n_ranks, ierr))
      PetscCall(memory_of_ranks(comm, sizes%memory, ierr))
      sizes%memory = share_of_memory * sizes%memory
      call measure_factor(mesh, sizes%stiffness_entries, sizes%factor_entries, sizes%factor_operations)
    end associate
  end subroutine measure_problem

  !> Returns the largest modulus of a material over the smallest, by the largest entries of their stress matrices.
  pure real(rk) function stiffness_ratio(body)
    type(elastic_body_t), intent(in) :: body

    associate (moduli => maxval(maxval(abs(body%stress_matrix), dim=1), dim=1))
      stiffness_ratio = maxval(moduli) / minval(moduli)
    end associate
  end function stiffness_ratio

  !> Turns the normals of the rows where bodies slip on each other, so that facets do not hold them, and sets problem%misses. Does
  !> nothing in axisymmetry, where bodies only shift along the axis.
  subroutine let_bodies_slip(problem)
    type(problem_t), intent(inout) :: problem
    type(rigid_motions_t) :: motions
    type(name_config_t) :: name
    real(rk), allocatable :: errors(:), normals(:, :)
    integer :: groups(size(problem%deck%contact)), i

    ! with those that rows resist by little more than rounding: fine facets of a round body
    call create_free_motions(problem%mesh, problem%body%mechanics%is_round, problem%boundary%is_prescribed, problem%rows, motions)
    allocate (problem%misses(motions%n_bodies), source=0.0_rk)
    if (motions%n_free == 0 .or. motions%is_round .or. .not. problem%deck%solver%holds_unloaded_motions) return
    groups = 0
    do i = 1, size(groups)
      if (problem%deck%contact(i)%has_direction .or. problem%deck%contact(i)%has_obstacle) cycle
      name = surface_of_side(problem, i, 1)
      groups(i) = find_group(problem%mesh, name%text, problem%mesh%n_dim - 1)
    end do
    call fit_normals(problem%mesh, problem%rows, groups, normals, errors)
    call turn_normals(motions, normals, errors, problem%rows, problem%misses, problem%is_settled)
  end subroutine let_bodies_slip

  !> Sets the work of each term's forces on the idle motions. Where bodies slip, the axis of a rotation is known up to the angle by
  !> which the motion misses the tangents, and so is the work.
  subroutine measure_idle_work(problem)
    type(problem_t), intent(inout) :: problem
    !> the work on a motion may err by so many times its miss
    real(rk), parameter :: margin = 10.0_rk
    type(load_pattern_t) :: pattern
    integer :: t

    associate (idle => problem%motions%idle, work => problem%idle_work, n_terms => problem%boundary%n_terms)
      allocate (work%work(n_terms, idle%n), work%limits(n_terms, idle%n), source=0.0_rk)
      call problem%boundary%get_forces(pattern)
      if (idle%n == 0 .or. pattern%n_entries() == 0) return
      do t = 1, n_terms
        associate (dofs => pack(pattern%dofs, pattern%terms == t), values => pack(pattern%values, pattern%terms == t))
          call idle%work(problem%motions, dofs, values, work%work(t, :), work%limits(t, :))
        end associate
        work%limits(t, :) = work%limits(t, :) * max(rounding_of_data, margin * problem%misses(idle%carriers))
      end do
    end associate
  end subroutine measure_idle_work

  !> Writes to the log, by log_info, the contacts and their gaps at the points, the solver and why it is taken, and all notes;
  !> then the warnings (warn_of_plan). Requires: check_points accepted the points.
  subroutine announce_plan(problem, points)
    type(problem_t), intent(in) :: problem
    !> points that will be solved, shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable :: lines(:)
    integer :: i

    lines = contact_lines(problem%deck, problem%mesh, problem%rows, problem%inert, problem%terms, points)
    do i = 1, size(lines)
      call log_info(lines(i)%text)
    end do
    call log_info(plan_text(problem%plan))
    do i = 1, size(problem%contact_notes)
      call log_info('note: ' // problem%contact_notes(i)%text)
    end do
    do i = 1, size(problem%notes)
      call log_info('note: ' // problem%notes(i)%text)
    end do
    call warn_of_plan(problem, points)
  end subroutine announce_plan

  !> Logs the warnings of a problem, and those of window_warnings at the points. Requires: check_points accepted the points.
  subroutine warn_of_plan(problem, points)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable :: more(:)

    call log_warnings(problem%warnings)
    more = window_warnings(problem%deck, problem%mesh, points)
    call log_warnings(more)
  end subroutine warn_of_plan

  !> Checks that the mesh has the zones of interest and the boundaries with exact displacements, because otherwise the error would
  !> come only after the sampling, and that fixed windows of loads meet their surfaces. Errors: the first that the mesh lacks; no
  !> node lies in the window of a zone; a window loads nothing.
  subroutine check_zones(deck, mesh, error)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: nodes(:)
    integer :: i

    call check_fixed_windows(deck, mesh, error)
    if (allocated(error)) return
    do i = 1, size(deck%reduction%zones_of_interest)
      call nodes_of_zone(mesh, deck%reduction%zones_of_interest(i), deck%path, nodes, error)
      if (allocated(error)) return
    end do
    do i = 1, size(deck%reduction%displacement%boundaries)
      call nodes_of_boundary(mesh, deck%reduction%displacement%boundaries(i), deck%path, nodes, error)
      if (allocated(error)) return
    end do
  end subroutine check_zones

  !> Makes problem%material_terms and the bodies with their elastic constants in the middle of the box.
  subroutine create_body(deck, material_of_cell, problem)
    type(deck_config_t), intent(in) :: deck
    !> number of each cell's material in the deck, shape (n_cells)
    integer, intent(in) :: material_of_cell(:)
    type(problem_t), intent(inout) :: problem
    real(rk) :: ones(size(deck%materials))

    ones = 1
    problem%has_fixed_stiffness = has_fixed_stiffness(deck)
    call create_material_terms(deck, parameter_names(deck), problem%material_terms)
    call create_elastic_body(deck%mesh%model, ones, 0 * ones, material_of_cell, problem%body)
    call set_materials(problem%material_terms, deck%state_parameters%minimum / 2 + deck%state_parameters%maximum / 2, problem%body)
  end subroutine create_body

  !> Returns the bodies with their elastic constants at a point. Requires: check_points accepted the point.
  subroutine body_at(problem, point, body)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    type(elastic_body_t), intent(out) :: body

    body = problem%body
    if (.not. problem%has_fixed_stiffness) call set_materials(problem%material_terms, point, body)
  end subroutine body_at

  !> Returns the imposed strains at a point; without imposed strains the field is empty. Requires: check_points accepted the point.
  subroutine strains_at(problem, point, field)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    type(strain_field_t), intent(out) :: field
    real(rk), allocatable :: theta(:, :)
    integer :: i_bad_point, i_bad_source

    if (.not. problem%strains%are_there()) return
    call evaluate_points(problem%strains%terms, reshape(point, [size(point), 1]), theta, i_bad_point, i_bad_source)
    call problem%strains%evaluate(problem%mesh, problem%body, theta(:, 1), field)
  end subroutine strains_at

  !> Makes prescribed displacements, loads, imposed strains and their lifted forces, and all terms but those of gaps. Lists the
  !> terms that are lifted, those of the elastic constants, and those of the stiffness. Errors: those of create_boundary_conditions,
  !> create_loads, create_imposed_strains and add_strain_forces.
  subroutine create_driving(deck, fields, problem, error)
    type(deck_config_t), intent(in) :: deck
    !> fields of the imposed strains
    type(nodal_field_t), intent(in) :: fields(:)
    type(problem_t), intent(inout) :: problem
    type(error_t), allocatable, intent(out) :: error
    type(mechanical_model_t) :: model
    integer :: n_first

    model = mechanical_model(deck%mesh%model)
    call start_terms(parameter_names(deck), coordinate_names(model), model%is_round, problem%terms)
    call create_boundary_conditions(problem%mesh, deck%boundary_conditions, deck%path, problem%terms, problem%boundary, error)
    if (allocated(error)) return
    call create_loads(problem%mesh, problem%body, deck%loads, deck%path, problem%terms, problem%boundary%loads, error)
    if (allocated(error)) return
    call start_terms(parameter_names(deck), coordinate_names(model), model%is_round, problem%strains%terms)
    call create_imposed_strains(problem%mesh, problem%body, deck, fields, problem%strains, error)
    if (allocated(error)) return
    n_first = problem%terms%n_terms()
    call add_strain_forces(problem%mesh, problem%body, deck, problem%strains, problem%terms, problem%boundary%strain_forces, error)
    if (allocated(error)) return
    problem%boundary%n_driving_terms = problem%terms%n_terms()
    call lift_strains(problem%mesh, problem%body, problem%strains, n_first, problem%terms, problem%boundary, problem%lifted_terms)
    allocate (problem%constant_terms(0))
    if (.not. problem%has_fixed_stiffness) call add_material_terms(deck, problem%terms, problem%constant_terms)
    call list_stiffness_terms(.not. has_numbers(deck%materials), problem%stiffness_terms)
  end subroutine create_driving

  !> Makes the contact rows, divides them into `rows` and `inert`, and adds the terms of their gaps behind all others. Errors: those
  !> of build_contact_rows; then there are no rows.
  subroutine create_contact(deck, problem, error)
    type(deck_config_t), intent(in) :: deck
    type(problem_t), intent(inout) :: problem
    type(error_t), allocatable, intent(out) :: error
    type(contact_rows_t) :: all_rows

    allocate (problem%is_swapped(size(deck%contact)))
    call build_contact_rows(deck, problem%mesh, problem%body, problem%boundary, problem%terms, all_rows, problem%contact_notes, &
      problem%is_swapped, error)
    if (allocated(error)) call leave_out_rows(problem%mesh%n_dim, problem%terms%n_terms(), all_rows)
    problem%boundary%n_terms = problem%terms%n_terms()
    call separate_inert_rows(all_rows, problem%boundary%is_prescribed, problem%rows, problem%inert)
  end subroutine create_contact

  !> Makes an empty set of rows, for a problem whose contacts were refused.
  pure subroutine leave_out_rows(n_dim, n_terms, rows)
    integer, intent(in) :: n_dim
    integer, intent(in) :: n_terms
    type(contact_rows_t), intent(out) :: rows
    real(rk) :: gap(0, n_terms), weights(n_dim, 0)

    call create_contact_rows([integer ::], [integer ::], [integer ::], weights, gap, [real(rk) ::], [integer ::], rows)
  end subroutine leave_out_rows

  !> Returns the name of one surface of a contact entry. Side 1 carries the multipliers: it is the deck's first surface unless the
  !> sides were swapped. Requires: side 2 is not an obstacle.
  pure type(name_config_t) function surface_of_side(problem, i_entry, side) result(name)
    type(problem_t), intent(in) :: problem
    !> number of the contact entry, 1-based
    integer, intent(in) :: i_entry
    !> 1 or 2
    integer, intent(in) :: side

    associate (entry => problem%deck%contact(i_entry))
      name = entry%first
      if ((side == 2) .neqv. problem%is_swapped(i_entry)) name = entry%second
    end associate
  end function surface_of_side

  !> Returns the names of the inert rows, `3 - 8` or `3 - obstacle`, with the node numbers of the mesh file; several nodes of one
  !> side have blanks between them.
  function inert_pair_names(problem) result(names)
    type(problem_t), intent(in) :: problem
    type(string_t), allocatable :: names(:)
    integer :: k

    allocate (names(problem%inert%n_rows))
    do k = 1, size(names)
      associate (tags => problem%mesh%node_tags, second => problem%inert%second_nodes_of(k))
        names(k)%text = tags_text(tags(problem%inert%first_nodes_of(k)), ' ') // ' - obstacle'
        if (size(second) > 0) names(k)%text = tags_text(tags(problem%inert%first_nodes_of(k)), ' ') // ' - ' // &
          tags_text(tags(second), ' ')
      end associate
    end do
  end function inert_pair_names

  !> Returns numbers as text with a separator between them. Requires: at least one number.
  pure function tags_text(tags, separator) result(text)
    integer, intent(in) :: tags(:)
    character(*), intent(in) :: separator
    character(:), allocatable :: text
    integer :: i

    text = to_text(tags(1))
    do i = 2, size(tags)
      text = text // separator // to_text(tags(i))
    end do
  end function tags_text

  !> Returns the names of the parameters in the deck's order.
  pure function parameter_names(deck) result(names)
    type(deck_config_t), intent(in) :: deck
    type(string_t), allocatable :: names(:)
    integer :: i

    allocate (names(size(deck%state_parameters)))
    do i = 1, size(names)
      names(i)%text = deck%state_parameters(i)%name
    end do
  end function parameter_names

  !> Returns the units of the parameters in the deck's order; a unit may be empty.
  pure function parameter_units(deck) result(units)
    type(deck_config_t), intent(in) :: deck
    type(string_t), allocatable :: units(:)
    integer :: i

    allocate (units(size(deck%state_parameters)))
    do i = 1, size(units)
      units(i)%text = deck%state_parameters(i)%unit
    end do
  end function parameter_units
end module sig_problem
