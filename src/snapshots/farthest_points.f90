! SPDX-License-Identifier: BSD-3-Clause
!> Chooses a few points of a set that are far from each other.
module sig_farthest_points
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: farthest_points

contains

  !> Returns the numbers of n_wanted points: first the point nearest to the middle of the box, then each time the point that is
  !> farthest from the chosen ones; of distances that are equal up to rounding the first point. No number is chosen twice, but a
  !> point equal to a chosen one may be chosen. Distances are Euclidean, after the box was scaled to sides of length 1.
  pure function farthest_points(points, box, n_wanted) result(chosen)
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> minimum and larger maximum of each parameter, shape (2, n_parameters)
    real(rk), intent(in) :: box(:, :)
    !> 0 to n_points
    integer, intent(in) :: n_wanted
    !> numbers of the points, 1-based
    integer :: chosen(n_wanted)
    real(rk) :: distances(size(points, 2))
    integer :: i

    if (n_wanted < 1) return
    chosen(1) = first_of(-squares(points, box, sum(box, dim=1) / 2))
    distances = huge(1.0_rk)
    do i = 1, n_wanted - 1
      distances = min(distances, squares(points, box, points(:, chosen(i))))
      ! so that a point at the same place as a chosen one may still be chosen
      distances(chosen(:i)) = -1
      chosen(i + 1) = first_of(distances)
    end do
  end function farthest_points

  !> Returns the squared distances of the points from a place, after the box was scaled to sides of length 1.
  pure function squares(points, box, place)
    !> points and box as in farthest_points
    real(rk), intent(in) :: points(:, :)
    real(rk), intent(in) :: box(:, :)
    !> in units of the parameters, not scaled; shape (n_parameters)
    real(rk), intent(in) :: place(:)
    real(rk) :: squares(size(points, 2))
    integer :: i

    do i = 1, size(squares)
      squares(i) = sum(((points(:, i) - place) / (box(2, :) - box(1, :)))**2)
    end do
  end function squares

  !> Returns the number of the first of the largest values; values that differ by at most 1e-10 count as equal.
  pure integer function first_of(values) result(i_first)
    real(rk), intent(in) :: values(:)
    real(rk), parameter :: rounding = 1.0e-10_rk

    i_first = findloc(values >= maxval(values) - rounding, .true., dim=1)
  end function first_of
end module sig_farthest_points
