! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Proper orthogonal decomposition: the left singular vectors of the snapshots are the modes.
!>
!> Tall: QR over the ranks, SVD of its triangle on each. Wide (fewer dofs than snapshots): small, so every rank decomposes the
!> whole matrix. The snapshots are handed over one by one and kept once, spread over the ranks.
module sig_pod
  use, intrinsic :: iso_c_binding, only: c_intptr_t
  use sig_kinds, only: rk
  use sig_petsc_support, only: rank_and_size
  use sig_reduction_c_interfaces, only: sig_gather_rows, sig_snapshot_svd_create, sig_snapshot_svd_decompose, &
    sig_snapshot_svd_destroy, sig_snapshot_svd_left, sig_snapshot_svd_set_column, sig_snapshot_svd_triangle, sig_thin_svd
  use sig_ties, only: first_largest
  use petsc
  implicit none(type, external)
  private
  public :: pod_t, compute_pod, compute_pod_of_rows, rows_of_rank

  !> A decomposition on its way: create, set_snapshot for each, decompose or triangle, left_vectors once, destroy.
  type :: pod_t
    !> [as snapshots] descending, after decompose; shape (min(n_rows, n_snapshots))
    real(rk), allocatable :: singular_values(:)
    MPI_Comm, private :: comm
    integer, private :: n_rows = 0
    integer, private :: n_local = 0
    !> tall
    integer(c_intptr_t), private :: svd = 0
    !> wide: rows of this rank, then the left vectors
    real(rk), allocatable, private :: wide(:, :)
  contains
    procedure :: create
    procedure :: set_snapshot
    procedure :: triangle
    procedure :: decompose
    procedure :: left_vectors
    procedure :: destroy
  end type pod_t

contains

  !> Collective on comm. Ranks may hold few rows or none.
  subroutine create(self, n_local, n_rows, n_snapshots, comm, ierr)
    class(pod_t), intent(out) :: self
    !> rows of this rank, of all ranks
    integer, intent(in) :: n_local
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_snapshots
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    self%comm = comm
    self%n_rows = n_rows
    self%n_local = n_local
    allocate (self%singular_values(min(n_rows, n_snapshots)), source=0.0_rk)
    if (n_snapshots > n_rows) then
      allocate (self%wide(n_local, n_snapshots))
    else
      ierr = sig_snapshot_svd_create(comm, n_local, n_snapshots, self%svd)
    end if
  end subroutine create

  !> One snapshot. Collective.
  subroutine set_snapshot(self, i, rows, ierr)
    class(pod_t), intent(inout) :: self
    !> 1-based
    integer, intent(in) :: i
    !> those of this rank, shape (n_local)
    real(rk), intent(in), contiguous :: rows(:)
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (allocated(self%wide)) then
      self%wide(:, i) = rows
    else
      ierr = sig_snapshot_svd_set_column(self%svd, i - 1, rows)
    end if
  end subroutine set_snapshot

  !> The snapshots in an orthonormal basis of what they span, with zeros below the diagonal; for tall matrices only. Collective.
  subroutine triangle(self, coordinates, ierr)
    class(pod_t), intent(inout) :: self
    !> [as snapshots] shape (n_snapshots, n_snapshots), the same on all ranks
    real(rk), allocatable, intent(out) :: coordinates(:, :)
    PetscErrorCode, intent(out) :: ierr

    allocate (coordinates(size(self%singular_values), size(self%singular_values)), source=0.0_rk)
    ierr = sig_snapshot_svd_triangle(self%svd, coordinates)
  end subroutine triangle

  !> Finds the singular values. Collective.
  subroutine decompose(self, ierr)
    class(pod_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: rows(:, :)

    if (.not. allocated(self%wide)) then
      ierr = sig_snapshot_svd_decompose(self%svd, self%singular_values)
      return
    end if
    allocate (rows(self%n_rows, size(self%wide, 2)))
    ierr = sig_gather_rows(self%comm, self%n_local, self%n_rows, size(rows, 2), self%wide, rows)
    CHKERRQ(ierr)
    deallocate (self%wide)
    allocate (self%wide(self%n_rows, self%n_rows))
    ierr = sig_thin_svd(self%n_rows, size(rows, 2), rows, self%singular_values, self%wide)
  end subroutine decompose

  !> The first left singular vectors, all rows of them on every rank. Collective.
  !>
  !> Any number of ranks gives the same result to rounding: each vector's largest entry is positive (the lowest index within
  !> 1e-8 of the largest). Vectors whose value is rounding (below 1e-15 of the first) are arbitrary.
  subroutine left_vectors(self, n_vectors, vectors, ierr)
    class(pod_t), intent(inout) :: self
    integer, intent(in) :: n_vectors
    !> [-] orthonormal columns, shape (n_rows, n_vectors), the same on all ranks
    real(rk), allocatable, intent(out) :: vectors(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: local(:, :)

    if (allocated(self%wide)) then
      ierr = 0
      vectors = self%wide(:, :n_vectors)
    else
      allocate (local(self%n_local, n_vectors), vectors(self%n_rows, n_vectors))
      ierr = sig_snapshot_svd_left(self%svd, n_vectors, local)
      CHKERRQ(ierr)
      ierr = sig_gather_rows(self%comm, self%n_local, self%n_rows, n_vectors, local, vectors)
      CHKERRQ(ierr)
    end if
    call fix_signs(vectors)
  end subroutine left_vectors

  !> A singular vector has no sign: make its largest entry positive, of nearly equal ones that of the lowest index.
  pure subroutine fix_signs(vectors)
    real(rk), intent(inout) :: vectors(:, :)
    integer :: i_column, i_row

    do i_column = 1, size(vectors, 2)
      i_row = first_largest(abs(vectors(:, i_column)))
      if (vectors(i_row, i_column) < 0) vectors(:, i_column) = -vectors(:, i_column)
    end do
  end subroutine fix_signs

  !> Collective.
  subroutine destroy(self, ierr)
    class(pod_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (self%svd /= 0) ierr = sig_snapshot_svd_destroy(self%svd)
  end subroutine destroy

  !> First and last of the rows that a rank takes of a matrix which all ranks hold: nearly equal slices.
  subroutine rows_of_rank(n_rows, comm, first, last, ierr)
    integer, intent(in) :: n_rows
    MPI_Comm, intent(in) :: comm
    integer, intent(out) :: first
    integer, intent(out) :: last
    PetscErrorCode, intent(out) :: ierr
    integer :: n_ranks, rank

    first = 0
    last = 0
    PetscCall(rank_and_size(comm, rank, n_ranks, ierr))
    first = slice_end(n_rows, rank, n_ranks) + 1
    last = slice_end(n_rows, rank + 1, n_ranks)
  end subroutine rows_of_rank

  !> Last row of the first i_slice of n_slices nearly equal slices, safe against overflow of a plain product.
  pure integer function slice_end(n_rows, i_slice, n_slices)
    integer, intent(in) :: n_rows
    integer, intent(in) :: i_slice
    integer, intent(in) :: n_slices

    slice_end = i_slice * (n_rows / n_slices) + min(i_slice, modulo(n_rows, n_slices))
  end function slice_end

  !> Thin singular value decomposition of snapshots that every rank holds; the work is shared, the result is everywhere.
  !> Collective on comm.
  subroutine compute_pod(snapshots, comm, singular_values, vectors, ierr)
    !> shape (n_rows, n_snapshots), the same on all ranks
    real(rk), intent(in) :: snapshots(:, :)
    MPI_Comm, intent(in) :: comm
    !> [as snapshots] descending, shape (k), k = min(n_rows, n_snapshots)
    real(rk), allocatable, intent(out) :: singular_values(:)
    !> [-] as of left_vectors, shape (n_rows, k)
    real(rk), allocatable, intent(out) :: vectors(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: first, last

    PetscCall(rows_of_rank(size(snapshots, 1), comm, first, last, ierr))
    PetscCall(compute_pod_of_rows(snapshots(first:last, :), size(snapshots, 1), comm, singular_values, vectors, ierr))
  end subroutine compute_pod

  !> The same where each rank holds rows of its own, in rank order; ranks may hold few rows or none. Collective on comm.
  subroutine compute_pod_of_rows(local_rows, n_rows, comm, singular_values, vectors, ierr)
    !> shape (rows of this rank, n_snapshots)
    real(rk), intent(in), contiguous :: local_rows(:, :)
    !> rows of all ranks
    integer, intent(in) :: n_rows
    MPI_Comm, intent(in) :: comm
    real(rk), allocatable, intent(out) :: singular_values(:)
    real(rk), allocatable, intent(out) :: vectors(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(pod_t) :: pod
    integer :: i

    PetscCall(pod%create(size(local_rows, 1), n_rows, size(local_rows, 2), comm, ierr))
    do i = 1, size(local_rows, 2)
      PetscCall(pod%set_snapshot(i, local_rows(:, i), ierr))
    end do
    PetscCall(pod%decompose(ierr))
    PetscCall(pod%left_vectors(size(pod%singular_values), vectors, ierr))
    call move_alloc(pod%singular_values, singular_values)
    PetscCall(pod%destroy(ierr))
  end subroutine compute_pod_of_rows
end module sig_pod
