! SPDX-License-Identifier: BSD-3-Clause
!> Random numbers that a seed repeats on every machine and rank count.
module sig_random_numbers
  use sig_base_c_interfaces, only: sig_random_below, sig_random_fraction
  use sig_kinds, only: lk, rk
  implicit none(type, external)
  private
  public :: random_t

  !> A stream of random numbers. Set the state to a seed, then draw.
  type :: random_t
    integer(lk) :: state = 0
  contains
    procedure :: fraction
    procedure :: permutation
  end type random_t

contains

  !> Draws the next random number in [0, 1).
  subroutine fraction(self, value)
    class(random_t), intent(inout) :: self
    real(rk), intent(out) :: value

    value = sig_random_fraction(self%state)
  end subroutine fraction

  !> Fills the array with the numbers 1 to size(values) in random order; every order is equally likely.
  subroutine permutation(self, values)
    class(random_t), intent(inout) :: self
    integer, intent(out) :: values(:)
    integer :: i, j

    do i = 1, size(values)
      j = 1 + sig_random_below(self%state, i)
      if (j < i) values(i) = values(j)
      values(j) = i
    end do
  end subroutine permutation
end module sig_random_numbers
