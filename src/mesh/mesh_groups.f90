! SPDX-License-Identifier: BSD-3-Clause
!> Makes the groups of a mesh from those of the file, and says which of their names were made up.
module sig_mesh_groups
  use sig_mesh, only: find_group, mesh_t
  use sig_mesh_file, only: kind_entity, kind_named, kind_physical, raw_mesh_t, raw_nodes
  use sig_text, only: append_text, to_text
  implicit none(type, external)
  private
  public :: build_groups, note_names

contains

  !> Makes mesh%groups, in the file's order: the groups with a name in the file, also those without elements, and those others that
  !> have nodes of the mesh.
  pure subroutine build_groups(raw, cell_of_element, facet_of_element, node_of_raw_node, mesh)
    type(raw_mesh_t), intent(in) :: raw
    !> of number_cells and number_elements
    integer, intent(in) :: cell_of_element(:), facet_of_element(:), node_of_raw_node(:)
    !> with n_dim, n_cells and n_facets
    type(mesh_t), intent(inout) :: mesh
    integer :: i, i_group
    integer :: members_before(raw%n_groups + 1), elements(size(raw%member_elements))
    logical :: is_kept(raw%n_groups)

    call sort_members(raw, members_before, elements)
    is_kept = raw%group_kinds == kind_named
    do i = 1, size(raw%member_elements)
      if (all(node_of_raw_node(raw_nodes(raw, raw%member_elements(i))) > 0)) is_kept(raw%member_groups(i)) = .true.
    end do
    allocate (mesh%groups(count(is_kept)))
    i = 0
    do i_group = 1, raw%n_groups
      if (.not. is_kept(i_group)) cycle
      i = i + 1
      mesh%groups(i)%name = raw%group_names(i_group)%text
      mesh%groups(i)%n_dim = raw%group_dims(i_group)
      associate (own => elements(members_before(i_group) + 1:members_before(i_group + 1)), group => mesh%groups(i))
        call collect_nodes(raw, own, node_of_raw_node, group%nodes, group%n_left_out)
        if (group%n_dim == mesh%n_dim) then
          group%entities = ascending(cell_of_element(own), mesh%n_cells)
        else if (group%n_dim == mesh%n_dim - 1) then
          group%entities = ascending(facet_of_element(own), mesh%n_facets)
        else
          allocate (group%entities(0))
        end if
      end associate
    end do
  end subroutine build_groups

  !> Adds a note for the groups that got a name from their dimension and number, if there are some.
  pure subroutine note_names(raw, mesh)
    type(raw_mesh_t), intent(in) :: raw
    type(mesh_t), intent(inout) :: mesh
    character(:), allocatable :: physical, entities

    physical = first_names(raw, kind_physical, mesh)
    entities = first_names(raw, kind_entity, mesh)
    if (len(physical) > 0) call append_text(mesh%notes, 'physical groups of the mesh without a name are called by dimension ' // &
      'and number: ' // physical)
    if (len(entities) > 0) call append_text(mesh%notes, 'elements of the mesh in no physical group are called by the ' // &
      'dimension and number of their geometric entity: ' // entities)
  end subroutine note_names

  !> Returns the names of up to three groups of a kind in the mesh, those of larger dimension first, and how many more there are;
  !> empty if there are none.
  pure function first_names(raw, kind, mesh) result(text)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: kind
    type(mesh_t), intent(in) :: mesh
    character(:), allocatable :: text
    integer, parameter :: n_shown = 3
    integer :: i, n, n_dim

    text = ''
    n = 0
    do n_dim = mesh%n_dim, 0, -1
      do i = 1, raw%n_groups
        if (raw%group_kinds(i) /= kind .or. raw%group_dims(i) /= n_dim) cycle
        if (find_group(mesh, raw%group_names(i)%text, n_dim) == 0) cycle
        n = n + 1
        if (n > 1 .and. n <= n_shown) text = text // ', '
        if (n <= n_shown) text = text // raw%group_names(i)%text
      end do
    end do
    if (n > n_shown) text = text // ' and ' // to_text(n - n_shown) // ' more'
  end function first_names

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
end module sig_mesh_groups
