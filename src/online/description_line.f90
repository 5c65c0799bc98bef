! SPDX-License-Identifier: BSD-3-Clause
!> Lines of a model's description.
module sig_description_line
  implicit none(type, external)
  private
  public :: line, eol

  character(1), parameter :: eol = new_line('a')

contains

  !> Returns one line, `word                    value`.
  pure function line(word, value) result(text)
    character(*), intent(in) :: word
    character(*), intent(in) :: value
    character(:), allocatable :: text

    text = word // repeat(' ', max(1, 24 - len(word))) // value // eol
  end function line
end module sig_description_line
