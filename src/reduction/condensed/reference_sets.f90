! SPDX-License-Identifier: BSD-3-Clause
!> Chooses the active sets of training points that get a principal pivot transform: the medoids, where the dissimilarity of two sets
!> is the number of contacts in which they differ.
module sig_reference_sets
  use sig_bits, only: pack_columns, unpack_columns
  use sig_condensed_plan, only: most_references, number_size
  use sig_errors, only: error_t
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_k_medoids, only: find_medoids, k_medoids_options_t, medoids_t
  use sig_kinds, only: rk
  use sig_pivot_sets, only: transform_scale
  use sig_pivot_transform, only: transform_matrix
  use sig_progress, only: progress_t
  implicit none(type, external)
  private
  public :: choose_references, group_sets, start_sets_of

  !> usual number of steps of the active set method
  real(rk), parameter :: steps = 3
  !> most candidates; of more sets only every n-th is a candidate, because dissimilarities of all pairs would take long
  integer, parameter :: most_candidates = 1000

contains

  !> Returns as bits (pack_columns) which unknowns are positive at each point. The unknown of a contact row is its force. The
  !> unknown of an anchor is its opening, which counts as positive where the anchor has no force.
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

  !> Sets reference_points (at most 32 training points), reference_of_point and transforms of data%pivots, as many as pay. A
  !> reference whose transform does not exist is left out; where none exists, all three are empty. Where none pays, or max_size does
  !> not allow one transform, there are no references: the lists are empty, and transforms is not set.
  !>
  !> Errors: those of find_medoids; then the lists are empty.
  subroutine choose_references(max_size, data, error)
    !> [MB] largest memory for the transforms
    real(rk), intent(in) :: max_size
    !> start_sets and compliance must be set. reference_points gets numbers of training points, reference_of_point the position in
    !> reference_points of the nearest reference of each training point, transforms one matrix of the size of W per reference side
    !> by side
    type(fixed_compliance_t), intent(inout) :: data
    type(error_t), allocatable, intent(out) :: error
    logical, allocatable :: sets(:, :)
    integer, allocatable :: candidates(:), medoids(:)
    integer :: i, n, n_references

    n = size(data%compliance, 1)
    sets = unpack_columns(data%start_sets, n)
    candidates = distinct_columns(data%start_sets)
    ! the real numbers are compared first: a quotient may be larger than any integer
    n_references = int(min(real(min(most_references, size(candidates)), rk), max_size / (number_size * real(n, rk)**2)))
    allocate (data%pivots%reference_points(0), data%pivots%reference_of_point(0))
    if (n_references < 1) return
    candidates = candidates([(1 + (i - 1) * (1 + (size(candidates) - 1) / most_candidates), &
      i=1, 1 + (size(candidates) - 1) / (1 + (size(candidates) - 1) / most_candidates))])
    n_references = min(n_references, size(candidates))
    call find_references(n, size(data%free_opening, 2), sets(:, candidates), n_references, medoids, error)
    if (allocated(error) .or. size(medoids) == 0) return
    call transform_sets(candidates(medoids), sets, data)
    if (size(data%pivots%reference_points) > 0) data%pivots%reference_of_point = nearest_sets(sets, data%pivots%reference_points)
  end subroutine choose_references

  !> Finds the references: medoids of the candidates, the smallest number that makes queries nearly as fast as any number up to the
  !> largest; none where even that gains little over W itself. A query for a few closed contacts of many has no use for a transform.
  !>
  !> Errors: those of find_medoids.
  subroutine find_references(n_rows, n_terms, sets, largest_number, medoids, error)
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_terms
    !> active sets of the candidates, shape (n_rows, n_candidates)
    logical, intent(in) :: sets(:, :)
    !> at most n_candidates
    integer, intent(in) :: largest_number
    !> numbers of candidates
    integer, allocatable, intent(out) :: medoids(:)
    type(error_t), allocatable, intent(out) :: error
    !> [-] operations that count as nearly as few, and as a gain
    real(rk), parameter :: nearly = 1.1_rk, gain = 0.8_rk
    real(rk) :: distances(size(sets, 2), size(sets, 2)), to_neighbor(size(sets, 2)), fewest
    type(medoids_t) :: found
    integer :: i, n

    distances = differences(sets)
    to_neighbor = [(minval(distances(:, i), mask=[(n /= i, n=1, size(sets, 2))]), i=1, size(sets, 2))]
    if (size(sets, 2) == 1) to_neighbor = 0
    allocate (medoids(0))
    fewest = gain * sum(operations_with_all(n_rows, real(count(sets, dim=1), rk)))
    n = 1
    do
      call find_medoids(distances, n, k_medoids_options_t(n_starts=1), found, error)
      if (allocated(error)) return
      associate (changes => max(to_neighbor, minval(distances(:, found%medoids), dim=2)))
        associate (operations => sum(operations_with_transform(n_rows, n_terms, real(count(sets, dim=1), rk), changes)))
          if (operations < fewest / merge(1.0_rk, nearly, size(medoids) == 0)) then
            medoids = found%medoids
            fewest = operations
          end if
        end associate
      end associate
      if (n == largest_number) exit
      n = min(2 * n, largest_number)
    end do
  end subroutine find_references

  !> Returns the operations of a query that factors W of the closed contacts in each step.
  elemental real(rk) function operations_with_all(n_rows, n_closed) result(operations)
    integer, intent(in) :: n_rows
    real(rk), intent(in) :: n_closed

    operations = steps * (n_closed**3 / 3 + 2 * n_rows * n_closed) + 2 * n_rows * n_closed
  end function operations_with_all

  !> Returns the operations of a query that changes some contacts of a reference in each step, and computes all openings from the
  !> closed ones in the end.
  elemental real(rk) function operations_with_transform(n_rows, n_terms, n_closed, n_changes) result(operations)
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_terms
    real(rk), intent(in) :: n_closed
    real(rk), intent(in) :: n_changes

    operations = steps * (2 * n_changes**3 / 3 + 2 * n_rows * n_changes) + 2 * n_rows * (n_terms + n_closed)
  end function operations_with_transform

  !> Divides sets into groups whose sets differ little. Each set belongs to the medoid from which it differs in the fewest contacts;
  !> of equally near medoids to the first.
  !>
  !> Errors: those of find_medoids.
  subroutine group_sets(sets, n_groups, group_of_set, error)
    !> true: closed, shape (n_contacts, n_sets)
    logical, intent(in) :: sets(:, :)
    !> number of groups; there are fewer where there are fewer different sets
    integer, intent(in) :: n_groups
    !> group of each set, 1-based, shape (n_sets)
    integer, allocatable, intent(out) :: group_of_set(:)
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: candidates(:)
    type(medoids_t) :: found

    candidates = distinct_columns(pack_columns(sets))
    call find_medoids(differences(sets(:, candidates)), min(n_groups, size(candidates)), k_medoids_options_t(n_starts=1), found, &
      error)
    if (allocated(error)) return
    group_of_set = nearest_sets(sets, candidates(found%medoids))
  end subroutine group_sets

  !> Returns the numbers, ascending, of the columns that differ from all columns before them.
  pure function distinct_columns(columns) result(numbers)
    !> sets as bits, shape (n_words, n_sets)
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

  !> Returns for each pair of sets the number of contacts in which they differ, shape (n_sets, n_sets).
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

  !> Sets data%pivots%transforms to the pivot transforms for the sets of some training points, and appends these points to
  !> data%pivots%reference_points, except where the transform does not exist. Requires: data%pivots%reference_points is empty.
  subroutine transform_sets(points, sets, data)
    !> numbers of the training points
    integer, intent(in) :: points(:)
    !> sets of all training points, shape (n_contacts, n_points)
    logical, intent(in) :: sets(:, :)
    type(fixed_compliance_t), intent(inout) :: data
    !> [s] progress is told only if the transforms take longer
    real(rk), parameter :: seconds_of_silence = 3
    type(progress_t) :: progress
    real(rk), allocatable :: scaled(:, :), transforms(:, :)
    integer :: i, n
    logical :: is_singular

    n = size(sets, 1)
    scaled = data%compliance / transform_scale(data%compliance)
    allocate (transforms(n, n * size(points)))
    call progress%start('pivot transforms', size(points), seconds_of_silence)
    do i = 1, size(points)
      associate (first => n * size(data%pivots%reference_points) + 1)
        call transform_matrix(scaled, sets(:, points(i)), transforms(:, first:first + n - 1), is_singular)
      end associate
      if (.not. is_singular) data%pivots%reference_points = [data%pivots%reference_points, points(i)]
      call progress%advance(i)
    end do
    call progress%finish()
    data%pivots%transforms = transforms(:, :n * size(data%pivots%reference_points))
  end subroutine transform_sets

  !> Returns for each point the position in `references` of the point whose set differs in the fewest contacts; of equal ones the
  !> first.
  pure function nearest_sets(sets, references) result(nearest)
    !> shape (n_contacts, n_points)
    logical, intent(in) :: sets(:, :)
    !> numbers of the points that are references
    integer, intent(in) :: references(:)
    integer :: nearest(size(sets, 2))
    integer :: counts(size(references)), i, k

    do i = 1, size(sets, 2)
      counts = [(count(sets(:, i) .neqv. sets(:, references(k))), k=1, size(references))]
      nearest(i) = minloc(counts, dim=1)
    end do
  end function nearest_sets
end module sig_reference_sets
