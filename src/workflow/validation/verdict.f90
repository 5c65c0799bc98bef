! SPDX-License-Identifier: BSD-3-Clause
!> The result of a validation: a table for the terminal, and one sentence that says whether the model is good enough.
module sig_verdict
  use sig_accuracy_warnings, only: accuracy_advice, motion_warning
  use sig_kinds, only: rk
  use sig_statistics, only: measured_statistics, statistics_t
  use sig_text, only: counted, short_number, to_text
  use sig_validation, only: error_names, validation_t
  implicit none(type, external)
  private
  public :: verdict_t, counted_errors, judge_validation, validation_table

  character(1), parameter :: eol = new_line('a')
  !> rows of the table: e_u, e_lambda_rid, e_lambda_all
  integer, parameter :: n_shown = 3
  !> the row whose p95 decides: e_lambda_all
  integer, parameter :: i_decisive = 3
  !> e_lambda_rid
  integer, parameter :: i_rid = 2

  !> Whether a validated model is good enough.
  type :: verdict_t
    !> p95 is at most validation.accept, some test point has a contact force, and no body rotates or deforms too far
    logical :: is_accepted = .false.
    !> number of points without an answer of the model but with a full-order solution, of points without a full-order solution, and
    !> of answers by the fallback
    integer :: n_unanswered = 0
    integer :: n_unsolved = 0
    integer :: n_fallbacks = 0
    !> [-] p95 of e_lambda_all; a point without an answer counts with a huge error
    real(rk) :: p95 = 0
    !> verdict in words, without a full stop
    character(:), allocatable :: sentence
  end type verdict_t

contains

  !> Returns the verdict: the model is accepted if p95 of e_lambda_all, as counted_errors counts it, is at most the deck's limit,
  !> some full-order solution has a contact force, and none rotates or deforms a body too far for linear equations
  !> (motion_warning). Points without a full-order solution do not count; if no point counts, p95 is NaN and
  !> the model is not accepted. The sentence names the number of answers by the fallback if it answered more than half of all
  !> points.
  pure function judge_validation(outcome, limit) result(verdict)
    type(validation_t), intent(in) :: outcome
    !> [-] validation.accept
    real(rk), intent(in) :: limit
    type(verdict_t) :: verdict
    type(statistics_t) :: statistics
    character(:), allocatable :: objection

    verdict%n_unanswered = count(outcome%method == 0 .and. outcome%reason_full_order > 0)
    verdict%n_unsolved = count(outcome%reason_full_order <= 0)
    verdict%n_fallbacks = count(outcome%is_fallback)
    statistics = measured_statistics(counted_errors(outcome, i_decisive))
    verdict%p95 = statistics%p95
    objection = motion_warning(outcome%rotation, outcome%deformation)
    if (.not. any(outcome%n_active_full_order > 0 .and. outcome%reason_full_order > 0)) objection = 'no test point has a ' // &
      'contact force, so those of the model were not tested; choose test points at which contacts close (test)'
    verdict%is_accepted = verdict%p95 <= limit .and. objection == ''
    verdict%sentence = 'p95 of ' // trim(error_names(i_decisive)) // ' is ' // short_number(verdict%p95)
    if (verdict%is_accepted) then
      verdict%sentence = 'accepted: ' // verdict%sentence // ', the limit is ' // short_number(limit) // ' (validation.accept)'
    else if (verdict%p95 <= limit) then
      verdict%sentence = 'NOT accepted: ' // objection
    else
      verdict%sentence = 'NOT accepted: ' // verdict%sentence // ', the limit is ' // short_number(limit) // &
        ' (validation.accept); ' // accuracy_advice(outcome%model_kind)
    end if
    if (2 * verdict%n_fallbacks > size(outcome%is_fallback)) verdict%sentence = verdict%sentence // &
      '; the fallback, not the reduced part of the model, answered ' // to_text(verdict%n_fallbacks) // ' of ' // &
      counted(size(outcome%is_fallback), 'point')
    if (verdict%n_unsolved > 0) verdict%sentence = verdict%sentence // '; ' // counted(verdict%n_unsolved, 'point') // &
      ' without a full-order solution left out'
    if (verdict%n_unanswered > 0) verdict%sentence = verdict%sentence // '; ' // counted(verdict%n_unanswered, 'point') // &
      ' without an answer (an infinite error)'
  end function judge_validation

  !> Returns the errors of the points with a full-order solution, in their order. Without an answer the error is huge(errors). An
  !> error that is NaN becomes 0 if the full-order solution has no contact force anywhere, and for e_lambda_rid also if the
  !> full-order solution and the answer have none in the reduced integration domain; otherwise huge(errors).
  pure function counted_errors(outcome, i_error) result(errors)
    type(validation_t), intent(in) :: outcome
    !> position in error_names
    integer, intent(in) :: i_error
    real(rk), allocatable :: errors(:)
    logical :: is_open
    integer :: i

    errors = outcome%errors(i_error, :)
    do i = 1, size(errors)
      if (outcome%method(i) == 0) then
        errors(i) = huge(errors)
      else if (.not. errors(i) >= 0) then
        ! e_lambda_rid is NaN only without full-order forces in the domain
        is_open = outcome%n_active_full_order(i) == 0 .or. (i_error == i_rid .and. outcome%n_active(i) == 0)
        errors(i) = merge(0.0_rk, huge(errors), is_open)
      end if
    end do
    errors = pack(errors, outcome%reason_full_order > 0)
  end function counted_errors

  !> Returns a table without a line end at its end: median, p95 and maximum of e_u, e_lambda_rid and e_lambda_all (by
  !> counted_errors) and of the bounds, where there are any; the number of points without a finite error_bound (if there are any),
  !> of points with a full-order solution but without an answer, and of points that the fallback answered.
  pure function validation_table(outcome, verdict) result(text)
    type(validation_t), intent(in) :: outcome
    type(verdict_t), intent(in) :: verdict
    character(:), allocatable :: text
    integer :: i

    text = repeat(' ', 24) // 'median        95 %          largest' // eol
    do i = 1, n_shown
      text = text // row(trim(error_names(i)), counted_errors(outcome, i)) // eol
    end do
    associate (bound => outcome%error_bound, has_bound => is_bound(outcome%error_bound))
      if (any(has_bound)) text = text // row('error_bound', pack(bound, has_bound)) // eol
    end associate
    associate (bound => outcome%displacement_bound, has_bound => is_bound(outcome%displacement_bound))
      if (any(has_bound)) text = text // row('displacement_bound', pack(bound, has_bound)) // eol
    end associate
    associate (n_without => count(.not. is_bound(outcome%error_bound)))
      if (n_without > 0) text = text // cell('no error_bound', 24) // to_text(n_without) // ' of ' // &
        counted(size(outcome%error_bound), 'point') // eol
    end associate
    text = text // cell('without an answer', 24) // to_text(verdict%n_unanswered) // ' of ' // &
      counted(size(outcome%method), 'point') // eol // cell('by the fallback', 24) // to_text(verdict%n_fallbacks)
  end function validation_table

  !> Whether a bound says something: it is not no_bound, and the error cannot be of any size (huge).
  elemental logical function is_bound(bound)
    real(rk), intent(in) :: bound

    is_bound = bound >= 0 .and. bound < huge(bound)
  end function is_bound

  pure function row(name, values) result(text)
    character(*), intent(in) :: name
    !> [-] NaN values are left out
    real(rk), intent(in) :: values(:)
    character(:), allocatable :: text
    type(statistics_t) :: statistics

    statistics = measured_statistics(values)
    text = cell(name, 24) // cell(shown(statistics%median), 14) // cell(shown(statistics%p95), 14) // shown(statistics%maximum)
  end function row

  !> Returns a number as text (short_number); `none` for NaN, huge(value) and infinity, as for points without an answer.
  pure function shown(value) result(text)
    real(rk), intent(in) :: value
    character(:), allocatable :: text

    text = 'none'
    if (value < huge(value)) text = short_number(value)
  end function shown

  pure function cell(word, width) result(text)
    character(*), intent(in) :: word
    integer, intent(in) :: width
    character(width) :: text

    text = word
  end function cell
end module sig_verdict
