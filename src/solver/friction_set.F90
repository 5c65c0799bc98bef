! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Contact with friction or ties where W has no room: the semismooth Newton method of sig_friction_newton, each of whose steps is a
!> sparse linear system (sig_slip_system). It is `active_set` for such decks.
!>
!> The times of a history are solved in their order, each from the states and the displacement of the last one.
module sig_friction_set
  use sig_active_set, only: find_residual, unknown_force
  use sig_contact_laws, only: contact_laws_t
  use sig_contact_solver, only: contact_solver_t
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_friction_newton, only: can_turn, signs_of
  use sig_friction_types, only: contact_open, contact_slips, contact_sticks, friction_workspace_t, length, project, project_contact
  use sig_holding, only: is_last_hold, keep_hold, letting_go
  use sig_kinds, only: rk
  use sig_log, only: log_warning
  use sig_progress, only: progress_t
  use sig_reasons, only: reason_converged, reason_linear_solver, reason_pulled_off, reason_sliding, reason_unsolved_friction
  use sig_rounding, only: dependent, rounding
  use sig_slip_system, only: slip_data_t, slip_system_t
  use petsc
  implicit none(type, external)
  private
  public :: friction_set_t

  !> What is carried from one time to the next.
  type :: memory_t
    !> [length] natural
    real(rk), allocatable :: displacement(:)
    !> [force] of all rows
    real(rk), allocatable :: multipliers(:)
    !> [force] T' (K u - F), natural
    real(rk), allocatable :: left(:)
    !> [length] of tangential rows: places from which slips count; shape (n_rows)
    real(rk), allocatable :: origins(:)
    !> given at the last time, with bounds for slips that count from it
    type(slip_data_t) :: data
    !> states, directions and softness
    type(friction_workspace_t) :: workspace
  end type memory_t

  !> The contact solver `active_set` for friction and ties. Call create, then solve or solve_points, then destroy.
  type, extends(contact_solver_t) :: friction_set_t
    !> whether the progress of a history is told
    logical :: tells_progress = .false.
    type(slip_system_t), private :: linear
    !> [force/length] c_n and c_t of each contact, shape (2, n_contacts)
    real(rk), allocatable, private :: c(:, :)
  contains
    procedure :: create
    procedure :: solve
    procedure :: n_points_at_once
    procedure :: solve_points
    procedure :: destroy
  end type friction_set_t

  !> [-] largest natural residual of an answer where the last step has not halved it; else it is at most `rounding`
  real(rk), parameter :: accepted_residual = 1.0e-9_rk
  !> [-] by which the residual of the linear system falls where the states have changed, and where they have not
  real(rk), parameter :: coarse = 0.03_rk, finer = 1.0e-3_rk
  !> [-] natural residual from which on linear systems are solved as accurately as possible
  real(rk), parameter :: near = 1.0e-5_rk
  !> [-] compliance of a contact over that of its nodes alone, in the plane and in space; and of c_n over c_t. Both are larger than
  !> the true ones: then fewer steps overshoot, so that states come back less often (random blocks with 41 and 49 contacts)
  real(rk), parameter :: spread_of_forces(2:3) = [10.0_rk, 3.0_rk], softer_tangents = 4.0_rk
  !> [-] of the contacts that ask for another state, those change it that miss their laws by at least this share of the largest
  !> miss: at first all of them, where a set of states has come back all by finer solutions, then fewer each time, at last one
  real(rk), parameter :: shares(4) = [0.0_rk, 0.0_rk, 0.3_rk, 1.0_rk]
  !> a run ends after this number of steps in which the residual has not fallen by a tenth
  integer, parameter :: patience = 8
  real(rk), parameter :: fallen = 0.9_rk
  !> a time that is not solved is reached by steps of its loads, no smaller than this share
  real(rk), parameter :: smallest_step = 1.0_rk / 32
  !> [s] progress is told only if a history takes longer
  real(rk), parameter :: seconds_of_silence = 3

contains

  !> Makes the linear systems. Collective.
  subroutine create(self, system, ierr)
    class(friction_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr

    self%linear%is_multigrid = self%is_multigrid
    PetscCall(self%linear%create(system, ierr))
    PetscCall(scale_projections(self, system, ierr))
  end subroutine create

  !> Sets c_n and c_t to the inverse of estimated compliances of the rows, multiples of B diag(K)^-1 B'. Collective.
  subroutine scale_projections(self, system, ierr)
    class(friction_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: diagonal(system%map%n_dofs), compliance(system%rows%n_rows)
    integer :: k

    PetscCall(MatGetDiagonal(system%stiffness, system%work_in, ierr))
    PetscCall(system%get(system%work_in, diagonal, ierr))
    where (system%boundary%is_prescribed) diagonal = huge(diagonal)
    do k = 1, size(compliance)
      compliance(k) = spread_of_forces(system%map%n_dim) * &
        sum(system%rows%coefficients_of(k)**2 / diagonal(system%rows%dofs_of(k)))
    end do
    if (allocated(self%c)) deallocate (self%c)
    allocate (self%c(2, system%laws%n_contacts))
    do k = 1, system%laws%n_contacts
      self%c(:, k) = 1 / compliance(k)
      associate (tangents => system%laws%tangents(:system%laws%n_tangents(k), k))
        if (size(tangents) > 0) self%c(2, k) = 1 / (softer_tangents * maxval(compliance(tangents)))
      end associate
    end do
  end subroutine scale_projections

  !> Solves one point, which is a history of one time. Collective.
  subroutine solve(self, system, theta, state, ierr)
    class(friction_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:)
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr
    type(contact_state_t) :: states(1)

    PetscCall(solve_history(self, system, reshape(theta, [size(theta), 1]), states, ierr))
    state = states(1)
  end subroutine solve

  !> Returns the number of times of a history.
  pure integer function n_points_at_once(self, system) result(n_points)
    class(friction_set_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system

    n_points = system%n_times
  end function n_points_at_once

  !> Solves whole histories, one after the other. Collective.
  subroutine solve_points(self, system, theta, states, ierr)
    class(friction_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:, :)
    type(contact_state_t), intent(out) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    integer :: first

    ierr = 0
    do first = 1, size(states), system%n_times
      associate (last => first + system%n_times - 1)
        PetscCall(solve_history(self, system, theta(:, first:last), states(first:last), ierr))
      end associate
    end do
  end subroutine solve_points

  !> Solves the states of one history in their order, from the state before anything has happened. If multigrid fails and may_factor
  !> is true, factorizations solve the history again and all later ones. Collective.
  subroutine solve_history(self, system, theta, states, ierr)
    class(friction_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    !> [-] values of the terms in each state, shape (n_terms, n_times)
    real(rk), intent(in) :: theta(:, :)
    type(contact_state_t), intent(out) :: states(:)
    PetscErrorCode, intent(out) :: ierr

    PetscCall(walk(self, system, theta, states, ierr))
    if (all(states%reason /= reason_linear_solver) .or. .not. (self%is_multigrid .and. self%may_factor)) return
    call log_warning('iterations with multigrid failed: from here on the stiffness is factored')
    PetscCall(self%linear%destroy(ierr))
    self%is_multigrid = .false.
    PetscCall(self%create(system, ierr))
    PetscCall(walk(self, system, theta, states, ierr))
  end subroutine solve_history

  !> Goes through the times. A state that has no answer gets the reason why, and the later states get the same reason. Collective.
  subroutine walk(self, system, theta, states, ierr)
    class(friction_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:, :)
    type(contact_state_t), intent(inout) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    type(memory_t) :: memory
    type(progress_t) :: progress
    integer :: i, reason

    ierr = 0
    if (self%tells_progress) call progress%start('times with friction', size(states), seconds_of_silence)
    call begin(self, system, theta(:, 1), memory)
    reason = reason_converged
    do i = 1, size(states)
      states(i) = contact_state_t()
      states(i)%reason = reason
      if (reason == reason_converged) then
        PetscCall(solve_time(self, system, theta(:, i), memory, states(i), ierr))
      end if
      reason = states(i)%reason
      call take_answer(self, system, theta(:, i), memory, states(i))
      if (self%tells_progress) call progress%advance(i)
    end do
    if (self%tells_progress) call progress%finish()
  end subroutine walk

  !> Begins a history: nothing is displaced, loaded or has slipped, overlaps are zero, and all contacts are closed, which holds
  !> bodies.
  subroutine begin(self, system, theta, memory)
    class(friction_set_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> at the first time
    real(rk), intent(in) :: theta(:)
    type(memory_t), intent(out) :: memory

    associate (n => system%map%n_dofs, n_rows => system%rows%n_rows)
      allocate (memory%displacement(n), memory%left(n), memory%multipliers(n_rows), memory%origins(n_rows), source=0.0_rk)
      memory%data = data_at(self, system, theta, memory%origins)
      memory%data%forces = 0
      memory%data%prescribed = 0
      memory%data%bounds = max(0.0_rk, system%gap(theta)) / self%linear%form%norms
      memory%data%bounds(system%laws%n_contacts + 1:) = 0
    end associate
    call memory%workspace%reserve_projections(system%laws%friction_contacts_t)
    memory%workspace%c = self%c
    memory%workspace%states = merge(contact_sticks, contact_slips, system%laws%have_friction() .or. system%laws%is_tied)
  end subroutine begin

  !> Returns what is given at a point.
  pure type(slip_data_t) function data_at(self, system, theta, origins) result(data)
    class(friction_set_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    real(rk), intent(in) :: theta(:)
    !> [length] shape (n_rows)
    real(rk), intent(in) :: origins(:)

    data%forces = system%load(theta)
    data%prescribed = system%prescribed_displacement(theta)
    data%bounds = self%linear%form%bounds(system, theta) + origins / self%linear%form%norms
    data%friction = merge(system%laws%friction_at(theta), 0.0_rk, system%laws%have_friction())
  end function data_at

  !> Solves the next time: at once or, if that fails, through smaller steps of what is given. Slips always count from the last time,
  !> so that these steps change only the start. Collective.
  subroutine solve_time(self, system, theta, memory, state, ierr)
    class(friction_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:)
    !> in: of the last time; out: of this one
    type(memory_t), intent(inout) :: memory
    !> gets reason and numbers of iterations
    type(contact_state_t), intent(inout) :: state
    PetscErrorCode, intent(out) :: ierr
    type(slip_data_t) :: start, target
    type(memory_t) :: reached
    real(rk) :: share, step

    ierr = 0
    target = data_at(self, system, theta, memory%origins)
    start = memory%data
    share = 0
    step = 1
    do
      reached = memory
      reached%data = between(start, target, share + step)
      PetscCall(run_newton(self, system, reached, state, ierr))
      if (state%reason == reason_converged) then
        memory = reached
        share = share + step
        if (.not. share < 1) exit
        step = min(2 * step, 1 - share)
      else if (any(state%reason == [reason_unsolved_friction, reason_sliding, reason_pulled_off]) .and. step > smallest_step) then
        step = step / 2
      else
        exit
      end if
    end do
  end subroutine solve_time

  !> Returns what is given between two times.
  pure type(slip_data_t) function between(one, other, share) result(data)
    type(slip_data_t), intent(in) :: one, other
    !> [-] 0 is the first one, 1 the other
    real(rk), intent(in) :: share

    data = other
    if (.not. share < 1) return
    data%forces = (1 - share) * one%forces + share * other%forces
    data%prescribed = (1 - share) * one%prescribed + share * other%prescribed
    data%bounds = (1 - share) * one%bounds + share * other%bounds
    data%friction = (1 - share) * one%friction + share * other%friction
  end function between

  !> Runs Newton's method from the states and the displacement of the memory. Collective.
  subroutine run_newton(self, system, memory, state, ierr)
    class(friction_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    !> out: the answer, where there is one
    type(memory_t), intent(inout) :: memory
    !> reason is set, numbers of iterations grow
    type(contact_state_t), intent(inout) :: state
    PetscErrorCode, intent(out) :: ierr
    type(friction_workspace_t) :: asked, before
    real(rk) :: last, lowest, reduction, residual
    integer, allocatable :: seen(:, :)
    logical :: is_same, unwilling(system%rows%n_rows)
    integer :: i, i_lowest, level

    ierr = 0
    state%reason = reason_unsolved_friction
    if (allocated(state%drift)) deallocate (state%drift)
    allocate (seen(system%laws%n_contacts, 0))
    reduction = coarse
    residual = huge(residual)
    lowest = huge(lowest)
    unwilling = .false.
    ! what is not held could move by any amount, and beside that no residual is large
    if (.not. system%motions%are_held_by(self%linear%rows_held(system, memory%workspace%states))) return
    level = 1
    i_lowest = 1
    do i = 1, self%max_iterations
      before = memory%workspace
      last = residual
      state%n_iterations = state%n_iterations + 1
      PetscCall(self%linear%solve(system, memory%data, memory%workspace, reduction, memory%displacement, ierr))
      state%n_linear_iterations = state%n_linear_iterations + self%linear%linear_solver%n_iterations
      if (self%linear%linear_solver%reason /= reason_converged) then
        ! where contacts slip, the system of some states is singular
        if (.not. (self%linear%coupled%has_coupling .and. self%linear%linear_solver%ksp /= 0)) &
          state%reason = self%linear%linear_solver%reason
        return
      end if
      PetscCall(project_forces(self, system, memory, residual, ierr))
      call keep_bodies(self, system, memory, before, unwilling)
      is_same = same_states(before, memory%workspace)
      if (.not. reduction > 0 .and. (residual <= rounding .or. &
        (residual <= accepted_residual .and. residual > last / 2 .and. is_same))) then
        state%reason = reason_converged
        return
      end if
      if (.not. reduction > 0 .and. is_same .and. any(unwilling)) exit
      if (is_same .and. (reduction <= finer .or. residual <= near .or. &
        .not. can_turn(system%laws%friction_contacts_t, memory%workspace))) then
        reduction = 0
      else
        reduction = merge(finer, coarse, is_same .or. level > 1)
      end if
      if (is_same) cycle
      if (residual > lowest / 2 .and. was_seen(memory%workspace, seen)) then
        level = level + 1
        deallocate (seen)
        allocate (seen(system%laws%n_contacts, 0))
        if (level > size(shares)) exit
      end if
      if (residual < fallen * lowest) i_lowest = i
      if (i - i_lowest >= patience .and. level == 1) exit
      lowest = min(lowest, residual)
      seen = reshape([seen, signs_of(memory%workspace%states, memory%workspace%directions)], [size(seen, 1), size(seen, 2) + 1])
      asked = memory%workspace
      call change_worst(system, shares(level), memory, before)
      call keep_bodies(self, system, memory, before, unwilling)
      ! what holds a body changes from one contact to another, and one alone may not
      if (same_states(before, memory%workspace)) then
        memory%workspace = asked
        unwilling = .false.
      end if
    end do
    if (any(unwilling)) call find_motion(self, system, memory, unwilling, state)
  end subroutine run_newton

  !> Computes forces and openings from the displacement, and the states that they ask for. Collective.
  subroutine project_forces(self, system, memory, residual, ierr)
    class(friction_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    type(memory_t), intent(inout) :: memory
    !> [-] natural residual
    real(rk), intent(out) :: residual
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: unknowns(system%map%n_dofs), size_of_row
    logical :: all_rows(system%rows%n_rows)
    integer :: k

    all_rows = .true.
    unknowns = memory%displacement
    call self%linear%form%to_unknowns(system, unknowns)
    PetscCall(find_residual(self%linear%form, system, memory%data%forces, memory%displacement, all_rows, memory%left, ierr))
    memory%multipliers = self%linear%form%multipliers(memory%left)
    associate (workspace => memory%workspace, norms => self%linear%form%norms)
      workspace%w = norms * (memory%data%bounds - unknowns(self%linear%form%bounded_dofs))
      size_of_row = 0
      do k = 1, size(workspace%w)
        size_of_row = max(size_of_row, abs(norms(k) * memory%data%bounds(k)) + &
          dot_product(abs(system%rows%coefficients_of(k)), abs(memory%displacement(system%rows%dofs_of(k)))))
      end do
      workspace%row_size = size_of_row
      call project(memory%data%friction, system%laws%friction_contacts_t, memory%multipliers, workspace, residual)
    end associate
  end subroutine project_forces

  !> Whether two steps have the same states; in the plane those with the same directions.
  pure logical function same_states(one, other)
    type(friction_workspace_t), intent(in) :: one, other

    same_states = all(one%states == other%states)
    if (same_states) same_states = .not. any(one%states == contact_slips .and. &
      one%directions(1, :) * other%directions(1, :) + one%directions(2, :) * other%directions(2, :) < 0)
  end function same_states

  !> Whether the states are among those seen.
  pure logical function was_seen(workspace, seen)
    type(friction_workspace_t), intent(in) :: workspace
    !> of signs_of, shape (n_contacts, n)
    integer, intent(in) :: seen(:, :)
    integer :: i, signs(size(seen, 1))

    signs = signs_of(workspace%states, workspace%directions)
    was_seen = .false.
    do i = 1, size(seen, 2)
      was_seen = was_seen .or. all(seen(:, i) == signs)
    end do
  end function was_seen

  !> Changes the states so that closed contacts always hold the bodies which nothing else holds: of those that open or slip, the
  !> ones that miss their laws least stay as they were.
  subroutine keep_bodies(self, system, memory, before, unwilling)
    class(friction_set_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    type(memory_t), intent(inout) :: memory
    !> states of the step, which hold the bodies
    type(friction_workspace_t), intent(in) :: before
    !> rows that hold a body against their laws, shape (n_rows)
    logical, intent(out) :: unwilling(:)
    real(rk) :: margins(system%rows%n_rows)
    logical :: kept(system%rows%n_rows), wanted(system%rows%n_rows)
    integer :: k

    unwilling = .false.
    if (system%motions%n_free == 0) return
    wanted = self%linear%rows_held(system, memory%workspace%states)
    if (system%motions%are_held_by(wanted)) return
    margins = memory%multipliers
    do k = 1, system%laws%n_contacts
      margins(system%laws%tangents(:system%laws%n_tangents(k), k)) = memory%data%friction(k) * memory%multipliers(k) - &
        length(system%laws%tangential(k, memory%multipliers))
    end do
    kept = wanted
    call keep_hold(system%motions, self%linear%rows_held(system, before%states), margins, kept)
    unwilling = kept .and. .not. wanted
    do k = 1, system%laws%n_contacts
      if (any(kept(system%laws%rows_of(k)) .neqv. wanted(system%laws%rows_of(k)))) call take_state(before, k, memory%workspace)
    end do
  end subroutine keep_bodies

  !> Finds whether there is no equilibrium, where a row holds a body against its law: without this row, the body moves so that
  !> nothing else stops it. No other contact opens, closes or stops to stick in this motion, and those that slip go on with it.
  subroutine find_motion(self, system, memory, unwilling, state)
    class(friction_set_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    type(memory_t), intent(in) :: memory
    !> shape (n_rows), at least one
    logical, intent(in) :: unwilling(:)
    !> gets reason_sliding or reason_pulled_off and drift, or reason_unsolved_friction
    type(contact_state_t), intent(inout) :: state
    real(rk) :: motion(system%rows%n_rows), amplitudes(system%motions%n_free)
    logical :: is_held(system%rows%n_rows)
    integer :: k, row

    state%reason = reason_unsolved_friction
    is_held = self%linear%rows_held(system, memory%workspace%states)
    row = findloc(unwilling .and. is_last_hold(system%motions, is_held), .true., dim=1)
    if (row == 0) return
    amplitudes = letting_go(system%motions, is_held, row)
    motion = matmul(system%motions%closing, amplitudes)
    ! along the force of a tangential row, which is opposite to that on the body
    if (row > system%laws%n_contacts .and. memory%multipliers(row) > 0) then
      amplitudes = -amplitudes
      motion = -motion
    end if
    do k = 1, system%laws%n_contacts
      associate (rows => system%laws%tangents(:system%laws%n_tangents(k), k))
        if (memory%workspace%states(k) == contact_open .and. motion(k) > dependent * maxval(abs(motion))) return
        if (memory%workspace%states(k) == contact_slips .and. &
          dot_product(memory%multipliers(rows), motion(rows)) < 0) return
      end associate
    end do
    state%reason = merge(reason_sliding, reason_pulled_off, row > system%laws%n_contacts)
    state%drift = amplitudes
  end subroutine find_motion

  !> Takes the state of a contact from another step.
  pure subroutine take_state(from, k, workspace)
    type(friction_workspace_t), intent(in) :: from
    integer, intent(in) :: k
    type(friction_workspace_t), intent(inout) :: workspace

    workspace%states(k) = from%states(k)
    workspace%directions(:, k) = from%directions(:, k)
    workspace%softness(k) = from%softness(k)
  end subroutine take_state

  !> Lets only those contacts change their states that miss their laws most.
  pure subroutine change_worst(system, share, memory, before)
    type(contact_system_t), intent(in) :: system
    !> [-] of the largest miss
    real(rk), intent(in) :: share
    type(memory_t), intent(inout) :: memory
    type(friction_workspace_t), intent(in) :: before
    type(friction_workspace_t) :: asked
    real(rk) :: missed(system%laws%n_contacts)
    integer :: k

    asked = memory%workspace
    missed = 0
    do k = 1, size(missed)
      if (asked%states(k) == before%states(k) .and. .not. dot_product(asked%directions(:, k), before%directions(:, k)) < 0) cycle
      call project_contact(memory%data%friction, system%laws%friction_contacts_t, k, memory%multipliers, asked, missed(k))
    end do
    do k = 1, size(missed)
      if (missed(k) > 0 .and. missed(k) < share * maxval(missed)) call take_state(before, k, memory%workspace)
    end do
  end subroutine change_worst

  !> Copies the answer of a time, or the reason why there is none, into its state, and goes on to the next time: from there on slips
  !> count from the present places.
  subroutine take_answer(self, system, theta, memory, state)
    class(friction_set_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    real(rk), intent(in) :: theta(:)
    type(memory_t), intent(inout) :: memory
    type(contact_state_t), intent(inout) :: state
    real(rk) :: origins(system%rows%n_rows), smallest
    integer :: k

    state%n_solutions = 0
    state%friction = system%laws%friction_at(theta)
    state%origins = memory%origins
    allocate (state%displacement(system%map%n_dofs), state%multipliers(system%rows%n_rows), state%slip(system%rows%n_rows), &
      source=0.0_rk)
    allocate (state%is_active(system%rows%n_rows), state%slips(system%laws%n_contacts), source=.false.)
    if (state%reason /= reason_converged) return
    associate (workspace => memory%workspace, laws => system%laws)
      do k = 1, laws%n_contacts
        state%is_active(laws%rows_of(k)) = workspace%states(k) /= contact_open
      end do
      smallest = unknown_force(self%linear%form, system, theta, memory%displacement, memory%left, state%is_active)
      origins = memory%origins
      do k = 1, laws%n_contacts
        if (memory%multipliers(k) <= smallest .and. .not. laws%is_tied(k)) workspace%states(k) = contact_open
        call obey(laws, memory%data%friction(k), k, workspace%states(k), memory%multipliers)
        state%is_active(laws%rows_of(k)) = workspace%states(k) /= contact_open
        associate (rows => laws%tangents(:laws%n_tangents(k), k))
          if (workspace%states(k) /= contact_sticks) origins(rows) = origins(rows) - workspace%w(rows)
          if (workspace%states(k) == contact_slips) state%slip(rows) = -workspace%w(rows)
        end associate
      end do
      state%slips = workspace%states == contact_slips .and. (laws%tangents(1, :) > 0 .or. .not. laws%friction_factors > 0)
    end associate
    state%multipliers = memory%multipliers
    state%displacement = memory%displacement
    call system%motions%idle%leave_out(system%motions, state%displacement)
    memory%data%bounds = memory%data%bounds + (origins - memory%origins) / self%linear%form%norms
    memory%origins = origins
  end subroutine take_answer

  !> Makes the forces of a contact what its state says, which they miss by what is left of the linear system.
  pure subroutine obey(laws, friction, k, state, multipliers)
    type(contact_laws_t), intent(in) :: laws
    real(rk), intent(in) :: friction
    integer, intent(in) :: k
    integer, intent(in) :: state
    real(rk), intent(inout) :: multipliers(:)
    real(rk) :: radius, size_of_force

    if (laws%is_tied(k)) return
    if (state == contact_open) multipliers(k) = 0
    radius = friction * multipliers(k)
    size_of_force = length(laws%tangential(k, multipliers))
    if (.not. size_of_force > 0 .or. (state == contact_sticks .and. size_of_force <= radius)) return
    associate (rows => laws%tangents(:laws%n_tangents(k), k))
      multipliers(rows) = multipliers(rows) * (radius / size_of_force)
    end associate
  end subroutine obey

  !> Frees the linear systems. Collective.
  subroutine destroy(self, ierr)
    class(friction_set_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%linear%destroy(ierr))
  end subroutine destroy
end module sig_friction_set
