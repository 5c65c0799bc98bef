! SPDX-License-Identifier: BSD-3-Clause
!> What counts as rounding. A number is rounding if it is small beside the terms of the sum that made it, never because another
!> answer is larger: so the same problem in other units, and a point where nearly nothing is loaded, are judged alike.
module sig_rounding
  use sig_kinds, only: rk
  implicit none(type, external)
  private

  !> [-] of the sizes of its terms: what sums, products and solves with a factor leave of a result that is zero. They leave 1e-16
  !> for a few terms, and up to 1e-13 for 1e5 terms or an ill-conditioned stiffness; 1e-12 is above that, and far below what an
  !> engineer looks at
  real(rk), parameter, public :: rounding = 1.0e-12_rk
  !> [-] of the sizes of its terms: the same if these were rounded before. Coordinates in mesh files and bounds in decks often have
  !> ten digits, and derivatives come from differences
  real(rk), parameter, public :: rounding_of_data = 1.0e-9_rk
  !> [-] of its length: what is left of a vector by others that it depends on, such as rigid motions that were made from such
  !> coordinates. Between 1e-9, rounding, and 1e-3, the smallest angle that bodies of an engineer have
  real(rk), parameter, public :: dependent = 1.0e-6_rk
end module sig_rounding
