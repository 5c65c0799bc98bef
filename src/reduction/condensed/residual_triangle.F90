! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Columns in a basis that is orthonormal in the norm of K: a small triangle that has the norms of all their combinations.
!>
!> Gram and Schmidt's method, many columns at a time first, then each as often as rounding needs. A combination that is far smaller
!> than its parts keeps its digits, which the matrix of products of the columns would lose.
module sig_residual_triangle
  use sig_kinds, only: rk
  use sig_linear_algebra, only: add_product, transposed_product
  use sig_petsc_support, only: multiply_block, sum_over_ranks
  use petsc
  implicit none(type, external)
  private
  public :: find_triangle

  !> columns at a time
  integer, parameter :: chunk = 32
  !> [-] what is left of a column below this is rounding of the solves
  real(rk), parameter :: dependent = 1.0e-13_rk
  !> each takes away twelve digits or is the last
  integer, parameter :: most_passes = 5

  !> The basis on its way, rows of this rank.
  type :: basis_t
    integer :: n = 0
    !> columns, and K times these
    real(rk), allocatable :: columns(:, :)
    real(rk), allocatable :: products(:, :)
  end type basis_t

contains

  !> Finds the upper triangle R of y_j = sum_i q_i R(i, j) with q_i'K q_k = 1 for i = k and 0 otherwise. Dependent columns make
  !> fewer q than columns; the remaining rows of R are then zero.
  !> Collective on comm.
  subroutine find_triangle(comm, stiffness, columns, triangle, ierr)
    MPI_Comm, intent(in) :: comm
    !> [force/length] K, positive definite on the columns
    Mat, intent(in) :: stiffness
    !> [length] rows of this rank, shape (n_local, n)
    real(rk), contiguous, intent(in) :: columns(:, :)
    !> [sqrt(force*length)] shape (n, n)
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

  !> Takes away what the basis spans. Collective.
  subroutine remove(comm, basis, block, triangle, ierr)
    MPI_Comm, intent(in) :: comm
    type(basis_t), intent(in) :: basis
    real(rk), contiguous, intent(inout) :: block(:, :)
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

  !> Columns that the basis did not span before, one by one. What shrinks is full of rounding that the basis spans: it is taken away
  !> again. Collective.
  subroutine append_columns(comm, stiffness, block, sizes, basis, triangle, ierr)
    MPI_Comm, intent(in) :: comm
    Mat, intent(in) :: stiffness
    real(rk), contiguous, intent(inout) :: block(:, :)
    !> [force*length] squares of the norms of the whole columns
    real(rk), intent(in) :: sizes(:)
    type(basis_t), intent(inout) :: basis
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
