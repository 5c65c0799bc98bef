! SPDX-License-Identifier: BSD-3-Clause
!> An HDF5 file of arrays, texts and attributes: create, write ..., close; or open, read ..., close.
!>
!> HDF5 counts indices the other way round: a Fortran array of shape (n_dofs, n_modes) is one of shape (n_modes, n_dofs)
!> for h5py, with the same bytes. Reading turns it back. Local: one rank owns the file.
module sig_hdf5_file
  use, intrinsic :: iso_c_binding, only: c_associated, c_int, c_null_ptr, c_ptr, c_size_t
  use sig_base_c_interfaces, only: sig_commit_file, sig_h5_close, sig_h5_has
  use sig_errors, only: error_t, make_error
  use sig_file_system, only: remove_file, system_reason
  use sig_hdf5_access, only: create_hdf5, find_shape, integer_type, open_hdf5, read_array, read_texts, real_type, &
    text_type, write_array, write_texts
  use sig_kinds, only: rk
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: h5_file_t

  !> Writing: the file appears under its name only with a close that succeeds; before, it is `<path>.partial`.
  !> The first failure of a write is kept, later writes do nothing, and close hands it back. One that is never closed is removed.
  !>
  !> `write(name, value [, unit, description])`: value is real of rank 0 to 3, integer of rank 0 to 2, a text or a list
  !> of texts (string_t); groups in the name are made. `write_attribute(object, name, value)`: a text, integer, real, list of
  !> reals or of texts; an object that is missing is made as a group, '/' is the file itself.
  !> `read(name, value, error)`, `read_attribute(object, name, value, error)`: the same values, arrays and texts allocatable.
  !> A read does nothing where error is allocated already, so that a row of them needs one question at its end; after
  !> a failure value is zero or empty. Errors: missing, other type, other rank; integers may be read as reals.
  type :: h5_file_t
    private
    type(c_ptr) :: handle = c_null_ptr
    character(:), allocatable :: path
    logical :: is_new = .false.
    type(error_t), allocatable :: error
  contains
    procedure :: create
    procedure :: open => open_file
    procedure :: close => close_file
    procedure :: discard => discard_file
    procedure :: has
    procedure :: has_attribute
    procedure :: get_shape
    generic :: write => write_real, write_real_1, write_real_2, write_real_3, write_integer, write_integer_1, &
      write_integer_2, write_text, write_text_1
    generic :: write_attribute => write_real_attribute, write_real_1_attribute, write_integer_attribute, &
      write_text_attribute, write_text_1_attribute
    generic :: read => read_real, read_real_1, read_real_2, read_real_3, read_integer, read_integer_1, read_integer_2, &
      read_text, read_text_1
    generic :: read_attribute => read_real_attribute, read_real_1_attribute, read_integer_attribute, &
      read_text_attribute, read_text_1_attribute
    procedure, private :: write_real, write_real_1, write_real_2, write_real_3, write_integer, write_integer_1
    procedure, private :: write_integer_2, write_text, write_text_1
    procedure, private :: write_real_attribute, write_real_1_attribute, write_integer_attribute
    procedure, private :: write_text_attribute, write_text_1_attribute
    procedure, private :: read_real, read_real_1, read_real_2, read_real_3, read_integer, read_integer_1, read_integer_2
    procedure, private :: read_text, read_text_1
    procedure, private :: read_real_attribute, read_real_1_attribute, read_integer_attribute
    procedure, private :: read_text_attribute, read_text_1_attribute
    final :: finalize
  end type h5_file_t

contains

  !> Starts a new file. Errors: no such folder, no right to write there.
  subroutine create(self, path, error)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call discard_file(self)
    self%path = path
    self%is_new = .true.
    call create_hdf5(path, path // '.partial', self%handle, error)
  end subroutine create

  !> Opens a file for reading. Errors: no such file, not HDF5, cut off or damaged.
  subroutine open_file(self, path, error)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call discard_file(self)
    self%path = path
    self%is_new = .false.
    call open_hdf5(path, self%handle, error)
  end subroutine open_file

  !> Ends the work on the file. A new one is flushed to the disk and gets its name, unless a write failed.
  subroutine close_file(self, error)
    class(h5_file_t), intent(inout) :: self
    !> the first failure since create
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: code

    if (.not. c_associated(self%handle)) return
    if (allocated(self%error)) call move_alloc(self%error, error)
    code = sig_h5_close(self%handle)
    self%handle = c_null_ptr
    if (.not. self%is_new) return
    if (code /= 0 .and. .not. allocated(error)) call make_error(error, 'cannot write the file; is the disk full?', file=self%path)
    if (.not. allocated(error)) call commit(self%path, error)
    if (allocated(error)) call remove_partial(self%path)
  end subroutine close_file

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

  !> Gives up the file; a new one is removed. That none is open is fine.
  subroutine discard_file(self)
    class(h5_file_t), intent(inout) :: self
    integer(c_int) :: ignored

    if (allocated(self%error)) deallocate (self%error)
    if (.not. c_associated(self%handle)) return
    ignored = sig_h5_close(self%handle)
    self%handle = c_null_ptr
    if (self%is_new) call remove_partial(self%path)
  end subroutine discard_file

  subroutine finalize(self)
    type(h5_file_t), intent(inout) :: self

    call discard_file(self)
  end subroutine finalize

  !> True where the file has a group or dataset of this name.
  logical function has(self, name)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: name

    has = .false.
    if (c_associated(self%handle)) has = sig_h5_has(self%handle, name, len(name, c_size_t)) == 1
  end function has

  logical function has_attribute(self, object, name)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: object
    character(*), intent(in) :: name

    has_attribute = self%has(object // '@' // name)
  end function has_attribute

  !> Fortran shape of a dataset, empty for a scalar.
  subroutine get_shape(self, name, shape, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, allocatable, intent(out) :: shape(:)
    type(error_t), allocatable, intent(inout) :: error

    call shape_for(self, name, 0_c_int, -1, shape, error)
  end subroutine get_shape

  subroutine write_real(self, name, value, unit, description)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: value
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, real_type, [integer ::], [value], unit, description)
  end subroutine write_real

  subroutine write_real_1(self, name, value, unit, description)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: value(:)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, real_type, shape(value), value, unit, description)
  end subroutine write_real_1

  subroutine write_real_2(self, name, value, unit, description)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: value(:, :)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, real_type, shape(value), value, unit, description)
  end subroutine write_real_2

  subroutine write_real_3(self, name, value, unit, description)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rk), intent(in) :: value(:, :, :)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, real_type, shape(value), value, unit, description)
  end subroutine write_real_3

  subroutine write_integer(self, name, value, unit, description)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: value
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, integer_type, [integer ::], [value], unit, description)
  end subroutine write_integer

  subroutine write_integer_1(self, name, value, unit, description)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: value(:)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, integer_type, shape(value), value, unit, description)
  end subroutine write_integer_1

  subroutine write_integer_2(self, name, value, unit, description)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: value(:, :)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put(self, name, integer_type, shape(value), value, unit, description)
  end subroutine write_integer_2

  subroutine write_text(self, name, value, unit, description)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(*), intent(in) :: value
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put_texts(self, name, list_of(value), .true., unit, description)
  end subroutine write_text

  subroutine write_text_1(self, name, value, unit, description)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: name
    type(string_t), intent(in) :: value(:)
    character(*), intent(in), optional :: unit
    character(*), intent(in), optional :: description

    call put_texts(self, name, value, .false., unit, description)
  end subroutine write_text_1

  subroutine write_real_attribute(self, object, name, value)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: object
    character(*), intent(in) :: name
    real(rk), intent(in) :: value

    call put(self, object // '@' // name, real_type, [integer ::], [value])
  end subroutine write_real_attribute

  subroutine write_real_1_attribute(self, object, name, value)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: object
    character(*), intent(in) :: name
    real(rk), intent(in) :: value(:)

    call put(self, object // '@' // name, real_type, shape(value), value)
  end subroutine write_real_1_attribute

  subroutine write_integer_attribute(self, object, name, value)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: object
    character(*), intent(in) :: name
    integer, intent(in) :: value

    call put(self, object // '@' // name, integer_type, [integer ::], [value])
  end subroutine write_integer_attribute

  subroutine write_text_attribute(self, object, name, value)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: object
    character(*), intent(in) :: name
    character(*), intent(in) :: value

    call put_texts(self, object // '@' // name, list_of(value), .true.)
  end subroutine write_text_attribute

  subroutine write_text_1_attribute(self, object, name, value)
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: object
    character(*), intent(in) :: name
    type(string_t), intent(in) :: value(:)

    call put_texts(self, object // '@' // name, value, .false.)
  end subroutine write_text_1_attribute

  !> Numbers, with unit and description where given; keeps the first failure.
  subroutine put(self, address, type, shape, values, unit, description)
    class(h5_file_t), intent(inout) :: self
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
    class(h5_file_t), intent(inout) :: self
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
    class(h5_file_t), intent(inout) :: self
    character(*), intent(in) :: address
    character(*), intent(in) :: name
    character(*), intent(in), optional :: text

    if (present(text) .and. may_write(self)) &
      call write_texts(self%handle, self%path, address // '@' // name, list_of(text), .true., self%error)
  end subroutine describe

  ! gfortran 12 never frees the text in a constructor that is an actual argument
  pure function list_of(text) result(texts)
    character(*), intent(in) :: text
    type(string_t) :: texts(1)

    texts(1)%text = text
  end function list_of

  pure logical function may_write(self)
    class(h5_file_t), intent(in) :: self

    may_write = c_associated(self%handle) .and. self%is_new .and. .not. allocated(self%error)
  end function may_write

  subroutine read_real(self, name, value, error)
    class(h5_file_t), intent(in) :: self
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
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: name
    real(rk), allocatable, intent(out) :: value(:)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, name, real_type, 1, n, error)
    allocate (value(n(1)))
    call get(self, name, real_type, value, error)
  end subroutine read_real_1

  subroutine read_real_2(self, name, value, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: name
    real(rk), allocatable, intent(out) :: value(:, :)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, name, real_type, 2, n, error)
    allocate (value(n(1), n(2)))
    call get(self, name, real_type, value, error)
  end subroutine read_real_2

  subroutine read_real_3(self, name, value, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: name
    real(rk), allocatable, intent(out) :: value(:, :, :)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, name, real_type, 3, n, error)
    allocate (value(n(1), n(2), n(3)))
    call get(self, name, real_type, value, error)
  end subroutine read_real_3

  subroutine read_integer(self, name, value, error)
    class(h5_file_t), intent(in) :: self
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
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, allocatable, intent(out) :: value(:)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, name, integer_type, 1, n, error)
    allocate (value(n(1)))
    call get(self, name, integer_type, value, error)
  end subroutine read_integer_1

  subroutine read_integer_2(self, name, value, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: name
    integer, allocatable, intent(out) :: value(:, :)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, name, integer_type, 2, n, error)
    allocate (value(n(1), n(2)))
    call get(self, name, integer_type, value, error)
  end subroutine read_integer_2

  subroutine read_text(self, name, value, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: name
    character(:), allocatable, intent(out) :: value
    type(error_t), allocatable, intent(inout) :: error
    type(string_t), allocatable :: texts(:)

    call get_texts(self, name, 0, texts, error)
    value = ''
    if (size(texts) == 1) value = texts(1)%text
  end subroutine read_text

  subroutine read_text_1(self, name, value, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: name
    type(string_t), allocatable, intent(out) :: value(:)
    type(error_t), allocatable, intent(inout) :: error

    call get_texts(self, name, 1, value, error)
  end subroutine read_text_1

  subroutine read_real_attribute(self, object, name, value, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: object
    character(*), intent(in) :: name
    real(rk), intent(out) :: value
    type(error_t), allocatable, intent(inout) :: error
    real(rk) :: values(1)
    integer, allocatable :: n(:)

    values = 0
    call shape_for(self, object // '@' // name, real_type, 0, n, error)
    call get(self, object // '@' // name, real_type, values, error)
    value = values(1)
  end subroutine read_real_attribute

  subroutine read_real_1_attribute(self, object, name, value, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: object
    character(*), intent(in) :: name
    real(rk), allocatable, intent(out) :: value(:)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: n(:)

    call shape_for(self, object // '@' // name, real_type, 1, n, error)
    allocate (value(n(1)))
    call get(self, object // '@' // name, real_type, value, error)
  end subroutine read_real_1_attribute

  subroutine read_integer_attribute(self, object, name, value, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: object
    character(*), intent(in) :: name
    integer, intent(out) :: value
    type(error_t), allocatable, intent(inout) :: error
    integer :: values(1)
    integer, allocatable :: n(:)

    values = 0
    call shape_for(self, object // '@' // name, integer_type, 0, n, error)
    call get(self, object // '@' // name, integer_type, values, error)
    value = values(1)
  end subroutine read_integer_attribute

  subroutine read_text_attribute(self, object, name, value, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: object
    character(*), intent(in) :: name
    character(:), allocatable, intent(out) :: value
    type(error_t), allocatable, intent(inout) :: error
    type(string_t), allocatable :: texts(:)

    call get_texts(self, object // '@' // name, 0, texts, error)
    value = ''
    if (size(texts) == 1) value = texts(1)%text
  end subroutine read_text_attribute

  subroutine read_text_1_attribute(self, object, name, value, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: object
    character(*), intent(in) :: name
    type(string_t), allocatable, intent(out) :: value(:)
    type(error_t), allocatable, intent(inout) :: error

    call get_texts(self, object // '@' // name, 1, value, error)
  end subroutine read_text_1_attribute

  !> Shape of an array that is to be read; zeros where it cannot be, or where a read before it failed.
  subroutine shape_for(self, address, type, rank, shape, error)
    class(h5_file_t), intent(in) :: self
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
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: address
    integer(c_int), intent(in) :: type
    type(*), intent(inout) :: values(*)
    type(error_t), allocatable, intent(inout) :: error

    if (.not. allocated(error)) call read_array(self%handle, self%path, address, type, values, error)
  end subroutine get

  subroutine get_texts(self, address, rank, texts, error)
    class(h5_file_t), intent(in) :: self
    character(*), intent(in) :: address
    integer, intent(in) :: rank
    type(string_t), allocatable, intent(out) :: texts(:)
    type(error_t), allocatable, intent(inout) :: error
    integer, allocatable :: shape(:)

    call shape_for(self, address, text_type, rank, shape, error)
    if (.not. allocated(error)) call read_texts(self%handle, self%path, address, texts, error)
    if (.not. allocated(texts)) allocate (texts(0))
  end subroutine get_texts
end module sig_hdf5_file
