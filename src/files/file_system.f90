! SPDX-License-Identifier: BSD-3-Clause
!> Procedures for files and folders. Failures are errors with the path. Local: one rank calls.
module sig_file_system
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_long, c_ptr, c_size_t
  use sig_c_strings, only: from_c, sig_free
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: lk
  use sig_system, only: system_reason
  use sig_text, only: split, string_t, to_text
  implicit none(type, external)
  private
  public :: file_exists, is_directory, make_directories
  public :: read_text_file, write_text_file, remove_file, list_files
  public :: directory_lock_t, lock_directory, unlock_directory
  public :: directory_of, path_below, base_name, program_folder

  ! the same values as in file_system.h
  integer(c_int), parameter :: no_file = 0, plain_file = 1, directory = 2
  !> Linux's EWOULDBLOCK
  integer(c_int), parameter :: would_block = 11
  !> Linux's ELOOP
  integer(c_int), parameter :: is_link = 40

  !> Linux's PATH_MAX
  integer, parameter :: longest_path = 4096

  !> A lock on a folder or a share of it, from lock_directory to unlock_directory or to the end of the process.
  type :: directory_lock_t
    private
    integer(c_int) :: descriptor = -1
    integer(c_int) :: share_descriptor = -1
  end type directory_lock_t

  ! include/signorom/file_system.h describes these procedures in C.
  interface
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

    integer(c_int) function sig_remove_file(path, length) bind(c)
      import :: c_char, c_int, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
    end function sig_remove_file

    integer(c_int) function sig_lock_file(path, length, is_shared, descriptor, process) bind(c)
      import :: c_char, c_int, c_long, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      integer(c_int), value :: is_shared
      integer(c_int), intent(out) :: descriptor
      integer(c_long), intent(out) :: process
    end function sig_lock_file

    subroutine sig_unlock_file(descriptor) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor
    end subroutine sig_unlock_file

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
  end interface

contains

  !> Whether the path leads to something that is not a folder: a file, a device or a pipe. Links are followed.
  logical function file_exists(path)
    character(*), intent(in) :: path
    integer(c_int) :: kind

    kind = sig_file_kind(path, len(path, c_size_t))
    file_exists = kind /= no_file .and. kind /= directory
  end function file_exists

  !> Whether the path leads to a folder. Links are followed.
  logical function is_directory(path)
    character(*), intent(in) :: path

    is_directory = sig_file_kind(path, len(path, c_size_t)) == directory
  end function is_directory

  !> Makes a folder and the folders above it; an existing folder is no error. An empty path is the current folder. Errors: the
  !> system refuses it, for example without the right to write there, or because a file has the name.
  subroutine make_directories(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: code

    if (len(path) == 0) return
    code = sig_make_directories(path, len(path, c_size_t))
    if (code /= 0) call make_error(error, 'cannot make the folder: ' // system_reason(code), file=path)
  end subroutine make_directories

  !> Reads a whole text file without changes.
  !>
  !> Errors: no such file; a folder, a device or a pipe; not readable; empty; not a text, because it has null bytes.
  subroutine read_text_file(path, text, error)
    character(*), intent(in) :: path
    !> empty on an error
    character(:), allocatable, intent(out) :: text
    type(error_t), allocatable, intent(out) :: error
    type(c_ptr) :: bytes
    integer(c_size_t) :: size
    integer(c_int) :: code

    text = ''
    select case (sig_file_kind(path, len(path, c_size_t)))
    case (no_file)
      call make_error(error, 'no such file', file=path)
    case (directory)
      call make_error(error, 'this is a folder; a text file is needed', file=path)
    case (plain_file)
      code = sig_read_file(path, len(path, c_size_t), bytes, size)
      if (code /= 0) then
        call make_error(error, 'cannot read the file: ' // system_reason(code), file=path)
        return
      end if
      text = from_c(bytes, size)
      call sig_free(bytes)
      call check_text(path, text, error)
    case default
      call make_error(error, 'this is a device or a pipe; a text file is needed', file=path)
    end select
    if (allocated(error)) text = ''
  end subroutine read_text_file

  subroutine check_text(path, text, error)
    character(*), intent(in) :: path
    character(*), intent(in) :: text
    type(error_t), allocatable, intent(out) :: error

    if (len(text) == 0) then
      call make_error(error, 'the file is empty', file=path)
    else if (index(text, achar(0)) > 0) then
      call make_error(error, 'the file has null bytes, so it is binary or UTF-16; a text file in UTF-8 is needed', file=path)
    end if
  end subroutine check_text

  !> Writes or replaces a file as a whole: a reader sees the old or the new text, also after a crash. If the path is a symbolic
  !> link, the file to which it leads is replaced. The new file has the permissions of the old one, if there is one. A device or a
  !> pipe is written to directly; an empty path is the standard output. Errors: the system refuses it; the path is a folder.
  subroutine write_text_file(path, text, error)
    character(*), intent(in) :: path
    character(*), intent(in) :: text
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: code

    code = sig_write_file(path, len(path, c_size_t), text, len(text, c_size_t))
    if (code /= 0) call make_error(error, 'cannot write the file: ' // system_reason(code), file=path)
  end subroutine write_text_file

  !> Removes a file; a link is removed, and not the file to which it leads. A file that does not exist, or that the system does not
  !> show, is no error. A link that leads nowhere stays. Errors: the system refuses it; the path is a folder.
  subroutine remove_file(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    integer(c_int) :: code

    if (sig_file_kind(path, len(path, c_size_t)) == no_file) return
    code = sig_remove_file(path, len(path, c_size_t))
    if (code /= 0) call make_error(error, 'cannot remove the file: ' // system_reason(code), file=path)
  end subroutine remove_file

  !> Locks a folder for this process, so that two runs do not write into it at once. With `share`, runs that write other shares of
  !> it may do so at the same time, but no run that locks the whole folder.
  !>
  !> Requires: the folder exists. Errors: this or another process has locked it or the share already; the file .lock, or
  !> .lock-<share>, is a link, has a second name (hard link) or is no plain file; the system refuses to open or lock this file. The
  !> lock must then be given back, too.
  subroutine lock_directory(path, lock, error, share)
    character(*), intent(in) :: path
    type(directory_lock_t), intent(out) :: lock
    type(error_t), allocatable, intent(out) :: error
    !> name of the share, such as `2of4`; default: the whole folder
    character(*), intent(in), optional :: share
    character(*), parameter :: file_name = '/.lock'

    call lock_file(path, file_name, present(share), lock%descriptor, 'another run writes into this folder now', &
      'wait until it ends, or give this run another output.directory', error)
    if (allocated(error) .or. .not. present(share)) return
    call lock_file(path, file_name // '-' // share, .false., lock%share_descriptor, 'another run writes the same share of ' // &
      'this folder now', 'each job needs a share of its own; or wait until that run ends', error)
  end subroutine lock_directory

  !> Locks a file of a folder. Errors: those of lock_directory, with `message` and `hint` if another process holds the lock.
  subroutine lock_file(path, file_name, is_shared, descriptor, message, hint, error)
    !> of the folder
    character(*), intent(in) :: path
    !> with the slash before it
    character(*), intent(in) :: file_name
    !> other processes may have a shared lock, too
    logical, intent(in) :: is_shared
    integer(c_int), intent(out) :: descriptor
    character(*), intent(in) :: message
    character(*), intent(in) :: hint
    type(error_t), allocatable, intent(out) :: error
    integer(c_long) :: process
    integer(c_int) :: code

    code = sig_lock_file(path // file_name, len(path // file_name, c_size_t), merge(1_c_int, 0_c_int, is_shared), descriptor, &
      process)
    if (code == would_block) then
      call make_error(error, message // holder_text(process), file=path, hint=hint)
    else if (code == is_link) then
      call make_error(error, 'the file ' // file_name(2:) // ' of this folder is a link or no plain file; runs would ' // &
        'overwrite what it leads to', file=path, hint='remove ' // path // file_name)
    else if (code /= 0) then
      call make_error(error, 'cannot lock the folder: ' // system_reason(code), file=path)
    end if
  end subroutine lock_file

  !> Returns ` (process 1234)` for messages; empty if the number is not known.
  function holder_text(process) result(text)
    !> number of the process that holds a lock; 0: not known
    integer(c_long), intent(in) :: process
    character(:), allocatable :: text

    text = ''
    if (process > 0) text = ' (process ' // to_text(int(process, lk)) // ')'
  end function holder_text

  !> Unlocks the folder, or the share; the files of the locks stay. Does nothing if there is no lock.
  subroutine unlock_directory(lock)
    type(directory_lock_t), intent(inout) :: lock

    call sig_unlock_file(lock%share_descriptor)
    call sig_unlock_file(lock%descriptor)
    lock = directory_lock_t()
  end subroutine unlock_directory

  !> Returns the names, without the folder, of the files in a folder whose names start with the prefix, in byte order. Folders,
  !> hidden files and links that lead nowhere are left out. There are none if the folder is missing or cannot be read. An empty path
  !> is the current folder.
  function list_files(path, prefix) result(names)
    character(*), intent(in) :: path
    character(*), intent(in) :: prefix
    type(string_t), allocatable :: names(:)
    character(:), allocatable :: folder, packed
    type(c_ptr) :: block
    integer(c_size_t) :: size

    allocate (names(0))
    folder = path
    if (len(folder) == 0) folder = '.'
    if (sig_list_files(folder, len(folder, c_size_t), prefix, len(prefix, c_size_t), block, size) /= 0) return
    packed = from_c(block, size)
    call sig_free(block)
    ! each name ends with a null, the last one too
    if (len(packed) > 0) names = split(packed(:len(packed) - 1), achar(0))
  end function list_files

  !> Returns the folder of a path, that is, what stands before its last slash: `a/b.yaml` -> `a`, `b.yaml` -> `.`, `/b` -> `/`,
  !> `a/` -> `a`.
  pure function directory_of(path) result(folder)
    character(*), intent(in) :: path
    character(:), allocatable :: folder
    integer :: i_slash

    i_slash = index(path, '/', back=.true.)
    if (i_slash == 0) then
      folder = '.'
    else if (i_slash == 1) then
      folder = '/'
    else
      folder = path(:i_slash - 1)
    end if
  end function directory_of

  !> Returns, for a path in a deck that is relative to the deck's folder, one that can be opened from the current directory: the
  !> deck's folder stands before it. An absolute or empty path is unchanged, and any path if the deck is in the current directory.
  pure function path_below(deck_path, path) result(openable)
    !> path of the deck
    character(*), intent(in) :: deck_path
    !> path as written in the deck
    character(*), intent(in) :: path
    character(:), allocatable :: openable

    openable = path
    if (len(path) == 0) return
    if (path(1:1) == '/' .or. directory_of(deck_path) == '.') return
    openable = directory_of(deck_path) // '/' // path
  end function path_below

  !> Returns the folder of the running program, with links followed; empty if the system does not give it.
  function program_folder() result(folder)
    character(:), allocatable :: folder
    character(kind=c_char) :: path(longest_path)

    folder = ''
    if (sig_program_path(path, size(path, kind=c_size_t)) == 0) folder = directory_of(from_c(path))
  end function program_folder

  !> Returns the file name of a path without its ending: `a/b.c.yaml` -> `b.c`. A leading dot does not start an ending.
  pure function base_name(path) result(name)
    character(*), intent(in) :: path
    character(:), allocatable :: name
    integer :: i_dot

    name = path(index(path, '/', back=.true.) + 1:)
    i_dot = index(name, '.', back=.true.)
    if (i_dot > 1) name = name(:i_dot - 1)
  end function base_name
end module sig_file_system
