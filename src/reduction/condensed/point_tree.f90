! SPDX-License-Identifier: BSD-3-Clause
!> A tree of points that are halved along the longest side of their box again and again, so that near points stand near each other.
module sig_point_tree
  use sig_kinds, only: rk
  use sig_sorting, only: sort_by_keys
  implicit none(type, external)
  private
  public :: point_tree_t

  !> Intervals of the ordered points. A leaf has no children. Children come before their parent.
  type :: point_tree_t
    !> number of each ordered point, 1-based; shape (n_points)
    integer, allocatable :: order(:)
    !> first and last ordered point of each interval, shape (n_intervals)
    integer, allocatable :: first(:)
    integer, allocatable :: last(:)
    !> the two halves of each interval, 0 for a leaf; shape (2, n_intervals)
    integer, allocatable :: children(:, :)
    !> intervals that belong to no other, shape (n_groups)
    integer, allocatable :: roots(:)
  contains
    procedure :: create
  end type point_tree_t

  integer, parameter :: n_steps = 2**20

contains

  !> Builds the tree of each group of points, one after the other. Points with the same place keep the order of their numbers.
  !> Places that differ by less than a millionth of the size of all count as the same: rounding of the coordinates, which differs
  !> with the unit of length, must not decide.
  subroutine create(self, points, groups, most_in_leaf)
    class(point_tree_t), intent(out) :: self
    !> [length] shape (n_dim, n_points)
    real(rk), intent(in) :: points(:, :)
    !> group of each point: 1, 2, ..., without gaps; shape (n_points)
    integer, intent(in) :: groups(:)
    !> largest number of points in a leaf
    integer, intent(in) :: most_in_leaf
    integer :: i, k, n, n_before, places(size(points, 1), size(points, 2))

    places = steps_of(points)
    allocate (self%order(size(groups)))
    allocate (self%first(2 * size(groups)), self%last(2 * size(groups)), self%children(2, 2 * size(groups)))
    allocate (self%roots(maxval([0, groups])))
    n = 0
    n_before = 0
    do k = 1, size(self%roots)
      associate (own => pack([(i, i=1, size(groups))], groups == k))
        self%order(n_before + 1:n_before + size(own)) = own
        call halve(self, places, n_before + 1, n_before + size(own), most_in_leaf, n)
        n_before = n_before + size(own)
      end associate
      self%roots(k) = n
    end do
    self%first = self%first(:n)
    self%last = self%last(:n)
    self%children = self%children(:, :n)
  end subroutine create

  !> Returns coordinates as numbers of steps, 0 to n_steps along the longest side of the box around all points.
  pure function steps_of(points) result(places)
    real(rk), intent(in) :: points(:, :)
    integer :: places(size(points, 1), size(points, 2))
    real(rk) :: corner(size(points, 1)), size_of_all
    integer :: i

    corner = minval(points, dim=2)
    size_of_all = maxval([0.0_rk, maxval(points, dim=2) - corner])
    do i = 1, size(points, 2)
      places(:, i) = nint((points(:, i) - corner) / max(size_of_all, tiny(size_of_all)) * n_steps)
    end do
  end function steps_of

  !> Adds an interval and all below it. On return n is its number.
  pure recursive subroutine halve(self, places, first, last, most_in_leaf, n)
    class(point_tree_t), intent(inout) :: self
    !> of steps_of
    integer, intent(in) :: places(:, :)
    integer, intent(in) :: first
    integer, intent(in) :: last
    integer, intent(in) :: most_in_leaf
    !> number of intervals
    integer, intent(inout) :: n
    integer :: axis, children(2), middle

    children = 0
    if (last - first + 1 > most_in_leaf) then
      associate (own => places(:, self%order(first:last)))
        axis = maxloc(maxval(own, dim=2) - minval(own, dim=2), dim=1)
      end associate
      call sort(places(axis, self%order(first:last)), self%order(first:last))
      middle = (first + last) / 2
      call halve(self, places, first, middle, most_in_leaf, n)
      children(1) = n
      call halve(self, places, middle + 1, last, most_in_leaf, n)
      children(2) = n
    end if
    n = n + 1
    self%first(n) = first
    self%last(n) = last
    self%children(:, n) = children
  end subroutine halve

  !> Sorts numbers of points by their coordinate, equal ones by their number.
  pure subroutine sort(coordinates, numbers)
    !> of these points
    integer, intent(in) :: coordinates(:)
    integer, intent(inout) :: numbers(:)
    real(rk) :: keys(2, size(numbers))
    integer :: i, order(size(numbers))

    keys(1, :) = coordinates
    keys(2, :) = numbers
    order = [(i, i=1, size(order))]
    call sort_by_keys(keys, order)
    numbers = numbers(order)
  end subroutine sort
end module sig_point_tree
