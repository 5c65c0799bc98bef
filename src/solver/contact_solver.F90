! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The interface of all full-order contact solvers: create for one system, solve for one parameter point or many, destroy.
module sig_contact_solver
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use petsc
  implicit none(type, external)
  private
  public :: contact_solver_t

  !> What all contact solvers have. Set the components, call create for a system, then solve or solve_points, then destroy.
  type, abstract :: contact_solver_t
    !> largest number of steps at one point; `snesvi` may need twice as many in its two attempts, `condensed` does not use it
    integer :: max_iterations = 50
    !> whether conjugate gradients with multigrid solve the linear systems, and not factorizations
    logical :: is_multigrid = .false.
    !> whether the stiffness may be factored, as where multigrid fails
    logical :: may_factor = .false.
    !> whether a dof belongs to a body whose stiffness changes again and again, natural, shape (n_dofs): the solver keeps what renew
    !> can use; not allocated: renew is not called
    logical, allocatable :: changing_dofs(:)
  contains
    procedure(create_solver), deferred :: create
    procedure :: renew
    procedure(solve_point), deferred :: solve
    procedure :: n_points_at_once
    procedure :: solve_points
    procedure(destroy_solver), deferred :: destroy
  end type contact_solver_t

  abstract interface
    !> Prepares the solver for a system. Collective on the system's communicator.
    subroutine create_solver(self, system, ierr)
      import :: contact_solver_t, contact_system_t
      class(contact_solver_t), intent(inout) :: self
      type(contact_system_t), intent(inout) :: system
      PetscErrorCode, intent(out) :: ierr
    end subroutine create_solver

    !> Solves one point: sets displacement, multipliers, active set, iterations and reason of the state. A failure is a reason and
    !> not an error. Collective.
    subroutine solve_point(self, system, theta, state, ierr)
      import :: contact_solver_t, contact_state_t, contact_system_t, rk
      class(contact_solver_t), intent(inout) :: self
      type(contact_system_t), intent(inout) :: system
      !> [-] values of the terms at the point, shape (n_terms)
      real(rk), intent(in) :: theta(:)
      type(contact_state_t), intent(out) :: state
      PetscErrorCode, intent(out) :: ierr
    end subroutine solve_point

    !> Frees the memory of the solver. Collective.
    subroutine destroy_solver(self, ierr)
      import :: contact_solver_t
      class(contact_solver_t), intent(inout) :: self
      PetscErrorCode, intent(out) :: ierr
    end subroutine destroy_solver
  end interface

contains

  !> Prepares the solver again after new values in the stiffness at changing_dofs, whose pattern stays, and in loads, prescribed
  !> displacements and gaps. This default begins from nothing. Requires: create. Collective.
  subroutine renew(self, system, ierr)
    class(contact_solver_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%destroy(ierr))
    PetscCall(self%create(system, ierr))
  end subroutine renew

  !> Returns how many points one call of solve_points should solve: more than one if they cost less together, but at most about a
  !> second of work, because a kill of the program loses this work. This default is 1.
  pure integer function n_points_at_once(self, system) result(n_points)
    class(contact_solver_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system

    n_points = 1
  end function n_points_at_once

  !> Solves several points; a failure is the reason of a state. This default solves one after the other. Collective.
  subroutine solve_points(self, system, theta, states, ierr)
    class(contact_solver_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    !> [-] values of the terms at each point, shape (n_terms, n_points)
    real(rk), intent(in) :: theta(:, :)
    !> shape (n_points)
    type(contact_state_t), intent(out) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    integer :: i

    ierr = 0
    do i = 1, size(states)
      PetscCall(self%solve(system, theta(:, i), states(i), ierr))
    end do
  end subroutine solve_points
end module sig_contact_solver
