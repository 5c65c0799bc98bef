! SPDX-License-Identifier: BSD-3-Clause
!> What imposed strains add to the strain energy: 1/2 int (eps - eps*)' C (eps - eps*) = 1/2 u' K u - F*' u + 1/2 int eps*' C eps*.
module sig_imposed_energy
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: n_stresses
  use sig_element_matrices, only: strains_at_point
  use sig_imposed_strain, only: imposed_strains_t, strain_field_t, strain_part_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: unit_vector
  use sig_load_pattern, only: load_pattern_t
  use sig_mesh, only: mesh_t, nodes_of_cell
  use sig_strain_force, only: strain_forces
  implicit none(type, external)
  private
  public :: imposed_energy_t

  !> Of some cells; the terms are those of the imposed strains.
  type :: imposed_energy_t
    private
    !> F*
    type(load_pattern_t) :: forces
    !> [force*length] 1/2 int eps_s' C eps_t, shape (n_terms, n_terms)
    real(rk), allocatable :: energies(:, :)
  contains
    procedure :: create
    procedure :: value
  end type imposed_energy_t

contains

  !> Local. The energies are those of the elastic constants that the body has.
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
    integer :: i, j

    allocate (self%energies(size(fields), size(fields)), source=0.0_rk)
    if (.not. strains%are_there()) return
    do i = 1, size(strains%parts)
      call strains%parts(i)%restrict(mesh, body, cells, part)
      call strain_forces(mesh, body, part, body%stress_matrix(:, :, part%material), forces)
      call self%forces%add_forces(part%term, forces)
    end do
    do i = 1, size(fields)
      call strains%evaluate(mesh, body, unit_vector(size(fields), i), fields(i))
      do j = 1, i
        self%energies(i, j) = mutual_energy(mesh, body, cells, fields(i), fields(j))
        self%energies(j, i) = self%energies(i, j)
      end do
    end do
  end subroutine create

  !> [force*length] 1/2 int eps_1' C eps_2 over the cells.
  pure real(rk) function mutual_energy(mesh, body, cells, first, second) result(energy)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    integer, intent(in) :: cells(:)
    type(strain_field_t), intent(in) :: first
    type(strain_field_t), intent(in) :: second
    real(rk) :: stress(n_stresses), volume
    real(rk), allocatable :: coordinates(:, :), strain(:, :)
    integer :: i, i_point

    energy = 0
    do i = 1, size(cells)
      coordinates = mesh%coordinates(:, nodes_of_cell(mesh, cells(i)))
      if (allocated(strain)) deallocate (strain)
      allocate (strain(body%mechanics%n_strains, size(coordinates)))
      do i_point = 1, body%tables(mesh%cell_types(cells(i)))%n_points
        call strains_at_point(body%mechanics, body%tables(mesh%cell_types(cells(i))), i_point, coordinates, strain, volume)
        stress = matmul(body%stress_matrix(:, :, body%material_of_cell(cells(i))), second%at_point(cells(i), i_point))
        energy = energy + volume * dot_product(first%at_point(cells(i), i_point), stress) / 2
      end do
    end do
  end function mutual_energy

  !> [force*length] - F*' u + 1/2 int eps*' C eps*.
  pure real(rk) function value(self, displacement, theta)
    class(imposed_energy_t), intent(in) :: self
    !> [length] shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    !> [-] of the imposed strains
    real(rk), intent(in) :: theta(:)

    value = dot_product(theta, matmul(self%energies, theta)) - &
      dot_product(self%forces%forces(theta, size(displacement)), displacement)
  end function value
end module sig_imposed_energy
