! SPDX-License-Identifier: BSD-3-Clause
!> The active sets of a new model's answers at its training points, from which queries nearby start.
module sig_start_sets
  use sig_bits, only: n_words, pack_bits
  use sig_model, only: complete_model, model_t
  use sig_online_model, only: online_model_t
  use sig_query, only: answer_t, query_t
  implicit none(type, external)
  private
  public :: fill_start_sets

contains

  !> Answers of each cluster at every training point, from the full-order contacts and from none: where the reduced problem has
  !> several solutions, queries nearby shall begin on the better one. A model that cannot answer gets no sets: its user will be
  !> told why.
  subroutine fill_start_sets(model)
    type(model_t), intent(inout) :: model
    type(online_model_t) :: online
    type(query_t) :: query
    type(answer_t) :: answer
    character(:), allocatable :: message
    logical, allocatable :: is_closed(:, :)
    integer, allocatable :: sets(:, :), starts(:, :)
    integer :: i, k

    call complete_model(model)
    do k = 1, size(model%clusters)
      model%clusters(k)%start_sets = model%clusters(k)%start_sets(:, :0)
    end do
    online%model = model
    call online%prepare(message)
    if (.not. allocated(message)) call query%create(online, message)
    if (allocated(message)) return
    call find_closed(model, is_closed)
    do k = 1, size(model%clusters)
      associate (cluster => model%clusters(k), points => model%training_points)
        allocate (sets(n_words(cluster%n_rows), size(points, 2)))
        allocate (starts(n_words(cluster%n_rows), 2), source=0)
        do i = 1, size(points, 2)
          call pack_bits(is_closed(cluster%contact_rows, i), starts(:, 1))
          call query%evaluate(online, points(:, i), answer, k, starts)
          call pack_bits(answer%is_active, sets(:, i))
        end do
        call move_alloc(sets, cluster%start_sets)
        deallocate (starts)
      end associate
    end do
    call query%destroy()
  end subroutine fill_start_sets

  !> Full-order contacts at the training points, those of the clusters' snapshots; open where no cluster has a snapshot.
  pure subroutine find_closed(model, is_closed)
    type(model_t), intent(in) :: model
    !> shape (n_multipliers, n_points)
    logical, allocatable, intent(out) :: is_closed(:, :)
    integer :: i, k

    allocate (is_closed(model%n_multipliers, size(model%training_points, 2)), source=.false.)
    do k = 1, size(model%clusters)
      associate (cluster => model%clusters(k))
        do i = 1, min(size(cluster%training_points), size(cluster%dual_snapshots, 2))
          is_closed(:, cluster%training_points(i)) = cluster%dual_snapshots(:, i) > 0
        end do
      end associate
    end do
  end subroutine find_closed
end module sig_start_sets
