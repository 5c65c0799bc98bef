! SPDX-License-Identifier: BSD-3-Clause
!> Stress of each cell: the mean over its integration points.
module sig_stress
  use sig_cell_stiffness, only: cell_dofs
  use sig_elastic_body, only: elastic_body_t
  use sig_element_matrices, only: physical_gradients, strain_matrix
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t, nodes_of_cell
  implicit none(type, external)
  private
  public :: cell_stresses, n_stresses

  !> xx, yy, zz, xy, yz, xz: the order of symmetric tensors in VTK
  integer, parameter :: n_stresses = 6

contains

  !> Local: every rank computes every cell.
  pure function cell_stresses(mesh, body, displacement) result(stresses)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> [length] shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    !> [force/length**2] shape (n_stresses, n_cells)
    real(rk) :: stresses(n_stresses, mesh%n_cells)
    integer :: i_cell

    do i_cell = 1, mesh%n_cells
      stresses(:, i_cell) = full_stress(body%hooke(:, :, body%material_of_cell(i_cell)), &
        mean_strain(mesh, body, i_cell, displacement))
    end do
  end function cell_stresses

  pure function mean_strain(mesh, body, i_cell, displacement) result(strain)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    integer, intent(in) :: i_cell
    real(rk), intent(in) :: displacement(:)
    !> [-] shape (n_strains)
    real(rk) :: strain(size(body%hooke, 1))
    real(rk), allocatable :: coordinates(:, :), gradients(:, :)
    real(rk) :: volume, total
    integer :: i_point

    coordinates = mesh%coordinates(:, nodes_of_cell(mesh, i_cell))
    allocate (gradients(size(coordinates, 1), size(coordinates, 2)))
    strain = 0
    total = 0
    associate (table => body%tables(mesh%cell_types(i_cell)))
      do i_point = 1, table%n_points
        call physical_gradients(table, i_point, coordinates, gradients, volume)
        strain = strain + volume * matmul(strain_matrix(gradients, size(strain)), displacement(cell_dofs(mesh, i_cell)))
        total = total + volume
      end do
    end associate
    strain = strain / total
  end function mean_strain

  !> Plane strain: sigma_zz = lambda (eps_xx + eps_yy) with lambda = hooke_12.
  pure function full_stress(hooke, strain) result(stress)
    real(rk), intent(in) :: hooke(:, :)
    real(rk), intent(in) :: strain(:)
    real(rk) :: stress(n_stresses)
    real(rk) :: in_plane(size(strain))

    in_plane = matmul(hooke, strain)
    stress = [in_plane(1), in_plane(2), hooke(1, 2) * (strain(1) + strain(2)), in_plane(3), 0.0_rk, 0.0_rk]
  end function full_stress
end module sig_stress
