! SPDX-License-Identifier: BSD-3-Clause
!> Norton's creep over one step of backward Euler: the equivalent strain grows by dt A sigma**n.
!>
!> All powers are taken by logarithms, so that neither large exponents nor stresses in Pa overflow.
module sig_creep_step
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: creep_step_t, creep_step, no_creep, relax

  type :: creep_step_t
    !> logarithm of 3 G dt A; far below all others without creep
    real(rk) :: log_factor = -huge(1.0_rk)
    !> [-] n >= 1
    real(rk) :: exponent = 1
  contains
    procedure :: drop
  end type creep_step_t

  type(creep_step_t), parameter :: no_creep = creep_step_t()

  !> exponentials of less are zero in a sum with 1, and would be denormal or 0
  real(rk), parameter :: least_logarithm = -700

contains

  !> Returns the creep of a step.
  pure type(creep_step_t) function creep_step(shear_modulus, dt, coefficient, exponent) result(creep)
    !> [force/length**2] > 0
    real(rk), intent(in) :: shear_modulus
    !> [time] >= 0
    real(rk), intent(in) :: dt
    !> [1/time / (force/length**2)**n] A >= 0
    real(rk), intent(in) :: coefficient
    !> [-] n >= 1
    real(rk), intent(in) :: exponent

    creep%exponent = exponent
    if (dt > 0 .and. coefficient > 0) creep%log_factor = log(3 * shear_modulus) + log(dt) + log(coefficient)
  end function creep_step

  !> Returns by how much creep lowers the equivalent stress in the step: 3 G dt A sigma**n for the stress sigma at its end.
  pure real(rk) function drop(self, stress)
    class(creep_step_t), intent(in) :: self
    !> [force/length**2] >= 0
    real(rk), intent(in) :: stress

    drop = 0
    if (stress > 0) drop = exponential(self%log_factor + self%exponent * log(stress))
  end function drop

  !> Solves sigma + 3 G dt A sigma**n = trial for the stress sigma at the end of the step.
  !>
  !> With sigma = trial exp(z) this is log(exp(z) + exp(k + n z)) = 0, k = log(3 G dt A trial**(n-1)). The left side is convex, with
  !> slopes from 1 to n, and at z = min(0, -k/n) it lies between 0 and log 2: from there Newton's steps go down to the root, quickly
  !> and without any case to guard.
  pure subroutine relax(creep, trial, kept, lost, slope)
    type(creep_step_t), intent(in) :: creep
    !> [force/length**2] >= 0
    real(rk), intent(in) :: trial
    !> [-] sigma / trial, and 1 - kept without rounding of the difference
    real(rk), intent(out) :: kept, lost
    !> [-] d sigma / d trial
    real(rk), intent(out) :: slope
    integer, parameter :: max_steps = 100
    real(rk) :: k, step, z
    integer :: i

    k = creep%log_factor
    if (creep%exponent > 1) then
      if (trial > 0) then
        k = k + (creep%exponent - 1) * log(trial)
      else
        k = -huge(1.0_rk)
      end if
    end if
    z = min(0.0_rk, -k / creep%exponent)
    do i = 1, max_steps
      kept = exponential(z)
      lost = exponential(k + creep%exponent * z)
      step = log(kept + lost) * (kept + lost) / (kept + creep%exponent * lost)
      z = z - step
      if (.not. step > epsilon(1.0_rk)) exit
    end do
    kept = exponential(z)
    lost = exponential(k + creep%exponent * z)
    ! both are exact up to rounding, the larger one less so in relation to itself
    if (kept > lost) then
      kept = 1 - lost
    else
      lost = 1 - kept
    end if
    slope = kept / (kept + creep%exponent * lost)
  end subroutine relax

  !> Returns the exponential, 0 for very small ones.
  pure real(rk) function exponential(logarithm)
    real(rk), intent(in) :: logarithm

    exponential = 0
    if (logarithm > least_logarithm) exponential = exp(logarithm)
  end function exponential
end module sig_creep_step
