! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Makes the contact solver that a plan names.
module sig_solver_choice
  use sig_active_set, only: active_set_t
  use sig_condensed, only: condensed_t
  use sig_contact_solver, only: contact_solver_t
  use sig_friction_set, only: friction_set_t
  use sig_petsc_support, only: precondition_failed
  use sig_snes_vi, only: snes_vi_t
  use sig_solver_plan, only: solver_plan_t
  use petsc
  implicit none(type, external)
  private
  public :: choose_solver

contains

  !> Allocates the solver that the plan names and sets max_iterations, is_multigrid and may_factor; the caller then calls its create
  !> for a system. ierr is set if the plan has an unknown type. Local.
  subroutine choose_solver(plan, max_iterations, solver, ierr, has_plain_contact)
    type(solver_plan_t), intent(in) :: plan
    !> largest number of steps at one parameter point
    integer, intent(in) :: max_iterations
    class(contact_solver_t), allocatable, intent(out) :: solver
    PetscErrorCode, intent(out) :: ierr
    !> whether contacts only open and close: no friction, none tied; default: yes
    logical, intent(in), optional :: has_plain_contact
    logical :: is_plain

    ierr = 0
    is_plain = .true.
    if (present(has_plain_contact)) is_plain = has_plain_contact
    select case (plan%type)
    case ('active_set')
      if (is_plain) then
        allocate (active_set_t :: solver)
      else
        allocate (friction_set_t :: solver)
      end if
    case ('snesvi')
      allocate (snes_vi_t :: solver)
    case ('condensed')
      allocate (condensed_t :: solver)
    case default
      SIG_CHECK(.false., PETSC_ERR_ARG_WRONG, 'a solver type that the plan should not have')
    end select
    solver%max_iterations = max_iterations
    solver%is_multigrid = plan%linear == 'gamg'
    solver%may_factor = plan%may_factor
  end subroutine choose_solver
end module sig_solver_choice
