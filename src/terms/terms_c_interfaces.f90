! SPDX-License-Identifier: BSD-3-Clause
!> Fortran interfaces of the C functions of this layer; include/signorom/expression.h describes them.
module sig_terms_c_interfaces
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_ptr, c_size_t
  implicit none(type, external)
  private
  public :: sig_expression_create, sig_expression_evaluate, sig_expression_uses, sig_expression_free

  interface
    integer(c_int) function sig_expression_create(text, text_length, names, name_width, n_names, places, expression, &
      position, token, message, size) bind(c)
      import :: c_char, c_int, c_ptr, c_size_t
      implicit none(type, external)
      character(kind=c_char), intent(in) :: text(*)
      integer(c_size_t), value, intent(in) :: text_length
      character(kind=c_char), intent(in) :: names(*)
      integer(c_size_t), value, intent(in) :: name_width
      integer(c_int), value, intent(in) :: n_names
      integer(c_int), intent(in) :: places(*)
      type(c_ptr), intent(out) :: expression
      integer(c_int), intent(out) :: position
      character(kind=c_char), intent(out) :: token(*)
      character(kind=c_char), intent(out) :: message(*)
      integer(c_size_t), value, intent(in) :: size
    end function sig_expression_create

    integer(c_int) function sig_expression_evaluate(expression, values, result) bind(c)
      import :: c_double, c_int, c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: expression
      real(c_double), intent(in) :: values(*)
      real(c_double), intent(out) :: result
    end function sig_expression_evaluate

    integer(c_int) function sig_expression_uses(expression, i) bind(c)
      import :: c_int, c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: expression
      integer(c_int), value, intent(in) :: i
    end function sig_expression_uses

    subroutine sig_expression_free(expression) bind(c)
      import :: c_ptr
      implicit none(type, external)
      type(c_ptr), value, intent(in) :: expression
    end subroutine sig_expression_free
  end interface
end module sig_terms_c_interfaces
