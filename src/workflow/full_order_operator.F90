! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The condensed full-order operator for a model file, as far as the deck gives it room.
module sig_full_order_operator
  use sig_condensed, only: condensed_t
  use sig_contact_state, only: reason_converged
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_log, only: log_warning
  use sig_model, only: full_order_t
  use sig_petsc_support, only: sum_over_ranks
  use sig_problem, only: problem_t
  use sig_text, only: to_text
  use petsc
  implicit none(type, external)
  private
  public :: condense_full_order

  !> [MB] of one number
  real(rk), parameter :: number_size = 8.0e-6_rk

contains

  !> W and D - B G where they fit into reduction.max_full_order_size, and G and H where they fit too. Collective on all ranks, for
  !> which the problem was loaded; the result is the same on each.
  subroutine condense_full_order(problem, full_order, ierr)
    type(problem_t), intent(in) :: problem
    type(full_order_t), intent(out) :: full_order
    PetscErrorCode, intent(out) :: ierr
    type(contact_system_t) :: system
    type(condensed_t) :: condensed
    real(rk) :: displacement_size, multiplier_size

    ierr = 0
    associate (n_rows => problem%operator%n_rows, n_terms => problem%boundary%n_terms, &
      room => problem%deck%reduction%max_full_order_size)
      multiplier_size = number_size * n_rows * (n_rows + n_terms)
      displacement_size = number_size * problem%mesh%n_dim * problem%mesh%n_nodes * (n_rows + n_terms)
      if (room <= 0 .or. n_rows == 0) return
      if (multiplier_size > room) then
        call log_warning('the model keeps no full-order operator, which takes ' // to_text(ceiling(multiplier_size)) // &
          ' MB; where the reduced problem has no solution there will be no answer (reduction.max_full_order_size)')
        return
      end if
      if (problem%plan%linear == 'gamg') return
      PetscCall(system%create(PETSC_COMM_WORLD, problem%mesh, problem%body, problem%boundary, problem%pairs, ierr))
      PetscCall(condensed%create(system, ierr))
      ! with anchors the unknowns of W are not the multipliers alone
      if (condensed%reason == reason_converged .and. system%motions%n_free == 0) then
        full_order%compliance = condensed%compliance
        full_order%free_opening = condensed%free_opening
        if (multiplier_size + displacement_size <= room) then
          PetscCall(gather_columns(system, condensed%free_response, n_terms, full_order%free_response, ierr))
          PetscCall(gather_columns(system, condensed%contact_response, n_rows, full_order%contact_response, ierr))
        end if
      end if
      PetscCall(condensed%destroy(ierr))
      PetscCall(system%destroy(ierr))
    end associate
  end subroutine condense_full_order

  !> Distributed columns in natural order on every rank, filled up with zeros.
  subroutine gather_columns(system, local, n_columns, columns, ierr)
    type(contact_system_t), intent(in) :: system
    !> rows of this rank, shape (n_local_dofs, at most n_columns)
    real(rk), intent(in) :: local(:, :)
    integer, intent(in) :: n_columns
    !> shape (n_dofs, n_columns)
    real(rk), allocatable, intent(out) :: columns(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: i

    ierr = 0
    allocate (columns(system%map%n_dofs, n_columns), source=0.0_rk)
    do i = 1, size(local, 2)
      columns(system%map%local_dofs, i) = local(:, i)
      PetscCall(sum_over_ranks(system%comm, columns(:, i), ierr))
    end do
  end subroutine gather_columns
end module sig_full_order_operator
