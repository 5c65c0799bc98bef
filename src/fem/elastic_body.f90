! SPDX-License-Identifier: BSD-3-Clause
!> Everything that the stiffness of a mesh needs beside the mesh: mechanical model, Hooke's matrix of each material, material of
!> each cell, and the tabulated shape functions of the elements.
module sig_elastic_body
  use sig_element_types, only: element_types, n_element_types
  use sig_elasticity, only: hooke_matrix, n_strains, n_stresses, stress_matrix
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  use sig_quadrature, only: quadrature_rule
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
    !> shape functions at the integration points, one table per row of element_types
    type(shape_table_t) :: tables(n_element_types)
  contains
    procedure :: set_moduli
    procedure :: set_stresses
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
