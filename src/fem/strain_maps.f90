! SPDX-License-Identifier: BSD-3-Clause
!> Makes the maps that give strains as linear functions of the displacement: the mean strain of each cell, and smoothed strains at
!> the nodes.
!>
!> The strain at a node is the mean of the values that the cells around it give to the node, weighted by the cells' volumes. A
!> linear cell gives its mean to all its nodes, a quadratic cell a linear function of the place (shape_functions.f90). Stresses jump
!> at a node that several materials share. Only the material with the largest volume around the node counts there (of equal ones the
!> first of the deck), so that the stress of one material does not change that of another.
module sig_strain_maps
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: n_stresses
  use sig_element_matrices, only: physical_gradients
  use sig_element_types, only: element_types
  use sig_imposed_strain, only: imposed_strains_t, strain_part_t
  use sig_kinds, only: rk
  use sig_mechanical_models, only: circumference
  use sig_mesh, only: cells_around_nodes, mesh_t, nodes_of_cell
  use sig_strain_map, only: strain_map_t
  use sig_ties, only: first_largest
  implicit none(type, external)
  private
  public :: create_strain_maps

  !> Gradients of the shape functions of one cell at its integration points.
  type :: cell_gradients_t
    !> [1/length] shape (3, n_nodes, n_points); in axisymmetry the third one is N / r
    real(rk), allocatable :: values(:, :, :)
    !> [length**3, length**2 in the plane] volume of each integration point, shape (n_points)
    real(rk), allocatable :: volumes(:)
  end type cell_gradients_t

contains

  !> Creates the maps from nodal displacements to the mean strain of each cell, and to the smoothed strain at each node. They also
  !> get the imposed strains: their mean in each cell, and their smoothed value at each node. Local: every rank computes every cell.
  pure subroutine create_strain_maps(mesh, body, imposed, of_cells, of_nodes)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> may be empty
    type(imposed_strains_t), intent(in) :: imposed
    type(strain_map_t), intent(out) :: of_cells
    type(strain_map_t), intent(out) :: of_nodes
    real(rk) :: volumes(mesh%n_cells)

    call map_cells(mesh, body, of_cells, volumes)
    call choose_materials(mesh, body, volumes, of_nodes%materials)
    call list_neighbors(mesh, body, of_nodes)
    call map_nodes(mesh, body, volumes, of_nodes)
    call impose(mesh, body, imposed, volumes, of_cells, of_nodes)
    call map_points(mesh, body, of_cells, of_nodes)
  end subroutine create_strain_maps

  !> Creates the map to the mean strains of the cells, without imposed strains, and computes the volumes of the cells.
  pure subroutine map_cells(mesh, body, map, volumes)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(strain_map_t), intent(inout) :: map
    !> [length**3, length**2 in the plane] of the cells
    real(rk), intent(out) :: volumes(:)
    type(cell_gradients_t) :: gradients
    integer :: i

    map%starts = mesh%cell_offsets
    map%nodes = mesh%cell_nodes
    map%materials = body%material_of_cell
    allocate (map%gradients(3, size(map%nodes)))
    do i = 1, mesh%n_cells
      call find_gradients(mesh, body, i, gradients)
      volumes(i) = sum(gradients%volumes)
      map%gradients(:, map%starts(i) + 1:map%starts(i + 1)) = weighted(gradients, gradients%volumes / volumes(i))
    end do
  end subroutine map_cells

  !> Computes the gradients of the shape functions at the integration points of a cell, and the volumes of these points. In the
  !> plane the third gradient is 0.
  pure subroutine find_gradients(mesh, body, i_cell, gradients)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: i_cell
    type(cell_gradients_t), intent(out) :: gradients
    real(rk) :: place(mesh%n_dim)
    real(rk), allocatable :: coordinates(:, :)
    integer :: i

    coordinates = mesh%coordinates(:, nodes_of_cell(mesh, i_cell))
    associate (table => body%tables(body%table_of(i_cell, mesh%cell_types(i_cell))))
      allocate (gradients%values(3, size(coordinates, 2), table%n_points), source=0.0_rk)
      allocate (gradients%volumes(table%n_points))
      do i = 1, table%n_points
        call physical_gradients(table, i, coordinates, gradients%values(:mesh%n_dim, :, i), gradients%volumes(i))
        place = matmul(coordinates, table%values(:, i))
        gradients%volumes(i) = gradients%volumes(i) * circumference(body%mechanics, place)
        if (body%mechanics%is_round) gradients%values(3, :, i) = table%values(:, i) / place(1)
      end do
    end associate
  end subroutine find_gradients

  !> Returns the sum of weight times gradient over the integration points. It is not divided by the sum of the weights.
  pure function weighted(gradients, weights) result(total)
    type(cell_gradients_t), intent(in) :: gradients
    !> [-] weight of each integration point
    real(rk), intent(in) :: weights(:)
    !> [1/length] shape (3, n_nodes)
    real(rk) :: total(3, size(gradients%values, 2))
    integer :: i

    total = 0
    do i = 1, size(weights)
      total = total + weights(i) * gradients%values(:, :, i)
    end do
  end function weighted

  !> Chooses for each node the material with the largest volume around it, of equal ones (up to 1e-8 relative) the first of the
  !> deck; 0 for a node without cells.
  pure subroutine choose_materials(mesh, body, volumes, materials)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> of the cells, shape (n_cells)
    real(rk), intent(in) :: volumes(:)
    !> 1-based, shape (n_nodes)
    integer, allocatable, intent(out) :: materials(:)
    real(rk) :: around(size(body%hooke, 3), mesh%n_nodes)
    integer, allocatable :: nodes(:)
    integer :: i

    around = 0
    do i = 1, mesh%n_cells
      nodes = nodes_of_cell(mesh, i)
      associate (material => body%material_of_cell(i))
        around(material, nodes) = around(material, nodes) + volumes(i)
      end associate
    end do
    materials = [(merge(first_largest(around(:, i)), 0, any(around(:, i) > 0)), i=1, mesh%n_nodes)]
  end subroutine choose_materials

  !> Fills map%starts and map%nodes: the row of a node lists each node of those cells around it that have the node's material, once
  !> and itself included. The row of a node without cells is empty. Requires: map%materials.
  pure subroutine list_neighbors(mesh, body, map)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(strain_map_t), intent(inout) :: map
    integer, allocatable :: cells(:), offsets(:), longer(:)
    integer :: i, k, last, n, seen_by(mesh%n_nodes)

    call cells_around_nodes(mesh, offsets, cells)
    allocate (map%starts(mesh%n_nodes + 1), source=0)
    allocate (map%nodes(32 * mesh%n_nodes))
    seen_by = 0
    last = 0
    do i = 1, mesh%n_nodes
      do k = offsets(i) + 1, offsets(i + 1)
        if (body%material_of_cell(cells(k)) /= map%materials(i)) cycle
        associate (nodes => nodes_of_cell(mesh, cells(k)))
          if (last + size(nodes) > size(map%nodes)) then
            allocate (longer(2 * size(map%nodes) + size(nodes)))
            longer(:last) = map%nodes(:last)
            call move_alloc(longer, map%nodes)
          end if
          do n = 1, size(nodes)
            if (seen_by(nodes(n)) == i) cycle
            seen_by(nodes(n)) = i
            last = last + 1
            map%nodes(last) = nodes(n)
          end do
        end associate
      end do
      map%starts(i + 1) = last
    end do
    map%nodes = map%nodes(:last)
  end subroutine list_neighbors

  !> Fills map%gradients of the map to the nodal strains: means, weighted by volume, over the cells around each node that have its
  !> material. Each cell gives the node a value by node_weights. Requires: list_neighbors.
  pure subroutine map_nodes(mesh, body, volumes, map)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> of the cells, shape (n_cells)
    real(rk), intent(in) :: volumes(:)
    type(strain_map_t), intent(inout) :: map
    type(cell_gradients_t) :: gradients
    real(rk) :: totals(mesh%n_nodes)
    integer, allocatable :: nodes(:)
    real(rk), allocatable :: weights(:, :)
    integer :: i, n

    totals = volumes_around(mesh, body, volumes, map%materials)
    allocate (map%gradients(3, size(map%nodes)), source=0.0_rk)
    do i = 1, mesh%n_cells
      call find_gradients(mesh, body, i, gradients)
      nodes = nodes_of_cell(mesh, i)
      weights = node_weights(mesh, body, i, gradients%volumes)
      do n = 1, size(nodes)
        if (body%material_of_cell(i) /= map%materials(nodes(n))) cycle
        call add_to_row(map, nodes(n), nodes, weighted(gradients, weights(n, :) * (volumes(i) / totals(nodes(n)))))
      end do
    end do
  end subroutine map_nodes

  !> Returns for each node the volume of the cells around it that have the node's material.
  pure function volumes_around(mesh, body, volumes, materials) result(totals)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> of the cells, shape (n_cells)
    real(rk), intent(in) :: volumes(:)
    !> material that counts at each node, shape (n_nodes)
    integer, intent(in) :: materials(:)
    real(rk) :: totals(mesh%n_nodes)
    integer, allocatable :: nodes(:)
    integer :: i

    totals = 0
    do i = 1, mesh%n_cells
      nodes = pack(nodes_of_cell(mesh, i), materials(nodes_of_cell(mesh, i)) == body%material_of_cell(i))
      totals(nodes) = totals(nodes) + volumes(i)
    end do
  end function volumes_around

  !> Returns the factors [-] that give values at the nodes of a cell from values at its integration points, shape (n_nodes,
  !> n_points): the mean over the cell for linear elements, to_nodes of shape_table_t for quadratic ones.
  pure function node_weights(mesh, body, i_cell, volumes) result(weights)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: i_cell
    !> volumes of the integration points
    real(rk), intent(in) :: volumes(:)
    real(rk), allocatable :: weights(:, :)

    associate (i_type => mesh%cell_types(i_cell))
      if (element_types(i_type)%order == 1) then
        weights = spread(volumes / sum(volumes), 1, element_types(i_type)%n_nodes)
      else
        weights = body%tables(body%table_of(i_cell, i_type))%to_nodes
      end if
    end associate
  end function node_weights

  !> Adds gradients that belong to the nodes of one cell to the entries of these nodes in a row of the map.
  pure subroutine add_to_row(map, row, nodes, gradients)
    type(strain_map_t), intent(inout) :: map
    !> number of the row, 1-based
    integer, intent(in) :: row
    !> natural nodes of the cell
    integer, intent(in) :: nodes(:)
    !> shape (3, size(nodes))
    real(rk), intent(in) :: gradients(:, :)
    integer :: i, n

    do n = 1, size(nodes)
      do i = map%starts(row) + 1, map%starts(row + 1)
        if (map%nodes(i) /= nodes(n)) cycle
        map%gradients(:, i) = map%gradients(:, i) + gradients(:, n)
        exit
      end do
    end do
  end subroutine add_to_row

  !> Adds the imposed strains to both maps: the means over the cells, and nodal values by the same rule as for other strains.
  pure subroutine impose(mesh, body, imposed, volumes, of_cells, of_nodes)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(imposed_strains_t), intent(in) :: imposed
    !> of the cells, shape (n_cells)
    real(rk), intent(in) :: volumes(:)
    type(strain_map_t), intent(inout) :: of_cells, of_nodes
    real(rk) :: at_cells(mesh%n_cells), at_nodes(mesh%n_nodes), totals(mesh%n_nodes)
    integer :: i

    call start_imposed(of_cells)
    call start_imposed(of_nodes)
    if (.not. imposed%are_there()) return
    totals = volumes_around(mesh, body, volumes, of_nodes%materials)
    do i = 1, size(imposed%parts)
      call spread_part(mesh, body, imposed%parts(i), volumes, of_nodes%materials, at_cells, at_nodes)
      where (totals > 0) at_nodes = at_nodes / totals
      call add_imposed(imposed%parts(i), at_cells, of_cells)
      call add_imposed(imposed%parts(i), at_nodes, of_nodes)
    end do
  end subroutine impose

  pure subroutine start_imposed(map)
    type(strain_map_t), intent(inout) :: map

    allocate (map%imposed(n_stresses, 0), map%imposed_rows(0), map%imposed_terms(0))
  end subroutine start_imposed

  !> Spreads the values of one part of the imposed strains, given at integration points. at_cells gets the mean over each cell of
  !> the part. at_nodes gets the sum over the part's cells of the node's material: value at the node times volume of the cell. Both
  !> are 0 elsewhere. Value times theta is [-].
  pure subroutine spread_part(mesh, body, part, volumes, materials, at_cells, at_nodes)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(strain_part_t), intent(in) :: part
    !> [length**3, length**2 in the plane] of all cells, shape (n_cells)
    real(rk), intent(in) :: volumes(:)
    !> material that counts at each node, shape (n_nodes)
    integer, intent(in) :: materials(:)
    !> value, shape (n_cells)
    real(rk), intent(out) :: at_cells(:)
    !> value times [length**3, length**2 in the plane], shape (n_nodes)
    real(rk), intent(out) :: at_nodes(:)
    type(cell_gradients_t) :: gradients
    integer, allocatable :: nodes(:)
    real(rk), allocatable :: own(:)
    integer :: i, n, n_points

    at_cells = 0
    at_nodes = 0
    n = 0
    do i = 1, size(part%cells)
      associate (i_cell => part%cells(i))
        call find_gradients(mesh, body, i_cell, gradients)
        n_points = size(gradients%volumes)
        nodes = nodes_of_cell(mesh, i_cell)
        associate (values => part%values(n + 1:n + n_points))
          at_cells(i_cell) = dot_product(gradients%volumes, values) / volumes(i_cell)
          own = volumes(i_cell) * matmul(node_weights(mesh, body, i_cell, gradients%volumes), values)
        end associate
        where (materials(nodes) /= body%material_of_cell(i_cell)) own = 0
        at_nodes(nodes) = at_nodes(nodes) + own
        n = n + n_points
      end associate
    end do
  end subroutine spread_part

  !> Lists how values at the integration points of all flowing cells of the mesh, cell by cell, are spread: to the cells as means,
  !> and to the nodes by the same rule as strains.
  pure subroutine map_points(mesh, body, of_cells, of_nodes)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(strain_map_t), intent(inout) :: of_cells
    !> with its materials
    type(strain_map_t), intent(inout) :: of_nodes
    type(cell_gradients_t) :: gradients
    integer, allocatable :: nodes(:)
    real(rk), allocatable :: weights(:, :)
    real(rk) :: totals(mesh%n_nodes), volume
    integer :: i, i_cell, k, n, n_points, next(mesh%n_nodes)

    call count_points_of_rows(mesh, body, of_cells, of_nodes)
    next = of_nodes%point_starts(:mesh%n_nodes)
    totals = 0
    n = 0
    do i_cell = 1, mesh%n_cells
      if (.not. body%flows_in(i_cell)) cycle
      call find_gradients(mesh, body, i_cell, gradients)
      n_points = size(gradients%volumes)
      volume = sum(gradients%volumes)
      associate (first => of_cells%point_starts(i_cell) + 1, last => of_cells%point_starts(i_cell + 1))
        of_cells%points(first:last) = [(i, i=n + 1, n + n_points)]
        of_cells%point_weights(first:last) = gradients%volumes / volume
      end associate
      nodes = nodes_of_cell(mesh, i_cell)
      weights = node_weights(mesh, body, i_cell, gradients%volumes)
      do k = 1, size(nodes)
        if (of_nodes%materials(nodes(k)) /= body%material_of_cell(i_cell)) cycle
        associate (start => next(nodes(k)))
          of_nodes%points(start + 1:start + n_points) = [(i, i=n + 1, n + n_points)]
          of_nodes%point_weights(start + 1:start + n_points) = volume * weights(k, :)
          start = start + n_points
        end associate
        totals(nodes(k)) = totals(nodes(k)) + volume
      end do
      n = n + n_points
    end do
    do k = 1, mesh%n_nodes
      associate (own => of_nodes%point_weights(of_nodes%point_starts(k) + 1:of_nodes%point_starts(k + 1)))
        if (size(own) > 0) own = own / totals(k)
      end associate
    end do
  end subroutine map_points

  !> Makes room for map_points.
  pure subroutine count_points_of_rows(mesh, body, of_cells, of_nodes)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(strain_map_t), intent(inout) :: of_cells
    type(strain_map_t), intent(inout) :: of_nodes
    integer, allocatable :: nodes(:)
    integer :: i_cell, k, n_points, per_cell(mesh%n_cells), per_node(mesh%n_nodes)

    per_cell = 0
    per_node = 0
    do i_cell = 1, mesh%n_cells
      if (.not. body%flows_in(i_cell)) cycle
      n_points = body%tables(body%table_of(i_cell, mesh%cell_types(i_cell)))%n_points
      per_cell(i_cell) = n_points
      nodes = nodes_of_cell(mesh, i_cell)
      do k = 1, size(nodes)
        if (of_nodes%materials(nodes(k)) == body%material_of_cell(i_cell)) per_node(nodes(k)) = per_node(nodes(k)) + n_points
      end do
    end do
    call make_lists(per_cell, of_cells)
    call make_lists(per_node, of_nodes)

  contains

    pure subroutine make_lists(lengths, map)
      integer, intent(in) :: lengths(:)
      type(strain_map_t), intent(inout) :: map
      integer :: row

      allocate (map%point_starts(size(lengths) + 1), source=0)
      do row = 1, size(lengths)
        map%point_starts(row + 1) = map%point_starts(row) + lengths(row)
      end do
      allocate (map%points(sum(lengths)), map%point_weights(sum(lengths)))
    end subroutine make_lists
  end subroutine count_points_of_rows

  !> Adds one part of the imposed strains to a map, in the rows where its value is not zero.
  pure subroutine add_imposed(part, values, map)
    type(strain_part_t), intent(in) :: part
    !> value of the part in each row of the map; value times theta is [-]
    real(rk), intent(in) :: values(:)
    type(strain_map_t), intent(inout) :: map
    integer, allocatable :: rows(:)
    integer :: i

    rows = pack([(i, i=1, size(values))], abs(values) > 0)
    map%imposed = reshape([map%imposed, [(part%direction * values(rows(i)), i=1, size(rows))]], &
      [n_stresses, size(map%imposed_rows) + size(rows)])
    map%imposed_rows = [map%imposed_rows, rows]
    map%imposed_terms = [map%imposed_terms, spread(part%term, 1, size(rows))]
  end subroutine add_imposed
end module sig_strain_maps
