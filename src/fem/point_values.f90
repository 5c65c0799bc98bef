! SPDX-License-Identifier: BSD-3-Clause
!> Computes values at the integration points of cells, from an expression of the coordinates or from nodal values. The points stand
!> in the order of the cells.
module sig_point_values
  use sig_deck_config, only: value_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_expression, only: expression_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t, nodes_of_cell
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: evaluate_at_points, interpolate_at_points, count_points

contains

  !> Returns the number of all integration points of some cells.
  pure integer function count_points(mesh, body, cells) result(n)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: cells(:)
    integer :: i

    n = 0
    do i = 1, size(cells)
      n = n + body%tables(body%table_of(cells(i), mesh%cell_types(cells(i))))%n_points
    end do
  end function count_points

  !> Evaluates an expression of the coordinates at the integration points of cells. Requires: value%text is a valid expression.
  subroutine evaluate_at_points(mesh, body, cells, value, coordinate_names, values, bad_cell)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: cells(:)
    !> only its text is read
    type(value_config_t), intent(in) :: value
    !> names of the coordinates in the expression, shape (n_dim)
    type(string_t), intent(in) :: coordinate_names(:)
    !> cell by cell, shape (count_points of the cells)
    real(rk), allocatable, intent(out) :: values(:)
    !> the first of these cells in which a value is not finite; 0 = none
    integer, intent(out) :: bad_cell
    type(expression_t) :: expression
    character(:), allocatable :: message
    integer :: i, i_point, n
    logical :: is_valid

    allocate (values(count_points(mesh, body, cells)))
    bad_cell = 0
    n = 0
    call expression%create(value%text, coordinate_names, message)
    do i = 1, size(cells)
      associate (table => body%tables(body%table_of(cells(i), mesh%cell_types(cells(i)))), nodes => nodes_of_cell(mesh, cells(i)))
        do i_point = 1, table%n_points
          n = n + 1
          call expression%evaluate(matmul(mesh%coordinates(:, nodes), table%values(:, i_point)), values(n), is_valid)
          if (bad_cell == 0 .and. .not. is_valid) bad_cell = cells(i)
        end do
      end associate
    end do
    call expression%destroy()
  end subroutine evaluate_at_points

  !> Interpolates nodal values at the integration points with the shape functions of the cells.
  pure subroutine interpolate_at_points(mesh, body, cells, nodal, values)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: cells(:)
    !> values at all nodes of the mesh, shape (n_nodes)
    real(rk), intent(in) :: nodal(:)
    !> cell by cell, shape (count_points of the cells)
    real(rk), allocatable, intent(out) :: values(:)
    integer :: i, n

    allocate (values(count_points(mesh, body, cells)))
    n = 0
    do i = 1, size(cells)
      associate (table => body%tables(body%table_of(cells(i), mesh%cell_types(cells(i)))), nodes => nodes_of_cell(mesh, cells(i)))
        values(n + 1:n + table%n_points) = matmul(nodal(nodes), table%values)
        n = n + table%n_points
      end associate
    end do
  end subroutine interpolate_at_points
end module sig_point_values
