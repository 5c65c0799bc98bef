! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> What every full-order contact solver offers: create for one system, solve for one parameter point, destroy.
module sig_contact_solver
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use petsc
  implicit none(type, external)
  private
  public :: contact_solver_t

  type, abstract :: contact_solver_t
    integer :: max_iterations = 50
  contains
    procedure(create_solver), deferred :: create
    procedure(solve_point), deferred :: solve
    procedure(destroy_solver), deferred :: destroy
  end type contact_solver_t

  abstract interface
    !> Collective on the system's communicator.
    subroutine create_solver(self, system, ierr)
      import :: contact_solver_t, contact_system_t
      class(contact_solver_t), intent(inout) :: self
      type(contact_system_t), intent(inout) :: system
      PetscErrorCode, intent(out) :: ierr
    end subroutine create_solver

    !> Collective. Fills displacement, multipliers, active set, iterations and reason; a failure is a reason.
    subroutine solve_point(self, system, theta, state, ierr)
      import :: contact_solver_t, contact_state_t, contact_system_t, rk
      class(contact_solver_t), intent(inout) :: self
      type(contact_system_t), intent(inout) :: system
      !> [-] values of the terms at the point, shape (n_terms)
      real(rk), intent(in) :: theta(:)
      type(contact_state_t), intent(out) :: state
      PetscErrorCode, intent(out) :: ierr
    end subroutine solve_point

    subroutine destroy_solver(self, ierr)
      import :: contact_solver_t
      class(contact_solver_t), intent(inout) :: self
      PetscErrorCode, intent(out) :: ierr
    end subroutine destroy_solver
  end interface
end module sig_contact_solver
