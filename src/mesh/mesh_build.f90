! SPDX-License-Identifier: BSD-3-Clause
!> Builds the mesh from the content of a gmsh file: the cells and facets, each once, and the nodes of the cells.
module sig_mesh_build
  use sig_element_types, only: element_type_of_gmsh, element_types
  use sig_errors, only: error_t, make_error
  use sig_hanging_diagonals, only: note_hanging_diagonals
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_file, only: raw_mesh_t, raw_nodes
  use sig_mesh_groups, only: build_groups, note_names
  use sig_mid_nodes, only: check_mid_nodes
  use sig_rounding, only: rounding_of_data
  use sig_text, only: append_text, string_t, to_text
  implicit none(type, external)
  private
  public :: build_mesh, mesh_dimension

  character(1), parameter :: axis_names(3) = ['x', 'y', 'z']

contains

  !> Builds the mesh. Elements of the same type and nodes count once; nodes without a cell, and facets with such a node, are left
  !> out; the order of the file is kept. The orientation of the cells is not checked, and file_hash is not set. Local.
  !>
  !> Errors: the largest dimension of the elements is not n_dim, or there are none; those of check_mid_nodes and find_axes. After
  !> any error the mesh is not complete.
  subroutine build_mesh(raw, n_dim, length_factor, path, mesh, error)
    type(raw_mesh_t), intent(in) :: raw
    !> 2 or 3: dimension of the model
    integer, intent(in) :: n_dim
    !> factor for all coordinates, from the mesh file's unit of length to the deck's [units.length / mesh.length_unit]
    real(rk), intent(in) :: length_factor
    !> name of the file for messages
    character(*), intent(in) :: path
    type(mesh_t), intent(out) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: cell_of_element(:), facet_of_element(:), node_of_raw_node(:)
    integer :: axes(3)

    mesh%n_dim = n_dim
    allocate (mesh%notes(0))
    call check_dimension(raw, n_dim, path, error)
    if (allocated(error)) return
    call check_mid_nodes(raw, n_dim, path, error)
    if (allocated(error)) return
    call note_hanging_diagonals(raw, path, mesh%notes)
    call number_cells(raw, n_dim, cell_of_element, node_of_raw_node)
    call find_axes(raw, node_of_raw_node, n_dim, path, axes, mesh%notes, error)
    if (allocated(error)) return
    call copy_nodes(raw, node_of_raw_node, axes(:n_dim), length_factor, mesh)
    call copy_elements(raw, cell_of_element, node_of_raw_node, mesh%n_cells, mesh%cell_types, mesh%cell_offsets, mesh%cell_nodes, &
                       mesh%cell_tags)
    call number_elements(raw, n_dim - 1, node_of_raw_node, facet_of_element)
    call copy_elements(raw, facet_of_element, node_of_raw_node, mesh%n_facets, mesh%facet_types, mesh%facet_offsets, &
                       mesh%facet_nodes)
    call build_groups(raw, cell_of_element, facet_of_element, node_of_raw_node, mesh)
    call note_names(raw, mesh)
  end subroutine build_mesh

  pure integer function dimension_of_element(raw, i_element) result(n_dim)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: i_element

    n_dim = element_types(element_type_of_gmsh(raw%element_types(i_element)))%n_dim
  end function dimension_of_element

  !> Returns the largest dimension of the elements; -1 if there are none.
  pure integer function mesh_dimension(raw) result(n_dim)
    type(raw_mesh_t), intent(in) :: raw
    integer :: i_element

    n_dim = -1
    do i_element = 1, raw%n_elements
      n_dim = max(n_dim, dimension_of_element(raw, i_element))
    end do
  end function mesh_dimension

  pure subroutine check_dimension(raw, n_dim, path, error)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: n_dim
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    integer :: found

    found = mesh_dimension(raw)
    if (found == n_dim) return
    if (found < 0) then
      call make_error(error, 'the mesh has no elements', file=path, hint='mesh the geometry and save it again')
    else
      call make_error(error, 'the model needs a mesh of dimension ' // to_text(n_dim) // &
                      ', but the largest dimension of its elements is ' // to_text(found), file=path, &
                      hint=dimension_hint(n_dim, found))
    end if
  end subroutine check_dimension

  pure function dimension_hint(n_dim, found) result(hint)
    integer, intent(in) :: n_dim, found
    character(:), allocatable :: hint

    hint = ''
    if (found > n_dim) hint = 'a mesh of volumes needs mesh.model: solid; the other models take triangles and quadrilaterals'
    if (found < n_dim) hint = 'mesh it with gmsh -' // to_text(n_dim) // &
      '; gmsh saves the regions if they are in physical groups, or if there are no physical groups at all'
    if (found < n_dim .and. n_dim == 3) hint = hint // '; a mesh of the plane needs another mesh.model than solid'
  end function dimension_hint

  !> Numbers the cells and their nodes in the order of the file.
  pure subroutine number_cells(raw, n_dim, cell_of_element, node_of_raw_node)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: n_dim
    !> number of the cell of each element of the file; 0 for other elements
    integer, allocatable, intent(out) :: cell_of_element(:)
    !> number in the mesh of each node of the file; 0 for nodes without a cell
    integer, allocatable, intent(out) :: node_of_raw_node(:)
    integer :: i_element, i_node, n

    allocate (node_of_raw_node(raw%n_nodes), source=1)
    call number_elements(raw, n_dim, node_of_raw_node, cell_of_element)
    node_of_raw_node = 0
    do i_element = 1, raw%n_elements
      if (cell_of_element(i_element) == 0) cycle
      do n = raw%element_offsets(i_element) + 1, raw%element_offsets(i_element + 1)
        node_of_raw_node(raw%element_nodes(n)) = 1
      end do
    end do
    n = 0
    do i_node = 1, raw%n_nodes
      if (node_of_raw_node(i_node) == 0) cycle
      n = n + 1
      node_of_raw_node(i_node) = n
    end do
  end subroutine number_cells

  !> Numbers the elements of one dimension, 1, 2, ... in the order of the file, but only those whose nodes all count. Elements of
  !> the same type on the same nodes, in any order, get the same number.
  pure subroutine number_elements(raw, n_dim, node_of_raw_node, number_of_element)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: n_dim
    !> 0 for the nodes that do not count, shape (n_nodes of the file): none for cells, those without a cell for facets
    integer, intent(in) :: node_of_raw_node(:)
    !> number of each element of the file; 0 for other elements
    integer, allocatable, intent(out) :: number_of_element(:)
    !> last numbered element whose smallest node is this one, and the one before it: short chains, so that not all pairs are
    !> compared
    integer :: last_at_node(raw%n_nodes), previous(raw%n_elements)
    integer :: i_element, i_twin, n, smallest

    last_at_node = 0
    allocate (number_of_element(raw%n_elements), source=0)
    n = 0
    do i_element = 1, raw%n_elements
      if (dimension_of_element(raw, i_element) /= n_dim) cycle
      if (any(node_of_raw_node(raw_nodes(raw, i_element)) == 0)) cycle
      smallest = minval(raw_nodes(raw, i_element))
      i_twin = last_at_node(smallest)
      do while (i_twin > 0)
        if (has_same_nodes(raw, i_element, i_twin)) exit
        i_twin = previous(i_twin)
      end do
      if (i_twin > 0) then
        number_of_element(i_element) = number_of_element(i_twin)
      else
        n = n + 1
        number_of_element(i_element) = n
        previous(i_element) = last_at_node(smallest)
        last_at_node(smallest) = i_element
      end if
    end do
  end subroutine number_elements

  pure logical function has_same_nodes(raw, i_first, i_second) result(is_same)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: i_first, i_second
    integer :: n

    is_same = raw%element_types(i_first) == raw%element_types(i_second)
    if (.not. is_same) return
    do n = raw%element_offsets(i_first) + 1, raw%element_offsets(i_first + 1)
      is_same = is_same .and. any(raw_nodes(raw, i_second) == raw%element_nodes(n))
    end do
  end function has_same_nodes

  !> Finds which of the file's axes are those of the model: 1, 2, 3 in space and in a plane z = const; the other two, ascending,
  !> in a plane y = const or x = const, with a note. Errors: a plane mesh in none of these planes, that is, all three coordinates
  !> vary by more than 1e-9 of the mesh's size.
  pure subroutine find_axes(raw, node_of_raw_node, n_dim, path, axes, notes, error)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: node_of_raw_node(:)
    integer, intent(in) :: n_dim
    character(*), intent(in) :: path
    integer, intent(out) :: axes(3)
    type(string_t), allocatable, intent(inout) :: notes(:)
    type(error_t), allocatable, intent(out) :: error
    real(rk) :: lower(3), upper(3)
    integer :: across, i

    axes = [1, 2, 3]
    if (n_dim == 3) return
    do i = 1, 3
      lower(i) = minval(raw%coordinates(i, :), mask=node_of_raw_node > 0)
      upper(i) = maxval(raw%coordinates(i, :), mask=node_of_raw_node > 0)
    end do
    across = findloc(upper - lower <= rounding_of_data * maxval(upper - lower), .true., dim=1, back=.true.)
    if (across == 0) then
      call make_error(error, 'a plane model needs a mesh in a plane z = const, y = const or x = const; here x runs from ' // &
        to_text(lower(1)) // ' to ' // to_text(upper(1)) // ', y from ' // to_text(lower(2)) // ' to ' // to_text(upper(2)) // &
        ' and z from ' // to_text(lower(3)) // ' to ' // to_text(upper(3)), file=path, hint='the mesh has surfaces and no ' // &
        'volumes: for a solid, mesh its volume (gmsh -3); for a plane model, build the geometry in the x-y plane')
    else if (across < 3) then
      axes = [pack(axes, axes /= across), across]
      call append_text(notes, 'the mesh is in a plane ' // axis_names(across) // ' = const: ' // axis_names(axes(1)) // ' and ' // &
        axis_names(axes(2)) // ' of the file are x and y of the model')
    end if
  end subroutine find_axes

  !> Makes mesh%coordinates and mesh%node_tags.
  pure subroutine copy_nodes(raw, node_of_raw_node, axes, length_factor, mesh)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: node_of_raw_node(:)
    !> of find_axes, shape (mesh%n_dim)
    integer, intent(in) :: axes(:)
    real(rk), intent(in) :: length_factor
    type(mesh_t), intent(inout) :: mesh
    integer :: i_node, i_raw

    mesh%n_nodes = maxval(node_of_raw_node)
    allocate (mesh%coordinates(mesh%n_dim, mesh%n_nodes), mesh%node_tags(mesh%n_nodes))
    do i_raw = 1, raw%n_nodes
      i_node = node_of_raw_node(i_raw)
      if (i_node == 0) cycle
      mesh%coordinates(:, i_node) = length_factor * raw%coordinates(axes, i_raw)
      mesh%node_tags(i_node) = raw%node_tags(i_raw)
    end do
  end subroutine copy_nodes

  !> Copies each numbered element once, from its first occurrence in the file: types (rows of element_types), offsets, nodes and
  !> tags as in mesh_t.
  pure subroutine copy_elements(raw, number_of_element, node_of_raw_node, n_kept, types, offsets, nodes, tags)
    type(raw_mesh_t), intent(in) :: raw
    !> of number_elements
    integer, intent(in) :: number_of_element(:)
    !> of number_cells
    integer, intent(in) :: node_of_raw_node(:)
    !> number of elements that were copied
    integer, intent(out) :: n_kept
    integer, allocatable, intent(out) :: types(:), offsets(:), nodes(:)
    !> gmsh's element numbers
    integer, allocatable, intent(out), optional :: tags(:)
    integer, allocatable :: first_element(:)
    integer :: i, i_element, n

    n_kept = maxval([0, number_of_element])
    allocate (first_element(n_kept))
    do i_element = raw%n_elements, 1, -1
      if (number_of_element(i_element) > 0) first_element(number_of_element(i_element)) = i_element
    end do
    allocate (types(n_kept), offsets(n_kept + 1))
    offsets(1) = 0
    do i = 1, n_kept
      i_element = first_element(i)
      types(i) = element_type_of_gmsh(raw%element_types(i_element))
      offsets(i + 1) = offsets(i) + raw%element_offsets(i_element + 1) - raw%element_offsets(i_element)
    end do
    allocate (nodes(offsets(n_kept + 1)))
    do i = 1, n_kept
      n = raw%element_offsets(first_element(i))
      nodes(offsets(i) + 1:offsets(i + 1)) = node_of_raw_node(raw%element_nodes(n + 1:n + offsets(i + 1) - offsets(i)))
    end do
    if (present(tags)) tags = raw%element_tags(first_element)
  end subroutine copy_elements
end module sig_mesh_build
