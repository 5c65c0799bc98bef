! SPDX-License-Identifier: BSD-3-Clause
!> Writes the manual page and the completion of bash, which the build does: write_manual MANUAL_PAGE COMPLETION
program write_manual
  use sig_command_help, only: bash_completion, manual_page
  use sig_version, only: code_version
  implicit none(type, external)

  call write_file(1, manual_page(code_version))
  call write_file(2, bash_completion())

contains

  !> Writes the text to the file that argument i of the command line names, and replaces an old one. If this fails, the program
  !> ends.
  subroutine write_file(i, text)
    integer, intent(in) :: i
    character(*), intent(in) :: text
    character(:), allocatable :: path
    integer :: length, unit

    call get_command_argument(i, length=length)
    allocate (character(length) :: path)
    call get_command_argument(i, path)
    open (newunit=unit, file=path, access='stream', form='unformatted', action='write', status='replace')
    write (unit) text
    close (unit)
  end subroutine write_file
end program write_manual
