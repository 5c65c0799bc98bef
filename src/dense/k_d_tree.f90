! SPDX-License-Identifier: BSD-3-Clause
!> A k-d tree: which of many points lie near a place, without looking at them all.
module sig_k_d_tree
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: k_d_tree_t

  !> A balanced tree without pointers: the root of the points lo..hi is the one in the middle, in the order of the tree.
  type :: k_d_tree_t
    private
    integer :: n_points = 0
    !> points in the tree's order, shape (n_dim, n_points)
    real(rk), allocatable :: points(:, :)
    !> the caller's number of each
    integer, allocatable :: numbers(:)
    !> coordinate by which the points beside each root are told apart
    integer, allocatable :: axes(:)
  contains
    procedure :: create
    procedure :: nearest
    procedure :: within
  end type k_d_tree_t

contains

  !> Cost: O(n log n).
  pure subroutine create(self, points)
    class(k_d_tree_t), intent(inout) :: self
    !> shape (n_dim, n_points)
    real(rk), intent(in) :: points(:, :)
    integer :: i

    if (allocated(self%axes)) deallocate (self%axes)
    self%n_points = size(points, 2)
    self%points = points
    self%numbers = [(i, i=1, self%n_points)]
    allocate (self%axes(self%n_points), source=1)
    call arrange(self, 1, self%n_points)
  end subroutine create

  !> Makes a tree of the points lo..hi.
  pure recursive subroutine arrange(self, lo, hi)
    class(k_d_tree_t), intent(inout) :: self
    integer, intent(in) :: lo, hi
    integer :: middle

    if (hi <= lo) return
    middle = (lo + hi) / 2
    self%axes(middle) = widest_axis(self%points(:, lo:hi))
    call select_middle(self, self%axes(middle), lo, middle, hi)
    call arrange(self, lo, middle - 1)
    call arrange(self, middle + 1, hi)
  end subroutine arrange

  pure integer function widest_axis(points) result(axis)
    real(rk), intent(in) :: points(:, :)

    axis = maxloc(maxval(points, dim=2) - minval(points, dim=2), dim=1)
  end function widest_axis

  !> Quickselect: afterwards no point of lo..middle-1 lies above that in the middle, none of middle+1..hi below it.
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
    self%numbers([i, j]) = self%numbers([j, i])
  end subroutine swap

  !> The point nearest to a place; of equally near ones that with the lowest number. Cost: O(log n) as a rule.
  pure subroutine nearest(self, place, number, distance)
    class(k_d_tree_t), intent(in) :: self
    real(rk), intent(in) :: place(:)
    !> 1-based; 0 in an empty tree
    integer, intent(out) :: number
    !> huge in an empty tree
    real(rk), intent(out) :: distance

    number = 0
    distance = huge(distance)
    call search_nearest(self, place, 1, self%n_points, number, distance)
  end subroutine nearest

  pure recursive subroutine search_nearest(self, place, lo, hi, number, distance)
    class(k_d_tree_t), intent(in) :: self
    real(rk), intent(in) :: place(:)
    integer, intent(in) :: lo, hi
    integer, intent(inout) :: number
    real(rk), intent(inout) :: distance
    integer :: middle
    real(rk) :: offset, candidate

    if (hi < lo) return
    middle = (lo + hi) / 2
    candidate = norm2(self%points(:, middle) - place)
    if (candidate < distance .or. (candidate <= distance .and. self%numbers(middle) < number)) then
      distance = candidate
      number = self%numbers(middle)
    end if
    offset = place(self%axes(middle)) - self%points(self%axes(middle), middle)
    ! the side of the place first, so that the other one can mostly be left out
    if (offset <= 0) then
      call search_nearest(self, place, lo, middle - 1, number, distance)
      if (-offset <= distance) call search_nearest(self, place, middle + 1, hi, number, distance)
    else
      call search_nearest(self, place, middle + 1, hi, number, distance)
      if (offset <= distance) call search_nearest(self, place, lo, middle - 1, number, distance)
    end if
  end subroutine search_nearest

  !> All points at most `radius` from a place, ascending.
  pure subroutine within(self, place, radius, numbers)
    class(k_d_tree_t), intent(in) :: self
    real(rk), intent(in) :: place(:)
    real(rk), intent(in) :: radius
    !> 1-based
    integer, allocatable, intent(out) :: numbers(:)

    allocate (numbers(0))
    call search_within(self, place, radius, 1, self%n_points, numbers)
    call sort_ascending(numbers)
  end subroutine within

  pure recursive subroutine search_within(self, place, radius, lo, hi, numbers)
    class(k_d_tree_t), intent(in) :: self
    real(rk), intent(in) :: place(:)
    real(rk), intent(in) :: radius
    integer, intent(in) :: lo, hi
    integer, allocatable, intent(inout) :: numbers(:)
    integer :: middle
    real(rk) :: offset

    if (hi < lo) return
    middle = (lo + hi) / 2
    if (norm2(self%points(:, middle) - place) <= radius) numbers = [numbers, self%numbers(middle)]
    offset = place(self%axes(middle)) - self%points(self%axes(middle), middle)
    if (offset <= radius) call search_within(self, place, radius, lo, middle - 1, numbers)
    if (offset >= -radius) call search_within(self, place, radius, middle + 1, hi, numbers)
  end subroutine search_within

  !> By insertion: a query finds few points.
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
