! SPDX-License-Identifier: BSD-3-Clause
!> How much flows in a step: by creep, or plastically with creep or Prager's hardening beside it.
module sig_plastic_flow
  use sig_creep_step, only: creep_step_t, relax
  use sig_hardening, only: hardening_line_t, hardening_line, yield_stress_at
  use sig_kinds, only: rk
  use sig_radial_return, only: flow_t, trial_t
  implicit none(type, external)
  private
  public :: creep_flow, plastic_flow

contains

  !> Returns the flow of a step by creep alone.
  pure type(flow_t) function creep_flow(trial, creep) result(flow)
    type(trial_t), intent(in) :: trial
    type(creep_step_t), intent(in) :: creep
    real(rk) :: lost

    call relax(creep, trial%equivalent, flow%kept, lost, flow%slope)
    flow%creep = lost * trial%equivalent / (3 * trial%shear_modulus)
  end function creep_flow

  !> Returns the flow of a step of a material that yields, and may creep: with R the yield stress,
  !>
  !>     R(p + dp) + (3 G + H_k) dp + 3 G dt A R(p + dp)**n = xi_eq    if the stress without dp is above R(p), else dp = 0.
  !>
  !> Requires: no creep or no kinematic hardening, as creep follows the stress and not xi.
  pure type(flow_t) function plastic_flow(trial, creep, strains, stresses, last_slope, strain) result(flow)
    type(trial_t), intent(in) :: trial
    type(creep_step_t), intent(in) :: creep
    !> as in hardening_line
    real(rk), intent(in) :: strains(:), stresses(:), last_slope
    !> [-] p, equivalent plastic strain at the start of the step
    real(rk), intent(in) :: strain
    type(hardening_line_t) :: line
    real(rk) :: bound, drop, growth, stiffness, stress
    integer :: i

    flow = creep_flow(trial, creep)
    bound = flow%kept * trial%equivalent
    if (.not. bound > yield_stress_at(strains, stresses, last_slope, strain)) return
    stiffness = 3 * trial%shear_modulus + trial%kinematic_hardening
    do i = 1, size(strains)
      line = hardening_line(strains, stresses, last_slope, i)
      if (line%end <= strain) cycle
      growth = growth_on_line(line, strain, trial%equivalent, stiffness, creep, bound)
      if (strain + growth <= line%end) exit
    end do
    stress = line%at(strain + growth)
    drop = creep%drop(stress)
    flow%plastic = growth
    flow%creep = drop / (3 * trial%shear_modulus)
    flow%kept = (stress + trial%kinematic_hardening * growth) / trial%equivalent
    flow%slope = (line%slope + trial%kinematic_hardening) / &
      (stiffness + line%slope * (1 + creep%exponent * drop / stress))
  end function plastic_flow

  !> Solves the equation of plastic_flow for dp, as if the curve were this line from end to end.
  !>
  !> Its left side is convex in dp. Newton's steps start at or above the root, where the power is still small, and go down to it;
  !> the first one that does not go down is at the root. Without creep the first step is there.
  pure real(rk) function growth_on_line(line, strain, trial, stiffness, creep, bound) result(growth)
    type(hardening_line_t), intent(in) :: line
    !> [-] p
    real(rk), intent(in) :: strain
    !> [force/length**2] xi_eq
    real(rk), intent(in) :: trial
    !> [force/length**2] 3 G + H_k
    real(rk), intent(in) :: stiffness
    type(creep_step_t), intent(in) :: creep
    !> [force/length**2] the stress with creep alone, which the root's stress does not exceed
    real(rk), intent(in) :: bound
    integer, parameter :: max_steps = 100
    real(rk) :: drop, stress, step
    integer :: i

    growth = (trial - line%at(strain)) / (stiffness + line%slope)
    if (line%slope > 0) growth = min(growth, (bound - line%at(strain)) / line%slope)
    do i = 1, max_steps
      stress = line%at(strain + growth)
      drop = creep%drop(stress)
      step = (stress + stiffness * growth + drop - trial) / &
        (stiffness + line%slope * (1 + creep%exponent * drop / stress))
      growth = growth - step
      if (.not. step > epsilon(1.0_rk) * abs(growth)) exit
    end do
  end function growth_on_line
end module sig_plastic_flow
