! SPDX-License-Identifier: BSD-3-Clause
!> Interfaces of the C functions of this layer, which include/signorom/{checksum,file_seal,file_system,hdf5_file,output_stream}.h
!> declare and describe.
module sig_files_c_interfaces
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int64_t, c_long, c_ptr, c_size_t
  implicit none(type, external)
  private
  public :: sig_fnv1a, sig_file_kind, sig_make_directories, sig_read_file, sig_write_file, sig_commit_file, &
    sig_remove_file, sig_lock_directory, sig_unlock_directory, sig_list_files, &
    sig_program_path, sig_seal_file, sig_check_seal, sig_open_to_read, sig_read_some, sig_close_descriptor, &
    sig_find_target, sig_output_open, sig_output_write, sig_output_close, sig_h5_create_image, sig_h5_open_image, &
    sig_h5_image_size, sig_h5_get_image, sig_h5_create, sig_h5_open, sig_h5_close, sig_h5_write, sig_h5_write_rows, &
    sig_h5_write_texts, sig_h5_has, sig_h5_describe, sig_h5_read, sig_h5_read_part, sig_h5_read_texts

  interface
    pure integer(c_int64_t) function sig_fnv1a(bytes, size, seed) bind(c)
      import :: c_int64_t, c_size_t
      type(*), intent(in) :: bytes(*)
      integer(c_size_t), value :: size
      integer(c_int64_t), value :: seed
    end function sig_fnv1a

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

    integer(c_int) function sig_program_path(path, size) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(out) :: path(*)
      integer(c_size_t), value :: size
    end function sig_program_path

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

    integer(c_int) function sig_open_to_read(path, length, descriptor) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      integer(c_int), intent(out) :: descriptor
    end function sig_open_to_read

    integer(c_int) function sig_read_some(descriptor, bytes, size, n_read) bind(c)
      import :: c_char, c_int, c_size_t
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(inout) :: bytes(*)
      integer(c_size_t), value :: size
      integer(c_size_t), intent(out) :: n_read
    end function sig_read_some

    subroutine sig_close_descriptor(descriptor) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor
    end subroutine sig_close_descriptor

    integer(c_int) function sig_find_target(path, length, target, is_direct) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      type(c_ptr), intent(out) :: target
      integer(c_int), intent(out) :: is_direct
    end function sig_find_target

    integer(c_int) function sig_output_open(path, length, stream) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      type(c_ptr), intent(out) :: stream
    end function sig_output_open

    integer(c_int) function sig_output_write(stream, text, size) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      type(c_ptr), value :: stream
      character(kind=c_char), intent(in) :: text(*)
      integer(c_size_t), value :: size
    end function sig_output_write

    integer(c_int) function sig_output_close(stream, is_kept) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
      integer(c_int), value :: is_kept
    end function sig_output_close

    integer(c_int) function sig_h5_create_image(file) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), intent(out) :: file
    end function sig_h5_create_image

    integer(c_int) function sig_h5_open_image(bytes, size, file) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: bytes(*)
      integer(c_size_t), value :: size
      type(c_ptr), intent(out) :: file
    end function sig_h5_open_image

    integer(c_int64_t) function sig_h5_image_size(file) bind(c)
      import :: c_int64_t, c_ptr
      type(c_ptr), value :: file
    end function sig_h5_image_size

    integer(c_int) function sig_h5_get_image(file, size, bytes) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      type(c_ptr), value :: file
      integer(c_size_t), value :: size
      character(kind=c_char), intent(out) :: bytes(*)
    end function sig_h5_get_image

    integer(c_int) function sig_h5_create(path, length, n_free, file) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      integer(c_size_t), value :: n_free
      type(c_ptr), intent(out) :: file
    end function sig_h5_create

    integer(c_int) function sig_h5_open(path, length, file) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      type(c_ptr), intent(out) :: file
    end function sig_h5_open

    integer(c_int) function sig_h5_close(file) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function sig_h5_close

    integer(c_int) function sig_h5_write(file, address, length, type, rank, shape, values) bind(c)
      import :: c_char, c_int, c_int64_t, c_ptr, c_size_t
      type(c_ptr), value :: file
      character(kind=c_char), intent(in) :: address(*)
      integer(c_size_t), value :: length
      integer(c_int), value :: type
      integer(c_int), value :: rank
      integer(c_int64_t), intent(in) :: shape(*)
      type(*), intent(in) :: values(*)
    end function sig_h5_write

    integer(c_int) function sig_h5_write_rows(file, address, length, n_rows, row_size, rows) bind(c)
      import :: c_char, c_int, c_int64_t, c_ptr, c_size_t
      type(c_ptr), value :: file
      character(kind=c_char), intent(in) :: address(*)
      integer(c_size_t), value :: length
      integer(c_int64_t), value :: n_rows
      integer(c_int64_t), value :: row_size
      type(c_ptr), intent(in) :: rows(*)
    end function sig_h5_write_rows

    integer(c_int) function sig_h5_write_texts(file, address, length, rank, n, characters, ends) bind(c)
      import :: c_char, c_int, c_int64_t, c_ptr, c_size_t
      type(c_ptr), value :: file
      character(kind=c_char), intent(in) :: address(*)
      integer(c_size_t), value :: length
      integer(c_int), value :: rank
      integer(c_int64_t), value :: n
      character(kind=c_char), intent(in) :: characters(*)
      integer(c_int64_t), intent(in) :: ends(*)
    end function sig_h5_write_texts

    integer(c_int) function sig_h5_has(file, address, length) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      type(c_ptr), value :: file
      character(kind=c_char), intent(in) :: address(*)
      integer(c_size_t), value :: length
    end function sig_h5_has

    integer(c_int) function sig_h5_describe(file, address, length, type, rank, shape) bind(c)
      import :: c_char, c_int, c_int64_t, c_ptr, c_size_t
      type(c_ptr), value :: file
      character(kind=c_char), intent(in) :: address(*)
      integer(c_size_t), value :: length
      integer(c_int), intent(out) :: type
      integer(c_int), intent(out) :: rank
      integer(c_int64_t), intent(inout) :: shape(*)
    end function sig_h5_describe

    integer(c_int) function sig_h5_read(file, address, length, type, values) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      type(c_ptr), value :: file
      character(kind=c_char), intent(in) :: address(*)
      integer(c_size_t), value :: length
      integer(c_int), value :: type
      type(*), intent(inout) :: values(*)
    end function sig_h5_read

    integer(c_int) function sig_h5_read_part(file, address, length, first_row, n_rows, first_column, n_columns, values) bind(c)
      import :: c_char, c_double, c_int, c_int64_t, c_ptr, c_size_t
      type(c_ptr), value :: file
      character(kind=c_char), intent(in) :: address(*)
      integer(c_size_t), value :: length
      integer(c_int64_t), value :: first_row, n_rows, first_column, n_columns
      real(c_double), intent(inout) :: values(*)
    end function sig_h5_read_part

    integer(c_int) function sig_h5_read_texts(file, address, length, n, characters, ends) bind(c)
      import :: c_char, c_int, c_int64_t, c_ptr, c_size_t
      type(c_ptr), value :: file
      character(kind=c_char), intent(in) :: address(*)
      integer(c_size_t), value :: length
      integer(c_int64_t), intent(out) :: n
      type(c_ptr), intent(out) :: characters
      type(c_ptr), intent(out) :: ends
    end function sig_h5_read_texts
  end interface
end module sig_files_c_interfaces
