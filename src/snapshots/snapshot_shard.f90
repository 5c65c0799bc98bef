! SPDX-License-Identifier: BSD-3-Clause
!> Shards: files to which each group of ranks appends its snapshots, so that a kill loses none. They are merged into the store at
!> the end of the sampling.
module sig_snapshot_shard
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_int, c_int64_t, c_null_ptr, c_ptr, c_size_t
  use sig_errors, only: error_t, make_error
  use sig_system, only: system_reason
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: snapshot_record_t, shard_content_t, shard_writer_t, check_shard, read_shard, append_records, move_record
  public :: n_residuals

  !> equilibrium, penetration, negative multiplier, complementarity, force balance
  integer, parameter :: n_residuals = 5
  !> residuals, seconds, n_iterations, reason
  integer, parameter :: n_extra = n_residuals + 3
  !> as in snapshot_shard.h
  integer(c_int), parameter :: foreign = -1, other_version = -2, other_provenance = -3, other_sizes = -4, short = -5, gone = -6

  !> One solved parameter point.
  type :: snapshot_record_t
    !> shape (n_parameters)
    real(rk), allocatable :: parameters(:)
    !> [length] shape (n_dofs)
    real(rk), allocatable :: displacement(:)
    !> [force] shape (n_multipliers)
    real(rk), allocatable :: multipliers(:)
    integer :: n_iterations = 0
    !> > 0 solved, < 0 failed: constants of sig_reasons
    integer :: reason = 0
    !> residuals of (3): equilibrium, penetration [length], negative multiplier, complementarity, force balance; others relative
    real(rk) :: residuals(n_residuals) = 0
    !> [s] wall time
    real(rk) :: seconds = 0
  end type snapshot_record_t

  !> What the records of a shard belong to, and the sizes of their arrays.
  type :: shard_content_t
    !> hash of the deck's physics and of the mesh
    character(16) :: provenance
    integer :: n_parameters
    !> 0 where displacements are not kept
    integer :: n_dofs
    integer :: n_multipliers
  contains
    procedure :: sizes => sizes_of
  end type shard_content_t

  !> A shard that is open for appending. Local: one rank of the group writes.
  type :: shard_writer_t
    !> number of whole records when the shard was opened, and number of records that were cut from its end then
    integer :: n_records = 0
    integer :: n_dropped = 0
    type(c_ptr), private :: handle = c_null_ptr
    integer, private :: sizes(4) = 0
    character(:), allocatable, private :: path
  contains
    procedure :: create
    procedure :: append
    procedure :: close => close_writer
  end type shard_writer_t

  interface
    integer(c_int) function sig_shard_open(path, length, provenance, sizes, is_writing, shard, n_records, n_dropped) bind(c)
      import :: c_char, c_int, c_int64_t, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      character(kind=c_char), intent(in) :: provenance(*)
      integer(c_int64_t), intent(in) :: sizes(*)
      integer(c_int), value :: is_writing
      type(c_ptr), intent(out) :: shard
      integer(c_int64_t), intent(out) :: n_records
      integer(c_int64_t), intent(out) :: n_dropped
    end function sig_shard_open

    integer(c_int) function sig_shard_read(shard, i_record, values) bind(c)
      import :: c_double, c_int, c_int64_t, c_ptr
      type(c_ptr), value :: shard
      integer(c_int64_t), value :: i_record
      real(c_double), intent(out) :: values(*)
    end function sig_shard_read

    integer(c_int) function sig_shard_append(shard, n_records, values) bind(c)
      import :: c_double, c_int, c_int64_t, c_ptr
      type(c_ptr), value :: shard
      integer(c_int64_t), value :: n_records
      real(c_double), intent(inout) :: values(*)
    end function sig_shard_append

    integer(c_int) function sig_shard_close(shard) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: shard
    end function sig_shard_close
  end interface

contains

  !> Opens a shard for appending. Creates it if it is missing; cuts off the first damaged record of an existing one and all behind
  !> it, and counts what is left and what was cut off in n_records and n_dropped.
  !>
  !> Errors: the file is no shard, is of another deck, mesh, size or format (it does not change then), or cannot be written.
  subroutine create(self, path, content, error)
    class(shard_writer_t), intent(inout) :: self
    character(*), intent(in) :: path
    type(shard_content_t), intent(in) :: content
    type(error_t), allocatable, intent(out) :: error

    self%path = path
    self%sizes = content%sizes()
    call open_shard(path, content, .true., self%handle, self%n_records, self%n_dropped, error)
  end subroutine create

  !> Returns the numbers of parameters, dofs, multipliers and further values of each record.
  pure function sizes_of(self) result(sizes)
    class(shard_content_t), intent(in) :: self
    integer :: sizes(4)

    sizes = [self%n_parameters, self%n_dofs, self%n_multipliers, n_extra]
  end function sizes_of

  !> Appends records. From then on a kill of the process does not lose them; a crash of the machine may lose the last ones.
  !>
  !> Errors: they cannot be written, because the disk is full or fails; the earlier records stay valid. The file was removed or
  !> moved.
  subroutine append(self, records, error)
    class(shard_writer_t), intent(inout) :: self
    !> sizes as those of the content given to create
    type(snapshot_record_t), intent(in) :: records(:)
    type(error_t), allocatable, intent(out) :: error
    !> a row more, for the hash
    real(rk) :: values(sum(self%sizes) + 1, size(records))
    integer(c_int) :: code
    integer :: i

    do i = 1, size(records)
      call pack_record(records(i), self%sizes, values(:, i))
    end do
    code = sig_shard_append(self%handle, size(records, kind=c_int64_t), values)
    if (code == 0) return
    if (code == gone) then
      call make_gone_error(self%path, error)
      return
    end if
    call make_error(error, 'cannot write the snapshot: ' // system_reason(code), file=self%path, &
      hint='the snapshots before it are safe; remove this cause (if the disk is full, make room) and run the same command again')
  end subroutine append

  !> Writes everything to the disk and closes the shard. Harmless if the writer is not open.
  !>
  !> Errors: the disk fails; the file was removed or moved. The shard is closed also then.
  subroutine close_writer(self, error)
    class(shard_writer_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: code

    code = sig_shard_close(self%handle)
    self%handle = c_null_ptr
    if (code == gone) then
      call make_gone_error(self%path, error)
    else if (code /= 0) then
      call make_error(error, 'cannot finish the snapshot file: ' // system_reason(code), file=self%path)
    end if
  end subroutine close_writer

  subroutine make_gone_error(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call make_error(error, 'the file of the finished points was removed or moved while the run wrote it', file=path, &
      hint='without it the same command solves its points again; put the file or the results folder back if it was moved')
  end subroutine make_gone_error

  !> Reads the records of a shard before the first damaged one, in the order in which they were written. The file does not change.
  !>
  !> Errors: the file is missing, is no shard, is of another deck, mesh, size or format, or cannot be read.
  subroutine read_shard(path, content, records, n_dropped, error)
    character(*), intent(in) :: path
    !> as for create
    type(shard_content_t), intent(in) :: content
    type(snapshot_record_t), allocatable, intent(out) :: records(:)
    !> number of records from the first damaged one on, the last one perhaps only a piece; a kill leaves at most one
    integer, intent(out) :: n_dropped
    type(error_t), allocatable, intent(out) :: error
    type(c_ptr) :: handle
    type(snapshot_record_t), allocatable :: found(:)
    real(rk), allocatable :: values(:)
    integer :: i_record, n_records, sizes(4)
    integer(c_int) :: code

    sizes = content%sizes()
    call open_shard(path, content, .false., handle, n_records, n_dropped, error)
    allocate (records(n_records))
    if (allocated(error)) return
    allocate (values(sum(sizes) + 1))
    do i_record = 1, n_records
      code = sig_shard_read(handle, int(i_record - 1, c_int64_t), values)
      if (code /= 0) exit
      call unpack_record(values, sizes, records(i_record))
    end do
    n_dropped = n_records - i_record + 1
    if (n_dropped > 0 .and. code /= short) call make_error(error, 'cannot read the snapshots: ' // system_reason(code), file=path)
    if (n_dropped > 0) then
      allocate (found(0))
      call append_records(records(:i_record - 1), found)
      call move_alloc(found, records)
    end if
    code = sig_shard_close(handle)
  end subroutine read_shard

  !> Finds out whether a shard, to which another run may be appending, belongs to the same study. Reads no record. Errors: those of
  !> read_shard.
  subroutine check_shard(path, content, error)
    character(*), intent(in) :: path
    type(shard_content_t), intent(in) :: content
    type(error_t), allocatable, intent(out) :: error
    type(c_ptr) :: handle
    integer :: n_dropped, n_records
    integer(c_int) :: code

    call open_shard(path, content, .false., handle, n_records, n_dropped, error)
    code = sig_shard_close(handle)
  end subroutine check_shard

  !> Appends records to a list. Their arrays are moved, not copied: those of `records` are not allocated afterwards.
  pure subroutine append_records(records, list)
    type(snapshot_record_t), intent(inout) :: records(:)
    !> must be allocated, maybe empty
    type(snapshot_record_t), allocatable, intent(inout) :: list(:)
    type(snapshot_record_t), allocatable :: longer(:)
    integer :: i, n

    n = size(list)
    allocate (longer(n + size(records)))
    do i = 1, n
      call move_record(list(i), longer(i))
    end do
    do i = 1, size(records)
      call move_record(records(i), longer(n + i))
    end do
    call move_alloc(longer, list)
  end subroutine append_records

  !> Moves a record. Afterwards the arrays of `from` are not allocated.
  pure subroutine move_record(from, to)
    type(snapshot_record_t), intent(inout) :: from
    type(snapshot_record_t), intent(inout) :: to

    call move_alloc(from%parameters, to%parameters)
    call move_alloc(from%displacement, to%displacement)
    call move_alloc(from%multipliers, to%multipliers)
    to%n_iterations = from%n_iterations
    to%reason = from%reason
    to%residuals = from%residuals
    to%seconds = from%seconds
  end subroutine move_record

  !> Opens the file. For writing: creates it if it is missing and cuts a damaged end off; n_records whole records are left,
  !> n_dropped were cut off. For reading: the file does not change, n_records counts all records, also damaged ones and a
  !> piece at the end, and n_dropped is 0. After an error the handle is null and the counts are zero. Errors: the file is no shard,
  !> is of another version, deck, mesh or size, or cannot be opened; for reading, it is missing.
  subroutine open_shard(path, content, is_writing, handle, n_records, n_dropped, error)
    character(*), intent(in) :: path
    type(shard_content_t), intent(in) :: content
    logical, intent(in) :: is_writing
    type(c_ptr), intent(out) :: handle
    integer, intent(out) :: n_records
    integer, intent(out) :: n_dropped
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: remedy = 'remove it to sample again, or choose another results folder (output.directory)'
    integer(c_int64_t) :: n_good, n_bad
    integer(c_int) :: code

    code = sig_shard_open(path, len(path, c_size_t), content%provenance, int(content%sizes(), c_int64_t), &
      merge(1_c_int, 0_c_int, is_writing), handle, n_good, n_bad)
    if (.not. c_associated(handle)) n_good = 0
    if (.not. c_associated(handle)) n_bad = 0
    n_records = int(n_good)
    n_dropped = int(n_bad)
    select case (code)
    case (0)
      continue
    case (foreign)
      call make_error(error, 'this is not a file of snapshots', file=path, hint=remedy)
    case (other_version)
      call make_error(error, 'these snapshots were written by another version of the program or on another kind of machine', &
        file=path, hint=remedy)
    case (other_provenance)
      call make_error(error, 'these snapshots belong to another deck, mesh or field file', file=path, hint=remedy)
    case (other_sizes)
      call make_error(error, 'these snapshots have other numbers of parameters, dofs or contacts than this deck needs; ' // &
        'perhaps the stopped run had another reduction.method (a condensed model keeps no displacements)', file=path, hint=remedy)
    case default
      call make_error(error, 'cannot open the snapshots: ' // system_reason(code), file=path)
    end select
  end subroutine open_shard

  !> Writes a record as the doubles of the file, in the order parameters, displacement, multipliers, residuals, seconds,
  !> n_iterations, reason. Doubles hold whole numbers below 2**53 exactly.
  pure subroutine pack_record(record, sizes, values)
    type(snapshot_record_t), intent(in) :: record
    !> numbers of parameters, dofs, multipliers and further values
    integer, intent(in) :: sizes(4)
    !> shape (sum(sizes) + 1); the last value, the hash, is not set
    real(rk), intent(inout) :: values(:)
    integer :: ends(4)

    ends = [sizes(1), sum(sizes(:2)), sum(sizes(:3)), sum(sizes)]
    values(:ends(1)) = record%parameters
    values(ends(1) + 1:ends(2)) = record%displacement
    values(ends(2) + 1:ends(3)) = record%multipliers
    values(ends(3) + 1:ends(3) + n_residuals) = record%residuals
    values(ends(4) - 2:ends(4)) = [record%seconds, real(record%n_iterations, rk), real(record%reason, rk)]
  end subroutine pack_record

  pure subroutine unpack_record(values, sizes, record)
    real(rk), intent(in) :: values(:)
    integer, intent(in) :: sizes(4)
    type(snapshot_record_t), intent(out) :: record
    integer :: ends(4)

    ends = [sizes(1), sum(sizes(:2)), sum(sizes(:3)), sum(sizes)]
    record%parameters = values(:ends(1))
    record%displacement = values(ends(1) + 1:ends(2))
    record%multipliers = values(ends(2) + 1:ends(3))
    record%residuals = values(ends(3) + 1:ends(3) + n_residuals)
    record%seconds = values(ends(4) - 2)
    record%n_iterations = nint(values(ends(4) - 1))
    record%reason = nint(values(ends(4)))
  end subroutine unpack_record
end module sig_snapshot_shard
