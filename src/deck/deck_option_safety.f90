! SPDX-License-Identifier: BSD-3-Clause
!> Finds PETSc options that a deck must not have, because they write files or run code. A deck may come from anybody; the command
!> line, where such options are allowed, comes from the user.
module sig_deck_option_safety
  use sig_text, only: lower, split, string_t
  implicit none(type, external)
  private
  public :: complaint_about_writing

  character(*), parameter :: hint_of_all = '; such options go on the command line'
  !> parts of names of options that show something; their value may be the name of a file or a kind of viewer
  character(*), parameter :: showing(5) = [character(8) :: 'view', 'monitor', 'reason', 'draw', 'save']
  !> parts of names that a deck must never use: factors in files (MUMPS's control 22), their folder, and code to run
  character(*), parameter :: forbidden(3) = [character(10) :: 'ooc', 'icntl_22', 'python']

  character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz'

contains

  !> Returns a complaint about a quotation mark, tab or line end anywhere in the text, or else about the first option that may write
  !> a file or run code; this complaint begins with the option in lower case, and its value if that is the reason. It is empty if
  !> there is nothing to complain about.
  pure function complaint_about_writing(options) result(complaint)
    !> options of the deck: names and values with blanks between them
    character(*), intent(in) :: options
    character(:), allocatable :: complaint
    type(string_t), allocatable :: words(:)
    character(:), allocatable :: name
    integer :: i

    complaint = ''
    name = ''
    if (scan(options, '"''' // achar(9) // achar(10) // achar(13)) > 0) complaint = &
      'a quotation mark, a tab or a new line; options and their values are separated by blanks'
    words = split(options, ' ')
    do i = 1, size(words)
      if (len(complaint) > 0) return
      if (len(words(i)%text) == 0) cycle
      if (words(i)%text(1:1) == '-' .and. scan(lower(words(i)%text), letters) == 2) then
        ! PETSc ignores upper and lower case in names
        name = lower(words(i)%text)
        if (has_any(name, forbidden)) complaint = name // ', which may write files or run code' // hint_of_all
      else if (names_file(name, words(i)%text)) then
        complaint = name // ' ' // words(i)%text // ', which may write a file' // hint_of_all
      end if
    end do
  end function complaint_about_writing

  !> Whether the output of an option may go to a file. It goes to the terminal for `ascii`, `::ascii_info` and `ascii::ascii_info`.
  !> A word after one colon is the name of a file. Viewers of other kinds write to a file by default. A value without a colon counts
  !> only if the option's name has view, monitor, reason, draw or save in it, and not if it is ascii, a number, or one of true,
  !> false, yes and no.
  pure logical function names_file(name, value)
    !> option in lower case; empty for a value before all options
    character(*), intent(in) :: name
    character(*), intent(in) :: value
    integer :: i

    i = index(value, ':')
    names_file = .false.
    if (i == 0) then
      names_file = has_any(name, showing) .and. verify(value, '0123456789.,+-eE') > 0 .and. &
        .not. any(value == [character(5) :: 'ascii', 'true', 'false', 'yes', 'no'])
    else
      names_file = index(value, '::') /= i .or. (i > 1 .and. value(:i - 1) /= 'ascii') .or. index(value(i + 2:), ':') > 0
    end if
  end function names_file

  pure logical function has_any(text, words)
    character(*), intent(in) :: text
    character(*), intent(in) :: words(:)
    integer :: i

    has_any = .false.
    do i = 1, size(words)
      if (index(text, trim(words(i))) > 0) has_any = .true.
    end do
  end function has_any
end module sig_deck_option_safety
