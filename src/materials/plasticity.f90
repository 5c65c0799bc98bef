! SPDX-License-Identifier: BSD-3-Clause
!> J2 plasticity that does not depend on time, with isotropic hardening (none, linear, a curve) and Prager's kinematic hardening.
module sig_plasticity
  use sig_creep_step, only: no_creep
  use sig_kinds, only: rk
  use sig_material_law, only: plastic_strain_at
  use sig_plastic_flow, only: plastic_flow
  use sig_property_checks, only: bad_elastic_constant, bad_stress, is_positive_or_zero
  use sig_radial_return, only: flow_t, radial_law_t, trial_t
  implicit none(type, external)
  private
  public :: plasticity_t

  type, extends(radial_law_t) :: plasticity_t
  contains
    procedure :: start
    procedure :: flow
    procedure :: bad_property
  end type plasticity_t

  !> places of the properties; the yield stresses of the curve follow
  integer, parameter :: kinematic = 3, isotropic = 4, first_stress = 5

contains

  !> Makes the law ready, as material_law_t says.
  pure subroutine start(self)
    class(plasticity_t), intent(inout) :: self

    allocate (self%property_names(first_stress - 1 + size(self%curve_strains)))
    self%property_names = 'yield_stress'
    self%property_names(:first_stress - 1) = [character(20) :: 'young_modulus', 'poisson_ratio', 'kinematic_hardening', &
      'isotropic_hardening']
    self%kinematic = kinematic
  end subroutine start

  pure type(flow_t) function flow(self, trial, dt, properties, state_in)
    class(plasticity_t), intent(in) :: self
    type(trial_t), intent(in) :: trial
    real(rk), intent(in) :: dt, properties(:), state_in(:)

    flow = plastic_flow(trial, no_creep, self%curve_strains, properties(first_stress:), properties(isotropic), &
      state_in(plastic_strain_at))
  end function flow

  !> Returns the number of the first property that is out of its range, 0 if there is none.
  pure integer function bad_property(self, properties)
    class(plasticity_t), intent(in) :: self
    real(rk), intent(in) :: properties(:)

    bad_property = bad_elastic_constant(properties)
    if (bad_property > 0) return
    do bad_property = kinematic, isotropic
      if (.not. is_positive_or_zero(properties(bad_property))) return
    end do
    bad_property = bad_stress(properties, first_stress)
  end function bad_property
end module sig_plasticity
