! SPDX-License-Identifier: BSD-3-Clause
!> Builds the mesh from the content of a gmsh file: the cells and facets of physical groups, each once, and the nodes of the cells.
module sig_mesh_build
  use sig_element_types, only: element_type_of_gmsh, element_types
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_mesh, only: group_t, mesh_t
  use sig_mesh_file, only: raw_mesh_t
  use sig_mid_nodes, only: check_mid_nodes
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: build_mesh, mesh_dimension

  !> [-] largest distance of a plane mesh from a plane, relative to its size
  real(rk), parameter :: plane_tolerance = 1.0e-9_rk

contains

  !> Builds the mesh from the elements in physical groups. Elements of the same type and nodes count once; nodes without a cell, and
  !> facets with such a node, are left out; the order of the file is kept. The orientation of the cells is not checked, and
  !> file_hash is not set. Local.
  !>
  !> Errors: the largest dimension of the elements in physical groups is not n_dim, or there are none; cells in an unnamed group,
  !> also if a named one has them, too; those of check_mid_nodes; a plane mesh that is not in a plane z = const (z varies by more
  !> than 1e-9 of the mesh's size). After any error the mesh is not complete.
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

    mesh%n_dim = n_dim
    call check_dimension(raw, n_dim, path, error)
    if (allocated(error)) return
    call check_names(raw, n_dim, path, error)
    if (allocated(error)) return
    call check_mid_nodes(raw, n_dim, path, error)
    if (allocated(error)) return
    call number_cells(raw, n_dim, cell_of_element, node_of_raw_node)
    call check_plane(raw, node_of_raw_node, n_dim, path, error)
    if (allocated(error)) return
    call copy_nodes(raw, node_of_raw_node, length_factor, mesh)
    call copy_elements(raw, cell_of_element, node_of_raw_node, mesh%n_cells, mesh%cell_types, mesh%cell_offsets, mesh%cell_nodes, &
                       mesh%cell_tags)
    call number_elements(raw, n_dim - 1, node_of_raw_node, facet_of_element)
    call copy_elements(raw, facet_of_element, node_of_raw_node, mesh%n_facets, mesh%facet_types, mesh%facet_offsets, &
                       mesh%facet_nodes)
    call build_groups(raw, cell_of_element, facet_of_element, node_of_raw_node, mesh)
  end subroutine build_mesh

  pure integer function dimension_of_element(raw, i_element) result(n_dim)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: i_element

    n_dim = element_types(element_type_of_gmsh(raw%element_types(i_element)))%n_dim
  end function dimension_of_element

  !> Returns the largest dimension of the elements that belong to a physical group; -1 if there are none.
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
      call make_error(error, 'the mesh has no element of a physical group', file=path, &
                      hint='in the .geo file, name each region (Physical Surface("lower") = {1}; or Physical Volume) and each ' // &
                      'boundary, and mesh it again')
    else
      call make_error(error, 'the model needs a mesh of dimension ' // to_text(n_dim) // &
                      ', but the largest dimension of elements with a physical group is ' // to_text(found), file=path, &
                      hint=dimension_hint(n_dim, found))
    end if
  end subroutine check_dimension

  pure function dimension_hint(n_dim, found) result(hint)
    integer, intent(in) :: n_dim, found
    character(:), allocatable :: hint

    hint = ''
    if (found > n_dim) hint = 'a mesh of volumes needs mesh.model: solid; the other models take triangles and quadrilaterals'
    if (found < n_dim) hint = 'give each region a name in the .geo file (Physical ' // region_word(n_dim) // &
      '("lower") = {1};) and mesh with gmsh -' // to_text(n_dim)
    if (found < n_dim .and. n_dim == 3) hint = hint // '; a mesh of the plane needs another mesh.model than solid'
  end function dimension_hint

  !> Returns gmsh's word for regions: Surface if n_dim is 2, otherwise Volume.
  pure function region_word(n_dim) result(word)
    integer, intent(in) :: n_dim
    character(:), allocatable :: word

    word = trim(merge('Surface', 'Volume ', n_dim == 2))
  end function region_word

  !> Checks that regions have names: the deck uses regions by name, so a region without a name would be lost without a message.
  !> Errors: the first group of dimension n_dim that has elements and no name.
  pure subroutine check_names(raw, n_dim, path, error)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: n_dim
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    integer :: i_member, i_group

    do i_member = 1, size(raw%member_groups)
      i_group = raw%member_groups(i_member)
      if (raw%group_dims(i_group) /= n_dim .or. len(raw%group_names(i_group)%text) > 0) cycle
      call make_error(error, 'the physical group ' // to_text(raw%group_tags(i_group)) // ' of dimension ' // to_text(n_dim) // &
                      ' has no name', file=path, &
                      hint='name it in the .geo file: Physical ' // trim(merge('Surface', 'Volume ', n_dim == 2)) // &
                      '("name", ' // to_text(raw%group_tags(i_group)) // ') = {...};')
      return
    end do
  end subroutine check_names

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

  pure function raw_nodes(raw, i_element) result(nodes)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: i_element
    integer :: nodes(raw%element_offsets(i_element + 1) - raw%element_offsets(i_element))

    nodes = raw%element_nodes(raw%element_offsets(i_element) + 1:raw%element_offsets(i_element + 1))
  end function raw_nodes

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

  pure subroutine check_plane(raw, node_of_raw_node, n_dim, path, error)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: node_of_raw_node(:)
    integer, intent(in) :: n_dim
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    real(rk) :: lower(3), upper(3)
    integer :: i

    if (n_dim == 3) return
    do i = 1, 3
      lower(i) = minval(raw%coordinates(i, :), mask=node_of_raw_node > 0)
      upper(i) = maxval(raw%coordinates(i, :), mask=node_of_raw_node > 0)
    end do
    if (upper(3) - lower(3) <= plane_tolerance * maxval(upper - lower)) return
    call make_error(error, 'a plane model needs a mesh in a plane z = const; here z runs from ' // to_text(lower(3)) // ' to ' // &
                    to_text(upper(3)), file=path, hint='build the geometry in the x-y plane')
  end subroutine check_plane

  pure subroutine copy_nodes(raw, node_of_raw_node, length_factor, mesh)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: node_of_raw_node(:)
    real(rk), intent(in) :: length_factor
    type(mesh_t), intent(inout) :: mesh
    integer :: i_node, i_raw

    mesh%n_nodes = maxval(node_of_raw_node)
    allocate (mesh%coordinates(mesh%n_dim, mesh%n_nodes), mesh%node_tags(mesh%n_nodes))
    do i_raw = 1, raw%n_nodes
      i_node = node_of_raw_node(i_raw)
      if (i_node == 0) cycle
      mesh%coordinates(:, i_node) = length_factor * raw%coordinates(:mesh%n_dim, i_raw)
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

  !> Makes mesh%groups: one group for each physical group that has a name, also if it has no elements, in the file's order. A deck
  !> cannot use the others.
  pure subroutine build_groups(raw, cell_of_element, facet_of_element, node_of_raw_node, mesh)
    type(raw_mesh_t), intent(in) :: raw
    !> of number_cells and number_elements
    integer, intent(in) :: cell_of_element(:), facet_of_element(:), node_of_raw_node(:)
    !> with n_dim, n_cells and n_facets
    type(mesh_t), intent(inout) :: mesh
    integer :: i, i_group, n_named
    integer :: members_before(raw%n_groups + 1), elements(size(raw%member_elements))

    call sort_members(raw, members_before, elements)
    n_named = count([(len(raw%group_names(i)%text) > 0, i=1, raw%n_groups)])
    allocate (mesh%groups(n_named))
    i = 0
    do i_group = 1, raw%n_groups
      if (len(raw%group_names(i_group)%text) == 0) cycle
      i = i + 1
      mesh%groups(i)%name = raw%group_names(i_group)%text
      mesh%groups(i)%n_dim = raw%group_dims(i_group)
      associate (own => elements(members_before(i_group) + 1:members_before(i_group + 1)))
        call collect_nodes(raw, own, node_of_raw_node, mesh%groups(i)%nodes, mesh%groups(i)%n_left_out)
        if (raw%group_dims(i_group) == mesh%n_dim) then
          mesh%groups(i)%entities = ascending(cell_of_element(own), mesh%n_cells)
        else if (raw%group_dims(i_group) == mesh%n_dim - 1) then
          mesh%groups(i)%entities = ascending(facet_of_element(own), mesh%n_facets)
        else
          allocate (mesh%groups(i)%entities(0))
        end if
      end associate
    end do
  end subroutine build_groups

  !> Sorts the elements of the file by groups: those of group g are elements(members_before(g) + 1 : members_before(g + 1)). An
  !> element of several groups is there several times.
  pure subroutine sort_members(raw, members_before, elements)
    type(raw_mesh_t), intent(in) :: raw
    !> shape (n_groups + 1)
    integer, intent(out) :: members_before(:)
    !> numbers in the file, 1-based, shape (number of memberships)
    integer, intent(out) :: elements(:)
    integer :: i_group, m, next(size(members_before))

    members_before = 0
    do m = 1, size(raw%member_groups)
      i_group = raw%member_groups(m)
      members_before(i_group + 1) = members_before(i_group + 1) + 1
    end do
    do i_group = 1, raw%n_groups
      members_before(i_group + 1) = members_before(i_group + 1) + members_before(i_group)
    end do
    next = members_before
    do m = 1, size(raw%member_groups)
      i_group = raw%member_groups(m)
      next(i_group) = next(i_group) + 1
      elements(next(i_group)) = raw%member_elements(m)
    end do
  end subroutine sort_members

  !> Lists the nodes (numbers in the mesh) of elements of the file, each once, ascending. Elements with any node that belongs to no
  !> cell do not count.
  pure subroutine collect_nodes(raw, elements, node_of_raw_node, nodes, n_left_out)
    type(raw_mesh_t), intent(in) :: raw
    !> 1-based, in the file
    integer, intent(in) :: elements(:)
    !> of number_cells
    integer, intent(in) :: node_of_raw_node(:)
    integer, allocatable, intent(out) :: nodes(:)
    !> number of elements that do not count
    integer, intent(out) :: n_left_out
    logical :: is_used(maxval(node_of_raw_node))
    integer, allocatable :: own(:)
    integer :: i, i_node

    is_used = .false.
    n_left_out = 0
    do i = 1, size(elements)
      own = node_of_raw_node(raw_nodes(raw, elements(i)))
      if (any(own == 0)) then
        n_left_out = n_left_out + 1
      else
        is_used(own) = .true.
      end if
    end do
    nodes = pack([(i_node, i_node=1, size(is_used))], is_used)
  end subroutine collect_nodes

  !> Returns the positive numbers of a list, each once, ascending.
  pure function ascending(numbers, n) result(sorted)
    integer, intent(in) :: numbers(:)
    !> largest possible number
    integer, intent(in) :: n
    integer, allocatable :: sorted(:)
    logical :: is_used(n)
    integer :: i

    is_used = .false.
    do i = 1, size(numbers)
      if (numbers(i) > 0) is_used(numbers(i)) = .true.
    end do
    sorted = pack([(i, i=1, n)], is_used)
  end function ascending
end module sig_mesh_build
