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

  !> Answers of each cluster at every training point from a cold start. A model that cannot answer gets no sets: its user will be
  !> told why.
  subroutine fill_start_sets(model)
    type(model_t), intent(inout) :: model
    type(online_model_t) :: online
    type(query_t) :: query
    type(answer_t) :: answer
    character(:), allocatable :: message
    integer, allocatable :: sets(:, :)
    integer :: i, k

    call complete_model(model)
    do k = 1, size(model%clusters)
      model%clusters(k)%start_sets = model%clusters(k)%start_sets(:, :0)
    end do
    online%model = model
    call online%prepare(message)
    if (.not. allocated(message)) call query%create(online, message)
    if (allocated(message)) return
    do k = 1, size(model%clusters)
      associate (cluster => model%clusters(k), points => model%training_points)
        allocate (sets(n_words(cluster%n_rows), size(points, 2)))
        do i = 1, size(points, 2)
          call query%evaluate(online, points(:, i), answer, k)
          call pack_bits(answer%is_active, sets(:, i))
        end do
        call move_alloc(sets, cluster%start_sets)
      end associate
    end do
    call query%destroy()
  end subroutine fill_start_sets
end module sig_start_sets
