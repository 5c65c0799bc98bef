! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The interpolation from the linear elements with the same corners, for multigrid on quadratic elements: a node in the middle of
!> corners moves by their mean.
module sig_linear_interpolant
  use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
  use sig_contact_system, only: contact_system_t
  use petsc
  implicit none(type, external)
  private
  public :: set_linear_interpolant

  ! include/signorom/quadratic_levels.h describes this procedure in C.
  interface
    function sig_set_linear_interpolant(matrix, n_dim, n_nodes, n_corners, offsets, corners_0) result(status) bind(c)
      import :: c_int, c_intptr_t
      integer(c_intptr_t), value :: matrix
      integer(c_int), value :: n_dim, n_nodes, n_corners
      integer(c_int), intent(in) :: offsets(*), corners_0(*)
      integer(c_int) :: status
    end function sig_set_linear_interpolant
  end interface

contains

  !> Gives a matrix on all dofs, before multigrid is built for it, the interpolation from the dofs of the corners. Does nothing if
  !> all nodes are corners. Collective.
  subroutine set_linear_interpolant(system, matrix, ierr)
    type(contact_system_t), intent(in) :: system
    Mat, intent(inout) :: matrix
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: numbers_0(:), nodes(:), offsets(:), columns_0(:)
    integer :: i

    ierr = 0
    associate (map => system%map, means => system%corner_means)
      if (.not. means%has_middles()) return
      numbers_0 = number_corners(means%n_corners == 1, map%node_places_0)
      nodes = map%local_nodes()
      allocate (offsets(size(nodes) + 1), source=0)
      do i = 1, size(nodes)
        offsets(i + 1) = offsets(i) + means%n_corners(nodes(i))
      end do
      allocate (columns_0(offsets(size(offsets))))
      do i = 1, size(nodes)
        columns_0(offsets(i) + 1:offsets(i + 1)) = numbers_0(means%corners(:means%n_corners(nodes(i)), i))
      end do
      ierr = sig_set_linear_interpolant(matrix%v, map%n_dim, size(nodes), count(means%n_corners(nodes) == 1), offsets, columns_0)
    end associate
  end subroutine set_linear_interpolant

  !> Returns the number (0-based) of each corner in the order of the distributed nodes, so that those of a rank are one block; -1
  !> for other nodes.
  pure function number_corners(is_corner, places_0) result(numbers_0)
    !> of each node, natural
    logical, intent(in) :: is_corner(:)
    !> distributed number of each node, 0-based
    integer, intent(in) :: places_0(:)
    integer :: numbers_0(size(places_0))
    integer :: node_at(size(places_0)), i, n

    node_at(places_0 + 1) = [(i, i=1, size(places_0))]
    numbers_0 = -1
    n = 0
    do i = 1, size(node_at)
      if (.not. is_corner(node_at(i))) cycle
      numbers_0(node_at(i)) = n
      n = n + 1
    end do
  end function number_corners
end module sig_linear_interpolant
