! SPDX-License-Identifier: BSD-3-Clause
!> Sorts items by keys.
module sig_sorting
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: sort_by_keys, precedes

contains

  !> Sorts numbers of items by their keys, ascending in the sense of `precedes`, by merging. Items with equal keys keep their order.
  pure recursive subroutine sort_by_keys(keys, order)
    !> shape (n_keys, n_items)
    real(rk), intent(in) :: keys(:, :)
    !> numbers of items, 1-based; any number of them
    integer, intent(inout) :: order(:)
    integer :: first_half(size(order) / 2), i, j, k

    if (size(order) < 2) return
    j = size(first_half) + 1
    call sort_by_keys(keys, order(:j - 1))
    call sort_by_keys(keys, order(j:))
    first_half = order(:j - 1)
    i = 1
    do k = 1, size(order)
      if (i > size(first_half)) exit
      if (takes_second()) then
        order(k) = order(j)
        j = j + 1
      else
        order(k) = first_half(i)
        i = i + 1
      end if
    end do

  contains

    pure logical function takes_second()
      takes_second = j <= size(order)
      if (takes_second) takes_second = precedes(keys(:, order(j)), keys(:, first_half(i)))
    end function takes_second
  end subroutine sort_by_keys

  !> Whether `one` is smaller than `other` in the first key that differs; false if all are equal.
  pure logical function precedes(one, other)
    real(rk), intent(in) :: one(:)
    real(rk), intent(in) :: other(:)
    integer :: i

    precedes = .false.
    do i = 1, size(one)
      precedes = one(i) < other(i)
      if (abs(one(i) - other(i)) > 0) return
    end do
  end function precedes
end module sig_sorting
