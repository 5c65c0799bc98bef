! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The contact solver that the deck names.
module sig_solver_choice
  use sig_active_set, only: active_set_t
  use sig_condensed, only: condensed_t
  use sig_contact_solver, only: contact_solver_t
  use sig_deck_config, only: solver_config_t
  use sig_petsc_support, only: precondition_failed
  use sig_snes_vi, only: snes_vi_t
  use petsc
  implicit none(type, external)
  private
  public :: choose_solver

contains

  !> Allocates the solver; the caller creates it for a system. Local.
  subroutine choose_solver(config, solver, ierr)
    type(solver_config_t), intent(in) :: config
    class(contact_solver_t), allocatable, intent(out) :: solver
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    select case (config%type)
    case ('active_set')
      allocate (active_set_t :: solver)
    case ('snesvi')
      allocate (snes_vi_t :: solver)
    case ('condensed')
      allocate (condensed_t :: solver)
    case default
      SIG_CHECK(.false., PETSC_ERR_ARG_WRONG, 'a solver type that the deck layer should have refused')
    end select
    solver%max_iterations = config%max_iterations
  end subroutine choose_solver
end module sig_solver_choice
