! SPDX-License-Identifier: BSD-3-Clause
!> Latin hypercubes: the range of each parameter is cut into as many slices as there are points, and each slice has one point.
module sig_latin_hypercube
  use sig_kinds, only: rk
  use sig_random_numbers, only: random_t
  implicit none(type, external)
  private
  public :: latin_hypercube_points

contains

  !> Returns random points in the unit box. The range of each parameter is cut into n_points slices of equal length, and each slice
  !> has one point; each parameter has its slices in another random order.
  !>
  !> Source: McKay, Beckman and Conover, Technometrics 21 (1979) 239. The same seed gives the same points.
  function latin_hypercube_points(n_parameters, n_points, seed) result(points)
    integer, intent(in) :: n_parameters
    integer, intent(in) :: n_points
    !> of the random numbers
    integer, intent(in) :: seed
    !> [-] in [0, 1), shape (n_parameters, n_points)
    real(rk) :: points(n_parameters, n_points)
    integer :: i_parameter, i_point, slices(n_points)
    real(rk) :: fraction
    type(random_t) :: random

    random%state = seed
    do i_parameter = 1, n_parameters
      call random%permutation(slices)
      do i_point = 1, n_points
        call random%fraction(fraction)
        points(i_parameter, i_point) = (slices(i_point) - 1 + fraction) / n_points
      end do
    end do
  end function latin_hypercube_points
end module sig_latin_hypercube
