! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> A factor of K in two parts: of bodies whose stiffness stays, and of bodies whose stiffness changes. K couples no bodies, so that
!> each part is factored alone, and the first one only once.
module sig_divided_solver
  use sig_kinds, only: rk
  use sig_linear_solver, only: linear_solver_t
  use sig_petsc_support, only: max_over_ranks
  use sig_reasons, only: reason_converged
  use petsc
  implicit none(type, external)
  private
  public :: divided_solver_t, both_parts, changing_part, staying_part

  integer, parameter :: both_parts = 0, staying_part = 1, changing_part = 2

  !> One part of K.
  type :: part_t
    type(linear_solver_t) :: solver
    !> its dofs on this rank, 1-based in the order of map%local_dofs
    integer, allocatable :: places(:)
    !> the same as rows of K, on the ranks of K; and the rows and columns of K in them
    IS :: rows
    Mat :: matrix
    logical :: is_there = .false.
  end type part_t

  !> Call divide, then factor whenever K has new values, then solve_many; destroy at the end. Without divide it is a
  !> linear_solver_t.
  type, extends(linear_solver_t) :: divided_solver_t
    !> part for which solve_many solves; displacements in the other one are then zero
    integer :: chosen = both_parts
    !> the part that stays, and the one that changes; not allocated without divide
    type(part_t), allocatable, private :: parts(:)
    MPI_Comm, private :: comm = MPI_COMM_NULL
  contains
    procedure :: divide
    procedure :: factor
    procedure :: solve_many
    procedure :: destroy
  end type divided_solver_t

contains

  !> Says which dofs belong to bodies whose stiffness changes. Local.
  pure subroutine divide(self, comm, changes)
    class(divided_solver_t), intent(inout) :: self
    !> that of K
    MPI_Comm, intent(in) :: comm
    !> in the order of map%local_dofs; the same for all dofs of a body
    logical, intent(in) :: changes(:)
    integer :: i

    self%comm = comm
    allocate (self%parts(2))
    self%parts(staying_part)%places = pack([(i, i=1, size(changes))], .not. changes)
    self%parts(changing_part)%places = pack([(i, i=1, size(changes))], changes)
  end subroutine divide

  !> Factors a matrix: the part that stays only at the first call, and at later calls MUMPS keeps the ordering of the part that
  !> changes. Reasons and other arguments: as of linear_solver_t. Collective.
  subroutine factor(self, matrix, prefix, ierr)
    class(divided_solver_t), intent(inout) :: self
    !> the pattern stays
    Mat, intent(in) :: matrix
    character(*), intent(in) :: prefix
    PetscErrorCode, intent(out) :: ierr

    if (.not. allocated(self%parts)) then
      PetscCall(self%linear_solver_t%factor(matrix, prefix, ierr))
      return
    end if
    associate (staying => self%parts(staying_part), changing => self%parts(changing_part))
      if (.not. staying%is_there) then
        PetscCall(factor_part(staying, self%comm, matrix, prefix, ierr))
      end if
      PetscCall(factor_part(changing, self%comm, matrix, prefix, ierr))
      self%reason = staying%solver%reason
      if (self%reason == reason_converged) self%reason = changing%solver%reason
    end associate
  end subroutine factor

  !> Factors one part. One without dofs has nothing to solve. Collective.
  subroutine factor_part(part, comm, matrix, prefix, ierr)
    type(part_t), intent(inout) :: part
    MPI_Comm, intent(in) :: comm
    Mat, intent(in) :: matrix
    character(*), intent(in) :: prefix
    PetscErrorCode, intent(out) :: ierr
    MatReuse :: reuse
    PetscInt :: first, last, n

    reuse = MAT_REUSE_MATRIX
    if (.not. part%is_there) then
      reuse = MAT_INITIAL_MATRIX
      PetscCall(MatGetOwnershipRange(matrix, first, last, ierr))
      PetscCall(ISCreateGeneral(comm, size(part%places), first + part%places - 1, PETSC_COPY_VALUES, part%rows, ierr))
    end if
    PetscCall(MatCreateSubMatrix(matrix, part%rows, part%rows, reuse, part%matrix, ierr))
    part%is_there = .true.
    PetscCall(MatSetOption(part%matrix, MAT_SYMMETRIC, PETSC_TRUE, ierr))
    PetscCall(ISGetSize(part%rows, n, ierr))
    part%solver%reason = reason_converged
    if (n == 0) return
    if (part%solver%ksp == 0) then
      PetscCall(part%solver%factor(part%matrix, prefix, ierr))
    else
      PetscCall(part%solver%factor_again(ierr))
    end if
  end subroutine factor_part

  !> Solves for several right-hand sides, those of the chosen part. Arguments and reasons: as of linear_solver_t. Collective.
  subroutine solve_many(self, rhs, solution, ierr)
    class(divided_solver_t), intent(inout) :: self
    real(rk), contiguous, intent(in) :: rhs(:, :)
    real(rk), contiguous, intent(out) :: solution(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: own_rhs(:, :), own(:, :), sizes(:, :)
    integer, allocatable :: columns(:)
    integer :: i, k

    ierr = 0
    if (.not. allocated(self%parts)) then
      PetscCall(self%linear_solver_t%solve_many(rhs, solution, ierr))
      return
    end if
    solution = 0
    do i = 1, size(self%parts)
      if (self%chosen /= both_parts .and. self%chosen /= i) cycle
      associate (part => self%parts(i))
        if (part%solver%ksp == 0) cycle
        ! a contact with an obstacle or of other bodies has no forces here
        sizes = reshape([(maxval([0.0_rk, abs(rhs(part%places, k))]), k=1, size(rhs, 2))], [1, size(rhs, 2)])
        PetscCall(max_over_ranks(self%comm, sizes, ierr))
        columns = pack([(k, k=1, size(rhs, 2))], .not. sizes(1, :) <= 0)
        if (size(columns) == 0) cycle
        own_rhs = rhs(part%places, columns)
        allocate (own, mold=own_rhs)
        PetscCall(part%solver%solve_many(own_rhs, own, ierr))
        solution(part%places, columns) = own
        deallocate (own)
      end associate
    end do
  end subroutine solve_many

  !> Frees the factors; K is then one part again. Collective.
  subroutine destroy(self, ierr)
    class(divided_solver_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr
    integer :: i

    PetscCall(self%linear_solver_t%destroy(ierr))
    if (.not. allocated(self%parts)) return
    do i = 1, size(self%parts)
      associate (part => self%parts(i))
        PetscCall(part%solver%destroy(ierr))
        if (part%is_there) then
          PetscCall(ISDestroy(part%rows, ierr))
          PetscCall(MatDestroy(part%matrix, ierr))
        end if
      end associate
    end do
    deallocate (self%parts)
  end subroutine destroy
end module sig_divided_solver
