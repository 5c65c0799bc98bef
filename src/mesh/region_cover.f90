! SPDX-License-Identifier: BSD-3-Clause
!> Chooses regions that cover the mesh once, where cells have several names, and finds nodes that two of them share. `signorom init`
!> needs both for a first deck.
module sig_region_cover
  use sig_element_types, only: element_types
  use sig_mesh, only: mesh_t
  implicit none(type, external)
  private
  public :: choose_regions, shared_nodes_t, find_shared_nodes

  !> Two regions with common nodes.
  type :: shared_nodes_t
    !> numbers of the groups in the mesh
    integer :: first = 0
    integer :: second = 0
    integer :: n_nodes = 0
    !> whether they also have common faces (edges in the plane): a cell of the second region has as many corners in the first one as
    !> the mesh has dimensions
    logical :: has_faces = .false.
  end type shared_nodes_t

contains

  !> Returns groups of cells without common cells, ascending: those with the fewest cells first, if they cover all cells, as the
  !> parts of an assembly do beside a group of all; otherwise those with the most cells first, if they cover more.
  pure function choose_regions(mesh) result(groups)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable :: groups(:)
    integer, allocatable :: from_largest(:)

    groups = cover(mesh, .true.)
    if (n_cells_of(mesh, groups) == mesh%n_cells) return
    from_largest = cover(mesh, .false.)
    if (n_cells_of(mesh, from_largest) > n_cells_of(mesh, groups)) groups = from_largest
  end function choose_regions

  !> Returns groups of cells without common cells, ascending, taken by their number of cells, of equal ones the first.
  pure function cover(mesh, is_smallest_first) result(groups)
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: is_smallest_first
    integer, allocatable :: groups(:)
    logical :: is_left(size(mesh%groups)), is_taken(size(mesh%groups)), is_covered(mesh%n_cells)
    integer :: i, next, sizes(size(mesh%groups))

    sizes = [(size(mesh%groups(i)%entities), i=1, size(sizes))]
    is_left = mesh%groups%n_dim == mesh%n_dim .and. sizes > 0
    is_taken = .false.
    is_covered = .false.
    do while (any(is_left))
      next = merge(minloc(sizes, dim=1, mask=is_left), maxloc(sizes, dim=1, mask=is_left), is_smallest_first)
      is_left(next) = .false.
      associate (cells => mesh%groups(next)%entities)
        if (any(is_covered(cells))) cycle
        is_covered(cells) = .true.
        is_taken(next) = .true.
      end associate
    end do
    groups = pack([(i, i=1, size(sizes))], is_taken)
  end function cover

  !> Returns the number of cells of groups without common cells.
  pure integer function n_cells_of(mesh, groups)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: groups(:)
    integer :: i

    n_cells_of = sum([(size(mesh%groups(groups(i))%entities), i=1, size(groups))])
  end function n_cells_of

  !> Finds all pairs of regions that have common nodes, in the order of `regions`.
  pure subroutine find_shared_nodes(mesh, regions, shared)
    type(mesh_t), intent(in) :: mesh
    !> numbers of groups of cells
    integer, intent(in) :: regions(:)
    type(shared_nodes_t), allocatable, intent(out) :: shared(:)
    logical :: is_in_first(mesh%n_nodes)
    integer :: i, j, n

    allocate (shared(0))
    do i = 1, size(regions)
      is_in_first = .false.
      is_in_first(mesh%groups(regions(i))%nodes) = .true.
      do j = i + 1, size(regions)
        n = count(is_in_first(mesh%groups(regions(j))%nodes))
        if (n > 0) shared = [shared, shared_nodes_t(regions(i), regions(j), n, has_common_face(mesh, regions(j), is_in_first))]
      end do
    end do
  end subroutine find_shared_nodes

  !> Whether a cell of a region has n_dim corners among the marked nodes.
  pure logical function has_common_face(mesh, region, is_marked)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: region
    logical, intent(in) :: is_marked(:)
    integer :: i, i_cell, first

    do i = 1, size(mesh%groups(region)%entities)
      i_cell = mesh%groups(region)%entities(i)
      first = mesh%cell_offsets(i_cell) + 1
      associate (corners => mesh%cell_nodes(first:first + element_types(mesh%cell_types(i_cell))%n_corners - 1))
        has_common_face = count(is_marked(corners)) >= mesh%n_dim
      end associate
      if (has_common_face) return
    end do
    has_common_face = .false.
  end function has_common_face
end module sig_region_cover
