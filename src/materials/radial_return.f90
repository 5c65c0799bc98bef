! SPDX-License-Identifier: BSD-3-Clause
!> Laws with a flow along the deviator of the stress: a step is a radial return, and the law says how much flows.
!>
!> With s_tr = 2 G (dev eps - eps_p - eps_c) of the old state and its back stress X = 2/3 H_k eps_p, the flow of a step has the
!> direction N = 3/2 xi / xi_eq, xi = s_tr - X, xi_eq = sqrt(3/2 xi:xi). So a law solves one scalar equation: how much flows for
!> this xi_eq (Simo & Hughes, Computational Inelasticity, 3.3).
module sig_radial_return
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_kinds, only: rk
  use sig_material_law, only: creep_strain_at, creep_strains, inelastic_strain, material_law_t, n_components, &
    plastic_strain_at, plastic_strains
  implicit none(type, external)
  private
  public :: radial_law_t, trial_t, flow_t

  !> The stress if nothing flowed in the step: held + 2/3 xi_eq N.
  type :: trial_t
    !> [force/length**2] mean stress and back stress, which the flow of the step leaves
    real(rk) :: held(n_components) = 0
    !> [force/length**2] xi_eq, >= 0
    real(rk) :: equivalent = 0
    !> [-] N; zero where xi_eq is zero
    real(rk) :: direction(n_components) = 0
    !> [force/length**2] > 0
    real(rk) :: shear_modulus = 0, bulk_modulus = 0
    !> [force/length**2] H_k of Prager's rule
    real(rk) :: kinematic_hardening = 0
  end type trial_t

  !> The answer of a law to a trial.
  type :: flow_t
    !> [-] growth of the equivalent strains, >= 0
    real(rk) :: plastic = 0, creep = 0
    !> [-] 1 - 3 G (plastic + creep) / xi_eq, of which the law knows how it avoids the difference
    real(rk) :: kept = 1
    !> [-] derivative of xi_eq - 3 G (plastic + creep) with respect to xi_eq
    real(rk) :: slope = 1
  end type flow_t

  !> Its first two properties are young_modulus and poisson_ratio.
  type, abstract, extends(material_law_t) :: radial_law_t
    !> place of H_k among the properties; 0: the law has none
    integer :: kinematic = 0
  contains
    procedure(flow_of_law), deferred :: flow
    procedure :: update
  end type radial_law_t

  abstract interface
    !> Returns how much flows in a step.
    pure function flow_of_law(self, trial, dt, properties, state_in) result(flow)
      import :: flow_t, radial_law_t, rk, trial_t
      class(radial_law_t), intent(in) :: self
      type(trial_t), intent(in) :: trial
      !> as in material_law_t
      real(rk), intent(in) :: dt, properties(:), state_in(:)
      type(flow_t) :: flow
    end function flow_of_law
  end interface

contains

  !> Makes one step, as material_law_t says.
  pure subroutine update(self, strain, dt, properties, state_in, stress, state, tangent, is_solved)
    class(radial_law_t), intent(in) :: self
    real(rk), intent(in) :: strain(n_components)
    real(rk), intent(in) :: dt
    real(rk), intent(in) :: properties(:)
    real(rk), intent(in) :: state_in(:)
    real(rk), intent(out) :: stress(n_components)
    real(rk), intent(out) :: state(:)
    real(rk), intent(out) :: tangent(n_components, n_components)
    logical, intent(out) :: is_solved
    type(trial_t) :: trial

    if (self%kinematic > 0) trial%kinematic_hardening = properties(self%kinematic)
    call find_trial(strain, properties(1), properties(2), state_in, trial)
    call finish_return(trial, self%flow(trial, dt, properties, state_in), state_in, stress, state, tangent, is_solved)
    if (self%bad_property(properties) > 0) is_solved = .false.
  end subroutine update

  !> Computes the trial of a step.
  pure subroutine find_trial(strain, young_modulus, poisson_ratio, state_in, trial)
    !> [-] total strain without the imposed strain
    real(rk), intent(in) :: strain(n_components)
    !> [force/length**2]
    real(rk), intent(in) :: young_modulus
    !> [-]
    real(rk), intent(in) :: poisson_ratio
    !> state at the start of the step
    real(rk), intent(in) :: state_in(:)
    !> in: kinematic_hardening; out: all
    type(trial_t), intent(inout) :: trial
    real(rk) :: back_stress(n_components), xi(n_components)

    trial%shear_modulus = young_modulus / (2 * (1 + poisson_ratio))
    trial%bulk_modulus = young_modulus / (3 * (1 - 2 * poisson_ratio))
    back_stress = trial%kinematic_hardening * (2.0_rk / 3) * tensor_deviator(state_in(plastic_strains))
    xi = 2 * trial%shear_modulus * tensor_deviator(strain - inelastic_strain(state_in)) - back_stress
    trial%equivalent = equivalent_stress(xi)
    if (trial%equivalent > 0) trial%direction = 1.5_rk * (xi / trial%equivalent)
    trial%held = back_stress
    ! flow keeps the volume, so that its rounding must not enter the mean stress
    trial%held(:3) = trial%held(:3) + trial%bulk_modulus * sum(strain(:3))
  end subroutine find_trial

  !> Computes stress, state and tangent from trial and flow:
  !>
  !>     s = X + kept xi,    eps_p += dp N,    eps_c += dc N,
  !>     C_T = K 1 x 1 + 2 G kept I_dev - 4 G / 3 (kept - slope) N x N.
  pure subroutine finish_return(trial, flow, state_in, stress, state, tangent, is_solved)
    type(trial_t), intent(in) :: trial
    type(flow_t), intent(in) :: flow
    real(rk), intent(in) :: state_in(:)
    real(rk), intent(out) :: stress(n_components)
    real(rk), intent(out) :: state(:)
    real(rk), intent(out) :: tangent(n_components, n_components)
    !> whether all results are finite numbers
    logical, intent(out) :: is_solved
    real(rk) :: angles(n_components)
    integer :: i

    angles = trial%direction
    angles(4:) = 2 * angles(4:)
    stress = trial%held + flow%kept * trial%equivalent * (2.0_rk / 3) * trial%direction
    state = state_in
    state(plastic_strains) = state_in(plastic_strains) + flow%plastic * angles
    state(creep_strains) = state_in(creep_strains) + flow%creep * angles
    state(plastic_strain_at) = state_in(plastic_strain_at) + flow%plastic
    state(creep_strain_at) = state_in(creep_strain_at) + flow%creep
    tangent = 0
    tangent(:3, :3) = trial%bulk_modulus - 2 * trial%shear_modulus * flow%kept / 3
    do i = 1, 3
      tangent(i, i) = tangent(i, i) + 2 * trial%shear_modulus * flow%kept
      tangent(3 + i, 3 + i) = trial%shear_modulus * flow%kept
    end do
    do i = 1, n_components
      tangent(:, i) = tangent(:, i) - 4 * trial%shear_modulus / 3 * (flow%kept - flow%slope) * &
        trial%direction(i) * trial%direction
    end do
    is_solved = ieee_is_finite(sum(abs(stress)) + sum(abs(state)) + sum(abs(tangent)))
  end subroutine finish_return

  !> Returns the deviator of a strain as a tensor: its shears are half of the angles.
  pure function tensor_deviator(strain) result(deviator)
    real(rk), intent(in) :: strain(n_components)
    real(rk) :: deviator(n_components)

    deviator(:3) = strain(:3) - sum(strain(:3)) / 3
    deviator(4:) = strain(4:) / 2
  end function tensor_deviator

  !> Returns sqrt(3/2 s:s) of a deviator. The scale keeps the squares of very small and very large numbers.
  pure real(rk) function equivalent_stress(deviator) result(equivalent)
    real(rk), intent(in) :: deviator(n_components)
    real(rk) :: scale

    equivalent = 0
    scale = maxval(abs(deviator))
    if (.not. scale > 0) return
    equivalent = scale * sqrt(1.5_rk * sum((deviator(:3) / scale)**2) + 3 * sum((deviator(4:) / scale)**2))
  end function equivalent_stress
end module sig_radial_return
