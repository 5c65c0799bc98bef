! SPDX-License-Identifier: BSD-3-Clause
!> The C side of the snapshots, as Fortran sees it; what each function does stands in include/signorom/snapshot_shard.h.
module sig_snapshots_c_interfaces
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int64_t, c_ptr, c_size_t
  implicit none(type, external)
  private
  public :: sig_shard_open, sig_shard_read, sig_shard_append, sig_shard_close

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
end module sig_snapshots_c_interfaces
