! SPDX-License-Identifier: BSD-3-Clause
!> Writes lines to the standard output, a file, a device or a pipe. Every failure is reported.
module sig_output_stream
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_ptr, c_ptr, c_size_t
  use sig_c_strings, only: from_c, sig_free
  use sig_errors, only: error_t, make_error
  use sig_system, only: system_reason
  implicit none(type, external)
  private
  public :: output_stream_t, find_target

  !> An output stream. A file gets its name only by a close that succeeds; an earlier file of this name stays until then. If the
  !> path is a symbolic link, the file to which it leads is replaced. A device or a pipe is written to directly.
  type :: output_stream_t
    private
    type(c_ptr) :: handle = c_null_ptr
    !> name of the target for messages
    character(:), allocatable :: name
  contains
    procedure :: open => open_stream
    procedure :: write_line
    procedure :: close => close_stream
  end type output_stream_t

  ! include/signorom/output_stream.h describes these procedures in C.
  interface
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
  end interface

contains

  !> Opens a stream. Requires: it is not open. Errors: no right to write there, no such folder, the path is a folder or a circle of
  !> links. Then the stream is not open.
  subroutine open_stream(self, path, error)
    class(output_stream_t), intent(inout) :: self
    !> empty: the standard output
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: code

    self%name = path
    if (path == '') self%name = 'standard output'
    code = sig_output_open(path, len(path, c_size_t), self%handle)
    if (code /= 0) call make_error(error, 'cannot write here: ' // system_reason(code), file=self%name)
  end subroutine open_stream

  !> Writes a line and its line end. Requires: the stream is open. Errors: the output fails, for example because the disk is full or
  !> the pipe has no reader; every later line gives the same error. Lines are collected, so an error may come later than the line
  !> that caused it.
  subroutine write_line(self, line, error)
    class(output_stream_t), intent(inout) :: self
    character(*), intent(in) :: line
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: code

    code = sig_output_write(self%handle, line // new_line('a'), len(line, c_size_t) + 1)
    if (code /= 0) call report(self, code, error)
  end subroutine write_line

  !> Writes what is left and closes the stream. A file gets its name. After an error, also one of an earlier line, the new file is
  !> removed, and an earlier file of this name stays; a device, a pipe or the standard output keeps what it got.
  !> Does nothing if the stream is not open. Errors: something could not be written, or the file cannot get its name.
  subroutine close_stream(self, error, is_dropped)
    class(output_stream_t), intent(inout) :: self
    !> if it is allocated before, it stays as it is, and the new file is removed
    type(error_t), allocatable, intent(inout) :: error
    !> whether to remove the new file in any case; default no. It has no effect on a device, a pipe or the standard output
    logical, intent(in), optional :: is_dropped
    logical :: is_kept
    integer(c_int) :: code

    if (.not. c_associated(self%handle)) return
    is_kept = .not. allocated(error)
    if (present(is_dropped)) is_kept = is_kept .and. .not. is_dropped
    code = sig_output_close(self%handle, merge(1_c_int, 0_c_int, is_kept))
    self%handle = c_null_ptr
    if (code /= 0 .and. .not. allocated(error)) call report(self, code, error)
  end subroutine close_stream

  subroutine report(self, code, error)
    class(output_stream_t), intent(in) :: self
    integer(c_int), intent(in) :: code
    type(error_t), allocatable, intent(out) :: error

    call make_error(error, 'cannot write everything: ' // system_reason(code), file=self%name)
  end subroutine report

  !> Finds the file that must be replaced so that a path leads to a new file: symbolic links are followed. Errors: a folder, a
  !> circle of links, a device, a pipe or anything in /proc.
  subroutine find_target(path, target, error)
    character(*), intent(in) :: path
    !> path of this file, which may not exist yet; not usable after an error
    character(:), allocatable, intent(out) :: target
    type(error_t), allocatable, intent(out) :: error
    type(c_ptr) :: text
    integer(c_int) :: code, is_direct

    target = path
    code = sig_find_target(path, len(path, c_size_t), text, is_direct)
    if (code /= 0) then
      call make_error(error, 'cannot write here: ' // system_reason(code), file=path)
    else
      target = from_c(text)
      call sig_free(text)
      if (is_direct /= 0) call make_error(error, 'this is a device, a pipe or a path into /proc; a plain file is needed', &
        file=path)
    end if
  end subroutine find_target
end module sig_output_stream
