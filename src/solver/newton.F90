! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Equilibrium where materials flow (plasticity, creep): a semismooth Newton method on displacements, materials and contact at once.
!>
!> With sigma_k and C_k, stress and tangent of the iterate u_k, the linear problem is one of elastic bodies in contact,
!>
!>     K_k u + B' lambda = F + int B' (C_k eps(u_k) - sigma_k),   K_k = int B' C_k B,   contact conditions of u and lambda,
!>
!> which the contact solvers solve with their own active set, friction and bodies that only contact holds. So contact is exact at
!> every iterate that takes the whole step, and the method ends as fast as Newton's. The terms of the problem are summed to one:
!> F contains no forces of imposed strains in cells that flow, because sigma does.
!>
!> Line search: the work of the residual int B' sigma + B' lambda - F on the step from u_k to the solution u, which grows along the
!> step and is negative at its start. The first step is taken as it is: it moves the supports. So is one where the residual is small
!> already: the work may be rounding.
!>
!> A step of time that does not converge is cut in two, in which all data are half way.
module sig_newton
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_active_set, only: active_set_t
  use sig_assembly, only: add_cells, add_tangents
  use sig_condensed, only: condensed_t
  use sig_contact_residuals, only: measure_residuals
  use sig_contact_solver, only: contact_solver_t
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_elastic_body, only: elastic_body_t
  use sig_flowing_cells, only: dofs_of_flowing_bodies, flow_laws_t, flow_work_t, flowing_cells_t, point_data_t
  use sig_kinds, only: rk
  use sig_load_pattern, only: load_pattern_t
  use sig_material_law, only: creep_strain_at, creep_strains, plastic_strain_at, plastic_strains
  use sig_mesh, only: mesh_t
  use sig_petsc_support, only: max_over_ranks, sum_over_ranks
  use sig_reasons, only: reason_bad_property, reason_converged, reason_floating_body, reason_no_material_answer, reason_pulled_off
  use petsc
  implicit none(type, external)
  private
  public :: newton_t, step_data_t

  !> What is given at one time.
  type :: step_data_t
    !> [time]
    real(rk) :: time = 0
    !> [length] on prescribed dofs, in their order
    real(rk), allocatable :: prescribed(:)
    !> [force] loads and forces of imposed strains, natural, shape (n_dofs)
    real(rk), allocatable :: forces(:)
    !> [length] shape (n_rows)
    real(rk), allocatable :: gap(:)
    !> [-] shape (n_contacts)
    real(rk), allocatable :: friction(:)
    !> at the points of this rank's flowing cells
    type(point_data_t) :: points
  end type step_data_t

  !> The end of a step.
  type :: end_t
    !> [length] natural, shape (n_dofs)
    real(rk), allocatable :: displacement(:)
    !> [force] loads without forces of imposed strains in cells that flow, and forces of the supports; same shape
    real(rk), allocatable :: loads(:)
    real(rk), allocatable :: supports(:)
    !> [force] shape (n_rows)
    real(rk), allocatable :: multipliers(:)
    !> [force*length] elastic energy
    real(rk) :: energy = 0
  end type end_t

  !> Call create; for each history take_body, where its elastic constants are not those of the history before, and begin, then solve
  !> for each time in order; then destroy.
  type :: newton_t
    !> cells of this rank that flow
    type(flowing_cells_t) :: flowing
    !> whether each time is reached by two steps, in the middle of which all data are half way
    logical :: halves_steps = .false.
    !> how often the stiffness of the cells that do not flow was assembled
    integer :: n_stiffnesses = 0
    !> the linear problem; its matrix is K_k
    type(contact_system_t), private :: system
    class(contact_solver_t), allocatable, private :: solver
    !> whether the solver was made, so that it can be renewed
    logical, private :: is_ready = .false.
    !> stiffness of the cells that do not flow
    Mat, private :: elastic
    !> [force/length**2] stress_matrix of the bodies for which it was assembled; not allocated before
    real(rk), allocatable, private :: stress_matrix(:, :, :)
    !> the accepted state
    type(end_t), private :: last
    !> what friction remembers (condensed_t); not allocated at the beginning, or without friction
    real(rk), allocatable, private :: remembered(:)
    !> closed rows of the last linear problem; not allocated before
    logical, allocatable, private :: closed(:)
  contains
    procedure :: create
    procedure :: take_body
    procedure :: begin
    procedure :: solve
    procedure :: destroy
  end type newton_t

  !> An iterate, and what is measured there.
  type :: iterate_t
    !> [length] natural, shape (n_dofs)
    real(rk), allocatable :: displacement(:)
    !> [force] the integral of B' sigma over all cells, and sizes of its parts; same shape
    real(rk), allocatable :: forces(:)
    real(rk), allocatable :: sizes(:)
    !> [force*length] u . K u / 2 of the cells that do not flow
    real(rk) :: energy = 0
    !> whether the laws have an answer at all points
    logical :: is_solved = .false.
  end type iterate_t

  !> What the steps of one time have done so far.
  type :: course_t
    !> the last solution of a linear problem; its reason is that of the last step
    type(contact_state_t) :: found
    !> [length] slip in tangential rows since the last time
    real(rk), allocatable :: slip(:)
    type(flow_work_t) :: work
    !> [force*length] sizes of the terms in the balance of work
    real(rk) :: work_size = 0
    integer :: n_iterations = 0
    integer :: n_linear_iterations = 0
    integer :: n_cuts = 0
    !> [-] of the last step: residual behind each iteration
    real(rk), allocatable :: residuals(:)
    !> [time] of the last accepted step
    real(rk) :: reached = 0
    !> of the last step: number of points of each material on this rank, and of those that yield; shape (n_materials)
    integer, allocatable :: n_points(:)
    integer, allocatable :: n_yielding(:)
    !> [force] of the last step: loads without forces of imposed strains in cells that flow, and forces of the stresses; natural,
    !> shape (n_dofs)
    real(rk), allocatable :: external(:)
    real(rk), allocatable :: forces(:)
    !> [force*length] of the last step: u . K u / 2 of the cells that do not flow
    real(rk) :: energy = 0
  end type course_t

  !> [-] an answer leaves at most this share of the forces (with multigrid the second one, because its conjugate gradients leave
  !> 1e-11), and its last step was at most that share of the displacement
  real(rk), parameter :: residual_tolerance = 1.0e-12_rk, multigrid_tolerance = 1.0e-10_rk, step_tolerance = 1.0e-6_rk
  !> [-] or what it leaves is rounding: this share of the forces, or of |K| |u|
  real(rk), parameter :: rounding_of_forces = 1.0e-13_rk, rounding_of_products = epsilon(1.0_rk)
  !> [-] or its last step was so small that Newton's next one would be rounding: with multigrid the linear problem has the error
  real(rk), parameter :: coarse_residual = 1.0e-8_rk, small_step = 1.0e-10_rk
  !> [-] or from one iteration to the next it did not fall to the second share, and is at most the first one
  real(rk), parameter :: stalled_residual = 1.0e-10_rk, stalled_share = 0.5_rk
  !> [-] forces are compared with at least this share of |K| |u|, because where nothing presses they are rounding
  real(rk), parameter :: smallest_share = 1.0e-6_rk
  integer, parameter :: most_iterations = 25
  !> a step is at least 1/2**most_cuts of that of the deck
  integer, parameter :: most_cuts = 5
  !> [-] line search: the work of the residual along the step may have this share of its size at the start; if it has more, the step
  !> is shortened until it has at most the second one
  real(rk), parameter :: steep = 0.8_rk, flat = 0.5_rk
  integer, parameter :: most_searches = 6

contains

  !> Makes the linear problem from the system, and the cells that flow. Collective.
  subroutine create(self, system, mesh, body, laws, solver, ierr)
    class(newton_t), intent(inout) :: self
    !> stays as it is, and must live as long as this; its matrix has the pattern
    type(contact_system_t), intent(in) :: system
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> shape (n_materials)
    type(flow_laws_t), intent(in) :: laws(:)
    !> of choose_solver; moved
    class(contact_solver_t), allocatable, intent(inout) :: solver
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: values(:, :), gap(:, :)

    self%system = system
    call move_alloc(solver, self%solver)
    PetscCall(MatDuplicate(system%stiffness, MAT_DO_NOT_COPY_VALUES, self%system%stiffness, ierr))
    PetscCall(MatDuplicate(system%stiffness, MAT_DO_NOT_COPY_VALUES, self%elastic, ierr))
    self%system%n_times = 1
    associate (boundary => self%system%boundary)
      allocate (values(size(boundary%prescribed_dofs), 1), gap(self%system%rows%n_rows, 1), source=0.0_rk)
      call move_alloc(values, boundary%prescribed_values)
      call move_alloc(gap, self%system%rows%gap)
      boundary%n_terms = 1
      boundary%n_driving_terms = 1
      boundary%strain_forces = load_pattern_t()
      boundary%lifted_forces = load_pattern_t()
    end associate
    if (allocated(self%system%laws%friction_terms)) self%system%laws%friction_terms = 1
    call self%flowing%create(mesh, body, laws, system%map%own_cells)
    self%solver%changing_dofs = dofs_of_flowing_bodies(mesh, body, system%motions%body_of_node)
  end subroutine create

  !> Assembles the stiffness of the cells that do not flow. Does nothing if it is there for the same elastic constants. Collective.
  subroutine take_body(self, mesh, body, ierr)
    class(newton_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    PetscErrorCode, intent(out) :: ierr
    integer :: i

    ierr = 0
    if (allocated(self%stress_matrix)) then
      if (.not. any(abs(body%stress_matrix - self%stress_matrix) > 0)) return
    end if
    self%stress_matrix = body%stress_matrix
    self%n_stiffnesses = self%n_stiffnesses + 1
    PetscCall(destroy_solver(self, ierr))
    PetscCall(MatZeroEntries(self%elastic, ierr))
    associate (own => self%system%map%own_cells)
      associate (cells => pack(own, [(.not. body%flows_in(own(i)), i=1, size(own))]))
        PetscCall(add_cells(mesh, body, self%system%map, cells, self%elastic, ierr))
      end associate
    end associate
  end subroutine take_body

  !> Begins a history: nothing is displaced, and the materials are virgin. Local.
  subroutine begin(self)
    class(newton_t), intent(inout) :: self

    call self%flowing%begin()
    self%last%displacement = spread(0.0_rk, 1, self%system%map%n_dofs)
    self%last%loads = self%last%displacement
    self%last%supports = self%last%displacement
    self%last%multipliers = spread(0.0_rk, 1, self%system%rows%n_rows)
    self%last%energy = 0
    if (allocated(self%remembered)) deallocate (self%remembered)
    if (allocated(self%closed)) deallocate (self%closed)
  end subroutine begin

  !> Solves the next time of a history. The reason of the state says whether there is an answer; without one, the history has ended.
  !> Collective.
  subroutine solve(self, mesh, body, before, now, state, ierr)
    class(newton_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> what was given at the time before; for the first time, what is assumed before it
    type(step_data_t), intent(in) :: before
    type(step_data_t), intent(in) :: now
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr
    type(course_t) :: course
    type(step_data_t) :: middle
    real(rk) :: n_bad(1)

    course%reached = before%time
    allocate (course%slip(self%system%rows%n_rows), source=0.0_rk)
    allocate (course%n_points(size(body%hooke, 3)), course%n_yielding(size(body%hooke, 3)), source=0)
    n_bad(1) = self%flowing%count_bad_properties(body, now%points)
    PetscCall(sum_over_ranks(self%system%comm, n_bad, ierr))
    if (n_bad(1) > 0) then
      course%found%reason = reason_bad_property
      allocate (course%residuals(0))
    else if (self%halves_steps) then
      middle = half_way(before, now)
      PetscCall(advance(self, mesh, body, before, middle, 0, course, ierr))
      if (course%found%reason == reason_converged) then
        PetscCall(advance(self, mesh, body, middle, now, 0, course, ierr))
      end if
    else
      PetscCall(advance(self, mesh, body, before, now, 0, course, ierr))
    end if
    PetscCall(fill_state(self, mesh, body, course, state, ierr))
  end subroutine solve

  !> Makes one step, or its two halves if it does not converge as a whole. Collective.
  recursive subroutine advance(self, mesh, body, before, now, level, course, ierr)
    type(newton_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(step_data_t), intent(in) :: before
    type(step_data_t), intent(in) :: now
    !> how often the step was cut
    integer, intent(in) :: level
    type(course_t), intent(inout) :: course
    PetscErrorCode, intent(out) :: ierr
    type(step_data_t) :: middle

    PetscCall(find_equilibrium(self, mesh, body, now, now%time - before%time, course, ierr))
    call self%flowing%count_yielding(body, course%n_points, course%n_yielding)
    if (course%found%reason == reason_converged) then
      PetscCall(accept_step(self, mesh, body, before, now, course, ierr))
      return
    end if
    if (level == most_cuts .or. course%found%reason == reason_pulled_off) return
    course%n_cuts = course%n_cuts + 1
    middle = half_way(before, now)
    PetscCall(advance(self, mesh, body, before, middle, level + 1, course, ierr))
    if (course%found%reason /= reason_converged) return
    PetscCall(advance(self, mesh, body, middle, now, level + 1, course, ierr))
  end subroutine advance

  !> Returns the mean of what is given at two times.
  pure type(step_data_t) function half_way(one, other) result(middle)
    type(step_data_t), intent(in) :: one
    type(step_data_t), intent(in) :: other

    middle%time = (one%time + other%time) / 2
    middle%prescribed = (one%prescribed + other%prescribed) / 2
    middle%forces = (one%forces + other%forces) / 2
    middle%gap = (one%gap + other%gap) / 2
    middle%friction = (one%friction + other%friction) / 2
    middle%points%imposed = (one%points%imposed + other%points%imposed) / 2
    middle%points%properties = (one%points%properties + other%points%properties) / 2
  end function half_way

  !> Newton's method for one step. course%found has its solution, or the reason why there is none. Collective.
  subroutine find_equilibrium(self, mesh, body, data, dt, course, ierr)
    type(newton_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(step_data_t), intent(in) :: data
    !> [time] length of the step
    real(rk), intent(in) :: dt
    type(course_t), intent(inout) :: course
    PetscErrorCode, intent(out) :: ierr
    type(iterate_t) :: now
    real(rk), allocatable :: direction(:)
    real(rk) :: before, moved, residual, rounding
    logical :: is_whole
    integer :: i

    before = huge(before)
    PetscCall(take_data(self, mesh, body, data, course%external, ierr))
    allocate (now%forces, now%sizes, mold=course%external)
    if (allocated(course%residuals)) deallocate (course%residuals)
    allocate (course%residuals(0))
    now%displacement = self%last%displacement
    PetscCall(evaluate(self, mesh, body, data, dt, now, ierr))
    do i = 1, min(most_iterations, self%solver%max_iterations)
      if (.not. now%is_solved) exit
      PetscCall(solve_linear(self, mesh, body, course, ierr))
      if (course%found%reason /= reason_converged) return
      direction = course%found%displacement - now%displacement
      now%is_solved = all(ieee_is_finite(direction))
      if (.not. now%is_solved) exit
      is_whole = i == 1 .or. before <= stalled_residual
      PetscCall(take_step(self, mesh, body, data, dt, direction, course, is_whole, now, moved, ierr))
      if (.not. now%is_solved) exit
      call measure(self, now, course%external, course%found%multipliers, residual, rounding)
      course%residuals = [course%residuals, residual]
      if (moved < 1) cycle
      if (residual <= max(rounding_of_forces, rounding)) exit
      associate (share => maxval(abs(direction)) / max(maxval(abs(now%displacement)), tiny(moved)))
        if (residual <= merge(multigrid_tolerance, residual_tolerance, self%solver%is_multigrid) .and. share <= step_tolerance) exit
        if (residual <= coarse_residual .and. share <= small_step) exit
      end associate
      if (residual <= stalled_residual .and. residual > stalled_share * before) exit
      before = residual
    end do
    course%energy = now%energy
    course%forces = now%forces
    if (i > min(most_iterations, self%solver%max_iterations) .or. .not. now%is_solved) &
      course%found%reason = reason_no_material_answer
  end subroutine find_equilibrium

  !> Puts what is given at a time into the linear problem, and computes the loads without the forces of imposed strains in cells
  !> that flow. Collective.
  subroutine take_data(self, mesh, body, data, external, ierr)
    type(newton_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(step_data_t), intent(in) :: data
    !> [force] natural, shape (n_dofs)
    real(rk), allocatable, intent(out) :: external(:)
    PetscErrorCode, intent(out) :: ierr

    self%system%boundary%prescribed_values(:, 1) = data%prescribed
    self%system%rows%gap(:, 1) = data%gap
    if (allocated(self%system%laws%friction_factors)) self%system%laws%friction_factors = data%friction
    external = self%flowing%imposed_forces(mesh, body, data%points)
    PetscCall(sum_over_ranks(self%system%comm, external, ierr))
    external = data%forces - external
  end subroutine take_data

  !> Evaluates the laws at an iterate, and the forces there. Collective.
  subroutine evaluate(self, mesh, body, data, dt, now, ierr)
    type(newton_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(step_data_t), intent(in) :: data
    real(rk), intent(in) :: dt
    !> in: displacement
    type(iterate_t), intent(inout) :: now
    PetscErrorCode, intent(out) :: ierr
    PetscScalar, pointer :: local(:)
    real(rk) :: numbers(2, 1)

    associate (system => self%system)
      call self%flowing%evaluate(mesh, body, now%displacement, data%points, dt, now%forces, now%sizes, now%is_solved)
      PetscCall(system%put(now%displacement, system%work_in, ierr))
      PetscCall(MatMult(self%elastic, system%work_in, system%work_out, ierr))
      PetscCall(VecGetArrayReadF90(system%work_out, local, ierr))
      numbers(1, 1) = dot_product(local, now%displacement(system%map%local_dofs)) / 2
      numbers(2, 1) = merge(0, 1, now%is_solved)
      now%forces(system%map%local_dofs) = now%forces(system%map%local_dofs) + local
      now%sizes(system%map%local_dofs) = now%sizes(system%map%local_dofs) + abs(local)
      PetscCall(VecRestoreArrayReadF90(system%work_out, local, ierr))
      PetscCall(sum_over_ranks(system%comm, now%forces, ierr))
      PetscCall(sum_over_ranks(system%comm, now%sizes, ierr))
      PetscCall(sum_over_ranks(system%comm, numbers, ierr))
      now%energy = numbers(1, 1)
      now%is_solved = numbers(2, 1) <= 0 .and. all(ieee_is_finite(now%forces))
    end associate
  end subroutine evaluate

  !> Sets K_k and the loads of the linear problem at the last evaluate. Collective.
  subroutine linearize(self, mesh, body, external, ierr)
    type(newton_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    real(rk), intent(in) :: external(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: forces(size(external))

    forces = 0
    associate (system => self%system)
      PetscCall(MatCopy(self%elastic, system%stiffness, SAME_NONZERO_PATTERN, ierr))
      PetscCall(add_tangents(mesh, body, system%map, self%flowing, system%stiffness, forces, ierr))
      PetscCall(MatNorm(system%stiffness, NORM_INFINITY, system%stiffness_size, ierr))
      PetscCall(sum_over_ranks(system%comm, forces, ierr))
      system%boundary%loads = load_pattern_t()
      call system%boundary%loads%add_forces(1, external + forces)
    end associate
  end subroutine linearize

  !> Solves the linear problem at the last evaluate; course%found gets its solution, or the reason. Collective.
  subroutine solve_linear(self, mesh, body, course, ierr)
    type(newton_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(course_t), intent(inout) :: course
    PetscErrorCode, intent(out) :: ierr
    logical :: all_closed(self%system%rows%n_rows)

    all_closed = .true.
    PetscCall(linearize(self, mesh, body, course%external, ierr))
    if (self%is_ready) then
      PetscCall(self%solver%renew(self%system, ierr))
    else
      PetscCall(self%solver%create(self%system, ierr))
      self%is_ready = .true.
    end if
    select type (solver => self%solver)
    type is (active_set_t)
      if (allocated(solver%start)) deallocate (solver%start)
      if (allocated(self%closed)) solver%start = self%closed
    type is (condensed_t)
      if (allocated(solver%remembered)) deallocate (solver%remembered)
      if (allocated(self%remembered)) solver%remembered = self%remembered
    end select
    PetscCall(self%solver%solve(self%system, [1.0_rk], course%found, ierr))
    ! bodies that are held have a stiffness, unless their material flows everywhere
    if (course%found%reason == reason_floating_body .and. self%system%motions%are_held_by(all_closed)) &
      course%found%reason = reason_no_material_answer
    course%n_iterations = course%n_iterations + 1
    course%n_linear_iterations = course%n_linear_iterations + course%found%n_linear_iterations
    if (course%found%reason == reason_converged) self%closed = course%found%is_active
  end subroutine solve_linear

  !> Goes along a direction, as far as the line search says. Collective.
  subroutine take_step(self, mesh, body, data, dt, direction, course, is_whole, now, moved, ierr)
    type(newton_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(step_data_t), intent(in) :: data
    real(rk), intent(in) :: dt
    !> [length] natural, shape (n_dofs)
    real(rk), intent(in) :: direction(:)
    !> has the loads, and the multipliers of the linear problem
    type(course_t), intent(in) :: course
    !> whether the whole step is taken in any case
    logical, intent(in) :: is_whole
    type(iterate_t), intent(inout) :: now
    !> [-] share of the direction that was taken
    real(rk), intent(out) :: moved
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: given(size(direction)), start(size(direction))
    real(rk) :: lower, lower_work, upper, upper_work, start_work, work
    integer :: i

    start = now%displacement
    given = course%external - self%system%rows%apply_transpose(course%found%multipliers, size(direction))
    start_work = work_along()
    moved = 1
    now%displacement = start + direction
    PetscCall(evaluate(self, mesh, body, data, dt, now, ierr))
    if (is_whole .or. .not. start_work < 0) return
    work = work_along()
    if (now%is_solved .and. work <= -steep * start_work) return
    lower = 0
    lower_work = start_work
    upper = 1
    upper_work = merge(work, -start_work, now%is_solved)
    do i = 1, most_searches
      moved = lower + (upper - lower) * min(0.9_rk, max(0.1_rk, lower_work / (lower_work - upper_work)))
      now%displacement = start + moved * direction
      PetscCall(evaluate(self, mesh, body, data, dt, now, ierr))
      if (.not. now%is_solved) then
        upper = moved
        cycle
      end if
      work = work_along()
      if (abs(work) <= -flat * start_work) return
      if (work < 0) then
        lower = moved
        lower_work = work
      else
        upper = moved
        upper_work = work
      end if
    end do

  contains

    !> Returns the work of the residual on the direction, without the supports.
    real(rk) function work_along()
      work_along = sum(direction * (now%forces - given), mask=.not. self%system%boundary%is_prescribed)
    end function work_along
  end subroutine take_step

  !> Computes the largest entry of int B' sigma + B' lambda - F on the free dofs, over the largest of the parts of these forces.
  !> Local.
  subroutine measure(self, now, external, multipliers, residual, rounding)
    type(newton_t), intent(in) :: self
    type(iterate_t), intent(in) :: now
    !> [force] F
    real(rk), intent(in) :: external(:)
    real(rk), intent(in) :: multipliers(:)
    !> [-]
    real(rk), intent(out) :: residual
    !> [-] how large it is for rounding alone
    real(rk), intent(out) :: rounding
    real(rk) :: contact(size(external)), whole

    contact = self%system%rows%apply_transpose(multipliers, size(external))
    associate (of_displacement => self%system%stiffness_size * maxval(abs(now%displacement)))
      whole = max(maxval(now%sizes), maxval(abs(external)), maxval(abs(contact)), smallest_share * of_displacement, tiny(whole))
      residual = maxval(abs(now%forces + contact - external), mask=.not. self%system%boundary%is_prescribed)
      residual = max(0.0_rk, residual) / whole
      rounding = rounding_of_products * of_displacement / whole
    end associate
  end subroutine measure

  !> Makes the solution of a step the accepted state. Collective.
  subroutine accept_step(self, mesh, body, before, now, course, ierr)
    type(newton_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(step_data_t), intent(in) :: before
    type(step_data_t), intent(in) :: now
    type(course_t), intent(inout) :: course
    PetscErrorCode, intent(out) :: ierr
    type(end_t) :: new
    type(flow_work_t) :: own
    real(rk) :: numbers(5)

    call self%flowing%accept(mesh, body, now%points, own, numbers(1))
    numbers(2:) = [own%imposed, own%inelastic, own%plastic, own%creep]
    PetscCall(sum_over_ranks(self%system%comm, numbers, ierr))
    new%displacement = course%found%displacement
    new%loads = course%external
    new%multipliers = course%found%multipliers
    new%supports = course%forces - new%loads + self%system%rows%apply_transpose(new%multipliers, size(new%loads))
    where (.not. self%system%boundary%is_prescribed) new%supports = 0
    new%energy = course%energy + numbers(1)
    associate (work => course%work, rows => self%system%rows)
      work%imposed = work%imposed + numbers(2)
      work%inelastic = work%inelastic + numbers(3)
      work%plastic = work%plastic + numbers(4)
      work%creep = work%creep + numbers(5)
      work%energy = work%energy + new%energy - self%last%energy
      course%work_size = course%work_size + abs(new%energy) + abs(self%last%energy) + sum(abs(numbers(2:3)))
      associate (moved => new%displacement - self%last%displacement)
        call add_work(self%last%loads, new%loads, moved, work%loads, course%work_size)
        call add_work(self%last%supports, new%supports, moved, work%supports, course%work_size)
        call add_work(self%last%multipliers, new%multipliers, rows%apply(moved), work%contact, course%work_size)
      end associate
      work%gaps = work%gaps + dot_product(new%multipliers + self%last%multipliers, now%gap - before%gap) / 2
      if (allocated(course%found%slip)) then
        work%friction = work%friction + dot_product(new%multipliers, course%found%slip)
        course%slip = course%slip + course%found%slip
      end if
    end associate
    self%last = new
    course%reached = now%time
    select type (solver => self%solver)
    type is (condensed_t)
      if (allocated(solver%latest)) self%remembered = solver%latest
    end select
  end subroutine accept_step

  !> Adds the work of the mean of two forces, and the sizes of its products.
  pure subroutine add_work(old, new, moved, work, sizes)
    !> [force] at both ends
    real(rk), intent(in) :: old(:), new(:)
    !> [length] same shape
    real(rk), intent(in) :: moved(:)
    !> [force*length] grow
    real(rk), intent(inout) :: work
    real(rk), intent(inout) :: sizes

    work = work + dot_product(old + new, moved) / 2
    sizes = sizes + dot_product(abs(old) + abs(new), abs(moved)) / 2
  end subroutine add_work

  !> Fills the state of a time. Collective.
  subroutine fill_state(self, mesh, body, course, state, ierr)
    type(newton_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(course_t), intent(in) :: course
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: counts(size(body%hooke, 3), 2)

    state = course%found
    state%n_iterations = course%n_iterations
    state%n_linear_iterations = course%n_linear_iterations
    allocate (state%flow)
    state%flow%n_cuts = course%n_cuts
    state%flow%reached = course%reached
    state%flow%residuals = course%residuals
    counts = reshape(real([course%n_points, course%n_yielding], rk), shape(counts))
    PetscCall(sum_over_ranks(self%system%comm, counts, ierr))
    state%flow%yielding = counts(:, 2) / max(1.0_rk, counts(:, 1))
    if (state%reason /= reason_converged) then
      call clear_answer(self, state)
      return
    end if
    if (allocated(state%slip)) state%slip = course%slip
    associate (work => course%work)
      state%flow%work = work
      if (course%work_size > 0) state%flow%work_residual = &
        abs(work%loads + work%supports - work%energy - work%imposed - work%inelastic - work%contact) / course%work_size
    end associate
    PetscCall(share_strains(self, plastic_strains, plastic_strain_at, state%flow%plastic, ierr))
    PetscCall(share_strains(self, creep_strains, creep_strain_at, state%flow%creep, ierr))
    PetscCall(linearize(self, mesh, body, course%external, ierr))
    PetscCall(measure_residuals(self%system, [1.0_rk], state, ierr))
    state%energy = self%last%energy
  end subroutine fill_state

  !> Makes the arrays of a state without an answer zeros. Local.
  subroutine clear_answer(self, state)
    type(newton_t), intent(in) :: self
    type(contact_state_t), intent(inout) :: state
    logical, allocatable :: none(:)

    state%displacement = 0 * self%last%displacement
    state%multipliers = 0 * self%last%multipliers
    state%reactions = state%displacement
    allocate (none(size(state%multipliers)), source=.false.)
    call move_alloc(none, state%is_active)
  end subroutine clear_answer

  !> Collects strains of the accepted states, of which each rank has its own points, on all ranks. Collective.
  subroutine share_strains(self, components, equivalent, strains, ierr)
    type(newton_t), intent(in) :: self
    !> their places in a state
    integer, intent(in) :: components(:)
    !> place of the equivalent strain
    integer, intent(in) :: equivalent
    !> [-] shape (size(components) + 1, n_all_points)
    real(rk), allocatable, intent(out) :: strains(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: i

    associate (flowing => self%flowing)
      allocate (strains(size(components) + 1, flowing%n_all_points), source=0.0_rk)
      do i = 1, size(flowing%cells)
        associate (first => flowing%offsets(i) + 1, n => flowing%offsets(i + 1) - flowing%offsets(i))
          strains(:, flowing%places(i) + 1:flowing%places(i) + n) = &
            flowing%old_states([components, equivalent], first:first + n - 1)
        end associate
      end do
      PetscCall(sum_over_ranks(self%system%comm, strains, ierr))
    end associate
  end subroutine share_strains

  !> Frees what the solver has made. Collective.
  subroutine destroy_solver(self, ierr)
    class(newton_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (self%is_ready) then
      PetscCall(self%solver%destroy(ierr))
    end if
    self%is_ready = .false.
  end subroutine destroy_solver

  !> Frees solver and matrices. Collective.
  subroutine destroy(self, ierr)
    class(newton_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    PetscCall(destroy_solver(self, ierr))
    PetscCall(MatDestroy(self%system%stiffness, ierr))
    PetscCall(MatDestroy(self%elastic, ierr))
  end subroutine destroy
end module sig_newton
