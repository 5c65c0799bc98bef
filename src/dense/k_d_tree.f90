! SPDX-License-Identifier: BSD-3-Clause
!> A k-d tree: finds the points or balls near a place or a line without comparing all of them.
module sig_k_d_tree
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: k_d_tree_t

  !> A balanced tree without pointers. In the order of the tree, the root of the points lo..hi is the one in the middle.
  !>
  !> Each subtree has a ball around all its points or balls. A search leaves out subtrees whose ball is too far away. This works for
  !> distances from a place and from a line.
  type :: k_d_tree_t
    private
    integer :: n_points = 0
    !> points in the tree's order, shape (n_dim, n_points)
    real(rk), allocatable :: points(:, :)
    !> radius of the ball around each point, 0 for points, shape (n_points)
    real(rk), allocatable :: sizes(:)
    !> number of each point in the order of the caller, shape (n_points)
    integer, allocatable :: numbers(:)
    !> center and radius of the ball of the subtree below each root, shape (n_dim, n_points) and (n_points)
    real(rk), allocatable :: centers(:, :)
    real(rk), allocatable :: radii(:)
  contains
    procedure :: create
    procedure :: nearest
    procedure :: within
  end type k_d_tree_t

  !> [-] balls are larger by this fraction of the coordinates, so that no point is lost by rounding
  real(rk), parameter :: slack = 8 * epsilon(1.0_rk)

contains

  !> Makes the tree of some points or balls in place of those that it had. Cost: O(n log n) in most cases.
  pure subroutine create(self, points, sizes)
    class(k_d_tree_t), intent(inout) :: self
    !> points, or centers of the balls, shape (n_dim, n_points)
    real(rk), intent(in) :: points(:, :)
    !> radii of the balls, which only `within` uses; default 0; shape (n_points)
    real(rk), intent(in), optional :: sizes(:)
    integer :: i

    if (allocated(self%radii)) deallocate (self%radii, self%centers)
    self%n_points = size(points, 2)
    self%points = points
    self%sizes = spread(0.0_rk, 1, self%n_points)
    if (present(sizes)) self%sizes = sizes
    self%numbers = [(i, i=1, self%n_points)]
    allocate (self%radii(self%n_points), self%centers(size(points, 1), self%n_points), source=0.0_rk)
    call arrange(self, 1, self%n_points)
  end subroutine create

  !> Orders the points lo..hi as a tree and sets the balls of its subtrees; does nothing if hi < lo.
  pure recursive subroutine arrange(self, lo, hi)
    class(k_d_tree_t), intent(inout) :: self
    integer, intent(in) :: lo, hi
    real(rk) :: lowest(size(self%points, 1)), highest(size(self%points, 1))
    integer :: i, middle

    if (hi < lo) return
    middle = (lo + hi) / 2
    lowest = minval(self%points(:, lo:hi), dim=2)
    highest = maxval(self%points(:, lo:hi), dim=2)
    self%centers(:, middle) = lowest + (highest - lowest) / 2
    do i = lo, hi
      self%radii(middle) = max(self%radii(middle), norm2(self%points(:, i) - self%centers(:, middle)) + self%sizes(i))
    end do
    self%radii(middle) = self%radii(middle) + slack * maxval(abs([lowest, highest]))
    call select_middle(self, maxloc(highest - lowest, dim=1), lo, middle, hi)
    call arrange(self, lo, middle - 1)
    call arrange(self, middle + 1, hi)
  end subroutine arrange

  !> Sorts the points lo..hi partly along an axis (quickselect). Afterwards, no point of lo..middle-1 has a larger coordinate than
  !> the middle one, and no point of middle+1..hi a smaller one.
  pure subroutine select_middle(self, axis, lo, middle, hi)
    class(k_d_tree_t), intent(inout) :: self
    integer, intent(in) :: axis, lo, middle, hi
    real(rk) :: pivot
    integer :: first, last, i, j

    first = lo
    last = hi
    do while (first < last)
      pivot = self%points(axis, (first + last) / 2)
      i = first
      j = last
      do while (i <= j)
        do while (self%points(axis, i) < pivot)
          i = i + 1
        end do
        do while (self%points(axis, j) > pivot)
          j = j - 1
        end do
        if (i > j) exit
        call swap(self, i, j)
        i = i + 1
        j = j - 1
      end do
      if (middle > j) first = i
      if (middle < i) last = j
    end do
  end subroutine select_middle

  pure subroutine swap(self, i, j)
    class(k_d_tree_t), intent(inout) :: self
    integer, intent(in) :: i, j

    self%points(:, [i, j]) = self%points(:, [j, i])
    self%sizes([i, j]) = self%sizes([j, i])
    self%numbers([i, j]) = self%numbers([j, i])
  end subroutine swap

  !> Finds the point, or the center of a ball, that is nearest to a place, or to a line through the place. Of several at exactly the
  !> same distance it is the one with the lowest number.
  !>
  !> Cost: O(log n) in most cases.
  pure subroutine nearest(self, place, number, distance, direction)
    class(k_d_tree_t), intent(in) :: self
    !> shape (n_dim)
    real(rk), intent(in) :: place(:)
    !> number of the point or ball in the order of the caller, 1-based; 0 in an empty tree
    integer, intent(out) :: number
    !> distance of the point or center; huge in an empty tree
    real(rk), intent(out) :: distance
    !> [-] direction of the line, unit vector; default: no line
    real(rk), intent(in), optional :: direction(:)
    real(rk) :: along(size(place))

    along = 0
    if (present(direction)) along = direction
    number = 0
    distance = huge(distance)
    call search_nearest(self, place, along, 1, self%n_points, number, distance)
  end subroutine nearest

  pure recursive subroutine search_nearest(self, place, along, lo, hi, number, distance)
    class(k_d_tree_t), intent(in) :: self
    real(rk), intent(in) :: place(:)
    real(rk), intent(in) :: along(:)
    integer, intent(in) :: lo, hi
    integer, intent(inout) :: number
    real(rk), intent(inout) :: distance
    integer :: middle
    real(rk) :: candidate

    if (least_distance(self, place, along, lo, hi) > distance) return
    middle = (lo + hi) / 2
    candidate = offset(self%points(:, middle) - place, along)
    if (candidate < distance .or. (candidate <= distance .and. self%numbers(middle) < number)) then
      distance = candidate
      number = self%numbers(middle)
    end if
    ! the nearer side first, because the other one can then usually be left out
    if (least_distance(self, place, along, lo, middle - 1) <= least_distance(self, place, along, middle + 1, hi)) then
      call search_nearest(self, place, along, lo, middle - 1, number, distance)
      call search_nearest(self, place, along, middle + 1, hi, number, distance)
    else
      call search_nearest(self, place, along, middle + 1, hi, number, distance)
      call search_nearest(self, place, along, lo, middle - 1, number, distance)
    end if
  end subroutine search_nearest

  !> Returns a lower bound, which may be negative, of the distance between the points or balls lo..hi and the place or line;
  !> infinite if hi < lo. `along` is the direction of the line, zero for no line.
  pure real(rk) function least_distance(self, place, along, lo, hi) result(distance)
    class(k_d_tree_t), intent(in) :: self
    real(rk), intent(in) :: place(:)
    real(rk), intent(in) :: along(:)
    integer, intent(in) :: lo, hi

    distance = ieee_value(distance, ieee_positive_inf)
    if (hi < lo) return
    associate (root => (lo + hi) / 2)
      distance = offset(self%centers(:, root) - place, along) - self%radii(root) - slack * maxval(abs(place))
    end associate
  end function least_distance

  !> Returns the length of a vector without its component along the unit vector `along`; if `along` is zero, the length of the
  !> whole vector.
  pure real(rk) function offset(vector, along)
    real(rk), intent(in) :: vector(:)
    real(rk), intent(in) :: along(:)

    offset = norm2(vector - dot_product(vector, along) * along)
  end function offset

  !> Finds all points, or balls, whose distance from a place, or from a line through the place, is at most `radius`. Balls that
  !> contain the place, or meet the line, are found, too.
  pure subroutine within(self, place, radius, numbers, direction)
    class(k_d_tree_t), intent(in) :: self
    !> shape (n_dim)
    real(rk), intent(in) :: place(:)
    !> largest distance, in the unit of the points
    real(rk), intent(in) :: radius
    !> numbers of the points or balls in the order of the caller, 1-based, ascending; empty if there are none
    integer, allocatable, intent(out) :: numbers(:)
    !> [-] direction of the line, unit vector; default: no line
    real(rk), intent(in), optional :: direction(:)
    real(rk) :: along(size(place))

    along = 0
    if (present(direction)) along = direction
    allocate (numbers(0))
    call search_within(self, place, along, radius, 1, self%n_points, numbers)
    call sort_ascending(numbers)
  end subroutine within

  pure recursive subroutine search_within(self, place, along, radius, lo, hi, numbers)
    class(k_d_tree_t), intent(in) :: self
    real(rk), intent(in) :: place(:)
    real(rk), intent(in) :: along(:)
    real(rk), intent(in) :: radius
    integer, intent(in) :: lo, hi
    integer, allocatable, intent(inout) :: numbers(:)
    integer :: middle

    if (least_distance(self, place, along, lo, hi) > radius) return
    middle = (lo + hi) / 2
    if (offset(self%points(:, middle) - place, along) - self%sizes(middle) <= radius) numbers = [numbers, self%numbers(middle)]
    call search_within(self, place, along, radius, lo, middle - 1, numbers)
    call search_within(self, place, along, radius, middle + 1, hi, numbers)
  end subroutine search_within

  !> Sorts numbers in place by insertion, which is fast enough for the few points that a search finds.
  pure subroutine sort_ascending(numbers)
    integer, intent(inout) :: numbers(:)
    integer :: i, j, number

    do i = 2, size(numbers)
      number = numbers(i)
      j = i - 1
      do while (j > 0)
        if (numbers(j) <= number) exit
        numbers(j + 1) = numbers(j)
        j = j - 1
      end do
      numbers(j + 1) = number
    end do
  end subroutine sort_ascending
end module sig_k_d_tree
