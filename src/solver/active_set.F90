! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Primal-dual active set on the bound form: closed pairs are prescribed unknowns, each step solves one linear system.
module sig_active_set
  use sig_bound_form, only: bound_form_t, renew_matrix
  use sig_contact_solver, only: contact_solver_t
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_holding, only: change_first, first_to_block, is_last_hold, keep_hold, letting_go
  use sig_kinds, only: rk
  use sig_linear_interpolant, only: set_linear_interpolant
  use sig_linear_solver, only: hold, linear_solver_t, set_near_null_space
  use sig_log, only: log_warning
  use sig_next_active_set, only: next_active_set
  use sig_petsc_support, only: create_vector
  use sig_problem_sizes, only: problem_sizes_t, sizes_at
  use sig_reasons, only: reason_converged, reason_linear_solver, reason_max_iterations, reason_pulled_off
  use sig_rounding, only: rounding
  use petsc
  implicit none(type, external)
  private
  public :: active_set_t, build_levels, find_residual, finish_state, unknown_force

  !> The contact solver `active_set`. Call create, then solve for any number of points, then destroy.
  type, extends(contact_solver_t) :: active_set_t
    type(bound_form_t) :: form
    type(linear_solver_t) :: linear_solver
    !> without multigrid: T' K T, and the same in the current step, where closed pairs and prescribed dofs are held
    Mat :: stiffness
    Mat :: matrix
    !> forces of the current step; 0 at held unknowns with multigrid, which solves for the others
    Vec :: rhs
    Vec :: solution
    !> [length] displacement in the last step, from which conjugate gradients start; natural, shape (n_dofs)
    real(rk), allocatable :: displacement(:)
    !> accuracy level of the current point: index into tolerance_levels
    integer :: level = 1
    !> whether the factor is one of a stiffness before renew
    logical, private :: is_outdated = .false.
    !> number of pairs that the last step changed
    integer :: n_changed = 0
    !> pairs that are closed in the first step of a point, shape (n_rows); not allocated, or where they do not hold all bodies: all
    !> pairs
    logical, allocatable :: start(:)
  contains
    procedure :: create
    procedure :: renew
    procedure :: solve
    procedure :: destroy
  end type active_set_t

  !> One step: what it solves, and what it finds.
  type :: step_t
    !> whether the solution is as accurate as it can be
    logical :: is_accurate = .false.
    !> [-] values of the terms
    real(rk), allocatable :: theta(:)
    !> [force] loads on the dofs, natural
    real(rk), allocatable :: forces(:)
    !> rows that change the unknowns of the linear system, shape (n_rows): all rows, and closed ones with multigrid
    logical, allocatable :: is_changed(:)
    !> [force] work of the loads on the free motions, and the sum of the sizes of its parts, shape (n_free)
    real(rk), allocatable :: work(:)
    real(rk), allocatable :: work_size(:)
    !> held dofs, natural, and [length] what they are held at, natural, shape (n_dofs)
    integer, allocatable :: dofs(:)
    real(rk), allocatable :: values(:)
    !> [length] unknowns of the bound form, natural
    real(rk), allocatable :: unknowns(:)
    !> [force] T' (K T x - F), natural
    real(rk), allocatable :: residual(:)
    !> [force] shape (n_rows)
    real(rk), allocatable :: multipliers(:)
    !> [length] shape (n_rows)
    real(rk), allocatable :: opening(:)
    !> set of closed pairs that these multipliers and openings ask for
    logical, allocatable :: wanted(:)
  end type step_t

  !> [-] of each accuracy level: what counts as rounding (next_active_set), and the tolerance of conjugate gradients (0: that of the
  !> options)
  real(rk), parameter :: noise_levels(3) = [1.0e-3_rk, 1.0e-5_rk, 1.0e-9_rk]
  real(rk), parameter :: tolerance_levels(3) = [1.0e-3_rk, 1.0e-6_rk, 0.0_rk]
  !> [-] noise_levels if the preconditioner is a factor: its tightest tolerance is as good as a new factorization
  real(rk), parameter :: factor_noise_levels(3) = [1.0e-3_rk, 1.0e-5_rk, rounding]
  !> number of steps at one point from which on no solution is coarse
  integer, parameter :: usual_steps = 12
  !> usual number of iterations of conjugate gradients; a factorization that takes less time than so many solves is made anew
  integer, parameter :: usual_iterations = 40

contains

  !> Makes the bound form, work vectors, and the multigrid levels or T' K T. If the levels cannot be made, a warning says so, and
  !> multigrid fails at the first `solve`. Collective.
  subroutine create(self, system, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%form%create(system, ierr))
    self%displacement = spread(0.0_rk, 1, system%map%n_dofs)
    PetscCall(create_vector(system%comm, system%map%n_local_dofs, self%solution, ierr))
    PetscCall(create_vector(system%comm, system%map%n_local_dofs, self%rhs, ierr))
    self%linear_solver%is_multigrid = self%is_multigrid
    if (self%is_multigrid) then
      PetscCall(build_levels(self%form, self%linear_solver, system, ierr))
    else
      PetscCall(create_matrices(self, system, ierr))
    end if
  end subroutine create

  !> Takes the new values of the stiffness. MUMPS keeps its ordering, conjugate gradients start from the last displacement.
  !> Collective.
  subroutine renew(self, system, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: start(:)

    if (self%is_multigrid) then
      start = self%displacement
      PetscCall(self%destroy(ierr))
      PetscCall(self%create(system, ierr))
      self%displacement = start
      return
    end if
    PetscCall(renew_matrix(self%stiffness, ierr))
    self%is_outdated = .true.
  end subroutine renew

  !> Makes the matrices for factorizations. Collective.
  subroutine create_matrices(self, system, ierr)
    type(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%form%create_matrix(system, self%stiffness, ierr, allocated(self%changing_dofs)))
    PetscCall(MatDuplicate(self%stiffness, MAT_DO_NOT_COPY_VALUES, self%matrix, ierr))
  end subroutine create_matrices

  !> Builds the multigrid levels for K without contacts and supports. Each aggregate lies in one body, so that its rigid motions let
  !> bodies slide and separate. Every active set then uses these interpolations. If the levels cannot be made, only the reason of
  !> the linear solver stays. Collective.
  subroutine build_levels(form, linear_solver, system, ierr)
    type(bound_form_t), intent(in) :: form
    !> with is_multigrid
    type(linear_solver_t), intent(inout) :: linear_solver
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr
    Mat :: transformation, inverse
    logical :: all_rows(system%rows%n_rows)

    PetscCall(set_near_null_space(system, system%stiffness, ierr))
    PetscCall(set_linear_interpolant(system, system%stiffness, ierr))
    PetscCall(linear_solver%factor(system%stiffness, 'active_set_', ierr))
    if (linear_solver%reason == reason_converged) then
      all_rows = .true.
      PetscCall(form%create_transformation(system, all_rows, .false., transformation, ierr))
      PetscCall(form%create_transformation(system, all_rows, .true., inverse, ierr))
      PetscCall(linear_solver%change_unknowns(system, transformation, inverse, ierr))
      PetscCall(MatDestroy(transformation, ierr))
      PetscCall(MatDestroy(inverse, ierr))
    end if
    if (linear_solver%reason /= reason_converged) then
      ! its reason stays
      PetscCall(linear_solver%destroy(ierr))
    end if
  end subroutine build_levels

  !> Solves the point at which the terms have the values theta [-]. If multigrid fails and may_factor is true, factorizations solve
  !> this point again and all later ones. Any other failure is the reason of the state: too many steps, linear solver, singular
  !> matrix, no equilibrium. Collective.
  subroutine solve(self, system, theta, state, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:)
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr

    PetscCall(find_set(self, system, theta, state, ierr))
    if (state%reason /= reason_linear_solver .or. .not. (self%is_multigrid .and. self%may_factor)) return
    call log_warning('conjugate gradients with multigrid failed: from here on the stiffness is factored')
    PetscCall(self%linear_solver%destroy(ierr))
    self%is_multigrid = .false.
    self%linear_solver%is_multigrid = .false.
    PetscCall(create_matrices(self, system, ierr))
    PetscCall(find_set(self, system, theta, state, ierr))
  end subroutine solve

  !> Finds the active set of one point, and sets the state. Starts with the pairs of `start`, or with every pair closed, so that a
  !> body that only contact holds is held from the first step on. If an accurate solution asks for a set that another had before,
  !> from then on a step changes only the wrong pair with the lowest number, or exchanges it for another one (change_first): without
  !> rounding errors this cannot cycle, but it needs more steps. Collective.
  subroutine find_set(self, system, theta, state, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:)
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr
    type(step_t) :: step
    logical, allocatable :: history(:, :)
    logical :: next(system%rows%n_rows), is_single

    is_single = .false.
    self%level = first_level(self, system)
    self%n_changed = huge(self%n_changed)
    allocate (state%is_active(system%rows%n_rows), source=.true.)
    if (allocated(self%start)) then
      if (system%motions%are_held_by(self%start)) state%is_active = self%start
    end if
    allocate (history(size(next), 0))
    state%reason = reason_max_iterations
    do while (state%n_iterations < self%max_iterations)
      state%n_iterations = state%n_iterations + 1
      PetscCall(solve_with_closed(self, system, theta, state, step, ierr))
      if (self%linear_solver%reason /= reason_converged) then
        state%reason = self%linear_solver%reason
        exit
      end if
      next = step%wanted
      if (all(next .eqv. state%is_active)) then
        state%reason = reason_converged
        exit
      end if
      call keep_hold(system%motions, state%is_active, step%multipliers, next)
      if (all(next .eqv. state%is_active)) call exchange_hold(system, step, next)
      ! what coarse solutions found proves nothing
      if (step%is_accurate) then
        history = reshape([history, state%is_active], [size(next), size(history, 2) + 1])
        is_single = is_single .or. has_column(history, next)
      end if
      if (is_single) next = change_first(system%motions, state%is_active, step%wanted)
      if (all(next .eqv. state%is_active)) then
        state%reason = reason_pulled_off
        exit
      end if
      self%n_changed = count(next .neqv. state%is_active)
      state%is_active = next
    end do
    call finish_state(self%form, system, theta, step%unknowns, step%residual, state)
  end subroutine find_set

  !> Returns the accuracy level with which each point begins: 1 (coarse) in general. It is the finest one if only contact holds some
  !> body and K is factored: with coarse forces the contacts could seem to hold the body no more, and with a factor accuracy costs
  !> little.
  pure integer function first_level(self, system)
    class(active_set_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system

    first_level = 1
    if (system%motions%n_free > 0 .and. .not. self%is_multigrid) first_level = size(tolerance_levels)
  end function first_level

  !> Solves one step, in which the unknowns of closed pairs are held at their bounds. A failure is the reason of the linear solver.
  !> Collective.
  subroutine solve_with_closed(self, system, theta, state, step, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:)
    !> in: is_active, the closed pairs of this step; n_linear_iterations grows
    type(contact_state_t), intent(inout) :: state
    type(step_t), intent(out) :: step
    PetscErrorCode, intent(out) :: ierr

    PetscCall(prepare_step(self, system, theta, state%is_active, step, ierr))
    if (self%is_multigrid) then
      PetscCall(improve_in_levels(self, system, noise_levels, state, step, ierr))
    else
      PetscCall(solve_with_factor(self, system, state, step, ierr))
    end if
  end subroutine solve_with_closed

  !> Solves by conjugate gradients with an earlier factor, if there is one and a factorization takes as long as usual_iterations
  !> solves or more. Otherwise, or if they fail, factors the matrix of this set and solves by the factor. Collective.
  subroutine solve_with_factor(self, system, state, step, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    type(contact_state_t), intent(inout) :: state
    type(step_t), intent(inout) :: step
    PetscErrorCode, intent(out) :: ierr
    integer :: n_solves

    if (self%linear_solver%ksp /= 0) then
      PetscCall(self%linear_solver%solves_per_factorization(n_solves, ierr))
      if (n_solves >= usual_iterations .and. .not. self%is_outdated) then
        PetscCall(self%linear_solver%keep_factor(n_solves, ierr))
        PetscCall(improve_in_levels(self, system, factor_noise_levels, state, step, ierr))
        if (self%linear_solver%reason == reason_converged) return
      end if
      PetscCall(self%linear_solver%factor_again(ierr))
    else
      PetscCall(self%linear_solver%factor(self%matrix, 'active_set_', ierr))
    end if
    self%is_outdated = .false.
    if (self%linear_solver%reason == reason_converged) then
      PetscCall(improve(self, system, 0.0_rk, rounding, state, step, ierr))
    else
      ! its reason stays
      PetscCall(self%linear_solver%destroy(ierr))
    end if
  end subroutine solve_with_factor

  !> Solves by conjugate gradients, more and more accurately as long as the solution asks for the same active set, or changes no
  !> fewer pairs than the last step did: coarse forces may be the reason. Begins with self%level, which rises. After a failure the
  !> next solve starts from zero. Collective.
  subroutine improve_in_levels(self, system, noise, state, step, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    !> [-] share that counts as rounding, for each accuracy level
    real(rk), intent(in) :: noise(:)
    type(contact_state_t), intent(inout) :: state
    type(step_t), intent(inout) :: step
    PetscErrorCode, intent(out) :: ierr
    integer :: n_changed

    ierr = 0
    do while (self%linear_solver%reason == reason_converged)
      PetscCall(improve(self, system, tolerance_levels(self%level), noise(self%level), state, step, ierr))
      n_changed = count(step%wanted .neqv. state%is_active)
      if (step%is_accurate .or. (n_changed > 0 .and. n_changed < self%n_changed .and. state%n_iterations < usual_steps)) exit
      self%level = self%level + 1
      ! what coarser solutions changed says nothing any more
      self%n_changed = huge(self%n_changed)
    end do
    if (self%linear_solver%reason /= reason_converged) self%displacement = 0
  end subroutine improve_in_levels

  !> Computes the loads and held values of a step, and sets the system of `self` for it. Collective.
  subroutine prepare_step(self, system, theta, is_closed, step, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:)
    !> shape (n_rows)
    logical, intent(in) :: is_closed(:)
    type(step_t), intent(inout) :: step
    PetscErrorCode, intent(out) :: ierr

    step%theta = theta
    step%forces = system%load(theta)
    step%work = system%motions%work(step%forces)
    step%work_size = system%motions%work_size(step%forces)
    allocate (step%unknowns(system%map%n_dofs), step%residual(system%map%n_dofs), source=0.0_rk)
    step%values = system%prescribed_displacement(theta)
    step%values(self%form%bounded_dofs) = self%form%bounds(system, theta)
    step%dofs = [system%boundary%prescribed_dofs, pack(self%form%bounded_dofs, is_closed)]
    if (self%is_multigrid) then
      step%is_changed = is_closed
      PetscCall(hold_in_levels(self, system, step, ierr))
    else
      allocate (step%is_changed(size(is_closed)), source=.true.)
      PetscCall(hold_in_matrix(self, system, step, ierr))
    end if
  end subroutine prepare_step

  !> Sets matrix and right-hand side for a step. Collective.
  subroutine hold_in_matrix(self, system, step, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    type(step_t), intent(in) :: step
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: forces(system%map%n_dofs)

    forces = step%forces
    call self%form%to_forces_on_unknowns(system, forces)
    PetscCall(MatCopy(self%stiffness, self%matrix, SAME_NONZERO_PATTERN, ierr))
    PetscCall(system%put(forces, self%rhs, ierr))
    PetscCall(hold(system, step%dofs, step%values, self%matrix, self%rhs, ierr))
  end subroutine hold_in_matrix

  !> Sets multigrid and the right-hand side for a step: the forces on free unknowns, less those of the held values. Only closed rows
  !> change their unknowns: where a stiff and a soft body may move apart, unknowns that mix their displacements would make the
  !> smoother slow. Collective.
  subroutine hold_in_levels(self, system, step, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    type(step_t), intent(in) :: step
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: held(system%map%n_dofs), forces(system%map%n_dofs)
    Mat :: transformation, inverse

    held = 0
    held(step%dofs) = step%values(step%dofs)
    call self%form%to_displacement(system, held, step%is_changed)
    PetscCall(find_residual(self%form, system, step%forces, held, step%is_changed, forces, ierr))
    forces(step%dofs) = 0
    PetscCall(system%put(-forces, self%rhs, ierr))
    if (self%linear_solver%ksp == 0) return
    PetscCall(self%form%create_transformation(system, step%is_changed, .false., transformation, ierr))
    PetscCall(self%form%create_transformation(system, step%is_changed, .true., inverse, ierr))
    PetscCall(self%linear_solver%hold_unknowns(system, transformation, inverse, step%dofs, ierr))
    PetscCall(MatDestroy(transformation, ierr))
    PetscCall(MatDestroy(inverse, ierr))
  end subroutine hold_in_levels

  !> Solves to a tolerance, starting from the last solution, and finds the set that the result asks for (step%wanted). Reads
  !> state%is_active; state%n_linear_iterations grows. Collective.
  subroutine improve(self, system, tolerance, noise, state, step, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    !> [-] relative tolerance of conjugate gradients; 0 = that of the options. A factor of this matrix solves without it
    real(rk), intent(in) :: tolerance
    !> [-] share that counts as rounding, as in next_active_set
    real(rk), intent(in) :: noise
    type(contact_state_t), intent(inout) :: state
    type(step_t), intent(inout) :: step
    PetscErrorCode, intent(out) :: ierr
    logical :: all_rows(system%rows%n_rows)

    PetscCall(find_displacement(self, system, tolerance, step, ierr))
    step%is_accurate = tolerance <= 0
    state%n_linear_iterations = state%n_linear_iterations + self%linear_solver%n_iterations
    step%unknowns = self%displacement
    call self%form%to_unknowns(system, step%unknowns)
    all_rows = .true.
    PetscCall(find_residual(self%form, system, step%forces, self%displacement, all_rows, step%residual, ierr))
    step%multipliers = self%form%multipliers(step%residual)
    step%opening = self%form%bounds(system, step%theta) - step%unknowns(self%form%bounded_dofs)
    step%wanted = next_active_set(state%is_active, step%multipliers, -step%opening, maxval(abs(step%unknowns)), noise)
    call keep_idle_holds(system, state%is_active, step)
  end subroutine improve

  !> Computes T' (K u - F), what a displacement leaves of the balance of forces on the unknowns. Collective.
  subroutine find_residual(form, system, loads, displacement, is_changed, residual, ierr)
    type(bound_form_t), intent(in) :: form
    type(contact_system_t), intent(inout) :: system
    !> [force] F, natural, shape (n_dofs)
    real(rk), intent(in) :: loads(:)
    !> [length] u, same shape
    real(rk), intent(in) :: displacement(:)
    !> rows in T, shape (n_rows)
    logical, intent(in) :: is_changed(:)
    !> [force] natural, shape (n_dofs)
    real(rk), intent(out) :: residual(:)
    PetscErrorCode, intent(out) :: ierr

    PetscCall(system%apply_stiffness(displacement, residual, ierr))
    residual = residual - loads
    call form%to_forces_on_unknowns(system, residual, is_changed)
  end subroutine find_residual

  !> Solves the linear system of a step, and sets self%displacement. Collective.
  subroutine find_displacement(self, system, tolerance, step, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: tolerance
    type(step_t), intent(in) :: step
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: unknowns(system%map%n_dofs)

    unknowns = self%displacement
    call self%form%to_unknowns(system, unknowns, step%is_changed)
    unknowns(step%dofs) = merge(0.0_rk, step%values(step%dofs), self%is_multigrid)
    PetscCall(system%put(unknowns, self%solution, ierr))
    PetscCall(self%linear_solver%solve_vector(self%rhs, tolerance, self%solution, ierr))
    PetscCall(system%get(self%solution, unknowns, ierr))
    unknowns(step%dofs) = step%values(step%dofs)
    call self%form%to_displacement(system, unknowns, step%is_changed)
    self%displacement = unknowns
  end subroutine find_displacement

  !> Changes step%wanted: a closed pair that is the last to hold some motion of a body stays closed, unless the loads pull it open
  !> by more than rounding. The loads alone give the force of such a pair.
  subroutine keep_idle_holds(system, is_closed, step)
    type(contact_system_t), intent(in) :: system
    !> shape (n_rows)
    logical, intent(in) :: is_closed(:)
    type(step_t), intent(inout) :: step
    real(rk) :: amplitudes(system%motions%n_free)
    logical :: is_last(size(is_closed))
    integer :: k

    if (system%motions%n_free == 0 .or. all(step%wanted .or. .not. is_closed)) return
    is_last = is_last_hold(system%motions, is_closed)
    do k = 1, size(is_closed)
      if (step%wanted(k) .or. .not. (is_closed(k) .and. is_last(k))) cycle
      amplitudes = letting_go(system%motions, is_closed, k)
      step%wanted(k) = dot_product(amplitudes, step%work) <= rounding * dot_product(abs(amplitudes), step%work_size)
    end do
  end subroutine keep_idle_holds

  !> Opens the pair that pulls most of those that step%wanted opens, and closes the pair that the body then meets first. If it meets
  !> none, the set stays.
  subroutine exchange_hold(system, step, set)
    type(contact_system_t), intent(in) :: system
    type(step_t), intent(in) :: step
    !> closed pairs; each that step%wanted opens is a last hold (is_last_hold), and there is at least one
    logical, intent(inout) :: set(:)
    integer :: first, k

    k = minloc(step%multipliers, dim=1, mask=set .and. .not. step%wanted)
    first = first_to_block(system%motions, set, letting_go(system%motions, set, k), step%opening)
    if (first == 0) return
    set(k) = .false.
    set(first) = .true.
  end subroutine exchange_hold

  !> Sets displacement, without idle motions, and multipliers of the state. The multiplier of a pair is zero if state%is_active is
  !> false for it, or if its computed force pulls or is only rounding.
  pure subroutine finish_state(form, system, theta, unknowns, residual, state)
    type(bound_form_t), intent(in) :: form
    type(contact_system_t), intent(in) :: system
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [length] unknowns x of the bound form, and [force] T' (K T x - F), both natural, shape (n_dofs)
    real(rk), intent(in) :: unknowns(:)
    real(rk), intent(in) :: residual(:)
    type(contact_state_t), intent(inout) :: state

    state%displacement = unknowns
    call form%to_displacement(system, state%displacement)
    call system%motions%idle%leave_out(system%motions, state%displacement)
    state%multipliers = merge(max(form%multipliers(residual), 0.0_rk), 0.0_rk, state%is_active)
    where (state%multipliers <= unknown_force(form, system, theta, state%displacement, residual, state%is_active)) &
      state%multipliers = 0
  end subroutine finish_state

  !> Returns the largest force [force] that may be rounding: contact forces are what K u - F leaves at the nodes of closed pairs, so
  !> they are known up to what it leaves where it should be zero, ten times to be safe, and up to rounding of its terms. The largest
  !> sum of a row of K stands for those at the contacts, which are often ten times smaller. is_closed: rows of closed contacts.
  !> Other arguments: finish_state.
  pure real(rk) function unknown_force(form, system, theta, displacement, residual, is_closed)
    type(bound_form_t), intent(in) :: form
    type(contact_system_t), intent(in) :: system
    real(rk), intent(in) :: theta(:)
    !> [length] u, shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    real(rk), intent(in) :: residual(:)
    logical, intent(in) :: is_closed(:)
    type(problem_sizes_t) :: sizes
    logical :: is_free(size(residual))

    is_free = .true.
    is_free(system%boundary%prescribed_dofs) = .false.
    is_free(pack(form%bounded_dofs, is_closed)) = .false.
    sizes = sizes_at(system, theta)
    unknown_force = max(10 * maxval(abs(residual), mask=is_free), &
      rounding / 10 * max(system%stiffness_size * maxval(abs(displacement)), sizes%force))
  end function unknown_force

  pure logical function has_column(columns, column)
    logical, intent(in) :: columns(:, :)
    logical, intent(in) :: column(:)
    integer :: i

    has_column = .false.
    do i = 1, size(columns, 2)
      has_column = has_column .or. all(columns(:, i) .eqv. column)
    end do
  end function has_column

  !> Frees the matrices, vectors and linear solver. Collective.
  subroutine destroy(self, ierr)
    class(active_set_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%linear_solver%destroy(ierr))
    PetscCall(MatDestroy(self%stiffness, ierr))
    PetscCall(MatDestroy(self%matrix, ierr))
    PetscCall(VecDestroy(self%rhs, ierr))
    PetscCall(VecDestroy(self%solution, ierr))
  end subroutine destroy
end module sig_active_set
