! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Dissimilarities of all pairs of subspaces or snapshots. The ranks share the pairs. Snapshots are represented by few coordinates
!> instead of all dofs.
module sig_dissimilarity
  use sig_grassmann, only: snapshot_angle, subspace_distance, subspace_t
  use sig_kinds, only: rk
  use sig_petsc_support, only: rank_and_size, sum_over_ranks
  use sig_pod, only: pod_t, sig_gather_rows
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: snapshot_coordinates, dissimilarity_of_subspaces, dissimilarity_of_snapshots

contains

  !> Returns the coordinates of the snapshots in an orthonormal basis of their span. Angles and lengths are the same as of the
  !> snapshots, but the cost of comparisons does not depend on the number of dofs.
  !>
  !> The coordinates are the triangle of one thin QR; where there are not more dofs than snapshots, they are the snapshots
  !> themselves. Collective on comm, over which the dofs are spread.
  subroutine snapshot_coordinates(snapshots, comm, coordinates, ierr)
    type(training_set_t), intent(in) :: snapshots
    MPI_Comm, intent(in) :: comm
    !> [as snapshots] shape (min(n_dofs, n_snapshots), n_snapshots), the same on all ranks
    real(rk), allocatable, intent(out) :: coordinates(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(pod_t) :: pod
    integer :: i, n

    n = snapshots%n_snapshots()
    if (snapshots%n_dofs <= n) then
      PetscCall(gather_fields(snapshots, comm, coordinates, ierr))
      return
    end if
    PetscCall(pod%create(snapshots%n_own, snapshots%n_dofs, n, comm, ierr))
    do i = 1, n
      PetscCall(pod%set_snapshot(i, snapshots%displacement(i)%values, ierr))
    end do
    PetscCall(pod%triangle(coordinates, ierr))
    PetscCall(pod%destroy(ierr))
  end subroutine snapshot_coordinates

  !> Gathers all dofs of all snapshots on every rank, for snapshots of few dofs. Collective on comm.
  subroutine gather_fields(snapshots, comm, fields, ierr)
    type(training_set_t), intent(in) :: snapshots
    MPI_Comm, intent(in) :: comm
    !> [length] displacements, shape (n_dofs, n_snapshots), the same on all ranks
    real(rk), allocatable, intent(out) :: fields(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: own(:, :)
    integer :: i

    allocate (own(snapshots%n_own, snapshots%n_snapshots()))
    do i = 1, size(own, 2)
      own(:, i) = snapshots%displacement(i)%values
    end do
    allocate (fields(snapshots%n_dofs, size(own, 2)))
    ierr = sig_gather_rows(comm, size(own, 1), size(fields, 1), size(fields, 2), own, fields)
  end subroutine gather_fields

  !> Computes the distances (13) of all pairs of subspaces, a symmetric matrix with a zero diagonal. Collective on comm.
  subroutine dissimilarity_of_subspaces(subspaces, comm, dissimilarity, ierr)
    !> the same on all ranks
    type(subspace_t), intent(in) :: subspaces(:)
    MPI_Comm, intent(in) :: comm
    !> [rad] shape (n, n), the same on all ranks
    real(rk), allocatable, intent(out) :: dissimilarity(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: i, j, n_ranks, rank

    allocate (dissimilarity(size(subspaces), size(subspaces)), source=0.0_rk)
    PetscCall(rank_and_size(comm, rank, n_ranks, ierr))
    do j = rank + 1, size(subspaces), n_ranks
      do i = j + 1, size(subspaces)
        dissimilarity(i, j) = subspace_distance(subspaces(i), subspaces(j))
      end do
    end do
    PetscCall(complete_columns(comm, dissimilarity, ierr))
  end subroutine dissimilarity_of_subspaces

  !> Computes the angles (16) of all pairs of snapshots, a symmetric matrix with a zero diagonal. Collective on comm.
  subroutine dissimilarity_of_snapshots(coordinates, is_signed, comm, dissimilarity, ierr)
    !> snapshot_coordinates, no column zero, shape (n_coordinates, n_snapshots), the same on all ranks
    real(rk), intent(in) :: coordinates(:, :)
    !> the angle between opposite snapshots is pi, as (16) is printed; otherwise it is 0
    logical, intent(in) :: is_signed
    MPI_Comm, intent(in) :: comm
    !> [rad] shape (n_snapshots, n_snapshots), the same on all ranks
    real(rk), allocatable, intent(out) :: dissimilarity(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: directions(:, :)
    integer :: i, j, n, n_ranks, rank

    n = size(coordinates, 2)
    directions = coordinates
    do j = 1, n
      directions(:, j) = coordinates(:, j) / norm2(coordinates(:, j))
    end do
    allocate (dissimilarity(n, n), source=0.0_rk)
    PetscCall(rank_and_size(comm, rank, n_ranks, ierr))
    do j = rank + 1, n, n_ranks
      do i = j + 1, n
        dissimilarity(i, j) = snapshot_angle(directions(:, i), directions(:, j), is_signed)
      end do
    end do
    PetscCall(complete_columns(comm, dissimilarity, ierr))
  end subroutine dissimilarity_of_snapshots

  !> Gives every rank the whole symmetric matrix. Before, each rank has some columns of the lower triangle, and zeros elsewhere.
  !> Collective on comm.
  subroutine complete_columns(comm, matrix, ierr)
    MPI_Comm, intent(in) :: comm
    !> shape (n, n)
    real(rk), intent(inout) :: matrix(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: j

    ierr = 0
    do j = 1, size(matrix, 2)
      PetscCall(sum_over_ranks(comm, matrix(j + 1:, j), ierr))
      matrix(j, j + 1:) = matrix(j + 1:, j)
    end do
  end subroutine complete_columns
end module sig_dissimilarity
