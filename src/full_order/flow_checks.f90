! SPDX-License-Identifier: BSD-3-Clause
!> Checks the properties of materials that flow where they depend on the temperature, which only the mesh tells.
module sig_flow_checks
  use sig_deck_config, only: value_config_t
  use sig_deck_material_laws, only: law_of_material
  use sig_errors, only: error_t, make_error
  use sig_flow_properties, only: compiled_properties_t
  use sig_kinds, only: rk
  use sig_material_law, only: material_law_t
  use sig_parameter_space, only: format_point
  use sig_problem, only: problem_t
  use sig_property_checks, only: rule_of
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: check_flow_properties

contains

  !> Checks the properties of all materials that flow at each of some points, where the temperature of the material is lowest and
  !> where it is highest. Errors: the first property that is not finite or out of its range. Local.
  subroutine check_flow_properties(problem, points, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    type(compiled_properties_t) :: compiled
    character(:), allocatable :: message
    integer, allocatable :: materials(:), extremes(:)
    real(rk), allocatable :: degrees(:), properties(:, :)
    integer :: bad, i, i_point

    if (.not. problem%flow%is_there()) return
    associate (flow => problem%flow)
      ! the deck has compiled all expressions before
      call flow%properties%compile(compiled, message)
      materials = flow%point_materials(problem%mesh, problem%body)
      allocate (properties(flow%properties%n_most(), 1))
      do i_point = 1, size(points, 2)
        degrees = compiled%temperature(points(:, i_point), flow%temperatures)
        extremes = extreme_places(materials, degrees)
        do i = 1, size(extremes)
          associate (k => extremes(i), law => flow%laws(materials(extremes(i)))%law)
            call compiled%evaluate(points(:, i_point), materials(k:k), flow%temperatures(k:k, :), properties)
            bad = law%bad_property(properties(:law%n_properties(), 1))
            if (bad == 0) cycle
            call refuse(problem, points(:, i_point), materials(k), bad, properties(bad, 1), degrees(k), error)
            return
          end associate
        end do
      end do
    end associate
  end subroutine check_flow_properties

  !> Returns for each material the number of its point with the lowest and of that with the highest temperature.
  pure function extreme_places(materials, degrees) result(places)
    !> of each point, 1-based
    integer, intent(in) :: materials(:)
    !> [degree] shape (n_points)
    real(rk), intent(in) :: degrees(:)
    integer, allocatable :: places(:)
    integer :: i

    allocate (places(0))
    do i = 1, maxval(materials)
      if (.not. any(materials == i)) cycle
      places = [places, minloc(degrees, 1, materials == i), maxloc(degrees, 1, materials == i)]
    end do
  end function extreme_places

  !> Makes the error about one property.
  subroutine refuse(problem, point, i_material, i_property, value, degrees, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> 1-based, and so is the property among those of the law
    integer, intent(in) :: i_material, i_property
    real(rk), intent(in) :: value
    !> [degree] temperature
    real(rk), intent(in) :: degrees
    type(error_t), allocatable, intent(out) :: error
    class(material_law_t), allocatable :: law
    type(value_config_t), allocatable :: values(:)
    character(:), allocatable :: heat, name

    call law_of_material(problem%deck%materials(i_material), law, values)
    name = trim(law%property_names(i_property))
    heat = ''
    if (values(i_property)%uses_temperature) heat = 'T = ' // to_text(degrees) // ', '
    associate (place => values(i_property))
      call make_error(error, name // ' of materials.' // problem%deck%materials(i_material)%name // ' is ''' // place%text // &
        ''', which is ' // to_text(value) // ' at ' // heat // format_point(problem%deck%state_parameters, point) // '; ' // &
        trim(rule_of(name)), problem%deck%path, place%line, place%column, &
        'change it, the temperature or the range of the parameters')
    end associate
  end subroutine refuse
end module sig_flow_checks
