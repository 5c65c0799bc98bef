! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Solves points of a sampling that have many different stiffnesses by the elastic responses of the bodies, without a factorization
!> for each point.
!>
!> This is exact if all Young's moduli of each body scale together and no Poisson's ratio varies. Otherwise the responses are
!> interpolated over the elastic constants; the deck must allow this. Some points are solved first with their own stiffness. They
!> measure the error.
module sig_sampled_responses
  use sig_answer, only: answer_t
  use sig_body_compliance, only: body_compliance_t
  use sig_body_constants, only: body_constants_t, find_body_constants, joined_body_t, usual_nodes_of
  use sig_clock, only: wall_time
  use sig_condensed_model, only: condensed_model_t
  use sig_condensed_plan, only: displacement_plan_t, why_not_condensed
  use sig_contact_residuals, only: measure_residuals
  use sig_contact_state, only: contact_state_t
  use sig_errors, only: error_t
  use sig_full_order, only: team_t
  use sig_interpolated_training, only: any_variable, interpolate_responses
  use sig_kinds, only: rk
  use sig_log, only: log_info, log_warning
  use sig_materials, only: varying_constants
  use sig_model_data, only: model_sizes_t
  use sig_petsc_support, only: sum_over_ranks
  use sig_point_batches, only: count_distinct
  use sig_point_solver, only: point_solver_t
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged, reason_no_complementary_solution
  use sig_reduced, only: room_t
  use sig_reduced_kinds, only: bodies_of
  use sig_probe_points, only: nearest_of
  use sig_snapshot_store, only: snapshot_set_t
  use sig_solver_plan, only: fits_condensed
  use sig_text, only: counted, short_number, to_text
  use sig_training_set, only: take_snapshots, training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: sampled_responses_t

  !> Call choose; solve the first points and call collect for each; then create; if is_ready, call solve for the other points.
  type :: sampled_responses_t
    !> the responses are there, so that `solve` may be called
    logical :: is_ready = .false.
    !> points that are solved first, shape (n_parameters, n_first), and [force] their contact forces, shape (n_multipliers,
    !> n_first); before `create` only the leader of the group that solved a point has its forces, other ranks have 0
    real(rk), allocatable, private :: points(:, :)
    real(rk), allocatable, private :: forces(:, :)
    logical, allocatable, private :: is_solved(:)
    type(body_constants_t), allocatable, private :: constants(:)
    !> largest number of interpolation nodes of a body with which the responses save time
    integer, private :: n_most = 0
    type(condensed_model_t), allocatable, private :: model
    integer, private :: n_factored = 0
    !> [-] largest relative error of the contact forces at the points that were solved first
    real(rk), private :: measured_error = 0
    class(room_t), allocatable, private :: room
  contains
    procedure :: choose
    procedure :: collect
    procedure :: create
    procedure :: solve
    procedure, private :: answer_point
    procedure :: n_factorizations
  end type sampled_responses_t

  !> number of points with one stiffness from which on they have a factorization of their own
  integer, parameter :: enough_points = 4
  !> number of points that are solved first: if the responses are exact, and if they are interpolated
  integer, parameter :: n_first_exact = 4, n_first_interpolated = 20
  !> [-] largest error of the contact forces that counts as rounding
  real(rk), parameter :: rounding = 1.0e-9_rk
  !> a factorization takes as long as so many solves; a point takes about three
  real(rk), parameter :: solves_per_factorization = 40
  real(rk), parameter :: factorizations_per_point = 3

contains

  !> Chooses the points that are solved first with their own stiffness. There are none if the stiffness is fixed, or if the
  !> responses are not possible, not wanted or save no time; training.stiffness: auto wants them only if they are exact and
  !> may_condense. Then every point is solved with its own stiffness. Local; the same on all ranks.
  subroutine choose(self, problem, points, n_ranks, first)
    class(sampled_responses_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> to be solved, shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> number of ranks of one group; each keeps all responses
    integer, intent(in) :: n_ranks
    !> numbers of the points that are solved first, 1-based, spread evenly over all: 4, or 20 if the responses are interpolated
    integer, allocatable, intent(out) :: first(:)
    type(error_t), allocatable :: error
    character(:), allocatable :: reason
    integer :: i, n_first, n_stiffnesses

    allocate (first(0))
    self%is_ready = .false.
    if (allocated(self%forces)) deallocate (self%forces, self%is_solved)
    associate (wish => problem%deck%training%stiffness)
      if (problem%has_fixed_stiffness .or. wish == 'factored' .or. .not. problem%laws%is_plain()) return
      if (problem%flow%is_there()) then
        call tell_why_factored(wish, 'materials yield or creep, so that each step has a stiffness of its own')
        return
      end if
      if (wish == 'auto' .and. .not. may_condense(problem)) return
      call find_body_constants(problem, self%constants, error)
      if (allocated(error)) then
        call tell_why_factored(wish, error%message)
        return
      end if
      if (wish == 'auto' .and. any_variable(self%constants)) return
      n_first = merge(n_first_interpolated, n_first_exact, any_variable(self%constants))
      n_stiffnesses = count_distinct(varying_constants(problem%deck, problem%material_terms, points))
      self%n_most = int(factorizations_per_point * (n_stiffnesses - n_first) / &
        (1 + problem%rows%n_rows / solves_per_factorization))
      reason = why_not(problem, self%constants, self%n_most, n_ranks)
      if (reason /= '') then
        call tell_why_factored(wish, reason)
        return
      end if
    end associate
    first = [(1 + (i * (size(points, 2) - 1)) / (n_first - 1), i=0, n_first - 1)]
    self%points = points(:, first)
    allocate (self%forces(problem%rows%n_rows, n_first), source=0.0_rk)
    allocate (self%is_solved(n_first), source=.false.)
  end subroutine choose

  !> Logs why there is no interpolation, if the deck asks for it (`interpolated`).
  subroutine tell_why_factored(wish, reason)
    !> training.stiffness of the deck
    character(*), intent(in) :: wish
    character(*), intent(in) :: reason

    if (wish == 'interpolated') call log_info( &
      'training.stiffness: interpolated has no effect; each point is solved exactly, with its own stiffness: ' // reason)
  end subroutine tell_why_factored

  !> Whether the responses may replace the planned solver: the deck asks for the condensed solver, or leaves the choice (auto) and
  !> another solver than condensed is planned, or only a few points share a stiffness. Local.
  pure logical function may_condense(problem)
    type(problem_t), intent(in) :: problem

    associate (type => problem%deck%solver%type)
      may_condense = type == 'condensed' .or. &
        (type == 'auto' .and. (problem%plan%type /= 'condensed' .or. problem%sizes%n_points < enough_points))
    end associate
  end function may_condense

  !> Returns why the responses are impossible, need too much memory or save no time; empty if none of these reasons holds.
  function why_not(problem, constants, n_most, n_ranks) result(reason)
    type(problem_t), intent(in) :: problem
    !> elastic constants of each body, from find_body_constants
    type(body_constants_t), intent(in) :: constants(:)
    !> largest number of interpolation nodes of a body that saves time
    integer, intent(in) :: n_most
    !> ranks of one group
    integer, intent(in) :: n_ranks
    character(:), allocatable :: reason

    reason = why_not_condensed(problem)
    if (reason /= '') return
    associate (n_dofs => problem%mesh%n_dim * problem%mesh%n_nodes, n_nodes => usual_nodes_of(constants))
      if (.not. fits_condensed(problem%sizes, n_nodes * n_ranks)) then
        reason = 'the responses of ' // to_text(n_dofs) // ' dofs to ' // to_text(problem%rows%n_rows) // &
          ' multipliers need too much memory'
      else if (n_nodes > n_most) then
        reason = 'there are so few stiffnesses that the responses would take longer'
      end if
    end associate
  end function why_not

  !> Keeps the contact forces of a point that was solved first, and whether it converged; does nothing if choose has found no
  !> points. Local; the leader of the group calls it.
  subroutine collect(self, i, state)
    class(sampled_responses_t), intent(inout) :: self
    !> position of the point in `first` of choose, 1-based
    integer, intent(in) :: i
    !> its full-order solution
    type(contact_state_t), intent(in) :: state

    if (.not. allocated(self%forces)) return
    self%forces(:, i) = state%multipliers
    self%is_solved(i) = state%reason == reason_converged
  end subroutine collect

  !> Makes the responses and measures their error at the points that were solved first. Afterwards is_ready says whether the
  !> responses may be used. It is false, with a warning, if one of these points did not converge, if interpolate_responses fails (a
  !> stiffness could not be factored, the error of interpolated responses stays too large, a body has too many variable constants),
  !> or if exact responses have an error above 1e-9. Collective on all ranks; the same on each. Requires: choose; collect for its
  !> points.
  subroutine create(self, problem, team, ierr)
    class(sampled_responses_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> its solver is ready; its stiffness changes
    type(team_t), intent(inout) :: team
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t), target :: set
    type(training_set_t) :: solved
    type(joined_body_t) :: joined
    type(displacement_plan_t) :: plan
    type(condensed_model_t), allocatable, target :: model
    type(body_compliance_t), pointer :: bodies
    type(error_t), allocatable :: error
    integer :: i

    PetscCall(share(self, ierr))
    allocate (plan%boundaries(0))
    plan%exact_dofs = [(i, i=1, problem%mesh%n_dim * problem%mesh%n_nodes)]
    set%parameters = self%points
    set%multipliers = self%forces
    allocate (set%displacement(0, size(self%is_solved)))
    solved = take_snapshots(set, pack([(i, i=1, size(self%is_solved))], self%is_solved))
    if (solved%n_snapshots() < size(self%is_solved)) then
      call log_warning('one of the points that are solved first, to measure the error of the responses, did not converge; so ' // &
        'the responses are not used, and each point is solved with its own stiffness')
      return
    end if
    call joined%create(problem, self%constants)
    allocate (model)
    allocate (body_compliance_t :: model%compliance)
    PetscCall(interpolate_responses(problem, team, solved, plan, self%n_most, joined, model, error, ierr))
    bodies => bodies_of(model)
    self%n_factored = bodies%n_factorizations
    self%measured_error = bodies%measured_error
    self%is_ready = .not. allocated(error)
    if (self%is_ready .and. .not. any_variable(self%constants)) self%is_ready = self%measured_error <= rounding
    call tell(self, error)
    if (.not. self%is_ready) return
    call model%complete(model_sizes_t(size(plan%exact_dofs), problem%rows%n_rows, problem%boundary%n_terms, solved%n_snapshots()))
    if (allocated(self%room)) deallocate (self%room)
    call model%create_room(self%room)
    call move_alloc(model, self%model)
  end subroutine create

  !> Gives all ranks the contact forces that the leaders have collected, and which of the points converged. Collective on all ranks.
  subroutine share(self, ierr)
    class(sampled_responses_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: is_solved(size(self%is_solved))
    integer :: i

    do i = 1, size(self%forces, 2)
      PetscCall(sum_over_ranks(PETSC_COMM_WORLD, self%forces(:, i), ierr))
    end do
    is_solved = merge(1.0_rk, 0.0_rk, self%is_solved)
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, is_solved, ierr))
    self%is_solved = is_solved > 0
  end subroutine share

  !> Logs how the other points are solved, and the error of the responses; says why, if the responses cannot be used.
  subroutine tell(self, error)
    class(sampled_responses_t), intent(in) :: self
    !> of interpolate_responses
    type(error_t), allocatable, intent(in) :: error
    character(:), allocatable :: text

    text = 'the forces of ' // counted(size(self%is_solved), 'point') // ' that were solved with their own stiffness'
    if (allocated(error)) then
      call log_warning('the responses of the bodies, which would save factorizations, cannot be used, so each point is solved ' // &
        'with its own stiffness: ' // error%message)
    else if (.not. self%is_ready) then
      if (self%measured_error < huge(rounding)) then
        text = 'give ' // text // ' with a relative error of ' // short_number(self%measured_error) // ', above ' // &
          short_number(rounding)
      else
        text = 'give no answer at a point that was solved with its own stiffness'
      end if
      call log_info('note: the responses from one factorization ' // text // '; so each point is solved with its own ' // &
        'stiffness, which takes longer')
    else if (any_variable(self%constants)) then
      call log_info('solver: condensed: the other points come from responses that are interpolated over the elastic ' // &
        'constants (' // counted(self%n_factorizations(), 'factorization') // &
        '); their relative error of ' // text // ' is at most ' // short_number(self%measured_error))
    else
      call log_info('solver: condensed: the moduli of each body scale together, so one factorization serves all other points; ' // &
        'compared with ' // text // ', the relative error is at most ' // short_number(self%measured_error))
    end if
  end subroutine tell

  !> Solves a point by the responses; with its own stiffness if they give no solution, or if the residual of equilibrium is above
  !> reduction.stiffness_tolerance. state%reason says how the solution ended; state%seconds is the time of both. Collective on the
  !> group. Requires: is_ready.
  subroutine solve(self, problem, solver, point, state, ierr)
    class(sampled_responses_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> full-order solver of the group
    type(point_solver_t), intent(inout) :: solver
    !> shape (n_parameters), checked
    real(rk), intent(in) :: point(:)
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: start, theta(problem%boundary%n_terms)
    integer :: i_source
    logical :: is_valid

    start = wall_time()
    call solver%terms%evaluate(point, theta, is_valid, i_source)
    call self%answer_point(problem, point, theta, state)
    if (state%reason == reason_converged) then
      PetscCall(solver%look_at(problem, point, ierr))
      PetscCall(measure_residuals(solver%system, theta, state, ierr))
      associate (limit => problem%deck%reduction%stiffness_tolerance)
        if (.not. state%residuals%equilibrium <= limit) state%reason = reason_no_complementary_solution
      end associate
    end if
    if (state%reason /= reason_converged) then
      PetscCall(solver%solve(problem, point, state, ierr))
    end if
    state%seconds = wall_time() - start
  end subroutine solve

  !> Computes contact forces and displacements by the responses; state%reason says whether there is a solution, and without one only
  !> this is set. Local.
  subroutine answer_point(self, problem, point, theta, state)
    class(sampled_responses_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> values of the terms at the point, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    type(contact_state_t), intent(inout) :: state
    type(answer_t) :: answer

    call self%model%ask(theta, nearest_of(problem%deck%state_parameters, self%points, point), self%room, answer)
    state%reason = answer%reason
    if (answer%reason <= 0) return
    state%reason = reason_converged
    state%multipliers = answer%multipliers
    state%is_active = answer%multipliers > 0
    state%n_iterations = answer%n_iterations
    allocate (state%displacement(problem%mesh%n_dim * problem%mesh%n_nodes))
    call self%model%fill_displacement(answer, state%displacement)
  end subroutine answer_point

  !> Returns how many stiffnesses were factored for the last responses that were made, also if they may not be used; 0 if none were.
  pure integer function n_factorizations(self)
    class(sampled_responses_t), intent(in) :: self

    n_factorizations = self%n_factored
  end function n_factorizations
end module sig_sampled_responses
