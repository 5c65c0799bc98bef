! SPDX-License-Identifier: BSD-3-Clause
!> The candidates of clusters.target: points with full-order solutions, at which models are measured and from which new snapshots
!> are taken.
!>
!> If the worst candidates become snapshots, the others look better than an average point. So, if the deck adds snapshots
!> (clusters.refine), a random half of the candidates is kept for measuring, and none of these becomes a snapshot.
module sig_candidate_pool
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_positive_inf, ieee_quiet_nan, ieee_value
  use sig_answer_errors, only: all_forces, compare_forces, comparison_t, displacement_squares, negligible_share, rid_forces
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_online_model, only: online_model_t
  use sig_answer, only: answer_t
  use sig_query, only: query_t
  use sig_random_numbers, only: random_t
  use sig_reasons, only: reason_converged
  use sig_parameter_space, only: point_index
  use sig_snapshot_store, only: snapshot_set_t
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: pool_errors_t, usable_candidates, draw_half, measure_candidates, finish_displacement_errors, errors_among
  public :: worst_candidates

  !> The errors of a model at all candidates.
  type :: pool_errors_t
    !> [-] infinite where the cluster has no answer or the error cannot be measured (measurable); NaN at candidates that were not
    !> measured and, for errors of contact forces (not for e_u), where nothing touches in either model; shape (n_candidates)
    real(rk), allocatable :: values(:)
    !> cluster that the model chooses, 0 at candidates that were not measured; shape (n_candidates)
    integer, allocatable :: cluster(:)
    !> [length^2] if the error is e_u: results of displacement_squares for the dofs of this rank; else 0; shape (2, n_candidates)
    real(rk), allocatable :: squares(:, :)
  end type pool_errors_t

contains

  !> Returns which candidates may be used: they converged, their displacement is not zero, and they are no training points (equal
  !> except for rounding, point_index).
  pure function usable_candidates(candidates, lengths, training_points) result(is_usable)
    type(snapshot_set_t), intent(in) :: candidates
    !> [length] Euclidean norms of the displacements, shape (n_candidates)
    real(rk), intent(in) :: lengths(:)
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: training_points(:, :)
    !> shape (n_candidates)
    logical :: is_usable(size(candidates%reasons))
    integer :: i

    is_usable = candidates%reasons == reason_converged .and. lengths > 0
    do i = 1, size(is_usable)
      if (point_index(training_points, candidates%parameters(:, i), i - 1) > 0) is_usable(i) = .false.
    end do
  end function usable_candidates

  !> Draws half of the usable candidates at random, rounded up: 3 of 5.
  function draw_half(is_usable, seed) result(is_drawn)
    !> shape (n_candidates), as the result
    logical, intent(in) :: is_usable(:)
    !> of the random numbers; the same seed draws the same half
    integer, intent(in) :: seed
    logical :: is_drawn(size(is_usable))
    integer :: i, order(count(is_usable))
    integer, allocatable :: numbers(:)
    type(random_t) :: random

    random%state = seed
    call random%permutation(order)
    numbers = pack([(i, i=1, size(is_usable))], is_usable)
    is_drawn = .false.
    is_drawn(numbers(order(:(size(order) + 1) / 2))) = .true.
  end function draw_half

  !> Asks the model at the wanted candidates, and measures the error of the answer of the chosen cluster. The error is infinite
  !> where this cluster has no answer, also if the fallback has one. Local. For e_u this computes only the squares of this rank's
  !> dofs: the caller sums them over all ranks, then calls finish_displacement_errors.
  !>
  !> Errors: message is allocated if the model cannot answer at all.
  subroutine measure_candidates(candidates, is_wanted, model, name, errors, message)
    type(snapshot_set_t), intent(in) :: candidates
    !> which candidates are measured, shape (n_candidates)
    logical, intent(in) :: is_wanted(:)
    type(model_t), intent(in) :: model
    !> of the error: e_u, e_lambda_rid or e_lambda_all
    character(*), intent(in) :: name
    type(pool_errors_t), intent(out) :: errors
    character(:), allocatable, intent(out) :: message
    type(online_model_t) :: online
    type(query_t) :: query
    type(answer_t) :: answer
    type(comparison_t) :: comparison
    real(rk) :: negligible
    integer :: i

    negligible = negligible_share * largest_force(candidates)
    allocate (errors%values(size(is_wanted)), source=ieee_value(1.0_rk, ieee_quiet_nan))
    allocate (errors%cluster(size(is_wanted)), source=0)
    allocate (errors%squares(2, size(is_wanted)), source=0.0_rk)
    online%model = model
    call online%prepare(message)
    if (.not. allocated(message)) call query%create(online, message)
    if (allocated(message)) return
    do i = 1, size(is_wanted)
      if (.not. is_wanted(i)) cycle
      call query%evaluate(online, candidates%parameters(:, i), answer)
      errors%cluster(i) = answer%cluster
      ! the fallback's answer says nothing about the cluster
      errors%values(i) = ieee_value(1.0_rk, ieee_positive_inf)
      if (answer%reason < 0 .or. answer%part /= answer%cluster) cycle
      if (name == 'e_u') then
        errors%values(i) = 0
        errors%squares(:, i) = displacement_squares(online, answer, candidates%first_dof, candidates%displacement(:, i))
      else
        associate (multipliers => candidates%multipliers(:, i))
          comparison = compare_forces(merge(all_forces, rid_forces, name == 'e_lambda_all'), online, answer, multipliers)
          errors%values(i) = measurable(comparison%relative(negligible), multipliers)
        end associate
      end if
    end do
    call query%destroy()
  end subroutine measure_candidates

  !> [force] Returns the largest norm of the contact forces at a candidate that converged; 0 without such candidates.
  pure real(rk) function largest_force(candidates)
    type(snapshot_set_t), intent(in) :: candidates
    integer :: i

    largest_force = 0
    do i = 1, size(candidates%reasons)
      if (candidates%reasons(i) == reason_converged) largest_force = max(largest_force, norm2(candidates%multipliers(:, i)))
    end do
  end function largest_force

  !> Computes errors%values of e_u from errors%squares, which must be summed over all ranks before. Infinite values and those of
  !> candidates that were not measured stay as they are. Local.
  pure subroutine finish_displacement_errors(candidates, errors)
    type(snapshot_set_t), intent(in) :: candidates
    type(pool_errors_t), intent(inout) :: errors
    type(comparison_t) :: comparison
    real(rk) :: negligible
    integer :: i

    negligible = negligible_share * sqrt(maxval([0.0_rk, errors%squares(2, :)]))
    do i = 1, size(errors%values)
      if (.not. abs(errors%values(i)) <= 0) cycle
      comparison = comparison_t(sqrt(errors%squares(1, i)), sqrt(errors%squares(2, i)))
      errors%values(i) = measurable(comparison%relative(negligible), candidates%multipliers(:, i))
    end do
  end subroutine finish_displacement_errors

  !> [-] Returns the error, or infinity if it is NaN although the full-order solution has contact forces.
  pure real(rk) function measurable(error, multipliers)
    real(rk), intent(in) :: error
    !> [force] full-order contact forces, shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)

    measurable = error
    if (ieee_is_nan(error) .and. any(multipliers > 0)) measurable = ieee_value(error, ieee_positive_inf)
  end function measurable

  !> Returns the errors as if only the chosen candidates had been measured; squares are not allocated in the result.
  pure function errors_among(errors, is_chosen) result(chosen)
    type(pool_errors_t), intent(in) :: errors
    !> shape (n_candidates)
    logical, intent(in) :: is_chosen(:)
    type(pool_errors_t) :: chosen

    chosen%values = merge(errors%values, ieee_value(1.0_rk, ieee_quiet_nan), is_chosen)
    chosen%cluster = merge(errors%cluster, 0, is_chosen)
  end function errors_among

  !> Returns the numbers of the candidates with the largest errors among those for which the model chooses the cluster, the worst
  !> first. Of errors that are equal to 1e-8 relative the lowest number comes first.
  pure function worst_candidates(errors, i_cluster, n_wanted) result(numbers)
    type(pool_errors_t), intent(in) :: errors
    !> number of the cluster, 1-based
    integer, intent(in) :: i_cluster
    integer, intent(in) :: n_wanted
    !> 1-based; at most n_wanted, fewer if fewer candidates have an error above 0
    integer, allocatable :: numbers(:)
    logical :: is_open(size(errors%values))
    integer :: i

    is_open = errors%cluster == i_cluster .and. errors%values > 0
    numbers = [integer ::]
    do while (size(numbers) < n_wanted .and. any(is_open))
      i = findloc(is_open .and. errors%values >= (1 - tie_tolerance) * maxval(errors%values, mask=is_open), .true., dim=1)
      numbers = [numbers, i]
      is_open(i) = .false.
    end do
  end function worst_candidates
end module sig_candidate_pool
