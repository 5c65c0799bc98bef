! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Euclidean norms of displacement snapshots whose dofs are spread over the ranks, and a search for equal snapshots.
module sig_snapshot_lengths
  use sig_kinds, only: rk
  use sig_petsc_support, only: sum_over_ranks
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: find_identical, snapshot_lengths

contains

  !> Computes the Euclidean norm of each displacement, the same on all ranks. Collective on comm, over which the dofs are spread.
  subroutine snapshot_lengths(snapshots, comm, lengths, ierr)
    type(training_set_t), intent(in) :: snapshots
    MPI_Comm, intent(in) :: comm
    !> [length] shape (n_snapshots)
    real(rk), allocatable, intent(out) :: lengths(:)
    PetscErrorCode, intent(out) :: ierr
    integer :: i

    allocate (lengths(snapshots%n_snapshots()))
    do i = 1, size(lengths)
      lengths(i) = norm2(snapshots%displacement(i)%values)**2
    end do
    PetscCall(sum_over_ranks(comm, lengths, ierr))
    lengths = sqrt(lengths)
  end subroutine snapshot_lengths

  !> Finds the first snapshot that equals an earlier one, up to 1e-14 of its norm, and the first of these earlier ones. Both numbers
  !> are 0 where all differ. Collective on comm.
  !>
  !> Equal snapshots are no error, and k-medoids accepts them: a load on whole edges can be the same at two parameter points.
  subroutine find_identical(snapshots, lengths, comm, i_snapshot, i_earlier, ierr)
    type(training_set_t), intent(in) :: snapshots
    !> [length] from snapshot_lengths
    real(rk), intent(in) :: lengths(:)
    MPI_Comm, intent(in) :: comm
    !> numbers of the snapshot and of the earlier one, 1-based
    integer, intent(out) :: i_snapshot
    integer, intent(out) :: i_earlier
    PetscErrorCode, intent(out) :: ierr
    real(rk), parameter :: rounding = 1.0e-14_rk
    integer, allocatable :: alike(:)
    real(rk), allocatable :: differences(:)
    integer :: i, k

    ierr = 0
    i_earlier = 0
    do i_snapshot = 2, size(lengths)
      associate (length => lengths(i_snapshot), field => snapshots%displacement(i_snapshot)%values)
        alike = pack([(i, i=1, i_snapshot - 1)], abs(length - lengths(:i_snapshot - 1)) <= rounding * length)
        if (size(alike) == 0) cycle
        differences = [(norm2(field - snapshots%displacement(alike(i))%values)**2, i=1, size(alike))]
        PetscCall(sum_over_ranks(comm, differences, ierr))
        k = findloc(sqrt(differences) <= rounding * length, .true., dim=1)
        if (k == 0) cycle
        i_earlier = alike(k)
        return
      end associate
    end do
    i_snapshot = 0
  end subroutine find_identical
end module sig_snapshot_lengths
