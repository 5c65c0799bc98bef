! SPDX-License-Identifier: BSD-3-Clause
!> A share of the points of a study, which one of several jobs samples (--share 2/4).
module sig_share
  use sig_text, only: read_integer, split, string_t, to_text
  implicit none(type, external)
  private
  public :: most_shares, read_share, share_of_label, share_t

  integer, parameter :: most_shares = 10000

  !> Share number of n_shares, which take all points together; by default all points, which are no share.
  type :: share_t
    !> 1-based
    integer :: number = 1
    !> 0: no share
    integer :: n_shares = 0
  contains
    procedure :: is_used
    procedure :: equals
    procedure :: label
    procedure :: words
  end type share_t

contains

  !> Whether this is a share; also 1/1 is one.
  pure logical function is_used(self)
    class(share_t), intent(in) :: self

    is_used = self%n_shares > 0
  end function is_used

  pure logical function equals(self, other)
    class(share_t), intent(in) :: self
    type(share_t), intent(in) :: other

    equals = self%number == other%number .and. self%n_shares == other%n_shares
  end function equals

  !> Returns the share as it stands in names of files: `2of4`.
  pure function label(self) result(text)
    class(share_t), intent(in) :: self
    character(:), allocatable :: text

    text = to_text(self%number) // 'of' // to_text(self%n_shares)
  end function label

  !> Returns the share for messages: `share 2/4`.
  pure function words(self) result(text)
    class(share_t), intent(in) :: self
    character(:), allocatable :: text

    text = 'share ' // to_text(self%number) // '/' // to_text(self%n_shares)
  end function words

  !> Reads a share such as `2/4`. Not valid: anything else, and numbers outside of 1 <= number <= n_shares <= most_shares; then the
  !> share is not used.
  pure subroutine read_share(text, share, is_valid)
    character(*), intent(in) :: text
    type(share_t), intent(out) :: share
    logical, intent(out) :: is_valid

    call read_parts(text, '/', share, is_valid)
  end subroutine read_share

  !> Returns the share of a label such as `2of4`; one that is not used if it is none.
  pure type(share_t) function share_of_label(text) result(share)
    character(*), intent(in) :: text
    logical :: is_valid

    call read_parts(text, 'of', share, is_valid)
  end function share_of_label

  pure subroutine read_parts(text, separator, share, is_valid)
    character(*), intent(in) :: text
    character(*), intent(in) :: separator
    type(share_t), intent(out) :: share
    logical, intent(out) :: is_valid
    type(string_t), allocatable :: parts(:)
    integer :: i, numbers(2)

    is_valid = .false.
    parts = split(text, separator)
    if (size(parts) /= 2) return
    do i = 1, 2
      call read_integer(parts(i)%text, numbers(i), is_valid)
      if (.not. is_valid) return
    end do
    is_valid = numbers(1) >= 1 .and. numbers(1) <= numbers(2) .and. numbers(2) <= most_shares
    if (is_valid) share = share_t(numbers(1), numbers(2))
  end subroutine read_parts
end module sig_share
