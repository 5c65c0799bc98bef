! SPDX-License-Identifier: BSD-3-Clause
!> Computes the active sets of the answers of new hyper-reduced models at the training points. Queries nearby start from them.
module sig_hhr_start_sets
  use sig_answer, only: answer_t
  use sig_bits, only: n_words, pack_bits
  use sig_kinds, only: rk
  use sig_model, only: complete_model, model_t
  use sig_online_model, only: online_model_t
  use sig_reduced, only: neighbors_t, reduced_t, room_t
  use sig_reduced_hhr, only: reduced_hhr_t
  use sig_term_values, only: term_values_t
  implicit none(type, external)
  private
  public :: fill_start_sets

contains

  !> Sets start_sets of each hyper-reduced cluster: the active set of its answer at each training point. The reduced problem is
  !> solved from the contacts that are closed in the full-order solution and, if this gives an answer, from no closed contacts, too.
  !> Of two solutions the one of smaller energy counts or, in a model without fallback, the first one. Queries nearby start from
  !> this set. At a point without a reduced answer the set is empty. A model that cannot answer gets no sets, without a message
  !> here: opening the model for queries gives the reason. The model is completed (complete_model).
  subroutine fill_start_sets(model)
    type(model_t), intent(inout) :: model
    type(online_model_t) :: online
    class(reduced_t), allocatable :: fallback
    integer :: k

    call complete_model(model)
    do k = 1, model%n_clusters()
      select type (part => model%parts(k)%reduced)
      type is (reduced_hhr_t)
        part%data%start_sets = part%data%start_sets(:, :0)
      end select
    end do
    k = model%fallback()
    ! the fallback is moved and not copied, because it can be larger than all the rest
    if (k > 0) call move_alloc(model%parts(k)%reduced, fallback)
    online%model = model
    if (k > 0) call move_alloc(fallback, online%model%parts(k)%reduced)
    call fill_from(online, model)
    if (k > 0) call move_alloc(online%model%parts(k)%reduced, model%parts(k)%reduced)
  end subroutine fill_start_sets

  !> Answers the training points with the model `online` and stores the active sets in `model`. If `online` cannot be prepared,
  !> `model` does not change.
  subroutine fill_from(online, model)
    !> the model without start sets
    type(online_model_t), target, intent(inout) :: online
    !> the model; its fallback has been moved away
    type(model_t), intent(inout) :: model
    type(term_values_t) :: terms
    character(:), allocatable :: message
    logical, allocatable :: is_closed(:, :)
    integer :: k

    call online%prepare(message)
    if (.not. allocated(message)) call terms%create(model%terms, message)
    if (allocated(message)) return
    call find_closed(model, is_closed)
    do k = 1, model%n_clusters()
      select type (part => online%model%parts(k)%reduced)
      type is (reduced_hhr_t)
        select type (filled => model%parts(k)%reduced)
        type is (reduced_hhr_t)
          call answer_points(part, terms, model%training_points, is_closed, online%model, filled%data%start_sets)
        end select
      end select
    end do
    call terms%destroy()
  end subroutine fill_from

  !> Computes the active sets of one cluster's answers at all training points; a set is empty where there is no answer.
  subroutine answer_points(part, terms, points, is_closed, model, sets)
    !> the part, after prepare; its start_sets are overwritten
    type(reduced_hhr_t), intent(inout) :: part
    type(term_values_t), intent(inout) :: terms
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> result of find_closed, shape (n_multipliers, n_points)
    logical, intent(in) :: is_closed(:, :)
    !> its fallback, if it has one, decides between two solutions by their energy
    type(model_t), intent(in) :: model
    !> active sets as bits (pack_bits), shape (n_words(n_rows), n_points)
    integer, allocatable, intent(out) :: sets(:, :)
    class(room_t), allocatable :: room
    type(answer_t) :: answer
    real(rk) :: theta(size(part%data%load, 2))
    integer :: i, i_source
    logical :: is_valid

    allocate (sets(n_words(part%data%n_rows), size(points, 2)), source=0)
    part%data%start_sets = reshape([integer ::], [size(sets, 1), 2], pad=[0])
    call part%create_room(room)
    do i = 1, size(points, 2)
      call terms%evaluate(points(:, i), theta, is_valid, i_source)
      call answer%start(1, size(theta), part%data%n_modes, part%data%n_rows, size(is_closed, 1))
      call pack_bits(is_closed(part%data%contact_rows, i), part%data%start_sets(:, 1))
      if (is_valid .and. model%has_fallback) then
        call part%solve(theta, neighbors_t(1, 2), room, answer, model%parts(model%fallback())%reduced)
      else if (is_valid) then
        call part%solve(theta, neighbors_t(1, 2), room, answer)
      end if
      call pack_bits(answer%is_active, sets(:, i))
    end do
  end subroutine answer_points

  !> Finds the contacts that are closed (force > 0) in the full-order solutions at the training points, from the clusters'
  !> snapshots. At a point whose snapshot no cluster has, all contacts count as open.
  subroutine find_closed(model, is_closed)
    type(model_t), intent(in) :: model
    !> shape (n_multipliers, n_points)
    logical, allocatable, intent(out) :: is_closed(:, :)
    integer :: i, k

    allocate (is_closed(model%n_multipliers, size(model%training_points, 2)), source=.false.)
    do k = 1, model%n_clusters()
      select type (part => model%parts(k)%reduced)
      type is (reduced_hhr_t)
        associate (cluster => part%data)
          do i = 1, min(size(cluster%training_points), size(cluster%dual_snapshots, 2))
            is_closed(:, cluster%training_points(i)) = cluster%dual_snapshots(:, i) > 0
          end do
        end associate
      end select
    end do
  end subroutine find_closed
end module sig_hhr_start_sets
