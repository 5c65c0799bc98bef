! SPDX-License-Identifier: BSD-3-Clause
!> Writes an HDF5 file of arrays, texts and attributes: create, write ..., close.
!>
!> The order of indices is reversed: a Fortran array of shape (n_dofs, n_modes) has the shape (n_modes, n_dofs) in h5py, with the
!> same bytes. Local: one rank writes the file.
module sig_hdf5_writer
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_int64_t, c_null_ptr, c_ptr, c_size_t
  use sig_errors, only: error_t, exit_internal, make_error
  use sig_file_seal, only: seal_file, seal_size
  use sig_file_system, only: remove_file
  use sig_system, only: system_reason
  use sig_hdf5_access, only: column_t, create_hdf5, integer_type, real_type, sig_h5_close, single_type, &
    write_array, write_columns, write_texts
  use sig_kinds, only: rk, sk
  use sig_output_stream, only: find_target
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: column_t, h5_writer_t

  !> A file that is written. It gets its name only by a close that succeeds; before, its name is `<path>.partial`. After the first
  !> write that fails, later writes do nothing, and close returns this first error. A file that is never closed is removed.
  !>
  !> `write(name, value [, unit, description])` writes a dataset and makes the groups in its name. The value is real of rank 0 to 3,
  !> real in single precision (sk) of rank 1, integer of rank 0 to 2, a text or a list of texts (string_t). A name with @, as
  !> `object@name`, is that of an attribute of a group or dataset: a number, a list or a text, without unit and description. An
  !> object that is missing becomes a group; '/' is the file itself.
  type :: h5_writer_t
    private
    type(c_ptr) :: handle = c_null_ptr
    !> empty for a file in memory
    character(:), allocatable :: path
    logical :: is_sealed = .false.
    type(error_t), allocatable :: error
  contains
    procedure :: create
    procedure :: close => close_file
    procedure :: create_image
    procedure :: close_image
    procedure :: discard => discard_file
    generic :: write => write_real, write_real_1, write_real_2, write_real_3, write_single_1, write_integer, &
      write_integer_1, write_integer_2, write_text, write_text_1
    procedure :: write_columns => write_real_columns
    procedure, private :: write_real, write_real_1, write_real_2, write_real_3, write_single_1, write_integer, write_integer_1
    procedure, private :: write_integer_2, write_text, write_text_1
    final :: finalize
  end type h5_writer_t

  ! include/signorom/file_system.h and include/signorom/hdf5_file.h describe these procedures in C.
  interface
    integer(c_int) function sig_commit_file(from, from_length, to, to_length) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: from(*)
      integer(c_size_t), value :: from_length
      character(kind=c_char), intent(in) :: to(*)
      integer(c_size_t), value :: to_length
    end function sig_commit_file

    integer(c_int) function sig_h5_create_image(file) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), intent(out) :: file
    end function sig_h5_create_image

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
  end interface

contains

  !> Starts a new file, and discards the one that is not closed. If the path is a symbolic link, the file to which it leads is
  !> replaced by close. Errors: no such folder, no right to write there, the path is a folder, a device, a pipe, in /proc or a
  !> circle of links. Then no file is open.
  subroutine create(self, path, error, is_sealed)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    !> whether the file gets a seal at its head (sig_file_seal); default no
    logical, intent(in), optional :: is_sealed

    call discard_file(self)
    self%is_sealed = .false.
    if (present(is_sealed)) self%is_sealed = is_sealed
    call find_target(path, self%path, error)
    if (allocated(error)) return
    call create_hdf5(path, self%path // '.partial', merge(seal_size, 0, self%is_sealed), self%handle, error)
  end subroutine create

  !> Closes the file. If no write failed, the file is written to the disk and gets its seal, if `create` was told so, and then
  !> its name. Otherwise it is removed, and an older file of this name stays. Does nothing if no file is open. Errors: the first
  !> failure since create; the file cannot be completed.
  subroutine close_file(self, error)
    class(h5_writer_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: code

    if (.not. c_associated(self%handle)) return
    code = sig_h5_close(self%handle)
    self%handle = c_null_ptr
    work: block
      if (allocated(self%error)) call move_alloc(self%error, error)
      if (allocated(error)) exit work
      if (code /= 0) call make_error(error, 'cannot write the file; is the disk full?', file=self%path)
      if (allocated(error)) exit work
      if (self%is_sealed) call seal_file(self%path // '.partial', error)
      if (allocated(error)) exit work
      call commit(self%path, error)
    end block work
    if (allocated(error)) call remove_partial(self%path)
  end subroutine close_file

  !> Starts a file in memory, which close_image ends, and discards the one that is not closed. Errors: not enough memory.
  subroutine create_image(self, error)
    class(h5_writer_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error

    call discard_file(self)
    self%path = ''
    if (sig_h5_create_image(self%handle) /= 0) call make_error(error, 'no memory for an HDF5 file', exit_code=exit_internal)
  end subroutine create_image

  !> Closes a file in memory and returns its bytes. Requires: create_image. Errors: the first failure since then, or not enough
  !> memory; then the bytes must not be used.
  subroutine close_image(self, bytes, error)
    class(h5_writer_t), intent(inout) :: self
    character(1), allocatable, intent(out) :: bytes(:)
    type(error_t), allocatable, intent(out) :: error
    integer(c_int64_t) :: n_bytes
    integer(c_int) :: ignored

    n_bytes = -1
    if (allocated(self%error)) call move_alloc(self%error, error)
    if (c_associated(self%handle) .and. .not. allocated(error)) n_bytes = sig_h5_image_size(self%handle)
    allocate (bytes(max(n_bytes, 0_c_int64_t)))
    if (n_bytes > 0) then
      if (sig_h5_get_image(self%handle, int(n_bytes, c_size_t), bytes) /= 0) n_bytes = -1
    end if
    if (n_bytes < 0 .and. .not. allocated(error)) call make_error(error, 'no memory for an HDF5 file', exit_code=exit_internal)
    ignored = sig_h5_close(self%handle)
    self%handle = c_null_ptr
  end subroutine close_image

  subroutine commit(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: partial
    integer(c_int) :: code

    partial = path // '.partial'
    code = sig_commit_file(partial, len(partial, c_size_t), path, len(path, c_size_t))
    if (code /= 0) call make_error(error, 'cannot write the file: ' // system_reason(code), file=path)
  end subroutine commit

  subroutine remove_partial(path)
    character(*), intent(in) :: path
    type(error_t), allocatable :: ignored

    call remove_file(path // '.partial', ignored)
  end subroutine remove_partial

  !> Closes and removes the open file, on the disk or in memory, if there is one, and forgets the first failure.
  subroutine discard_file(self)
    class(h5_writer_t), intent(inout) :: self
    integer(c_int) :: ignored

    if (allocated(self%error)) deallocate (self%error)
    if (.not. c_associated(self%handle)) return
    ignored = sig_h5_close(self%handle)
    self%handle = c_null_ptr
    if (len(self%path) > 0) call remove_partial(self%path)
  end subroutine discard_file

  subroutine finalize(self)
    type(h5_writer_t), intent(inout) :: self

    call discard_file(self)
  end subroutine finalize

  subroutine write_real(self, name, value, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: value
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, real_type, [integer ::], [value], unit, description)
  end subroutine write_real

  subroutine write_real_1(self, name, value, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: value(:)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, real_type, shape(value), value, unit, description)
  end subroutine write_real_1

  subroutine write_real_2(self, name, value, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: value(:, :)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, real_type, shape(value), value, unit, description)
  end subroutine write_real_2

  !> Writes a matrix of reals whose columns are at different places in memory, as `write` does with a matrix of rank 2:
  !> shape (n_rows, size(columns)).
  subroutine write_real_columns(self, name, columns, n_rows, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    type(column_t), intent(in) :: columns(:)
    !> size of each column
    integer, intent(in) :: n_rows
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    if (.not. may_write(self)) return
    call write_columns(self%handle, self%path, name, columns, n_rows, self%error)
    call describe(self, name, 'unit', unit)
    call describe(self, name, 'description', description)
  end subroutine write_real_columns

  subroutine write_real_3(self, name, value, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: value(:, :, :)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, real_type, shape(value), value, unit, description)
  end subroutine write_real_3

  subroutine write_single_1(self, name, value, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(sk), intent(in) :: value(:)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, single_type, shape(value), value, unit, description)
  end subroutine write_single_1

  subroutine write_integer(self, name, value, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: value
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, integer_type, [integer ::], [value], unit, description)
  end subroutine write_integer

  subroutine write_integer_1(self, name, value, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: value(:)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, integer_type, shape(value), value, unit, description)
  end subroutine write_integer_1

  subroutine write_integer_2(self, name, value, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: value(:, :)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, integer_type, shape(value), value, unit, description)
  end subroutine write_integer_2

  subroutine write_text(self, name, value, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(*), intent(in) :: value
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put_texts(self, name, list_of(value), .true., unit, description)
  end subroutine write_text

  subroutine write_text_1(self, name, value, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    type(string_t), intent(in) :: value(:)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put_texts(self, name, value, .false., unit, description)
  end subroutine write_text_1

  !> Writes numbers, and as attributes unit and description if they are given. Keeps the first failure, and does nothing after it or
  !> without an open file.
  subroutine put(self, address, type, shape, values, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: address
    integer(c_int), intent(in) :: type
    integer, intent(in) :: shape(:)
    type(*), intent(in) :: values(*)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    if (.not. may_write(self)) return
    call write_array(self%handle, self%path, address, type, shape, values, self%error)
    call describe(self, address, 'unit', unit)
    call describe(self, address, 'description', description)
  end subroutine put

  subroutine put_texts(self, address, texts, is_scalar, unit, description)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: address
    type(string_t), intent(in) :: texts(:)
    logical, intent(in) :: is_scalar
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    if (.not. may_write(self)) return
    call write_texts(self%handle, self%path, address, texts, is_scalar, self%error)
    call describe(self, address, 'unit', unit)
    call describe(self, address, 'description', description)
  end subroutine put_texts

  subroutine describe(self, address, name, text)
    class(h5_writer_t), intent(inout) :: self
    character(*), intent(in) :: address
    character(*), intent(in) :: name
    character(*), intent(in), optional :: text

    if (present(text) .and. may_write(self)) &
      call write_texts(self%handle, self%path, address // '@' // name, list_of(text), .true., self%error)
  end subroutine describe

  !> Returns a list of one text. Use it because gfortran 12 never frees the text in a constructor that is an actual argument.
  pure function list_of(text) result(texts)
    character(*), intent(in) :: text
    type(string_t) :: texts(1)

    texts(1)%text = text
  end function list_of

  pure logical function may_write(self)
    class(h5_writer_t), intent(in) :: self

    may_write = c_associated(self%handle) .and. .not. allocated(self%error)
  end function may_write
end module sig_hdf5_writer
