! SPDX-License-Identifier: BSD-3-Clause
!> Which active sets of the training points get a principal pivot transform: medoids in the number of contacts that differ.
module sig_reference_sets
  use sig_bits, only: pack_columns, unpack_columns
  use sig_condensed_data, only: condensed_data_t
  use sig_condensed_plan, only: number_size
  use sig_errors, only: error_t
  use sig_k_medoids, only: find_medoids, k_medoids_options_t, medoids_t
  use sig_kinds, only: rk
  use sig_pivot_transform, only: transform_matrix
  implicit none(type, external)
  private
  public :: choose_references, group_sets, start_sets_of

  !> more gain little
  integer, parameter :: most_references = 32
  !> the dissimilarities of more sets would take long; of more points every n-th is a candidate
  integer, parameter :: most_candidates = 1000

contains

  !> z > 0 at the training points, as bits: closed pairs, but open anchors.
  pure function start_sets_of(multipliers, anchors) result(sets)
    !> [force] shape (n_multipliers, n_points)
    real(rk), intent(in) :: multipliers(:, :)
    !> 1-based among the multipliers
    integer, intent(in) :: anchors(:)
    !> shape (n_words(n_multipliers), n_points)
    integer, allocatable :: sets(:, :)
    logical :: is_active(size(multipliers, 1), size(multipliers, 2))

    is_active = multipliers > 0
    is_active(anchors, :) = .not. is_active(anchors, :)
    sets = pack_columns(is_active)
  end function start_sets_of

  !> Fills references and transforms. A reference whose transform does not exist is left out.
  !>
  !> Errors: those of the medoids.
  subroutine choose_references(max_size, data, error)
    !> [MB] that the transforms may take
    real(rk), intent(in) :: max_size
    !> its start sets are set
    class(condensed_data_t), intent(inout) :: data
    type(error_t), allocatable, intent(out) :: error
    logical, allocatable :: sets(:, :)
    integer, allocatable :: candidates(:)
    type(medoids_t) :: found
    integer :: i, n, n_references

    n = size(data%compliance, 1)
    sets = unpack_columns(data%start_sets, n)
    candidates = distinct_columns(data%start_sets)
    n_references = min(most_references, size(candidates), int(max_size / (number_size * real(n, rk)**2)))
    allocate (data%reference_points(0), data%reference_of_point(0))
    if (n_references < 1) return
    candidates = candidates([(1 + (i - 1) * (1 + (size(candidates) - 1) / most_candidates), &
      i=1, 1 + (size(candidates) - 1) / (1 + (size(candidates) - 1) / most_candidates))])
    n_references = min(n_references, size(candidates))
    call find_medoids(differences(sets(:, candidates)), n_references, k_medoids_options_t(n_starts=1), found, error)
    if (allocated(error)) return
    call transform_sets(candidates(found%medoids), sets, data)
    if (size(data%reference_points) > 0) data%reference_of_point = nearest_sets(sets, data%reference_points)
  end subroutine choose_references

  !> Groups of sets that differ little: each belongs to the nearest of some medoids.
  !>
  !> Errors: those of the medoids.
  subroutine group_sets(sets, n_groups, group_of_set, error)
    !> shape (n_contacts, n_sets)
    logical, intent(in) :: sets(:, :)
    !> fewer where there are not as many different sets
    integer, intent(in) :: n_groups
    !> 1-based, shape (n_sets)
    integer, allocatable, intent(out) :: group_of_set(:)
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: candidates(:)
    type(medoids_t) :: found

    candidates = distinct_columns(pack_columns(sets))
    call find_medoids(differences(sets(:, candidates)), min(n_groups, size(candidates)), k_medoids_options_t(n_starts=1), found, &
      error)
    if (.not. allocated(error)) group_of_set = nearest_sets(sets, candidates(found%medoids))
  end subroutine group_sets

  !> Numbers of the columns that equal none before them.
  pure function distinct_columns(columns) result(numbers)
    integer, intent(in) :: columns(:, :)
    integer, allocatable :: numbers(:)
    integer :: i, k

    numbers = [integer ::]
    do i = 1, size(columns, 2)
      do k = 1, size(numbers)
        if (all(columns(:, numbers(k)) == columns(:, i))) exit
      end do
      if (k > size(numbers)) numbers = [numbers, i]
    end do
  end function distinct_columns

  !> Contacts in which two sets differ.
  pure function differences(sets) result(counts)
    !> shape (n_contacts, n_sets)
    logical, intent(in) :: sets(:, :)
    real(rk) :: counts(size(sets, 2), size(sets, 2))
    integer :: i, k

    counts = 0
    do k = 1, size(sets, 2)
      do i = k + 1, size(sets, 2)
        counts(i, k) = count(sets(:, i) .neqv. sets(:, k))
        counts(k, i) = counts(i, k)
      end do
    end do
  end function differences

  subroutine transform_sets(points, sets, data)
    !> training points whose sets are wanted
    integer, intent(in) :: points(:)
    !> of all training points
    logical, intent(in) :: sets(:, :)
    class(condensed_data_t), intent(inout) :: data
    real(rk), allocatable :: transforms(:, :)
    integer :: i, n
    logical :: is_singular

    n = size(sets, 1)
    allocate (transforms(n, n * size(points)))
    do i = 1, size(points)
      associate (first => n * size(data%reference_points) + 1)
        call transform_matrix(data%compliance, sets(:, points(i)), transforms(:, first:first + n - 1), is_singular)
      end associate
      if (.not. is_singular) data%reference_points = [data%reference_points, points(i)]
    end do
    data%transforms = transforms(:, :n * size(data%reference_points))
  end subroutine transform_sets

  !> The reference whose set differs least from that of each point; the first of equals.
  pure function nearest_sets(sets, references) result(nearest)
    logical, intent(in) :: sets(:, :)
    !> points
    integer, intent(in) :: references(:)
    integer :: nearest(size(sets, 2))
    integer :: counts(size(references)), i, k

    do i = 1, size(sets, 2)
      counts = [(count(sets(:, i) .neqv. sets(:, references(k))), k=1, size(references))]
      nearest(i) = minloc(counts, dim=1)
    end do
  end function nearest_sets
end module sig_reference_sets
