! SPDX-License-Identifier: BSD-3-Clause
!> Queries a context at a point and fills the caller's signorom_answer.
module sig_c_answers
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_intptr_t, c_loc, c_ptr, c_size_t, &
    c_sizeof
  use sig_c_handles, only: bad_argument, code_ok, context_handle_t, keep, no_answer
  use sig_kinds, only: rk
  use sig_reasons, only: reason_length
  use sig_reconstruction, only: displacement_of_dof
  use sig_reduced, only: displacement_none
  implicit none(type, external)
  private
  public :: ask, ask_next, ask_time, copy_displacement, has_node, has_size, place_of, tell, too_large

  !> the structure signorom_answer of signorom.h
  type, bind(c) :: c_answer_t
    integer(c_size_t) :: size
    integer(c_int) :: code, method, cluster, n_modes, n_domain_contacts, n_active, n_iterations, is_inside_box
    real(c_double) :: distance, residual
    integer(c_int) :: n_solutions
    real(c_double) :: bound, relative_bound, displacement_bound, relative_displacement_bound
    integer(c_int) :: n_free_motions
    real(c_double) :: error_estimate
  end type c_answer_t

  !> [bytes] size of the first version of the structure, which ends with n_solutions and padding
  integer(c_size_t), parameter :: first_size = 64
  !> [bytes] a size of this or more can only come from a structure that was not initialized: no version will be as large
  integer(c_size_t), parameter :: too_large = 65536

contains

  !> Whether `answer` is null, or the component `size` of the caller's answer is possible. If not, the message of the context says
  !> how to set the size. It must be at least first_size and less than too_large; a program with a newer header has larger answers.
  !> For one answer the size may be 0, as in an answer filled with zeros. It then means the first version of the structure, with
  !> which every later version begins. For several answers it may not be 0, because it must tell their distance.
  logical function has_size(handle, answer, n, n_bytes)
    type(context_handle_t), intent(inout) :: handle
    !> the caller's answer, or the first of several, or null
    type(c_ptr), intent(in) :: answer
    !> number of answers
    integer(c_int), intent(in) :: n
    !> [bytes] size of one answer of the caller, and so the distance of two answers in an array: first_size if `size` is 0; 0 for
    !> null
    integer(c_size_t), intent(out) :: n_bytes
    type(c_answer_t), pointer :: told

    n_bytes = 0
    has_size = .true.
    if (.not. c_associated(answer)) return
    call c_f_pointer(answer, told)
    n_bytes = told%size
    if (n_bytes == 0 .and. n == 1) n_bytes = first_size
    has_size = n_bytes >= first_size .and. n_bytes < too_large
    if (.not. has_size) call keep(handle%message, &
      'the size of the answer, or of the first of several, is not set: signorom_answer answer = SIGNOROM_ANSWER;')
  end function has_size

  !> Asks the model at a point and keeps the result in the context; the fields and derivatives of the answer before are dropped.
  !> code is code_ok or, if the point has no answer, no_answer; then the message of the context gives the reason.
  subroutine ask(handle, point, code)
    type(context_handle_t), intent(inout) :: handle
    !> values of the parameters, shape (n_parameters)
    real(rk), intent(in) :: point(:)
    integer(c_int), intent(out) :: code

    handle%point = point
    call handle%query%evaluate(handle%model%online, point, handle%answer)
    call take_answer(handle, code)
  end subroutine ask

  !> Asks the next point of a list (query%continue), and keeps the result as `ask` does.
  subroutine ask_next(handle, point, code)
    type(context_handle_t), intent(inout) :: handle
    real(rk), intent(in) :: point(:)
    integer(c_int), intent(out) :: code

    handle%point = point
    call handle%query%continue(handle%model%online, point, handle%answer)
    call take_answer(handle, code)
  end subroutine ask_next

  !> Asks the next time of a history (query%advance), and keeps the result as `ask` does. If the time or the number of tables is
  !> refused, code is bad_argument, and the context has no answer.
  subroutine ask_time(handle, time, tables, code)
    type(context_handle_t), intent(inout) :: handle
    real(rk), intent(in) :: time
    !> values of all tables; not associated: those of the model's tables
    real(c_double), pointer, intent(in) :: tables(:)
    integer(c_int), intent(out) :: code
    character(:), allocatable :: message

    handle%has_answer = .false.
    if (associated(tables)) then
      call handle%query%advance(handle%model%online, time, handle%answer, handle%point, message, tables)
    else
      call handle%query%advance(handle%model%online, time, handle%answer, handle%point, message)
    end if
    code = bad_argument
    if (allocated(message)) then
      call keep(handle%message, message)
    else
      call take_answer(handle, code)
    end if
  end subroutine ask_time

  !> Drops the derivatives and fields of the answer before. code is code_ok or, if the last query had no answer, no_answer; then the
  !> message of the context gives the reason.
  subroutine take_answer(handle, code)
    type(context_handle_t), intent(inout) :: handle
    integer(c_int), intent(out) :: code

    handle%has_gradient = .false.
    handle%has_fields = .false.
    handle%has_answer = handle%answer%reason > 0
    code = code_ok
    if (handle%has_answer) return
    code = no_answer
    call keep_reason(handle)
  end subroutine take_answer

  !> Makes the text of the reason why the last point has no answer the message of the context.
  subroutine keep_reason(handle)
    type(context_handle_t), intent(inout) :: handle
    character(reason_length) :: text

    call handle%model%online%model%parts(handle%answer%part)%reduced%put_refusal(handle%answer, text)
    call keep(handle%message, trim(text))
  end subroutine keep_reason

  !> Writes the last answer of a context, `code` and n_bytes to the caller's signorom_answer; the method is 0 without an answer.
  subroutine tell(handle, code, n_bytes, place)
    type(context_handle_t), intent(in) :: handle
    integer(c_int), intent(in) :: code
    !> [bytes] size of the caller's structure, from has_size: members behind it are not written; bytes behind the members known here
    !> stay unchanged
    integer(c_size_t), intent(in) :: n_bytes
    !> address of the caller's answer
    type(c_ptr), intent(in) :: place
    ! volatile: the bytes are read as characters, which an optimizer need not expect
    type(c_answer_t), target, volatile :: told
    character(1), pointer :: bytes(:), own(:)

    associate (answer => handle%answer)
      told = c_answer_t(size=n_bytes, code=code, method=merge(answer%method, 0, handle%has_answer), cluster=answer%cluster - 1, &
        n_modes=size(answer%coordinates), n_domain_contacts=size(answer%multipliers_rid), n_active=count(answer%is_active), &
        n_iterations=answer%n_iterations, is_inside_box=merge(1, 0, answer%is_inside_box), distance=answer%distance, &
        residual=answer%residual, n_solutions=answer%n_solutions, bound=answer%bound, relative_bound=answer%relative_bound, &
        displacement_bound=answer%displacement_bound, relative_displacement_bound=answer%relative_displacement_bound, &
        n_free_motions=answer%n_free_motions, error_estimate=answer%error_estimate)
    end associate
    call c_f_pointer(place, bytes, [min(n_bytes, c_sizeof(told))])
    call c_f_pointer(c_loc(told), own, [size(bytes)])
    bytes = own
  end subroutine tell

  !> Whether the last answer has a displacement of this node. Requires: an answer whose displacement_part has displacements
  !> (has_displacement), and a node of the model.
  logical function has_node(handle, node)
    type(context_handle_t), intent(in) :: handle
    !> number of the node, 0-based
    integer(c_int), intent(in) :: node

    associate (model => handle%model%online%model)
      has_node = model%parts(handle%answer%displacement_part)%reduced%displacement_source(model%n_dim * (node + 1)) /= &
        displacement_none
    end associate
  end function has_node

  !> Copies the displacement of a node in the last answer to `displacement`. Requires: has_node.
  subroutine copy_displacement(handle, node, displacement)
    type(context_handle_t), intent(in) :: handle
    !> number of the node, 0-based
    integer(c_int), intent(in) :: node
    !> [length] shape (n_dim)
    real(c_double), intent(out) :: displacement(:)
    integer :: k

    associate (model => handle%model%online%model)
      do k = 1, model%n_dim
        displacement(k) = displacement_of_dof(model, handle%answer, model%n_dim * node + k)
      end do
    end associate
  end subroutine copy_displacement

  !> Returns the address of element i of an array whose elements have a size that only the caller knows.
  pure function place_of(first, n_bytes, i) result(place)
    !> address of the first element
    type(c_ptr), intent(in) :: first
    !> [bytes] size of an element
    integer(c_size_t), intent(in) :: n_bytes
    !> 1-based
    integer, intent(in) :: i
    type(c_ptr) :: place

    place = transfer(transfer(first, 0_c_intptr_t) + (i - 1) * n_bytes, place)
  end function place_of
end module sig_c_answers
