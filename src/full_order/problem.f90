! SPDX-License-Identifier: BSD-3-Clause
!> The full-order problem of a deck and its mesh, before anything is solved.
module sig_problem
  use sig_boundary_conditions, only: boundary_conditions_t
  use sig_contact_laws, only: contact_laws_t
  use sig_contact_rows, only: contact_rows_t
  use sig_deck_box, only: names_of
  use sig_deck_config, only: deck_config_t, name_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_elimination_plan, only: elimination_plan_t
  use sig_errors, only: error_t
  use sig_flow_model, only: flow_model_t
  use sig_idle_work, only: idle_work_t
  use sig_imposed_strain, only: imposed_strains_t, strain_field_t
  use sig_kinds, only: rk
  use sig_materials, only: set_materials
  use sig_mesh, only: mesh_t
  use sig_mesh_checks, only: nodes_of_boundary
  use sig_rigid_motions, only: rigid_motions_t
  use sig_solver_costs, only: problem_size_t
  use sig_solver_plan, only: solver_plan_t
  use sig_stiffness_terms, only: stiffness_term_t
  use sig_term_set, only: term_set_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: problem_t, body_at, named_nodes, strains_at, surface_of_side, parameter_names, parameter_units

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
    !> laws of the materials that flow
    type(flow_model_t) :: flow
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
    !> terms of the coefficients of friction, 1 where there is none; shape (size(deck%contact))
    integer, allocatable :: friction_terms(:)
    !> terms of the motions of obstacles with friction, 0 where they stand still; shape (n_dim, size(contact))
    integer, allocatable :: motion_terms(:, :)
    !> normal rows of the contacts, and inert rows, whose displacements are all prescribed
    type(contact_rows_t) :: rows
    type(contact_rows_t) :: inert
    !> rows with a multiplier: `rows`, then tangential rows
    type(contact_rows_t) :: force_rows
    type(contact_laws_t) :: laws
    !> which solver is taken, and why
    type(solver_plan_t) :: plan
    !> what the costs of solvers depend on
    type(problem_size_t) :: sizes
    !> what an elimination for W gives beside it, and where it is kept
    type(elimination_plan_t) :: elimination
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
  contains
    procedure :: remembers
  end type problem_t

contains

  !> Whether a state depends on those before it in its history: friction, or materials that flow.
  pure logical function remembers(self)
    class(problem_t), intent(in) :: self

    remembers = self%laws%remembers() .or. self%flow%is_there()
  end function remembers

  !> Returns which nodes belong to the boundaries whose exact displacements the deck wants (reduction.displacement). That the mesh
  !> has these boundaries was checked before.
  function named_nodes(problem) result(is_named)
    type(problem_t), intent(in) :: problem
    !> shape (n_nodes)
    logical :: is_named(problem%mesh%n_nodes)
    type(error_t), allocatable :: error
    integer, allocatable :: nodes(:)
    integer :: i

    is_named = .false.
    associate (boundaries => problem%deck%reduction%displacement%boundaries)
      do i = 1, size(boundaries)
        call nodes_of_boundary(problem%mesh, boundaries(i), problem%deck%path, nodes, error)
        if (.not. allocated(error)) is_named(nodes) = .true.
      end do
    end associate
  end function named_nodes

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

  !> Returns the names of the parameters in the deck's order.
  pure function parameter_names(deck) result(names)
    type(deck_config_t), intent(in) :: deck
    type(string_t), allocatable :: names(:)

    names = names_of(deck%state_parameters)
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
