! SPDX-License-Identifier: BSD-3-Clause
!> Reads files whose names come line by line on standard input, and answers each on standard output.
!>
!>     fuzz_readers KIND          for each path of a file of this kind: `accepted`, or `refused N` and a sentence of N bytes
!>     fuzz_readers seeds FOLDER  writes a shard, snapshots.h5 and two model.h5 to begin with
program fuzz_readers
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use fuzz_seeds, only: write_seeds
  use fuzz_targets, only: read_input
  implicit none(type, external)
  character(4096) :: kind, folder

  call get_command_argument(1, kind)
  call get_command_argument(2, folder)
  if (kind == 'seeds') then
    call make_seeds(trim(folder))
  else
    call answer_all(trim(kind))
  end if

contains

  subroutine make_seeds(folder)
    character(*), intent(in) :: folder
    character(:), allocatable :: sentence

    call write_seeds(folder, sentence)
    if (len(sentence) == 0) return
    write (error_unit, '(a)') sentence
    error stop
  end subroutine make_seeds

  subroutine answer_all(kind)
    character(*), intent(in) :: kind
    character(4096) :: path
    character(:), allocatable :: sentence
    integer :: status

    do
      read (*, '(a)', iostat=status) path
      if (status /= 0) exit
      call read_input(kind, trim(path), sentence)
      if (len(sentence) == 0) then
        write (output_unit, '(a)') 'accepted'
      else
        write (output_unit, '(a, i0, a)') 'refused ', len(sentence), new_line('a') // sentence
      end if
      flush (output_unit)
    end do
  end subroutine answer_all
end program fuzz_readers
