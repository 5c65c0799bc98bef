! SPDX-License-Identifier: BSD-3-Clause
!> Which points a group of ranks solves, and which of them at once: those that share a stiffness stay together.
module sig_point_batches
  use sig_kinds, only: rk
  use sig_sorting, only: precedes, sort_by_keys
  implicit none(type, external)
  private
  public :: point_batches_t, deal_points, count_distinct

  !> The points that one group solves, cut into batches. The points of a batch share a stiffness and are solved at once.
  type :: point_batches_t
    !> indices of the points, in the order in which the group solves them
    integer, allocatable :: points(:)
    !> index in `points` of the last one of each batch
    integer, allocatable :: ends(:)
  end type point_batches_t

contains

  !> Finds the points of one group and their batches; the points of a batch share one stiffness. If all points share one stiffness,
  !> the groups get them in turn, because neighbors take about the same time. Otherwise the points are sorted by their constants and
  !> cut into one share per group. If there are fewer stiffnesses than groups, the shares are nearly equal. If not, each cut is
  !> between two stiffnesses, where it is nearest to equal shares (border). A group may get no points. The states of a history that
  !> remembers stay together, in their order.
  pure subroutine deal_points(constants, i_group, n_groups, n_at_once, n_times, batches)
    !> what the stiffness depends on at each point, as varying_constants gives it, shape (n_constants, n_points)
    real(rk), intent(in) :: constants(:, :)
    !> 1-based
    integer, intent(in) :: i_group
    integer, intent(in) :: n_groups
    !> largest number of points in a batch
    integer, intent(in) :: n_at_once
    !> so many points after each other are the states of a history, which share their stiffness; 1 where nothing remembers
    integer, intent(in) :: n_times
    type(point_batches_t), intent(out) :: batches
    integer :: i, t

    call deal_histories(constants(:, ::n_times), i_group, n_groups, max(1, n_at_once / n_times), batches)
    batches%points = [((n_times * (batches%points(i) - 1) + t, t=1, n_times), i=1, size(batches%points))]
    batches%ends = n_times * batches%ends
  end subroutine deal_points

  !> Does the work of deal_points for points, or for histories of which one state each is given.
  pure subroutine deal_histories(constants, i_group, n_groups, n_at_once, batches)
    real(rk), intent(in) :: constants(:, :)
    integer, intent(in) :: i_group
    integer, intent(in) :: n_groups
    integer, intent(in) :: n_at_once
    type(point_batches_t), intent(out) :: batches
    integer :: order(size(constants, 2))
    logical :: is_first(size(constants, 2))

    call sort_by_constants(constants, order, is_first)
    if (count(is_first) <= 1) then
      batches%points = order(i_group::n_groups)
      is_first = .false.
      call cut_batches(is_first(:size(batches%points)), n_at_once, batches%ends)
    else
      associate (before => border(is_first, i_group - 1, n_groups), last => border(is_first, i_group, n_groups))
        batches%points = order(before + 1:last)
        call cut_batches(is_first(before + 1:last), n_at_once, batches%ends)
      end associate
    end if
  end subroutine deal_histories

  !> Returns the number of different stiffnesses that the points need: the number of different columns. It is 1 if the constants
  !> have no rows, and 0 without points.
  pure integer function count_distinct(constants)
    !> of varying_constants, shape (n_constants, n_points)
    real(rk), intent(in) :: constants(:, :)
    integer :: order(size(constants, 2))
    logical :: is_first(size(constants, 2))

    call sort_by_constants(constants, order, is_first)
    count_distinct = count(is_first)
  end function count_distinct

  !> Returns the number of sorted points that groups 1 to i_group have together: 0 for i_group = 0, all points for the last group.
  !> For others it is the number nearest to equal shares (of two, the smaller one) behind which a new stiffness begins, 0 included.
  !> If there are fewer stiffnesses than groups, it is the equal share itself, rounded down.
  pure integer function border(is_first, i_group, n_groups)
    !> whether a point has another stiffness than the one before; the first point has
    logical, intent(in) :: is_first(:)
    !> 0 to n_groups
    integer, intent(in) :: i_group
    integer, intent(in) :: n_groups
    integer :: distance, fair

    fair = i_group * size(is_first) / n_groups
    border = fair
    if (count(is_first) < n_groups .or. i_group == n_groups) return
    do distance = 0, size(is_first)
      border = fair - distance
      if (is_place(border)) return
      border = fair + distance
      if (is_place(border)) return
    end do

  contains

    pure logical function is_place(n)
      integer, intent(in) :: n

      is_place = n == 0
      if (n > 0 .and. n < size(is_first)) is_place = is_first(n + 1)
    end function is_place
  end function border

  pure subroutine cut_batches(is_first, n_at_once, ends)
    logical, intent(in) :: is_first(:)
    integer, intent(in) :: n_at_once
    integer, allocatable, intent(out) :: ends(:)
    logical :: is_end(size(is_first))
    integer :: i, n

    n = 0
    do i = 1, size(is_first)
      n = n + 1
      is_end(i) = i == size(is_first) .or. n == n_at_once
      if (i < size(is_first)) is_end(i) = is_end(i) .or. is_first(i + 1)
      if (is_end(i)) n = 0
    end do
    ends = pack([(i, i=1, size(is_end))], is_end)
  end subroutine cut_batches

  !> Sorts the points by their constants, ascending in the sense of `precedes`. Points with equal constants keep their order.
  pure subroutine sort_by_constants(constants, order, is_first)
    !> shape (n_constants, n_points)
    real(rk), intent(in) :: constants(:, :)
    !> numbers of the points, sorted, shape (n_points)
    integer, intent(out) :: order(:)
    !> along the order: whether the constants differ from those of the point before; the first is true
    logical, intent(out) :: is_first(:)
    integer :: i

    order = [(i, i=1, size(order))]
    call sort_by_keys(constants, order)
    is_first = .true.
    do i = 2, size(order)
      is_first(i) = precedes(constants(:, order(i - 1)), constants(:, order(i)))
    end do
  end subroutine sort_by_constants
end module sig_point_batches
