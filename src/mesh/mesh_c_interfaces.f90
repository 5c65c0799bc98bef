! SPDX-License-Identifier: BSD-3-Clause
!> Interfaces of the C functions of this layer, which include/signorom/{factor_size,gmsh_reader,partition}.h declare and describe.
module sig_mesh_c_interfaces
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int64_t, c_ptr, c_size_t
  implicit none(type, external)
  private
  public :: sig_gmsh_read, sig_gmsh_message, sig_gmsh_sizes, sig_gmsh_nodes, sig_gmsh_elements, sig_gmsh_memberships
  public :: sig_gmsh_group, sig_gmsh_hash, sig_gmsh_free, sig_count_factor, sig_partition_graph
  public :: sig_gmsh_read_fields, sig_gmsh_n_fields, sig_gmsh_field, sig_gmsh_field_values
  public :: gmsh_ok, gmsh_invalid, gmsh_unreadable, gmsh_no_memory, gmsh_message_size

  integer(c_int), parameter :: gmsh_ok = 0, gmsh_invalid = 1, gmsh_unreadable = 2, gmsh_no_memory = 3
  integer, parameter :: gmsh_message_size = 512

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

    subroutine sig_gmsh_free(mesh) bind(c)
      import :: c_ptr
      type(c_ptr), value :: mesh
    end subroutine sig_gmsh_free

    integer(c_int) function sig_partition_graph(n_vertices, offsets, neighbors, weights, n_parts, seed, part) bind(c)
      import :: c_int
      integer(c_int), value :: n_vertices
      integer(c_int), intent(in) :: offsets(*), neighbors(*), weights(*)
      integer(c_int), value :: n_parts, seed
      integer(c_int), intent(inout) :: part(*)
    end function sig_partition_graph

    integer(c_int) function sig_count_factor(n_vertices, offsets, neighbors, n_dim, seed, entries, operations) bind(c)
      import :: c_double, c_int
      integer(c_int), value :: n_vertices
      integer(c_int), intent(in) :: offsets(*), neighbors(*)
      integer(c_int), value :: n_dim, seed
      real(c_double), intent(out) :: entries, operations
    end function sig_count_factor
  end interface
end module sig_mesh_c_interfaces
