! SPDX-License-Identifier: BSD-3-Clause
!> The laws of the materials of a deck that flow, and the values of their properties at integration points.
module sig_flow_model
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: n_stresses
  use sig_flow_properties, only: compiled_properties_t, flow_properties_t
  use sig_flowing_cells, only: flow_laws_t, flowing_cells_t, point_data_t
  use sig_imposed_strain, only: strain_field_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_point_values, only: count_points
  implicit none(type, external)
  private
  public :: flow_model_t

  !> All laws of a problem.
  type :: flow_model_t
    !> shape (n_materials); not allocated where nothing flows
    type(flow_laws_t), allocatable :: laws(:)
    !> of all materials of the deck
    type(flow_properties_t) :: properties
    !> whether some property of each material contains the temperature, shape (n_materials)
    logical, allocatable :: is_hot(:)
    !> parts of the temperature [degree] at the points of all flowing cells of the mesh, in their order; 0 in cells to which a part
    !> does not belong; shape (n_points, n_parts)
    real(rk), allocatable :: temperatures(:, :)
    !> whether some law has plastic strains, and whether some has creep strains
    logical :: has_plasticity = .false.
    logical :: has_creep = .false.
  contains
    procedure :: is_there
    procedure :: evaluate
    procedure :: point_materials
    procedure :: find_cell_means
  end type flow_model_t

contains

  !> Whether any material flows.
  pure logical function is_there(self)
    class(flow_model_t), intent(in) :: self

    is_there = allocated(self%laws)
  end function is_there

  !> Computes what is given at the points of a rank's flowing cells. Local.
  subroutine evaluate(self, body, point, field, flowing, data)
    class(flow_model_t), intent(in) :: self
    type(elastic_body_t), intent(in) :: body
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> imposed strains at this point
    type(strain_field_t), intent(in) :: field
    type(flowing_cells_t), intent(in) :: flowing
    type(point_data_t), intent(inout) :: data
    type(compiled_properties_t) :: compiled
    character(:), allocatable :: message
    integer :: i, k, materials(flowing%n_points()), places(flowing%n_points())

    associate (n => flowing%n_points())
      if (.not. allocated(data%imposed)) allocate (data%imposed(n_stresses, n), &
        data%properties(self%properties%n_most(), n), source=0.0_rk)
    end associate
    do i = 1, size(flowing%cells)
      do k = 1, flowing%offsets(i + 1) - flowing%offsets(i)
        data%imposed(:, flowing%offsets(i) + k) = field%at_point(flowing%cells(i), k)
        materials(flowing%offsets(i) + k) = body%material_of_cell(flowing%cells(i))
        places(flowing%offsets(i) + k) = flowing%places(i) + k
      end do
    end do
    ! the deck has compiled all expressions before
    call self%properties%compile(compiled, message)
    call compiled%evaluate(point, materials, self%temperatures(places, :), data%properties)
  end subroutine evaluate

  !> Returns the material of each point of all flowing cells of the mesh, 1-based, in the order of `temperatures`. Local.
  pure function point_materials(self, mesh, body) result(materials)
    class(flow_model_t), intent(in) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    integer :: materials(size(self%temperatures, 1))
    integer :: first, i, n

    first = 0
    do i = 1, mesh%n_cells
      if (.not. body%flows_in(i)) cycle
      n = count_points(mesh, body, [i])
      materials(first + 1:first + n) = body%material_of_cell(i)
      first = first + n
    end do
  end function point_materials

  !> Computes means over the integration points of each cell, in shape (n_cells); not a number where there is no such value. Local.
  subroutine find_cell_means(self, mesh, body, point, temperatures, yield_stresses)
    class(flow_model_t), intent(in) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> [degree] where a property contains the temperature
    real(rk), allocatable, intent(out) :: temperatures(:)
    !> [force/length**2] before the material hardens, where it is plastic
    real(rk), allocatable, intent(out) :: yield_stresses(:)
    type(compiled_properties_t) :: compiled
    character(:), allocatable :: message
    real(rk), allocatable :: properties(:, :)
    integer :: first, i, k, n

    allocate (temperatures(mesh%n_cells), source=ieee_value(0.0_rk, ieee_quiet_nan))
    allocate (yield_stresses, source=temperatures)
    call self%properties%compile(compiled, message)
    first = 0
    do i = 1, mesh%n_cells
      if (.not. body%flows_in(i)) cycle
      n = count_points(mesh, body, [i])
      associate (m => body%material_of_cell(i), parts => self%temperatures(first + 1:first + n, :))
        if (self%is_hot(m)) temperatures(i) = sum(compiled%temperature(point, parts)) / n
        allocate (properties(self%laws(m)%law%n_properties(), n))
        call compiled%evaluate(point, spread(m, 1, n), parts, properties)
        do k = 1, size(properties, 1)
          if (self%laws(m)%law%property_names(k) /= 'yield_stress') cycle
          yield_stresses(i) = sum(properties(k, :)) / n
          exit
        end do
        deallocate (properties)
      end associate
      first = first + n
    end do
  end subroutine find_cell_means
end module sig_flow_model
