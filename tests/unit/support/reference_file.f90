! SPDX-License-Identifier: BSD-3-Clause
!> Reads what the scripts in tests/reference wrote: blocks `name n_rows n_columns`, then a line per row.
module reference_file
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: read_reference

contains

  !> The named block of the file; of shape (0, 0) where the file has no such block.
  subroutine read_reference(path, name, matrix)
    character(*), intent(in) :: path
    character(*), intent(in) :: name
    real(rk), allocatable, intent(out) :: matrix(:, :)
    character(64) :: word
    integer :: i_row, n_columns, n_rows, status, unit

    open (newunit=unit, file=path, status='old', action='read')
    do
      read (unit, *, iostat=status) word, n_rows, n_columns
      if (status /= 0) exit
      if (allocated(matrix)) deallocate (matrix)
      allocate (matrix(n_rows, n_columns))
      do i_row = 1, n_rows
        read (unit, *) matrix(i_row, :)
      end do
      if (word == name) exit
    end do
    close (unit)
    if (status /= 0) matrix = reshape([real(rk) ::], [0, 0])
  end subroutine read_reference
end module reference_file
