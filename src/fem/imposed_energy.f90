! SPDX-License-Identifier: BSD-3-Clause
!> Computes what imposed strains eps* add to the strain energy 1/2 u' K u:
!> 1/2 int (eps - eps*)' C (eps - eps*) = 1/2 u' K u - F*' u + 1/2 int eps*' C eps*.
module sig_imposed_energy
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: n_stresses
  use sig_element_matrices, only: physical_gradients
  use sig_imposed_strain, only: imposed_strains_t, strain_field_t, strain_part_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: unit_vector
  use sig_load_pattern, only: load_pattern_t
  use sig_mechanical_models, only: circumference
  use sig_mesh, only: mesh_t, nodes_of_cell
  use sig_strain_force, only: strain_forces
  implicit none(type, external)
  private
  public :: imposed_energy_t

  !> The energy of imposed strains over some cells. Its terms are those of the imposed strains.
  type :: imposed_energy_t
    private
    !> [force] F* of the cells
    type(load_pattern_t) :: forces
    !> [force*length, force in the plane] 1/2 int eps_s' C eps_t, shape (n_terms, n_terms)
    real(rk), allocatable :: energies(:, :)
  contains
    procedure :: create
    procedure :: value
  end type imposed_energy_t

contains

  !> Computes the forces and energies of imposed strains in some cells, with the present elastic constants of the bodies. Local.
  subroutine create(self, mesh, body, strains, cells)
    class(imposed_energy_t), intent(out) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(imposed_strains_t), intent(in) :: strains
    !> 1-based
    integer, intent(in) :: cells(:)
    type(strain_field_t) :: fields(strains%terms%n_terms())
    type(strain_part_t) :: part
    real(rk) :: forces(mesh%n_dim * mesh%n_nodes)
    integer :: i

    allocate (self%energies(size(fields), size(fields)), source=0.0_rk)
    if (.not. strains%are_there()) return
    do i = 1, size(strains%parts)
      call strains%parts(i)%restrict(mesh, body, cells, part)
      call strain_forces(mesh, body, part, body%stress_matrix(:, :, part%material), forces)
      call self%forces%add_forces(part%term, forces)
    end do
    do i = 1, size(fields)
      call strains%evaluate(mesh, body, unit_vector(size(fields), i), fields(i))
    end do
    do i = 1, size(cells)
      call add_cell(mesh, body, cells(i), fields, self%energies)
    end do
  end subroutine create

  !> Adds 1/2 int eps_s' C eps_t over one cell to energies(s, t), for all terms s and t of the imposed strains.
  pure subroutine add_cell(mesh, body, i_cell, fields, energies)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: i_cell
    !> imposed strain of each term alone
    type(strain_field_t), intent(in) :: fields(:)
    !> [force*length, force in the plane] grows, shape (n_terms, n_terms)
    real(rk), intent(inout) :: energies(:, :)
    real(rk) :: strains(n_stresses, size(fields)), volume
    real(rk), allocatable :: coordinates(:, :), gradients(:, :)
    integer :: i, i_point

    coordinates = mesh%coordinates(:, nodes_of_cell(mesh, i_cell))
    allocate (gradients, mold=coordinates)
    associate (table => body%tables(body%table_of(i_cell, mesh%cell_types(i_cell))), &
      hooke => body%stress_matrix(:, :, body%material_of_cell(i_cell)))
      do i_point = 1, table%n_points
        do i = 1, size(fields)
          strains(:, i) = fields(i)%at_point(i_cell, i_point)
        end do
        call physical_gradients(table, i_point, coordinates, gradients, volume)
        volume = volume * circumference(body%mechanics, matmul(coordinates, table%values(:, i_point)))
        energies = energies + volume / 2 * matmul(transpose(strains), matmul(hooke, strains))
      end do
    end associate
  end subroutine add_cell

  !> Returns what the imposed strains add to the strain energy 1/2 u' K u of the cells: -F*' u + 1/2 int eps*' C eps* [force*length,
  !> force in the plane]; 0 if there are none.
  pure real(rk) function value(self, displacement, theta)
    class(imposed_energy_t), intent(in) :: self
    !> [length] shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    !> [-] values of the terms of the imposed strains, shape (n_terms)
    real(rk), intent(in) :: theta(:)

    value = dot_product(theta, matmul(self%energies, theta)) - &
      dot_product(self%forces%forces(theta, size(displacement)), displacement)
  end function value
end module sig_imposed_energy
