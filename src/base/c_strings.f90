! SPDX-License-Identifier: BSD-3-Clause
!> Texts to and from C, and the end of memory that C made.
module sig_c_strings
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_null_char, c_ptr, c_size_t
  implicit none(type, external)
  private
  public :: from_c, sig_free, to_c

  !> Converts a C text to a Fortran text: from a null-terminated pointer (null gives an empty text), a pointer with a length in
  !> bytes, or an array of characters (up to its first null, or all of it).
  interface from_c
    procedure from_pointer, from_sized_pointer, from_array
  end interface from_c

  ! strlen is one of C's own; include/signorom/system.h describes the other one.
  interface
    pure integer(c_size_t) function strlen(text) bind(c)
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
    end function strlen

    subroutine sig_free(block) bind(c)
      import :: c_ptr
      type(c_ptr), value :: block
    end subroutine sig_free
  end interface

contains

  !> Returns the text as a null-terminated array.
  pure function to_c(text) result(array)
    character(*), intent(in) :: text
    character(kind=c_char) :: array(len(text) + 1)
    integer :: i

    do i = 1, len(text)
      array(i) = text(i:i)
    end do
    array(len(text) + 1) = c_null_char
  end function to_c

  !> Converts a null-terminated C text; a null pointer gives an empty text.
  function from_pointer(pointer) result(text)
    type(c_ptr), intent(in) :: pointer
    character(:), allocatable :: text

    text = ''
    if (c_associated(pointer)) text = from_sized_pointer(pointer, strlen(pointer))
  end function from_pointer

  function from_sized_pointer(pointer, length) result(text)
    !> not null, unless the length is 0
    type(c_ptr), intent(in) :: pointer
    !> number of bytes
    integer(c_size_t), intent(in) :: length
    character(:), allocatable :: text
    character(kind=c_char), pointer :: characters(:)
    integer(c_size_t) :: i

    allocate (character(length) :: text)
    if (length == 0 .or. .not. c_associated(pointer)) return
    call c_f_pointer(pointer, characters, [length])
    do i = 1, length
      text(i:i) = characters(i)
    end do
  end function from_sized_pointer

  pure function from_array(array) result(text)
    character(kind=c_char), intent(in) :: array(:)
    character(:), allocatable :: text
    integer :: i, length

    length = findloc(array, c_null_char, dim=1) - 1
    if (length < 0) length = size(array)
    allocate (character(length) :: text)
    do i = 1, length
      text(i:i) = array(i)
    end do
  end function from_array
end module sig_c_strings
