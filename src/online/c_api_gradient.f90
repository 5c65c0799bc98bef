! SPDX-License-Identifier: BSD-3-Clause
!> The functions of include/signorom.h for derivatives with respect to the parameters; each one is explained there.
module sig_c_api_gradient
  use, intrinsic :: iso_c_binding, only: c_double, c_f_pointer, c_int, c_ptr
  use sig_c_handles, only: answered_context, bad_argument, chosen_nodes, code_ok, context_handle_t, keep, no_answer, &
    put_integers, put_reals, ready_context
  use sig_kinds, only: rk
  use sig_reduced, only: displacement_none
  implicit none(type, external)
  private

contains

  integer(c_int) function signorom_differentiate(context, direction, n_grazing, is_one_sided) result(code) bind(c)
    type(c_ptr), value :: context
    integer(c_int), value :: direction
    type(c_ptr), value :: n_grazing, is_one_sided
    type(context_handle_t), pointer :: handle
    character(:), allocatable :: message

    code = bad_argument
    handle => ready_context(context)
    if (.not. associated(handle)) return
    handle%has_gradient = .false.
    if (abs(direction) /= 1) then
      call keep(handle%message, 'the direction of derivatives must be 1 or -1')
      return
    end if
    handle => answered_context(context, context, code)
    if (.not. associated(handle)) return
    call handle%query%differentiate(handle%model%online, handle%point, handle%answer, int(direction), handle%gradient, message)
    code = no_answer
    if (allocated(message)) then
      call keep(handle%message, message)
      return
    end if
    handle%has_gradient = .true.
    call put_integers([handle%gradient%n_grazing], n_grazing)
    call put_integers(merge(1, 0, handle%gradient%is_one_sided), is_one_sided)
    code = code_ok
  end function signorom_differentiate

  !> Returns the handle of a context for which signorom_differentiate succeeded after the last query. Otherwise, or if `array`, the
  !> array of the caller, is null, it returns null and code = bad_argument, and the message of the context (unless `context` is
  !> null) says why.
  function differentiated_context(context, array, code) result(handle)
    type(c_ptr), intent(in) :: context
    type(c_ptr), intent(in) :: array
    !> code_ok unless the result is null
    integer(c_int), intent(out) :: code
    type(context_handle_t), pointer :: handle

    handle => answered_context(context, array, code)
    if (.not. associated(handle)) return
    if (handle%has_gradient) return
    code = bad_argument
    call keep(handle%message, 'there are no derivatives: signorom_differentiate was not called after the last query, or it failed')
    handle => null()
  end function differentiated_context

  integer(c_int) function signorom_get_multiplier_gradient(context, gradient) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: gradient
    type(context_handle_t), pointer :: handle

    handle => differentiated_context(context, gradient, code)
    if (associated(handle)) &
      call put_reals(reshape(handle%gradient%multipliers, [size(handle%gradient%multipliers)]), gradient)
  end function signorom_get_multiplier_gradient

  !> Gives the derivatives of the resultants with respect to each parameter, in arrays of the caller (shapes: signorom.h): the
  !> resultants of the derivatives of the multipliers, as forces and moments are linear in these. code is code_ok, or bad_argument
  !> as for differentiated_context; then nothing is written. An array that is null is such an error.
  integer(c_int) function signorom_get_resultant_gradient(context, forces, moments) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: forces, moments
    type(context_handle_t), pointer :: handle
    real(c_double), pointer :: told_forces(:, :, :), told_moments(:, :, :)
    real(rk), allocatable :: areas(:)
    integer :: i

    handle => differentiated_context(context, forces, code)
    if (associated(handle)) handle => differentiated_context(context, moments, code)
    if (.not. associated(handle)) return
    associate (whole => handle%model%online%model, n => handle%model%online%model%resultants%n_entries(), &
      of_multipliers => handle%gradient%multipliers)
      call c_f_pointer(forces, told_forces, [whole%n_dim, n, size(of_multipliers, 2)])
      call c_f_pointer(moments, told_moments, [whole%resultants%n_moments(), n, size(of_multipliers, 2)])
      allocate (areas(n))
      do i = 1, size(of_multipliers, 2)
        call whole%resultants%evaluate(whole%laws, whole%areas, of_multipliers(:, i), areas, told_forces(:, :, i), &
          told_moments(:, :, i))
      end do
    end associate
  end function signorom_get_resultant_gradient

  integer(c_int) function signorom_get_displacement_gradient_at(context, n, nodes, gradient) result(code) bind(c)
    type(c_ptr), value :: context
    integer(c_int), value :: n
    type(c_ptr), value :: nodes, gradient
    type(context_handle_t), pointer :: handle
    integer(c_int), pointer :: chosen(:)
    real(c_double), pointer :: target(:, :)
    integer :: i

    handle => differentiated_context(context, gradient, code)
    if (.not. associated(handle)) return
    code = bad_argument
    chosen => chosen_nodes(handle, n, nodes)
    if (.not. associated(chosen)) return
    code = no_answer
    if (.not. all_have_displacements(handle, chosen)) return
    associate (model => handle%model%online%model)
      call c_f_pointer(gradient, target, [model%n_dim * int(n), size(handle%point)])
      do i = 1, size(handle%point)
        associate (answer => handle%gradient%answer)
          call model%parts(answer%part)%reduced%displacement_changes(answer, handle%gradient, i, dofs_of(model%n_dim, chosen), &
            target(:, i))
        end associate
      end do
    end associate
    code = code_ok
  end function signorom_get_displacement_gradient_at

  integer(c_int) function signorom_get_displacement_gradient_errors(context, errors) result(code) bind(c)
    type(c_ptr), value :: context
    type(c_ptr), value :: errors
    type(context_handle_t), pointer :: handle

    handle => differentiated_context(context, errors, code)
    if (.not. associated(handle)) return
    associate (answer => handle%gradient%answer)
      call put_reals(handle%model%online%model%parts(answer%part)%reduced%change_errors(answer, handle%gradient), errors)
    end associate
  end function signorom_get_displacement_gradient_errors

  !> Whether each of the nodes has a derivative of its displacement; otherwise the message of the context says that one has none. It
  !> is false for any list, even an empty one, if another part than the one with the derivatives gives the displacement.
  logical function all_have_displacements(handle, nodes)
    type(context_handle_t), intent(inout) :: handle
    !> node numbers, 0-based
    integer(c_int), intent(in) :: nodes(:)
    integer :: i

    associate (model => handle%model%online%model, answer => handle%gradient%answer)
      all_have_displacements = answer%displacement_part == answer%part
      do i = 1, size(nodes)
        if (.not. all_have_displacements) exit
        all_have_displacements = model%parts(answer%part)%reduced%displacement_source(model%n_dim * (nodes(i) + 1)) /= &
          displacement_none
      end do
    end associate
    if (.not. all_have_displacements) call keep(handle%message, &
      'the displacement of a node has no derivative: see reduction.displacement of the deck, or ' // &
      'reduction.max_full_order_size if the model is hyper-reduced')
  end function all_have_displacements

  !> Returns the dofs of nodes, 1-based: those of the first node, then those of the second, and so on.
  pure function dofs_of(n_dim, nodes) result(dofs)
    integer, intent(in) :: n_dim
    !> node numbers, 0-based
    integer(c_int), intent(in) :: nodes(:)
    integer :: dofs(n_dim * size(nodes))
    integer :: i, k

    dofs = [((n_dim * nodes(i) + k, k=1, n_dim), i=1, size(nodes))]
  end function dofs_of
end module sig_c_api_gradient
