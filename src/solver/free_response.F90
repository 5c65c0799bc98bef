! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Elastic responses without contact, one field per term: to prescribed displacements and loads, or to the former alone,
!> which lifts them into the bodies.
module sig_free_response
  use sig_contact_state, only: reason_converged
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_linear_solver, only: constrain, linear_solver_t
  use sig_petsc_support, only: sum_over_ranks
  use petsc
  implicit none(type, external)
  private
  public :: factor_without_contact, solve_free_response, compute_lifting

contains

  !> K with the prescribed dofs held, factored. Collective.
  subroutine factor_without_contact(system, linear_solver, ierr)
    type(contact_system_t), intent(in) :: system
    type(linear_solver_t), intent(inout) :: linear_solver
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: nothing(system%map%n_dofs)
    Mat :: constrained
    Vec :: unused

    nothing = 0
    PetscCall(constrain(system, system%stiffness, system%boundary%prescribed_dofs, nothing, nothing, constrained, unused, ierr))
    PetscCall(linear_solver%factor(constrained, 'fom_', ierr))
    PetscCall(MatDestroy(constrained, ierr))
    PetscCall(VecDestroy(unused, ierr))
  end subroutine factor_without_contact

  !> Displacement for each of the leading terms alone, prescribed values included. Collective.
  subroutine solve_free_response(system, linear_solver, n_terms, has_loads, response, ierr)
    type(contact_system_t), intent(inout) :: system
    !> from factor_without_contact
    type(linear_solver_t), intent(inout) :: linear_solver
    integer, intent(in) :: n_terms
    logical, intent(in) :: has_loads
    !> [length] rows of this rank, shape (n_local_dofs, n_terms)
    real(rk), allocatable, intent(out) :: response(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: prescribed(system%map%n_dofs), forces(system%map%n_dofs)
    real(rk), allocatable :: rhs(:, :)
    integer :: i_term

    associate (local => system%map%local_dofs, n_all => system%boundary%n_terms)
      allocate (rhs(size(local), n_terms), response(size(local), n_terms))
      do i_term = 1, n_terms
        forces = 0
        if (has_prescribed_values(system, i_term)) then
          prescribed = system%prescribed_displacement(unit(n_all, i_term))
          PetscCall(system%apply_stiffness(prescribed, forces, ierr))
        end if
        forces = -forces
        if (has_loads) forces = forces + system%load(unit(n_all, i_term))
        rhs(:, i_term) = merge(0.0_rk, forces(local), system%boundary%is_prescribed(local))
      end do
      PetscCall(linear_solver%solve_many(rhs, response, ierr))
      do i_term = 1, n_terms
        if (.not. has_prescribed_values(system, i_term)) cycle
        prescribed = system%prescribed_displacement(unit(n_all, i_term))
        response(:, i_term) = response(:, i_term) + prescribed(local)
      end do
    end associate
  end subroutine solve_free_response

  !> Most terms of a load that moves are forces alone.
  pure logical function has_prescribed_values(system, i_term)
    type(contact_system_t), intent(in) :: system
    integer, intent(in) :: i_term

    has_prescribed_values = .false.
    if (i_term <= size(system%boundary%prescribed_values, 2)) &
      has_prescribed_values = any(abs(system%boundary%prescribed_values(:, i_term)) > 0)
  end function has_prescribed_values

  !> Responses to the terms of the prescribed displacements, on every rank and in natural order, with a factorization of their
  !> own. Collective.
  subroutine compute_lifting(system, response, reason, ierr)
    type(contact_system_t), intent(inout) :: system
    !> [length] shape (n_dofs, n_prescribed_terms)
    real(rk), allocatable, intent(out) :: response(:, :)
    !> reason_converged, or why K could not be factored
    integer, intent(out) :: reason
    PetscErrorCode, intent(out) :: ierr
    type(linear_solver_t) :: linear_solver
    real(rk), allocatable :: local(:, :)
    integer :: i_term, n_terms

    n_terms = size(system%boundary%prescribed_values, 2)
    allocate (response(system%map%n_dofs, n_terms), source=0.0_rk)
    reason = reason_converged
    ierr = 0
    if (.not. any([(has_prescribed_values(system, i_term), i_term=1, n_terms)])) return
    PetscCall(factor_without_contact(system, linear_solver, ierr))
    reason = linear_solver%reason
    if (reason == reason_converged) then
      PetscCall(solve_free_response(system, linear_solver, n_terms, .false., local, ierr))
      response(system%map%local_dofs, :) = local
      do i_term = 1, n_terms
        PetscCall(sum_over_ranks(system%comm, response(:, i_term), ierr))
      end do
    end if
    PetscCall(linear_solver%destroy(ierr))
  end subroutine compute_lifting

  pure function unit(n, i) result(vector)
    integer, intent(in) :: n
    integer, intent(in) :: i
    real(rk) :: vector(n)

    vector = 0
    vector(i) = 1
  end function unit
end module sig_free_response
