! SPDX-License-Identifier: BSD-3-Clause
!> The functions of include/signorom.h that answer many points in one call; each one is explained there.
module sig_c_api_many
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr, c_size_t, c_sizeof
  use sig_c_answers, only: ask_next, copy_displacement, has_node, has_size, place_of, tell, too_large
  use sig_c_handles, only: bad_argument, chosen_nodes, code_ok, context_handle_t, keep, no_answer, ready_context
  use sig_kinds, only: rk
  use sig_reconstruction, only: reconstruct_multipliers
  implicit none(type, external)
  private

  !> the structure signorom_arrays of signorom.h
  type, bind(c) :: c_arrays_t
    integer(c_size_t) :: size
    type(c_ptr) :: answers, multipliers, areas, forces, moments
    integer(c_int) :: n_nodes
    type(c_ptr) :: nodes, displacement
  end type c_arrays_t

  !> The caller's arrays; their last index is the point, except in `nodes`. An array that the caller does not want is null.
  type :: targets_t
    integer(c_int), pointer :: nodes(:) => null()
    real(c_double), pointer :: multipliers(:, :) => null()
    real(c_double), pointer :: areas(:, :) => null()
    real(c_double), pointer :: forces(:, :, :) => null()
    real(c_double), pointer :: moments(:, :, :) => null()
    real(c_double), pointer :: displacement(:, :, :) => null()
  end type targets_t

contains

  integer(c_int) function signorom_query_many(context, n, points, answers, multipliers) result(code) bind(c)
    type(c_ptr), value :: context
    integer(c_int), value :: n
    type(c_ptr), value :: points, answers, multipliers
    type(context_handle_t), pointer :: handle
    type(targets_t) :: targets

    code = bad_argument
    handle => ready_context(context)
    if (.not. associated(handle)) return
    if (n < 0 .or. .not. c_associated(points)) then
      call refuse_points(handle)
      return
    end if
    if (c_associated(multipliers)) &
      call c_f_pointer(multipliers, targets%multipliers, [handle%model%online%model%n_multipliers, int(n)])
    call ask_all(handle, n, points, answers, targets, code)
  end function signorom_query_many

  integer(c_int) function signorom_query_arrays(context, n, points, arrays) result(code) bind(c)
    type(c_ptr), value :: context
    integer(c_int), value :: n
    type(c_ptr), value :: points, arrays
    type(context_handle_t), pointer :: handle
    type(c_arrays_t), pointer :: given
    type(targets_t) :: targets
    logical :: is_fine

    code = bad_argument
    handle => ready_context(context)
    if (.not. associated(handle)) return
    if (n < 0 .or. .not. (c_associated(points) .and. c_associated(arrays))) then
      call refuse_points(handle)
      return
    end if
    call c_f_pointer(arrays, given)
    call set_targets(handle, n, given, targets, is_fine)
    if (is_fine) call ask_all(handle, n, points, given%answers, targets, code)
  end function signorom_query_arrays

  !> Drops the last answer, and keeps the message that the number of points is negative, or the points or the arrays are null.
  subroutine refuse_points(handle)
    type(context_handle_t), intent(inout) :: handle

    handle%has_answer = .false.
    call keep(handle%message, 'the number of points is negative, or the points or the arrays are a null pointer')
  end subroutine refuse_points

  !> Drops the last answer, and sets pointers to those arrays of the caller that are given. is_fine is false, and the message of the
  !> context says why, if the size of the structure is not set, if only some of areas, forces and moments are given or multipliers
  !> are missing beside them, or if `displacement` is given and n_nodes is negative or the nodes are null or out of range.
  subroutine set_targets(handle, n, given, targets, is_fine)
    type(context_handle_t), intent(inout) :: handle
    !> number of points
    integer(c_int), intent(in) :: n
    !> the structure of the caller
    type(c_arrays_t), intent(in) :: given
    !> in: all pointers are null
    type(targets_t), intent(inout) :: targets
    logical, intent(out) :: is_fine

    handle%has_answer = .false.
    is_fine = are_consistent(handle, given)
    if (.not. is_fine) return
    associate (model => handle%model%online%model)
      if (c_associated(given%multipliers)) &
        call c_f_pointer(given%multipliers, targets%multipliers, [model%n_multipliers, int(n)])
      if (c_associated(given%areas)) then
        associate (n_entries => model%resultants%n_entries())
          call c_f_pointer(given%areas, targets%areas, [n_entries, int(n)])
          call c_f_pointer(given%forces, targets%forces, [model%n_dim, n_entries, int(n)])
          call c_f_pointer(given%moments, targets%moments, [model%resultants%n_moments(), n_entries, int(n)])
        end associate
      end if
      if (.not. c_associated(given%displacement)) return
      targets%nodes => chosen_nodes(handle, given%n_nodes, given%nodes)
      is_fine = associated(targets%nodes)
      if (is_fine) call c_f_pointer(given%displacement, targets%displacement, [model%n_dim, size(targets%nodes), int(n)])
    end associate
  end subroutine set_targets

  !> Whether the caller has set the size of its structure (at least that of c_arrays_t and less than too_large; 0 is refused), and
  !> has given areas, forces and moments all or none, and only with multipliers; otherwise the message of the context says what is
  !> wrong.
  logical function are_consistent(handle, given)
    type(context_handle_t), intent(inout) :: handle
    type(c_arrays_t), intent(in) :: given

    are_consistent = given%size >= c_sizeof(given) .and. given%size < too_large
    if (.not. are_consistent) then
      call keep(handle%message, 'the size of the arrays is not set: signorom_arrays arrays = SIGNOROM_ARRAYS;')
      return
    end if
    associate (has_resultants => [c_associated(given%areas), c_associated(given%forces), c_associated(given%moments)])
      are_consistent = .not. any(has_resultants) .or. (all(has_resultants) .and. c_associated(given%multipliers))
    end associate
    if (.not. are_consistent) call keep(handle%message, &
      'give areas, forces and moments all or none, and only together with multipliers')
  end function are_consistent

  !> Queries one point after the other (states of histories in their order: query%continue), and fills `answers` and `targets`. The
  !> context then has the answer of the last point, if there is one. code is code_ok; no_answer if a point has no answer (the others
  !> are answered all the same); bad_argument, without any query, if there are points and the size of the answers is not possible
  !> (has_size). Unless code is code_ok, the message of the context says why.
  subroutine ask_all(handle, n, points, answers, targets, code)
    type(context_handle_t), intent(inout) :: handle
    !> number of points
    integer(c_int), intent(in) :: n
    !> values of the parameters, one point after the other
    type(c_ptr), intent(in) :: points
    !> the caller's answers, or null
    type(c_ptr), intent(in) :: answers
    type(targets_t), intent(inout) :: targets
    integer(c_int), intent(out) :: code
    real(c_double), pointer :: values(:, :)
    integer(c_int) :: code_of_point
    integer(c_size_t) :: n_bytes
    integer :: i, n_failed

    code = bad_argument
    handle%has_answer = .false.
    if (n > 0) then
      if (.not. has_size(handle, answers, n, n_bytes)) return
    end if
    call c_f_pointer(points, values, [size(handle%model%names), int(n)])
    n_failed = 0
    call handle%query%end_history()
    do i = 1, n
      call ask_next(handle, values(:, i), code_of_point)
      if (code_of_point /= code_ok) n_failed = n_failed + 1
      if (c_associated(answers)) call tell(handle, code_of_point, n_bytes, place_of(answers, n_bytes, i))
      call fill_targets(handle, i, targets)
    end do
    code = code_ok
    if (n_failed == 0) return
    code = no_answer
    call keep(handle%message, 'at least one of the points has no answer; the codes in `answers`, if this array is given, say which')
  end subroutine ask_all

  !> Writes forces, resultants and displacements of the last answer to those arrays of the caller that are given, at point i.
  !> Without an answer all of them are NaN, except the resultants of an entry without contacts, which are always 0.
  subroutine fill_targets(handle, i, targets)
    type(context_handle_t), intent(inout) :: handle
    !> number of the point, 1-based
    integer, intent(in) :: i
    type(targets_t), intent(inout) :: targets

    if (associated(targets%multipliers)) then
      if (handle%has_answer) then
        call reconstruct_multipliers(handle%model%online, handle%answer, handle%rooms, targets%multipliers(:, i))
      else
        targets%multipliers(:, i) = ieee_value(1.0_rk, ieee_quiet_nan)
      end if
      if (associated(targets%areas)) then
        associate (model => handle%model%online%model)
          call model%resultants%evaluate(model%laws, model%areas, targets%multipliers(:, i), targets%areas(:, i), &
            targets%forces(:, :, i), targets%moments(:, :, i))
        end associate
      end if
    end if
    if (associated(targets%displacement)) call fill_nodes(handle, targets%nodes, targets%displacement(:, :, i))
  end subroutine fill_targets

  !> Computes the displacement of the chosen nodes in the last answer; NaN without an answer, and for nodes that have none.
  subroutine fill_nodes(handle, nodes, displacement)
    type(context_handle_t), intent(in) :: handle
    !> node numbers, 0-based
    integer(c_int), intent(in) :: nodes(:)
    !> [length] shape (n_dim, size(nodes))
    real(c_double), intent(out) :: displacement(:, :)
    integer :: i

    displacement = ieee_value(1.0_rk, ieee_quiet_nan)
    if (.not. handle%has_answer) return
    associate (part => handle%model%online%model%parts(handle%answer%displacement_part)%reduced)
      if (.not. part%has_displacement()) return
    end associate
    do i = 1, size(nodes)
      if (has_node(handle, nodes(i))) call copy_displacement(handle, nodes(i), displacement(:, i))
    end do
  end subroutine fill_nodes
end module sig_c_api_many
