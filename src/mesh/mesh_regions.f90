! SPDX-License-Identifier: BSD-3-Clause
!> Numbers the named regions for files: 1, 2, ... in the order of the mesh's groups.
module sig_mesh_regions
  use sig_mesh, only: mesh_t
  use sig_text, only: append_text, string_t
  implicit none(type, external)
  private
  public :: region_names, regions_of_cells

contains

  !> Returns the names of the regions, that is, of the groups of cells, in the order of the mesh's groups.
  pure function region_names(mesh) result(names)
    type(mesh_t), intent(in) :: mesh
    type(string_t), allocatable :: names(:)
    integer :: i

    allocate (names(0))
    do i = 1, size(mesh%groups)
      if (mesh%groups(i)%n_dim == mesh%n_dim) call append_text(names, mesh%groups(i)%name)
    end do
  end function region_names

  !> Returns the number of the region of each cell, its 1-based place in region_names; a cell of several regions gets the lowest
  !> number.
  pure function regions_of_cells(mesh) result(regions)
    type(mesh_t), intent(in) :: mesh
    integer :: regions(mesh%n_cells)
    integer :: i, i_region

    regions = 0
    i_region = count(mesh%groups%n_dim == mesh%n_dim)
    do i = size(mesh%groups), 1, -1
      if (mesh%groups(i)%n_dim /= mesh%n_dim) cycle
      regions(mesh%groups(i)%entities) = i_region
      i_region = i_region - 1
    end do
  end function regions_of_cells
end module sig_mesh_regions
