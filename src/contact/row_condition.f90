! SPDX-License-Identifier: BSD-3-Clause
!> How well forces and gaps of contact rows determine each other: the condition number of B.
!>
!> For pairs of nodes B B' is twice the identity. Rows of mortar contact may have common nodes on the second side, so that B B' is
!> not diagonal.
module sig_row_condition
  use sig_condition_number, only: condition_of_values
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  use sig_random_numbers, only: random_t
  use sig_singular_values, only: singular_values
  implicit none(type, external)
  private
  public :: condition_of_rows

contains

  !> Returns the largest over the smallest singular value [-] of B on the free displacements; 1 without rows, infinite beyond 1e6.
  !>
  !> By Lanczos steps on B B' from a random vector. Without exact orthogonality some directions occur again, but they only repeat
  !> known values (Golub and Van Loan, Matrix Computations, 10.3). The steps end if ten more change the result by less than 1e-5 of
  !> it, if only rounding is left of the next vector, and after 200 at the latest.
  function condition_of_rows(rows, is_prescribed) result(kappa)
    type(contact_rows_t), intent(in) :: rows
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    real(rk) :: kappa
    integer, parameter :: most_steps = 200, stride = 10
    !> [-] relative: of the result, of what is left of a vector, of the smallest value of B B' that counts
    real(rk), parameter :: good_enough = 1.0e-5_rk, rounding = 1.0e-13_rk, smallest = 1.0e-12_rk
    real(rk) :: before, beside, last(rows%n_rows), next(rows%n_rows), now(rows%n_rows)
    real(rk), allocatable :: matrix(:, :)
    type(contact_rows_t) :: free
    integer :: j, n_dofs, rank
    logical :: is_end

    kappa = 1
    if (rows%n_rows == 0) return
    call keep_free(rows, is_prescribed, free, n_dofs)
    allocate (matrix(most_steps + 1, most_steps + 1), source=0.0_rk)
    now = 0
    next = random_vector(rows%n_rows)
    beside = norm2(next)
    do j = 1, most_steps
      last = now
      now = next / beside
      next = free%apply(free%apply_transpose(now, n_dofs))
      if (j > 1) next = next - beside * last
      matrix(j, j) = dot_product(now, next)
      next = next - matrix(j, j) * now
      beside = norm2(next)
      is_end = beside <= rounding * maxval(abs(matrix(:j, j))) .or. j == most_steps
      if (is_end .or. mod(j, stride) == 0) then
        before = kappa
        call condition_of_values(singular_values(matrix(:j, :j)), j, smallest, kappa, rank)
        kappa = sqrt(kappa)
        if (is_end .or. abs(kappa - before) < good_enough * kappa) exit
      end if
      matrix(j, j + 1) = beside
      matrix(j + 1, j) = beside
    end do
  end function condition_of_rows

  !> Copies the rows with zeros at prescribed dofs. Only the dofs of rows get numbers, because most bodies have far more dofs.
  pure subroutine keep_free(rows, is_prescribed, free, n_dofs)
    type(contact_rows_t), intent(in) :: rows
    logical, intent(in) :: is_prescribed(:)
    type(contact_rows_t), intent(out) :: free
    !> number of the new dofs, to which free%dofs refers
    integer, intent(out) :: n_dofs
    integer :: i, numbers(size(is_prescribed))

    free = rows
    where (is_prescribed(rows%dofs)) free%coefficients = 0
    numbers = 0
    n_dofs = 0
    do i = 1, size(rows%dofs)
      if (numbers(rows%dofs(i)) == 0) then
        n_dofs = n_dofs + 1
        numbers(rows%dofs(i)) = n_dofs
      end if
      free%dofs(i) = numbers(rows%dofs(i))
    end do
  end subroutine keep_free

  function random_vector(n) result(values)
    integer, intent(in) :: n
    real(rk) :: values(n)
    type(random_t) :: random
    integer :: i

    do i = 1, n
      call random%fraction(values(i))
    end do
    values = values - 0.5_rk
  end function random_vector
end module sig_row_condition
