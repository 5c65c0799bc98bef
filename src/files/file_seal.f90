! SPDX-License-Identifier: BSD-3-Clause
!> Seals at the head of files: length and checksum of the rest. With them a file that was cut off or changed is detected before a
!> library reads it.
module sig_file_seal
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t, c_size_t
  use sig_errors, only: error_t, make_error
  use sig_system, only: system_reason
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: seal_file, check_seal, seal_size

  ! the same value as in file_seal.h
  integer, parameter :: seal_size = 512
  integer(c_int), parameter :: no_seal = 1, newer = 2, other_length = 3, changed = 4
  character(*), parameter :: again = 'copy or make the file again'

  ! include/signorom/file_seal.h describes these procedures in C.
  interface
    integer(c_int) function sig_seal_file(path, length) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
    end function sig_seal_file

    integer(c_int) function sig_check_seal(path, length, n_found, n_sealed) bind(c)
      import :: c_char, c_int, c_int64_t, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      integer(c_int64_t), intent(out) :: n_found
      integer(c_int64_t), intent(out) :: n_sealed
    end function sig_check_seal
  end interface

contains

  !> Writes the seal of a file into its first seal_size (512) bytes, which the file must have and which are overwritten. Errors: the
  !> file cannot be read or written.
  subroutine seal_file(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: code

    code = sig_seal_file(path, len(path, c_size_t))
    if (code /= 0) call make_error(error, 'cannot write the file: ' // system_reason(code), file=path)
  end subroutine seal_file

  !> Checks the seal of a file. Errors: a newer version of the program wrote the seal; the file is shorter or longer than it was;
  !> its content or its seal was changed. A file that does not begin as a seal does, or that cannot be read, is no error.
  subroutine check_seal(path, is_sealed, error)
    character(*), intent(in) :: path
    !> whether the file has a seal and agrees with it
    logical, intent(out) :: is_sealed
    type(error_t), allocatable, intent(out) :: error
    integer(c_int64_t) :: n_found, n_sealed
    integer(c_int) :: status

    status = sig_check_seal(path, len(path, c_size_t), n_found, n_sealed)
    is_sealed = status == 0
    select case (status)
    case (newer)
      call make_error(error, 'a newer version of the program wrote the file; this version cannot read it', file=path, &
        hint='use the version that wrote it, or a newer one')
    case (other_length)
      if (n_sealed == 0) then
        call make_error(error, 'the file is cut off: it ends within its head', file=path, hint=again)
      else if (n_found < n_sealed) then
        call make_error(error, 'the file is cut off: behind its head ' // to_text(n_found) // ' of ' // to_text(n_sealed) // &
          ' bytes are there', file=path, hint=again)
      else
        call make_error(error, 'the file is longer than it was when it was written', file=path, hint=again)
      end if
    case (changed)
      call make_error(error, 'the file was changed or damaged after it was written: its checksum differs', file=path, hint=again)
    case default ! whole, without a seal, or for others to say why it cannot be read
    end select
  end subroutine check_seal
end module sig_file_seal
