! SPDX-License-Identifier: BSD-3-Clause
!> Decides, before anything is solved, which kind of model a deck gets, and for which nodes a condensed model answers displacements.
module sig_condensed_plan
  use sig_body_constants, only: body_constants_t, find_body_constants, usual_nodes_of
  use sig_deck_config, only: deck_config_t, material_config_t, value_config_t
  use sig_errors, only: error_t, make_error
  use sig_flowing_cells, only: dofs_of_flowing_bodies
  use sig_kinds, only: rk
  use sig_elasticity, only: n_stresses
  use sig_memory, only: memory_text
  use sig_point_choice, only: most_rows
  use sig_problem, only: named_nodes, problem_t
  use sig_solver_costs, only: condensed_cost, cost_t, problem_size_t
  use sig_strain_force, only: has_numbers
  use sig_text, only: counted, join, short_number, string_t, to_text
  implicit none(type, external)
  private
  public :: check_flow, check_friction, choose_model_kind, displacement_plan_t, needs_displacements, plan_displacements
  public :: all_dofs_fit
  public :: why_not_condensed
  public :: inelastic_model_size, inelastic_training_size, law_place
  public :: model_size, most_references, number_size, place_of_friction, room_for_transforms, room_of

  !> What reduction.displacement of the deck means for a problem.
  type :: displacement_plan_t
    !> dofs with exact displacements, natural (order of the mesh file), ascending: all, none, or those of the named boundaries;
    !> with type auto all or none (keeps_all_dofs)
    integer, allocatable :: exact_dofs(:)
    !> boundaries that the deck names, unless `misses` says why they are not exact
    type(string_t), allocatable :: boundaries(:)
    !> whether the responses of the exact dofs come from the elimination that makes W
    logical :: is_eliminated = .false.
    !> why modes answer the boundaries that the deck names, too, as a sentence; empty where they are exact
    character(:), allocatable :: misses
    !> the displacements of the other dofs are answered by modes, or from compressed responses
    logical :: has_modes = .false.
  end type displacement_plan_t

  !> [MB] responses of all nodes, and strains at all points that correct, are kept as they are up to this size; compression would
  !> gain little
  real(rk), parameter, public :: small_size = 64
  !> usual number of modes of displacements where multigrid solves for them
  integer, parameter, public :: usual_modes = 100
  !> largest number of references, which have a pivot transform each; more make queries hardly faster
  integer, parameter :: most_references = 32
  !> largest numbers of inelastic modes, and of main directions of the stresses of inelastic strains that count in training
  integer, parameter, public :: most_modes = 100, most_stresses = 60
  !> [MB] of one number
  real(rk), parameter :: number_size = 8.0e-6_rk

contains

  !> Chooses the kind of the model. `tied` is chosen where W and q take more memory than reduction.max_full_order_size, if this is
  !> above 0, there are contact rows, the stiffness is fixed and may be factored, and no body is held by contact only, unless
  !> contacts have friction or ties. Whether a tied model is possible is known only when the snapshots are there. The choice is hhr
  !> where reduction.method asks for it, where
  !> the deck asks for clusters (a number other than 1, a target or refine), and where no other kind is possible.
  subroutine choose_model_kind(problem, kind, reason)
    type(problem_t), intent(in) :: problem
    !> condensed, interpolated (where the stiffness depends on the parameters), tied or hhr
    character(:), allocatable, intent(out) :: kind
    !> why it is not condensed or interpolated; empty where it is, where the deck asks for hhr, and where materials flow
    character(:), allocatable, intent(out) :: reason

    kind = 'hhr'
    reason = ''
    if (problem%flow%is_there()) then
      kind = 'inelastic'
      return
    end if
    if (.not. problem%laws%is_plain()) then
      ! check_friction refuses all that needs another kind
      kind = 'condensed'
      if (.not. problem%has_fixed_stiffness) kind = 'interpolated'
      if (.not. may_be_tied(problem)) return
      kind = 'tied'
      reason = why_not_condensed(problem)
      return
    end if
    associate (deck => problem%deck)
      if (deck%reduction%method == 'hhr') return
      if (deck%clusters%number /= 1 .or. deck%clusters%target%is_used .or. deck%clusters%refine%is_used) then
        reason = 'the deck asks for clusters'
        return
      end if
      reason = why_not_condensed(problem)
      if (.not. problem%has_fixed_stiffness) then
        if (reason == '') kind = 'interpolated'
      else if (reason == '') then
        kind = 'condensed'
      else if (may_be_tied(problem) .and. problem%motions%n_free == 0) then
        kind = 'tied'
      end if
    end associate
  end subroutine choose_model_kind

  !> Whether unknowns only at contacts that change may be the way out, because W and q have no room.
  pure logical function may_be_tied(problem)
    type(problem_t), intent(in) :: problem

    may_be_tied = problem%has_fixed_stiffness .and. problem%rows%n_rows > 0 .and. forces_size(problem) > room_of(problem) .and. &
      problem%deck%reduction%max_full_order_size > 0 .and. problem%plan%may_factor .and. .not. problem%sizes%lacks_own_dofs
  end function may_be_tied

  !> Errors: contacts have friction or are tied, and the deck asks for something that only a model without can do. The place is that
  !> of the first such contact.
  subroutine check_friction(problem, error)
    type(problem_t), intent(in) :: problem
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: reason, hint
    integer :: place(2)

    if (problem%laws%is_plain()) return
    reason = ''
    if (problem%flow%is_there() .or. .not. may_be_tied(problem)) reason = why_not_condensed(problem)
    hint = 'the command solve needs no model'
    associate (deck => problem%deck)
      if (deck%reduction%method == 'hhr') then
        reason = 'hyper-reduction solves for a part of the contacts, and the friction of the others acts on them'
        hint = 'take reduction.method: auto or condensed, which is exact with friction'
      else if (deck%clusters%number /= 1 .or. deck%clusters%target%is_used .or. deck%clusters%refine%is_used) then
        reason = 'clusters are those of hyper-reduction, which has no friction'
        hint = 'leave clusters out'
      else if (deck%greedy%is_used .and. .not. problem%flow%is_there()) then
        reason = 'a greedy selection asks a model at single points, which do not remember'
        hint = 'leave greedy out: a condensed model is exact whatever its training points are'
      end if
      if (reason == '') return
      place = place_of_friction(deck)
      call make_error(error, 'contacts have friction or are tied, but ' // reason, deck%path, place(1), place(2), hint=hint)
    end associate
  end subroutine check_friction

  !> Returns line and column of the first coefficient of friction, or of the first surface of a tied contact.
  pure function place_of_friction(deck) result(place)
    type(deck_config_t), intent(in) :: deck
    integer :: place(2)
    integer :: i

    place = 0
    do i = 1, size(deck%contact)
      associate (contact => deck%contact(i))
        if (contact%has_friction) place = [contact%friction%line, contact%friction%column]
        if (contact%tied /= 'false') place = [contact%first%line, contact%first%column]
      end associate
      if (any(place > 0)) return
    end do
  end function place_of_friction

  !> Errors: materials flow, and there cannot be a model of them; the place is that of the elastic constant that forbids it, or of
  !> the law of the first material that flows; those of find_body_constants. The deck itself refuses hyper-reduction.
  subroutine check_flow(problem, error)
    type(problem_t), intent(in) :: problem
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: reason, hint
    type(value_config_t) :: place

    if (.not. problem%flow%is_there()) return
    reason = why_not_condensed(problem)
    hint = 'the command solve needs no model'
    place = law_place(problem%deck)
    if (.not. problem%has_fixed_stiffness) then
      call check_constants(problem, place, reason, hint, error)
      if (allocated(error)) return
    end if
    if (reason /= '') call make_error(error, 'materials yield or creep, but ' // reason, problem%deck%path, place%line, &
      place%column, hint=hint)
  end subroutine check_flow

  !> Returns a value of the law of the first material that flows.
  pure type(value_config_t) function law_place(deck) result(place)
    type(deck_config_t), intent(in) :: deck
    integer :: i

    do i = 1, size(deck%materials)
      associate (material => deck%materials(i))
        if (material%plasticity%is_used) then
          place = material%plasticity%yield_stress
        else if (material%creep%is_used) then
          place = material%creep%coefficient
        end if
        if (material%flows()) return
      end associate
    end do
  end function law_place

  !> Finds what forbids a model of materials that flow in which elastic constants depend on parameters: a constant of a body that
  !> flows, whose modes and strains belong to one stiffness, or displacements by modes, which are those of elastic bodies. Nothing
  !> changes where there is neither. Errors: those of find_body_constants.
  subroutine check_constants(problem, place, reason, hint, error)
    type(problem_t), intent(in) :: problem
    type(value_config_t), intent(inout) :: place
    character(:), allocatable, intent(inout) :: reason
    !> out: begins with what to do
    character(:), allocatable, intent(inout) :: hint
    type(error_t), allocatable, intent(out) :: error
    type(body_constants_t), allocatable :: constants(:)
    type(displacement_plan_t) :: plan
    logical, dimension(size(problem%deck%materials)) :: is_refused, is_varying
    integer :: i

    call find_body_constants(problem, constants, error)
    if (allocated(error)) return
    plan = plan_displacements(problem, usual_nodes_of(constants))
    is_varying = .not. has_numbers(problem%deck%materials)
    is_refused = is_varying .and. materials_of_flowing_bodies(problem)
    if (any(is_refused)) then
      i = findloc(is_refused, .true., dim=1)
      reason = constant_text(problem%deck%materials(i)) // ' depends on parameters, and a body with this material yields or ' // &
        'creeps; the modes of a model belong to one stiffness of this body'
      hint = 'give it as a number; elastic constants of bodies that stay elastic may depend on parameters; ' // hint
    else if (plan%has_modes) then
      i = findloc(is_varying, .true., dim=1)
      reason = constant_text(problem%deck%materials(i)) // ' depends on parameters, and there are no displacements by modes ' // &
        'then (reduction.displacement)'
      if (problem%deck%reduction%displacement%type == 'auto') reason = reason // '; those of all nodes take ' // &
        short_number(usual_nodes_of(constants) * fields_size(problem), 2) // ' MB, and reduction.max_full_order_size is ' // &
        short_number(problem%deck%reduction%max_full_order_size, 2) // ' MB'
      hint = 'take a larger reduction.max_full_order_size, or name the boundaries where displacements are needed: ' // &
        'reduction: {displacement: {boundaries: [...]}}; ' // hint
    else
      return
    end if
    place = problem%deck%materials(i)%poisson_ratio
    if (.not. problem%deck%materials(i)%young_modulus%is_constant) place = problem%deck%materials(i)%young_modulus
  end subroutine check_constants

  !> Returns the key path of the elastic constant of a material that is not a number, the modulus if neither is.
  pure function constant_text(material) result(text)
    type(material_config_t), intent(in) :: material
    character(:), allocatable :: text

    text = 'materials.' // material%name // '.poisson_ratio'
    if (.not. material%young_modulus%is_constant) text = 'materials.' // material%name // '.young_modulus'
  end function constant_text

  !> Returns whether a body in which something flows has cells of each material, shape (n_materials).
  pure function materials_of_flowing_bodies(problem) result(is_there)
    type(problem_t), intent(in) :: problem
    logical :: is_there(size(problem%deck%materials))
    logical, allocatable :: flows(:)
    integer :: i

    is_there = .false.
    associate (mesh => problem%mesh, body => problem%body)
      flows = dofs_of_flowing_bodies(mesh, body, problem%motions%body_of_node)
      do i = 1, mesh%n_cells
        if (flows(mesh%n_dim * mesh%cell_nodes(mesh%cell_offsets(i) + 1))) is_there(body%material_of_cell(i)) = .true.
      end do
    end associate
  end function materials_of_flowing_bodies

  !> Returns why the problem of the deck cannot be condensed, as a part of a sentence; empty where it can. Reasons: there is no
  !> contact row; W and q take more memory than reduction.max_full_order_size; the stiffness is too large; it changes with elastic
  !> constants or flow, and must not be factored, because it is too large or solver.linear is gamg.
  function why_not_condensed(problem) result(reason)
    type(problem_t), intent(in) :: problem
    character(:), allocatable :: reason

    reason = ''
    associate (room => room_of(problem))
      if (problem%rows%n_rows == 0) then
        reason = 'there is no contact with a free displacement'
      else if (forces_size(problem) > room) then
        reason = 'the matrix of all contacts takes ' // short_number(forces_size(problem), 2) // ' MB, more than ' // &
          'reduction.max_full_order_size allows (' // short_number(room, 2) // ' MB)'
      else if (.not. problem%plan%may_condense) then
        reason = 'the stiffness is too large to factor, and so are its displacements to be eliminated'
      else if (.not. problem%plan%may_factor .and. &
               (problem%flow%is_there() .or. .not. problem%has_fixed_stiffness)) then
        reason = 'the stiffness is too large to factor, or solver.linear is gamg'
      end if
    end associate
  end function why_not_condensed

  !> [MB] Returns the largest size of W and q: reduction.max_full_order_size; where this is auto, a third of it, because answers
  !> need work space of that size, and pivot transforms. With friction and ties W is taken as long as it has room: its model alone
  !> has answers for all histories.
  pure real(rk) function room_of(problem) result(room)
    type(problem_t), intent(in) :: problem

    room = problem%deck%reduction%max_full_order_size
    if (problem%deck%reduction%is_size_auto .and. problem%laws%is_plain()) room = room / 3
  end function room_of

  !> [MB] Returns the largest size of all pivot transforms: reduction.max_transforms_size; where this is auto, a third of
  !> reduction.max_full_order_size.
  pure real(rk) function room_for_transforms(problem) result(room)
    type(problem_t), intent(in) :: problem

    associate (reduction => problem%deck%reduction)
      room = reduction%max_transforms_size
      if (reduction%is_transforms_size_auto) room = reduction%max_full_order_size / 3
    end associate
  end function room_for_transforms

  !> [MB] Returns the memory for W and q (of all terms). One MB is 1e6 bytes.
  pure real(rk) function forces_size(problem)
    type(problem_t), intent(in) :: problem

    associate (n_rows => real(problem%force_rows%n_rows, rk))
      forces_size = number_size * n_rows * (n_rows + problem%boundary%n_terms)
    end associate
  end function forces_size

  !> [byte] Returns the largest size of a condensed model: W, q, pivot transforms, and displacements.
  real(rk) function model_size(problem) result(n_bytes)
    type(problem_t), intent(in) :: problem
    real(rk), parameter :: bytes_per_megabyte = 1.0e6_rk
    type(displacement_plan_t) :: plan
    real(rk) :: megabytes, per_dof

    plan = plan_displacements(problem)
    associate (reduction => problem%deck%reduction, n_rows => real(problem%force_rows%n_rows, rk))
      megabytes = forces_size(problem) + min(room_for_transforms(problem), most_references * number_size * n_rows**2)
      per_dof = number_size * (n_rows + problem%boundary%n_terms)
      megabytes = megabytes + size(plan%exact_dofs) * per_dof
      if (plan%has_modes) megabytes = megabytes + &
        min(problem%mesh%n_dim * problem%mesh%n_nodes * per_dof, reduction%max_full_order_size)
    end associate
    n_bytes = bytes_per_megabyte * megabytes
  end function model_size

  !> [byte] Returns the largest size of a model of materials that flow, without the mesh for fields: a condensed model, modes, and
  !> strains at all points. Those of contact forces are counted in single precision; their compression is known only when it is
  !> done.
  real(rk) function inelastic_model_size(problem) result(n_bytes)
    type(problem_t), intent(in) :: problem
    real(rk), parameter :: single = 4, double = 8
    real(rk) :: n_points, n_strains

    n_points = problem%sizes%n_flow_points
    n_strains = problem%body%mechanics%n_strains * n_points
    n_bytes = model_size(problem) + single * n_strains * problem%force_rows%n_rows + double * (n_strains * &
      (problem%boundary%n_terms + most_modes) + n_stresses * n_points * problem%strains%terms%n_terms() + &
      real(most_modes, rk) * problem%mesh%n_dim * problem%mesh%n_nodes)
  end function inelastic_model_size

  !> [byte] Returns the memory of each rank for the training of such a model: strains of contact forces at all points and a copy of
  !> them, stresses of all states at these points, what each point adds to the work of stresses on modes, and displacements.
  real(rk) function inelastic_training_size(problem, n_states) result(n_bytes)
    type(problem_t), intent(in) :: problem
    !> number of training points, each with all its times
    integer, intent(in) :: n_states
    real(rk), parameter :: double = 8
    real(rk) :: n_points

    n_points = problem%sizes%n_flow_points
    n_bytes = inelastic_model_size(problem) + double * (problem%body%mechanics%n_strains * n_points * &
      (2 * problem%force_rows%n_rows + real(n_states, rk) + most_stresses) + 2 * n_points * most_rows + &
      2 * real(n_states, rk) * problem%mesh%n_dim * problem%mesh%n_nodes)
  end function inelastic_training_size

  !> Whether reduction.max_full_order_size allows the memory for W, q, and the displacements of all nodes per term and per contact
  !> row. Only these displacements count n_nodes times.
  pure logical function all_dofs_fit(problem, n_nodes)
    type(problem_t), intent(in) :: problem
    !> number of interpolation nodes at which these displacements are kept; default: one
    real(rk), intent(in), optional :: n_nodes
    real(rk) :: n

    n = 1
    if (present(n_nodes)) n = n_nodes
    all_dofs_fit = forces_size(problem) + n * fields_size(problem) <= problem%deck%reduction%max_full_order_size
  end function all_dofs_fit

  !> [MB] Returns the memory for the displacements of all nodes per term and per contact row.
  pure real(rk) function fields_size(problem)
    type(problem_t), intent(in) :: problem

    fields_size = number_size * problem%mesh%n_dim * problem%mesh%n_nodes * &
      (real(problem%force_rows%n_rows, rk) + problem%boundary%n_driving_terms)
  end function fields_size

  !> Whether a model keeps the responses of all dofs as they are: where elastic constants vary (n_nodes is given), if they fit; else
  !> if they fit and are small, or the deck wants no error (reduction.displacement_tolerance: 0). Where multigrid solves for them,
  !> they are kept if that takes no more solutions than modes do.
  pure logical function keeps_all_dofs(problem, n_nodes)
    type(problem_t), intent(in) :: problem
    !> as in all_dofs_fit
    real(rk), intent(in), optional :: n_nodes
    logical :: is_cheap

    keeps_all_dofs = all_dofs_fit(problem, n_nodes)
    if (present(n_nodes)) return
    is_cheap = fields_size(problem) <= small_size .and. &
      (problem%plan%may_factor .or. problem%force_rows%n_rows <= usual_modes)
    keeps_all_dofs = keeps_all_dofs .and. (is_cheap .or. .not. problem%deck%reduction%displacement_tolerance > 0)
  end function keeps_all_dofs

  !> Returns at which dofs a condensed model answers displacements exactly, and whether modes answer them at the others. This
  !> follows from reduction.displacement. With its type auto all dofs are exact where keeps_all_dofs; otherwise none is exact, and
  !> there are modes or compressed responses. Without a factor the boundaries that the deck names are exact only where the
  !> elimination of their dofs has room; otherwise there are modes.
  function plan_displacements(problem, n_nodes, has_error) result(plan)
    type(problem_t), intent(in) :: problem
    !> as in all_dofs_fit
    real(rk), intent(in), optional :: n_nodes
    !> whether the error of interpolated displacements would be known; default: yes. That of modes is, so that they are taken where
    !> it is not, unless the deck wants no error (reduction.displacement_tolerance: 0)
    logical, intent(in), optional :: has_error
    type(displacement_plan_t) :: plan
    logical :: is_exact(problem%mesh%n_nodes), keeps_all
    integer :: i, n_dim

    keeps_all = keeps_all_dofs(problem, n_nodes)
    if (present(has_error)) keeps_all = keeps_all .and. &
      (has_error .or. .not. problem%deck%reduction%displacement_tolerance > 0)
    plan%misses = ''
    associate (deck => problem%deck%reduction%displacement)
      is_exact = deck%type == 'auto' .and. keeps_all
      plan%has_modes = deck%type == 'auto' .and. .not. keeps_all
      allocate (plan%boundaries(size(deck%boundaries)))
      do i = 1, size(deck%boundaries)
        plan%boundaries(i)%text = deck%boundaries(i)%text
      end do
      is_exact = is_exact .or. named_nodes(problem)
      if (deck%type == 'boundaries') plan%has_modes = deck%elsewhere == 'modes'
    end associate
    if (needs_elimination(problem)) call plan_boundaries(problem, is_exact, plan)
    n_dim = problem%mesh%n_dim
    plan%exact_dofs = pack([(i, i=1, n_dim * size(is_exact))], reshape(spread(is_exact, 1, n_dim), [n_dim * size(is_exact)]))
  end function plan_displacements

  !> Whether the exact displacements of boundaries that the deck names come from an elimination: without a factor each contact would
  !> take a solution by multigrid. Idle motions, which an elimination does not know, are left out of the solutions.
  pure logical function needs_elimination(problem)
    type(problem_t), intent(in) :: problem

    needs_elimination = size(problem%deck%reduction%displacement%boundaries) > 0 .and. problem%sizes%n_named_dofs > 0 .and. &
      problem%has_fixed_stiffness .and. .not. problem%flow%is_there() .and. .not. problem%plan%may_factor .and. &
      problem%motions%idle%n == 0
  end function needs_elimination

  !> Decides whether the elimination of the named dofs beside the contacts has room; if not, takes modes instead.
  subroutine plan_boundaries(problem, is_exact, plan)
    type(problem_t), intent(in) :: problem
    !> shape (n_nodes)
    logical, intent(inout) :: is_exact(:)
    type(displacement_plan_t), intent(inout) :: plan
    type(problem_size_t) :: sizes
    type(cost_t) :: cost

    sizes = problem%sizes
    sizes%keeps_named_dofs = .true.
    cost = condensed_cost(sizes, 'gamg')
    plan%is_eliminated = cost%bytes <= sizes%memory
    if (plan%is_eliminated) return
    plan%misses = 'displacements of ' // join(plan%boundaries, ', ') // ' are not exact, but by modes: to eliminate their ' // &
      to_text(sizes%n_named_dofs) // ' dofs beside ' // counted(sizes%n_multipliers, 'contact force') // ' takes ' // &
      memory_text(cost%bytes) // ', and there is room for ' // memory_text(sizes%memory)
    plan%boundaries = plan%boundaries(:0)
    plan%has_modes = .true.
    is_exact = .false.
  end subroutine plan_boundaries

  !> Whether training, or a greedy selection of its points, needs the displacements of the snapshots, or they are kept to compare
  !> with. False only if it is certain that the contact forces are enough.
  logical function needs_displacements(problem)
    type(problem_t), intent(in) :: problem
    character(:), allocatable :: kind, reason

    call choose_model_kind(problem, kind, reason)
    needs_displacements = problem%deck%greedy%is_used
    if (kind == 'inelastic') then
      needs_displacements = .true.
    else if (kind == 'interpolated') then
      ! modes come from the model's own displacements; those of the snapshots are there to compare with
      associate (displacement => problem%deck%reduction%displacement)
        needs_displacements = needs_displacements .or. displacement%type == 'auto' .or. displacement%elsewhere == 'modes'
      end associate
    else if (kind == 'hhr' .or. (kind == 'tied' .and. problem%deck%reduction%method == 'auto' .and. problem%laws%is_plain())) then
      ! method auto: hyper-reduction is used where the tied model is not possible, unless there is friction
      needs_displacements = .true.
    end if
  end function needs_displacements
end module sig_condensed_plan
