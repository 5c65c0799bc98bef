! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Splits the ranks into groups that work on different parameter points.
module sig_rank_groups
  use mpi, only: MPI_Comm_free, MPI_Comm_split
  use sig_petsc_support, only: rank_and_size
  use petsc
  implicit none(type, external)
  private
  public :: rank_groups_t, create_rank_groups, number_of_groups

  !> How all ranks are divided into groups, seen from one rank.
  type :: rank_groups_t
    integer :: n_groups = 1
    !> number of all ranks
    integer :: n_ranks = 1
    !> group of this rank, 1-based
    integer :: i_group = 1
    !> communicator of this rank's group
    MPI_Comm :: comm = MPI_COMM_NULL
    !> number of this rank among all ranks and in its group, 0-based
    integer :: world_rank = 0
    integer :: group_rank = 0
  contains
    procedure :: is_leader
    procedure :: has_point
    procedure :: leader_of
    procedure :: destroy
  end type rank_groups_t

contains

  !> Returns the number of groups: the wanted number (0 = one group per rank), but no more than ranks or points, and at least 1.
  pure integer function number_of_groups(n_wanted, n_points, n_ranks) result(n_groups)
    integer, intent(in) :: n_wanted
    !> number of points to be solved
    integer, intent(in) :: n_points
    integer, intent(in) :: n_ranks

    n_groups = max(1, min(n_ranks, n_points))
    if (n_wanted > 0) n_groups = min(n_wanted, n_groups)
  end function number_of_groups

  !> Divides the ranks into groups of neighboring ranks, of nearly equal size, and makes a communicator for each group; destroy
  !> frees it. n_wanted and n_points are those of number_of_groups. Collective on all ranks.
  subroutine create_rank_groups(n_wanted, n_points, groups, ierr)
    integer, intent(in) :: n_wanted
    integer, intent(in) :: n_points
    type(rank_groups_t), intent(out) :: groups
    PetscErrorCode, intent(out) :: ierr
    integer :: n_group_ranks

    PetscCall(rank_and_size(PETSC_COMM_WORLD, groups%world_rank, groups%n_ranks, ierr))
    groups%n_groups = number_of_groups(n_wanted, n_points, groups%n_ranks)
    groups%i_group = groups%world_rank * groups%n_groups / groups%n_ranks + 1
    call MPI_Comm_split(PETSC_COMM_WORLD, groups%i_group, groups%world_rank, groups%comm, ierr)
    PetscCall(rank_and_size(groups%comm, groups%group_rank, n_group_ranks, ierr))
  end subroutine create_rank_groups

  !> Whether this rank is the first one of its group, which writes for the group.
  pure logical function is_leader(self)
    class(rank_groups_t), intent(in) :: self

    is_leader = self%group_rank == 0
  end function is_leader

  !> Whether this rank's group has a point, if points are given to the groups in turn: point 1 to group 1, point 2 to group 2, ...
  pure logical function has_point(self, i_point)
    class(rank_groups_t), intent(in) :: self
    !> 1-based among the points that are given out
    integer, intent(in) :: i_point

    has_point = modulo(i_point - 1, self%n_groups) + 1 == self%i_group
  end function has_point

  !> Returns the leader of the group that has a point by the rule of has_point, as its 0-based number among all ranks.
  pure integer function leader_of(self, i_point)
    class(rank_groups_t), intent(in) :: self
    !> as for has_point
    integer, intent(in) :: i_point

    leader_of = (modulo(i_point - 1, self%n_groups) * self%n_ranks + self%n_groups - 1) / self%n_groups
  end function leader_of

  !> Frees the communicator of the group. Collective on the group.
  subroutine destroy(self, ierr)
    class(rank_groups_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    call MPI_Comm_free(self%comm, ierr)
  end subroutine destroy
end module sig_rank_groups
