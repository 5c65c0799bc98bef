! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Proper orthogonal decomposition: the left singular vectors of the snapshots are the modes.
module sig_pod
  use sig_kinds, only: rk
  use sig_petsc_support, only: rank_and_size
  use sig_reduction_c_interfaces, only: sig_gather_rows, sig_tall_svd, sig_thin_svd
  use sig_ties, only: first_largest
  use petsc
  implicit none(type, external)
  private
  public :: compute_pod, compute_pod_of_rows

contains

  !> Thin singular value decomposition of snapshots that every rank holds; the work is shared, the result is everywhere.
  !>
  !> Collective on comm. Any number of ranks gives the same result to rounding: each vector's largest entry is positive (the
  !> lowest index within 1e-8 of the largest). Vectors whose value is rounding (below 1e-15 of the first) are arbitrary.
  subroutine compute_pod(snapshots, comm, singular_values, left_vectors, ierr)
    !> shape (n_dofs, n_snapshots), the same on all ranks
    real(rk), intent(in) :: snapshots(:, :)
    MPI_Comm, intent(in) :: comm
    !> [as snapshots] descending, shape (k), k = min(n_dofs, n_snapshots)
    real(rk), allocatable, intent(out) :: singular_values(:)
    !> [-] orthonormal columns, shape (n_dofs, k), the same on all ranks
    real(rk), allocatable, intent(out) :: left_vectors(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: rank, n_ranks, n_rows, first, last

    PetscCall(rank_and_size(comm, rank, n_ranks, ierr))
    n_rows = size(snapshots, 1)
    first = slice_end(n_rows, rank, n_ranks) + 1
    last = slice_end(n_rows, rank + 1, n_ranks)
    PetscCall(compute_pod_of_rows(snapshots(first:last, :), n_rows, comm, singular_values, left_vectors, ierr))
  end subroutine compute_pod

  !> Last row of the first i_slice of n_slices nearly equal slices, safe against overflow of a plain product.
  pure integer function slice_end(n_rows, i_slice, n_slices)
    integer, intent(in) :: n_rows
    integer, intent(in) :: i_slice
    integer, intent(in) :: n_slices

    slice_end = i_slice * (n_rows / n_slices) + min(i_slice, modulo(n_rows, n_slices))
  end function slice_end

  !> The same where each rank holds rows of its own, in rank order; ranks may hold few rows or none.
  !>
  !> Collective on comm. Tall: QR over the ranks, SVD of its triangle on each. Wide (fewer dofs than snapshots): small, so
  !> every rank decomposes the whole matrix.
  subroutine compute_pod_of_rows(local_rows, n_rows, comm, singular_values, left_vectors, ierr)
    !> shape (rows of this rank, n_snapshots)
    real(rk), intent(in), contiguous :: local_rows(:, :)
    !> rows of all ranks
    integer, intent(in) :: n_rows
    MPI_Comm, intent(in) :: comm
    real(rk), allocatable, intent(out) :: singular_values(:)
    !> all rows, the same on all ranks
    real(rk), allocatable, intent(out) :: left_vectors(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: local_left(:, :), all_rows(:, :)
    integer :: n_local, n_columns

    n_local = size(local_rows, 1)
    n_columns = size(local_rows, 2)
    allocate (singular_values(min(n_rows, n_columns)), left_vectors(n_rows, min(n_rows, n_columns)))
    if (n_columns <= n_rows) then
      allocate (local_left(n_local, n_columns))
      ierr = sig_tall_svd(comm, n_local, n_columns, local_rows, singular_values, local_left)
      CHKERRQ(ierr)
      ierr = sig_gather_rows(comm, n_local, n_rows, n_columns, local_left, left_vectors)
      CHKERRQ(ierr)
    else
      allocate (all_rows(n_rows, n_columns))
      ierr = sig_gather_rows(comm, n_local, n_rows, n_columns, local_rows, all_rows)
      CHKERRQ(ierr)
      ierr = sig_thin_svd(n_rows, n_columns, all_rows, singular_values, left_vectors)
      CHKERRQ(ierr)
    end if
    call fix_signs(left_vectors)
  end subroutine compute_pod_of_rows

  !> A singular vector has no sign: make its largest entry positive, of nearly equal ones that of the lowest index.
  pure subroutine fix_signs(vectors)
    real(rk), intent(inout) :: vectors(:, :)
    integer :: i_column, i_row

    do i_column = 1, size(vectors, 2)
      i_row = first_largest(abs(vectors(:, i_column)))
      if (vectors(i_row, i_column) < 0) vectors(:, i_column) = -vectors(:, i_column)
    end do
  end subroutine fix_signs
end module sig_pod
