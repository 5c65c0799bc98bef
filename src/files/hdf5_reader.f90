! SPDX-License-Identifier: BSD-3-Clause
!> Reads an HDF5 file of arrays, texts and attributes: open, read ..., close.
!>
!> The order of indices is reversed: an array of shape (n_modes, n_dofs) in h5py has the Fortran shape (n_dofs, n_modes), with the
!> same bytes. Local: one rank reads the file.
module sig_hdf5_reader
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_ptr, c_ptr, c_size_t
  use sig_errors, only: error_t, exit_internal, make_error
  use sig_hdf5_access, only: find_shape, integer_type, open_hdf5, read_array, read_columns, read_texts, real_type, sig_h5_close, &
    single_type, text_type
  use sig_kinds, only: rk, sk
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: h5_reader_t

  !> A file that is read.
  !>
  !> `read(name, value, error)` reads the dataset `name`. The value is real of rank 0 to 3, real in single precision (sk) of rank 1,
  !> integer of rank 0 to 2, a text or a list of texts (string_t); arrays and texts are allocatable. A name with @, as
  !> `object@name`, is that of an attribute of a group or dataset: a text, integer, real, list of reals or of texts. Integers in the
  !> file may be read as reals.
  !>
  !> Errors: those of find_shape and read_array in sig_hdf5_access. Then the value is zero or empty, or, if the array
  !> was found, not defined. If `error` is allocated before, nothing is read; so a caller needs one check after several reads.
  type :: h5_reader_t
    private
    type(c_ptr) :: handle = c_null_ptr
    character(:), allocatable :: path
  contains
    procedure :: open => open_file
    procedure :: open_image
    procedure :: close => close_file
    procedure :: has
    procedure :: count_groups
    procedure :: all_groups
    procedure :: get_shape
    procedure :: read_block
    generic :: read => read_real, read_real_1, read_real_2, read_real_3, read_single_1, read_integer, read_integer_1, &
      read_integer_2, read_text, read_text_1
    procedure, private :: read_real, read_real_1, read_real_2, read_real_3, read_single_1, read_integer, read_integer_1
    procedure, private :: read_integer_2
    procedure, private :: read_text, read_text_1
    final :: finalize
  end type h5_reader_t

  ! include/signorom/hdf5_file.h describes these procedures in C.
  interface
    integer(c_int) function sig_h5_open_image(bytes, size, file) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: bytes(*)
      integer(c_size_t), value :: size
      type(c_ptr), intent(out) :: file
    end function sig_h5_open_image

    integer(c_int) function sig_h5_has(file, address, length) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      type(c_ptr), value :: file
      character(kind=c_char), intent(in) :: address(*)
      integer(c_size_t), value :: length
    end function sig_h5_has
  end interface

contains

  !> Opens a file for reading, after it has closed the one that is open. Errors: those of open_hdf5 (no such file, a folder, not
  !> HDF5, cut off or damaged, ...). Then no file is open.
  subroutine open_file(self, path, error)
    class(h5_reader_t), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call close_file(self)
    self%path = path
    call open_hdf5(path, self%handle, error)
  end subroutine open_file

  !> Opens a file from its bytes in memory, which are copied, after it has closed the one that is open. Errors: the bytes are not an
  !> HDF5 file, or memory is not enough. Then no file is open.
  subroutine open_image(self, bytes, error)
    class(h5_reader_t), intent(inout) :: self
    character(1), intent(in) :: bytes(:)
    type(error_t), allocatable, intent(out) :: error

    call close_file(self)
    self%path = ''
    if (sig_h5_open_image(bytes, size(bytes, kind=c_size_t), self%handle) /= 0) &
      call make_error(error, 'an HDF5 file in memory, which another rank sent, cannot be read: its bytes are damaged, or ' // &
      'there is not enough memory', exit_code=exit_internal)
  end subroutine open_image

  !> Closes the file. Does nothing if no file is open.
  subroutine close_file(self)
    class(h5_reader_t), intent(inout) :: self
    integer(c_int) :: ignored

    if (.not. c_associated(self%handle)) return
    ignored = sig_h5_close(self%handle)
    self%handle = c_null_ptr
  end subroutine close_file

  subroutine finalize(self)
    type(h5_reader_t), intent(inout) :: self

    call close_file(self)
  end subroutine finalize

  !> Whether the file has a group or dataset of this name, or an attribute `object@name`. A link or a damaged object counts, too, so
  !> that reading it fails with a reason. False if no file is open.
  logical function has(self, name)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name

    has = .false.
    if (c_associated(self%handle)) has = sig_h5_has(self%handle, name, len(name, c_size_t)) == 1
  end function has

  !> Returns how many of the groups name/1, name/2, ..., name/n exist before the first one that is missing: n if all exist, 0 for
  !> n < 0. Whatever `has` finds counts as a group. So a caller can check an n that it has read from a file.
  integer function count_groups(self, name, n) result(n_found)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: n

    do n_found = 0, n - 1
      if (.not. self%has(name // '/' // to_text(n_found + 1))) return
    end do
    n_found = max(n, 0)
  end function count_groups

  !> Returns n if all of the groups name/1, name/2, ..., name/n exist, otherwise 0: a list that is not whole counts as empty, and
  !> what the caller checks then refuses the file.
  integer function all_groups(self, name, n)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: n

    all_groups = self%count_groups(name, n)
    if (all_groups < n) all_groups = 0
  end function all_groups

  !> Returns the Fortran shape of a dataset of any type and rank; empty for a scalar and after an error, also an earlier one.
  !> Errors: as read.
  subroutine get_shape(self, name, shape, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, allocatable, intent(out) :: shape(:)
    type(error_t), allocatable, intent(inout) :: error

    call shape_for(self, name, 0_c_int, -1, shape, error)
  end subroutine get_shape

  !> Reads consecutive rows of given columns of a matrix of numbers, in Fortran's order of indices, without reading the rest.
  !> Errors: as read; rows or columns that do not exist. Then the values must not be used. With last < first there are no rows. That
  !> is no error, if first and the columns are at least 1.
  subroutine read_block(self, name, first, last, columns, values, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    !> first and last row, 1-based
    integer, intent(in) :: first
    integer, intent(in) :: last
    !> columns, 1-based, in any order
    integer, intent(in) :: columns(:)
    !> shape (max(0, last - first + 1), size(columns))
    real(rk), allocatable, intent(out) :: values(:, :)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)
    integer :: i, i_end

    call shape_for(self, name, real_type, 2, n, error)
    allocate (values(max(0, last - first + 1), size(columns)), source=0.0_rk)
    i = 1
    do while (i <= size(columns) .and. .not. allocated(error))
      i_end = end_of_run(columns, i)
      call read_columns(self%handle, self%path, name, first, columns(i), values(:, i:i_end), error)
      i = i_end + 1
    end do
  end subroutine read_block

  !> Returns the last index of the run that starts at index i: each of its numbers is the one before plus 1. Requires: i is an index
  !> of the numbers.
  pure integer function end_of_run(numbers, i) result(i_end)
    integer, intent(in) :: numbers(:)
    integer, intent(in) :: i

    do i_end = i, size(numbers) - 1
      if (numbers(i_end + 1) /= numbers(i_end) + 1) return
    end do
    i_end = size(numbers)
  end function end_of_run

  subroutine read_real(self, name, value, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    real(rk), intent(out) :: value
    type(error_t), allocatable, intent(inout) :: error
    real(rk) :: values(1)
    integer, allocatable :: n(:)

    values = 0
    call shape_for(self, name, real_type, 0, n, error)
    call get(self, name, real_type, values, error)
    value = values(1)
  end subroutine read_real

  subroutine read_real_1(self, name, value, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    real(rk), allocatable, intent(out) :: value(:)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, name, real_type, 1, n, error)
    allocate (value(n(1)))
    call get(self, name, real_type, value, error)
  end subroutine read_real_1

  subroutine read_real_2(self, name, value, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    real(rk), allocatable, intent(out) :: value(:, :)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, name, real_type, 2, n, error)
    allocate (value(n(1), n(2)))
    call get(self, name, real_type, value, error)
  end subroutine read_real_2

  subroutine read_real_3(self, name, value, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    real(rk), allocatable, intent(out) :: value(:, :, :)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, name, real_type, 3, n, error)
    allocate (value(n(1), n(2), n(3)))
    call get(self, name, real_type, value, error)
  end subroutine read_real_3

  subroutine read_single_1(self, name, value, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    real(sk), allocatable, intent(out) :: value(:)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, name, real_type, 1, n, error)
    allocate (value(n(1)))
    call get(self, name, single_type, value, error)
  end subroutine read_single_1

  subroutine read_integer(self, name, value, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, intent(out) :: value
    type(error_t), allocatable, intent(inout) :: error
    integer :: values(1)
    integer, allocatable :: n(:)

    values = 0
    call shape_for(self, name, integer_type, 0, n, error)
    call get(self, name, integer_type, values, error)
    value = values(1)
  end subroutine read_integer

  subroutine read_integer_1(self, name, value, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, allocatable, intent(out) :: value(:)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, name, integer_type, 1, n, error)
    allocate (value(n(1)))
    call get(self, name, integer_type, value, error)
  end subroutine read_integer_1

  subroutine read_integer_2(self, name, value, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, allocatable, intent(out) :: value(:, :)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, name, integer_type, 2, n, error)
    allocate (value(n(1), n(2)))
    call get(self, name, integer_type, value, error)
  end subroutine read_integer_2

  subroutine read_text(self, name, value, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    character(:), allocatable, intent(out) :: value
    type(error_t), allocatable, intent(inout) :: error
    type(string_t), allocatable :: texts(:)

    call get_texts(self, name, 0, texts, error)
    value = ''
    if (size(texts) == 1) value = texts(1)%text
  end subroutine read_text

  subroutine read_text_1(self, name, value, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: name
    type(string_t), allocatable, intent(out) :: value(:)
    type(error_t), allocatable, intent(inout) :: error

    call get_texts(self, name, 1, value, error)
  end subroutine read_text_1

  !> Returns the shape of an array that is to be read. After an error, also an earlier one, it is `rank` zeros, or empty if the rank
  !> is -1. Arguments and errors: those of find_shape; no file is open.
  subroutine shape_for(self, address, type, rank, shape, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: address
    integer(c_int), intent(in) :: type
    integer, intent(in) :: rank
    integer, allocatable, intent(out) :: shape(:)
    type(error_t), allocatable, intent(inout) :: error

    allocate (shape(max(rank, 0)), source=0)
    if (allocated(error)) return
    if (c_associated(self%handle)) then
      call find_shape(self%handle, self%path, address, type, rank, shape, error)
    else
      call make_error(error, 'the HDF5 file is not open')
    end if
  end subroutine shape_for

  subroutine get(self, address, type, values, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: address
    integer(c_int), intent(in) :: type
    type(*), intent(inout) :: values(*)
    type(error_t), allocatable, intent(inout) :: error

    if (.not. allocated(error)) call read_array(self%handle, self%path, address, type, values, error)
  end subroutine get

  subroutine get_texts(self, address, rank, texts, error)
    class(h5_reader_t), intent(in) :: self
    character(*), intent(in) :: address
    integer, intent(in) :: rank
    type(string_t), allocatable, intent(out) :: texts(:)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: shape(:)

    call shape_for(self, address, text_type, rank, shape, error)
    if (.not. allocated(error)) call read_texts(self%handle, self%path, address, texts, error)
    if (.not. allocated(texts)) allocate (texts(0))
  end subroutine get_texts
end module sig_hdf5_reader
