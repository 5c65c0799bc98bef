! SPDX-License-Identifier: BSD-3-Clause
!> Solved points on which models are measured, and from which snapshots are taken.
!>
!> The worst points of a set are no sample of it any more once they are taken: what a model is said to do is measured at points
!> that are kept for that, by lot.
module sig_candidate_pool
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_positive_inf, ieee_quiet_nan, ieee_value
  use sig_answer_errors, only: displacement_squares, forces_error, relative
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_online_model, only: online_model_t
  use sig_answer, only: answer_t
  use sig_query, only: query_t
  use sig_random_numbers, only: random_t
  use sig_reasons, only: reason_converged
  use sig_snapshot_store, only: point_index, snapshot_set_t
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: pool_errors_t, usable_candidates, draw_half, measure_candidates, finish_displacement_errors, errors_among
  public :: worst_candidates

  !> The errors of a model at all candidates.
  type :: pool_errors_t
    !> [-] infinite at candidates that failed; no number where nothing touches in either model, and at candidates that were not
    !> asked for; shape (n_candidates)
    real(rk), allocatable :: values(:)
    !> cluster that answered, 0 at candidates that were not asked for
    integer, allocatable :: cluster(:)
    !> [length^2] displacement_squares of this rank's dofs where the error is e_u, else 0; shape (2, n_candidates)
    real(rk), allocatable :: squares(:, :)
  end type pool_errors_t

contains

  !> Returns which candidates have a solution with a displacement that is not zero, and are no training points.
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

  !> Draws half of the candidates at random; one more than the rest if their number is odd.
  function draw_half(is_usable, seed) result(is_drawn)
    logical, intent(in) :: is_usable(:)
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

  !> Errors of a model's clusters at some of the candidates. Local; where the error is e_u, of which a rank has its part, they are
  !> to be finished.
  !>
  !> Errors: message is allocated where the model cannot answer at all.
  subroutine measure_candidates(candidates, is_wanted, model, name, errors, message)
    type(snapshot_set_t), intent(in) :: candidates
    !> shape (n_candidates)
    logical, intent(in) :: is_wanted(:)
    type(model_t), intent(in) :: model
    !> of the error, as in validation.csv
    character(*), intent(in) :: name
    type(pool_errors_t), intent(out) :: errors
    character(:), allocatable, intent(out) :: message
    type(online_model_t) :: online
    type(query_t) :: query
    type(answer_t) :: answer
    integer :: i

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
          errors%values(i) = measurable(forces_error(name, online, answer, multipliers), multipliers)
        end associate
      end if
    end do
    call query%destroy()
  end subroutine measure_candidates

  !> Computes e_u from the squares, which must be summed over all dofs. Local.
  pure subroutine finish_displacement_errors(candidates, errors)
    type(snapshot_set_t), intent(in) :: candidates
    type(pool_errors_t), intent(inout) :: errors
    integer :: i

    do i = 1, size(errors%values)
      if (.not. abs(errors%values(i)) <= 0) cycle
      associate (lengths => sqrt(errors%squares(:, i)))
        errors%values(i) = measurable(relative(lengths(1), lengths(2)), candidates%multipliers(:, i))
      end associate
    end do
  end subroutine finish_displacement_errors

  !> [-] The error; infinite if it is not a number although there is contact, so that it never looks too small.
  pure real(rk) function measurable(error, multipliers)
    real(rk), intent(in) :: error
    !> full-order
    real(rk), intent(in) :: multipliers(:)

    measurable = error
    if (ieee_is_nan(error) .and. any(multipliers > 0)) measurable = ieee_value(error, ieee_positive_inf)
  end function measurable

  !> Returns the errors as if only these candidates had been measured.
  pure function errors_among(errors, is_chosen) result(chosen)
    type(pool_errors_t), intent(in) :: errors
    logical, intent(in) :: is_chosen(:)
    type(pool_errors_t) :: chosen

    chosen%values = merge(errors%values, ieee_value(1.0_rk, ieee_quiet_nan), is_chosen)
    chosen%cluster = merge(errors%cluster, 0, is_chosen)
  end function errors_among

  !> The candidates of a cluster with the largest errors, the worst one first; the lowest number of those that are equal to 1e-8.
  pure function worst_candidates(errors, i_cluster, n_wanted) result(numbers)
    type(pool_errors_t), intent(in) :: errors
    integer, intent(in) :: i_cluster
    integer, intent(in) :: n_wanted
    !> at most n_wanted; none without an error
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
