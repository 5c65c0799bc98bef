! SPDX-License-Identifier: BSD-3-Clause
!> Choices that rounding must not decide: the number of ranks changes the last bits of what is compared.
module sig_ties
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: first_largest

  !> [-] values this close (relative) are equal
  real(rk), parameter, public :: tie_tolerance = 1.0e-8_rk

contains

  !> Lowest index of the largest values, which are equal to 1e-8; the last one where no value is a number.
  !>
  !> Requires: a value, and the largest >= 0.
  pure integer function first_largest(values) result(i_first)
    real(rk), intent(in) :: values(:)

    i_first = findloc(values >= (1 - tie_tolerance) * maxval(values), .true., dim=1)
    if (i_first == 0) i_first = size(values)
  end function first_largest
end module sig_ties
