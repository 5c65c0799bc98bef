! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The condensed full-order operator for a model file, as far as the deck gives it room.
module sig_full_order_operator
  use sig_condensed, only: condensed_t
  use sig_contact_state, only: reason_converged
  use sig_full_order, only: full_order_t, team_t
  use sig_kinds, only: rk
  use sig_log, only: log_warning
  use sig_model, only: operator_t => full_order_t
  use sig_petsc_support, only: broadcast_columns
  use sig_text, only: to_text
  use petsc
  implicit none(type, external)
  private
  public :: condense_full_order

  !> [MB] of one number
  real(rk), parameter :: number_size = 8.0e-6_rk

contains

  !> W and D - B G where they fit into reduction.max_full_order_size, and G and H where they fit too. Collective on all ranks; the
  !> result is the same on each.
  subroutine condense_full_order(full_order, operator, ierr)
    !> loaded
    type(full_order_t), intent(inout) :: full_order
    type(operator_t), intent(out) :: operator
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    type(condensed_t), pointer :: condensed
    real(rk) :: displacement_size, multiplier_size

    ierr = 0
    associate (problem => full_order%problem, n_rows => full_order%problem%rows%n_rows, &
      n_terms => full_order%problem%boundary%n_terms, room => full_order%problem%deck%reduction%max_full_order_size)
      multiplier_size = number_size * n_rows * (n_rows + n_terms)
      displacement_size = number_size * problem%mesh%n_dim * problem%mesh%n_nodes * (n_rows + n_terms)
      if (room <= 0 .or. n_rows == 0) return
      if (multiplier_size > room) then
        call log_warning('the model keeps no full-order operator, which takes ' // to_text(ceiling(multiplier_size)) // &
          ' MB; where the reduced problem has no solution there will be no answer (reduction.max_full_order_size)')
        return
      end if
      if (problem%plan%linear == 'gamg') return
      PetscCall(full_order%ready_team(team, ierr))
      PetscCall(team%solver%condense(condensed, ierr))
      ! with anchors the unknowns of W are not the multipliers alone
      if (condensed%reason /= reason_converged .or. team%solver%system%motions%n_free > 0) return
      operator%compliance = condensed%compliance
      operator%free_opening = condensed%free_opening
      if (multiplier_size + displacement_size <= room) then
        PetscCall(team%solver%system%share_columns(condensed%free_response, n_terms, operator%free_response, ierr))
        PetscCall(team%solver%system%share_columns(condensed%contact_response, n_rows, operator%contact_response, ierr))
      end if
    end associate
    PetscCall(agree_on_operator(operator, ierr))
  end subroutine condense_full_order

  !> Groups of ranks condense on their own and may differ by rounding: the first rank's numbers count. Collective on all ranks.
  subroutine agree_on_operator(operator, ierr)
    type(operator_t), intent(inout) :: operator
    PetscErrorCode, intent(out) :: ierr

    PetscCall(broadcast_columns(operator%compliance, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_columns(operator%free_opening, PETSC_COMM_WORLD, ierr))
    if (.not. allocated(operator%free_response)) return
    PetscCall(broadcast_columns(operator%free_response, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_columns(operator%contact_response, PETSC_COMM_WORLD, ierr))
  end subroutine agree_on_operator
end module sig_full_order_operator
