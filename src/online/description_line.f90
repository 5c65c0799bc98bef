! SPDX-License-Identifier: BSD-3-Clause
!> Lines of a model's description.
module sig_description_line
  implicit none(type, external)
  private
  public :: line, eol

  !> end of a line
  character(1), parameter :: eol = new_line('a')

contains

  !> Returns one line: `word`, blanks up to column 24 (at least one), `value` and the end of the line.
  pure function line(word, value) result(text)
    character(*), intent(in) :: word
    character(*), intent(in) :: value
    character(:), allocatable :: text

    text = word // repeat(' ', max(1, 24 - len(word))) // value // eol
  end function line
end module sig_description_line
