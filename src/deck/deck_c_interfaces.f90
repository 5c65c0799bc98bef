! SPDX-License-Identifier: BSD-3-Clause
!> Interfaces of the C functions of this layer, which include/signorom/yaml_reader.h declares and describes.
module sig_deck_c_interfaces
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_ptr, c_size_t
  implicit none(type, external)
  private
  public :: yaml_node_c_t, yaml_fault_c_t
  public :: sig_yaml_read, sig_yaml_n_nodes, sig_yaml_n_faults, sig_yaml_get_node, sig_yaml_get_fault, sig_yaml_free

  !> The structure sig_yaml_node of yaml_reader.h.
  type, bind(c) :: yaml_node_c_t
    integer(c_int) :: kind
    integer(c_int) :: parent
    integer(c_int) :: line
    integer(c_int) :: column
    integer(c_int) :: key_line
    integer(c_int) :: key_column
    integer(c_int) :: is_quoted
    type(c_ptr) :: key
    integer(c_size_t) :: key_length
    type(c_ptr) :: text
    integer(c_size_t) :: text_length
  end type yaml_node_c_t

  !> The structure sig_yaml_fault of yaml_reader.h.
  type, bind(c) :: yaml_fault_c_t
    integer(c_int) :: kind
    integer(c_int) :: line
    integer(c_int) :: column
    type(c_ptr) :: message
  end type yaml_fault_c_t

  interface
    integer(c_int) function sig_yaml_read(text, length, reading) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      implicit none(type, external)
      character(kind=c_char), intent(in) :: text(*)
      integer(c_size_t), value, intent(in) :: length
      type(c_ptr), intent(out) :: reading
    end function sig_yaml_read

    integer(c_int) function sig_yaml_n_nodes(reading) bind(c)
      import :: c_int, c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: reading
    end function sig_yaml_n_nodes

    integer(c_int) function sig_yaml_n_faults(reading) bind(c)
      import :: c_int, c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: reading
    end function sig_yaml_n_faults

    subroutine sig_yaml_get_node(reading, i, node) bind(c)
      import :: c_int, c_ptr, yaml_node_c_t
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: reading
      integer(c_int), value, intent(in) :: i
      type(yaml_node_c_t), intent(out) :: node
    end subroutine sig_yaml_get_node

    subroutine sig_yaml_get_fault(reading, i, fault) bind(c)
      import :: c_int, c_ptr, yaml_fault_c_t
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: reading
      integer(c_int), value, intent(in) :: i
      type(yaml_fault_c_t), intent(out) :: fault
    end subroutine sig_yaml_get_fault

    subroutine sig_yaml_free(reading) bind(c)
      import :: c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: reading
    end subroutine sig_yaml_free
  end interface
end module sig_deck_c_interfaces
