! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Some columns of the matrix W of all contacts, and the openings without contact forces, for problems in which the whole of W needs
!> too much memory.
!>
!> Bodies that only contact holds are held by anchors, whose forces balance all other forces. The place of these bodies is
!> arbitrary.
module sig_contact_columns
  use sig_condensed, only: condensed_t
  use sig_contact_responses, only: close_rows, columns_at_once, solve_columns
  use sig_contact_system, only: contact_system_t
  use sig_free_response, only: factor_without_contact, solve_free_response
  use sig_holding, only: anchors_t, find_anchors
  use sig_kinds, only: rk
  use sig_linear_solver, only: linear_solver_t
  use sig_reasons, only: reason_converged
  use petsc
  implicit none(type, external)
  private
  public :: contact_columns_t

  !> Columns of W for some chosen rows. Call `solve`, or `take` where a condensed operator is there already.
  type :: contact_columns_t
    !> reason_converged, or why K could not be factored or a solve failed; 0 before `solve` and `take`
    integer :: reason = 0
    !> [length per unit of theta] D - B G, shape (n_rows, n_terms); after `take` zero in the rows of anchors
    real(rk), allocatable :: free_opening(:, :)
    !> [length/force] columns of the chosen rows, shape (n_rows, n_chosen); the column of an anchor is zero up to rounding, and
    !> after `take` also its row
    real(rk), allocatable :: columns(:, :)
    type(anchors_t) :: anchors
  contains
    procedure :: solve
    procedure :: take
  end type contact_columns_t

contains

  !> Computes free_opening and the columns with one factorization, or by multigrid, and n_driving_terms + n_chosen solves; they are
  !> the same on all ranks of the system. If the contacts cannot hold a body, K cannot be factored or a solve fails, `reason` says
  !> so, and free_opening and columns are absent or of no use. Collective.
  subroutine solve(self, system, is_multigrid, chosen, ierr)
    class(contact_columns_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    !> whether conjugate gradients with multigrid solve, and not a factorization
    logical, intent(in) :: is_multigrid
    !> rows whose columns are computed, 1-based
    integer, intent(in) :: chosen(:)
    PetscErrorCode, intent(out) :: ierr
    type(linear_solver_t) :: linear_solver
    real(rk), allocatable :: response(:, :), closing(:, :)

    linear_solver%is_multigrid = is_multigrid
    PetscCall(factor_without_contact(system, linear_solver, ierr))
    self%reason = linear_solver%reason
    if (self%reason == reason_converged) then
      call find_anchors(system%motions, self%anchors)
      PetscCall(solve_free_response(system, linear_solver, system%boundary%n_driving_terms, response, ierr, self%anchors))
      PetscCall(close_rows(system, response, closing, ierr))
      self%free_opening = system%rows%gap
      associate (driven => self%free_opening(:, :size(closing, 2)))
        driven = driven - closing
      end associate
      ! conjugate gradients may fail here and below
      if (linear_solver%reason == reason_converged) then
        PetscCall(solve_chosen(self, system, linear_solver, chosen, ierr))
      end if
      self%reason = linear_solver%reason
    end if
    PetscCall(linear_solver%destroy(ierr))
  end subroutine solve

  !> Computes the columns B K^-1 (B' - B_T' N') of the chosen rows. If a solve fails, the linear solver's reason says so,
  !> and the columns are of no use. Collective.
  subroutine solve_chosen(self, system, linear_solver, chosen, ierr)
    type(contact_columns_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    type(linear_solver_t), intent(inout) :: linear_solver
    !> rows, 1-based
    integer, intent(in) :: chosen(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: response(:, :), closing(:, :)
    integer :: first, last

    ierr = 0
    allocate (self%columns(system%rows%n_rows, size(chosen)))
    do first = 1, size(chosen), columns_at_once
      last = min(first + columns_at_once - 1, size(chosen))
      allocate (response(system%map%n_local_dofs, last - first + 1))
      PetscCall(solve_columns(system, self%anchors, linear_solver, chosen(first:last), response, ierr))
      PetscCall(close_rows(system, response, closing, ierr))
      self%columns(:, first:last) = closing
      deallocate (response)
      if (linear_solver%reason /= reason_converged) return
    end do
  end subroutine solve_chosen

  !> Copies the anchors, the openings and the columns of the chosen rows from a condensed operator, whose anchors are closed. The
  !> rows and columns of the anchors become zero. If the operator could not be made, only its reason is copied. Local.
  subroutine take(self, condensed, chosen)
    class(contact_columns_t), intent(inout) :: self
    type(condensed_t), intent(in) :: condensed
    !> rows whose columns are copied, 1-based
    integer, intent(in) :: chosen(:)
    logical :: is_anchor(size(condensed%compliance, 1))

    self%reason = condensed%reason
    if (self%reason /= reason_converged) return
    self%anchors = condensed%anchors
    self%free_opening = condensed%free_opening
    self%columns = condensed%compliance(:, chosen)
    ! in the place of an anchor stands its opening
    is_anchor = .false.
    is_anchor(self%anchors%rows) = .true.
    where (spread(is_anchor, 2, size(self%free_opening, 2))) self%free_opening = 0
    where (spread(is_anchor, 2, size(chosen)) .or. spread(is_anchor(chosen), 1, size(is_anchor))) self%columns = 0
  end subroutine take
end module sig_contact_columns
