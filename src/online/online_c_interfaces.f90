! SPDX-License-Identifier: BSD-3-Clause
!> Interfaces of the online layer's C procedures; documented in include/signorom/.
module sig_online_c_interfaces
  use, intrinsic :: iso_c_binding, only: c_double, c_int, c_ptr
  implicit none(type, external)
  private
  public :: forest_arrays_t, sig_forest_check, sig_forest_votes

  !> The structure sig_forest of forest.h; its pointers refer to arrays of a forest_t.
  type, bind(c) :: forest_arrays_t
    integer(c_int) :: n_features
    integer(c_int) :: n_classes
    integer(c_int) :: n_trees
    type(c_ptr) :: tree_starts
    type(c_ptr) :: feature
    type(c_ptr) :: threshold
    type(c_ptr) :: left
    type(c_ptr) :: right
    type(c_ptr) :: values
  end type forest_arrays_t

  interface
    integer(c_int) function sig_forest_check(forest) bind(c)
      import :: c_int, forest_arrays_t
      implicit none(type, external)
      type(forest_arrays_t), intent(in) :: forest
    end function sig_forest_check

    subroutine sig_forest_votes(forest, point, votes) bind(c)
      import :: c_double, forest_arrays_t
      implicit none(type, external)
      type(forest_arrays_t), intent(in) :: forest
      real(c_double), intent(in) :: point(*)
      real(c_double), intent(out) :: votes(*)
    end subroutine sig_forest_votes
  end interface
end module sig_online_c_interfaces
