! SPDX-License-Identifier: BSD-3-Clause
!> Norton's creep: the equivalent creep strain grows at the rate A sigma_eq**n.
module sig_norton_creep
  use sig_creep_step, only: creep_step
  use sig_kinds, only: rk
  use sig_material_law, only: material_law_t, n_components
  use sig_plastic_flow, only: creep_flow
  use sig_property_checks, only: bad_creep, bad_elastic_constant
  use sig_radial_return, only: elastic_trial, finish_return, trial_t
  implicit none(type, external)
  private
  public :: norton_creep_t

  type, extends(material_law_t) :: norton_creep_t
  contains
    procedure :: start
    procedure :: update
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

  !> Makes one step, as material_law_t says.
  pure subroutine update(self, strain, dt, properties, state_in, stress, state, tangent, is_solved)
    class(norton_creep_t), intent(in) :: self
    real(rk), intent(in) :: strain(n_components)
    real(rk), intent(in) :: dt
    real(rk), intent(in) :: properties(:)
    real(rk), intent(in) :: state_in(:)
    real(rk), intent(out) :: stress(n_components)
    real(rk), intent(out) :: state(:)
    real(rk), intent(out) :: tangent(n_components, n_components)
    logical, intent(out) :: is_solved
    type(trial_t) :: trial

    trial = elastic_trial(strain, properties(1), properties(2), 0.0_rk, state_in)
    call finish_return(trial, creep_flow(trial, creep_step(trial%shear_modulus, dt, properties(coefficient), &
      properties(exponent))), state_in, stress, state, tangent, is_solved)
    if (self%bad_property(properties) > 0) is_solved = .false.
  end subroutine update

  !> Returns the number of the first property that is out of its range, 0 if there is none.
  pure integer function bad_property(self, properties)
    class(norton_creep_t), intent(in) :: self
    real(rk), intent(in) :: properties(:)

    bad_property = bad_elastic_constant(properties)
    if (bad_property == 0) bad_property = bad_creep(properties, coefficient, exponent)
  end function bad_property
end module sig_norton_creep
