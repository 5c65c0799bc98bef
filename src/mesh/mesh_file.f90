! SPDX-License-Identifier: BSD-3-Clause
!> Reads the content of a gmsh file into flat arrays, before cells are selected and checked.
module sig_mesh_file
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int64_t, c_null_char, c_ptr, c_size_t
  use sig_c_strings, only: from_c
  use sig_checksum, only: hash_digits
  use sig_errors, only: error_t, make_error
  use sig_system, only: system_reason
  use sig_kinds, only: rk
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: raw_mesh_t, raw_nodes, read_raw_mesh, report_invalid
  ! of the reader in C, for nodal fields, too
  public :: gmsh_invalid, gmsh_ok, gmsh_unreadable, sig_gmsh_free, sig_gmsh_nodes, sig_gmsh_sizes

  !> what the reader in C returns
  integer(c_int), parameter :: gmsh_ok = 0, gmsh_invalid = 1, gmsh_unreadable = 2, gmsh_no_memory = 3
  integer, parameter :: gmsh_message_size = 512

  !> kinds of groups: a physical group with a name, one without, a geometric entity of gmsh whose elements are in no physical group
  integer, parameter, public :: kind_named = 1, kind_physical = 2, kind_entity = 3

  !> start of the message if the file is missing, is a folder, or cannot be read
  character(*), parameter, public :: unreadable_mesh = 'cannot read the mesh file'

  !> The content of the file: all nodes and elements in the file's order, and the groups of elements. All indices are 1-based.
  type :: raw_mesh_t
    integer :: n_nodes = 0
    integer :: n_elements = 0
    integer :: n_groups = 0
    !> gmsh's node numbers
    integer, allocatable :: node_tags(:)
    !> [mesh.length_unit] shape (3, n_nodes)
    real(rk), allocatable :: coordinates(:, :)
    !> gmsh's number of each element's type, and of the element, shape (n_elements)
    integer, allocatable :: element_types(:)
    integer, allocatable :: element_tags(:)
    !> line and column in the file, 0 in a binary file, shape (2, n_elements)
    integer, allocatable :: element_places(:, :)
    !> nodes of element e: element_nodes(element_offsets(e) + 1 : element_offsets(e + 1))
    integer, allocatable :: element_offsets(:)
    integer, allocatable :: element_nodes(:)
    !> element member_elements(m) belongs to group member_groups(m); elements ascend
    integer, allocatable :: member_elements(:)
    integer, allocatable :: member_groups(:)
    !> dimension and tag of each group, shape (n_groups)
    integer, allocatable :: group_dims(:)
    integer, allocatable :: group_tags(:)
    !> kind_named, kind_physical or kind_entity, shape (n_groups)
    integer, allocatable :: group_kinds(:)
    !> the name in the file, or one made of dimension and number
    type(string_t), allocatable :: group_names(:)
    !> FNV-1a hash of the file's bytes, 16 hexadecimal digits
    character(16) :: hash = ''
  end type raw_mesh_t

  ! include/signorom/gmsh_reader.h describes these procedures in C.
  interface
    integer(c_int) function sig_gmsh_read(path, length, mesh) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      integer(c_size_t), value :: length
      type(c_ptr), intent(out) :: mesh
    end function sig_gmsh_read

    subroutine sig_gmsh_message(mesh, message, line) bind(c)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: mesh
      character(kind=c_char), intent(inout) :: message(*)
      integer(c_int), intent(out) :: line
    end subroutine sig_gmsh_message

    pure integer(c_int64_t) function sig_gmsh_hash(mesh) bind(c)
      import :: c_int64_t, c_ptr
      type(c_ptr), intent(in), value :: mesh
    end function sig_gmsh_hash

    subroutine sig_gmsh_sizes(mesh, sizes) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: mesh
      integer(c_int), intent(inout) :: sizes(*)
    end subroutine sig_gmsh_sizes

    subroutine sig_gmsh_nodes(mesh, tags, coordinates) bind(c)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: mesh
      integer(c_int), intent(inout) :: tags(*)
      real(c_double), intent(inout) :: coordinates(*)
    end subroutine sig_gmsh_nodes

    subroutine sig_gmsh_elements(mesh, types, tags, places, offsets, nodes) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: mesh
      integer(c_int), intent(inout) :: types(*), tags(*), places(2, *), offsets(*), nodes(*)
    end subroutine sig_gmsh_elements

    subroutine sig_gmsh_memberships(mesh, elements, groups) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: mesh
      integer(c_int), intent(inout) :: elements(*), groups(*)
    end subroutine sig_gmsh_memberships

    subroutine sig_gmsh_group(mesh, i, n_dim, tag, is_entity, name, name_length) bind(c)
      import :: c_int, c_ptr, c_size_t
      type(c_ptr), value :: mesh
      integer(c_int), value :: i
      integer(c_int), intent(out) :: n_dim, tag, is_entity
      type(c_ptr), intent(out) :: name
      integer(c_size_t), intent(out) :: name_length
    end subroutine sig_gmsh_group

    subroutine sig_gmsh_free(mesh) bind(c)
      import :: c_ptr
      type(c_ptr), value :: mesh
    end subroutine sig_gmsh_free
  end interface

contains

  !> Reads a gmsh file. Local. Errors: the file cannot be read (unreadable_mesh), memory is not enough, or the file is not a mesh
  !> that the reader supports; then, if the fault has a place, the error has the line of a text file, and for a binary file the
  !> message has the byte.
  subroutine read_raw_mesh(path, raw, error)
    character(*), intent(in) :: path
    type(raw_mesh_t), intent(out) :: raw
    type(error_t), allocatable, intent(out) :: error
    type(c_ptr) :: handle
    integer(c_int) :: status, sizes(5)

    status = sig_gmsh_read(path, len(path, c_size_t), handle)
    select case (status)
    case (gmsh_ok)
      call copy_mesh(handle, raw)
    case (gmsh_invalid)
      call report_invalid(handle, path, error)
    case (gmsh_unreadable)
      call sig_gmsh_sizes(handle, sizes)
      call make_error(error, unreadable_mesh // ' ''' // path // ''': ' // system_reason(sizes(1)), file=path)
    case default
      call make_error(error, 'not enough memory to read the mesh file', file=path, &
        hint='one rank reads the whole mesh: take a machine with more memory or a coarser mesh; more ranks do not help')
    end select
    call sig_gmsh_free(handle)
  end subroutine read_raw_mesh

  !> Returns the nodes of an element of the file, 1-based, in gmsh's order within the element.
  pure function raw_nodes(raw, i_element) result(nodes)
    type(raw_mesh_t), intent(in) :: raw
    integer, intent(in) :: i_element
    integer :: nodes(raw%element_offsets(i_element + 1) - raw%element_offsets(i_element))

    nodes = raw%element_nodes(raw%element_offsets(i_element) + 1:raw%element_offsets(i_element + 1))
  end function raw_nodes

  !> Makes the error of a file that the C functions refused, with their message and the line of the fault. The line is 0 in a binary
  !> file, and for a fault without a place.
  subroutine report_invalid(handle, path, error)
    !> of sig_gmsh_read or sig_gmsh_read_fields, which returned gmsh_invalid
    type(c_ptr), intent(in) :: handle
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    character(kind=c_char) :: message(gmsh_message_size)
    integer(c_int) :: line

    message = c_null_char
    call sig_gmsh_message(handle, message, line)
    call make_error(error, from_c(message), file=path, line=line)
  end subroutine report_invalid

  subroutine copy_mesh(handle, raw)
    type(c_ptr), intent(in) :: handle
    type(raw_mesh_t), intent(inout) :: raw
    integer(c_int) :: sizes(5)

    raw%hash = hash_digits(sig_gmsh_hash(handle))
    call sig_gmsh_sizes(handle, sizes)
    raw%n_nodes = sizes(1)
    raw%n_elements = sizes(2)
    raw%n_groups = sizes(5)
    allocate (raw%node_tags(raw%n_nodes), raw%coordinates(3, raw%n_nodes))
    call sig_gmsh_nodes(handle, raw%node_tags, raw%coordinates)
    allocate (raw%element_types(raw%n_elements), raw%element_tags(raw%n_elements), raw%element_offsets(raw%n_elements + 1))
    allocate (raw%element_places(2, raw%n_elements), raw%element_nodes(sizes(3)))
    call sig_gmsh_elements(handle, raw%element_types, raw%element_tags, raw%element_places, raw%element_offsets, raw%element_nodes)
    raw%element_nodes = raw%element_nodes + 1
    allocate (raw%member_elements(sizes(4)), raw%member_groups(sizes(4)))
    call sig_gmsh_memberships(handle, raw%member_elements, raw%member_groups)
    raw%member_elements = raw%member_elements + 1
    raw%member_groups = raw%member_groups + 1
    call copy_groups(handle, raw)
  end subroutine copy_mesh

  !> Gives the groups without a name one of their dimension and number: `volume_55`, `surface_57`, `curve_3`, `point_2`. An entity
  !> beside elements in physical groups of the same dimension gets `surface_entity_57`, because these have numbers of their own.
  pure subroutine name_groups(raw)
    type(raw_mesh_t), intent(inout) :: raw
    character(*), parameter :: nouns(0:3) = [character(7) :: 'point', 'curve', 'surface', 'volume']
    character(:), allocatable :: noun
    logical :: has_physical(0:3)
    integer :: i

    has_physical = .false.
    do i = 1, size(raw%member_groups)
      associate (group => raw%member_groups(i))
        if (raw%group_kinds(group) /= kind_entity) has_physical(raw%group_dims(group)) = .true.
      end associate
    end do
    do i = 1, raw%n_groups
      if (raw%group_kinds(i) == kind_named) cycle
      noun = trim(nouns(raw%group_dims(i)))
      if (raw%group_kinds(i) == kind_entity .and. has_physical(raw%group_dims(i))) noun = noun // '_entity'
      raw%group_names(i)%text = noun // '_' // to_text(raw%group_tags(i))
    end do
  end subroutine name_groups

  subroutine copy_groups(handle, raw)
    type(c_ptr), intent(in) :: handle
    type(raw_mesh_t), intent(inout) :: raw
    type(c_ptr) :: name
    integer(c_size_t) :: name_length
    integer(c_int) :: i_group, is_entity

    allocate (raw%group_dims(raw%n_groups), raw%group_tags(raw%n_groups), raw%group_names(raw%n_groups))
    allocate (raw%group_kinds(raw%n_groups))
    do i_group = 1, raw%n_groups
      call sig_gmsh_group(handle, i_group - 1, raw%group_dims(i_group), raw%group_tags(i_group), is_entity, name, name_length)
      raw%group_kinds(i_group) = merge(kind_named, kind_physical, name_length > 0)
      if (is_entity == 1) raw%group_kinds(i_group) = kind_entity
      raw%group_names(i_group)%text = from_c(name, name_length)
    end do
    call name_groups(raw)
  end subroutine copy_groups
end module sig_mesh_file
