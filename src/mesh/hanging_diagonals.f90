! SPDX-License-Identifier: BSD-3-Clause
!> Finds cells that have an edge across a quadrilateral face of another one. Two triangles against a quadrilateral have the same
!> corners, but not the same displacements between them. A displacement that is linear there fits, so that finer meshes are right,
!> but any other one has small gaps.
module sig_hanging_diagonals
  use sig_element_types, only: element_type_of_gmsh, element_types, fullest_type, n_element_types
  use sig_mesh_file, only: raw_mesh_t
  use sig_mid_nodes, only: element_text
  use sig_shape_functions, only: corners_of_node
  use sig_text, only: append_text, string_t, to_text
  implicit none(type, external)
  private
  public :: note_hanging_diagonals

  !> The edges of an element type, and the diagonals of its quadrilateral faces: pairs of its corners, shape (2, n).
  type :: lines_t
    integer, allocatable :: edges(:, :)
    integer, allocatable :: diagonals(:, :)
  end type lines_t

  !> The diagonals of all cells. Those with the same lower node form a chain.
  type :: diagonals_t
    integer :: n = 0
    !> last diagonal whose lower node is this one, 0 = none; shape (n_nodes)
    integer, allocatable :: last_at_node(:)
    !> the one before it in the chain, 0 = none
    integer, allocatable :: previous(:)
    !> its higher node, and a cell that has it
    integer, allocatable :: node(:)
    integer, allocatable :: element(:)
  end type diagonals_t

contains

  !> Adds a note that tells how many cells have such an edge, and the first one. Local. Cost: linear in the number of elements; a
  !> mesh with cells of one shape that has faces of one kind is not searched.
  pure subroutine note_hanging_diagonals(raw, path, notes)
    type(raw_mesh_t), intent(in) :: raw
    character(*), intent(in) :: path
    type(string_t), allocatable, intent(inout) :: notes(:)
    type(lines_t) :: lines(n_element_types)
    type(diagonals_t) :: diagonals
    character(:), allocatable :: first
    integer :: edge(2), i_element, i_other, i_type, n

    do i_type = 1, n_element_types
      lines(i_type) = lines_of(i_type)
    end do
    if (.not. has_both_kinds(raw, lines)) return
    call collect_diagonals(raw, lines, diagonals)
    n = 0
    do i_element = 1, raw%n_elements
      call find_hanging_edge(raw, lines, diagonals, i_element, edge, i_other)
      if (i_other == 0) cycle
      n = n + 1
      if (n == 1) first = path // ':' // to_text(raw%element_places(1, i_element)) // ', ' // element_text(raw, i_element) // &
        ', between the nodes ' // to_text(raw%node_tags(edge(1))) // ' and ' // to_text(raw%node_tags(edge(2))) // &
        ', on ' // element_text(raw, i_other)
    end do
    if (n > 0) call append_text(notes, to_text(n) // ' cells of the mesh have an edge across a quadrilateral face of another ' // &
      'cell (the first one: ' // first // '); their displacements fit together at the nodes only, so stresses there are less ' // &
      'accurate; put pyramids between tetrahedra and hexahedra, as gmsh does by itself')
  end subroutine note_hanging_diagonals

  !> Finds an edge of an element that is a diagonal of another one.
  pure subroutine find_hanging_edge(raw, lines, diagonals, i_element, edge, i_other)
    type(raw_mesh_t), intent(in) :: raw
    type(lines_t), intent(in) :: lines(:)
    type(diagonals_t), intent(in) :: diagonals
    integer, intent(in) :: i_element
    !> its nodes
    integer, intent(out) :: edge(2)
    !> the other element, 0 = none
    integer, intent(out) :: i_other
    integer :: i, place

    i_other = 0
    associate (nodes => raw%element_nodes(raw%element_offsets(i_element) + 1:raw%element_offsets(i_element + 1)), &
      edges => lines(element_type_of_gmsh(raw%element_types(i_element)))%edges)
      do i = 1, size(edges, 2)
        edge = nodes(edges(:, i))
        place = place_of(diagonals, edge)
        if (place > 0) i_other = diagonals%element(place)
        if (place > 0) return
      end do
    end associate
  end subroutine find_hanging_edge

  !> Returns the edges and diagonals of a type; none if it is no solid.
  pure function lines_of(i_type) result(lines)
    !> row of element_types
    integer, intent(in) :: i_type
    type(lines_t) :: lines
    integer, allocatable :: corners(:)
    integer :: i, j, k

    allocate (lines%edges(2, 0), lines%diagonals(2, 0))
    if (element_types(i_type)%n_dim < 3) return
    associate (full => element_types(fullest_type(i_type)))
      do i = full%n_corners + 1, full%n_nodes
        corners = corners_of_node(fullest_type(i_type), i)
        if (size(corners) == 2) lines%edges = reshape([lines%edges, corners], [2, size(lines%edges, 2) + 1])
      end do
      do i = full%n_corners + 1, full%n_nodes
        corners = corners_of_node(fullest_type(i_type), i)
        if (size(corners) /= 4) cycle
        do j = 1, 3
          do k = j + 1, 4
            if (any(lines%edges(1, :) == corners(j) .and. lines%edges(2, :) == corners(k))) cycle
            lines%diagonals = reshape([lines%diagonals, corners([j, k])], [2, size(lines%diagonals, 2) + 1])
          end do
        end do
      end do
    end associate
  end function lines_of

  !> Whether some cells have quadrilateral faces, and some, of the same or of other types, triangular ones.
  pure logical function has_both_kinds(raw, lines)
    type(raw_mesh_t), intent(in) :: raw
    type(lines_t), intent(in) :: lines(:)
    !> number of diagonals of a hexahedron, which alone has no triangles
    integer, parameter :: of_hexahedron = 12
    logical :: has_quadrilaterals, has_triangles
    integer :: i

    has_quadrilaterals = .false.
    has_triangles = .false.
    do i = 1, raw%n_elements
      associate (own => lines(element_type_of_gmsh(raw%element_types(i))))
        if (size(own%edges, 2) == 0) cycle
        has_quadrilaterals = has_quadrilaterals .or. size(own%diagonals, 2) > 0
        has_triangles = has_triangles .or. size(own%diagonals, 2) < of_hexahedron
      end associate
    end do
    has_both_kinds = has_quadrilaterals .and. has_triangles
  end function has_both_kinds

  pure subroutine collect_diagonals(raw, lines, diagonals)
    type(raw_mesh_t), intent(in) :: raw
    type(lines_t), intent(in) :: lines(:)
    type(diagonals_t), intent(out) :: diagonals
    integer :: i, i_element, n

    n = 0
    do i_element = 1, raw%n_elements
      n = n + size(lines(element_type_of_gmsh(raw%element_types(i_element)))%diagonals, 2)
    end do
    allocate (diagonals%previous(n), diagonals%node(n), diagonals%element(n))
    allocate (diagonals%last_at_node(raw%n_nodes), source=0)
    do i_element = 1, raw%n_elements
      associate (nodes => raw%element_nodes(raw%element_offsets(i_element) + 1:raw%element_offsets(i_element + 1)), &
        own => lines(element_type_of_gmsh(raw%element_types(i_element)))%diagonals)
        do i = 1, size(own, 2)
          n = diagonals%n + 1
          diagonals%n = n
          diagonals%node(n) = maxval(nodes(own(:, i)))
          diagonals%element(n) = i_element
          associate (last => diagonals%last_at_node(minval(nodes(own(:, i)))))
            diagonals%previous(n) = last
            last = n
          end associate
        end do
      end associate
    end do
  end subroutine collect_diagonals

  !> Returns the number of a diagonal between two nodes, 0 if there is none.
  pure integer function place_of(diagonals, ends) result(i_found)
    type(diagonals_t), intent(in) :: diagonals
    integer, intent(in) :: ends(2)

    i_found = diagonals%last_at_node(minval(ends))
    do while (i_found > 0)
      if (diagonals%node(i_found) == maxval(ends)) return
      i_found = diagonals%previous(i_found)
    end do
  end function place_of
end module sig_hanging_diagonals
