! SPDX-License-Identifier: BSD-3-Clause
!> Keeps records for about a second before they are written to a shard. So a short run does not write them twice: to a shard and to
!> the merged file.
module sig_snapshot_buffer
  use sig_clock, only: wall_time
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_snapshot_shard, only: append_records, shard_content_t, shard_writer_t, snapshot_record_t
  implicit none(type, external)
  private
  public :: snapshot_buffer_t

  !> Call create, then add for new records, then close. Local: one rank of the group has it.
  type :: snapshot_buffer_t
    !> records that are not written yet
    type(snapshot_record_t), allocatable :: records(:)
    type(shard_writer_t), private :: writer
    !> [s] time when the buffer was last empty, and when records were added last
    real(rk), private :: empty_time = 0
    real(rk), private :: add_time = 0
  contains
    procedure :: create
    procedure :: add
    procedure :: flush => flush_records
    procedure :: close => close_buffer
  end type snapshot_buffer_t

  !> [s] longest time that records should wait, by estimate, because a kill loses those that wait
  real(rk), parameter :: longest_time = 0.9_rk
  !> [bytes] size of the displacements from which on the records are written
  real(rk), parameter :: largest_size = 2.0e8_rk

contains

  !> Opens the shard for appending (creates it if it is missing, cuts off damaged records), and starts with an empty buffer. Errors:
  !> the file is no shard, is of another deck, mesh, size or format, or cannot be written.
  subroutine create(self, path, content, error)
    class(snapshot_buffer_t), intent(inout) :: self
    !> path of the shard
    character(*), intent(in) :: path
    type(shard_content_t), intent(in) :: content
    type(error_t), allocatable, intent(out) :: error

    if (allocated(self%records)) deallocate (self%records)
    allocate (self%records(0))
    self%empty_time = wall_time()
    self%add_time = self%empty_time
    call self%writer%create(path, content, error)
  end subroutine create

  !> Adds records. Writes all records of the buffer if some would otherwise wait, by estimate, for more than 0.9 s, or if their
  !> displacements have 200 MB or more. Errors: they cannot be written, or the shard was removed or moved; all records of the
  !> buffer are then lost.
  subroutine add(self, records, error)
    class(snapshot_buffer_t), intent(inout) :: self
    !> at least one; their arrays are moved into the buffer
    type(snapshot_record_t), intent(inout) :: records(:)
    type(error_t), allocatable, intent(out) :: error
    real(rk) :: next_time

    call append_records(records, self%records)
    ! estimate: the next records come after the same time as these
    next_time = 2 * wall_time() - self%add_time
    self%add_time = wall_time()
    if (next_time - self%empty_time >= longest_time .or. &
      8.0_rk * size(self%records) * size(self%records(1)%displacement) >= largest_size) call flush_records(self, error)
  end subroutine add

  !> Writes the records of the buffer, if there are any, and empties it. Errors: they cannot be written, or the shard was removed or
  !> moved; the records are then lost.
  subroutine flush_records(self, error)
    class(snapshot_buffer_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error

    if (size(self%records) > 0) call self%writer%append(self%records, error)
    deallocate (self%records)
    allocate (self%records(0))
    self%empty_time = wall_time()
  end subroutine flush_records

  !> Closes the shard. Records that are not written yet are written, or stay in the buffer if is_kept. Errors: the disk fails or is
  !> full; the shard was removed or moved. The shard is closed also then.
  subroutine close_buffer(self, is_kept, error)
    class(snapshot_buffer_t), intent(inout) :: self
    !> whether the caller takes the records from the component `records`
    logical, intent(in) :: is_kept
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: close_error

    if (.not. is_kept) call flush_records(self, error)
    call self%writer%close(close_error)
    if (allocated(close_error) .and. .not. allocated(error)) call move_alloc(close_error, error)
  end subroutine close_buffer
end module sig_snapshot_buffer
