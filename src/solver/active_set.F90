! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Primal-dual active set on the bound form: closed pairs are prescribed unknowns, each step is one Cholesky factorization.
module sig_active_set
  use sig_bound_form, only: bound_form_t
  use sig_contact_solver, only: contact_solver_t
  use sig_contact_state, only: contact_state_t, reason_converged, reason_max_iterations
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_linear_solver, only: constrain, linear_solver_t
  use petsc
  implicit none(type, external)
  private
  public :: active_set_t, next_active_set, finish_state

  type, extends(contact_solver_t) :: active_set_t
    type(bound_form_t) :: form
    type(linear_solver_t) :: linear_solver
  contains
    procedure :: create
    procedure :: solve
    procedure :: destroy
  end type active_set_t

  !> [-] a multiplier or a penetration this far below the largest of its kind is rounding, and changes no status
  real(rk), parameter :: rounding = 1.0e-12_rk

contains

  subroutine create(self, system, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%form%create(system, ierr))
  end subroutine create

  !> Starts with every pair closed, so that a body held only by contact is held from the first step on. When the active set comes
  !> back to an earlier one ("ping-pong"), only the first wrong pair changes from then on: that cannot cycle, because W = B K^-1 B'
  !> is positive definite (Murty's least-index rule), but needs more steps.
  subroutine solve(self, system, theta, state, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:)
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr
    logical, allocatable :: history(:, :)
    logical :: next(system%operator%n_rows), is_single
    real(rk) :: unknowns(system%map%n_dofs), residual(system%map%n_dofs)

    is_single = .false.
    allocate (state%is_active(system%operator%n_rows), source=.true.)
    allocate (history(system%operator%n_rows, 0))
    state%reason = reason_max_iterations
    do while (state%n_iterations < self%max_iterations)
      state%n_iterations = state%n_iterations + 1
      PetscCall(solve_with_closed(self, system, theta, state%is_active, unknowns, residual, ierr))
      if (self%linear_solver%reason /= reason_converged) then
        state%reason = self%linear_solver%reason
        exit
      end if
      next = next_active_set(state%is_active, self%form%multipliers(residual), &
        unknowns(self%form%bounded_dofs) - self%form%bounds(system, theta), maxval(abs(unknowns)))
      if (all(next .eqv. state%is_active)) then
        state%reason = reason_converged
        exit
      end if
      if (.not. is_single) is_single = has_column(history, next)
      if (is_single) next = change_one(state%is_active, next)
      history = reshape([history, next], [size(next), size(history, 2) + 1])
      state%is_active = next
    end do
    call finish_state(self%form, system, unknowns, residual, state)
  end subroutine solve

  !> One step: unknowns of closed pairs sit on their bounds. Collective.
  subroutine solve_with_closed(self, system, theta, is_closed, unknowns, residual, ierr)
    class(active_set_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:)
    logical, intent(in) :: is_closed(:)
    !> [length] reflected unknowns, natural
    real(rk), intent(out) :: unknowns(:)
    !> [force] R (K R x - F), natural
    real(rk), intent(out) :: residual(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: values(system%map%n_dofs), forces(system%map%n_dofs)
    Mat :: constrained
    Vec :: rhs, solution

    values = system%prescribed_displacement(theta)
    values(self%form%bounded_dofs) = self%form%bounds(system, theta)
    forces = system%load(theta)
    call self%form%reflect(system, forces)
    associate (dofs => [system%boundary%prescribed_dofs, pack(self%form%bounded_dofs, is_closed)])
      PetscCall(constrain(system, self%form%matrix, dofs, values, forces, constrained, rhs, ierr))
    end associate
    PetscCall(self%linear_solver%factor(constrained, 'active_set_', ierr))
    unknowns = 0
    residual = 0
    if (self%linear_solver%reason == reason_converged) then
      PetscCall(VecDuplicate(rhs, solution, ierr))
      PetscCall(self%linear_solver%solve_vector(rhs, solution, ierr))
      PetscCall(system%get(solution, unknowns, ierr))
      PetscCall(MatMult(self%form%matrix, solution, rhs, ierr))
      PetscCall(system%get(rhs, residual, ierr))
      residual = residual - forces
      PetscCall(VecDestroy(solution, ierr))
    end if
    PetscCall(MatDestroy(constrained, ierr))
    PetscCall(VecDestroy(rhs, ierr))
  end subroutine solve_with_closed

  !> A closed pair stays closed while it pushes; an open one closes when it penetrates.
  pure function next_active_set(is_closed, multipliers, penetration, length_scale) result(next)
    logical, intent(in) :: is_closed(:)
    !> [force] shape (n_rows)
    real(rk), intent(in) :: multipliers(:)
    !> [length] > 0 beyond the bound, shape (n_rows)
    real(rk), intent(in) :: penetration(:)
    real(rk), intent(in) :: length_scale
    logical :: next(size(is_closed))
    real(rk) :: force_scale

    force_scale = maxval(abs(multipliers), mask=is_closed)
    next = merge(multipliers >= -rounding * force_scale, penetration > rounding * length_scale, is_closed)
  end function next_active_set

  !> The current set with the first of the wanted changes.
  pure function change_one(current, wanted) result(next)
    logical, intent(in) :: current(:)
    logical, intent(in) :: wanted(:)
    logical :: next(size(current))
    integer :: first

    next = current
    first = findloc(current .neqv. wanted, .true., dim=1)
    if (first > 0) next(first) = wanted(first)
  end function change_one

  !> Back to displacements and nodal forces; a force that is negative by rounding only is zero.
  pure subroutine finish_state(form, system, unknowns, residual, state)
    type(bound_form_t), intent(in) :: form
    type(contact_system_t), intent(in) :: system
    real(rk), intent(in) :: unknowns(:)
    real(rk), intent(in) :: residual(:)
    type(contact_state_t), intent(inout) :: state

    state%displacement = unknowns
    call form%reflect(system, state%displacement)
    state%multipliers = merge(max(form%multipliers(residual), 0.0_rk), 0.0_rk, state%is_active)
  end subroutine finish_state

  pure logical function has_column(columns, column)
    logical, intent(in) :: columns(:, :)
    logical, intent(in) :: column(:)
    integer :: i

    has_column = .false.
    do i = 1, size(columns, 2)
      has_column = has_column .or. all(columns(:, i) .eqv. column)
    end do
  end function has_column

  subroutine destroy(self, ierr)
    class(active_set_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%linear_solver%destroy(ierr))
    PetscCall(self%form%destroy(ierr))
  end subroutine destroy
end module sig_active_set
