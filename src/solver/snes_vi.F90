! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> PETSc's SNESVI (reduced-space Newton) on the bound form: an independent check of the active set.
module sig_snes_vi
  use, intrinsic :: iso_c_binding, only: c_double, c_int, c_intptr_t
  use sig_active_set, only: finish_state
  use sig_bound_form, only: bound_form_t
  use sig_contact_solver, only: contact_solver_t
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_linear_solver, only: constrain
  use sig_petsc_support, only: create_vector
  use sig_problem_sizes, only: problem_sizes_t, sizes_at
  use sig_rounding, only: rounding_of_data
  use petsc
  implicit none(type, external)
  private
  public :: snes_vi_t

  !> The contact solver `snesvi`. Call create, then solve for any number of points, then destroy.
  type, extends(contact_solver_t) :: snes_vi_t
    type(bound_form_t) :: form
    !> T' K T
    Mat :: stiffness
    !> [force/length] norm of T' K T: for each row the sum of the absolute values of its entries, of these the largest
    real(rk) :: largest_stiffness = 0
  contains
    procedure :: create
    procedure :: solve
    procedure :: destroy
  end type snes_vi_t

  !> [-] a pair is closed if its unknown is above its bound, or below it by at most this fraction of length_scale (scales)
  real(rk), parameter :: on_bound = 1.0e-11_rk

  ! include/signorom/snes_vi.h describes this procedure in C.
  interface
    function sig_snes_vi_solve(matrix, rhs, upper, length_scale, force_scale, is_multigrid, max_iterations, solution, &
      n_iterations, reason) result(status) bind(c)
      import :: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: matrix, rhs, upper, solution
      real(c_double), value :: length_scale, force_scale
      integer(c_int), value :: is_multigrid, max_iterations
      integer(c_int), intent(out) :: n_iterations, reason
      integer(c_int) :: status
    end function sig_snes_vi_solve
  end interface

contains

  !> Makes the bound form for a system, T' K T and its norm. Collective.
  subroutine create(self, system, ierr)
    class(snes_vi_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%form%create(system, ierr))
    PetscCall(self%form%create_matrix(system, self%stiffness, ierr))
    PetscCall(MatNorm(self%stiffness, NORM_INFINITY, self%largest_stiffness, ierr))
  end subroutine create

  !> Solves one point: with full steps first. If max_iterations of them do not converge, begins again with a backtracking search of
  !> up to as many steps. A failure is the reason of the state: too many steps, linear solver (also every error in PETSc), line
  !> search (all other failures of SNES). Collective.
  subroutine solve(self, system, theta, state, ierr)
    class(snes_vi_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> n_iterations is the sum of both attempts
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: unknowns(system%map%n_dofs), residual(system%map%n_dofs), values(system%map%n_dofs), forces(system%map%n_dofs)
    real(rk) :: length_scale, force_scale
    integer(c_int) :: n_iterations, reason
    Mat :: constrained
    Vec :: rhs, upper, solution

    values = system%prescribed_displacement(theta)
    forces = system%load(theta)
    call self%form%to_forces_on_unknowns(system, forces)
    PetscCall(constrain(system, self%stiffness, system%boundary%prescribed_dofs, values, forces, constrained, rhs, ierr))
    PetscCall(scales(self, system, theta, values, length_scale, force_scale, ierr))
    PetscCall(fill_bounds(self, system, theta, length_scale, upper, ierr))
    PetscCall(create_vector(system%comm, system%map%n_local_dofs, solution, ierr))
    PetscCall(system%put(values, solution, ierr))
    ierr = sig_snes_vi_solve(constrained%v, rhs%v, upper%v, length_scale, force_scale, merge(1_c_int, 0_c_int, self%is_multigrid), &
      self%max_iterations, solution%v, n_iterations, reason)
    CHKERRQ(ierr)
    state%n_iterations = n_iterations
    state%reason = reason
    PetscCall(system%get(solution, unknowns, ierr))
    PetscCall(MatMult(self%stiffness, solution, rhs, ierr))
    PetscCall(system%get(rhs, residual, ierr))
    residual = residual - forces
    state%is_active = unknowns(self%form%bounded_dofs) >= self%form%bounds(system, theta) - on_bound * length_scale
    call finish_state(self%form, system, theta, unknowns, residual, state)
    PetscCall(MatDestroy(constrained, ierr))
    PetscCall(VecDestroy(rhs, ierr))
    PetscCall(VecDestroy(upper, ierr))
    PetscCall(VecDestroy(solution, ierr))
  end subroutine solve

  !> Computes the size of the displacements and of the forces that can occur at the point. length_scale [length] is the largest
  !> prescribed displacement, gap, or load over largest_stiffness; 1 if these are zero. force_scale [force] is the largest absolute
  !> component of K times `values` or load; if that is only rounding, largest_stiffness times length_scale. Collective.
  subroutine scales(self, system, theta, values, length_scale, force_scale, ierr)
    class(snes_vi_t), intent(in) :: self
    type(contact_system_t), intent(inout) :: system
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [length] prescribed displacements, 0 on all other dofs; natural, shape (n_dofs)
    real(rk), intent(in) :: values(:)
    real(rk), intent(out) :: length_scale
    real(rk), intent(out) :: force_scale
    PetscErrorCode, intent(out) :: ierr
    type(problem_sizes_t) :: sizes
    real(rk) :: forces(system%map%n_dofs)

    sizes = sizes_at(system, theta)
    length_scale = max(sizes%motion, sizes%gap, sizes%force / self%largest_stiffness)
    if (length_scale <= 0) length_scale = 1
    PetscCall(system%apply_stiffness(values, forces, ierr))
    force_scale = max(maxval(abs(forces)), sizes%force)
    ! a rigid tool that moves as a whole strains nothing by itself: what is left of K u is rounding
    if (force_scale <= rounding_of_data * self%largest_stiffness * length_scale) force_scale = self%largest_stiffness * length_scale
  end subroutine scales

  !> Makes the vector of upper bounds in units of length_scale; infinite except for the bounded unknowns. Collective.
  subroutine fill_bounds(self, system, theta, length_scale, upper, ierr)
    class(snes_vi_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [length] of scales
    real(rk), intent(in) :: length_scale
    Vec, intent(out) :: upper
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: values(system%map%n_dofs)

    values = PETSC_INFINITY
    values(self%form%bounded_dofs) = self%form%bounds(system, theta) / length_scale
    PetscCall(create_vector(system%comm, system%map%n_local_dofs, upper, ierr))
    PetscCall(system%put(values, upper, ierr))
  end subroutine fill_bounds

  !> Frees the matrix. Collective.
  subroutine destroy(self, ierr)
    class(snes_vi_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    PetscCall(MatDestroy(self%stiffness, ierr))
  end subroutine destroy
end module sig_snes_vi
