! SPDX-License-Identifier: BSD-3-Clause
!> Checks of plasticity and creep in the section `materials`.
module sig_deck_check_flow
  use sig_deck_check_values, only: check_order, check_range
  use sig_deck_config, only: deck_config_t, material_config_t, temperature_name, value_config_t
  use sig_deck_material_laws, only: temperature_entries
  use sig_deck_tree, only: deck_tree_t, shown
  use sig_kinds, only: rk
  use sig_text, only: to_text
  use sig_value_products, only: replace_name
  implicit none(type, external)
  private
  public :: check_flow

contains

  !> Checks a material that yields or creeps: whether the deck has what it needs (a history, a mechanical model that is not thin,
  !> the unit of the time, the temperature that expressions name), and the ranges of its properties, as check_range describes.
  !> Where the temperature depends on the place, ranges are not checked here, but where the property is used.
  subroutine check_flow(tree, config, i_material)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(deck_config_t), intent(in) :: config
    !> number of the material, 1-based
    integer, intent(in) :: i_material
    character(:), allocatable :: path, stress_unit

    associate (material => config%materials(i_material))
      if (.not. material%flows()) return
      path = 'materials.' // material%name
      stress_unit = ' ' // config%units%force // '/' // config%units%length // '^2'
      if (material%plasticity%is_used) then
        call check_surroundings(tree, path // '.plasticity', config)
        call check_plasticity(tree, path // '.plasticity', config, material, stress_unit)
      end if
      if (.not. material%creep%is_used) return
      call check_surroundings(tree, path // '.creep', config)
      if (config%units%time == '') call tree%report_at(path // '.creep', &
        'is given, but units has no time; the coefficient is a rate, and the unit of the time must be known', &
        'for example: units: {length: mm, force: N, time: h}')
      if (material%plasticity%hardening == 'kinematic_hardening') call tree%report_at(path // '.creep', &
        'does not go with kinematic_hardening: creep follows the stress, and plastic strain the stress less the back stress, ' // &
        'which needs a system of equations at each point', 'use isotropic_hardening, tangent_modulus or a curve')
      call check_property(tree, path // '.creep.norton.coefficient', config, material, material%creep%coefficient, 0.0_rk, '', &
        may_be_bound=.true.)
      call check_property(tree, path // '.creep.norton.exponent', config, material, material%creep%exponent, 1.0_rk, '', &
        may_be_bound=.true.)
    end associate
  end subroutine check_flow

  !> Checks what every material that flows needs in other sections.
  subroutine check_surroundings(tree, path, config)
    type(deck_tree_t), intent(inout) :: tree
    !> key path of plasticity or creep
    character(*), intent(in) :: path
    type(deck_config_t), intent(in) :: config

    if (config%mesh%model == 'plane_stress') call tree%report_at(path, 'does not go with the model plane_stress; materials ' // &
      'that yield or creep need plane_strain, axisymmetric or solid')
    if (.not. config%history%states%is_there()) call tree%report_at(path, 'is given, but the deck has no history; strains ' // &
      'that stay depend on all states before, so the deck must give their times', &
      'for example: history: {steps: [{until: 1, increments: 10}]}')
  end subroutine check_surroundings

  subroutine check_plasticity(tree, path, config, material, unit)
    type(deck_tree_t), intent(inout) :: tree
    character(*), intent(in) :: path
    type(deck_config_t), intent(in) :: config
    type(material_config_t), intent(in) :: material
    !> of a stress, with a blank before it
    character(*), intent(in) :: unit
    character(:), allocatable :: key

    associate (plasticity => material%plasticity)
      if (plasticity%hardening == 'curve') then
        call check_curve(tree, path, config, material, unit)
        return
      end if
      call check_property(tree, path // '.yield_stress', config, material, plasticity%yield_stress, 0.0_rk, unit)
      if (plasticity%hardening == '') return
      key = path // '.' // trim(plasticity%hardening)
      call check_property(tree, key, config, material, plasticity%modulus, 0.0_rk, unit, may_be_bound=.true.)
      if (plasticity%hardening == 'tangent_modulus') call compare(tree, key, config, material, plasticity%modulus, &
        material%young_modulus, .true., 'less than young_modulus', unit)
    end associate
  end subroutine check_plasticity

  !> Checks that the stresses of a curve are positive and do not fall, and that a yield stress beside it is the first one.
  subroutine check_curve(tree, path, config, material, unit)
    type(deck_tree_t), intent(inout) :: tree
    !> key path of plasticity
    character(*), intent(in) :: path
    type(deck_config_t), intent(in) :: config
    type(material_config_t), intent(in) :: material
    character(*), intent(in) :: unit
    character(:), allocatable :: key
    integer :: i

    associate (stresses => material%plasticity%curve_stresses, yield_stress => material%plasticity%yield_stress)
      if (yield_stress%text /= stresses(1)%text) call tree%report_at(path // '.yield_stress', 'is ' // &
        shown(yield_stress%text) // '; with a curve it must be the first stress of the curve, ' // shown(stresses(1)%text), &
        'leave yield_stress out: the curve has it')
      do i = 1, size(stresses)
        key = path // '.curve.stress[' // to_text(i) // ']'
        call check_property(tree, key, config, material, stresses(i), 0.0_rk, unit)
        if (i > 1) call compare(tree, key, config, material, stresses(i), stresses(i - 1), .false., &
          'at least the stress before it', unit)
      end do
    end associate
  end subroutine check_curve

  !> Checks that the regions of the material have the temperature that a property names, and the range of its value.
  subroutine check_property(tree, path, config, material, value, above, unit, may_be_bound)
    type(deck_tree_t), intent(inout) :: tree
    !> key path of the value
    character(*), intent(in) :: path
    type(deck_config_t), intent(in) :: config
    type(material_config_t), intent(in) :: material
    type(value_config_t), intent(in) :: value
    !> as in check_range
    real(rk), intent(in) :: above
    character(*), intent(in) :: unit
    logical, intent(in), optional :: may_be_bound
    integer, allocatable :: entries(:)
    integer :: i, n_errors

    if (.not. value%uses_temperature) then
      call check_range(tree, path, config, value, above, huge(1.0_rk), unit, may_be_bound)
      return
    end if
    n_errors = tree%errors%n_errors()
    do i = 1, size(material%regions)
      if (len(material%regions(i)%text) == 0) cycle
      entries = temperature_entries(config%imposed_strains, material%regions(i)%text)
      if (size(entries) /= 1) then
        call tree%report_at(path, 'is ' // shown(value%text) // '; T is the temperature of the region, and ' // &
          shown(material%regions(i)%text) // ' has ' // trim(merge('none   ', 'several', size(entries) == 0)) // &
          '; imposed_strains must have one entry with a temperature for it', &
          'for example: imposed_strains: [{region: ' // material%regions(i)%text // ', temperature: 600, reference: 293}]; ' // &
          'thermal_expansion: 0 where it expands nothing')
      else if (.not. varies(config, entries(1))) then
        call check_range(tree, path, config, at_temperature(config, value, entries(1)), above, huge(1.0_rk), unit, may_be_bound)
      end if
      ! one message per property is enough
      if (tree%errors%n_errors() > n_errors) return
    end do
  end subroutine check_property

  !> Compares two properties as check_order does, in each region whose temperature they name.
  subroutine compare(tree, path, config, material, value, other, must_be_less, rule, unit)
    type(deck_tree_t), intent(inout) :: tree
    character(*), intent(in) :: path
    type(deck_config_t), intent(in) :: config
    type(material_config_t), intent(in) :: material
    type(value_config_t), intent(in) :: value, other
    !> as in check_order
    logical, intent(in) :: must_be_less
    character(*), intent(in) :: rule, unit
    integer, allocatable :: entries(:)
    integer :: i, n_errors

    if (.not. (value%uses_temperature .or. other%uses_temperature)) then
      call check_order(tree, path, config, value, other, must_be_less, rule, unit)
      return
    end if
    n_errors = tree%errors%n_errors()
    do i = 1, size(material%regions)
      entries = temperature_entries(config%imposed_strains, material%regions(i)%text)
      if (size(entries) /= 1 .or. tree%errors%n_errors() > n_errors) cycle
      if (varies(config, entries(1))) cycle
      call check_order(tree, path, config, at_temperature(config, value, entries(1)), at_temperature(config, other, entries(1)), &
        must_be_less, rule, unit)
    end do
  end subroutine compare

  !> Whether the temperature of an entry of imposed_strains depends on the place.
  pure logical function varies(config, i_entry)
    type(deck_config_t), intent(in) :: config
    integer, intent(in) :: i_entry

    varies = config%imposed_strains(i_entry)%has_field .or. config%imposed_strains(i_entry)%value%uses_coordinates
  end function varies

  !> Returns a property with the temperature of an entry of imposed_strains in place of its name. Requires: it does not vary.
  pure type(value_config_t) function at_temperature(config, value, i_entry) result(replaced)
    type(deck_config_t), intent(in) :: config
    type(value_config_t), intent(in) :: value
    integer, intent(in) :: i_entry

    replaced = value
    if (.not. value%uses_temperature) return
    associate (entry => config%imposed_strains(i_entry))
      replaced%uses_temperature = .false.
      replaced%text = replace_name(value%text, temperature_name, entry%value%text)
      replaced%uses_history = value%uses_history .or. entry%value%uses_history
    end associate
  end function at_temperature
end module sig_deck_check_flow
