! SPDX-License-Identifier: BSD-3-Clause
!> Norton's creep: the equivalent creep strain grows at the rate A sigma_eq**n.
module sig_norton_creep
  use sig_creep_step, only: creep_step
  use sig_kinds, only: rk
  use sig_plastic_flow, only: creep_flow
  use sig_property_checks, only: bad_creep, bad_elastic_constant
  use sig_radial_return, only: flow_t, radial_law_t, trial_t
  implicit none(type, external)
  private
  public :: norton_creep_t

  type, extends(radial_law_t) :: norton_creep_t
  contains
    procedure :: start
    procedure :: flow
    procedure :: bad_property
  end type norton_creep_t

  !> places of the properties A and n
  integer, parameter :: coefficient = 3, exponent = 4

contains

  !> Makes the law ready, as material_law_t says.
  pure subroutine start(self)
    class(norton_creep_t), intent(inout) :: self

    self%property_names = [character(20) :: 'young_modulus', 'poisson_ratio', 'coefficient', 'exponent']
  end subroutine start

  pure type(flow_t) function flow(self, trial, dt, properties, state_in)
    class(norton_creep_t), intent(in) :: self
    type(trial_t), intent(in) :: trial
    real(rk), intent(in) :: dt, properties(:), state_in(:)

    flow = creep_flow(trial, creep_step(trial%shear_modulus, dt, properties(coefficient), properties(exponent)))
  end function flow

  !> Returns the number of the first property that is out of its range, 0 if there is none.
  pure integer function bad_property(self, properties)
    class(norton_creep_t), intent(in) :: self
    real(rk), intent(in) :: properties(:)

    bad_property = bad_elastic_constant(properties)
    if (bad_property == 0) bad_property = bad_creep(properties, coefficient, exponent)
  end function bad_property
end module sig_norton_creep
