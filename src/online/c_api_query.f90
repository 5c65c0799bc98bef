! SPDX-License-Identifier: BSD-3-Clause
!> The part of include/signorom.h that asks models; each procedure is explained there.
module sig_c_api_query
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_intptr_t, c_loc, c_null_ptr, c_ptr, &
    c_size_t, c_sizeof
  use sig_c_handles, only: answered_context, bad_argument, bad_model, chosen_nodes, code_ok, context_handle_t, keep, &
    no_answer, no_memory, &
    put_reals, ready_context, ready_model
  use sig_kinds, only: rk
  use sig_reasons, only: put_reason, reason_length
  use sig_reduced, only: displacement_none
  use sig_reconstruction, only: displacement_of_dof, fill_displacement, reconstruct_multipliers
  implicit none(type, external)
  private

  !> signorom_answer
  type, bind(c) :: c_answer_t
    integer(c_size_t) :: size
    integer(c_int) :: code, method, cluster, n_modes, n_domain_contacts, n_active, n_iterations, is_inside_box
    real(c_double) :: distance, residual
    integer(c_int) :: n_solutions
    real(c_double) :: bound, relative_bound, displacement_bound, relative_displacement_bound
  end type c_answer_t

  !> size of the first version, which ends with n_solutions and what fills it up
  integer(c_size_t), parameter :: first_size = 64

contains

  integer(c_int) function signorom_create_context(model, context) result(code) bind(c)
    type(c_ptr), value :: model
    type(c_ptr), intent(out) :: context
    type(context_handle_t), pointer :: handle
    character(:), allocatable :: message
    integer :: status

    context = c_null_ptr
    allocate (handle, stat=status)
    code = no_memory
    if (status /= 0) return
    context = c_loc(handle)
    call keep(handle%message, '')
    code = bad_argument
    handle%model => ready_model(model)
    if (.not. associated(handle%model)) then
      call keep(handle%message, 'the model was not opened, or could not be')
      return
    end if
    code = bad_model
    call handle%query%create(handle%model%online, message)
    if (.not. allocated(message) .and. len(handle%model%field_refusal) == 0) call handle%fields%create(handle%model%online, message)
    if (allocated(message)) then
      call keep(handle%message, 'the model cannot answer: ' // message)
      return
    end if
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
    if (.not. c_associated(point)) then
      call keep(handle%message, 'the point is a null pointer')
      return
    end if
    if (.not. has_size(handle, answer, n_bytes)) return
    call c_f_pointer(point, values, [size(handle%model%names)])
    call ask(handle, values, code)
    if (c_associated(answer)) call tell(handle, code, n_bytes, answer)
  end function signorom_query

  !> Whether the caller has said how large its answers are. A program with a newer header has larger ones; zero, as in an answer
  !> that was
  !> filled with zeros, means the first version of the struct, which every later one begins with.
  logical function has_size(handle, answer, n_bytes)
    type(context_handle_t), intent(inout) :: handle
    !> or null
    type(c_ptr), intent(in) :: answer
    !> 0 for null
    integer(c_size_t), intent(out) :: n_bytes
    type(c_answer_t), pointer :: told
    !> no version will be as large: it is what an uninitialized answer says
    integer(c_size_t), parameter :: too_large = 65536

    n_bytes = 0
    has_size = .true.
    if (.not. c_associated(answer)) return
    call c_f_pointer(answer, told)
    n_bytes = told%size
    if (n_bytes == 0) n_bytes = first_size
    has_size = n_bytes >= first_size .and. n_bytes < too_large
    if (.not. has_size) call keep(handle%message, 'the size of the answer is not set: signorom_answer answer = SIGNOROM_ANSWER;')
  end function has_size

  subroutine ask(handle, point, code)
    type(context_handle_t), intent(inout) :: handle
    real(rk), intent(in) :: point(:)
    integer(c_int), intent(out) :: code

    handle%point = point
    handle%has_gradient = .false.
    handle%has_fields = .false.
    call handle%query%evaluate(handle%model%online, point, handle%answer)
    handle%has_answer = handle%answer%reason > 0
    code = code_ok
    if (handle%has_answer) return
    code = no_answer
    call keep_reason(handle)
  end subroutine ask

  subroutine keep_reason(handle)
    type(context_handle_t), intent(inout) :: handle
    character(reason_length) :: text

    call put_reason(handle%answer%reason, text)
    call keep(handle%message, trim(text))
  end subroutine keep_reason

  subroutine tell(handle, code, n_bytes, place)
    type(context_handle_t), intent(in) :: handle
    integer(c_int), intent(in) :: code
    !> of the caller's answer; what lies behind the members known here stays as it is
    integer(c_size_t), intent(in) :: n_bytes
    type(c_ptr), intent(in) :: place
    ! volatile: its bytes are read as characters, which an optimizer need not expect
    type(c_answer_t), target, volatile :: told
    character(1), pointer :: bytes(:), own(:)

    associate (answer => handle%answer)
      told = c_answer_t(size=n_bytes, code=code, method=merge(answer%method, 0, handle%has_answer), cluster=answer%cluster - 1, &
        n_modes=size(answer%coordinates), n_domain_contacts=size(answer%multipliers_rid), n_active=count(answer%is_active), &
        n_iterations=answer%n_iterations, is_inside_box=merge(1, 0, answer%is_inside_box), distance=answer%distance, &
        residual=answer%residual, n_solutions=answer%n_solutions, bound=answer%bound, relative_bound=answer%relative_bound, &
        displacement_bound=answer%displacement_bound, relative_displacement_bound=answer%relative_displacement_bound)
    end associate
    call c_f_pointer(place, bytes, [min(n_bytes, c_sizeof(told))])
    call c_f_pointer(c_loc(told), own, [size(bytes)])
    bytes = own
  end subroutine tell

  integer(c_int) function signorom_query_many(context, n, points, answers, multipliers) result(code) bind(c)
    type(c_ptr), value :: context
    integer(c_int), value :: n
    type(c_ptr), value :: points, answers, multipliers
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: forces(:, :), values(:, :)
    integer(c_int) :: code_of_point
    integer(c_size_t) :: n_bytes
    integer :: i, n_failed

    code = bad_argument
    handle => ready_context(context)
    if (.not. associated(handle)) return
    handle%has_answer = .false.
    if (n < 0 .or. .not. c_associated(points)) then
      call keep(handle%message, 'the number of points is negative, or the points are a null pointer')
      return
    end if
    if (n > 0) then
      if (.not. has_size(handle, answers, n_bytes)) return
    end if
    call c_f_pointer(points, values, [size(handle%model%names), int(n)])
    if (c_associated(multipliers)) call c_f_pointer(multipliers, forces, [handle%model%online%model%n_multipliers, int(n)])
    n_failed = 0
    do i = 1, n
      call ask(handle, values(:, i), code_of_point)
      if (code_of_point /= code_ok) n_failed = n_failed + 1
      if (c_associated(answers)) call tell(handle, code_of_point, n_bytes, place_of(answers, n_bytes, i))
      if (.not. c_associated(multipliers)) cycle
      call reconstruct_multipliers(handle%model%online, handle%answer, handle%rooms, forces(:, i))
    end do
    code = code_ok
    if (n_failed == 0) return
    code = no_answer
    call keep(handle%message, 'some of the points have no answer; the code of each answer says which')
  end function signorom_query_many

  !> Where entry i of an array stands, 1-based.
  pure function place_of(first, n_bytes, i) result(place)
    type(c_ptr), intent(in) :: first
    !> of an entry
    integer(c_size_t), intent(in) :: n_bytes
    integer, intent(in) :: i
    type(c_ptr) :: place

    place = transfer(transfer(first, 0_c_intptr_t) + (i - 1) * n_bytes, place)
  end function place_of

  integer(c_int) function signorom_get_domain_multipliers(context, multipliers) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: multipliers
    type(context_handle_t), pointer :: handle

    code = bad_argument
    handle => answered_context(context, multipliers)
    if (.not. associated(handle)) return
    call put_reals(handle%answer%multipliers_rid, multipliers)
    code = code_ok
  end function signorom_get_domain_multipliers

  integer(c_int) function signorom_get_multipliers(context, multipliers) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: multipliers
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: target(:)

    code = bad_argument
    handle => answered_context(context, multipliers)
    if (.not. associated(handle)) return
    call c_f_pointer(multipliers, target, [handle%model%online%model%n_multipliers])
    call reconstruct_multipliers(handle%model%online, handle%answer, handle%rooms, target)
    code = code_ok
  end function signorom_get_multipliers

  integer(c_int) function signorom_get_coordinates(context, coordinates) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: coordinates
    type(context_handle_t), pointer :: handle

    code = bad_argument
    handle => answered_context(context, coordinates)
    if (.not. associated(handle)) return
    call put_reals(handle%answer%coordinates, coordinates)
    code = code_ok
  end function signorom_get_coordinates

  !> Whether the model answers displacements; the message says so where it does not.
  logical function has_displacement(handle)
    type(context_handle_t), intent(inout) :: handle

    associate (answer => handle%answer, model => handle%model%online%model)
      has_displacement = model%parts(answer%displacement_part)%reduced%has_displacement()
    end associate
    if (.not. has_displacement) call keep(handle%message, 'the model has no displacement: it answers contact forces only')
  end function has_displacement

  integer(c_int) function signorom_get_displacement(context, displacement) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: displacement
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: target(:)

    code = bad_argument
    handle => answered_context(context, displacement)
    if (.not. associated(handle)) return
    code = no_answer
    if (.not. has_displacement(handle)) return
    code = bad_argument
    call c_f_pointer(displacement, target, [handle%model%online%model%n_dofs])
    call fill_displacement(handle%model%online%model, handle%answer, target)
    code = code_ok
  end function signorom_get_displacement

  integer(c_int) function signorom_get_displacement_at(context, n, nodes, displacement) result(code) bind(c)
    type(c_ptr), value :: context
    integer(c_int), value :: n
    type(c_ptr), value :: nodes, displacement
    type(context_handle_t), pointer :: handle
    integer(c_int), pointer :: chosen(:)
    real(c_double), pointer :: target(:, :)
    integer :: i, k

    code = bad_argument
    handle => answered_context(context, displacement)
    if (.not. associated(handle)) return
    code = no_answer
    if (.not. has_displacement(handle)) return
    code = bad_argument
    chosen => chosen_nodes(handle, n, nodes)
    if (.not. associated(chosen)) return
    associate (model => handle%model%online%model)
      do i = 1, n
        if (model%parts(handle%answer%displacement_part)%reduced%displacement_source(model%n_dim * (chosen(i) + 1)) /= &
          displacement_none) cycle
        call keep(handle%message, 'a node has no displacement: see reduction.displacement of the deck')
        code = no_answer
        return
      end do
      call c_f_pointer(displacement, target, [model%n_dim, int(n)])
      do i = 1, n
        do k = 1, model%n_dim
          target(k, i) = displacement_of_dof(model, handle%answer, model%n_dim * chosen(i) + k)
        end do
      end do
    end associate
    code = code_ok
  end function signorom_get_displacement_at
end module sig_c_api_query
