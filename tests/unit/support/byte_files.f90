! SPDX-License-Identifier: BSD-3-Clause
!> Whole files as bytes, to damage them.
module byte_files
  use, intrinsic :: iso_fortran_env, only: int8
  implicit none(type, external)
  private
  public :: read_bytes, write_bytes

contains

  subroutine read_bytes(path, bytes)
    character(*), intent(in) :: path
    integer(int8), allocatable, intent(out) :: bytes(:)
    integer :: n_bytes, unit

    open (newunit=unit, file=path, access='stream', form='unformatted', action='read')
    inquire (unit=unit, size=n_bytes)
    allocate (bytes(n_bytes))
    read (unit) bytes
    close (unit)
  end subroutine read_bytes

  subroutine write_bytes(path, bytes)
    character(*), intent(in) :: path
    integer(int8), intent(in) :: bytes(:)
    integer :: unit

    open (newunit=unit, file=path, access='stream', form='unformatted', action='write', status='replace')
    write (unit) bytes
    close (unit)
  end subroutine write_bytes
end module byte_files
