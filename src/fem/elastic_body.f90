! SPDX-License-Identifier: BSD-3-Clause
!> Everything that the stiffness of a mesh needs beside the mesh: mechanical model, Hooke's matrix of each material, material of
!> each cell, and the tabulated shape functions of the elements.
module sig_elastic_body
  use sig_element_types, only: element_types, n_element_types
  use sig_elasticity, only: hooke_matrix, n_strains, n_stresses, stress_matrix
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  use sig_quadrature, only: quadrature_rule, reduced_rule
  use sig_shape_functions, only: create_shape_table, shape_table_t
  implicit none(type, external)
  private
  public :: elastic_body_t, create_elastic_body

  !> All elastic bodies of a mesh together: what their stiffness needs beside the mesh.
  type :: elastic_body_t
    !> name of the mechanical model (plane_strain, plane_stress, axisymmetric or solid), and its row of mechanical_models
    character(:), allocatable :: model
    type(mechanical_model_t) :: mechanics
    !> [force/length**2] hooke_matrix of each material, shape (n_strains, n_strains, n_materials)
    real(rk), allocatable :: hooke(:, :, :)
    !> [force/length**2] all stresses from all elastic strains, shape (n_stresses, n_stresses, n_materials)
    real(rk), allocatable :: stress_matrix(:, :, :)
    !> material of each cell: index into the last dimension of hooke, shape (n_cells)
    integer, allocatable :: material_of_cell(:)
    !> whether the cells of each material have the integration of materials that flow (sig_flow_strains), shape (n_materials)
    logical, allocatable :: flows(:)
    !> shape functions at the integration points: one table per row of element_types, then one per row for cells that flow; table_of
    !> says which one a cell has
    type(shape_table_t) :: tables(2 * n_element_types)
  contains
    procedure :: set_moduli
    procedure :: set_stresses
    procedure :: set_flow
    procedure :: flows_in
    procedure :: without_flow
    procedure :: table_of
  end type elastic_body_t

contains

  !> Makes the bodies: Hooke's matrices from the elastic constants, and the shape functions of all element types but the point. Does
  !> not check the constants.
  subroutine create_elastic_body(model, young_moduli, poisson_ratios, material_of_cell, body)
    !> name of a mechanical model
    character(*), intent(in) :: model
    !> [force/length**2] shape (n_materials)
    real(rk), intent(in) :: young_moduli(:)
    !> [-] shape (n_materials)
    real(rk), intent(in) :: poisson_ratios(:)
    !> 1-based, shape (n_cells)
    integer, intent(in) :: material_of_cell(:)
    type(elastic_body_t), intent(out) :: body
    real(rk), allocatable :: points(:, :), weights(:)
    integer :: i_type

    body%model = model
    body%mechanics = mechanical_model(model)
    body%material_of_cell = material_of_cell
    call body%set_moduli(young_moduli, poisson_ratios)
    do i_type = 1, n_element_types
      if (element_types(i_type)%n_dim == 0) cycle
      call quadrature_rule(i_type, points, weights)
      call create_shape_table(i_type, points, weights, body%tables(i_type))
    end do
  end subroutine create_elastic_body

  !> Sets which materials flow, and makes the tables of the cells that have fewer integration points then.
  subroutine set_flow(self, flows)
    class(elastic_body_t), intent(inout) :: self
    !> shape (n_materials)
    logical, intent(in) :: flows(:)
    real(rk), allocatable :: points(:, :), weights(:)
    integer :: i_type

    self%flows = flows
    if (.not. any(flows)) return
    do i_type = 1, n_element_types
      if (element_types(i_type)%order /= 2 .or. element_types(i_type)%n_dim < 2) cycle
      call reduced_rule(i_type, points, weights)
      call create_shape_table(i_type, points, weights, self%tables(n_element_types + i_type))
    end do
  end subroutine set_flow

  !> Whether the material of a cell flows.
  pure logical function flows_in(self, i_cell)
    class(elastic_body_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: i_cell

    flows_in = .false.
    if (allocated(self%flows)) flows_in = self%flows(self%material_of_cell(i_cell))
  end function flows_in

  !> Returns the same bodies with the integration of elastic cells everywhere, for loads.
  pure type(elastic_body_t) function without_flow(self) result(body)
    class(elastic_body_t), intent(in) :: self

    body = self
    if (allocated(body%flows)) body%flows = .false.
  end function without_flow

  !> Returns which of the tables a cell has.
  pure integer function table_of(self, i_cell, i_type)
    class(elastic_body_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: i_cell
    !> its row of element_types
    integer, intent(in) :: i_type

    table_of = i_type
    if (element_types(i_type)%order == 2 .and. self%flows_in(i_cell)) table_of = n_element_types + i_type
  end function table_of

  !> Computes Hooke's matrices from new elastic constants, which are not checked. The number of materials may change.
  subroutine set_moduli(self, young_moduli, poisson_ratios)
    class(elastic_body_t), intent(inout) :: self
    !> [force/length**2] shape (n_materials)
    real(rk), intent(in) :: young_moduli(:)
    !> [-] shape (n_materials)
    real(rk), intent(in) :: poisson_ratios(:)
    integer :: i

    if (allocated(self%hooke)) deallocate (self%hooke, self%stress_matrix)
    allocate (self%hooke(n_strains(self%model), n_strains(self%model), size(young_moduli)))
    allocate (self%stress_matrix(n_stresses, n_stresses, size(young_moduli)))
    do i = 1, size(young_moduli)
      self%hooke(:, :, i) = hooke_matrix(self%model, young_moduli(i), poisson_ratios(i))
      self%stress_matrix(:, :, i) = stress_matrix(self%model, young_moduli(i), poisson_ratios(i))
    end do
  end subroutine set_moduli

  !> Sets `hooke` and `stress_matrix` of all materials to given matrices, for example to the part of Hooke's matrix that belongs to
  !> one modulus.
  pure subroutine set_stresses(self, matrices)
    class(elastic_body_t), intent(inout) :: self
    !> [force/length**2] all stresses from all elastic strains, shape (n_stresses, n_stresses, n_materials)
    real(rk), intent(in) :: matrices(:, :, :)

    associate (strains => self%mechanics%strains(:self%mechanics%n_strains))
      self%stress_matrix = matrices
      self%hooke = matrices(strains, strains, :)
    end associate
  end subroutine set_stresses
end module sig_elastic_body
