! SPDX-License-Identifier: BSD-3-Clause
!> Which law a material of the deck that flows has, and its properties in the order of this law.
module sig_deck_material_laws
  use sig_deck_config, only: imposed_strain_config_t, material_config_t, value_config_t
  use sig_kinds, only: rk
  use sig_material_law, only: material_law_t
  use sig_material_laws, only: make_law
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: law_of_material, temperature_entries

contains

  !> Makes the law of a material that flows (material%flows()), and lists its properties.
  !>
  !> A property is an expression of the parameters of a state and, where uses_temperature, of the temperature of the region
  !> (temperature_name); compile it as a composed one. Its line and column are those of the deck.
  subroutine law_of_material(material, law, properties)
    type(material_config_t), intent(in) :: material
    class(material_law_t), allocatable, intent(out) :: law
    !> in the order of law%property_names
    type(value_config_t), allocatable, intent(out) :: properties(:)
    character(21) :: name
    integer :: i, n_stresses

    name = 'plasticity_with_creep'
    if (.not. material%creep%is_used) name = 'plasticity'
    if (.not. material%plasticity%is_used) name = 'norton_creep'
    call make_law(trim(name), material%plasticity%curve_strains, law)
    allocate (properties(law%n_properties()))
    n_stresses = 0
    do i = 1, size(properties)
      properties(i) = number(0.0_rk)
      select case (law%property_names(i))
      case ('young_modulus')
        properties(i) = material%young_modulus
      case ('poisson_ratio')
        properties(i) = material%poisson_ratio
      case ('coefficient')
        properties(i) = material%creep%coefficient
      case ('exponent')
        properties(i) = material%creep%exponent
      case ('yield_stress')
        n_stresses = n_stresses + 1
        properties(i) = material%plasticity%yield_stress
        if (material%plasticity%hardening == 'curve') properties(i) = material%plasticity%curve_stresses(n_stresses)
      case default
        if (law%property_names(i) == material%plasticity%hardening) properties(i) = material%plasticity%modulus
        if (law%property_names(i) == 'isotropic_hardening' .and. material%plasticity%hardening == 'tangent_modulus') &
          properties(i) = hardening_of_tangent(material%young_modulus, material%plasticity%modulus)
      end select
    end do
  end subroutine law_of_material

  !> Returns the hardening modulus H = E E_T / (E - E_T) of a tangent modulus E_T of uniaxial stress.
  pure type(value_config_t) function hardening_of_tangent(young_modulus, tangent) result(hardening)
    type(value_config_t), intent(in) :: young_modulus, tangent

    hardening = tangent
    hardening%is_constant = young_modulus%is_constant .and. tangent%is_constant
    if (hardening%is_constant) then
      hardening%constant = tangent%constant / (1 - tangent%constant / young_modulus%constant)
      hardening%text = to_text(hardening%constant)
    else
      hardening%text = '(' // tangent%text // ')/(1-(' // tangent%text // ')/(' // young_modulus%text // '))'
      hardening%uses_parameters = young_modulus%uses_parameters .or. tangent%uses_parameters
      hardening%uses_history = young_modulus%uses_history .or. tangent%uses_history
    end if
  end function hardening_of_tangent

  pure type(value_config_t) function number(value)
    real(rk), intent(in) :: value

    number%text = to_text(value)
    number%constant = value
  end function number

  !> Returns which entries of imposed_strains give a region a temperature, directly or by a field; 1-based.
  pure function temperature_entries(strains, region) result(entries)
    type(imposed_strain_config_t), intent(in) :: strains(:)
    character(*), intent(in) :: region
    integer, allocatable :: entries(:)
    integer :: i

    entries = pack([(i, i=1, size(strains))], [(strains(i)%is_thermal .and. strains(i)%region%text == region, i=1, size(strains))])
  end function temperature_entries
end module sig_deck_material_laws
