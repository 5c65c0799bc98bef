! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> A full-order problem ready to be solved at parameter points: system, solver and terms of one group of ranks.
module sig_point_solver
  use sig_clock, only: wall_time
  use sig_contact_residuals, only: measure_residuals
  use sig_contact_solver, only: contact_solver_t
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_deck_config, only: solver_config_t
  use sig_kinds, only: rk
  use sig_problem, only: problem_t
  use sig_solver_choice, only: choose_solver
  use sig_term_values, only: term_values_t
  use petsc
  implicit none(type, external)
  private
  public :: point_solver_t

  type :: point_solver_t
    type(contact_system_t) :: system
    class(contact_solver_t), allocatable :: solver
    type(term_values_t) :: terms
    !> [s] wall time of assembly and of what the solver does once
    real(rk) :: setup_seconds = 0
  contains
    procedure :: create
    procedure :: solve
    procedure :: destroy
  end type point_solver_t

contains

  !> Collective on comm, for which the problem was loaded.
  subroutine create(self, problem, config, comm, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    type(solver_config_t), intent(in) :: config
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    character(:), allocatable :: message
    real(rk) :: start

    start = wall_time()
    PetscCall(self%system%create(comm, problem%mesh, problem%body, problem%boundary, problem%pairs, ierr))
    call self%terms%create(problem%terms, message)
    PetscCall(choose_solver(config, self%solver, ierr))
    PetscCall(self%solver%create(self%system, ierr))
    self%setup_seconds = wall_time() - start
  end subroutine create

  !> Solves one point and measures its residuals. Collective. The points were checked before.
  subroutine solve(self, problem, point, state, ierr)
    class(point_solver_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: start, theta(problem%boundary%n_terms)
    integer :: i_source
    logical :: is_valid

    start = wall_time()
    call self%terms%evaluate(point, theta, is_valid, i_source)
    PetscCall(self%solver%solve(self%system, theta, state, ierr))
    state%seconds = wall_time() - start
    PetscCall(measure_residuals(self%system, theta, state, ierr))
  end subroutine solve

  subroutine destroy(self, ierr)
    class(point_solver_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    call self%terms%destroy()
    PetscCall(self%solver%destroy(ierr))
    PetscCall(self%system%destroy(ierr))
  end subroutine destroy
end module sig_point_solver
