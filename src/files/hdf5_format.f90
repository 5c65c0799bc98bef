! SPDX-License-Identifier: BSD-3-Clause
!> Writes and checks the attributes of '/' that say what our HDF5 files are: name and version of the format, and version of the
!> program that wrote the file.
module sig_hdf5_format
  use sig_errors, only: error_t, make_error
  use sig_file_seal, only: check_seal
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: file_format_t, write_format, check_format, open_sealed

  type :: file_format_t
    !> such as `signorom model`
    character(20) :: name
    !> oldest and newest version that can be read
    integer :: oldest, newest
    !> hint for errors: how to get a file that can be read
    character(60) :: hint
  end type file_format_t

contains

  !> Writes the attributes format, format_version and code_version of '/'. A failure is reported when the file is closed.
  subroutine write_format(file, format, version, code_version)
    type(h5_writer_t), intent(inout) :: file
    type(file_format_t), intent(in) :: format
    !> version of the format
    integer, intent(in) :: version
    !> version of the program that computed the content
    character(*), intent(in) :: code_version

    call file%write('/@format', trim(format%name))
    call file%write('/@format_version', version)
    call file%write('/@code_version', code_version)
  end subroutine write_format

  !> Opens an HDF5 file that has a seal (sig_file_seal). The seal is checked first, so that HDF5 does not read a file that was cut
  !> off or changed according to its seal. A file without a seal is opened to find out what it is, and then refused.
  !>
  !> Errors: those of check_seal, of the reader's `open` and of check_format; no seal. Then the file is closed.
  subroutine open_sealed(file, path, format, version, error)
    type(h5_reader_t), intent(inout) :: file
    character(*), intent(in) :: path
    type(file_format_t), intent(in) :: format
    !> version of the file's format; 0 if it is not known
    integer, intent(out) :: version
    type(error_t), allocatable, intent(out) :: error
    logical :: is_sealed

    version = 0
    work: block
      ! a damaged file may crash HDF5
      call check_seal(path, is_sealed, error)
      if (allocated(error)) exit work
      call file%open(path, error)
      if (allocated(error)) exit work
      call check_format(file, path, format, version, error)
      if (allocated(error)) exit work
      if (.not. is_sealed) call make_error(error, 'the file does not begin with a checksum, so its content cannot be trusted', &
        file=path, hint=trim(format%hint))
    end block work
    if (allocated(error)) call file%close()
  end subroutine open_sealed

  !> Checks format and version of an open file. If there is an error already, only sets version = 0. Errors: no format or another
  !> one; a version that this program does not read; one of these attributes cannot be read.
  subroutine check_format(file, path, format, version, error)
    type(h5_reader_t), intent(in) :: file
    !> name of the file for messages
    character(*), intent(in) :: path
    type(file_format_t), intent(in) :: format
    !> version of the file's format; 0 if it is not known
    integer, intent(out) :: version
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: found

    version = 0
    found = ''
    if (allocated(error)) return
    if (file%has('/@format')) call file%read('/@format', found, error)
    if (allocated(error)) return
    if (found == format%name) call file%read('/@format_version', version, error)
    if (allocated(error)) return
    if (found == '') then
      call make_error(error, 'this HDF5 file is no ' // trim(format%name), path, hint=trim(format%hint))
    else if (found /= format%name) then
      call make_error(error, 'this file is no ' // trim(format%name) // '; it says that it is ''' // found // '''', path, &
        hint=trim(format%hint))
    else if (version > format%newest) then
      call make_error(error, 'the file has format version ' // to_text(version) // '; this program reads up to version ' // &
        to_text(format%newest), path, hint='use the version that wrote it, or a newer one')
    else if (version < format%oldest) then
      call make_error(error, 'the file has format version ' // to_text(version) // '; this program reads none before ' // &
        to_text(format%oldest), path, hint=trim(format%hint))
    end if
  end subroutine check_format
end module sig_hdf5_format
