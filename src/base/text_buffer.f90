! SPDX-License-Identifier: BSD-3-Clause
!> A text that grows in pieces: appending a piece does not copy the text before it.
module sig_text_buffer
  implicit none(type, external)
  private
  public :: text_buffer_t

  !> Call add for each piece; text returns the pieces so far.
  type :: text_buffer_t
    private
    !> text, with free space at its end
    character(:), allocatable :: storage
    integer :: length = 0
  contains
    procedure :: add
    procedure :: text
    procedure :: clear
  end type text_buffer_t

contains

  !> Appends a piece.
  pure subroutine add(self, piece)
    class(text_buffer_t), intent(inout) :: self
    character(*), intent(in) :: piece
    character(:), allocatable :: longer
    integer, parameter :: first_room = 256
    integer :: room

    if (.not. allocated(self%storage)) allocate (character(first_room) :: self%storage)
    if (self%length + len(piece) > len(self%storage)) then
      room = max(2 * len(self%storage), self%length + len(piece))
      allocate (character(room) :: longer)
      longer(:self%length) = self%storage(:self%length)
      call move_alloc(longer, self%storage)
    end if
    self%storage(self%length + 1:self%length + len(piece)) = piece
    self%length = self%length + len(piece)
  end subroutine add

  !> Returns the whole text: all pieces one after the other.
  pure function text(self)
    class(text_buffer_t), intent(in) :: self
    character(:), allocatable :: text

    text = ''
    if (self%length > 0) text = self%storage(:self%length)
  end function text

  !> Empties the buffer and keeps its memory.
  pure subroutine clear(self)
    class(text_buffer_t), intent(inout) :: self

    self%length = 0
  end subroutine clear
end module sig_text_buffer
