! SPDX-License-Identifier: BSD-3-Clause
!> Convex polygons in a plane, with corners counter-clockwise: the common part of two, and the rest of one without the other.
module sig_convex_polygons
  use sig_cross_products, only: plane_cross_product
  use sig_kinds, only: rk
  use sig_rounding, only: rounding
  implicit none(type, external)
  private
  public :: polygon_t, polygon_of, area_of, centroid_of, common_part, rest_of, most_corners

  !> the common part of two facets with four corners has at most eight corners, and each cut of a rest adds at most one
  integer, parameter :: most_corners = 32

  !> A convex polygon, empty if it has no corners.
  type :: polygon_t
    !> number of corners
    integer :: n = 0
    !> [length] shape (2, n) used
    real(rk) :: corners(2, most_corners) = 0
  end type polygon_t

contains

  !> Returns the polygon with these corners, counter-clockwise. Requires: the corners go once round a convex polygon, in either
  !> direction.
  pure type(polygon_t) function polygon_of(corners) result(polygon)
    !> [length] shape (2, n), n up to most_corners
    real(rk), intent(in) :: corners(:, :)

    polygon%n = size(corners, 2)
    polygon%corners(:, :polygon%n) = corners
    if (area_of(polygon) < 0) polygon%corners(:, :polygon%n) = corners(:, polygon%n:1:-1)
  end function polygon_of

  !> Returns the area [length**2]; negative if the corners go round clockwise, 0 with fewer than three corners.
  pure real(rk) function area_of(polygon) result(area)
    type(polygon_t), intent(in) :: polygon
    integer :: i

    area = 0
    associate (corners => polygon%corners)
      do i = 3, polygon%n
        area = area + plane_cross_product(corners(:, i - 1) - corners(:, 1), corners(:, i) - corners(:, 1)) / 2
      end do
    end associate
  end function area_of

  !> Returns the mean [length] of the corners: a place inside the polygon, in general not the centroid of its area. Requires: at
  !> least one corner.
  pure function centroid_of(polygon) result(place)
    type(polygon_t), intent(in) :: polygon
    real(rk) :: place(2)

    place = sum(polygon%corners(:, :polygon%n), dim=2) / polygon%n
  end function centroid_of

  !> Returns the intersection of two convex polygons with corners counter-clockwise (polygon_of); it has no corners if it is empty
  !> or they only touch. Method: I. E. Sutherland, G. W. Hodgman, Communications of the ACM 17 (1974) 32.
  pure type(polygon_t) function common_part(one, other) result(part)
    type(polygon_t), intent(in) :: one, other
    integer :: i

    if (are_apart(one, other)) return
    part = one
    do i = 1, other%n
      part = left_of_side(part, other, i)
    end do
  end function common_part

  !> Computes polygons that together make up `one` without `other`. If the area that both have in common is at most `smallest`, the
  !> result is `one` itself.
  pure subroutine rest_of(one, other, smallest, rest)
    type(polygon_t), intent(in) :: one, other
    !> [length**2] polygons of at most this area are left out
    real(rk), intent(in) :: smallest
    type(polygon_t), allocatable, intent(out) :: rest(:)
    type(polygon_t) :: inside, outside
    integer :: i

    if (area_of(common_part(one, other)) <= smallest) then
      rest = [one]
      return
    end if
    allocate (rest(0))
    inside = one
    do i = 1, other%n
      outside = left_of_side(inside, other, i, is_turned=.true.)
      if (area_of(outside) > smallest) rest = [rest, outside]
      inside = left_of_side(inside, other, i)
    end do
  end subroutine rest_of

  !> Whether the boxes around the two polygons have nothing in common.
  pure logical function are_apart(one, other)
    type(polygon_t), intent(in) :: one, other

    associate (a => one%corners(:, :one%n), b => other%corners(:, :other%n))
      are_apart = any(maxval(a, dim=2) < minval(b, dim=2) .or. maxval(b, dim=2) < minval(a, dim=2))
    end associate
  end function are_apart

  !> Returns the part of a polygon on the left of the line through a side of another one, or, with is_turned, on its right; no
  !> corners if there is no such part.
  pure type(polygon_t) function left_of_side(polygon, other, i_side, is_turned) result(part)
    type(polygon_t), intent(in) :: polygon, other
    !> side from corner i_side of `other` to the next one
    integer, intent(in) :: i_side
    !> default: no
    logical, intent(in), optional :: is_turned
    real(rk) :: along(2), heights(most_corners)
    integer :: i, next

    associate (from => other%corners(:, i_side), to => other%corners(:, modulo(i_side, other%n) + 1), &
      corners => polygon%corners, n => polygon%n)
      along = to - from
      if (present(is_turned)) along = merge(-along, along, is_turned)
      do i = 1, n
        heights(i) = plane_cross_product(along, corners(:, i) - from)
        if (abs(heights(i)) <= rounding * norm2(along) * max(norm2(along), norm2(corners(:, i) - from))) heights(i) = 0
      end do
      if (.not. any(heights(:n) > 0)) return
      do i = 1, n
        next = modulo(i, n) + 1
        if (heights(i) >= 0) call append(corners(:, i), part)
        if (heights(i) * heights(next) < 0) call append((heights(i) * corners(:, next) - heights(next) * corners(:, i)) / &
          (heights(i) - heights(next)), part)
      end do
    end associate
  end function left_of_side

  !> Adds a corner to a polygon. A corner beyond the last possible one is left out: some area is lost.
  pure subroutine append(corner, polygon)
    real(rk), intent(in) :: corner(2)
    type(polygon_t), intent(inout) :: polygon

    if (polygon%n == most_corners) return
    polygon%n = polygon%n + 1
    polygon%corners(:, polygon%n) = corner
  end subroutine append
end module sig_convex_polygons
