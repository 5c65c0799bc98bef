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

  type :: rank_groups_t
    integer :: n_groups = 1
    integer :: n_ranks = 1
    !> 1-based
    integer :: i_group = 1
    !> communicator of this rank's group
    MPI_Comm :: comm = MPI_COMM_NULL
    !> rank in all ranks and in the group, 0-based
    integer :: world_rank = 0
    integer :: group_rank = 0
  contains
    procedure :: is_leader
    procedure :: has_point
    procedure :: leader_of
    procedure :: destroy
  end type rank_groups_t

contains

  !> Wanted groups, 0 meaning one per rank; never more than there are ranks or points.
  pure integer function number_of_groups(n_wanted, n_points, n_ranks) result(n_groups)
    integer, intent(in) :: n_wanted
    integer, intent(in) :: n_points
    integer, intent(in) :: n_ranks

    n_groups = max(1, min(n_ranks, n_points))
    if (n_wanted > 0) n_groups = min(n_wanted, n_groups)
  end function number_of_groups

  !> Divides the ranks into groups of neighboring ranks. The arguments are those of number_of_groups. Collective on all ranks.
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

  !> Whether this rank writes for its group.
  pure logical function is_leader(self)
    class(rank_groups_t), intent(in) :: self

    is_leader = self%group_rank == 0
  end function is_leader

  !> Whether this group solves the point: points are dealt in turn.
  pure logical function has_point(self, i_point)
    class(rank_groups_t), intent(in) :: self
    !> 1-based among those that are left to do
    integer, intent(in) :: i_point

    has_point = modulo(i_point - 1, self%n_groups) + 1 == self%i_group
  end function has_point

  !> The leader of the group that has a point, as a rank of all ranks.
  pure integer function leader_of(self, i_point)
    class(rank_groups_t), intent(in) :: self
    !> as for has_point
    integer, intent(in) :: i_point

    leader_of = (modulo(i_point - 1, self%n_groups) * self%n_ranks + self%n_groups - 1) / self%n_groups
  end function leader_of

  subroutine destroy(self, ierr)
    class(rank_groups_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    call MPI_Comm_free(self%comm, ierr)
  end subroutine destroy
end module sig_rank_groups
