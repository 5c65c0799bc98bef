! SPDX-License-Identifier: BSD-3-Clause
!> Chooses the solver: that of the deck, or for `auto` the one that is predicted to take the least time within the memory.
module sig_solver_plan
  use sig_deck_config, only: solver_config_t
  use sig_kinds, only: rk
  use sig_memory, only: memory_text
  use sig_solver_costs, only: condensed_cost, cost_t, dense_bytes, elimination_cost, &
    factorization_cost, multigrid_cost, newton_cost, point_cost, problem_size_t, refactoring_cost, sets, sets_of_friction, &
    solves_cost, operator(+), times
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: solver_plan_t, make_solver_plan, plan_text, fits_condensed, sweep_cost

  !> The solver that was chosen, and why.
  type :: solver_plan_t
    !> condensed, active_set or snesvi
    character(:), allocatable :: type
    !> cholesky or gamg
    character(:), allocatable :: linear
    !> whether one factorization of the stiffness has room in the memory, and the deck does not ask for multigrid
    logical :: may_factor = .true.
    !> whether the dense problem of all contacts can be made: by such a factorization or by an elimination
    logical :: may_condense = .true.
    !> reason of the choice, as text for a message
    character(:), allocatable :: why
  end type solver_plan_t

  !> One of the solvers that `auto` chooses from.
  type :: candidate_t
    character(10) :: type = ''
    character(8) :: linear = ''
    !> for all points
    type(cost_t) :: cost
    !> whether the deck allows it
    logical :: is_allowed = .false.
  end type candidate_t

  character(*), parameter :: own_dofs = 'active_set needs, at each contact with friction or a tie, a node of no other contact ' // &
    'that is free to move along the normal and the tangents'

contains

  !> Chooses solver and linear solver: those of the deck, or for `auto` the fastest by prediction. message is allocated if the deck
  !> asks for something that is not possible: condensed where its dense matrix has no room in the memory; snesvi with friction
  !> or ties, where only contact holds a body, or with gamg and a PETSc before 3.19; active_set where contacts with friction or
  !> ties lack dofs of their own; with friction or ties where materials flow another one than condensed. Otherwise it is not
  !> allocated.
  subroutine make_solver_plan(config, sizes, plan, message)
    !> section solver of the deck
    type(solver_config_t), intent(in) :: config
    type(problem_size_t), intent(in) :: sizes
    type(solver_plan_t), intent(out) :: plan
    !> sentence for the user
    character(:), allocatable, intent(out) :: message
    type(cost_t) :: eliminated, factored

    plan%type = config%type
    plan%linear = config%linear
    factored = factorization_cost(sizes)
    plan%may_factor = config%linear /= 'gamg' .and. factored%bytes <= sizes%memory
    eliminated = elimination_cost(sizes)
    plan%may_condense = plan%may_factor .or. eliminated%bytes <= sizes%memory
    plan%why = 'as the deck says'
    if (.not. sizes%has_plain_contact .and. sizes%n_flow_points > 0) then
      call take_condensed(config, sizes, plan, message)
      return
    end if
    if (plan%linear == 'auto' .and. plan%type == 'snesvi') plan%linear = 'cholesky'
    if (plan%type == 'auto' .or. plan%linear == 'auto') call take_fastest(candidates_of(config, sizes), sizes, plan)
    if (config%type == 'condensed' .and. dense_bytes(sizes) > sizes%memory) then
      message = 'the matrix of the condensed solver takes ' // memory_text(dense_bytes(sizes)) // ' for ' // &
        to_text(sizes%n_multipliers) // ' multipliers, and there is room for ' // memory_text(sizes%memory) // &
        '; solver.type must be active_set' // trim(merge(', snesvi', '        ', sizes%has_plain_contact)) // ' or auto'
    else if (plan%type == 'active_set' .and. sizes%lacks_own_dofs) then
      message = own_dofs // '; solver.type must be condensed or auto'
    else if (plan%type == 'condensed' .and. sizes%lacks_own_dofs .and. dense_bytes(sizes) > sizes%memory) then
      message = own_dofs // ', and the matrix of the condensed solver takes ' // memory_text(dense_bytes(sizes)) // &
        ' where there is room for ' // memory_text(sizes%memory)
    else if (plan%type == 'snesvi' .and. .not. sizes%has_plain_contact) then
      message = 'snesvi solves neither friction nor tied contacts; solver.type must be condensed, active_set or auto'
    else if (plan%type == 'snesvi' .and. sizes%is_floating) then
      message = 'snesvi cannot solve a problem in which contact alone holds a body; ' // &
        'solver.type must be active_set, condensed or auto'
    else if (plan%type == 'snesvi' .and. plan%linear == 'gamg' .and. .not. sizes%has_multigrid_vi) then
      message = 'snesvi needs PETSc 3.19 or later for gamg; solver.linear must be cholesky, or solver.type active_set'
    end if
  end subroutine make_solver_plan

  !> Takes the condensed solver, the only one for friction and ties where materials flow. message: the deck asks for another one, or
  !> its matrix has no room in the memory.
  pure subroutine take_condensed(config, sizes, plan, message)
    type(solver_config_t), intent(in) :: config
    type(problem_size_t), intent(in) :: sizes
    type(solver_plan_t), intent(inout) :: plan
    character(:), allocatable, intent(out) :: message

    plan%type = 'condensed'
    plan%linear = 'cholesky'
    if (config%type == 'auto') plan%why = 'the one that solves friction and tied contacts where materials flow, predicted ' // &
      cost_text(sweep_cost(plan%type, plan%linear, sizes, max(1, sizes%n_points)))
    if (all(config%type /= [character(9) :: 'auto', 'condensed'])) then
      message = config%type // ' solves neither friction nor tied contacts where materials flow; solver.type must be ' // &
        'condensed or auto'
    else if (config%linear == 'gamg') then
      message = 'where materials flow, friction and tied contacts need the condensed solver, which factors the stiffness; ' // &
        'solver.linear must be cholesky or auto'
    else if (dense_bytes(sizes) > sizes%memory) then
      message = 'where materials flow, friction and tied contacts need the condensed solver, whose matrix takes ' // &
        memory_text(dense_bytes(sizes)) // ' for ' // to_text(sizes%n_multipliers) // ' forces, and there is room for ' // &
        memory_text(sizes%memory)
    end if
  end subroutine take_condensed

  !> Lists the solvers, with their costs for all points that share a stiffness. Where a model needs the response to each multiplier
  !> in any case, its training has these costs, too.
  pure function candidates_of(config, sizes) result(candidates)
    type(solver_config_t), intent(in) :: config
    type(problem_size_t), intent(in) :: sizes
    type(candidate_t) :: candidates(4)
    type(cost_t) :: of_training
    integer :: i, n

    n = max(1, sizes%n_points)
    candidates = [candidate_t('condensed', 'cholesky'), candidate_t('active_set', 'cholesky'), candidate_t('active_set', 'gamg'), &
      candidate_t('condensed', 'gamg')]
    of_training = condensed_cost(sizes)
    if (.not. has_room(of_training, sizes)) of_training = condensed_cost(sizes, 'gamg')
    do i = 1, size(candidates)
      candidates(i)%cost = sweep_cost(trim(candidates(i)%type), trim(candidates(i)%linear), sizes, n)
      if (sizes%needs_responses .and. candidates(i)%type /= 'condensed') &
        candidates(i)%cost = candidates(i)%cost + of_training
    end do
    candidates%is_allowed = (config%type == 'auto' .or. candidates%type == config%type) .and. &
      (config%linear == 'auto' .or. candidates%linear == config%linear)
    ! Newton's method factors the bodies that flow. Otherwise a factor serves the displacements of a model, too, and multigrid
    ! converges slowly where a body has supports at single nodes instead of contact
    if (sizes%n_flow_points > 0) candidates(4)%is_allowed = .false.
    if ((sizes%needs_responses .or. sizes%is_floating) .and. candidates(1)%is_allowed .and. has_room(candidates(1)%cost, sizes)) &
      candidates(4)%is_allowed = .false.
    ! where only contact holds a body, contacts may change all at once, and condensed finds answers that active_set does not
    if (.not. sizes%has_plain_contact .and. sizes%is_floating .and. config%type == 'auto' .and. candidates(1)%is_allowed) &
      candidates(2:3)%is_allowed = .not. has_room(candidates(1)%cost, sizes)
    if (sizes%lacks_own_dofs .and. config%type == 'auto') candidates(2:3)%is_allowed = .false.
  end function candidates_of

  !> Returns the cost of the solutions at some points that share a stiffness, or of some states where materials flow.
  pure type(cost_t) function sweep_cost(type, linear, sizes, n_points) result(cost)
    !> condensed, active_set or snesvi, which counts as active_set
    character(*), intent(in) :: type
    !> cholesky or gamg
    character(*), intent(in) :: linear
    type(problem_size_t), intent(in) :: sizes
    integer, intent(in) :: n_points

    if (sizes%n_flow_points > 0) then
      cost = newton_cost(type, linear, sizes, n_points)
    else if (type == 'condensed') then
      cost = condensed_cost(sizes, linear) + times(n_points, point_cost(sizes, linear))
    else if (linear == 'gamg') then
      cost = multigrid_cost(sizes, n_points, merge(sets, sets_of_friction, sizes%has_plain_contact))
    else
      cost = refactoring_cost(sizes, n_points)
    end if
  end function sweep_cost

  !> Takes the fastest of the allowed candidates that have room in the memory, or, if none has, the one that needs least of it.
  pure subroutine take_fastest(candidates, sizes, plan)
    type(candidate_t), intent(in) :: candidates(:)
    type(problem_size_t), intent(in) :: sizes
    type(solver_plan_t), intent(inout) :: plan
    logical :: is_possible(size(candidates))
    integer :: best, i

    is_possible = candidates%is_allowed .and. has_room(candidates%cost, sizes)
    if (any(is_possible)) then
      best = minloc(candidates%cost%seconds, dim=1, mask=is_possible)
    else
      best = minloc(candidates%cost%bytes, dim=1, mask=candidates%is_allowed)
    end if
    plan%type = trim(candidates(best)%type)
    plan%linear = trim(candidates(best)%linear)
    plan%why = 'predicted ' // cost_text(candidates(best)%cost)
    do i = 1, size(candidates)
      if (i == best .or. .not. candidates(i)%is_allowed) cycle
      plan%why = plan%why // '; ' // trim(candidates(i)%type) // ', ' // trim(candidates(i)%linear) // ': ' // &
        cost_text(candidates(i)%cost)
      if (.not. has_room(candidates(i)%cost, sizes)) plan%why = plan%why // ', more than there is room for'
    end do
  end subroutine take_fastest

  !> Whether the memory suffices. Where the points are shared out to groups of ranks, each group has a solver of its own.
  elemental logical function has_room(cost, sizes)
    type(cost_t), intent(in) :: cost
    type(problem_size_t), intent(in) :: sizes

    has_room = cost%bytes * max(1, min(sizes%n_ranks, sizes%n_points)) <= sizes%memory
  end function has_room

  !> Returns a cost as text: `12 s and 1.3 GB`, `less than 1 s and 20 MB`.
  pure function cost_text(cost) result(text)
    type(cost_t), intent(in) :: cost
    character(:), allocatable :: text

    text = 'less than 1 s'
    if (cost%seconds >= 1) text = to_text(int(min(cost%seconds, 1.0e9_rk))) // ' s'
    text = text // ' and ' // memory_text(cost%bytes)
  end function cost_text

  !> Whether W and the responses to all multipliers have room in the memory.
  pure logical function fits_condensed(sizes, n_copies)
    type(problem_size_t), intent(in) :: sizes
    !> how many times they are kept: on how many groups of ranks, times for how many stiffnesses; default: 1
    real(rk), intent(in), optional :: n_copies
    type(cost_t) :: responses
    real(rk) :: n_bytes

    responses = solves_cost(sizes, sizes%n_multipliers)
    n_bytes = dense_bytes(sizes) + responses%bytes
    if (present(n_copies)) n_bytes = n_bytes * n_copies
    fits_condensed = n_bytes <= sizes%memory
  end function fits_condensed

  !> Returns the plan as text for the log, as `solver: active_set, gamg: why`.
  pure function plan_text(plan) result(text)
    type(solver_plan_t), intent(in) :: plan
    character(:), allocatable :: text

    text = 'solver: ' // plan%type // ', ' // plan%linear // ': ' // plan%why
  end function plan_text
end module sig_solver_plan
