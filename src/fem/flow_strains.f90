! SPDX-License-Identifier: BSD-3-Clause
!> Strain matrices of cells with all six components, and how cells are integrated whose material flows (plasticity, creep).
!>
!> A material that flows keeps its volume. Full integration asks for that at too many points, and the cell locks. So quadratic
!> cells have fewer points (reduced_rule). Linear cells take their mean dilatation: with B = strain matrix, m = (1, 1, 1, 0, 0, 0)
!> and tr B = m' B,
!>
!>     B-bar = B + m/3 (mean of tr B - tr B),
!>
!> where the mean is over the volume of the cell, and in axisymmetry tr B contains the hoop strain. Source: T. J. R. Hughes, Int. J.
!> for Num. Methods in Engineering 15 (1980) 1413. Linear triangles and tetrahedra have one dilatation in any case, and lock;
!> pyramids and cells with nodes in the middle of faces would have modes without energy, or lock.
module sig_flow_strains
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: n_stresses
  use sig_element_matrices, only: strains_at_point
  use sig_element_types, only: element_types
  use sig_kinds, only: rk
  use sig_linear_algebra, only: add_product
  use sig_mesh, only: mesh_t, nodes_of_cell
  implicit none(type, external)
  private
  public :: can_flow, strain_matrices, tangent_stiffness

contains

  !> Whether cells of a type may have a material that flows.
  pure logical function can_flow(i_type)
    !> row of element_types
    integer, intent(in) :: i_type

    can_flow = any(element_types(i_type)%name == [character(8) :: 'Q4', 'H8', 'W6', 'Q8', 'T6', 'H20', 'T10', 'W15'])
  end function can_flow

  !> Computes the strain matrices of a cell at its integration points, and the volumes of these. Strains are the matrix times the
  !> nodal displacements, node by node, with shears as angles. Cells of a material that flows have B-bar where they are linear.
  pure subroutine strain_matrices(mesh, body, i_cell, strains, volumes)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: i_cell
    !> [1/length] shape (n_stresses, n_dim * n_nodes, n_points)
    real(rk), allocatable, intent(inout) :: strains(:, :, :)
    !> [length**3, length**2 in the plane] shape (n_points)
    real(rk), allocatable, intent(inout) :: volumes(:)
    real(rk), allocatable :: coordinates(:, :), own(:, :)
    integer :: i, i_type

    i_type = mesh%cell_types(i_cell)
    coordinates = mesh%coordinates(:, nodes_of_cell(mesh, i_cell))
    associate (table => body%tables(body%table_of(i_cell, i_type)), model => body%mechanics)
      call make_room(size(coordinates), table%n_points, strains, volumes)
      allocate (own(model%n_strains, size(coordinates)))
      do i = 1, table%n_points
        call strains_at_point(model, table, i, coordinates, own, volumes(i))
        strains(model%strains(:model%n_strains), :, i) = own
      end do
    end associate
    if (element_types(i_type)%order == 1 .and. body%flows_in(i_cell)) call take_mean_dilatation(volumes, strains)
  end subroutine strain_matrices

  !> Allocates what strain_matrices fills; strains become zero.
  pure subroutine make_room(n_dofs, n_points, strains, volumes)
    integer, intent(in) :: n_dofs
    integer, intent(in) :: n_points
    real(rk), allocatable, intent(inout) :: strains(:, :, :)
    real(rk), allocatable, intent(inout) :: volumes(:)

    if (allocated(strains)) then
      if (any(shape(strains) /= [n_stresses, n_dofs, n_points])) deallocate (strains)
    end if
    if (.not. allocated(strains)) allocate (strains(n_stresses, n_dofs, n_points))
    if (allocated(volumes)) then
      if (size(volumes) /= n_points) deallocate (volumes)
    end if
    if (.not. allocated(volumes)) allocate (volumes(n_points))
    strains = 0
  end subroutine make_room

  !> Replaces B by B-bar.
  pure subroutine take_mean_dilatation(volumes, strains)
    real(rk), intent(in) :: volumes(:)
    !> [1/length] shape (n_stresses, n_dofs, n_points)
    real(rk), intent(inout) :: strains(:, :, :)
    real(rk) :: dilatations(size(strains, 2), size(volumes)), mean(size(strains, 2))
    integer :: i, k

    do i = 1, size(volumes)
      dilatations(:, i) = sum(strains(:3, :, i), dim=1)
    end do
    mean = matmul(dilatations, volumes) / sum(volumes)
    do i = 1, size(volumes)
      do k = 1, 3
        strains(k, :, i) = strains(k, :, i) + (mean - dilatations(:, i)) / 3
      end do
    end do
  end subroutine take_mean_dilatation

  !> Returns the integral of B' C B.
  function tangent_stiffness(strains, volumes, tangents) result(stiffness)
    !> results of strain_matrices
    real(rk), intent(in) :: strains(:, :, :)
    real(rk), intent(in) :: volumes(:)
    !> [force/length**2] C at each point, shape (n_stresses, n_stresses, n_points)
    real(rk), intent(in) :: tangents(:, :, :)
    !> [force/length, force/length**2 in the plane] shape (n_dofs, n_dofs)
    real(rk) :: stiffness(size(strains, 2), size(strains, 2))
    real(rk) :: columns(size(strains, 2), n_stresses * size(volumes)), rows(n_stresses * size(volumes), size(strains, 2))
    integer :: first, i

    do i = 1, size(volumes)
      first = (i - 1) * n_stresses + 1
      columns(:, first:first + n_stresses - 1) = transpose(strains(:, :, i))
      rows(first:first + n_stresses - 1, :) = volumes(i) * matmul(tangents(:, :, i), strains(:, :, i))
    end do
    stiffness = 0
    call add_product(1.0_rk, columns, rows, stiffness)
  end function tangent_stiffness
end module sig_flow_strains
