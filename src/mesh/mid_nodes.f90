! SPDX-License-Identifier: BSD-3-Clause
!> Checks that linear and quadratic elements fit in one mesh: elements that share an edge or a face must have the same nodes on it.
module sig_mid_nodes
  use sig_element_types, only: element_type_of_gmsh, element_types, fullest_type, n_element_types
  use sig_errors, only: error_t, make_error
  use sig_mesh_file, only: raw_mesh_t
  use sig_shape_functions, only: corners_of_node
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: check_mid_nodes, element_text

  !> number of corners of a quadrilateral face
  integer, parameter :: most_corners = 4
  !> number of edges and faces of a hexahedron
  integer, parameter :: most_middles = 18

  !> The edges and faces of an element type that may have a node in their middle.
  type :: middles_t
    !> number of these edges and faces
    integer :: n = 0
    !> corners of each edge and face, as numbers in the element, filled up with 0
    integer :: corners(most_corners, most_middles) = 0
    !> number of the middle node in the element, 0 = none
    integer :: node(most_middles) = 0
  end type middles_t

  !> The edges and faces of the cells seen so far. Those with the same lowest corner form a chain.
  type :: seen_t
    integer :: n = 0
    !> last edge or face whose lowest corner is this node, 0 = none; shape (n_nodes)
    integer, allocatable :: last_at_node(:)
    !> the one before it in the chain, 0 = none
    integer, allocatable :: previous(:)
    !> corners as nodes of the file, ascending, shape (most_corners, n)
    integer, allocatable :: corners(:, :)
    !> node in the middle, 0 = none
    integer, allocatable :: node(:)
    !> first element that has the edge or face
    integer, allocatable :: element(:)
  end type seen_t

contains

  !> Checks the middle nodes of the elements. Local. Cost: linear in the number of elements; a mesh without
  !> quadratic elements is not searched. Errors: two cells, or a cell and an element of lower dimension, have different nodes in the
  !> middle of a common edge or face, or only one of them has a node there. Elements of lower dimension are not compared with each
  !> other.
  pure subroutine check_mid_nodes(raw, n_dim, path, error)
    type(raw_mesh_t), intent(in) :: raw
    !> dimension of the cells
    integer, intent(in) :: n_dim
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(middles_t) :: middles(n_element_types)
    type(seen_t) :: seen
    integer :: i_element, i_sweep, i_type, n

    if (.not. has_quadratic(raw)) return
    do i_type = 1, n_element_types
      middles(i_type) = middles_of(i_type, n_dim)
    end do
    n = 0
    do i_element = 1, raw%n_elements
      n = n + middles(element_type_of_gmsh(raw%element_types(i_element)))%n
    end do
    allocate (seen%previous(n), seen%corners(most_corners, n), seen%node(n), seen%element(n))
    allocate (seen%last_at_node(raw%n_nodes), source=0)
    ! first the cells, then the elements on their edges and faces
    do i_sweep = 1, 2
      do i_element = 1, raw%n_elements
        i_type = element_type_of_gmsh(raw%element_types(i_element))
        if ((element_types(i_type)%n_dim == n_dim) .neqv. i_sweep == 1) cycle
        call compare_element(raw, i_element, middles(i_type), i_sweep == 1, path, seen, error)
        if (allocated(error)) return
      end do
    end do
  end subroutine check_mid_nodes

  pure logical function has_quadratic(raw)
    type(raw_mesh_t), intent(in) :: raw
    integer :: i_element

    has_quadratic = .false.
    do i_element = 1, raw%n_elements
      has_quadratic = has_quadratic .or. element_types(element_type_of_gmsh(raw%element_types(i_element)))%order > 1
    end do
  end function has_quadratic

  !> Returns the edges and faces of an element type, each with the node that the type has in its middle (0 = none). They are found
  !> from the element of the same shape with most nodes. An element of lower dimension than the cells counts itself as an edge or
  !> face; a cell does not, because no other element has the node inside of it.
  pure function middles_of(i_type, n_dim) result(middles)
    !> row of element_types
    integer, intent(in) :: i_type
    !> dimension of the cells
    integer, intent(in) :: n_dim
    type(middles_t) :: middles
    integer, allocatable :: corners(:)
    integer :: i, j

    associate (own => element_types(i_type), full => element_types(fullest_type(i_type)))
      do i = full%n_corners + 1, full%n_nodes
        corners = corners_of_node(fullest_type(i_type), i)
        if (size(corners) > most_corners .or. (size(corners) == full%n_corners .and. own%n_dim == n_dim)) cycle
        middles%n = middles%n + 1
        middles%corners(:size(corners), middles%n) = corners
        do j = own%n_corners + 1, own%n_nodes
          if (all(abs(own%reference_nodes(:, j) - full%reference_nodes(:, i)) < 0.1)) middles%node(middles%n) = j
        end do
      end do
    end associate
  end function middles_of

  pure subroutine compare_element(raw, i_element, middles, is_cell, path, seen, error)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: i_element
    type(middles_t), intent(in) :: middles
    logical, intent(in) :: is_cell
    character(*), intent(in) :: path
    type(seen_t), intent(inout) :: seen
    type(error_t), allocatable, intent(out) :: error
    integer :: corners(most_corners), i, i_seen, node

    associate (nodes => raw%element_nodes(raw%element_offsets(i_element) + 1:raw%element_offsets(i_element + 1)))
      do i = 1, middles%n
        associate (n => count(middles%corners(:, i) > 0))
          corners = 0
          corners(:n) = ascending(nodes(middles%corners(:n, i)))
        end associate
        node = 0
        if (middles%node(i) > 0) node = nodes(middles%node(i))
        i_seen = place_of(seen, corners)
        if (i_seen > 0) then
          if (seen%node(i_seen) /= node) call refuse(raw, i_element, seen%element(i_seen), corners, is_cell, path, error)
          if (allocated(error)) return
        else if (is_cell) then
          call remember(corners, node, i_element, seen)
        end if
      end do
    end associate
  end subroutine compare_element

  !> Returns the numbers in ascending order. Requires: no number occurs twice.
  pure function ascending(numbers) result(sorted)
    integer, intent(in) :: numbers(:)
    integer :: sorted(size(numbers))
    integer :: i

    do i = 1, size(numbers)
      sorted(count(numbers < numbers(i)) + 1) = numbers(i)
    end do
  end function ascending

  !> Returns the index of an edge or face in `seen`; 0 if no cell before had an edge or face with these corners.
  pure integer function place_of(seen, corners) result(i_seen)
    type(seen_t), intent(in) :: seen
    !> corners of the edge or face: nodes of the file, ascending, filled up with 0
    integer, intent(in) :: corners(most_corners)

    i_seen = seen%last_at_node(corners(1))
    do while (i_seen > 0)
      if (all(seen%corners(:, i_seen) == corners)) return
      i_seen = seen%previous(i_seen)
    end do
  end function place_of

  pure subroutine remember(corners, node, i_element, seen)
    integer, intent(in) :: corners(most_corners)
    integer, intent(in) :: node
    integer, intent(in) :: i_element
    type(seen_t), intent(inout) :: seen

    seen%n = seen%n + 1
    seen%corners(:, seen%n) = corners
    seen%node(seen%n) = node
    seen%element(seen%n) = i_element
    seen%previous(seen%n) = seen%last_at_node(corners(1))
    seen%last_at_node(corners(1)) = seen%n
  end subroutine remember

  pure subroutine refuse(raw, i_element, i_cell, corners, is_cell, path, error)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: i_element
    !> the other cell
    integer, intent(in) :: i_cell
    !> nodes of the edge or face, filled up with 0
    integer, intent(in) :: corners(most_corners)
    logical, intent(in) :: is_cell
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: hint, place
    integer :: i

    place = to_text(raw%node_tags(corners(1)))
    do i = 2, count(corners > 0)
      place = place // ', ' // to_text(raw%node_tags(corners(i)))
    end do
    hint = 'mesh boundaries and regions together with one Mesh.ElementOrder, so that both have mid-side nodes, or none'
    if (is_cell) hint = 'mesh connected parts with one Mesh.ElementOrder and one Mesh.SecondOrderIncomplete'
    call make_error(error, element_text(raw, i_element) // ' and ' // element_text(raw, i_cell) // &
      ' do not have the same node in the middle of their common ' // trim(merge('edge', 'face', corners(3) == 0)) // &
      ' between the nodes ' // place, path, raw%element_places(1, i_element), raw%element_places(2, i_element), hint)
  end subroutine refuse

  !> Returns an element for messages, `the T6 17 of 'block'`, with its number in gmsh and its first group.
  pure function element_text(raw, i_element) result(text)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: i_element
    character(:), allocatable :: text
    integer :: m

    text = 'the ' // trim(element_types(element_type_of_gmsh(raw%element_types(i_element)))%name) // ' ' // &
      to_text(raw%element_tags(i_element))
    m = findloc(raw%member_elements, i_element, dim=1)
    if (m > 0) text = text // " of '" // raw%group_names(raw%member_groups(m))%text // "'"
  end function element_text
end module sig_mid_nodes
