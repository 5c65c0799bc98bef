! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Contact condensed to the multipliers: K is factored once, then a parameter point is a dense complementarity problem.
!>
!> With G = responses to the terms without contact, H = K^-1 B' and W = B H:
!> 0 <= lambda, W lambda + D - B G theta >= 0, complementary; u = G theta - H lambda.
module sig_condensed
  use sig_contact_solver, only: contact_solver_t
  use sig_contact_state, only: contact_state_t, reason_converged, reason_no_complementary_solution
  use sig_contact_system, only: contact_system_t
  use sig_free_response, only: factor_without_contact, solve_free_response
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_solution_t, solve_lcp
  use sig_linear_solver, only: linear_solver_t
  use sig_petsc_support, only: sum_over_ranks
  use petsc
  implicit none(type, external)
  private
  public :: condensed_t

  type, extends(contact_solver_t) :: condensed_t
    !> reason_converged, or why the stiffness could not be factored
    integer :: reason = 0
    !> [length] rows of this rank, shape (n_local_dofs, n_terms)
    real(rk), allocatable :: free_response(:, :)
    !> [length/force] rows of this rank, shape (n_local_dofs, n_rows)
    real(rk), allocatable :: contact_response(:, :)
    !> [length/force] W, replicated, shape (n_rows, n_rows)
    real(rk), allocatable :: compliance(:, :)
    !> [length] B G, replicated, shape (n_rows, n_terms)
    real(rk), allocatable :: free_closing(:, :)
  contains
    procedure :: create
    procedure :: solve
    procedure :: destroy
  end type condensed_t

contains

  !> One factorization, n_terms + n_rows solves.
  subroutine create(self, system, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr
    type(linear_solver_t) :: linear_solver

    PetscCall(factor_without_contact(system, linear_solver, ierr))
    self%reason = linear_solver%reason
    if (self%reason == reason_converged) then
      PetscCall(solve_free_response(system, linear_solver, system%boundary%n_terms, .true., self%free_response, ierr))
      PetscCall(solve_contact(self, system, linear_solver, ierr))
      PetscCall(close_pairs(system, self%free_response, self%free_closing, ierr))
      PetscCall(close_pairs(system, self%contact_response, self%compliance, ierr))
    end if
    PetscCall(linear_solver%destroy(ierr))
  end subroutine create

  !> H = K^-1 B'.
  subroutine solve_contact(self, system, linear_solver, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    type(linear_solver_t), intent(inout) :: linear_solver
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: rhs(:, :)
    integer :: i, k, i_local

    allocate (rhs(system%map%n_local_dofs, system%operator%n_rows), source=0.0_rk)
    allocate (self%contact_response(system%map%n_local_dofs, system%operator%n_rows))
    do k = 1, system%operator%n_rows
      do i = 1, size(system%operator%dofs, 1)
        if (system%boundary%is_prescribed(system%operator%dofs(i, k))) cycle
        i_local = system%map%distributed_0(system%operator%dofs(i, k)) - system%map%first_dof_0 + 1
        if (i_local < 1 .or. i_local > system%map%n_local_dofs) cycle
        rhs(i_local, k) = system%operator%coefficients(i, k)
      end do
    end do
    PetscCall(linear_solver%solve_many(rhs, self%contact_response, ierr))
  end subroutine solve_contact

  !> B times distributed columns; replicated.
  subroutine close_pairs(system, columns, closing, ierr)
    type(contact_system_t), intent(in) :: system
    !> rows of this rank, shape (n_local_dofs, n_columns)
    real(rk), intent(in) :: columns(:, :)
    !> shape (n_rows, n_columns)
    real(rk), allocatable, intent(out) :: closing(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: flat(system%operator%n_rows * size(columns, 2))
    integer :: i, k, i_local

    allocate (closing(system%operator%n_rows, size(columns, 2)), source=0.0_rk)
    do k = 1, system%operator%n_rows
      do i = 1, size(system%operator%dofs, 1)
        i_local = system%map%distributed_0(system%operator%dofs(i, k)) - system%map%first_dof_0 + 1
        if (i_local < 1 .or. i_local > system%map%n_local_dofs) cycle
        closing(k, :) = closing(k, :) + system%operator%coefficients(i, k) * columns(i_local, :)
      end do
    end do
    flat = reshape(closing, shape(flat))
    PetscCall(sum_over_ranks(system%comm, flat, ierr))
    closing = reshape(flat, shape(closing))
  end subroutine close_pairs

  subroutine solve(self, system, theta, state, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:)
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr
    type(lcp_solution_t) :: solution
    real(rk) :: opening(system%operator%n_rows)

    allocate (state%displacement(system%map%n_dofs), source=0.0_rk)
    state%reason = self%reason
    if (self%reason /= reason_converged) then
      allocate (state%multipliers(system%operator%n_rows), source=0.0_rk)
      allocate (state%is_active(system%operator%n_rows), source=.false.)
    else
      opening = system%gap(theta) - matmul(self%free_closing, theta)
      call solve_lcp(self%compliance, opening, opening < 0, solution)
      if (solution%reason < 0) state%reason = reason_no_complementary_solution
      state%n_iterations = solution%n_iterations
      state%multipliers = solution%lambda
      state%is_active = solution%is_active
      state%displacement(system%map%local_dofs) = matmul(self%free_response, theta) &
        - matmul(self%contact_response, state%multipliers)
    end if
    PetscCall(sum_over_ranks(system%comm, state%displacement, ierr))
  end subroutine solve

  subroutine destroy(self, ierr)
    class(condensed_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (allocated(self%free_response)) deallocate (self%free_response, self%contact_response)
    if (allocated(self%compliance)) deallocate (self%compliance, self%free_closing)
  end subroutine destroy
end module sig_condensed
