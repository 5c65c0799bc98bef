! SPDX-License-Identifier: BSD-3-Clause
!> The laws of the materials of a deck that flow, and the values of their properties at integration points.
module sig_flow_model
  use sig_deck_config, only: temperature_name, value_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: n_stresses
  use sig_expression, only: expression_t
  use sig_flowing_cells, only: flow_laws_t, flowing_cells_t, point_data_t
  use sig_imposed_strain, only: strain_field_t
  use sig_kinds, only: rk
  use sig_strain_parts, only: point_product_t
  use sig_text, only: append_text, string_t
  implicit none(type, external)
  private
  public :: flow_model_t, flow_properties_t

  !> The properties of one material in the order of its law: numbers, or expressions of the parameters and the temperature.
  type :: flow_properties_t
    type(value_config_t), allocatable :: values(:)
  end type flow_properties_t

  !> All laws of a problem.
  type :: flow_model_t
    !> shape (n_materials); not allocated where nothing flows
    type(flow_laws_t), allocatable :: laws(:)
    !> those of elastic materials are empty; shape (n_materials)
    type(flow_properties_t), allocatable :: properties(:)
    !> parts of the temperature [degree] at the points of all flowing cells of the mesh, in their order; 0 in cells to which a part
    !> does not belong; only where some property contains the temperature
    type(point_product_t), allocatable :: temperature(:)
    type(string_t), allocatable :: parameter_names(:)
    !> whether some law has plastic strains, and whether some has creep strains
    logical :: has_plasticity = .false.
    logical :: has_creep = .false.
  contains
    procedure :: is_there
    procedure :: evaluate
    procedure :: temperatures
  end type flow_model_t

contains

  !> Whether any material flows.
  pure logical function is_there(self)
    class(flow_model_t), intent(in) :: self

    is_there = allocated(self%laws)
  end function is_there

  !> Computes what is given at the points of a rank's flowing cells. A property that is not finite makes the law unsolved there.
  !> Local.
  subroutine evaluate(self, body, point, field, flowing, data)
    class(flow_model_t), intent(in) :: self
    type(elastic_body_t), intent(in) :: body
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> imposed strains at this point
    type(strain_field_t), intent(in) :: field
    type(flowing_cells_t), intent(in) :: flowing
    type(point_data_t), intent(inout) :: data
    real(rk), allocatable :: temperatures(:)
    integer :: i, k, m

    if (.not. allocated(data%imposed)) then
      allocate (data%imposed(n_stresses, flowing%n_points()), source=0.0_rk)
      allocate (data%properties(maxval([(size(self%properties(m)%values), m=1, size(self%properties))]), flowing%n_points()), &
        source=0.0_rk)
    end if
    do i = 1, size(flowing%cells)
      do k = 1, flowing%offsets(i + 1) - flowing%offsets(i)
        data%imposed(:, flowing%offsets(i) + k) = field%at_point(flowing%cells(i), k)
      end do
    end do
    temperatures = self%temperatures(point, flowing)
    do m = 1, size(self%laws)
      do k = 1, size(self%properties(m)%values)
        call evaluate_property(self, self%properties(m)%values(k), point, temperatures, &
          [(body%material_of_cell(flowing%cells(i)) == m, i=1, size(flowing%cells))], flowing%offsets, data%properties(k, :))
      end do
    end do
  end subroutine evaluate

  !> Computes one property at the points of the cells of one material.
  subroutine evaluate_property(self, value, point, temperatures, has_material, offsets, values)
    type(flow_model_t), intent(in) :: self
    type(value_config_t), intent(in) :: value
    real(rk), intent(in) :: point(:)
    !> at all points; empty if no property contains it
    real(rk), intent(in) :: temperatures(:)
    !> whether each cell has the material
    logical, intent(in) :: has_material(:)
    !> of flowing_cells_t
    integer, intent(in) :: offsets(:)
    !> values at other cells' points stay
    real(rk), intent(inout) :: values(:)
    type(string_t), allocatable :: names(:)
    type(expression_t) :: expression
    character(:), allocatable :: message
    real(rk) :: number
    integer :: i, n
    logical :: is_valid

    names = self%parameter_names
    if (value%uses_temperature) call append_text(names, temperature_name)
    number = value%constant
    is_valid = value%is_constant
    if (.not. is_valid) call expression%create(value%text, names, message, .true.)
    if (.not. (is_valid .or. value%uses_temperature)) call expression%evaluate(point, number, is_valid)
    do i = 1, size(has_material)
      if (.not. has_material(i)) cycle
      do n = offsets(i) + 1, offsets(i + 1)
        if (value%uses_temperature) call expression%evaluate([point, temperatures(n)], number, is_valid)
        values(n) = number
      end do
    end do
    call expression%destroy()
  end subroutine evaluate_property

  !> Returns the temperature [degree] at the points of a rank's flowing cells; empty if no property contains it. Local.
  function temperatures(self, point, flowing)
    class(flow_model_t), intent(in) :: self
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    type(flowing_cells_t), intent(in) :: flowing
    real(rk), allocatable :: temperatures(:)
    type(expression_t) :: expression
    character(:), allocatable :: message
    real(rk) :: factor
    integer :: i, i_part
    logical :: is_valid

    if (.not. allocated(self%temperature)) then
      allocate (temperatures(0))
      return
    end if
    allocate (temperatures(flowing%n_points()), source=0.0_rk)
    do i_part = 1, size(self%temperature)
      associate (part => self%temperature(i_part))
        factor = 1
        if (part%of_parameters /= '') then
          call expression%create(part%of_parameters, self%parameter_names, message, .true.)
          call expression%evaluate(point, factor, is_valid)
          call expression%destroy()
        end if
        do i = 1, size(flowing%cells)
          associate (n => flowing%offsets(i + 1) - flowing%offsets(i))
            temperatures(flowing%offsets(i) + 1:flowing%offsets(i + 1)) = &
              temperatures(flowing%offsets(i) + 1:flowing%offsets(i + 1)) + &
              factor * part%values(flowing%places(i) + 1:flowing%places(i) + n)
          end associate
        end do
      end associate
    end do
  end function temperatures
end module sig_flow_model
