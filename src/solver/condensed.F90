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
  use sig_linear_algebra, only: add_product
  use sig_linear_solver, only: linear_solver_t
  use sig_petsc_support, only: sum_over_ranks
  use petsc
  implicit none(type, external)
  private
  public :: condensed_t

  type, extends(contact_solver_t) :: condensed_t
    !> reason_converged, or why the stiffness could not be factored
    integer :: reason = 0
    !> [length] rows of this rank, shape (n_local_dofs, n_driving_terms)
    real(rk), allocatable :: free_response(:, :)
    !> [length/force] rows of this rank, shape (n_local_dofs, n_rows)
    real(rk), allocatable :: contact_response(:, :)
    !> [length/force] W, replicated, shape (n_rows, n_rows)
    real(rk), allocatable :: compliance(:, :)
    !> [length] B G, replicated, shape (n_rows, n_driving_terms)
    real(rk), allocatable :: free_closing(:, :)
  contains
    procedure :: create
    procedure :: solve
    procedure :: n_points_at_once
    procedure :: solve_points
    procedure :: destroy
  end type condensed_t

  !> [flop] about half a second
  real(rk), parameter :: work_at_once = 1.0e10_rk
  integer, parameter :: most_points_at_once = 64

contains

  !> One factorization, n_driving_terms + n_rows solves.
  subroutine create(self, system, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr
    type(linear_solver_t) :: linear_solver

    PetscCall(factor_without_contact(system, linear_solver, ierr))
    self%reason = linear_solver%reason
    if (self%reason == reason_converged) then
      PetscCall(solve_free_response(system, linear_solver, system%boundary%n_driving_terms, .true., self%free_response, ierr))
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
    type(contact_state_t) :: states(1)

    PetscCall(self%solve_points(system, reshape(theta, [size(theta), 1]), states, ierr))
    state = states(1)
  end subroutine solve

  !> As many as share the products well, while the dense problems of the contact rows do not dominate.
  pure integer function n_points_at_once(self, system) result(n_points)
    class(condensed_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    real(rk) :: work

    associate (n_rows => real(system%operator%n_rows, rk))
      work = 2 * system%map%n_dofs * (n_rows + system%boundary%n_driving_terms) + n_rows**3
    end associate
    n_points = nint(max(1.0_rk, min(real(most_points_at_once, rk), work_at_once / work)))
  end function n_points_at_once

  !> A dense problem per point, then all displacements as one product and one sum over the ranks.
  subroutine solve_points(self, system, theta, states, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:, :)
    type(contact_state_t), intent(out) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: multipliers(:, :), local(:, :)
    integer :: i

    allocate (multipliers(system%operator%n_rows, size(states)), local(system%map%n_local_dofs, size(states)), source=0.0_rk)
    if (self%reason == reason_converged) then
      call solve_multipliers(self, system, theta, states, multipliers)
      call add_product(1.0_rk, self%free_response, theta(:system%boundary%n_driving_terms, :), local)
      call add_product(-1.0_rk, self%contact_response, multipliers, local)
    end if
    do i = 1, size(states)
      states(i)%multipliers = multipliers(:, i)
      if (self%reason /= reason_converged) states(i)%reason = self%reason
      if (.not. allocated(states(i)%is_active)) allocate (states(i)%is_active(system%operator%n_rows), source=.false.)
    end do
    PetscCall(share_displacements(system, local, states, ierr))
  end subroutine solve_points

  !> 0 <= lambda, W lambda + D - B G theta >= 0, complementary, for each point. Local.
  subroutine solve_multipliers(self, system, theta, states, multipliers)
    type(condensed_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    real(rk), intent(in) :: theta(:, :)
    type(contact_state_t), intent(inout) :: states(:)
    !> [force] shape (n_rows, n_points)
    real(rk), intent(out) :: multipliers(:, :)
    type(lcp_solution_t) :: solution
    real(rk) :: openings(system%operator%n_rows, size(states))
    logical :: start(system%operator%n_rows)
    integer :: i

    do i = 1, size(states)
      openings(:, i) = system%gap(theta(:, i))
    end do
    call add_product(-1.0_rk, self%free_closing, theta(:system%boundary%n_driving_terms, :), openings)
    start = openings(:, 1) < 0
    do i = 1, size(states)
      call solve_lcp(self%compliance, openings(:, i), start, solution)
      states(i)%reason = merge(reason_converged, reason_no_complementary_solution, solution%reason > 0)
      states(i)%n_iterations = solution%n_iterations
      states(i)%is_active = solution%is_active
      multipliers(:, i) = solution%lambda
      ! neighbors in a sweep have nearly the same contact
      start = solution%is_active
    end do
  end subroutine solve_multipliers

  !> Rows of each rank -> whole fields on every rank, in one sum. Collective.
  subroutine share_displacements(system, local, states, ierr)
    type(contact_system_t), intent(in) :: system
    !> [length] shape (n_local_dofs, n_points)
    real(rk), intent(in) :: local(:, :)
    type(contact_state_t), intent(inout) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: whole(:, :)
    integer :: i, i_local

    allocate (whole(system%map%n_dofs, size(states)), source=0.0_rk)
    do i = 1, size(states)
      do i_local = 1, size(local, 1)
        whole(system%map%local_dofs(i_local), i) = local(i_local, i)
      end do
    end do
    PetscCall(sum_over_ranks(system%comm, whole, ierr))
    do i = 1, size(states)
      states(i)%displacement = whole(:, i)
    end do
  end subroutine share_displacements

  subroutine destroy(self, ierr)
    class(condensed_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (allocated(self%free_response)) deallocate (self%free_response, self%contact_response)
    if (allocated(self%compliance)) deallocate (self%compliance, self%free_closing)
  end subroutine destroy
end module sig_condensed
