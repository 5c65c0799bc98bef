! SPDX-License-Identifier: BSD-3-Clause
!> Predicts time and memory of what solvers do: a factorization of K, solves with it, and a solution by multigrid.
!>
!> Times are processor times of one core of 2023 with a fast BLAS, divided by what several ranks gain. They are constants, not
!> measurements, so that every rank and every run chooses alike. tests/benchmark/solver_grid.py compares them with measured times.
module sig_solver_costs
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: cost_t, problem_size_t, comparison_cost, condensed_cost, dense_bytes, elimination_cost, factorization_cost
  public :: multigrid_cost, point_cost
  public :: newton_cost, refactoring_cost, solves_cost, steps_cost, operator(+), times

  !> What something takes: [s] on each rank, and [byte] on all ranks together.
  type :: cost_t
    real(rk) :: seconds = 0
    real(rk) :: bytes = 0
  end type cost_t

  !> One after the other: times add up, the larger memory counts.
  interface operator(+)
    module procedure add_costs
  end interface operator(+)

  !> The sizes that solvers depend on.
  type :: problem_size_t
    integer :: n_dim = 0
    integer :: n_dofs = 0
    integer :: n_multipliers = 0
    !> number of parameter points that share a stiffness, in the deck's set of points where it is largest
    integer :: n_points = 0
    !> number of ranks that solve a point together
    integer :: n_ranks = 1
    !> whether the response to each multiplier is needed in any case, for the training of a condensed model
    logical :: needs_responses = .false.
    !> [byte] memory that all ranks may take together; default: no limit
    real(rk) :: memory = huge(1.0_rk)
    !> largest Young's modulus over the smallest
    real(rk) :: stiffness_ratio = 1
    !> number of entries of K
    real(rk) :: stiffness_entries = 0
    !> number of entries of its factor, and of operations of a factorization
    real(rk) :: factor_entries = 0
    real(rk) :: factor_operations = 0
    !> the same of the elimination of all displacements, which leaves W, and number of entries of its largest column
    real(rk) :: elimination_entries = 0
    real(rk) :: elimination_operations = 0
    real(rk) :: largest_front = 0
    !> number of free dofs of the boundaries whose exact displacements the deck wants, and the same three figures of an elimination
    !> that keeps them beside the contacts
    integer :: n_named_dofs = 0
    real(rk) :: named_entries = 0
    real(rk) :: named_operations = 0
    real(rk) :: named_front = 0
    !> whether the elimination is this one
    logical :: keeps_named_dofs = .false.
    !> number of integration points of materials that flow
    integer :: n_flow_points = 0
    !> of the bodies where materials flow, as above: dofs, multipliers that press on them, factor
    integer :: n_flow_dofs = 0
    integer :: n_flow_multipliers = 0
    real(rk) :: flow_factor_entries = 0
    real(rk) :: flow_factor_operations = 0
    !> whether the elements are of second order
    logical :: is_quadratic = .false.
    !> whether a body is held by contact alone
    logical :: is_floating = .false.
    !> whether contacts only open and close: no friction, none tied
    logical :: has_plain_contact = .true.
    !> whether contacts may slip with friction, so that points are the states of histories
    logical :: has_friction = .false.
    !> whether a contact with friction or a tie has too few free dofs of its own for active_set
    logical :: lacks_own_dofs = .false.
    !> whether PETSc's SNESVI works with multigrid
    logical :: has_multigrid_vi = .false.
  end type problem_size_t

  ! In space the ordering that MUMPS finds gives 1.2 times the entries and 1.3 times the operations of nested dissection by METIS.
  ! The constants of MUMPS contain these factors.

  !> [s] MUMPS: ordering and analysis per dof, assembly per entry of the factor, and one operation
  real(rk), parameter :: analysis = 4.0e-6_rk, per_factor_entry = 2.3e-8_rk, per_operation = 5.3e-11_rk
  !> [s] a solve, per entry of the factor and per dof: a single right-hand side, and each of many at once
  real(rk), parameter :: single_solve(2) = [2.0e-9_rk, 3.0e-7_rk], joint_solve(2) = [1.05e-10_rk, 3.4e-8_rk]
  !> number of right-hand sides from which on they count as many
  integer, parameter :: many = 8
  !> [byte] MUMPS: per entry of the factor, with workspace, and per entry of K
  real(rk), parameter :: factor_bytes = 17.0_rk, stiffness_bytes = 40.0_rk
  !> [byte] MUMPS without a factor: fronts that wait for each other, per entry of the largest one
  real(rk), parameter :: front_bytes = 30.0_rk
  !> [s] multigrid with linear and with quadratic elements: first levels per entry of K, levels of an active set per dof
  real(rk), parameter :: levels(2) = [3.0e-7_rk, 1.0e-7_rk], levels_of_set(2) = [2.0e-6_rk, 1.0e-6_rk]
  !> [s] one iteration of conjugate gradients with multigrid, per entry of K and per dof
  real(rk), parameter :: iteration(2) = [4.5e-9_rk, 2.1e-7_rk]
  !> usual number of active sets of a point, and of iterations for each of them, in the plane and in space
  integer, parameter, public :: sets = 8
  integer, parameter :: iterations(2:3) = [15, 8]
  !> the same of a time of a history with friction, which begins with the states of the time before: more sets, but fewer iterations
  !> for each of them, together as much as so many sets
  integer, parameter, public :: sets_of_friction = 4
  !> ratio of moduli from which on multigrid needs more iterations, in proportion to the root of what is beyond
  real(rk), parameter :: harmless_ratio = 100
  !> from one active set to the next a factor is made anew, or serves as the preconditioner of at most so many solves
  integer, parameter :: solves_per_set = 40
  !> [-] the condensed solver keeps its responses if they take at most this share of the memory: a sixteenth of the machine's
  real(rk), parameter :: share_of_responses = 0.1_rk
  !> [byte] multigrid, per entry of K and per dof
  real(rk), parameter :: multigrid_bytes(2) = [22.0_rk, 1700.0_rk]
  !> [s] of one operation of a dense product, and n^3 of them for a dense problem with n unknowns, half of them closed
  real(rk), parameter :: per_dense_operation = 5.0e-11_rk, dense_share = 0.3_rk
  !> [s] of a state with friction: Newton's steps, and those that look for other solutions, which factor matrices of closed or open
  !> contacts. Per entry of W, in the plane and in space, where directions of slip change from step to step; and n^3 operations
  real(rk), parameter :: per_friction_entry(2:3) = [2.6e-8_rk, 7.5e-8_rk], friction_share = 1.5_rk
  !> [-] dense work of an answer of a model with friction, which does not look for other solutions, over that of a state
  real(rk), parameter :: share_of_answer = 0.4_rk
  !> usual number of steps of Newton's method for a time of a history where materials flow, of active sets in each of them
  !> (multigrid), and of factorizations; [s] of each step per integration point (laws, tangents and their assembly) and per entry
  !> of K (copies of it, whose supports are held)
  integer, parameter :: newton_steps = 5, sets_of_step = 2
  real(rk), parameter :: factors_of_step = 1.6_rk
  real(rk), parameter :: per_flow_point = 5.0e-6_rk, per_copied_entry = 4.0e-8_rk
  !> [s] errors of an answer and of its fields, per dof
  real(rk), parameter :: per_compared_dof = 4.0e-7_rk

contains

  pure type(cost_t) function add_costs(first, second) result(both)
    type(cost_t), intent(in) :: first
    type(cost_t), intent(in) :: second

    both = cost_t(first%seconds + second%seconds, max(first%bytes, second%bytes))
  end function add_costs

  !> The same again and again: the time grows, the memory does not.
  pure type(cost_t) function times(n, cost) result(all)
    integer, intent(in) :: n
    type(cost_t), intent(in) :: cost

    all = cost_t(n * cost%seconds, cost%bytes)
  end function times

  !> Returns the cost of one factorization of K by MUMPS, with its ordering.
  pure type(cost_t) function factorization_cost(sizes) result(cost)
    type(problem_size_t), intent(in) :: sizes

    cost%seconds = (analysis * sizes%n_dofs + per_factor_entry * sizes%factor_entries + &
      per_operation * sizes%factor_operations) / factor_gain(sizes)
    cost%bytes = factor_bytes * sizes%factor_entries + stiffness_bytes * sizes%stiffness_entries
  end function factorization_cost

  !> Returns the cost of solves by the factor for n_columns right-hand sides at once; the memory is that of the results.
  pure type(cost_t) function solves_cost(sizes, n_columns) result(cost)
    type(problem_size_t), intent(in) :: sizes
    integer, intent(in) :: n_columns
    real(rk) :: per(2)

    per = merge(joint_solve, single_solve, n_columns >= many)
    cost%seconds = n_columns * (per(1) * sizes%factor_entries + per(2) * sizes%n_dofs) / factor_gain(sizes)
    cost%bytes = 8.0_rk * sizes%n_dofs * n_columns
  end function solves_cost

  !> Returns the cost of W by elimination, with keeps_named_dofs also of the responses of the named dofs.
  pure type(cost_t) function elimination_cost(sizes) result(cost)
    type(problem_size_t), intent(in) :: sizes
    real(rk) :: entries, operations, front

    entries = merge(sizes%named_entries, sizes%elimination_entries, sizes%keeps_named_dofs)
    operations = merge(sizes%named_operations, sizes%elimination_operations, sizes%keeps_named_dofs)
    front = merge(sizes%named_front, sizes%largest_front, sizes%keeps_named_dofs)
    cost%seconds = (analysis * sizes%n_dofs + per_factor_entry * entries + per_operation * operations) / factor_gain(sizes)
    cost%bytes = front_bytes * front**2 + stiffness_bytes * sizes%stiffness_entries
    ! what is left, of contacts and dofs together
    if (sizes%keeps_named_dofs) cost%bytes = cost%bytes + 8 * (real(sizes%n_multipliers, rk) + sizes%n_named_dofs)**2
  end function elimination_cost

  !> Returns the cost of the condensed solver at no point yet, with W on every rank. With factors: a factorization, which it keeps,
  !> and a solve for each multiplier, whose responses are kept where they are small, else an elimination for W. With multigrid: an
  !> elimination, and the levels.
  pure type(cost_t) function condensed_cost(sizes, linear) result(cost)
    type(problem_size_t), intent(in) :: sizes
    !> cholesky or gamg; default: cholesky
    character(*), intent(in), optional :: linear
    type(cost_t) :: responses

    if (is_multigrid(linear)) then
      cost = multigrid_cost(sizes, 0)
      responses = elimination_cost(sizes)
    else
      cost = factorization_cost(sizes)
      if (keeps_responses(sizes)) then
        responses = solves_cost(sizes, sizes%n_multipliers)
      else
        responses = elimination_cost(sizes)
      end if
    end if
    cost%seconds = cost%seconds + responses%seconds
    cost%bytes = cost%bytes + responses%bytes + dense_bytes(sizes)
  end function condensed_cost

  pure logical function is_multigrid(linear)
    character(*), intent(in), optional :: linear

    is_multigrid = .false.
    if (present(linear)) is_multigrid = linear == 'gamg'
  end function is_multigrid

  !> Whether the condensed solver keeps the responses to all multipliers.
  pure logical function keeps_responses(sizes)
    type(problem_size_t), intent(in) :: sizes
    type(cost_t) :: responses

    responses = solves_cost(sizes, sizes%n_multipliers)
    keeps_responses = responses%bytes <= share_of_responses * sizes%memory
  end function keeps_responses

  !> [byte] Returns the memory of W and of two copies of it on every rank that solves the same point.
  pure real(rk) function dense_bytes(sizes)
    type(problem_size_t), intent(in) :: sizes

    dense_bytes = 24.0_rk * real(sizes%n_multipliers, rk)**2 * max(1, sizes%n_ranks / max(1, sizes%n_points))
  end function dense_bytes

  !> Returns the cost of active sets by factorizations at n_points points. Each set changes K; a factorization for it may be
  !> replaced by conjugate gradients with the factor of an earlier set.
  pure type(cost_t) function refactoring_cost(sizes, n_points) result(cost)
    type(problem_size_t), intent(in) :: sizes
    integer, intent(in) :: n_points
    type(cost_t) :: solve

    solve = solves_cost(sizes, 1)
    cost = factorization_cost(sizes)
    cost%seconds = cost%seconds + sets * n_points * min(again_seconds(sizes), solves_per_set * solve%seconds)
    cost%bytes = cost%bytes + solve%bytes
  end function refactoring_cost

  !> Returns the cost of n_states times of histories where materials flow. Each step of Newton's method has a stiffness of its own,
  !> so that each step factors, computes responses or builds levels again: the condensed solver only for the bodies that flow.
  pure type(cost_t) function newton_cost(type, linear, sizes, n_states) result(cost)
    !> condensed, active_set or snesvi, which counts as active_set
    character(*), intent(in) :: type
    !> cholesky or gamg
    character(*), intent(in) :: linear
    type(problem_size_t), intent(in) :: sizes
    integer, intent(in) :: n_states
    type(cost_t) :: step

    if (type == 'condensed') then
      cost = factorization_cost(sizes) + solves_cost(sizes, sizes%n_multipliers)
      step = condensed_step_cost(sizes)
      cost%bytes = cost%bytes + dense_bytes(sizes)
    else if (linear == 'gamg') then
      step = multigrid_cost(sizes, 1, sets_of_step)
      cost%bytes = step%bytes
    else
      cost = factorization_cost(sizes)
      step = solves_cost(sizes, 1)
      cost%bytes = cost%bytes + step%bytes
      step%seconds = factors_of_step * (step%seconds + again_seconds(sizes))
    end if
    step%seconds = step%seconds + (per_flow_point * sizes%n_flow_points + per_copied_entry * sizes%stiffness_entries) / &
      sizes%n_ranks
    cost%seconds = cost%seconds + real(newton_steps, rk) * n_states * step%seconds
  end function newton_cost

  !> Returns the cost of a step of Newton's method with the condensed solver, in the bodies that flow.
  pure type(cost_t) function condensed_step_cost(sizes) result(cost)
    type(problem_size_t), intent(in) :: sizes
    type(problem_size_t) :: flowing

    flowing = sizes
    flowing%n_dofs = sizes%n_flow_dofs
    flowing%factor_entries = sizes%flow_factor_entries
    flowing%factor_operations = sizes%flow_factor_operations
    ! the displacement takes one more solve with the loads and one with the contact forces, in all bodies
    cost = solves_cost(flowing, sizes%n_flow_multipliers) + times(2, solves_cost(sizes, 1))
    cost%seconds = cost%seconds + again_seconds(flowing) + dense_seconds(sizes)
  end function condensed_step_cost

  !> [s] Returns the time of a factorization that keeps the ordering.
  pure real(rk) function again_seconds(sizes) result(seconds)
    type(problem_size_t), intent(in) :: sizes
    type(cost_t) :: cost

    cost = factorization_cost(sizes)
    seconds = cost%seconds - analysis * sizes%n_dofs / factor_gain(sizes)
  end function again_seconds

  !> [-] Returns by how much several ranks make factorizations and solves faster: the upper part of the elimination tree belongs to
  !> few of them, and the largest front to one.
  pure real(rk) function factor_gain(sizes)
    type(problem_size_t), intent(in) :: sizes

    factor_gain = sqrt(real(sizes%n_ranks, rk))
  end function factor_gain

  !> Returns the cost of a point of the condensed solver: a dense problem whose active set changes a few times, or the step of a
  !> history with friction; and the displacement, by the responses or by one more solve.
  pure type(cost_t) function point_cost(sizes, linear) result(cost)
    type(problem_size_t), intent(in) :: sizes
    !> cholesky or gamg; default: cholesky
    character(*), intent(in), optional :: linear
    type(cost_t) :: before
    real(rk) :: n

    n = sizes%n_multipliers
    if (is_multigrid(linear)) then
      cost = multigrid_cost(sizes, 1, 1)
      before = multigrid_cost(sizes, 0)
      cost%seconds = cost%seconds - before%seconds
    else if (keeps_responses(sizes)) then
      cost%seconds = per_dense_operation * 2 * n * sizes%n_dofs / sizes%n_ranks
    else
      cost = solves_cost(sizes, 1)
    end if
    cost%seconds = cost%seconds + dense_seconds(sizes)
  end function point_cost

  !> [s] Returns the time of the dense problem of a point.
  pure real(rk) function dense_seconds(sizes) result(seconds)
    type(problem_size_t), intent(in) :: sizes

    associate (n => real(sizes%n_multipliers, rk))
      seconds = per_dense_operation * dense_share * n**3
      if (sizes%has_friction) seconds = per_friction_entry(sizes%n_dim) * n**2 + per_dense_operation * friction_share * n**3
    end associate
  end function dense_seconds

  !> Returns the cost of the steps of friction that a model keeps: W and its inverse.
  pure type(cost_t) function steps_cost(sizes) result(cost)
    type(problem_size_t), intent(in) :: sizes

    cost%seconds = per_dense_operation * 3 * real(sizes%n_multipliers, rk)**3
  end function steps_cost

  !> Returns the cost of an answer of a condensed model beside a solution of the full order, and of the errors between both.
  pure type(cost_t) function comparison_cost(sizes) result(cost)
    type(problem_size_t), intent(in) :: sizes

    cost%seconds = per_compared_dof * sizes%n_dofs
    if (sizes%has_friction) cost%seconds = cost%seconds + share_of_answer * dense_seconds(sizes)
  end function comparison_cost

  !> Returns the cost of multigrid at n_points points: levels once, then active sets with levels and iterations of their own.
  pure type(cost_t) function multigrid_cost(sizes, n_points, n_sets) result(cost)
    type(problem_size_t), intent(in) :: sizes
    integer, intent(in) :: n_points
    !> of each point; default: the usual number
    integer, intent(in), optional :: n_sets
    real(rk) :: per_iteration, per_set
    integer :: i, n

    n = sets
    if (present(n_sets)) n = n_sets
    i = merge(2, 1, sizes%is_quadratic)
    per_iteration = iteration(1) * sizes%stiffness_entries + iteration(2) * sizes%n_dofs
    per_set = levels_of_set(i) * sizes%n_dofs + iterations(sizes%n_dim) * per_iteration * &
      sqrt(max(1.0_rk, sizes%stiffness_ratio / harmless_ratio))
    cost%seconds = (levels(i) * sizes%stiffness_entries + n_points * n * per_set) / sizes%n_ranks
    cost%bytes = multigrid_bytes(1) * sizes%stiffness_entries + multigrid_bytes(2) * sizes%n_dofs
  end function multigrid_cost
end module sig_solver_costs
