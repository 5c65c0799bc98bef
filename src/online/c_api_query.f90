! SPDX-License-Identifier: BSD-3-Clause
!> The functions of include/signorom.h for queries; each one is explained there.
module sig_c_api_query
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_loc, c_null_ptr, c_ptr, c_size_t
  use sig_c_answers, only: ask, copy_displacement, has_node, has_size, tell
  use sig_c_handles, only: answered_context, bad_argument, bad_model, chosen_nodes, code_ok, context_handle_t, given_numbers, &
    keep, no_answer, no_memory, put_reals, ready_context, ready_model
  use sig_reconstruction, only: fill_displacement, reconstruct_multipliers
  implicit none(type, external)
  private

contains

  integer(c_int) function signorom_create_context(model, context) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), intent(out), optional :: context
    type(context_handle_t), pointer :: handle
    character(:), allocatable :: message
    integer :: status

    code = bad_argument
    if (.not. present(context)) return
    context = c_null_ptr
    allocate (handle, stat=status)
    code = no_memory
    if (status /= 0) return
    context = c_loc(handle)
    call keep(handle%message, '')
    handle%model => ready_model(model, code)
    if (.not. associated(handle%model)) then
      call keep(handle%message, 'the model is a null pointer, or signorom_open failed for it')
      return
    end if
    code = bad_model
    call handle%query%create(handle%model%online, message)
    if (.not. allocated(message) .and. len(handle%model%field_refusal) == 0) call handle%fields%create(handle%model%online, message)
    if (allocated(message)) then
      call keep(handle%message, 'the model cannot answer: ' // message)
      return
    end if
    if (len(handle%model%field_refusal) > 0) call handle%query%leave_out_points()
    handle%is_ready = .true.
    code = code_ok
  end function signorom_create_context

  type(c_ptr) function signorom_message(context) result(message) bind(c)
    type(c_ptr), value :: context
    type(context_handle_t), pointer :: handle

    message = c_null_ptr
    if (.not. c_associated(context)) return
    call c_f_pointer(context, handle)
    message = c_loc(handle%message%characters)
  end function signorom_message

  subroutine signorom_free_context(context) bind(c)
    type(c_ptr), value :: context
    type(context_handle_t), pointer :: handle

    if (.not. c_associated(context)) return
    call c_f_pointer(context, handle)
    call handle%query%destroy()
    call handle%fields%destroy()
    deallocate (handle)
  end subroutine signorom_free_context

  integer(c_int) function signorom_query(context, point, answer) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: point
    type(c_ptr), value :: answer
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: values(:)
    integer(c_size_t) :: n_bytes

    code = bad_argument
    handle => ready_context(context)
    if (.not. associated(handle)) return
    handle%has_answer = .false.
    values => given_numbers(handle, point, size(handle%model%names), 'the point is')
    if (.not. associated(values)) return
    if (.not. has_size(handle, answer, 1_c_int, n_bytes)) return
    call ask(handle, values, code)
    if (c_associated(answer)) call tell(handle, code, n_bytes, answer)
  end function signorom_query

  integer(c_int) function signorom_get_domain_multipliers(context, multipliers) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: multipliers
    type(context_handle_t), pointer :: handle

    handle => answered_context(context, multipliers, code)
    if (associated(handle)) call put_reals(handle%answer%multipliers_rid, multipliers)
  end function signorom_get_domain_multipliers

  integer(c_int) function signorom_get_multipliers(context, multipliers) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: multipliers
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: target(:)

    handle => answered_context(context, multipliers, code)
    if (.not. associated(handle)) return
    call c_f_pointer(multipliers, target, [handle%model%online%model%n_multipliers])
    call reconstruct_multipliers(handle%model%online, handle%answer, handle%rooms, target)
  end function signorom_get_multipliers

  integer(c_int) function signorom_get_coordinates(context, coordinates) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: coordinates
    type(context_handle_t), pointer :: handle

    handle => answered_context(context, coordinates, code)
    if (associated(handle)) call put_reals(handle%answer%coordinates, coordinates)
  end function signorom_get_coordinates

  !> Returns the handle of a context whose last answer has displacements, perhaps of some nodes only. Otherwise it returns null, and
  !> the message of the context (unless `context` is null) says why: code = no_answer if the answer has forces only, bad_argument
  !> without an answer or if `array`, the array of the caller, is null.
  function displaced_context(context, array, code) result(handle)
    type(c_ptr), intent(in) :: context
    type(c_ptr), intent(in) :: array
    !> code_ok unless the result is null
    integer(c_int), intent(out) :: code
    type(context_handle_t), pointer :: handle

    handle => answered_context(context, array, code)
    if (.not. associated(handle)) return
    associate (answer => handle%answer, model => handle%model%online%model)
      if (model%parts(answer%displacement_part)%reduced%has_displacement()) return
    end associate
    call keep(handle%message, 'the model has no displacement: it answers contact forces only')
    code = no_answer
    handle => null()
  end function displaced_context

  integer(c_int) function signorom_get_displacement(context, displacement) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: displacement
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: target(:)

    handle => displaced_context(context, displacement, code)
    if (.not. associated(handle)) return
    call c_f_pointer(displacement, target, [handle%model%online%model%n_dofs])
    call fill_displacement(handle%model%online%model, handle%answer, target)
  end function signorom_get_displacement

  integer(c_int) function signorom_get_displacement_at(context, n, nodes, displacement) result(code) bind(c)
    type(c_ptr), value :: context
    integer(c_int), value :: n
    type(c_ptr), value :: nodes, displacement
    type(context_handle_t), pointer :: handle
    integer(c_int), pointer :: chosen(:)
    real(c_double), pointer :: target(:, :)
    integer :: i

    handle => displaced_context(context, displacement, code)
    if (.not. associated(handle)) return
    code = bad_argument
    chosen => chosen_nodes(handle, n, nodes)
    if (.not. associated(chosen)) return
    do i = 1, n
      if (has_node(handle, chosen(i))) cycle
      call keep(handle%message, 'a node has no displacement: see reduction.displacement of the deck')
      code = no_answer
      return
    end do
    call c_f_pointer(displacement, target, [handle%model%online%model%n_dim, int(n)])
    do i = 1, n
      call copy_displacement(handle, chosen(i), target(:, i))
    end do
    code = code_ok
  end function signorom_get_displacement_at
end module sig_c_api_query
