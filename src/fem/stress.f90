! SPDX-License-Identifier: BSD-3-Clause
!> Stress of each cell (the mean over it), smoothed at the nodes, and von Mises' equivalent: C (eps(u) - eps*), without the imposed
!> strains eps*.
!>
!> Of a quadratic cell the nodes get what is linear in it, too (shape_functions.f90).
module sig_stress
  use sig_cell_stiffness, only: cell_dofs
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: n_stresses
  use sig_element_matrices, only: strains_at_point
  use sig_element_types, only: element_types
  use sig_imposed_strain, only: strain_field_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t, nodes_of_cell
  use sig_ties, only: first_largest
  implicit none(type, external)
  private
  public :: cell_stresses, nodal_stresses, von_mises, n_stresses

contains

  !> Local: every rank computes every cell.
  pure function cell_stresses(mesh, body, displacement, imposed) result(stresses)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> [length] shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    type(strain_field_t), intent(in) :: imposed
    !> [force/length**2] shape (n_stresses, n_cells)
    real(rk) :: stresses(n_stresses, mesh%n_cells)
    real(rk) :: strain(n_stresses), volume
    integer :: i_cell

    do i_cell = 1, mesh%n_cells
      call measure_cell(mesh, body, i_cell, displacement, imposed, strain, volume)
      stresses(:, i_cell) = matmul(body%stress_matrix(:, :, body%material_of_cell(i_cell)), strain)
    end do
  end function cell_stresses

  !> Stress at each node: the mean of what the cells around it have there, weighted by their volumes.
  !>
  !> Where materials share a node, stresses jump: there only the material with most volume around the node counts (of equal
  !> ones the first of the deck), so that one material's stress does not smear into the other's. Local.
  pure function nodal_stresses(mesh, body, displacement, imposed) result(smoothed)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> [length] shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    type(strain_field_t), intent(in) :: imposed
    !> [force/length**2] shape (n_stresses, n_nodes)
    real(rk) :: smoothed(n_stresses, mesh%n_nodes)
    real(rk) :: volumes(size(body%hooke, 3), mesh%n_nodes), volume(mesh%n_cells), strain(n_stresses)
    integer :: i_cell, i_node, material(mesh%n_nodes), n
    integer, allocatable :: nodes(:)
    real(rk), allocatable :: own(:, :)

    volumes = 0
    do i_cell = 1, mesh%n_cells
      call measure_cell(mesh, body, i_cell, displacement, imposed, strain, volume(i_cell))
      nodes = nodes_of_cell(mesh, i_cell)
      associate (i => body%material_of_cell(i_cell))
        volumes(i, nodes) = volumes(i, nodes) + volume(i_cell)
      end associate
    end do
    material = [(first_largest(volumes(:, i_node)), i_node=1, mesh%n_nodes)]
    smoothed = 0
    do i_cell = 1, mesh%n_cells
      nodes = nodes_of_cell(mesh, i_cell)
      own = stresses_at_nodes(mesh, body, i_cell, displacement, imposed)
      do n = 1, size(nodes)
        i_node = nodes(n)
        if (body%material_of_cell(i_cell) /= material(i_node)) cycle
        smoothed(:, i_node) = smoothed(:, i_node) + own(:, n) * (volume(i_cell) / volumes(material(i_node), i_node))
      end do
    end do
  end function nodal_stresses

  !> sqrt(((xx - yy)**2 + (yy - zz)**2 + (zz - xx)**2) / 2 + 3 (xy**2 + yz**2 + xz**2)) of each column.
  pure function von_mises(stresses) result(equivalent)
    !> [force/length**2] shape (n_stresses, n)
    real(rk), intent(in) :: stresses(:, :)
    !> [force/length**2] shape (n)
    real(rk) :: equivalent(size(stresses, 2))

    equivalent = sqrt(((stresses(1, :) - stresses(2, :))**2 + (stresses(2, :) - stresses(3, :))**2 + &
      (stresses(3, :) - stresses(1, :))**2) / 2 + 3 * sum(stresses(4:6, :)**2, dim=1))
  end function von_mises

  !> Stresses of one cell at its nodes: the mean of a linear one, else carried over from the integration points.
  pure function stresses_at_nodes(mesh, body, i_cell, displacement, imposed) result(stresses)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    integer, intent(in) :: i_cell
    real(rk), intent(in) :: displacement(:)
    type(strain_field_t), intent(in) :: imposed
    !> [force/length**2] shape (n_stresses, nodes of the cell)
    real(rk), allocatable :: stresses(:, :)
    real(rk) :: strain(n_stresses), volume
    real(rk), allocatable :: strains(:, :), volumes(:)

    associate (i_type => mesh%cell_types(i_cell), to_stress => body%stress_matrix(:, :, body%material_of_cell(i_cell)))
      if (element_types(i_type)%order == 1) then
        call measure_cell(mesh, body, i_cell, displacement, imposed, strain, volume)
        stresses = spread(matmul(to_stress, strain), 2, element_types(i_type)%n_nodes)
        return
      end if
      call find_elastic_strains(mesh, body, i_cell, displacement, imposed, strains, volumes)
      stresses = matmul(to_stress, matmul(strains, transpose(body%tables(i_type)%to_nodes)))
    end associate
  end function stresses_at_nodes

  !> Mean elastic strain of a cell and its volume.
  pure subroutine measure_cell(mesh, body, i_cell, displacement, imposed, strain, total)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    integer, intent(in) :: i_cell
    real(rk), intent(in) :: displacement(:)
    type(strain_field_t), intent(in) :: imposed
    !> [-] shears as angles
    real(rk), intent(out) :: strain(n_stresses)
    !> [length**3, length**2 in the plane]
    real(rk), intent(out) :: total
    real(rk), allocatable :: strains(:, :), volumes(:)

    call find_elastic_strains(mesh, body, i_cell, displacement, imposed, strains, volumes)
    total = sum(volumes)
    strain = matmul(strains, volumes) / total
  end subroutine measure_cell

  !> eps(u) - eps* at the integration points of a cell, and the volumes that these stand for.
  pure subroutine find_elastic_strains(mesh, body, i_cell, displacement, imposed, strains, volumes)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    integer, intent(in) :: i_cell
    real(rk), intent(in) :: displacement(:)
    type(strain_field_t), intent(in) :: imposed
    !> [-] shears as angles, shape (n_stresses, n_points)
    real(rk), allocatable, intent(out) :: strains(:, :)
    !> [length**3, length**2 in the plane] shape (n_points)
    real(rk), allocatable, intent(out) :: volumes(:)
    real(rk), allocatable :: coordinates(:, :), local(:), matrix(:, :)
    integer :: i_point

    coordinates = mesh%coordinates(:, nodes_of_cell(mesh, i_cell))
    local = displacement(cell_dofs(mesh, i_cell))
    associate (table => body%tables(mesh%cell_types(i_cell)), own => body%mechanics%strains(:body%mechanics%n_strains))
      allocate (matrix(size(own), size(local)), strains(n_stresses, table%n_points), volumes(table%n_points))
      do i_point = 1, table%n_points
        call strains_at_point(body%mechanics, table, i_point, coordinates, matrix, volumes(i_point))
        strains(:, i_point) = -imposed%at_point(i_cell, i_point)
        strains(own, i_point) = strains(own, i_point) + matmul(matrix, local)
      end do
    end associate
  end subroutine find_elastic_strains
end module sig_stress
