! SPDX-License-Identifier: BSD-3-Clause
!> Reads the section `materials` of a deck: elastic constants, plasticity, creep.
module sig_deck_read_materials
  use sig_deck_config, only: creep_config_t, material_config_t, plasticity_config_t, temperature_name, value_config_t
  use sig_deck_tree, only: deck_tree_t, shown
  use sig_deck_values, only: get_entries, get_list_entries, get_mapping, get_names, get_value, is_mapping, number_of, value_of
  use sig_kinds, only: rk
  use sig_text, only: counted, string_t, to_text
  use sig_value_products, only: depends_on
  implicit none(type, external)
  private
  public :: read_materials

  character(*), parameter :: wanted = 'a number or an expression of the parameters, the time and the temperature T'
  !> keys of plasticity of which at most one may stand in a deck
  character(*), parameter :: hardening_keys(4) = [character(19) :: 'isotropic_hardening', 'kinematic_hardening', &
    'tangent_modulus', 'curve']

contains

  !> Reads the section materials, one element per entry. Errors: an unknown key, a value that is missing or faulty (a harmless value
  !> stands in its place).
  subroutine read_materials(tree, materials)
    !> gets the errors
    type(deck_tree_t), intent(inout) :: tree
    type(material_config_t), allocatable, intent(out) :: materials(:)
    integer, allocatable :: nodes(:)
    integer :: i

    call get_entries(tree, 'materials', nodes)
    allocate (materials(size(nodes)))
    do i = 1, size(nodes)
      materials(i)%name = tree%nodes(nodes(i))%key
      materials(i)%young_modulus%constant = 1
      allocate (materials(i)%regions(0))
      if (.not. is_mapping(tree, nodes(i))) cycle
      call get_names(tree, nodes(i), 'regions', .true., materials(i)%regions)
      call get_value(tree, nodes(i), 'young_modulus', materials(i)%young_modulus)
      call get_value(tree, nodes(i), 'poisson_ratio', materials(i)%poisson_ratio)
      materials(i)%has_thermal_expansion = tree%find(nodes(i), 'thermal_expansion') > 0
      if (materials(i)%has_thermal_expansion) call get_value(tree, nodes(i), 'thermal_expansion', materials(i)%thermal_expansion)
      call read_plasticity(tree, nodes(i), materials(i)%plasticity)
      call read_creep(tree, nodes(i), materials(i)%creep)
      call tree%close_mapping(nodes(i))
    end do
  end subroutine read_materials

  !> Reads plasticity: a yield stress and at most one kind of hardening, or a curve, which has the yield stress as its first stress.
  subroutine read_plasticity(tree, i_material, plasticity)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_material
    type(plasticity_config_t), intent(inout) :: plasticity
    integer :: i, i_found(size(hardening_keys)), i_mapping, i_yield

    allocate (plasticity%curve_strains(1), plasticity%curve_stresses(1))
    plasticity%curve_strains = 0
    call set_number(plasticity%yield_stress, 1.0_rk)
    call set_number(plasticity%modulus, 0.0_rk)
    call set_number(plasticity%curve_stresses(1), 1.0_rk)
    if (tree%find(i_material, 'plasticity') == 0) return
    i_mapping = get_mapping(tree, i_material, 'plasticity', .true.)
    if (i_mapping == 0) return
    plasticity%is_used = .true.
    i_yield = tree%find(i_mapping, 'yield_stress')
    do i = 1, size(hardening_keys)
      i_found(i) = tree%find(i_mapping, trim(hardening_keys(i)))
      if (i_found(i) > 0) plasticity%hardening = hardening_keys(i)
    end do
    if (count(i_found > 0) > 1) then
      call tree%report_key(i_mapping, tree%key_path(i_mapping) // ' has ' // to_text(count(i_found > 0)) // &
        ' kinds of hardening; it may have one of isotropic_hardening, kinematic_hardening, tangent_modulus and curve')
      plasticity%hardening = ''
    else if (plasticity%hardening == 'curve') then
      call read_curve(tree, i_mapping, plasticity)
    else if (plasticity%hardening /= '') then
      call read_property(tree, maxval(i_found), plasticity%modulus)
    end if
    if (i_yield > 0) then
      call read_property(tree, i_yield, plasticity%yield_stress)
    else if (plasticity%hardening == 'curve') then
      plasticity%yield_stress = plasticity%curve_stresses(1)
    else
      call tree%report_key(i_mapping, tree%key_path(i_mapping) // '.yield_stress is missing')
    end if
    call tree%close_mapping(i_mapping)
  end subroutine read_plasticity

  !> Reads a hardening curve. Errors: lists of different length, strains that do not begin at 0 or do not increase; then the curve
  !> keeps its harmless point.
  subroutine read_curve(tree, i_plasticity, plasticity)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_plasticity
    type(plasticity_config_t), intent(inout) :: plasticity
    integer, allocatable :: strains(:), stresses(:)
    real(rk), allocatable :: numbers(:)
    integer :: i, i_curve
    logical :: are_all_valid, is_valid

    i_curve = get_mapping(tree, i_plasticity, 'curve', .true.)
    if (i_curve == 0) return
    call get_list_entries(tree, i_curve, 'plastic_strain', .true., .false., strains)
    call get_list_entries(tree, i_curve, 'stress', .true., .false., stresses)
    call tree%close_mapping(i_curve)
    if (size(strains) == 0 .or. size(stresses) == 0) return
    if (size(strains) /= size(stresses)) then
      call tree%report_key(i_curve, tree%key_path(i_curve) // ' has ' // counted(size(strains), 'plastic strain') // ' and ' // &
        counted(size(stresses), 'stress') // '; it must have as many strains as stresses')
      return
    end if
    allocate (numbers(size(strains)), source=0.0_rk)
    are_all_valid = .true.
    do i = 1, size(strains)
      call number_of(tree, strains(i), numbers(i), is_valid)
      are_all_valid = are_all_valid .and. is_valid
    end do
    if (.not. are_all_valid) return
    if (numbers(1) < 0 .or. numbers(1) > 0) call tree%report(strains(1), 'is ' // to_text(numbers(1)) // &
      '; the curve must begin at the plastic strain 0, where its stress is the yield stress', &
      'from a tensile test: plastic strain = total strain - stress / young_modulus')
    do i = 2, size(numbers)
      if (numbers(i) > numbers(i - 1)) cycle
      call tree%report(strains(i), 'is ' // to_text(numbers(i)) // '; it must be greater than the plastic strain before it, ' // &
        to_text(numbers(i - 1)))
      return
    end do
    deallocate (plasticity%curve_stresses)
    allocate (plasticity%curve_stresses(size(stresses)))
    do i = 1, size(stresses)
      call set_number(plasticity%curve_stresses(i), 1.0_rk)
      call read_property(tree, stresses(i), plasticity%curve_stresses(i))
    end do
    plasticity%curve_strains = numbers
  end subroutine read_curve

  !> Reads creep, of which there is one law so far.
  subroutine read_creep(tree, i_material, creep)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_material
    type(creep_config_t), intent(inout) :: creep
    integer :: i_creep, i_norton

    call set_number(creep%coefficient, 0.0_rk)
    call set_number(creep%exponent, 1.0_rk)
    if (tree%find(i_material, 'creep') == 0) return
    i_creep = get_mapping(tree, i_material, 'creep', .true.)
    if (i_creep == 0) return
    creep%is_used = .true.
    i_norton = get_mapping(tree, i_creep, 'norton', .true.)
    call tree%close_mapping(i_creep)
    if (i_norton == 0) return
    call get_property(tree, i_norton, 'coefficient', creep%coefficient)
    call get_property(tree, i_norton, 'exponent', creep%exponent)
    call tree%close_mapping(i_norton)
  end subroutine read_creep

  !> Reads the property below a required key.
  subroutine get_property(tree, i_parent, key, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_parent
    character(*), intent(in) :: key
    type(value_config_t), intent(inout) :: value
    integer :: i_node

    i_node = tree%find(i_parent, key)
    if (i_node == 0) then
      call tree%report_key(i_parent, tree%key_path(i_parent) // '.' // key // ' is missing')
    else
      call read_property(tree, i_node, value)
    end if
  end subroutine get_property

  !> Reads a number or an expression that may name the temperature of the region. After an error the value keeps its number. Errors:
  !> those of value_of; the temperature is named, but a parameter or a table has its name, too.
  subroutine read_property(tree, i_node, value)
    type(deck_tree_t), intent(inout) :: tree
    integer, intent(in) :: i_node
    type(value_config_t), intent(inout) :: value
    type(value_config_t) :: found
    type(string_t) :: temperature(1)
    integer :: i
    logical :: is_own_name, is_valid

    temperature(1)%text = temperature_name
    is_own_name = .not. any([(tree%parameter_names(i)%text == temperature_name, i=1, size(tree%parameter_names))])
    call value_of(tree, i_node, wanted, found, is_valid, may_use_temperature=is_own_name)
    if (.not. is_valid) return
    if (is_own_name .or. .not. depends_on(found%text, temperature)) then
      value = found
    else
      call tree%report(i_node, 'is ' // shown(found%text) // '; T is here the temperature of the region, but it is also the ' // &
        'name of a parameter or a table; rename that one')
    end if
  end subroutine read_property

  pure subroutine set_number(value, number)
    type(value_config_t), intent(inout) :: value
    real(rk), intent(in) :: number

    value%text = to_text(number)
    value%constant = number
  end subroutine set_number
end module sig_deck_read_materials
