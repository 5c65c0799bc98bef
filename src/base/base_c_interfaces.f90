! SPDX-License-Identifier: BSD-3-Clause
!> The C side of this layer, as declared in include/signorom/{checksum,file_system,signals}.h.
module sig_base_c_interfaces
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t, c_long, c_ptr, c_size_t
  implicit none(type, external)
  private
  public :: strlen
  public :: sig_fnv1a, sig_fnv1a_of_file
  public :: sig_install_stop_signals, sig_is_stop_requested, sig_is_terminal
  public :: sig_file_kind, sig_make_directories, sig_read_file, sig_write_file, sig_commit_file, sig_rename_file
  public :: sig_remove_file, sig_lock_directory, sig_unlock_directory, sig_list_files, sig_error_text, sig_free

  interface
    pure integer(c_size_t) function strlen(text) bind(c)
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
    end function strlen

    pure integer(c_int64_t) function sig_fnv1a(bytes, size, seed) bind(c)
      import :: c_int64_t, c_size_t
      type(*), intent(in) :: bytes(*)
      integer(c_size_t), value :: size
      integer(c_int64_t), value :: seed
    end function sig_fnv1a

    integer(c_int) function sig_fnv1a_of_file(path, length, seed, hash) bind(c)
      import :: c_char, c_int, c_int64_t, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      integer(c_int64_t), value :: seed
      integer(c_int64_t), intent(out) :: hash
    end function sig_fnv1a_of_file

    subroutine sig_install_stop_signals() bind(c)
    end subroutine sig_install_stop_signals

    integer(c_int) function sig_is_stop_requested() bind(c)
      import :: c_int
    end function sig_is_stop_requested

    integer(c_int) function sig_is_terminal(descriptor) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor
    end function sig_is_terminal

    integer(c_int) function sig_file_kind(path, length) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
    end function sig_file_kind

    integer(c_int) function sig_make_directories(path, length) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
    end function sig_make_directories

    integer(c_int) function sig_read_file(path, length, bytes, size) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      type(c_ptr), intent(out) :: bytes
      integer(c_size_t), intent(out) :: size
    end function sig_read_file

    integer(c_int) function sig_write_file(path, length, bytes, size) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      character(kind=c_char), intent(in) :: bytes(*)
      integer(c_size_t), value :: size
    end function sig_write_file

    integer(c_int) function sig_commit_file(from, from_length, to, to_length) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: from(*)
      integer(c_size_t), value :: from_length
      character(kind=c_char), intent(in) :: to(*)
      integer(c_size_t), value :: to_length
    end function sig_commit_file

    integer(c_int) function sig_rename_file(from, from_length, to, to_length) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: from(*)
      integer(c_size_t), value :: from_length
      character(kind=c_char), intent(in) :: to(*)
      integer(c_size_t), value :: to_length
    end function sig_rename_file

    integer(c_int) function sig_remove_file(path, length) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
    end function sig_remove_file

    integer(c_int) function sig_lock_directory(path, length, descriptor, process) bind(c)
      import :: c_char, c_int, c_long, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      integer(c_int), intent(out) :: descriptor
      integer(c_long), intent(out) :: process
    end function sig_lock_directory

    subroutine sig_unlock_directory(descriptor) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor
    end subroutine sig_unlock_directory

    integer(c_int) function sig_list_files(path, length, prefix, prefix_length, names, size) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      character(kind=c_char), intent(in) :: prefix(*)
      integer(c_size_t), value :: prefix_length
      type(c_ptr), intent(out) :: names
      integer(c_size_t), intent(out) :: size
    end function sig_list_files

    subroutine sig_error_text(code, text, size) bind(c)
      import :: c_char, c_int, c_size_t
      integer(c_int), value :: code
      character(kind=c_char), intent(inout) :: text(*)
      integer(c_size_t), value :: size
    end subroutine sig_error_text

    subroutine sig_free(block) bind(c)
      import :: c_ptr
      type(c_ptr), value :: block
    end subroutine sig_free
  end interface
end module sig_base_c_interfaces
