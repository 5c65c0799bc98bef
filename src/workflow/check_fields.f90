! SPDX-License-Identifier: BSD-3-Clause
!> Shows the problem of a deck before it is solved: supports, loads and contact in check.h5 and check.xdmf.
module sig_check_fields
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_cell_collection, only: cell_collection_t
  use sig_contact_rows, only: contact_rows_t
  use sig_contact_summary, only: contact_name
  use sig_deck_units, only: area_unit, force_unit, stress_unit
  use sig_errors, only: error_t
  use sig_field_file, only: field_file_t
  use sig_imposed_strain, only: cell_strains, strain_field_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_checks, only: group_of_surface
  use sig_mesh_regions, only: region_names, regions_of_cells
  use sig_nodal_values, only: nodal_areas, nodal_gaps
  use sig_parameter_space, only: format_point
  use sig_problem, only: parameter_names, parameter_units, problem_t, strains_at, surface_of_side
  use sig_term_values, only: evaluate_points
  use sig_text, only: append_text, string_t
  implicit none(type, external)
  private
  public :: write_check_fields, boundary_groups

  !> Each cell of the file has six labels. The row of each label, and the values of the first label, which says what the cell is.
  integer, parameter :: n_labels = 6
  integer, parameter :: label_kind = 1, label_material = 2, label_region = 3, label_boundary = 4, label_contact = 5, label_side = 6
  integer, parameter :: kind_body = 1, kind_boundary = 2, kind_surface = 3, kind_link = 4

contains

  !> Writes check.h5 and check.xdmf for one point of the parameters. Local: one rank writes. Errors: a file cannot be written.
  subroutine write_check_fields(problem, point, folder, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters); if a term is not finite at the point, prescribed displacements, loads and gaps are written as 0 and
    !> imposed strains are left out
    real(rk), intent(in) :: point(:)
    !> results folder
    character(*), intent(in) :: folder
    type(error_t), allocatable, intent(out) :: error
    type(cell_collection_t) :: cells
    type(contact_rows_t) :: rows
    type(field_file_t) :: file
    real(rk), allocatable :: shares(:), theta(:, :)
    integer :: i_bad_point, i_bad_source

    rows = problem%rows
    call rows%append(problem%inert)
    call cells%start(problem%mesh%n_dim, n_labels)
    call cells%add_bodies(problem%mesh, body_labels(problem))
    call add_boundaries(problem%mesh, cells)
    call add_surfaces(problem, cells, error)
    if (allocated(error)) return
    call add_links(rows, cells, shares)
    cells%mesh%n_nodes = problem%mesh%n_nodes
    cells%mesh%coordinates = problem%mesh%coordinates
    call file%create(folder // '/check.h5', cells%mesh, problem%deck%units%length, parameter_names(problem%deck), &
      parameter_units(problem%deck), error)
    if (allocated(error)) return
    call write_names(problem, file)
    call evaluate_points(problem%terms, reshape(point, [size(point), 1]), theta, i_bad_point, i_bad_source)
    ! the check of the points has reported it
    if (i_bad_point > 0) theta = 0
    call file%start_point(format_point(problem%deck%state_parameters, point), point)
    call write_cell_fields(cells, shares, file)
    call write_driving_fields(problem, theta(:, 1), file)
    if (problem%strains%are_there() .and. i_bad_point == 0) call write_strains(problem, point, cells%mesh%n_cells, file)
    if (problem%flow%is_there()) call write_flow(problem, point, cells%mesh%n_cells, file)
    call write_contact_fields(problem, rows, theta(:, 1), file)
    call file%close(error)
  end subroutine write_check_fields

  !> Returns the labels of the cells of the bodies: kind_body, material of the deck and region of the mesh (both 1-based; of several
  !> regions the lowest number). The labels boundary, contact and side are 0.
  pure function body_labels(problem) result(labels)
    type(problem_t), intent(in) :: problem
    integer :: labels(n_labels, problem%mesh%n_cells)

    labels = 0
    labels(label_kind, :) = kind_body
    labels(label_material, :) = problem%body%material_of_cell
    labels(label_region, :) = regions_of_cells(problem%mesh)
  end function body_labels

  !> Returns the numbers, 1-based in mesh%groups, of all groups of lower dimension than the mesh: surfaces, edges and points. The
  !> field `boundary` has positions in this list.
  pure function boundary_groups(mesh) result(groups)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable :: groups(:)
    integer :: i

    groups = pack([(i, i=1, size(mesh%groups))], mesh%groups%n_dim < mesh%n_dim)
  end function boundary_groups

  !> Adds the facets of each group of boundary_groups, or a point at each of its nodes if it consists of edges of a solid or of
  !> points.
  pure subroutine add_boundaries(mesh, cells)
    type(mesh_t), intent(in) :: mesh
    type(cell_collection_t), intent(inout) :: cells
    integer, allocatable :: groups(:)
    integer :: i, labels(n_labels), same(mesh%n_nodes)

    same = [(i, i=1, mesh%n_nodes)]
    groups = boundary_groups(mesh)
    labels = 0
    labels(label_kind) = kind_boundary
    do i = 1, size(groups)
      labels(label_boundary) = i
      if (mesh%groups(groups(i))%n_dim == mesh%n_dim - 1) then
        call cells%add_facets(mesh, mesh%groups(groups(i))%entities, same, labels)
      else
        call cells%add_points(mesh%groups(groups(i))%nodes, labels)
      end if
    end do
  end subroutine add_boundaries

  !> Adds the facets of both sides of each contact entry, or of the first side only if the other is an obstacle. Side 1 is the
  !> surface that carries the rows. Errors: none after the rows were built.
  pure subroutine add_surfaces(problem, cells, error)
    type(problem_t), intent(in) :: problem
    type(cell_collection_t), intent(inout) :: cells
    type(error_t), allocatable, intent(out) :: error
    integer :: i_entry, i_group, side, i, labels(n_labels), same(problem%mesh%n_nodes)

    same = [(i, i=1, problem%mesh%n_nodes)]
    labels = 0
    labels(label_kind) = kind_surface
    do i_entry = 1, size(problem%deck%contact)
      do side = 1, merge(1, 2, problem%deck%contact(i_entry)%has_obstacle)
        call group_of_surface(problem%mesh, surface_of_side(problem, i_entry, side), problem%deck%path, i_group, error)
        if (allocated(error)) return
        labels([label_contact, label_side]) = [i_entry, side]
        call cells%add_facets(problem%mesh, problem%mesh%groups(i_group)%entities, same, labels)
      end do
    end do
  end subroutine add_surfaces

  !> Adds a line from the owner of each row to each node of its second side; none for an obstacle.
  pure subroutine add_links(rows, cells, shares)
    type(contact_rows_t), intent(in) :: rows
    type(cell_collection_t), intent(inout) :: cells
    !> [-] of each line: share of the contact force that goes to its second node, negative where it pulls; 0 on the cells before;
    !> shape (n_cells)
    real(rk), allocatable, intent(out) :: shares(:)
    integer, allocatable :: labels(:, :), nodes(:), row(:), starts(:)
    real(rk), allocatable :: weights(:)
    integer :: i, k, owners(rows%n_rows)

    call rows%list_side(.true., starts, nodes, weights)
    owners = rows%owners()
    row = [((k, i=starts(k) + 1, starts(k + 1)), k=1, rows%n_rows)]
    allocate (labels(n_labels, size(nodes)), source=0)
    labels(label_kind, :) = kind_link
    labels(label_contact, :) = rows%contact_entry(row)
    shares = [spread(0.0_rk, 1, cells%mesh%n_cells), weights]
    call cells%add_lines(owners(row), nodes, labels)
  end subroutine add_links

  !> Writes the mechanical model, and the names that the numbers of the cell fields material, region, boundary and contact stand
  !> for.
  subroutine write_names(problem, file)
    type(problem_t), intent(in) :: problem
    type(field_file_t), intent(inout) :: file
    type(string_t), allocatable :: boundaries(:), contacts(:), materials(:), model(:)
    integer :: i

    allocate (boundaries(0), contacts(0), materials(0), model(0))
    call append_text(model, problem%deck%mesh%model)
    do i = 1, size(problem%deck%materials)
      call append_text(materials, problem%deck%materials(i)%name)
    end do
    associate (groups => boundary_groups(problem%mesh))
      do i = 1, size(groups)
        call append_text(boundaries, problem%mesh%groups(groups(i))%name)
      end do
    end associate
    do i = 1, size(problem%deck%contact)
      call append_text(contacts, contact_name(problem%deck, i))
    end do
    call file%add_shared_array('check/model', model, '-', 'mechanical model')
    call file%add_shared_array('check/materials', materials, '-', 'names of 1, 2, ... in the cell field material')
    call file%add_shared_array('check/regions', region_names(problem%mesh), '-', 'names of 1, 2, ... in the cell field region')
    call file%add_shared_array('check/boundaries', boundaries, '-', 'names of 1, 2, ... in the cell field boundary')
    call file%add_shared_array('check/contacts', contacts, '-', 'surfaces of 1, 2, ... in the cell field contact')
  end subroutine write_names

  !> Writes the labels of all cells of the file and the shares of the lines.
  subroutine write_cell_fields(cells, shares, file)
    type(cell_collection_t), intent(in) :: cells
    !> as in add_links
    real(rk), intent(in) :: shares(:)
    type(field_file_t), intent(inout) :: file

    call file%add_cell_field('kind', cells%labels(label_kind, :), '-', &
      '1 cell of a body, 2 facet or point of a named boundary, 3 facet of a contact surface, ' // &
      '4 line from a node with a contact row to a node that it faces')
    call file%add_cell_field('material', cells%labels(label_material, :), '-', 'of the deck, 1-based; 0 off the bodies')
    call file%add_cell_field('region', cells%labels(label_region, :), '-', 'of the mesh, 1-based; 0 off the bodies')
    call file%add_cell_field('boundary', cells%labels(label_boundary, :), '-', 'of the mesh, 1-based; 0 off the boundaries')
    call file%add_cell_field('contact', cells%labels(label_contact, :), '-', 'entry of the deck''s contact section; else 0')
    call file%add_cell_field('side', cells%labels(label_side, :), '-', &
      'of a contact: 1 first, 2 second surface, swapped where the rows are on the second one; else 0')
    call file%add_cell_field('share', shares, '-', &
      'of a line: part of the contact force that goes to its second end, below 0 where it pulls; else 0')
  end subroutine write_cell_fields

  !> Writes at the nodes which displacement components are prescribed, their values at the point, and the force of all loads there.
  subroutine write_driving_fields(problem, theta, file)
    type(problem_t), intent(in) :: problem
    !> [-] values of the terms at the point, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    type(field_file_t), intent(inout) :: file
    real(rk) :: values(problem%mesh%n_dim, problem%mesh%n_nodes)

    values = reshape(merge(1.0_rk, 0.0_rk, problem%boundary%is_prescribed), shape(values))
    call file%add_node_field('prescribed', values, '-', 'component by component: 1 its displacement is prescribed, 0 it is free')
    values = reshape(problem%boundary%prescribed_displacement(theta), shape(values))
    call file%add_node_field('prescribed_displacement', values, problem%deck%units%length, '0 where it is free')
    values = reshape(problem%boundary%loads%forces(theta, size(values)), shape(values))
    call file%add_node_field('load', values, force_unit(problem%deck), 'force of all loads on the node')
  end subroutine write_driving_fields

  !> Writes the mean imposed strain of each cell at the point; it is zero on the facets, points and lines, which are no cells of
  !> bodies.
  subroutine write_strains(problem, point, n_cells, file)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> number of all cells; those of the bodies come first
    integer, intent(in) :: n_cells
    type(field_file_t), intent(inout) :: file
    type(strain_field_t) :: imposed
    real(rk), allocatable :: strains(:, :)

    call strains_at(problem, point, imposed)
    strains = cell_strains(problem%mesh, problem%body, imposed)
    strains = reshape(strains, [size(strains, 1), n_cells], pad=[0.0_rk])
    call file%add_cell_field('imposed_strain', strains, '-', 'mean of what is imposed on the cell by temperature or swelling')
  end subroutine write_strains

  !> Writes temperature and yield stress of each cell at the point; no number where there are none, and off the bodies.
  subroutine write_flow(problem, point, n_cells, file)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> number of all cells; those of the bodies come first
    integer, intent(in) :: n_cells
    type(field_file_t), intent(inout) :: file
    real(rk), allocatable :: temperatures(:), yield_stresses(:)
    real(rk) :: nothing(n_cells - problem%mesh%n_cells)

    nothing = ieee_value(0.0_rk, ieee_quiet_nan)
    call problem%flow%find_cell_means(problem%mesh, problem%body, point, temperatures, yield_stresses)
    if (any(problem%flow%is_hot)) call file%add_cell_field('temperature', [temperatures, nothing], '-', &
      'mean over the cell, in the unit of the deck; no number where neither plasticity nor creep contains it')
    if (problem%flow%has_plasticity) call file%add_cell_field('yield_stress', [yield_stresses, nothing], &
      stress_unit(problem%deck), 'mean over the cell before it hardens; no number where nothing yields')
  end subroutine write_flow

  !> Writes for each contact node its side, its contact entry, its area, and its gap at the point before anything moves; for the
  !> owner of each row also whether the row has a multiplier, the normal, and how many nodes of the second side it faces, with the
  !> largest size of their shares of the force.
  subroutine write_contact_fields(problem, rows, theta, file)
    type(problem_t), intent(in) :: problem
    !> all rows; inert pairs, which have no multiplier, come last
    type(contact_rows_t), intent(in) :: rows
    !> [-] values of the terms at the point, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    type(field_file_t), intent(inout) :: file
    real(rk), dimension(problem%mesh%n_nodes) :: entry, largest, partners, side, status
    real(rk) :: normals(problem%mesh%n_dim, problem%mesh%n_nodes)

    call list_sides(rows, problem%rows%n_rows, side, entry, status)
    call list_partners(rows, normals, partners, largest)
    call file%add_node_field('contact_side', side, '-', '1 on the first side of a contact row, 2 on the second; else 0')
    call file%add_node_field('contact_entry', entry, '-', 'entry of the deck''s contact section, 1-based; 0 without a row')
    call file%add_node_field('contact_row', status, '-', &
      '1 owns a row with a multiplier, 2 owns a row whose displacements are all prescribed (no multiplier); else 0')
    call file%add_node_field('contact_normal', normals, '-', 'from side 1 to side 2, at nodes that own a row')
    call file%add_node_field('gap', nodal_gaps(rows, matmul(rows%gap, theta), problem%mesh%n_nodes), problem%deck%units%length, &
      'open distance before anything moves, the smallest of the rows at the node; no number where there is none')
    call file%add_node_field('contact_area', nodal_areas(rows, problem%mesh%n_nodes), area_unit(problem%deck), &
      'area that the node stands for')
    call file%add_node_field('n_partners', partners, '-', 'number of nodes on side 2 of the row that this node owns')
    call file%add_node_field('largest_share', largest, '-', &
      'largest share of one of these nodes in the contact force; 1 for a pair, 0 for an obstacle')
  end subroutine write_contact_fields

  !> Finds of each node its side, its contact entry and whether it owns a row with a multiplier; all are 0 at nodes that are in no
  !> row.
  pure subroutine list_sides(rows, n_with_force, side, entry, status)
    type(contact_rows_t), intent(in) :: rows
    !> number of rows with a multiplier, which come first
    integer, intent(in) :: n_with_force
    !> side: 1 on the first side of any row, 2 on the second side only; entry: contact entry, 1-based, of the first row that
    !> contains the node; status: 1 for owners of a row with a multiplier, 2 for owners of one without, 0 for all other nodes; shape
    !> (n_nodes)
    real(rk), intent(out) :: side(:), entry(:), status(:)
    integer :: k

    side = 0
    entry = 0
    status = 0
    do k = rows%n_rows, 1, -1
      side(rows%second_nodes_of(k)) = 2
      entry(rows%nodes_of(k)) = rows%contact_entry(k)
    end do
    do k = 1, rows%n_rows
      side(rows%first_nodes_of(k)) = 1
    end do
    status(rows%owners()) = merge(1, 2, [(k <= n_with_force, k=1, rows%n_rows)])
  end subroutine list_sides

  !> Computes at the owner of each row the normal, and the number and largest share of the nodes of the second side; 0 elsewhere.
  !> For an obstacle both are 0, and the normal is set.
  pure subroutine list_partners(rows, normals, partners, largest)
    type(contact_rows_t), intent(in) :: rows
    !> [-] of length 1, from the first side to the second, shape (n_dim, n_nodes)
    real(rk), intent(out) :: normals(:, :)
    !> number of nodes of the second side, and [-] largest size of their shares of the contact force, shape (n_nodes)
    real(rk), intent(out) :: partners(:), largest(:)
    integer, allocatable :: nodes(:), starts(:)
    real(rk), allocatable :: weights(:)
    integer :: k, owners(rows%n_rows)

    normals = 0
    partners = 0
    largest = 0
    call rows%list_side(.true., starts, nodes, weights)
    owners = rows%owners()
    do k = 1, rows%n_rows
      associate (own => rows%coefficients(rows%offsets(k) + 1:rows%offsets(k) + rows%n_dim), first => starts(k) + 1, &
        last => starts(k + 1))
        normals(:, owners(k)) = own / norm2(own)
        partners(owners(k)) = last + 1 - first
        if (last >= first) largest(owners(k)) = maxval(abs(weights(first:last)))
      end associate
    end do
  end subroutine list_partners
end module sig_check_fields
