! SPDX-License-Identifier: BSD-3-Clause
!> Reads and writes one HDF5 array, text or attribute. Failures are errors with the file's name. Only sig_hdf5_reader and
!> sig_hdf5_writer use these procedures.
!>
!> An address is the name of a dataset (`/clusters/1/basis`) or, with an @, of an attribute (`/clusters/1@rank`). `handle` is that
!> of create_hdf5, open_hdf5 or of a file in memory, and `path` is the file's name for messages.
module sig_hdf5_access
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_f_pointer, c_int, c_int64_t, c_loc, c_null_ptr, c_ptr, c_size_t
  use sig_c_strings, only: from_c, sig_free
  use sig_errors, only: error_t, make_error
  use sig_file_system, only: file_exists, is_directory
  use sig_kinds, only: lk, rk
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: create_hdf5, open_hdf5, write_array, write_columns, write_texts, find_shape, read_array, read_columns, read_texts, &
    sig_h5_close
  public :: column_t, real_type, integer_type, text_type, single_type

  !> A pointer to one column of a matrix.
  type :: column_t
    real(rk), pointer, contiguous :: values(:) => null()
  end type column_t

  ! the same values as in hdf5_file.h
  integer(c_int), parameter :: real_type = 1, integer_type = 2, text_type = 3, single_type = 4
  integer(c_int), parameter :: not_hdf5 = 1, damaged = 2, locked = 3, missing = 7, elsewhere = 8, too_large = 9
  integer, parameter :: max_rank = 8

  ! include/signorom/hdf5_file.h describes these procedures in C.
  interface
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

contains

  !> Creates the file `partial`; a file or link of this name is replaced. If a signal ends the process by force (sig_signals), the
  !> file is removed. The handle is null after an error. Errors are for example: no right to write there, no such folder.
  subroutine create_hdf5(path, partial, n_free, handle, error)
    !> name of the file for messages
    character(*), intent(in) :: path
    !> name of the file while it is incomplete
    character(*), intent(in) :: partial
    !> number of bytes at the head of the file that HDF5 does not use: 0, 512, 1024, 2048, ...
    integer, intent(in) :: n_free
    type(c_ptr), intent(out) :: handle
    type(error_t), allocatable, intent(out) :: error

    if (sig_h5_create(partial, len(partial, c_size_t), int(n_free, c_size_t), handle) /= 0) &
      call make_error(error, 'cannot create the HDF5 file; check that the folder exists and that you may write there', file=path)
  end subroutine create_hdf5

  !> Opens a file for reading. Errors: no such file, a folder, not readable, not HDF5, cut off or damaged, with a superblock of
  !> another version than 0, in use by a writer, cannot be locked. Then the handle is null.
  subroutine open_hdf5(path, handle, error)
    character(*), intent(in) :: path
    type(c_ptr), intent(out) :: handle
    type(error_t), allocatable, intent(out) :: error

    handle = c_null_ptr
    if (is_directory(path)) then
      call make_error(error, 'this is a folder; an HDF5 file is needed', file=path)
    else if (.not. file_exists(path)) then
      call make_error(error, 'no such file', file=path)
    else
      select case (sig_h5_open(path, len(path, c_size_t), handle))
      case (0)
      case (not_hdf5)
        call make_error(error, 'this is not an HDF5 file, or it cannot be read', file=path)
      case (damaged)
        call make_error(error, 'the HDF5 file is cut off or damaged, or has a newer layout of HDF5 than is read here', file=path, &
          hint='make it again; with h5py take libver=''earliest''')
      case (locked)
        call make_error(error, 'the HDF5 file cannot be locked: another program has it open for writing, or the file system ' // &
          'has no locks', file=path, hint='wait until the other program ends; without locks set HDF5_USE_FILE_LOCKING=FALSE')
      case default
        call make_error(error, 'cannot read the HDF5 file', file=path)
      end select
    end if
  end subroutine open_hdf5

  !> Returns `the dataset /a/b` or `the attribute c of /a/b`, for messages.
  pure function address_text(address) result(text)
    character(*), intent(in) :: address
    character(:), allocatable :: text
    integer :: i_at

    i_at = index(address, '@')
    if (i_at == 0) then
      text = 'the dataset ' // address
    else
      text = 'the attribute ' // address(i_at + 1:) // ' of ' // address(:i_at - 1)
    end if
  end function address_text

  !> Writes numbers, and makes the groups in the address. The file has the Fortran shape in reverse order. Errors: the disk is full,
  !> the address exists already, the values of an attribute take more than 64 KiB, or the rank is above 8.
  subroutine write_array(handle, path, address, type, shape, values, error)
    type(c_ptr), intent(in) :: handle
    character(*), intent(in) :: path
    character(*), intent(in) :: address
    !> real_type, single_type or integer_type
    integer(c_int), intent(in) :: type
    !> Fortran shape; empty for a scalar
    integer, intent(in) :: shape(:)
    !> real(rk), real(sk) or integer, as type says
    type(*), intent(in) :: values(*)
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: status

    status = sig_h5_write(handle, address, len(address, c_size_t), type, size(shape), &
      int(shape(size(shape):1:-1), c_int64_t), values)
    if (status /= 0) call report_write(path, address, error)
  end subroutine write_array

  !> Writes a matrix of reals, shape (n_rows, size(columns)), as a dataset. Its columns are at different places in memory; no matrix
  !> is made of them. Errors: as write_array.
  subroutine write_columns(handle, path, address, columns, n_rows, error)
    type(c_ptr), intent(in) :: handle
    character(*), intent(in) :: path
    character(*), intent(in) :: address
    type(column_t), intent(in) :: columns(:)
    !> size of each column
    integer, intent(in) :: n_rows
    type(error_t), allocatable, intent(out) :: error
    type(c_ptr) :: starts(size(columns))
    integer(c_int) :: status
    integer :: i

    starts = c_null_ptr
    if (n_rows > 0) starts = [(c_loc(columns(i)%values), i=1, size(columns))]
    status = sig_h5_write_rows(handle, address, len(address, c_size_t), size(columns, kind=c_int64_t), int(n_rows, c_int64_t), &
      starts)
    if (status /= 0) call report_write(path, address, error)
  end subroutine write_columns

  !> Writes a list of texts, or with is_scalar only its first text, and not as a list. Errors: as write_array.
  !> Requires: with is_scalar, at least one text.
  subroutine write_texts(handle, path, address, texts, is_scalar, error)
    type(c_ptr), intent(in) :: handle
    character(*), intent(in) :: path
    character(*), intent(in) :: address
    type(string_t), intent(in) :: texts(:)
    logical, intent(in) :: is_scalar
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: characters
    integer(c_int64_t) :: ends(size(texts))
    integer(c_int) :: status
    integer :: i_end, i_text

    i_end = 0
    do i_text = 1, size(texts)
      i_end = i_end + len(texts(i_text)%text)
      ends(i_text) = i_end
    end do
    allocate (character(i_end) :: characters)
    i_end = 0
    do i_text = 1, size(texts)
      characters(i_end + 1:int(ends(i_text))) = texts(i_text)%text
      i_end = int(ends(i_text))
    end do
    status = sig_h5_write_texts(handle, address, len(address, c_size_t), merge(0, 1, is_scalar), &
      size(texts, kind=c_int64_t), characters, ends)
    if (status /= 0) call report_write(path, address, error)
  end subroutine write_texts

  subroutine report_write(path, address, error)
    character(*), intent(in) :: path
    character(*), intent(in) :: address
    type(error_t), allocatable, intent(out) :: error

    call make_error(error, 'cannot write ' // address_text(address) // '; check whether the disk is full or the name exists ' // &
      'already', file=path)
  end subroutine report_write

  !> Returns the Fortran shape of an array, and checks its type and rank. Errors: it is missing or a group, has another type or
  !> rank or a rank above 8, has more values than are stored in the file, is damaged, is reached by a link, or its values are not in
  !> the file itself in one piece. Then the shape is `rank` zeros, or empty if the rank is -1.
  subroutine find_shape(handle, path, address, type, rank, shape, error)
    type(c_ptr), intent(in) :: handle
    character(*), intent(in) :: path
    character(*), intent(in) :: address
    !> expected type: real_type, which takes integers, too, integer_type or text_type; 0 takes any type
    integer(c_int), intent(in) :: type
    !> expected rank; -1 takes any rank
    integer, intent(in) :: rank
    integer, allocatable, intent(out) :: shape(:)
    type(error_t), allocatable, intent(out) :: error
    integer(c_int64_t) :: shape_in_c(max_rank)
    integer(c_int) :: found_rank, found_type, status

    status = sig_h5_describe(handle, address, len(address, c_size_t), found_type, found_rank, shape_in_c)
    if (status /= 0) then
      call report_read(path, address, status, error)
    else if (.not. is_type_fine(type, found_type)) then
      call make_error(error, address_text(address) // ' holds ' // type_text(found_type) // ' where ' // type_text(type) // &
        ' are needed', file=path)
    else if (rank >= 0 .and. found_rank /= rank) then
      call make_error(error, address_text(address) // ' has rank ' // to_text(found_rank) // ' where ' // to_text(rank) // &
        ' is needed', file=path)
    else if (any(shape_in_c(:found_rank) > huge(found_rank))) then
      call make_error(error, address_text(address) // ' is too large: ' // to_text(maxval(shape_in_c(:found_rank))) // &
        ' entries along one dimension', file=path)
    end if
    if (allocated(error)) then
      allocate (shape(max(rank, 0)), source=0)
    else
      shape = int(shape_in_c(found_rank:1:-1))
    end if
  end subroutine find_shape

  subroutine report_read(path, address, status, error)
    character(*), intent(in) :: path
    character(*), intent(in) :: address
    !> status of hdf5_file.h, not 0
    integer(c_int), intent(in) :: status
    type(error_t), allocatable, intent(out) :: error

    select case (status)
    case (missing)
      call make_error(error, address_text(address) // ' is missing', file=path)
    case (elsewhere)
      call make_error(error, address_text(address) // ' is reached by a soft or external link, or its values are chunked, ' // &
        'compressed or in another file; such values are not read', file=path, &
        hint='with h5py, create the dataset without chunks, maxshape and compression')
    case (too_large)
      call make_error(error, address_text(address) // ' claims more values than are stored in the file (perhaps it was never ' // &
        'filled), or too much was read from this file already', file=path)
    case default
      call make_error(error, 'cannot read ' // address_text(address) // '; is the file damaged?', file=path)
    end select
  end subroutine report_read

  pure logical function is_type_fine(wanted, found)
    integer(c_int), intent(in) :: wanted
    integer(c_int), intent(in) :: found

    is_type_fine = wanted == 0 .or. wanted == found .or. (wanted == real_type .and. found == integer_type)
  end function is_type_fine

  pure function type_text(type) result(text)
    integer(c_int), intent(in) :: type
    character(:), allocatable :: text

    select case (type)
    case (real_type)
      text = 'real numbers'
    case (integer_type)
      text = 'integers'
    case (text_type)
      text = 'texts'
    case default
      text = 'values of another kind'
    end select
  end function type_text

  !> Reads numbers into an array that has the shape that find_shape returned. Errors: those of find_shape but for the rank; the
  !> values cannot be read; all reads since the file was opened take more than 8 times its size + 1 MiB. Then the values must not be
  !> used.
  subroutine read_array(handle, path, address, type, values, error)
    type(c_ptr), intent(in) :: handle
    character(*), intent(in) :: path
    character(*), intent(in) :: address
    !> real_type, single_type or integer_type
    integer(c_int), intent(in) :: type
    !> real(rk), real(sk) or integer, as type says
    type(*), intent(inout) :: values(*)
    type(error_t), allocatable, intent(out) :: error

    integer(c_int) :: status

    status = sig_h5_read(handle, address, len(address, c_size_t), type, values)
    if (status /= 0) call report_read(path, address, status, error)
  end subroutine read_array

  !> Reads consecutive rows of consecutive columns of a dataset that is a matrix of numbers, in Fortran's order of indices; as many
  !> as `values` has. Errors: those of read_array; rows or columns that the matrix does not have. If `values` is empty, and
  !> first_row and i_column are at least 1, there is no error.
  subroutine read_columns(handle, path, address, first_row, i_column, values, error)
    type(c_ptr), intent(in) :: handle
    character(*), intent(in) :: path
    character(*), intent(in) :: address
    !> 1-based
    integer, intent(in) :: first_row
    !> first column, 1-based
    integer, intent(in) :: i_column
    !> shape (n_rows, n_columns)
    real(rk), contiguous, intent(inout) :: values(:, :)
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: status

    status = sig_h5_read_part(handle, address, len(address, c_size_t), i_column - 1_c_int64_t, size(values, 2, c_int64_t), &
      first_row - 1_c_int64_t, size(values, 1, c_int64_t), values)
    if (status /= 0) call report_read(path, address, status, error)
  end subroutine read_columns

  !> Reads texts of any rank as a list, in the order of the file; a scalar text gives a list of one text. Errors: those of
  !> read_array, and values that are no texts. Then the list is empty.
  subroutine read_texts(handle, path, address, texts, error)
    type(c_ptr), intent(in) :: handle
    character(*), intent(in) :: path
    character(*), intent(in) :: address
    type(string_t), allocatable, intent(out) :: texts(:)
    type(error_t), allocatable, intent(out) :: error
    type(c_ptr) :: characters, ends
    integer(c_int64_t), pointer :: end_of(:)
    character(:), allocatable :: packed
    integer(c_int64_t) :: n, i_start
    integer(c_int) :: status
    integer :: i_text

    status = sig_h5_read_texts(handle, address, len(address, c_size_t), n, characters, ends)
    if (status /= 0) then
      call report_read(path, address, status, error)
      allocate (texts(0))
      return
    end if
    allocate (texts(n))
    if (n > 0) then
      call c_f_pointer(ends, end_of, [n])
      packed = from_c(characters, int(end_of(n), c_size_t))
      i_start = 1
      do i_text = 1, int(n)
        texts(i_text)%text = packed(i_start:end_of(i_text))
        i_start = end_of(i_text) + 1
      end do
    end if
    call sig_free(characters)
    call sig_free(ends)
  end subroutine read_texts
end module sig_hdf5_access
