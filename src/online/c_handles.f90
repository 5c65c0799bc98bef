! SPDX-License-Identifier: BSD-3-Clause
!> The Fortran objects to which the handles of include/signorom.h point, and the transfer of values to C.
module sig_c_handles
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, c_loc, c_null_char, c_null_ptr, c_ptr
  use sig_answer, only: answer_t
  use sig_field_query, only: field_query_t
  use sig_gradient, only: gradient_t
  use sig_kinds, only: rk
  use sig_online_model, only: online_model_t
  use sig_query, only: query_t
  use sig_rooms, only: rooms_t
  implicit none(type, external)
  private
  public :: model_handle_t, context_handle_t, keep, ready_model, ready_context, answered_context, chosen_nodes, &
    given_numbers, put_integers, put_reals, put_text, text_at
  public :: code_ok, no_answer, bad_argument, bad_model, no_memory

  ! the values of signorom_code
  integer(c_int), parameter :: code_ok = 0, no_answer = 1, bad_argument = 2, bad_model = 3, no_memory = 4
  integer, parameter :: n_text_kinds = 10

  !> A text for C. A pointer to it is valid until keep replaces the text or the object ceases to exist.
  type :: c_text_t
    character(kind=c_char), allocatable :: characters(:)
  end type c_text_t

  type :: model_handle_t
    type(online_model_t) :: online
    !> whether the model was read and prepared
    logical :: is_ready = .false.
    type(c_text_t) :: message
    !> texts of the model; the index is signorom_text_kind + 1
    type(c_text_t) :: texts(n_text_kinds)
    type(c_text_t), allocatable :: names(:)
    type(c_text_t), allocatable :: units(:)
    !> names of the entries of the deck's contact section
    type(c_text_t), allocatable :: contact_names(:)
    type(c_text_t), allocatable :: region_names(:)
    !> reason why the model gives no fields; empty where it gives them
    character(:), allocatable :: field_refusal
  end type model_handle_t

  type :: context_handle_t
    type(model_handle_t), pointer :: model => null()
    type(query_t) :: query
    type(answer_t) :: answer
    type(rooms_t) :: rooms
    !> the last point, and the derivatives of its answer
    real(rk), allocatable :: point(:)
    type(gradient_t) :: gradient
    logical :: is_ready = .false.
    !> whether the last query had an answer
    logical :: has_answer = .false.
    !> whether this answer has its derivatives
    logical :: has_gradient = .false.
    !> whether this answer has its fields
    logical :: has_fields = .false.
    type(field_query_t) :: fields
    type(c_text_t) :: message
  end type context_handle_t

contains

  !> Keeps a copy of `value` for C in `text`, with a null character at its end. Pointers to the former text are no longer valid.
  subroutine keep(text, value)
    type(c_text_t), intent(inout) :: text
    character(*), intent(in) :: value
    integer :: i

    if (allocated(text%characters)) deallocate (text%characters)
    allocate (text%characters(len(value) + 1))
    do i = 1, len(value)
      text%characters(i) = value(i:i)
    end do
    text%characters(len(value) + 1) = c_null_char
  end subroutine keep

  !> Returns a pointer to text i of a list, or a null pointer if i is out of range. The text ends with a null character.
  function text_at(texts, i) result(text)
    type(c_text_t), target, intent(in) :: texts(:)
    !> counted from 0
    integer(c_int), intent(in) :: i
    type(c_ptr) :: text

    text = c_null_ptr
    if (i >= 0 .and. i < size(texts)) text = c_loc(texts(i + 1)%characters)
  end function text_at

  !> Returns the handle of a model that can answer; null if `model` is null or was not opened successfully.
  function ready_model(model, code) result(handle)
    type(c_ptr), intent(in) :: model
    !> code_ok; bad_argument if the result is null
    integer(c_int), intent(out), optional :: code
    type(model_handle_t), pointer :: handle

    handle => null()
    if (present(code)) code = bad_argument
    if (.not. c_associated(model)) return
    call c_f_pointer(model, handle)
    if (.not. handle%is_ready) handle => null()
    if (present(code) .and. associated(handle)) code = code_ok
  end function ready_model

  !> Returns the handle of a context that can answer. It returns null if `context` is null, or if signorom_create_context failed; in
  !> the second case the message of the context says why.
  function ready_context(context) result(handle)
    type(c_ptr), intent(in) :: context
    type(context_handle_t), pointer :: handle

    handle => null()
    if (.not. c_associated(context)) return
    call c_f_pointer(context, handle)
    if (.not. handle%is_ready) handle => null()
  end function ready_context

  !> Returns the handle of a context whose last query had an answer. Otherwise, or if `array`, the array of the caller, is null, it
  !> returns null, and the message of the context (unless `context` is null) says why.
  function answered_context(context, array, code) result(handle)
    type(c_ptr), intent(in) :: context
    type(c_ptr), intent(in) :: array
    !> code_ok; bad_argument if the result is null
    integer(c_int), intent(out) :: code
    type(context_handle_t), pointer :: handle

    code = bad_argument
    handle => ready_context(context)
    if (.not. associated(handle)) return
    if (handle%has_answer .and. c_associated(array)) code = code_ok
    if (code == code_ok) return
    if (handle%has_answer) then
      call keep(handle%message, 'the array for the answer is a null pointer')
    else
      call keep(handle%message, 'there is no answer: no point was asked, or the last query had no answer or was refused')
    end if
    handle => null()
  end function answered_context

  !> Returns a pointer to n numbers of the caller. It is null if `pointer` is null; then the message of the context says so.
  function given_numbers(handle, pointer, n, subject) result(numbers)
    type(context_handle_t), intent(inout) :: handle
    type(c_ptr), intent(in) :: pointer
    integer, intent(in) :: n
    !> what the numbers are, with its verb: the message goes on `a null pointer`
    character(*), intent(in) :: subject
    real(c_double), pointer :: numbers(:)

    numbers => null()
    if (c_associated(pointer)) then
      call c_f_pointer(pointer, numbers, [n])
    else
      call keep(handle%message, subject // ' a null pointer')
    end if
  end function given_numbers

  !> Returns a pointer to the numbers of the nodes that the caller chose, 0-based, in the caller's memory. With n = 0 the result has
  !> no elements. It is null if n is negative, `nodes` is null (also with n = 0) or a number is out of range; then the message of
  !> the context says so.
  function chosen_nodes(handle, n, nodes) result(chosen)
    type(context_handle_t), intent(inout) :: handle
    !> number of chosen nodes
    integer(c_int), intent(in) :: n
    type(c_ptr), intent(in) :: nodes
    integer(c_int), pointer :: chosen(:)

    chosen => null()
    if (n < 0 .or. .not. c_associated(nodes)) then
      call keep(handle%message, 'the number of nodes is negative, or the nodes are a null pointer')
      return
    end if
    call c_f_pointer(nodes, chosen, [n])
    if (.not. any(chosen < 0 .or. chosen >= handle%model%online%model%n_nodes)) return
    call keep(handle%message, 'a node is out of range: nodes are numbered from 0 to the number of nodes minus 1')
    chosen => null()
  end function chosen_nodes

  !> Copies integers to the array of the caller, which has at least as many; it does nothing if `pointer` is null.
  subroutine put_integers(values, pointer)
    integer, intent(in) :: values(:)
    type(c_ptr), intent(in) :: pointer
    integer(c_int), pointer :: target(:)

    if (.not. c_associated(pointer)) return
    call c_f_pointer(pointer, target, [size(values)])
    target = values
  end subroutine put_integers

  !> Copies reals to the array of the caller, which has at least as many; it does nothing if `pointer` is null.
  subroutine put_reals(values, pointer)
    real(rk), intent(in) :: values(:)
    type(c_ptr), intent(in) :: pointer
    real(c_double), pointer :: target(:)

    if (.not. c_associated(pointer)) return
    call c_f_pointer(pointer, target, [size(values)])
    target = values
  end subroutine put_reals

  !> Gives the caller a pointer to a text, which ends with a null character; it does nothing if `pointer` is null.
  subroutine put_text(text, pointer)
    type(c_text_t), intent(in), target :: text
    type(c_ptr), intent(in) :: pointer
    type(c_ptr), pointer :: target

    if (.not. c_associated(pointer)) return
    call c_f_pointer(pointer, target)
    target = c_loc(text%characters)
  end subroutine put_text
end module sig_c_handles
