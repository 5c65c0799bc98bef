! SPDX-License-Identifier: BSD-3-Clause
!> Checks whether the pivot transforms of a condensed model are accurate enough to be used.
module sig_reference_check
  use sig_answer, only: answer_t, comparable_size
  use sig_condensed_model, only: condensed_model_t
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_kinds, only: rk
  use sig_log, only: log_info
  use sig_problem, only: problem_t
  use sig_reduced, only: room_t
  use sig_reduced_kinds, only: fixed_of
  use sig_term_values, only: evaluate_points
  use sig_text, only: short_number
  use sig_training_set, only: training_set_t
  implicit none(type, external)
  private
  public :: drop_inaccurate_references

  !> [-] largest relative error of contact forces with which transforms are kept. A transform is computed from W without exchange of
  !> rows: where a part is much softer than the contacts, it loses all digits.
  real(rk), parameter :: accepted_error = 1.0e-7_rk

contains

  !> Removes the references and transforms, so that all queries solve the problem with W, if the answer at a training point differs
  !> from the full-order contact forces by more than accepted_error, or if a training point has no answer. Then it writes a note to
  !> the log. Local, with the same result on each rank. Requires: start_sets, and what choose_references sets.
  subroutine drop_inaccurate_references(problem, snapshots, model)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    !> its compliance is fixed
    type(condensed_model_t), target, intent(inout) :: model
    type(fixed_compliance_t), pointer :: fixed
    real(rk) :: error

    fixed => fixed_of(model)
    if (size(fixed%pivots%reference_points) == 0) return
    call fixed%prepare()
    error = largest_error(problem, snapshots, model)
    if (error <= accepted_error) return
    if (error < huge(error)) then
      call log_info('queries solve for all contacts: with the solutions of training points as references, the contact forces ' // &
        'would have relative errors of up to ' // short_number(error))
    else
      call log_info('queries solve for all contacts: with the solutions of training points as references, a training point ' // &
        'would have no answer')
    end if
    call fixed%pivots%clear()
  end subroutine drop_inaccurate_references

  !> Returns the largest relative error [-] of the contact forces at the training points; huge without an answer at one of them.
  real(rk) function largest_error(problem, snapshots, model) result(largest)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    !> its compliance is prepared
    type(condensed_model_t), intent(in) :: model
    class(room_t), allocatable :: room
    type(answer_t) :: answer
    real(rk), allocatable :: forces(:, :), theta(:, :)
    real(rk) :: sizes(snapshots%n_snapshots())
    integer :: i, i_bad_point, i_bad_source

    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    forces = snapshots%forces()
    sizes = norm2(forces, dim=1)
    call model%create_room(room)
    largest = 0
    do i = 1, size(sizes)
      call model%ask(theta(:, i), i, room, answer)
      if (answer%reason <= 0) then
        largest = huge(largest)
        return
      end if
      largest = max(largest, norm2(answer%multipliers - forces(:, i)) / max(comparable_size(sizes(i), maxval(sizes)), tiny(1.0_rk)))
    end do
  end function largest_error
end module sig_reference_check
