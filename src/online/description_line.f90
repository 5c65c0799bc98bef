! SPDX-License-Identifier: BSD-3-Clause
!> Lines of a model's description.
module sig_description_line
  use sig_text, only: counted
  implicit none(type, external)
  private
  public :: line, eol, modes_text

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

  !> Returns `by 12 modes`, for descriptions; empty for 0 modes.
  pure function modes_text(n_modes) result(text)
    integer, intent(in) :: n_modes
    character(:), allocatable :: text

    text = ''
    if (n_modes > 0) text = 'by ' // counted(n_modes, 'mode')
  end function modes_text
end module sig_description_line
