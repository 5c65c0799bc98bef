! SPDX-License-Identifier: BSD-3-Clause
!> Choices between values that are equal except for rounding. They must not depend on the number of ranks, which changes the last
!> bits of the values.
module sig_ties
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: first_largest

  !> [-] relative difference up to which values count as equal
  real(rk), parameter, public :: tie_tolerance = 1.0e-8_rk

contains

  !> Returns the lowest index of the largest values. Values that differ by at most 1e-8 relative count as equal. NaN values do not
  !> count; if all are NaN, returns the last index.
  !> Requires: at least one value; the largest one is at least 0, unless all are NaN.
  pure integer function first_largest(values) result(i_first)
    real(rk), intent(in) :: values(:)

    i_first = findloc(values >= (1 - tie_tolerance) * maxval(values), .true., dim=1)
    if (i_first == 0) i_first = size(values)
  end function first_largest
end module sig_ties
