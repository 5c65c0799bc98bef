! SPDX-License-Identifier: BSD-3-Clause
!> Checks the shapes of cells: corrects the node order of inverted cells, and refuses flat and folded ones.
module sig_cell_quality
  use sig_element_types, only: element_types, mirrored_order, n_element_types
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_mesh, only: group_t, mesh_t, nodes_of_cell
  use sig_quadrature, only: quadrature_rule
  use sig_shape_functions, only: create_shape_table, shape_table_t
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: orient_cells

  !> [-] a corner whose quality has a smaller size is flat; at an integration point a smaller quality means folded
  real(rk), parameter :: min_quality = 1.0e-10_rk

contains

  !> Gives every cell a positive volume: the nodes of an inverted cell, whose corner qualities are all negative, get another order.
  !>
  !> Errors: the first cell that is flat (a corner's quality has a size below 1e-10), folded (some corners have a negative quality,
  !> others a positive one), or folded by its mid-side nodes (a quadratic cell whose quality at an integration point is below
  !> 1e-10). A quality that is not a number counts as too small. After an error the later cells are not corrected.
  !>
  !> The quality of a corner is the determinant of the unit vectors along its edges, that of an integration point the determinant of
  !> the unit vectors along the reference axes; at right angles it is 1. The message has the cell's region, its number in gmsh and a
  !> quality: for a flat cell the smallest one in size, without its sign; otherwise the lowest one.
  pure subroutine orient_cells(mesh, path, error)
    type(mesh_t), intent(inout) :: mesh
    !> mesh file, for messages
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(shape_table_t) :: tables(n_element_types)
    integer :: i_cell

    call tabulate_curved(mesh, tables)
    do i_cell = 1, mesh%n_cells
      associate (qualities => corner_qualities(mesh, i_cell))
        ! written with .not., so that a NaN from huge coordinates is refused, too
        if (.not. all(abs(qualities) >= min_quality)) then
          call refuse_cell(mesh, i_cell, 'is flat', minval(abs(qualities)), path, error)
        else if (all(qualities < 0)) then
          call mirror_cell(mesh, i_cell)
        else if (any(qualities < 0)) then
          call refuse_cell(mesh, i_cell, 'is folded', minval(qualities), path, error)
        end if
      end associate
      if (allocated(error)) return
      if (element_types(mesh%cell_types(i_cell))%order == 1) cycle
      associate (quality => point_quality(mesh, i_cell, tables(mesh%cell_types(i_cell))))
        if (.not. quality >= min_quality) call refuse_cell(mesh, i_cell, 'is folded by its mid-side nodes', quality, path, error)
      end associate
      if (allocated(error)) return
    end do
  end subroutine orient_cells

  !> Tabulates the shape functions of the quadratic elements that the mesh has, at the points of quadrature_rule. The tables of
  !> other elements stay as they are.
  pure subroutine tabulate_curved(mesh, tables)
    type(mesh_t), intent(in) :: mesh
    !> one for each row of element_types
    type(shape_table_t), intent(inout) :: tables(n_element_types)
    real(rk), allocatable :: points(:, :), weights(:)
    integer :: i_type

    do i_type = 1, n_element_types
      if (element_types(i_type)%order == 1 .or. .not. any(mesh%cell_types == i_type)) cycle
      call quadrature_rule(i_type, points, weights)
      call create_shape_table(i_type, points, weights, tables(i_type))
    end do
  end subroutine tabulate_curved

  !> Returns the quality [-] of a quadratic cell: the smallest determinant of the unit vectors along its reference axes at the
  !> integration points, at most 1. It is negative if the cell is inverted at one of them.
  pure real(rk) function point_quality(mesh, i_cell, table) result(quality)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_cell
    !> of tabulate_curved, for the type of the cell
    type(shape_table_t), intent(in) :: table
    real(rk) :: directions(mesh%n_dim, mesh%n_dim)
    integer :: i_point, j

    quality = 1
    do i_point = 1, table%n_points
      directions = matmul(mesh%coordinates(:, nodes_of_cell(mesh, i_cell)), transpose(table%gradients(:, :, i_point)))
      do j = 1, mesh%n_dim
        directions(:, j) = direction(directions(:, j))
      end do
      if (.not. determinant(directions) >= quality) quality = determinant(directions)
    end do
  end function point_quality

  !> Returns the determinant of the unit vectors along the edges at each corner: 1 = right angles, 0 = flat, negative = inverted.
  !> Edges are straight here: mid-side nodes do not count.
  pure function corner_qualities(mesh, i_cell) result(qualities)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_cell
    !> [-] shape (number of corners of the cell)
    real(rk), allocatable :: qualities(:)
    real(rk) :: directions(mesh%n_dim, mesh%n_dim)
    integer, allocatable :: nodes(:)
    integer :: i, j, neighbor

    nodes = nodes_of_cell(mesh, i_cell)
    allocate (qualities(element_types(mesh%cell_types(i_cell))%n_corners))
    do i = 1, size(qualities)
      do j = 1, mesh%n_dim
        neighbor = nodes(element_types(mesh%cell_types(i_cell))%corner_neighbors(j, i))
        directions(:, j) = direction(mesh%coordinates(:, neighbor) - mesh%coordinates(:, nodes(i)))
      end do
      qualities(i) = determinant(directions)
    end do
  end function corner_qualities

  !> Returns a vector divided by its length; zero for a zero vector.
  pure function direction(vector) result(unit)
    real(rk), intent(in) :: vector(:)
    real(rk) :: unit(size(vector))

    unit = vector / max(norm2(vector), tiny(1.0_rk))
  end function direction

  !> Returns the determinant of a matrix of order 2 or 3.
  pure real(rk) function determinant(matrix)
    real(rk), intent(in) :: matrix(:, :)

    if (size(matrix, 1) == 2) then
      determinant = matrix(1, 1) * matrix(2, 2) - matrix(1, 2) * matrix(2, 1)
    else
      determinant = matrix(1, 1) * (matrix(2, 2) * matrix(3, 3) - matrix(2, 3) * matrix(3, 2)) &
        - matrix(1, 2) * (matrix(2, 1) * matrix(3, 3) - matrix(2, 3) * matrix(3, 1)) &
        + matrix(1, 3) * (matrix(2, 1) * matrix(3, 2) - matrix(2, 2) * matrix(3, 1))
    end if
  end function determinant

  pure subroutine mirror_cell(mesh, i_cell)
    type(mesh_t), intent(inout) :: mesh
    integer, intent(in) :: i_cell
    integer, allocatable :: nodes(:)

    nodes = nodes_of_cell(mesh, i_cell)
    mesh%cell_nodes(mesh%cell_offsets(i_cell) + 1:mesh%cell_offsets(i_cell + 1)) = &
      nodes(mirrored_order(mesh%cell_types(i_cell)))
  end subroutine mirror_cell

  pure subroutine refuse_cell(mesh, i_cell, fault, quality, path, error)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_cell
    character(*), intent(in) :: fault
    real(rk), intent(in) :: quality
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    character(12) :: shown

    write (shown, '(es9.2)') quality
    call make_error(error, 'cell ' // to_text(mesh%cell_tags(i_cell)) // ' (number in gmsh) of region ' // &
                    region_of_cell(mesh, i_cell) // ' ' // fault // ': its quality is ' // trim(adjustl(shown)) // &
                    ', at least 1.0e-10 is needed', file=path, hint='correct the geometry or the mesh size there')
  end subroutine refuse_cell

  !> Returns the name in quotes of the first region that has the cell; `?` if none has it.
  pure function region_of_cell(mesh, i_cell) result(name)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_cell
    character(:), allocatable :: name
    integer :: i_group

    name = '?'
    do i_group = 1, size(mesh%groups)
      if (mesh%groups(i_group)%n_dim /= mesh%n_dim) cycle
      if (.not. any(mesh%groups(i_group)%entities == i_cell)) cycle
      name = "'" // mesh%groups(i_group)%name // "'"
      return
    end do
  end function region_of_cell
end module sig_cell_quality
