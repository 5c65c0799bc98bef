! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> How well an answer meets (3): equilibrium, penetration, sign of the multipliers, complementarity, balance of forces.
module sig_contact_residuals
  use sig_contact_state, only: contact_state_t, residuals_t
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use petsc
  implicit none(type, external)
  private
  public :: measure_residuals

  !> [-] forces are compared with at least this share of |K| |u|: all that a rigid motion leaves of K u is rounding
  real(rk), parameter :: smallest_share = 1.0e-6_rk

contains

  !> Fills state%residuals and state%reactions. Collective on the system's communicator.
  subroutine measure_residuals(system, theta, state, ierr)
    type(contact_system_t), intent(inout) :: system
    real(rk), intent(in) :: theta(:)
    type(contact_state_t), intent(inout) :: state
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: internal(system%map%n_dofs), contact(system%map%n_dofs), load(system%map%n_dofs), opening(system%operator%n_rows)
    real(rk) :: smallest_force

    PetscCall(MatNorm(system%stiffness, NORM_INFINITY, smallest_force, ierr))
    smallest_force = smallest_share * smallest_force * maxval(abs(state%displacement))
    PetscCall(system%apply_stiffness(state%displacement, internal, ierr))
    contact = system%operator%apply_transpose(state%multipliers, system%map%n_dofs)
    load = system%load(theta)
    opening = system%gap(theta) - system%operator%apply(state%displacement)
    state%reactions = merge(internal + contact - load, 0.0_rk, system%boundary%is_prescribed)
    associate (r => state%residuals)
      r%equilibrium = relative(maxval(abs(internal + contact - load), mask=.not. system%boundary%is_prescribed), &
        max(smallest_force, maxval(abs(internal)), maxval(abs(contact))))
      r%penetration = max(0.0_rk, maxval(-opening))
      r%negative_multiplier = relative(max(0.0_rk, maxval(-state%multipliers)), maxval(abs(state%multipliers)))
      r%complementarity = relative(abs(dot_product(state%multipliers, opening)), maxval(abs(state%multipliers)) * &
        max(maxval(abs(system%gap(theta))), maxval(abs(state%displacement))))
      r%force_balance = worst_imbalance(internal + contact - load, load, system%map%n_dim, system%first_balanced, smallest_force)
    end associate
  end subroutine measure_residuals

  !> Resultant of reactions and loads over the sum of their sizes, worst component (contact forces cancel pair by pair).
  pure real(rk) function worst_imbalance(reactions, loads, n_dim, first, smallest_force)
    !> [force] natural, shape (n_dofs)
    real(rk), intent(in) :: reactions(:)
    real(rk), intent(in) :: loads(:)
    integer, intent(in) :: n_dim
    !> first component that is a direction in space: radial forces of a turned body balance by the hoop stress
    integer, intent(in) :: first
    !> [force] sizes below this count as this
    real(rk), intent(in) :: smallest_force
    integer :: i_component

    worst_imbalance = 0
    do i_component = first, n_dim
      worst_imbalance = max(worst_imbalance, relative(abs(sum(reactions(i_component::n_dim) + loads(i_component::n_dim))), &
        max(smallest_force, sum(abs(reactions)) + sum(abs(loads)))))
    end do
  end function worst_imbalance

  !> part / whole, and 0 where there is nothing to compare with.
  pure real(rk) function relative(part, whole)
    real(rk), intent(in) :: part
    real(rk), intent(in) :: whole

    relative = 0
    if (whole > 0) relative = part / whole
  end function relative
end module sig_contact_residuals
