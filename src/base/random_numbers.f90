! SPDX-License-Identifier: BSD-3-Clause
!> Random numbers that a seed repeats on every machine and rank count.
module sig_random_numbers
  use, intrinsic :: iso_c_binding, only: c_double, c_int, c_int64_t
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

  ! include/signorom/random_numbers.h describes these procedures in C.
  interface
    function sig_random_fraction(state) result(value) bind(c)
      import :: c_double, c_int64_t
      integer(c_int64_t), intent(inout) :: state
      real(c_double) :: value
    end function sig_random_fraction

    function sig_random_below(state, n) result(value) bind(c)
      import :: c_int, c_int64_t
      integer(c_int64_t), intent(inout) :: state
      integer(c_int), value :: n
      integer(c_int) :: value
    end function sig_random_below
  end interface

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
