! SPDX-License-Identifier: BSD-3-Clause
!> What a material does at one point: stress, state and tangent from strain, time step, properties and the state before.
!>
!> Tensors have the components xx, yy, zz, xy, yz, xz (in axisymmetry rr, zz, hoop, rz first), as in mechanical_models.f90; shear
!> strains are angles. They are always those of space: plane strain and axisymmetry have zeros where the model has no strain. A law
!> allocates nothing and keeps nothing, so that many threads may use one.
module sig_material_law
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: material_law_t, n_components, n_shared_state
  public :: plastic_strains, creep_strains, plastic_strain_at, creep_strain_at
  public :: inelastic_strain, plastic_work, creep_work

  !> number of components of a tensor
  integer, parameter :: n_components = 6

  !> The first numbers of a state mean the same in every law; a law may append its own. The virgin state is zero.
  !> places of the plastic strain and the creep strain [-], shears as angles
  integer, parameter :: plastic_strains(n_components) = [1, 2, 3, 4, 5, 6]
  integer, parameter :: creep_strains(n_components) = [7, 8, 9, 10, 11, 12]
  !> places of the equivalent plastic strain and the equivalent creep strain [-], both accumulated: the integrals of
  !> sqrt(2/3 d:d) for the rate d of the strain
  integer, parameter :: plastic_strain_at = 13
  integer, parameter :: creep_strain_at = 14
  integer, parameter :: n_shared_state = 14

  type, abstract :: material_law_t
    !> name and [-] strains of the hardening curve with which make_law made it
    character(24) :: name = ''
    real(rk), allocatable :: curve_strains(:)
    !> what each property is, in the order in which update takes them: keys of the deck, or `stress` for those of a curve
    character(20), allocatable :: property_names(:)
    !> how many numbers a state has, >= n_shared_state
    integer :: n_state = n_shared_state
  contains
    procedure(start_of_law), deferred :: start
    procedure(update_of_law), deferred :: update
    procedure(bad_property_of_law), deferred :: bad_property
    procedure :: n_properties
  end type material_law_t

  abstract interface
    !> Makes the law ready, with its curve_strains.
    pure subroutine start_of_law(self)
      import :: material_law_t
      class(material_law_t), intent(inout) :: self
    end subroutine start_of_law

    !> Makes one step of backward Euler.
    pure subroutine update_of_law(self, strain, dt, properties, state_in, stress, state, tangent, is_solved)
      import :: material_law_t, n_components, rk
      class(material_law_t), intent(in) :: self
      !> [-] total strain without the imposed strain, at the end of the step
      real(rk), intent(in) :: strain(n_components)
      !> [time] >= 0
      real(rk), intent(in) :: dt
      !> values at this point at the end of the step; shape (n_properties)
      real(rk), intent(in) :: properties(:)
      !> state at the start of the step; shape (n_state)
      real(rk), intent(in) :: state_in(:)
      !> [force/length**2]
      real(rk), intent(out) :: stress(n_components)
      !> state at the end of the step; shape as state_in
      real(rk), intent(out) :: state(:)
      !> [force/length**2] d stress / d strain of this very step, symmetric for the laws of this folder
      real(rk), intent(out) :: tangent(n_components, n_components)
      !> false: strain or properties are no finite numbers or out of range; the other results are then those of no inelastic strain
      !> in this step, and may be no numbers
      logical, intent(out) :: is_solved
    end subroutine update_of_law

    !> Returns the number of the first property that is out of its range, 0 if there is none.
    pure integer function bad_property_of_law(self, properties)
      import :: material_law_t, rk
      class(material_law_t), intent(in) :: self
      !> shape (n_properties)
      real(rk), intent(in) :: properties(:)
    end function bad_property_of_law
  end interface

contains

  !> Returns how many properties the law has.
  pure integer function n_properties(self)
    class(material_law_t), intent(in) :: self

    n_properties = size(self%property_names)
  end function n_properties

  !> Returns the sum of plastic strain and creep strain [-].
  pure function inelastic_strain(state) result(strain)
    !> shape (n_state)
    real(rk), intent(in) :: state(:)
    real(rk) :: strain(n_components)

    strain = state(plastic_strains) + state(creep_strains)
  end function inelastic_strain

  !> Returns the plastic work of a step per volume, stress : (change of plastic strain) [force/length**2]. Of it, kinematic
  !> hardening stores the change of H/3 (plastic strain : plastic strain); without it all is dissipated.
  pure real(rk) function plastic_work(stress, state_in, state)
    !> [force/length**2] at the end of the step
    real(rk), intent(in) :: stress(n_components)
    !> states at start and end; shape (n_state)
    real(rk), intent(in) :: state_in(:), state(:)

    plastic_work = dot_product(stress, state(plastic_strains) - state_in(plastic_strains))
  end function plastic_work

  !> Returns the creep work of a step per volume, stress : (change of creep strain) [force/length**2]; all of it is dissipated.
  pure real(rk) function creep_work(stress, state_in, state)
    !> [force/length**2] at the end of the step
    real(rk), intent(in) :: stress(n_components)
    !> states at start and end; shape (n_state)
    real(rk), intent(in) :: state_in(:), state(:)

    creep_work = dot_product(stress, state(creep_strains) - state_in(creep_strains))
  end function creep_work
end module sig_material_law
