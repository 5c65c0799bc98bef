! SPDX-License-Identifier: BSD-3-Clause
!> Stress of each cell: the mean over its integration points.
module sig_stress
  use sig_cell_stiffness, only: cell_dofs
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: n_stresses
  use sig_element_matrices, only: strains_at_point
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t, nodes_of_cell
  implicit none(type, external)
  private
  public :: cell_stresses, n_stresses

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
      stresses(:, i_cell) = matmul(body%stress_matrix(:, :, body%material_of_cell(i_cell)), &
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
    real(rk), allocatable :: coordinates(:, :), local(:)
    real(rk), allocatable :: matrix(:, :)
    real(rk) :: volume, total
    integer :: i_point

    coordinates = mesh%coordinates(:, nodes_of_cell(mesh, i_cell))
    local = displacement(cell_dofs(mesh, i_cell))
    allocate (matrix(size(strain), size(local)))
    strain = 0
    total = 0
    associate (table => body%tables(mesh%cell_types(i_cell)))
      do i_point = 1, table%n_points
        call strains_at_point(body%mechanics, table, i_point, coordinates, matrix, volume)
        strain = strain + volume * matmul(matrix, local)
        total = total + volume
      end do
    end associate
    strain = strain / total
  end function mean_strain
end module sig_stress
