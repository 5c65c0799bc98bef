! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> A full-order problem ready to be solved at parameter points: system, solver and terms of one group of ranks.
module sig_point_solver
  use sig_clock, only: wall_time
  use sig_condensed, only: condensed_t
  use sig_contact_residuals, only: measure_points, measure_residuals
  use sig_contact_solver, only: contact_solver_t
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_elastic_body, only: elastic_body_t
  use sig_elimination_plan, only: elimination_plan_t
  use sig_free_response, only: compute_lifting
  use sig_friction_set, only: friction_set_t
  use sig_imposed_strain, only: strain_field_t
  use sig_kinds, only: rk
  use sig_log, only: log_info
  use sig_newton, only: newton_t, step_data_t
  use sig_problem, only: body_at, problem_t, strains_at
  use sig_progress, only: duration_text, progress_t
  use sig_reasons, only: reason_converged
  use sig_solver_choice, only: choose_solver
  use sig_solver_costs, only: condensed_cost, cost_t, elimination_cost, factorization_cost
  use sig_solver_plan, only: solver_plan_t
  use sig_term_values, only: term_values_t
  use petsc
  implicit none(type, external)
  private
  public :: point_solver_t

  !> [s] progress of a history is told only if it takes longer
  real(rk), parameter :: seconds_of_silence = 3

  !> One group's system of equations and its solver.
  type :: point_solver_t
    type(contact_system_t) :: system
    class(contact_solver_t), allocatable :: solver
    type(term_values_t) :: terms
    !> the bodies of the last take_body; not set before
    type(elastic_body_t) :: body
    !> [s] wall time of create: assembly, and what the solver does once if the stiffness is fixed
    real(rk) :: setup_seconds = 0
    !> how often the stiffness was assembled and the solver made ready for it
    integer :: n_stiffnesses = 0
    !> whether steps where materials flow are halved (newton_t)
    logical :: halves_steps = .false.
    !> number of points that were solved
    integer :: n_solved = 0
    !> the solver is made for the stiffness that the system has now
    logical, private :: is_ready = .false.
    !> of condense, if the solver is another one
    type(condensed_t), allocatable, private :: condensed
    !> of a condensed operator
    type(elimination_plan_t), private :: elimination
    !> where materials flow; it has a solver of its own
    type(newton_t), allocatable, private :: newton
  contains
    procedure :: create
    procedure :: solve
    procedure :: solve_history
    procedure :: solve_points
    procedure :: n_times
    procedure :: n_points_at_once
    procedure :: condense
    procedure :: look_at
    procedure :: take_body
    procedure :: take_middle
    procedure :: lifting
    procedure :: destroy
    procedure, private :: solve_flow
  end type point_solver_t

contains

  !> Makes the system, and the solver for it. If the stiffness depends on the parameters, the solver is only chosen here, and made
  !> at the first point. A solver that cannot factor the stiffness keeps the reason, and its solutions report it. Collective on
  !> comm.
  subroutine create(self, problem, plan, comm, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> which solver to make
    type(solver_plan_t), intent(in) :: plan
    !> communicator of the group
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    character(:), allocatable :: message
    real(rk) :: start

    start = wall_time()
    self%n_stiffnesses = 0
    associate (body => problem%body, rows => problem%force_rows, n_times => max(1, problem%deck%history%states%n_times()))
      PetscCall(self%system%create(comm, problem%mesh, body, problem%boundary, rows, ierr, problem%laws, n_times))
    end associate
    call self%terms%create(problem%terms, message)
    associate (n => problem%deck%solver%max_iterations, is_plain => problem%sizes%has_plain_contact)
      PetscCall(choose_solver(plan, n, self%solver, ierr, is_plain))
    end associate
    if (problem%flow%is_there()) then
      PetscCall(create_newton(self, problem, plan, ierr))
    else if (problem%has_fixed_stiffness) then
      if (plan%linear == 'cholesky') call announce_factorization(problem)
      call plan_elimination(self, problem)
      PetscCall(self%solver%create(self%system, ierr))
      self%n_stiffnesses = 1
      self%is_ready = .true.
    end if
    self%setup_seconds = wall_time() - start
  end subroutine create

  !> Makes what solves histories of materials that flow. self%solver is not made ready: each step has a stiffness of its own.
  !> Collective.
  subroutine create_newton(self, problem, plan, ierr)
    type(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    type(solver_plan_t), intent(in) :: plan
    PetscErrorCode, intent(out) :: ierr
    class(contact_solver_t), allocatable :: solver

    self%system%n_times = max(1, problem%deck%history%states%n_times())
    self%body = problem%body
    allocate (self%newton)
    associate (n => problem%deck%solver%max_iterations, is_plain => problem%sizes%has_plain_contact)
      PetscCall(choose_solver(plan, n, solver, ierr, is_plain))
    end associate
    PetscCall(self%newton%create(self%system, problem%mesh, problem%body, problem%flow%laws, solver, ierr))
  end subroutine create_newton

  !> Sets self%elimination, and that of a condensed solver. Local.
  subroutine plan_elimination(self, problem)
    type(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    type(cost_t) :: alone, whole

    alone = elimination_cost(problem%sizes)
    whole = condensed_cost(problem%sizes, trim(merge('cholesky', 'gamg    ', problem%plan%may_factor)))
    self%elimination = problem%elimination
    self%elimination%cost = cost_t(alone%seconds, whole%bytes)
    select type (solver => self%solver)
    type is (condensed_t)
      solver%elimination = self%elimination
    end select
  end subroutine plan_elimination

  !> Tells how long the factorization will take if that is some seconds: MUMPS does it in one step, without a sign of progress.
  subroutine announce_factorization(problem)
    type(problem_t), intent(in) :: problem
    real(rk), parameter :: seconds_of_silence = 3
    type(cost_t) :: cost

    cost = factorization_cost(problem%sizes)
    if (cost%seconds > seconds_of_silence) call log_info('factoring the stiffness takes about ' // duration_text(cost%seconds))
  end subroutine announce_factorization

  !> Assembles the stiffness of a point and makes the solver for it. Does nothing if the solver is already made for the same elastic
  !> constants, or if the stiffness does not depend on the parameters. Collective.
  subroutine update_stiffness(self, problem, point, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters), checked
    real(rk), intent(in) :: point(:)
    PetscErrorCode, intent(out) :: ierr
    type(elastic_body_t) :: body

    ierr = 0
    if (problem%has_fixed_stiffness) return
    call body_at(problem, point, body)
    if (self%is_ready) then
      if (.not. any(abs(body%stress_matrix - self%body%stress_matrix) > 0)) return
    end if
    PetscCall(self%take_body(problem, body, ierr))
    PetscCall(self%solver%create(self%system, ierr))
    self%n_stiffnesses = self%n_stiffnesses + 1
    self%is_ready = .true.
  end subroutine update_stiffness

  !> Puts the stiffness of a point into the system, for products with it. The solver is freed, and the next solve makes it anew.
  !> Does nothing if the stiffness does not depend on the parameters. Collective.
  subroutine look_at(self, problem, point, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters), checked
    real(rk), intent(in) :: point(:)
    PetscErrorCode, intent(out) :: ierr
    type(elastic_body_t) :: body

    ierr = 0
    if (problem%has_fixed_stiffness) return
    call body_at(problem, point, body)
    PetscCall(self%take_body(problem, body, ierr))
  end subroutine look_at

  !> Assembles the stiffness of the whole mesh with given elastic constants, and frees the solver. If the stiffness depends on the
  !> parameters, the next solve assembles that of its own point and makes the solver anew. If it does not, solve must not be called
  !> any more. Collective.
  subroutine take_body(self, problem, body, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> elastic constants of all regions of the mesh
    type(elastic_body_t), intent(in) :: body
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (self%is_ready) then
      PetscCall(self%solver%destroy(ierr))
    end if
    self%is_ready = .false.
    self%body = body
    PetscCall(self%system%update_stiffness(problem%mesh, self%body, ierr))
  end subroutine take_body

  !> Assembles the stiffness in the middle of the box of the parameters, if it depends on them (take_body). Collective.
  subroutine take_middle(self, problem, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (problem%has_fixed_stiffness) return
    PetscCall(self%take_body(problem, problem%body, ierr))
  end subroutine take_middle

  !> Solves one point that is no state of a history which remembers, and measures its residuals and reactions; with friction it
  !> counts its solutions. The reason in `state` says whether it has a solution. Requires: check_points accepted the point.
  !> Collective.
  subroutine solve(self, problem, point, state, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> solution, and the wall time of assembly and solver without the residuals
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: start, theta(problem%boundary%n_terms)
    integer :: i_source
    logical :: is_valid

    type(contact_state_t) :: states(1)

    if (allocated(self%newton)) then
      PetscCall(self%solve_flow(problem, reshape(point, [size(point), 1]), states, ierr))
      state = states(1)
      return
    end if
    start = wall_time()
    call self%terms%evaluate(point, theta, is_valid, i_source)
    PetscCall(update_stiffness(self, problem, point, ierr))
    call count_solutions(self, .true.)
    PetscCall(self%solver%solve(self%system, theta, state, ierr))
    call count_solutions(self, .false.)
    self%n_solved = self%n_solved + 1
    state%seconds = wall_time() - start
    PetscCall(measure_residuals(self%system, theta, state, ierr))
  end subroutine solve

  !> Solves the states of one history, or one point where nothing remembers (n_times), as solve does. Requires: as solve.
  !> Collective.
  subroutine solve_history(self, problem, points, states, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_times)
    real(rk), intent(in) :: points(:, :)
    !> shape (n_times)
    type(contact_state_t), intent(out) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: theta(problem%boundary%n_terms, size(points, 2))
    integer :: i

    if (size(states) == 1) then
      PetscCall(self%solve(problem, points(:, 1), states(1), ierr))
      return
    end if
    if (allocated(self%newton)) then
      PetscCall(self%solve_flow(problem, points, states, ierr))
      return
    end if
    call count_solutions(self, .true.)
    PetscCall(solve_together(self, problem, points, theta, states, ierr))
    call count_solutions(self, .false.)
    do i = 1, size(states)
      PetscCall(measure_residuals(self%system, theta(:, i), states(i), ierr))
    end do
  end subroutine solve_history

  !> Solves the states of one history of materials that flow, in their order. A state without an answer gets the reason why, and the
  !> later states get the same reason. Collective.
  subroutine solve_flow(self, problem, points, states, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_times)
    real(rk), intent(in) :: points(:, :)
    !> shape (n_times)
    type(contact_state_t), intent(out) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    type(step_data_t) :: before, now
    type(progress_t) :: progress
    real(rk) :: start
    integer :: i

    call progress%start('times', size(states), seconds_of_silence)
    call self%newton%begin()
    self%newton%halves_steps = self%halves_steps
    if (.not. problem%has_fixed_stiffness) call body_at(problem, points(:, 1), self%body)
    PetscCall(self%newton%take_body(problem%mesh, self%body, ierr))
    self%n_stiffnesses = self%newton%n_stiffnesses
    do i = 1, size(states)
      start = wall_time()
      call collect_data(self, problem, points(:, i), i, now)
      if (i == 1) call assume_start(self, now, before)
      PetscCall(self%newton%solve(problem%mesh, self%body, before, now, states(i), ierr))
      self%n_solved = self%n_solved + 1
      states(i)%seconds = wall_time() - start
      call progress%advance(i)
      if (states(i)%reason /= reason_converged) exit
      before = now
    end do
    call progress%finish()
    do i = i + 1, size(states)
      states(i) = states(i - 1)
      states(i)%seconds = 0
      states(i)%n_iterations = 0
    end do
  end subroutine solve_flow

  !> Collects what is given at one time. Local.
  subroutine collect_data(self, problem, point, i_time, now)
    type(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> number of the time, 1-based
    integer, intent(in) :: i_time
    type(step_data_t), intent(inout) :: now
    type(strain_field_t) :: field
    real(rk) :: theta(problem%boundary%n_terms)
    integer :: i_source
    logical :: is_valid

    call self%terms%evaluate(point, theta, is_valid, i_source)
    now%time = 0
    if (problem%deck%history%states%is_there()) now%time = problem%deck%history%states%times(i_time)
    associate (boundary => self%system%boundary)
      now%prescribed = matmul(boundary%prescribed_values, theta(:size(boundary%prescribed_values, 2)))
    end associate
    now%forces = self%system%load(theta)
    now%gap = self%system%gap(theta)
    now%friction = self%system%laws%friction_at(theta)
    call strains_at(problem, point, field)
    call problem%flow%evaluate(self%body, point, field, self%newton%flowing, now%points)
  end subroutine collect_data

  !> Makes what is assumed before the first time: nothing is displaced, loaded or heated, and overlaps are zero. Local.
  subroutine assume_start(self, first, before)
    type(point_solver_t), intent(in) :: self
    !> what is given at the first time
    type(step_data_t), intent(in) :: first
    type(step_data_t), intent(out) :: before

    before = first
    before%time = 0
    before%prescribed = 0
    before%forces = 0
    associate (n => self%system%laws%n_contacts)
      before%gap(:n) = max(first%gap(:n), 0.0_rk)
      before%gap(n + 1:) = 0
    end associate
    before%points%imposed = 0
  end subroutine assume_start

  !> Lets the solver count the solutions of steps with friction, if it can, and tell how far it is, or not.
  pure subroutine count_solutions(self, is_wanted)
    class(point_solver_t), intent(inout) :: self
    logical, intent(in) :: is_wanted

    select type (solver => self%solver)
    type is (condensed_t)
      solver%counts_solutions = is_wanted
    type is (friction_set_t)
      solver%tells_progress = is_wanted
    end select
  end subroutine count_solutions

  !> Solves several points that share a stiffness at once and measures their residuals, but no reactions. Each state has its own
  !> reason, and an equal share of the wall time of assembly and solver. Requires: check_points accepted the points; there are one
  !> to n_points_at_once of them. Collective.
  subroutine solve_points(self, problem, points, states, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> shape (n_points)
    type(contact_state_t), intent(out) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: theta(problem%boundary%n_terms, size(points, 2))
    integer :: first

    if (allocated(self%newton)) then
      do first = 1, size(states), self%n_times()
        associate (last => first + self%n_times() - 1)
          PetscCall(self%solve_flow(problem, points(:, first:last), states(first:last), ierr))
        end associate
      end do
      return
    end if
    PetscCall(solve_together(self, problem, points, theta, states, ierr))
    PetscCall(measure_points(self%system, theta, states, ierr))
  end subroutine solve_points

  !> Solves several points that share a stiffness at once, and gives each state an equal share of the wall time. Collective.
  subroutine solve_together(self, problem, points, theta, states, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> [-] values of the terms at each point, shape (n_terms, n_points)
    real(rk), intent(out) :: theta(:, :)
    !> shape (n_points); get no residuals
    type(contact_state_t), intent(out) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: start
    integer :: i, i_source
    logical :: is_valid

    start = wall_time()
    do i = 1, size(points, 2)
      call self%terms%evaluate(points(:, i), theta(:, i), is_valid, i_source)
    end do
    PetscCall(update_stiffness(self, problem, points(:, 1), ierr))
    PetscCall(self%solver%solve_points(self%system, theta, states, ierr))
    self%n_solved = self%n_solved + size(states)
    states%seconds = (wall_time() - start) / size(states)
  end subroutine solve_together

  !> Returns how many points are solved together, in their order, because the states of a history remember: all its times, else 1.
  !> Requires: create.
  pure integer function n_times(self)
    class(point_solver_t), intent(in) :: self

    n_times = self%system%n_times
  end function n_times

  !> Returns how many points solve_points takes at most in one call: more than one if the solver is faster with several points.
  !> Requires: create.
  pure integer function n_points_at_once(self) result(n_points)
    class(point_solver_t), intent(in) :: self

    if (allocated(self%newton)) then
      n_points = self%n_times()
    else
      n_points = self%solver%n_points_at_once(self%system)
    end if
  end function n_points_at_once

  !> Returns the condensed operator of the system: the solver itself if it is condensed, else one that is made at the first call.
  !> condensed%reason says whether the stiffness could be factored. The operator belongs to the point solver. Requires: the
  !> stiffness does not depend on the parameters; or, where materials flow, take_middle. Collective.
  subroutine condense(self, condensed, ierr)
    class(point_solver_t), target, intent(inout) :: self
    type(condensed_t), pointer, intent(out) :: condensed
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    select type (solver => self%solver)
    type is (condensed_t)
      ! where materials flow, each step has a stiffness and a solver of its own
      if (.not. allocated(self%newton)) then
        condensed => solver
        return
      end if
    end select
    if (.not. allocated(self%condensed)) then
      allocate (self%condensed)
      self%condensed%is_multigrid = .not. self%solver%may_factor
      self%condensed%elimination = self%elimination
      PetscCall(self%condensed%create(self%system, ierr))
    end if
    condensed => self%condensed
  end subroutine condense

  !> Returns on every rank the elastic response to each of the problem's lifted terms with the value 1, without contact. Collective.
  !>
  !> If the stiffness depends on the parameters, it is assembled in the middle of their box and the solver is freed. The next solve
  !> makes it anew.
  subroutine lifting(self, problem, response, reason, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> [length] natural, shape (n_dofs, n_lifted_terms)
    real(rk), allocatable, intent(out) :: response(:, :)
    !> reason_converged, or why K could not be factored or a solve failed; then the response is zero or not allocated
    integer, intent(out) :: reason
    PetscErrorCode, intent(out) :: ierr

    if (.not. problem%has_fixed_stiffness) then
      PetscCall(self%take_body(problem, problem%body, ierr))
      PetscCall(compute_lifting(self%system, self%solver%is_multigrid, response, reason, ierr))
      return
    end if
    if (allocated(self%newton)) then
      PetscCall(compute_lifting(self%system, .false., response, reason, ierr))
      return
    end if
    select type (solver => self%solver)
    type is (condensed_t)
      reason = solver%reason
      if (reason == reason_converged) then
        PetscCall(self%system%share_columns(solver%lifting, size(solver%lifting, 2), response, ierr))
      end if
    class default
      PetscCall(compute_lifting(self%system, solver%is_multigrid, response, reason, ierr))
    end select
  end subroutine lifting

  !> Frees system, solver, terms and the operator of condense. Collective.
  subroutine destroy(self, ierr)
    class(point_solver_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    call self%terms%destroy()
    if (allocated(self%newton)) then
      PetscCall(self%newton%destroy(ierr))
      deallocate (self%newton)
    end if
    if (self%is_ready) then
      PetscCall(self%solver%destroy(ierr))
    end if
    self%is_ready = .false.
    if (allocated(self%condensed)) then
      PetscCall(self%condensed%destroy(ierr))
      deallocate (self%condensed)
    end if
    PetscCall(self%system%destroy(ierr))
  end subroutine destroy
end module sig_point_solver
