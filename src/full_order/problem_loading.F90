! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Builds the full-order problem from deck and mesh: bodies, prescribed displacements, loads, imposed strains, contact rows, and the
!> choice of the solver.
module sig_problem_loading
  use sig_accuracy_warnings, only: deck_warnings
  use sig_body_checks, only: check_bodies
  use sig_boundary_conditions, only: create_boundary_conditions
  use sig_checksum, only: fnv1a, fnv1a_seed, hash_digits, hash_of_text
  use sig_clock, only: wall_time
  use sig_contact_building, only: build_contact_rows
  use sig_contact_rows, only: contact_rows_t, create_contact_rows, separate_inert_rows
  use sig_deck_config, only: deck_config_t, name_config_t
  use sig_deck_echo, only: echo_physics
  use sig_elastic_body, only: create_elastic_body, elastic_body_t
  use sig_element_types, only: element_types
  use sig_errors, only: error_t, make_error
  use sig_factor_size, only: compact_factor, factor_size_t, measure_factor
  use sig_flow_building, only: add_temperatures, create_flow_model
  use sig_flowing_cells, only: dofs_of_flowing_bodies
  use sig_friction_building, only: add_friction_terms, add_motion_terms, create_contact_laws
  use sig_kinds, only: rk
  use sig_length_units, only: length_factor
  use sig_lifted_strains, only: lift_strains
  use sig_load_pattern, only: load_pattern_t
  use sig_load_windows, only: check_fixed_windows
  use sig_loads, only: create_loads
  use sig_materials, only: add_material_terms, create_material_terms, has_fixed_stiffness, most_points_per_stiffness, set_materials
  use sig_mechanical_models, only: coordinate_names, mechanical_model, mechanical_model_t
  use sig_mesh, only: find_group, mesh_t
  use sig_mesh_checks, only: material_of_cells, nodes_of_boundary, nodes_of_zone
  use sig_mesh_load, only: load_mesh
  use sig_nodal_field, only: nodal_field_t
  use sig_nodal_field_load, only: load_nodal_fields
  use sig_petsc_support, only: has_multigrid_vi, memory_of_ranks, rank_and_size
  use sig_problem, only: named_nodes, parameter_names, problem_t, surface_of_side
  use sig_rigid_motions, only: create_free_motions, create_rigid_motions, rigid_motions_t
  use sig_rounding, only: rounding_of_data
  use sig_slipping_motions, only: turn_normals
  use sig_smooth_normals, only: fit_normals
  use sig_solver_costs, only: problem_size_t
  use sig_solver_plan, only: make_solver_plan
  use sig_sparse_friction, only: contact_without_dofs, text_without_dofs
  use sig_stiffness_terms, only: list_stiffness_terms
  use sig_strain_force, only: add_strain_forces, has_numbers
  use sig_strain_parts, only: create_imposed_strains
  use sig_term_set, only: start_terms
  use sig_text, only: append_text, string_t
  use petsc
  implicit none(type, external)
  private
  public :: load_problem

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
    type(nodal_field_t), allocatable :: fields(:)
    real(rk) :: start

    problem%deck = deck
    start = wall_time()
    PetscCall(load_mesh(deck%mesh, deck%path, length_factor(deck), comm, problem%mesh, error, ierr))
    problem%mesh_seconds = wall_time() - start
    start = wall_time()
    work: block
      if (allocated(error)) exit work
      call create_body(deck, problem, error)
      if (allocated(error)) exit work
      PetscCall(load_nodal_fields(problem%mesh, deck%imposed_strains, deck%path, length_factor(deck), comm, fields, error, ierr))
      if (allocated(error)) exit work
      call create_driving(deck, fields, problem, error)
      if (allocated(error)) exit work
      call create_contact(deck, problem, error)
      if (allocated(error)) exit work
      problem%pairing_seconds = wall_time() - start
      call check_zones(deck, problem%mesh, error)
      if (allocated(error)) exit work
      PetscCall(plan_solving(problem, comm, error, ierr))
      if (allocated(error)) exit work
      problem%provenance = hash_of_text(echo_physics(deck) // problem%mesh%file_hash // field_hashes(fields))
      problem%elimination%provenance = problem%provenance
      problem%elimination%path = deck%output%path // '/compliance.h5'
    end block work
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

  !> Makes problem%material_terms and the bodies with their elastic constants in the middle of the box. Errors: those of
  !> material_of_cells.
  subroutine create_body(deck, problem, error)
    type(deck_config_t), intent(in) :: deck
    type(problem_t), intent(inout) :: problem
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: material_of_cell(:)
    real(rk) :: ones(size(deck%materials))

    call material_of_cells(problem%mesh, deck%materials, deck%path, material_of_cell, error)
    if (allocated(error)) return
    ones = 1
    problem%has_fixed_stiffness = has_fixed_stiffness(deck)
    call create_material_terms(deck, parameter_names(deck), problem%material_terms)
    call create_elastic_body(deck%mesh%model, ones, 0 * ones, material_of_cell, problem%body)
    call set_materials(problem%material_terms, deck%state_parameters%minimum / 2 + deck%state_parameters%maximum / 2, problem%body)
    call create_flow_model(problem%mesh, deck, parameter_names(deck), problem%body, problem%flow, error)
  end subroutine create_body

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
    call create_loads(problem%mesh, problem%body%without_flow(), deck%loads, deck%path, problem%terms, problem%boundary%loads, &
      error)
    if (allocated(error)) return
    call start_terms(parameter_names(deck), coordinate_names(model), model%is_round, problem%strains%terms)
    call create_imposed_strains(problem%mesh, problem%body, deck, fields, problem%strains, error)
    if (allocated(error)) return
    call add_temperatures(problem%mesh, problem%body, deck, fields, problem%strains%terms, problem%flow, error)
    if (allocated(error)) return
    n_first = problem%terms%n_terms()
    call add_strain_forces(problem%mesh, problem%body, deck, problem%strains, problem%terms, problem%boundary%strain_forces, error)
    if (allocated(error)) return
    problem%boundary%n_driving_terms = problem%terms%n_terms()
    call lift_strains(problem%mesh, problem%body, problem%strains, n_first, problem%terms, problem%boundary, problem%lifted_terms)
    allocate (problem%constant_terms(0))
    if (.not. problem%has_fixed_stiffness) call add_material_terms(deck, problem%terms, problem%constant_terms)
    call add_friction_terms(deck%contact, problem%terms, problem%friction_terms)
    call add_motion_terms(deck, problem%terms, problem%motion_terms)
    call list_stiffness_terms(.not. has_numbers(deck%materials), problem%stiffness_terms)
    problem%has_driving = .true.
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
    call create_contact_laws(problem%deck, problem%mesh, problem%boundary, problem%friction_terms, &
      problem%motion_terms, problem%rows, problem%force_rows, problem%laws, error)
    if (allocated(error)) return
    call create_rigid_motions(problem%mesh, problem%body%mechanics%is_round, problem%boundary%is_prescribed, problem%force_rows, &
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
    if (size(problem%deck%contact) == 0 .and. problem%flow%is_there()) then
      call append_text(problem%notes, 'the deck has no contact, so that nothing touches')
    else if (size(problem%deck%contact) == 0) then
      call append_text(problem%notes, 'the deck has no contact, so that nothing touches: displacements and stresses are those ' // &
        'of linear elasticity')
    end if
    do i = 1, size(body_notes)
      call append_text(problem%notes, body_notes(i)%text)
    end do
    associate (solver => problem%deck%solver)
      call make_solver_plan(solver, problem%sizes, problem%plan, message)
      if (.not. allocated(message)) return
      call make_error(error, message, problem%deck%path, solver%line, solver%column)
      if (problem%sizes%lacks_own_dofs) error%hint = text_without_dofs(problem, contact_without_dofs(problem))
    end associate
  end subroutine plan_solving

  !> Sets problem%sizes. Collective.
  subroutine measure_problem(problem, comm, ierr)
    type(problem_t), intent(inout) :: problem
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    type(factor_size_t) :: factor, bordered(2)
    integer, allocatable :: named(:)
    integer :: i, rank

    associate (sizes => problem%sizes, mesh => problem%mesh, rows => problem%force_rows)
      sizes%n_dim = mesh%n_dim
      sizes%n_dofs = mesh%n_dim * mesh%n_nodes
      sizes%n_multipliers = rows%n_rows
      sizes%has_plain_contact = problem%laws%is_plain()
      sizes%has_friction = problem%laws%remembers()
      sizes%n_points = most_points_per_stiffness(problem%deck, problem%material_terms)
      sizes%is_floating = problem%motions%n_free > 0
      sizes%lacks_own_dofs = contact_without_dofs(problem) > 0
      sizes%has_multigrid_vi = has_multigrid_vi()
      sizes%is_quadratic = any(element_types(mesh%cell_types)%order == 2)
      sizes%stiffness_ratio = stiffness_ratio(problem%body)
      PetscCall(rank_and_size(comm, rank, sizes%n_ranks, ierr))
      PetscCall(memory_of_ranks(comm, sizes%memory, ierr))
      sizes%memory = share_of_memory * sizes%memory
      named = pack([(i, i=1, sizes%n_dofs)], .not. problem%boundary%is_prescribed .and. &
        pack(spread(named_nodes(problem), 1, mesh%n_dim), .true.))
      sizes%n_named_dofs = size(named)
      ! a row has all components of each of its nodes; a named dof is a row of its own
      associate (offsets => rows%offsets/mesh%n_dim, nodes => rows%dofs(mesh%n_dim::mesh%n_dim) / mesh%n_dim)
        call measure_factor(mesh, [offsets, (size(nodes) + i, i=1, size(named))], [nodes, (named - 1) / mesh%n_dim + 1], &
          rows%n_rows + [0, size(named)], sizes%stiffness_entries, factor, bordered)
      end associate
      sizes%factor_entries = factor%entries
      sizes%factor_operations = factor%operations
      sizes%elimination_entries = bordered(1)%entries
      sizes%elimination_operations = bordered(1)%operations
      sizes%largest_front = bordered(1)%largest_column
      sizes%named_entries = bordered(2)%entries
      sizes%named_operations = bordered(2)%operations
      sizes%named_front = bordered(2)%largest_column
      if (problem%flow%is_there()) call measure_flow(problem, sizes)
    end associate
  end subroutine measure_problem

  !> Sets the sizes of the bodies where materials flow. Their share of the factor is that of compact bodies.
  pure subroutine measure_flow(problem, sizes)
    type(problem_t), intent(in) :: problem
    type(problem_size_t), intent(inout) :: sizes
    type(factor_size_t) :: factors(problem%motions%n_bodies)
    logical :: body_flows(problem%motions%n_bodies), dof_flows(sizes%n_dofs)
    integer :: i

    associate (n_dim => problem%mesh%n_dim, bodies => problem%motions%body_of_node, rows => problem%force_rows)
      dof_flows = dofs_of_flowing_bodies(problem%mesh, problem%body, bodies)
      do i = 1, size(factors)
        factors(i) = compact_factor(n_dim, n_dim * count(bodies == i))
        body_flows(i) = dof_flows(n_dim * findloc(bodies, i, dim=1))
      end do
      sizes%n_flow_points = size(problem%flow%temperatures, 1)
      sizes%n_flow_dofs = count(dof_flows)
      sizes%n_flow_multipliers = count([(any(dof_flows(rows%dofs(rows%offsets(i) + 1:rows%offsets(i + 1)))), i=1, rows%n_rows)])
    end associate
    sizes%flow_factor_entries = sizes%factor_entries * sum(factors%entries, mask=body_flows) / sum(factors%entries)
    sizes%flow_factor_operations = sizes%factor_operations * sum(factors%operations, mask=body_flows) / sum(factors%operations)
  end subroutine measure_flow

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
end module sig_problem_loading
