! SPDX-License-Identifier: BSD-3-Clause
!> Reads files with values at nodes: gmsh files with $NodeData, and HDF5 files.
!>
!> In an HDF5 file, /node_tags has the numbers of the nodes in the mesh file, and /<name> has one value for each of these nodes. If
!> /coordinates exists, it has their places.
module sig_nodal_field_file
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_ptr, c_size_t
  use sig_c_strings, only: from_c
  use sig_deck_config, only: field_config_t
  use sig_errors, only: error_t, make_error
  use sig_hdf5_reader, only: h5_reader_t
  use sig_kinds, only: rk
  use sig_mesh_file, only: gmsh_invalid, gmsh_ok, gmsh_unreadable, report_invalid, sig_gmsh_free, sig_gmsh_nodes, sig_gmsh_sizes
  use sig_system, only: system_reason
  use sig_text, only: append_text, join, string_t, to_text
  implicit none(type, external)
  private
  public :: raw_field_t, read_raw_field

  !> A field as the file has it.
  type :: raw_field_t
    !> numbers in the mesh file of the nodes with a value, and the values
    integer, allocatable :: tags(:)
    real(rk), allocatable :: values(:)
    !> numbers of the nodes whose places the file gives, and their places [length of the mesh file], shape (n_components, n_places);
    !> not allocated if the file has no places
    integer, allocatable :: place_tags(:)
    real(rk), allocatable :: coordinates(:, :)
  end type raw_field_t

  !> data set of HDF5 with the node numbers
  character(*), parameter :: tags_name = '/node_tags'
  !> data set of HDF5 with the places of these nodes
  character(*), parameter :: places_name = '/coordinates'

  ! include/signorom/gmsh_reader.h describes these procedures in C.
  interface
    integer(c_int) function sig_gmsh_read_fields(path, length, fields) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      type(c_ptr), intent(out) :: fields
    end function sig_gmsh_read_fields

    pure integer(c_int) function sig_gmsh_n_fields(fields) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), intent(in), value :: fields
    end function sig_gmsh_n_fields

    subroutine sig_gmsh_field(fields, i, n_components, n_values, name, name_length) bind(c)
      import :: c_int, c_ptr, c_size_t
      type(c_ptr), value :: fields
      integer(c_int), value :: i
      integer(c_int), intent(out) :: n_components, n_values
      type(c_ptr), intent(out) :: name
      integer(c_size_t), intent(out) :: name_length
    end subroutine sig_gmsh_field

    subroutine sig_gmsh_field_values(fields, i, tags, values) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: fields
      integer(c_int), value :: i
      integer(c_int), intent(inout) :: tags(*)
      real(c_double), intent(inout) :: values(*)
    end subroutine sig_gmsh_field_values
  end interface

contains

  !> Reads a field. A file whose name ends in .h5 or .hdf5 (lower case) is an HDF5 file, any other one a gmsh file. Local.
  !>
  !> Errors: a file that cannot be read, or not enough memory; what the reader of gmsh files or sig_hdf5_reader refuses; no field of
  !> this name; more than one number per node. In a gmsh file also: several fields of this name. In an HDF5 file also: no node_tags,
  !> or another number of them than of values.
  subroutine read_raw_field(config, deck_path, field, error)
    !> file and name of the field
    type(field_config_t), intent(in) :: config
    !> name of the deck for messages
    character(*), intent(in) :: deck_path
    type(raw_field_t), intent(out) :: field
    type(error_t), allocatable, intent(out) :: error

    if (ends_with(config%path, '.h5') .or. ends_with(config%path, '.hdf5')) then
      call read_hdf5(config, deck_path, field, error)
    else
      call read_gmsh(config, deck_path, field, error)
    end if
  end subroutine read_raw_field

  pure logical function ends_with(text, ending)
    character(*), intent(in) :: text
    character(*), intent(in) :: ending

    ends_with = .false.
    if (len(text) >= len(ending)) ends_with = text(len(text) - len(ending) + 1:) == ending
  end function ends_with

  subroutine read_hdf5(config, deck_path, field, error)
    type(field_config_t), intent(in) :: config
    character(*), intent(in) :: deck_path
    type(raw_field_t), intent(out) :: field
    type(error_t), allocatable, intent(out) :: error
    type(h5_reader_t) :: file

    work: block
      call file%open(config%path, error)
      if (allocated(error)) exit work
      if (file%has('/' // config%name%text)) then
        call file%read(tags_name, field%tags, error)
        call file%read('/' // config%name%text, field%values, error)
        if (file%has(places_name)) then
          field%place_tags = field%tags
          call file%read(places_name, field%coordinates, error)
        end if
      else
        call refuse_name(config, deck_path, 'has no field ''' // config%name%text // '''', error)
      end if
    end block work
    call file%close()
    if (allocated(error)) return
    if (size(field%tags) /= size(field%values)) call refuse_name(config, deck_path, 'has ' // to_text(size(field%values)) // &
      ' values of the field ''' // config%name%text // ''' for ' // to_text(size(field%tags)) // ' node_tags', error)
  end subroutine read_hdf5

  subroutine read_gmsh(config, deck_path, field, error)
    type(field_config_t), intent(in) :: config
    character(*), intent(in) :: deck_path
    type(raw_field_t), intent(out) :: field
    type(error_t), allocatable, intent(out) :: error
    type(c_ptr) :: handle
    integer(c_int) :: sizes(5)

    select case (sig_gmsh_read_fields(config%path, len(config%path, c_size_t), handle))
    case (gmsh_ok)
      call copy_field(handle, config, deck_path, field, error)
    case (gmsh_invalid)
      call report_invalid(handle, config%path, error)
    case (gmsh_unreadable)
      call sig_gmsh_sizes(handle, sizes)
      call make_error(error, 'cannot read the field file ''' // config%file // ''': ' // system_reason(sizes(1)), deck_path, &
        config%line, config%column)
    case default
      call make_error(error, 'not enough memory to read the field file', file=config%path)
    end select
    call sig_gmsh_free(handle)
  end subroutine read_gmsh

  subroutine copy_field(handle, config, deck_path, field, error)
    type(c_ptr), intent(in) :: handle
    type(field_config_t), intent(in) :: config
    character(*), intent(in) :: deck_path
    type(raw_field_t), intent(inout) :: field
    type(error_t), allocatable, intent(out) :: error
    type(string_t), allocatable :: names(:)
    integer, allocatable :: found(:)
    integer :: i, n_components(sig_gmsh_n_fields(handle)), n_values(sig_gmsh_n_fields(handle))
    integer(c_size_t) :: length
    type(c_ptr) :: name

    allocate (names(0))
    do i = 1, size(n_values)
      call sig_gmsh_field(handle, i - 1, n_components(i), n_values(i), name, length)
      call append_text(names, from_c(name, length))
    end do
    found = pack([(i, i=1, size(names))], [(names(i)%text == config%name%text, i=1, size(names))])
    if (size(found) == 0) then
      call refuse_name(config, deck_path, 'has no $NodeData ''' // config%name%text // '''; it has ' // listed(names), error)
    else if (size(found) > 1) then
      call refuse_name(config, deck_path, 'has the $NodeData ''' // config%name%text // ''' ' // to_text(size(found)) // &
        ' times; write the one that counts into a file of its own', error)
    else if (n_components(found(1)) > 1) then
      call refuse_name(config, deck_path, 'has ' // to_text(n_components(found(1))) // ' numbers per node in ''' // &
        config%name%text // '''; there must be one', error)
    else
      allocate (field%tags(n_values(found(1))), field%values(n_values(found(1))))
      call sig_gmsh_field_values(handle, found(1) - 1, field%tags, field%values)
      call copy_places(handle, field)
    end if
  end subroutine copy_field

  !> Copies numbers and places of the nodes in $Nodes of the field's file to place_tags and coordinates, which stay unallocated if
  !> the file has no nodes.
  subroutine copy_places(handle, field)
    !> of sig_gmsh_read_fields
    type(c_ptr), intent(in) :: handle
    type(raw_field_t), intent(inout) :: field
    integer(c_int) :: sizes(5)

    call sig_gmsh_sizes(handle, sizes)
    if (sizes(1) == 0) return
    allocate (field%place_tags(sizes(1)), field%coordinates(3, sizes(1)))
    call sig_gmsh_nodes(handle, field%place_tags, field%coordinates)
  end subroutine copy_places

  !> Returns the names with commas between them; `none` without names.
  pure function listed(names) result(text)
    type(string_t), intent(in) :: names(:)
    character(:), allocatable :: text

    text = 'none'
    if (size(names) > 0) text = join(names, ', ')
  end function listed

  subroutine refuse_name(config, deck_path, message, error)
    type(field_config_t), intent(in) :: config
    character(*), intent(in) :: deck_path
    !> message after the name of the file
    character(*), intent(in) :: message
    type(error_t), allocatable, intent(inout) :: error

    call make_error(error, 'the field file ''' // config%file // ''' ' // message, deck_path, config%name%line, config%name%column)
  end subroutine refuse_name
end module sig_nodal_field_file
