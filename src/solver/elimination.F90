! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> B K^-1 B' by elimination. Where contact has many rows, this takes less time than a solve for each of them, and less memory than a
!> factor of K.
module sig_elimination
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_intptr_t
  use sig_c_strings, only: from_c
  use sig_contact_system, only: contact_system_t
  use sig_free_response, only: held_dofs
  use sig_kinds, only: rk
  use sig_linear_solver, only: constrain, reason_of
  use sig_log, only: log_warning
  use sig_petsc_support, only: broadcast_columns, message_size
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

  !> Computes B K^-1 B' [length/force], in which the prescribed dofs and statically determinate supports are held
  !> (factor_without_contact), symmetric to the last bit. A failure is a reason, with a warning in the log, and not an error.
  !> Collective, with the same result on each rank.
  subroutine eliminate_displacements(system, compliance, reason, ierr)
    type(contact_system_t), intent(in) :: system
    !> shape (n_rows, n_rows)
    real(rk), intent(inout), contiguous :: compliance(:, :)
    !> reason_converged, or why there is no result
    integer, intent(out) :: reason
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: nothing(system%map%n_dofs)
    real(rk), allocatable :: coefficients(:)
    integer, allocatable :: held(:), places(:)
    logical, allocatable :: is_held(:)
    character(kind=c_char) :: message(message_size)
    integer(c_int) :: c_reason
    integer :: i
    Mat :: constrained
    Vec :: unused

    nothing = 0
    is_held = held_dofs(system)
    held = pack([(i, i=1, size(is_held))], is_held)
    PetscCall(constrain(system, system%stiffness, held, nothing, nothing, constrained, unused, ierr))
    places = system%map%distributed_0(system%rows%dofs)
    coefficients = merge(0.0_rk, system%rows%coefficients, is_held(system%rows%dofs))
    ierr = sig_eliminate(constrained%v, system%rows%n_rows, system%rows%offsets, places, coefficients, compliance, c_reason, &
      message)
    CHKERRQ(ierr)
    PetscCall(MatDestroy(constrained, ierr))
    PetscCall(VecDestroy(unused, ierr))
    reason = reason_of(c_reason)
    if (reason == reason_linear_solver) call log_warning('the elimination of displacements: ' // from_c(message))
    PetscCall(broadcast_columns(compliance, system%comm, ierr))
  end subroutine eliminate_displacements
end module sig_elimination
