! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> B K^-1 B' by elimination. Where contact has many rows, this takes less time than a solve for each of them, and less memory than a
!> factor of K. Displacements D u of some dofs under the contact forces come with it: [B; D] K^-1 [B' D'] has D K^-1 B'.
module sig_elimination
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_intptr_t
  use sig_c_strings, only: from_c
  use sig_contact_system, only: contact_system_t
  use sig_free_response, only: held_dofs
  use sig_kinds, only: rk
  use sig_linear_solver, only: constrain, reason_of
  use sig_log, only: log_warning
  use sig_petsc_support, only: broadcast_columns, message_size, rank_and_size
  use sig_reasons, only: reason_linear_solver
  use petsc
  implicit none(type, external)
  private
  public :: eliminate_displacements

  ! include/signorom/elimination.h describes this procedure in C.
  interface
    integer(c_int) function sig_eliminate(stiffness, n_rows, offsets, places, coefficients, compliance, reason, message) bind(c)
      import :: c_char, c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: stiffness
      integer(c_int), value :: n_rows
      integer(c_int), intent(in) :: offsets(*), places(*)
      real(c_double), intent(in) :: coefficients(*)
      real(c_double), intent(inout) :: compliance(*)
      integer(c_int), intent(out) :: reason
      character(kind=c_char), intent(out) :: message(*)
    end function sig_eliminate
  end interface

contains

  !> Computes B K^-1 B' and D K^-1 B' [length/force], in which the prescribed dofs and statically determinate supports are held
  !> (factor_without_contact), the first symmetric to the last bit. A failure is a reason, with a warning in the log, and not an
  !> error. Collective, with the same result on each rank.
  subroutine eliminate_displacements(system, dofs, compliance, response, reason, ierr)
    type(contact_system_t), intent(in) :: system
    !> dofs that D chooses, natural; the more, the more is left by the elimination
    integer, intent(in) :: dofs(:)
    !> shape (n_rows, n_rows)
    real(rk), intent(inout), contiguous :: compliance(:, :)
    !> shape (size(dofs), n_rows); zero at held dofs
    real(rk), intent(inout), contiguous :: response(:, :)
    !> reason_converged, or why there is no result
    integer, intent(out) :: reason
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: nothing(system%map%n_dofs)
    real(rk), allocatable :: coefficients(:), left(:, :)
    integer, allocatable :: held(:), moving(:), offsets(:), places(:)
    logical, allocatable :: is_held(:)
    character(kind=c_char) :: message(message_size)
    integer(c_int) :: c_reason
    integer :: i, n, n_left, n_ranks, rank
    Mat :: constrained
    Vec :: unused

    nothing = 0
    is_held = held_dofs(system)
    held = pack([(i, i=1, size(is_held))], is_held)
    PetscCall(constrain(system, system%stiffness, held, nothing, nothing, constrained, unused, ierr))
    n = system%rows%n_rows
    moving = pack([(i, i=1, size(dofs))], .not. is_held(dofs))
    places = system%map%distributed_0([system%rows%dofs, dofs(moving)])
    coefficients = [merge(0.0_rk, system%rows%coefficients, is_held(system%rows%dofs)), (1.0_rk, i=1, size(moving))]
    offsets = [system%rows%offsets, (size(system%rows%dofs) + i, i=1, size(moving))]
    PetscCall(rank_and_size(system%comm, rank, n_ranks, ierr))
    n_left = merge(n + size(moving), 0, rank == 0)
    allocate (left(n_left, n_left))
    ierr = sig_eliminate(constrained%v, n + size(moving), offsets, places, coefficients, left, c_reason, message)
    CHKERRQ(ierr)
    PetscCall(MatDestroy(constrained, ierr))
    PetscCall(VecDestroy(unused, ierr))
    reason = reason_of(c_reason)
    if (reason == reason_linear_solver) call log_warning('the elimination of displacements: ' // from_c(message))
    if (rank == 0) then
      compliance = left(:n, :n)
      response = 0
      response(moving, :) = left(n + 1:, :n)
    end if
    deallocate (left)
    PetscCall(broadcast_columns(compliance, system%comm, ierr))
    PetscCall(broadcast_columns(response, system%comm, ierr))
  end subroutine eliminate_displacements
end module sig_elimination
