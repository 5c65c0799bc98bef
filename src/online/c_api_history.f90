! SPDX-License-Identifier: BSD-3-Clause
!> The functions of include/signorom.h for histories; each one is explained there.
module sig_c_api_history
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr, c_size_t
  use sig_c_answers, only: ask_time, has_size, tell
  use sig_c_handles, only: answered_context, bad_argument, code_ok, context_handle_t, given_numbers, keep, model_handle_t, &
    put_integers, put_reals, ready_context, ready_model
  use sig_history, only: states_of
  use sig_kinds, only: rk
  implicit none(type, external)
  private

contains

  integer(c_int) function signorom_get_history(model, n_given, n_times, times) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: n_given, n_times, times
    type(model_handle_t), pointer :: handle

    handle => ready_model(model, code)
    if (.not. associated(handle)) return
    associate (whole => handle%online%model)
      call put_integers([whole%n_given()], n_given)
      call put_integers([whole%history%n_times()], n_times)
      call put_reals(whole%history%times, times)
    end associate
  end function signorom_get_history

  integer(c_int) function signorom_get_states(context, parameters, states) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: parameters, states
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: values(:)
    real(rk), allocatable :: found(:, :)
    character(:), allocatable :: fault
    integer :: i_bad_point

    code = bad_argument
    handle => ready_context(context)
    if (.not. associated(handle)) return
    if (.not. (c_associated(parameters) .and. c_associated(states))) then
      call keep(handle%message, 'the parameters or the states are a null pointer')
      return
    end if
    associate (model => handle%model%online%model)
      call c_f_pointer(parameters, values, [model%n_given()])
      call states_of(model%history, model%parameter_names(:model%n_given()), reshape(values, [size(values), 1]), found, &
        i_bad_point, fault)
    end associate
    if (allocated(fault)) then
      call keep(handle%message, fault)
      return
    end if
    call put_reals(reshape(found, [size(found)]), states)
    code = code_ok
  end function signorom_get_states

  integer(c_int) function signorom_get_point(context, point) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: point
    type(context_handle_t), pointer :: handle

    handle => answered_context(context, point, code)
    if (associated(handle)) call put_reals(handle%point, point)
  end function signorom_get_point

  integer(c_int) function signorom_start(context, parameters) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: parameters
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: values(:)
    character(:), allocatable :: message

    code = bad_argument
    handle => ready_context(context)
    if (.not. associated(handle)) return
    handle%has_answer = .false.
    values => given_numbers(handle, parameters, handle%model%online%model%n_given(), 'the parameters are')
    if (.not. associated(values)) return
    call handle%query%start(handle%model%online, values, message)
    call take_message(handle, message, code)
  end function signorom_start

  integer(c_int) function signorom_advance(context, time, tables, answer) result(code) bind(c)
    type(c_ptr), value :: context
    real(c_double), value :: time
    type(c_ptr), value :: tables
    type(c_ptr), value :: answer
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: values(:)
    integer(c_size_t) :: n_bytes

    code = bad_argument
    handle => ready_context(context)
    if (.not. associated(handle)) return
    handle%has_answer = .false.
    if (.not. has_size(handle, answer, 1_c_int, n_bytes)) return
    values => null()
    if (c_associated(tables)) call c_f_pointer(tables, values, [size(handle%model%online%model%history%tables)])
    call ask_time(handle, time, values, code)
    if (code /= bad_argument .and. c_associated(answer)) call tell(handle, code, n_bytes, answer)
  end function signorom_advance

  integer(c_int) function signorom_get_memory_size(model, n) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), value :: n
    type(model_handle_t), pointer :: handle

    handle => ready_model(model, code)
    if (associated(handle)) call put_integers([handle%online%n_remembered()], n)
  end function signorom_get_memory_size

  integer(c_int) function signorom_get_memory(context, memory) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: memory
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: numbers(:)
    character(:), allocatable :: message

    code = bad_argument
    handle => ready_context(context)
    if (.not. associated(handle)) return
    numbers => given_numbers(handle, memory, handle%model%online%n_remembered(), 'the memory is')
    if (.not. associated(numbers)) return
    call handle%query%save_memory(handle%model%online, numbers, message)
    call take_message(handle, message, code)
  end function signorom_get_memory

  integer(c_int) function signorom_set_memory(context, memory) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: memory
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: numbers(:)
    character(:), allocatable :: message

    code = bad_argument
    handle => ready_context(context)
    if (.not. associated(handle)) return
    numbers => given_numbers(handle, memory, handle%model%online%n_remembered(), 'the memory is')
    if (.not. associated(numbers)) return
    handle%has_answer = .false.
    call handle%query%restore_memory(handle%model%online, numbers, message)
    call take_message(handle, message, code)
  end function signorom_set_memory

  !> Keeps a message in its context; without one the code is code_ok.
  subroutine take_message(handle, message, code)
    type(context_handle_t), intent(inout) :: handle
    character(:), allocatable, intent(in) :: message
    !> in: what it is with a message
    integer(c_int), intent(inout) :: code

    if (allocated(message)) then
      call keep(handle%message, message)
    else
      code = code_ok
    end if
  end subroutine take_message
end module sig_c_api_history
