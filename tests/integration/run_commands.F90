! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> usage: run_commands FILE
!>
!> Runs the commands of a file, one of its lines after the other, in one process: the start of the program takes longer than the
!> check of a small deck. After each one, standard output and standard error get the line `exit code <n>`. Words end at blanks.
program run_commands
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use sig_commands, only: run_command
  use sig_petsc_support, only: end_petsc, start_petsc
  use sig_text, only: string_t
  implicit none(type, external)
  type(string_t), allocatable :: words(:)
  character(4096) :: file, line
  integer :: exit_code, ierr, status, unit

  call get_command_argument(1, file)
  call start_petsc(ierr)
  open (newunit=unit, file=trim(file), action='read')
  do while (ierr == 0)
    read (unit, '(a)', iostat=status) line
    if (status /= 0) exit
    call split(trim(line), words)
    call run_command(words, exit_code, ierr)
    call say_end(output_unit, exit_code)
    call say_end(error_unit, exit_code)
  end do
  if (ierr == 0) call end_petsc(ierr)
  if (ierr /= 0) error stop

contains

  subroutine split(line, words)
    character(*), intent(in) :: line
    type(string_t), allocatable, intent(out) :: words(:)
    integer :: first, i, last

    allocate (words(count([(line(i:i) /= ' ' .and. line(i + 1:i + 1) == ' ', i=1, len(line) - 1)]) + 1))
    last = 0
    do i = 1, size(words)
      first = last + verify(line(last + 1:), ' ')
      last = first + index(line(first:) // ' ', ' ') - 2
      words(i)%text = line(first:last)
    end do
  end subroutine split

  subroutine say_end(unit, exit_code)
    integer, intent(in) :: unit
    integer, intent(in) :: exit_code

    write (unit, '(a, i0)') 'exit code ', exit_code
    flush (unit)
  end subroutine say_end
end program run_commands
