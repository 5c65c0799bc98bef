! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Computes the coordinates of columns in a basis that is orthonormal in the norm of K. They are a small triangular matrix R. The
!> norm of any combination of the columns is the Euclidean norm of the same combination of the columns of R.
!>
!> The method is Gram-Schmidt, first for many columns at a time, then for each column as often as rounding requires. The norm of a
!> combination that is much smaller than its parts stays exact; with the matrix of the products of the columns it would not.
module sig_residual_triangle
  use sig_kinds, only: rk
  use sig_linear_algebra, only: add_product, transposed_product
  use sig_petsc_support, only: multiply_block, sum_over_ranks
  use petsc
  implicit none(type, external)
  private
  public :: find_triangle

  !> number of columns at a time
  integer, parameter :: chunk = 32
  !> [-] a rest of at most this fraction of the norm of the column is rounding of the solves
  real(rk), parameter :: dependent = 1.0e-13_rk
  !> most passes for a column; a pass is the last one unless it makes the rest much smaller
  integer, parameter :: most_passes = 5

  !> The basis vectors found so far: the rows of this rank.
  type :: basis_t
    integer :: n = 0
    !> basis vectors, and K times these
    real(rk), allocatable :: columns(:, :)
    real(rk), allocatable :: products(:, :)
  end type basis_t

contains

  !> Computes the matrix R of y_j = sum_i q_i R(i, j), where y_j are the columns and q_i'K q_k = 1 for i = k and 0 otherwise.
  !> Dependent columns add no basis vector, so there can be fewer q than columns; the remaining rows of R are zero. Collective on
  !> comm.
  subroutine find_triangle(comm, stiffness, columns, triangle, ierr)
    MPI_Comm, intent(in) :: comm
    !> [force/length] K, positive definite on the columns
    Mat, intent(in) :: stiffness
    !> [length] rows of this rank, shape (n_local, n)
    real(rk), contiguous, intent(in) :: columns(:, :)
    !> R [sqrt(force*length)], upper triangle, shape (n, n)
    real(rk), allocatable, intent(out) :: triangle(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(basis_t) :: basis
    real(rk), allocatable :: block(:, :), products(:, :), sizes(:, :)
    integer :: first, last

    ierr = 0
    allocate (triangle(size(columns, 2), size(columns, 2)), source=0.0_rk)
    allocate (basis%columns, mold=columns)
    allocate (basis%products, mold=columns)
    do first = 1, size(columns, 2), chunk
      last = min(first + chunk - 1, size(columns, 2))
      block = columns(:, first:last)
      allocate (products, mold=block)
      PetscCall(multiply_block(stiffness, block, products, ierr))
      sizes = reshape(sum(block * products, dim=1), [last - first + 1, 1])
      PetscCall(sum_over_ranks(comm, sizes, ierr))
      deallocate (products)
      PetscCall(remove(comm, basis, block, triangle(:, first:last), ierr))
      PetscCall(append_columns(comm, stiffness, block, sizes(:, 1), basis, triangle(:, first:last), ierr))
    end do
  end subroutine find_triangle

  !> Subtracts from the columns of a block their projection on the basis, and adds the coordinates of the projection to the
  !> triangle. Does nothing while the basis is empty. Collective on comm.
  subroutine remove(comm, basis, block, triangle, ierr)
    MPI_Comm, intent(in) :: comm
    type(basis_t), intent(in) :: basis
    !> [length] rows of this rank
    real(rk), contiguous, intent(inout) :: block(:, :)
    !> columns of R that belong to the block
    real(rk), intent(inout) :: triangle(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: shares(:, :)

    ierr = 0
    if (basis%n == 0) return
    shares = transposed_product(basis%products(:, :basis%n), block)
    PetscCall(sum_over_ranks(comm, shares, ierr))
    call add_product(-1.0_rk, basis%columns(:, :basis%n), shares, block)
    triangle(:basis%n, :) = triangle(:basis%n, :) + shares
  end subroutine remove

  !> Adds the columns of a block to the basis, one by one, without their projection on it. A column of which at most 1e-13 is left
  !> depends on the basis and is not added. Where a projection makes a column much smaller, rounding leaves a part in the span of
  !> the basis; the projection is then repeated, at most four times. Collective on comm.
  subroutine append_columns(comm, stiffness, block, sizes, basis, triangle, ierr)
    MPI_Comm, intent(in) :: comm
    Mat, intent(in) :: stiffness
    !> [length] rows of this rank; changed
    real(rk), contiguous, intent(inout) :: block(:, :)
    !> [force*length] squares of the norms of the whole columns
    real(rk), intent(in) :: sizes(:)
    type(basis_t), intent(inout) :: basis
    !> columns of R that belong to the block
    real(rk), intent(inout) :: triangle(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: product(size(block, 1), 1), square(1), square_before
    integer :: i, pass

    ierr = 0
    do i = 1, size(block, 2)
      square = sizes(i)
      do pass = 1, most_passes
        square_before = square(1)
        PetscCall(remove(comm, basis, block(:, i:i), triangle(:, i:i), ierr))
        PetscCall(multiply_block(stiffness, block(:, i:i), product, ierr))
        square = dot_product(block(:, i), product(:, 1))
        PetscCall(sum_over_ranks(comm, square, ierr))
        if (square(1) >= square_before / 4 .or. square(1) <= dependent**2 * sizes(i)) exit
      end do
      if (square(1) <= dependent**2 * sizes(i)) cycle
      basis%n = basis%n + 1
      triangle(basis%n, i) = sqrt(square(1))
      basis%columns(:, basis%n) = block(:, i) / sqrt(square(1))
      basis%products(:, basis%n) = product(:, 1) / sqrt(square(1))
    end do
  end subroutine append_columns
end module sig_residual_triangle
