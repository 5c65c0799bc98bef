! SPDX-License-Identifier: BSD-3-Clause
!> The result of a validation: a table for the terminal, and two sentences that say whether the contact forces and the fields of the
!> model are good enough.
module sig_verdict
  use sig_accuracy_warnings, only: accuracy_advice, field_advice, motion_warning
  use sig_deck_config, only: validation_config_t
  use sig_history_errors, only: estimate_quality_t, near_ratios, quality_of_estimates
  use sig_kinds, only: rk
  use sig_statistics, only: measured_statistics, statistics_t
  use sig_text, only: counted, short_number, to_text
  use sig_validation, only: error_names, validation_t
  implicit none(type, external)
  private
  public :: judgment_t, verdict_t, counted_errors, estimate_sentence, judge_validation, validation_table

  character(1), parameter :: eol = new_line('a')
  !> errors of contact forces whose p95 is shown; that of the last one decides
  character(*), parameter :: force_errors(3) = [character(12) :: 'e_pressure', 'e_lambda_rid', 'e_lambda_all']
  !> errors of displacements and stresses that are shown; the p95 of the last two decide
  character(*), parameter :: field_errors(4) = [character(22) :: 'e_u', 'e_von_mises', 'e_u_energy_relative', 'e_von_mises_largest']

  !> Whether contact forces or fields are good enough.
  type :: judgment_t
    logical :: is_accepted = .false.
    !> in words, without a full stop; begins with `accepted`, `NOT accepted` or `not judged`
    character(:), allocatable :: sentence
  end type judgment_t

  !> Whether a validated model is good enough.
  type :: verdict_t
    !> p95 of e_lambda_all, where materials flow of the errors of whole histories, is at most validation.accept, some test point has
    !> a contact force or the deck no contact, and no body rotates or deforms too far
    type(judgment_t) :: forces
    !> p95 of e_u_energy_relative and of e_von_mises_largest, where materials flow those of the errors of whole histories in the
    !> same norm and of von Mises stresses anywhere, are at most validation.accept_fields
    type(judgment_t) :: fields
    !> where materials flow: p95 of the errors of plastic and creep strains are at most validation.accept_strains;
    !> elsewhere accepted
    type(judgment_t) :: strains
    !> forces are accepted, and fields and strains, too, if the model keeps the data for them
    logical :: is_accepted = .false.
    !> both sentences in one; begins with `accepted` or `NOT accepted`
    character(:), allocatable :: sentence
    !> number of points without an answer of the model but with a full-order solution, of points without a full-order solution, and
    !> of answers by the fallback
    integer :: n_unanswered = 0
    integer :: n_unsolved = 0
    integer :: n_fallbacks = 0
  end type verdict_t

contains

  !> Returns the verdict on a model: that on its contact forces (judge_forces) and that on its fields (judge_fields). The latter
  !> counts for a model that keeps the data for fields; for others its sentence says that it does not.
  pure function judge_validation(outcome, limits) result(verdict)
    type(validation_t), intent(in) :: outcome
    type(validation_config_t), intent(in) :: limits
    type(verdict_t) :: verdict
    character(:), allocatable :: of_strains

    verdict%n_unanswered = count(outcome%method == 0 .and. outcome%reason_full_order > 0)
    verdict%n_unsolved = count(outcome%reason_full_order <= 0)
    verdict%n_fallbacks = count(outcome%is_fallback)
    call judge_forces(outcome, limits%accepted_forces, verdict%forces)
    verdict%forces%sentence = verdict%forces%sentence // remarks(outcome, verdict)
    call judge_fields(outcome, limits%accepted_fields, verdict%fields)
    call judge_strains(outcome, limits%accepted_strains, verdict%strains)
    of_strains = ''
    if (outcome%n_times > 0) of_strains = '; strains ' // verdict%strains%sentence
    verdict%is_accepted = verdict%forces%is_accepted .and. ((verdict%fields%is_accepted .and. verdict%strains%is_accepted) .or. &
      .not. outcome%has_fields)
    if (verdict%is_accepted .or. .not. verdict%forces%is_accepted) then
      verdict%sentence = verdict%forces%sentence // '; fields ' // verdict%fields%sentence // of_strains
    else if (verdict%fields%is_accepted) then
      verdict%sentence = verdict%strains%sentence // '; forces ' // verdict%forces%sentence // '; fields ' // &
        verdict%fields%sentence
    else
      verdict%sentence = verdict%fields%sentence // '; forces ' // verdict%forces%sentence // of_strains
    end if
  end function judge_validation

  !> Judges the contact forces: they are accepted if p95 of e_lambda_all, as counted_errors counts it, or where materials flow of
  !> the errors of whole histories, is at most the limit, some
  !> full-order solution has a contact force or the deck has no contact, and none rotates or deforms a body too far for linear
  !> equations (motion_warning).
  !> Points without a full-order solution do not count; if no point counts, p95 is NaN and the forces are not accepted.
  pure subroutine judge_forces(outcome, limit, judgment)
    type(validation_t), intent(in) :: outcome
    !> [-] validation.accept
    real(rk), intent(in) :: limit
    type(judgment_t), intent(inout) :: judgment
    character(:), allocatable :: objection
    real(rk) :: p95

    p95 = p95_of('e_lambda_all', outcome)
    if (outcome%n_times > 0) p95 = p95_over(outcome%histories%forces)
    objection = motion_warning(outcome%rotation, outcome%deformation)
    if (outcome%has_contact .and. .not. any(outcome%n_active_full_order > 0 .and. outcome%reason_full_order > 0)) objection = &
      'no test point has a contact force, so those of the model were not tested; choose test points at which contacts close (test)'
    judgment%is_accepted = p95 <= limit .and. objection == ''
    judgment%sentence = 'p95 of ' // name_of('e_lambda_all', 'the largest error of forces in a history', outcome) // ' is ' // &
      short_number(p95) // ', the limit is ' // short_number(limit) // ' (validation.accept)'
    if (.not. outcome%has_contact) judgment%sentence = 'the deck has no contact, and so no contact forces'
    if (judgment%is_accepted) then
      judgment%sentence = 'accepted: ' // judgment%sentence
    else if (p95 <= limit) then
      judgment%sentence = 'NOT accepted: ' // objection
    else
      judgment%sentence = 'NOT accepted: ' // judgment%sentence // '; ' // accuracy_advice(outcome%model_kind)
    end if
  end subroutine judge_forces

  !> Judges the fields: they are accepted if p95 of e_u_energy_relative and of e_von_mises_largest, as counted_errors counts them,
  !> or where materials flow of the errors of whole histories, are at most the limit. They are not judged if the model has no fields
  !> and not the displacements of all nodes.
  pure subroutine judge_fields(outcome, limit, judgment)
    type(validation_t), intent(in) :: outcome
    !> [-] validation.accept_fields
    real(rk), intent(in) :: limit
    type(judgment_t), intent(inout) :: judgment
    real(rk) :: of_energy, of_stress

    judgment%sentence = 'the model does not have the displacements of all nodes'
    if (outcome%has_displacements) then
      of_energy = p95_of('e_u_energy_relative', outcome)
      of_stress = p95_of('e_von_mises_largest', outcome)
      if (outcome%n_times > 0) then
        of_energy = p95_over(outcome%histories%displacement)
        of_stress = p95_over(outcome%histories%stress)
      end if
      judgment%is_accepted = of_energy <= limit .and. of_stress <= limit
      judgment%sentence = 'p95 of ' // name_of('e_u_energy_relative', 'the largest error of displacements in a history', &
        outcome) // ' is ' // short_number(of_energy) // ' and of ' // name_of('e_von_mises_largest', 'von Mises stresses', &
        outcome) // ' ' // short_number(of_stress) // ', the limit is ' // short_number(limit) // ' (validation.accept_fields)'
    end if
    if (judgment%is_accepted) then
      judgment%sentence = 'accepted: ' // judgment%sentence
      return
    else if (.not. (outcome%has_displacements .or. outcome%has_fields)) then
      judgment%sentence = 'not judged: ' // judgment%sentence
      return
    end if
    judgment%sentence = 'NOT accepted: ' // judgment%sentence // '; ' // field_advice(outcome%model_kind)
    if (.not. outcome%has_fields) judgment%sentence = judgment%sentence // '; the verdict on the model does not count this, ' // &
      'because reduction.fields is false, but displacements that you ask for have this error'
  end subroutine judge_fields

  !> Judges plastic and creep strains: they are accepted if p95 of the errors of whole histories is at most the limit, of those that
  !> some material has. Where nothing flows they are accepted, without a sentence.
  pure subroutine judge_strains(outcome, limit, judgment)
    type(validation_t), intent(in) :: outcome
    !> [-] validation.accept_strains
    real(rk), intent(in) :: limit
    type(judgment_t), intent(inout) :: judgment
    real(rk) :: of_creep, of_plasticity

    judgment%is_accepted = outcome%n_times == 0
    judgment%sentence = ''
    if (judgment%is_accepted) return
    of_plasticity = p95_over(outcome%histories%plastic_strain)
    of_creep = p95_over(outcome%histories%creep_strain)
    ! NaN where no material has such strains
    associate (found => [of_plasticity, of_creep])
      judgment%is_accepted = any(found >= 0) .and. .not. any(found > limit)
    end associate
    if (of_plasticity >= 0) judgment%sentence = 'p95 of the largest error of plastic strains in a history is ' // &
      short_number(of_plasticity) // ', '
    if (of_creep >= 0) judgment%sentence = judgment%sentence // 'p95 of the largest error of creep strains in a history is ' // &
      short_number(of_creep) // ', '
    judgment%sentence = judgment%sentence // 'the limit is ' // short_number(limit) // ' (validation.accept_strains)'
    if (judgment%is_accepted) then
      judgment%sentence = 'accepted: ' // judgment%sentence
    else
      judgment%sentence = 'NOT accepted: ' // judgment%sentence // '; ' // field_advice(outcome%model_kind)
    end if
  end subroutine judge_strains

  !> Returns the first name, or the second one where materials flow.
  pure function name_of(name, over_history, outcome) result(text)
    character(*), intent(in) :: name
    character(*), intent(in) :: over_history
    type(validation_t), intent(in) :: outcome
    character(:), allocatable :: text

    text = name
    if (outcome%n_times > 0) text = over_history
  end function name_of

  !> [-] Returns p95 of values that are not NaN; NaN if there is none.
  pure real(rk) function p95_over(values)
    real(rk), intent(in) :: values(:)
    type(statistics_t) :: statistics

    statistics = measured_statistics(values)
    p95_over = statistics%p95
  end function p95_over

  !> Returns what the estimate of the model's error is worth, as a sentence without a full stop. Requires: materials flow.
  pure function estimate_sentence(outcome) result(text)
    type(validation_t), intent(in) :: outcome
    character(:), allocatable :: text
    type(estimate_quality_t) :: quality

    quality = quality_of_estimates(outcome%histories%estimate, outcome%histories%raw_forces)
    text = 'error_estimate stands for the error before the correction of the forces, and is an estimate, not a bound'
    if (quality%n_histories == 0) return
    text = text // ': over ' // counted(quality%n_histories, 'history') // ' it is ' // short_number(quality%median_ratio) // &
      ' times this error (median), ' // short_number(near_ratios(1)) // ' to ' // short_number(near_ratios(2)) // ' times at ' // &
      short_number(100 * quality%share_near) // ' % of them'
    if (quality%rank_correlation >= -1) text = text // ', with a rank correlation of ' // short_number(quality%rank_correlation)
  end function estimate_sentence

  !> Returns what else belongs to the verdict on forces, each part after a semicolon: the number of answers by the fallback if it
  !> answered more than half of all points, of points without a full-order solution, and of points without an answer.
  pure function remarks(outcome, verdict) result(text)
    type(validation_t), intent(in) :: outcome
    type(verdict_t), intent(in) :: verdict
    character(:), allocatable :: text

    text = ''
    if (2 * verdict%n_fallbacks > size(outcome%is_fallback)) text = '; the fallback, not the reduced part of the model, ' // &
      'answered ' // to_text(verdict%n_fallbacks) // ' of ' // counted(size(outcome%is_fallback), 'point')
    if (verdict%n_unsolved > 0) text = text // '; ' // counted(verdict%n_unsolved, 'point') // &
      ' without a full-order solution left out'
    if (verdict%n_unanswered > 0) text = text // '; ' // counted(verdict%n_unanswered, 'point') // &
      ' without an answer (an infinite error)'
  end function remarks

  !> [-] Returns p95 of an error as counted_errors counts it; NaN if no point counts.
  pure real(rk) function p95_of(name, outcome)
    !> one of error_names
    character(*), intent(in) :: name
    type(validation_t), intent(in) :: outcome
    type(statistics_t) :: statistics

    statistics = measured_statistics(counted_errors(outcome, name))
    p95_of = statistics%p95
  end function p95_of

  !> Returns the errors of the points with a full-order solution, in their order. Without an answer the error is huge(errors). So is
  !> an error that is NaN, except where that means no contact: the error of forces or of e_u becomes 0 if the full-order solution
  !> has no contact force anywhere, and for e_lambda_rid also if the full-order solution and the answer have none in the reduced
  !> integration domain.
  pure function counted_errors(outcome, name) result(errors)
    type(validation_t), intent(in) :: outcome
    !> one of error_names
    character(*), intent(in) :: name
    real(rk), allocatable :: errors(:)
    logical :: is_of_field, is_open
    integer :: i

    errors = outcome%errors(findloc(error_names == name, .true., dim=1), :)
    is_of_field = any(field_errors(2:) == name)
    do i = 1, size(errors)
      if (outcome%method(i) == 0) then
        errors(i) = huge(errors)
      else if (.not. errors(i) >= 0) then
        ! e_lambda_rid is NaN only without full-order forces in the domain
        is_open = outcome%n_active_full_order(i) == 0 .or. (name == 'e_lambda_rid' .and. outcome%n_active(i) == 0)
        errors(i) = merge(0.0_rk, huge(errors), is_open .and. .not. is_of_field)
      end if
    end do
    errors = pack(errors, outcome%reason_full_order > 0)
  end function counted_errors

  !> Returns a table without a line end at its end: median, p95 and maximum (by counted_errors) of the errors of forces, of the
  !> errors of fields, if the model has the displacements of all nodes, and of the bounds, where there are any; the number of points
  !> without a finite error_bound (if there are any), of points with a full-order solution but without an answer, and of points that
  !> the fallback answered. Where materials flow also the errors of whole histories.
  pure function validation_table(outcome, verdict) result(text)
    type(validation_t), intent(in) :: outcome
    type(verdict_t), intent(in) :: verdict
    character(:), allocatable :: text
    integer :: i

    text = repeat(' ', 24) // 'median        95 %          largest' // eol
    do i = 1, size(force_errors)
      text = text // row(trim(force_errors(i)), counted_errors(outcome, force_errors(i))) // eol
    end do
    do i = 1, merge(size(field_errors), 1, outcome%has_displacements)
      text = text // row(trim(field_errors(i)), counted_errors(outcome, field_errors(i))) // eol
    end do
    associate (bound => outcome%error_bound, has_bound => is_bound(outcome%error_bound))
      if (any(has_bound)) text = text // row('error_bound', pack(bound, has_bound)) // eol
    end associate
    associate (bound => outcome%displacement_bound, has_bound => is_bound(outcome%displacement_bound))
      if (any(has_bound)) text = text // row('displacement_bound', pack(bound, has_bound)) // eol
    end associate
    if (outcome%n_times > 0) text = text // history_rows(outcome)
    associate (n_without => count(.not. is_bound(outcome%error_bound)))
      if (n_without > 0 .and. outcome%n_times == 0) text = text // cell('no error_bound', 24) // to_text(n_without) // ' of ' // &
        counted(size(outcome%error_bound), 'point') // eol
    end associate
    text = text // cell('without an answer', 24) // to_text(verdict%n_unanswered) // ' of ' // &
      counted(size(outcome%method), 'point') // eol // cell('by the fallback', 24) // to_text(verdict%n_fallbacks)
  end function validation_table

  !> Returns the rows of errors of whole histories; each line ends with a line end.
  pure function history_rows(outcome) result(text)
    type(validation_t), intent(in) :: outcome
    character(:), allocatable :: text

    associate (histories => outcome%histories)
      text = 'over ' // counted(size(histories%forces), 'history') // &
        ': largest error over the largest value of a history' // eol // &
        row('  forces, not corrected', histories%raw_forces) // eol // row('  error_estimate', histories%estimate) // eol // &
        row('  forces', histories%forces) // eol
      if (outcome%has_displacements) text = text // row('  von Mises stress', histories%stress) // eol
      if (any(histories%plastic_strain >= 0)) text = text // row('  plastic strain', histories%plastic_strain) // eol
      if (any(histories%creep_strain >= 0)) text = text // row('  creep strain', histories%creep_strain) // eol
    end associate
  end function history_rows

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
