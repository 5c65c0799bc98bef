! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> A stiffness matrix with some dofs prescribed, factored once by MUMPS and used for many right-hand sides.
module sig_linear_solver
  use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_null_char
  use sig_contact_state, only: reason_converged, reason_floating_body, reason_linear_solver
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_petsc_support, only: create_vector
  use sig_solver_c_interfaces, only: sig_linear_solver_destroy, sig_linear_solver_factor, sig_linear_solver_solve_many
  use petsc
  implicit none(type, external)
  private
  public :: linear_solver_t, constrain

  type :: linear_solver_t
    integer(c_intptr_t) :: ksp = 0
    !> reason_converged, or why the factorization is of no use
    integer :: reason = 0
  contains
    procedure :: factor
    procedure :: solve_many
    procedure :: solve_vector
    procedure :: destroy
  end type linear_solver_t

contains

  !> Copy of a matrix whose rows and columns of some dofs are zero but for the diagonal, and the right-hand side that makes
  !> them take their values. Collective.
  subroutine constrain(system, matrix, dofs, values, forces, constrained, rhs, ierr)
    type(contact_system_t), intent(in) :: system
    Mat, intent(in) :: matrix
    !> natural
    integer, intent(in) :: dofs(:)
    !> [length] natural, shape (n_dofs); read on `dofs` only
    real(rk), intent(in) :: values(:)
    !> [force] natural, shape (n_dofs)
    real(rk), intent(in) :: forces(:)
    !> the caller destroys both
    Mat, intent(out) :: constrained
    Vec, intent(out) :: rhs
    PetscErrorCode, intent(out) :: ierr
    Vec :: prescribed
    integer, allocatable :: own_dofs_0(:)
    real(rk) :: diagonal

    own_dofs_0 = system%map%distributed_0(dofs)
    own_dofs_0 = pack(own_dofs_0, own_dofs_0 >= system%map%first_dof_0 .and. &
      own_dofs_0 < system%map%first_dof_0 + system%map%n_local_dofs)
    PetscCall(create_vector(system%comm, system%map%n_local_dofs, rhs, ierr))
    PetscCall(create_vector(system%comm, system%map%n_local_dofs, prescribed, ierr))
    PetscCall(MatDuplicate(matrix, MAT_COPY_VALUES, constrained, ierr))
    PetscCall(MatGetDiagonal(constrained, rhs, ierr))
    PetscCall(VecSum(rhs, diagonal, ierr))
    diagonal = diagonal / system%map%n_dofs
    PetscCall(system%put(forces, rhs, ierr))
    PetscCall(system%put(values, prescribed, ierr))
    PetscCall(MatZeroRowsColumns(constrained, size(own_dofs_0), own_dofs_0, diagonal, prescribed, rhs, ierr))
    PetscCall(MatSetOption(constrained, MAT_SYMMETRIC, PETSC_TRUE, ierr))
    PetscCall(VecDestroy(prescribed, ierr))
  end subroutine constrain

  !> Collective. A singular matrix is a reason, not an error.
  subroutine factor(self, matrix, prefix, ierr)
    class(linear_solver_t), intent(inout) :: self
    Mat, intent(in) :: matrix
    !> of the PETSc options, with its underscore
    character(*), intent(in) :: prefix
    PetscErrorCode, intent(out) :: ierr
    integer(c_int) :: reason, detail

    PetscCall(self%destroy(ierr))
    ierr = sig_linear_solver_factor(matrix%v, prefix // c_null_char, self%ksp, reason, detail)
    self%reason = reason_linear_solver
    if (reason > 0) self%reason = reason_converged
    if (reason == -2) self%reason = reason_floating_body
  end subroutine factor

  !> Collective. Arrays hold the rows of this rank.
  subroutine solve_many(self, rhs, solution, ierr)
    class(linear_solver_t), intent(inout) :: self
    !> [force] shape (n_local_dofs, n_columns)
    real(rk), contiguous, intent(in) :: rhs(:, :)
    !> [length] same shape
    real(rk), contiguous, intent(out) :: solution(:, :)
    PetscErrorCode, intent(out) :: ierr

    ierr = sig_linear_solver_solve_many(self%ksp, size(rhs, 2), size(rhs, 1), rhs, solution)
  end subroutine solve_many

  !> Collective.
  subroutine solve_vector(self, rhs, solution, ierr)
    class(linear_solver_t), intent(inout) :: self
    Vec, intent(in) :: rhs
    Vec, intent(inout) :: solution
    PetscErrorCode, intent(out) :: ierr
    PetscScalar, pointer :: from(:), to(:)
    real(rk), allocatable :: answer(:, :)

    PetscCall(VecGetArrayReadF90(rhs, from, ierr))
    PetscCall(VecGetArrayF90(solution, to, ierr))
    allocate (answer(size(to), 1))
    PetscCall(self%solve_many(reshape(from, [size(from), 1]), answer, ierr))
    to = answer(:, 1)
    PetscCall(VecRestoreArrayF90(solution, to, ierr))
    PetscCall(VecRestoreArrayReadF90(rhs, from, ierr))
  end subroutine solve_vector

  subroutine destroy(self, ierr)
    class(linear_solver_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (self%ksp /= 0) ierr = sig_linear_solver_destroy(self%ksp)
  end subroutine destroy
end module sig_linear_solver
