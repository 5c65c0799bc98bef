! SPDX-License-Identifier: BSD-3-Clause
!> Writes what a validation found: validation.csv, sections of the report, and statistics in the model.
module sig_validation_output
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use sig_accuracy_warnings, only: error_warnings, motion_warning
  use sig_deck_config, only: deck_config_t
  use sig_errors, only: error_t
  use sig_file_system, only: write_text_file
  use sig_history_errors, only: estimate_quality_t, quality_of_estimates
  use sig_kinds, only: rk
  use sig_log, only: log_warnings
  use sig_model, only: model_t
  use sig_parameter_space, only: format_point
  use sig_answer, only: bound_text, method_name, n_answer_methods
  use sig_reasons, only: reason_converged
  use sig_reporting, only: report_statistics
  use sig_run_report, only: run_report_t
  use sig_statistics, only: measured_statistics, statistics_t
  use sig_text, only: append_text, counted, csv_number, join, string_t, to_text
  use sig_text_buffer, only: text_buffer_t
  use sig_validation, only: error_names, n_errors, n_usual_errors, validation_t
  use sig_verdict, only: counted_errors, verdict_t
  implicit none(type, external)
  private
  public :: write_validation_table, report_validation, warn_of_errors, keep_statistics

  !> number of points with the largest errors that the report names
  integer, parameter :: n_worst = 5

contains

  !> Writes validation.csv to the path: a head, and one line per test point. Local. Errors: the file cannot be written.
  subroutine write_validation_table(deck, outcome, path, error)
    type(deck_config_t), intent(in) :: deck
    type(validation_t), intent(in) :: outcome
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(text_buffer_t) :: buffer
    integer :: i, i_error

    do i = 1, size(deck%state_parameters)
      call buffer%add(deck%state_parameters(i)%name // ',')
    end do
    call buffer%add('cluster')
    do i_error = 1, n_shown(outcome)
      call buffer%add(',' // trim(error_names(i_error)))
    end do
    call buffer%add(',n_active,n_active_full_order,solver,n_solutions,error_bound,displacement_bound')
    if (has_estimates(outcome)) call buffer%add(',error_estimate')
    call buffer%add(',full_order' // new_line('a'))
    do i = 1, size(outcome%points, 2)
      call buffer%add(table_row(outcome, i) // new_line('a'))
    end do
    call write_text_file(path, buffer%text(), error)
  end subroutine write_validation_table

  function table_row(outcome, i) result(row)
    type(validation_t), intent(in) :: outcome
    integer, intent(in) :: i
    character(:), allocatable :: row
    integer :: k

    row = join(outcome%points(:, i), ',') // ',' // to_text(outcome%cluster(i))
    do k = 1, n_shown(outcome)
      row = row // ',' // csv_number(outcome%errors(k, i))
    end do
    row = row // ',' // to_text(outcome%n_active(i)) // ',' // to_text(outcome%n_active_full_order(i)) // ',' // &
      method_name(outcome%method(i)) // ',' // to_text(outcome%n_solutions(i)) // ',' // &
      bound_text(outcome%error_bound(i)) // ',' // bound_text(outcome%displacement_bound(i)) // ','
    if (has_estimates(outcome)) row = row // bound_text(outcome%error_estimate(i)) // ','
    row = row // status(outcome%reason_full_order(i))
  end function table_row

  !> Returns how many of error_names the model has.
  pure integer function n_shown(outcome)
    type(validation_t), intent(in) :: outcome

    n_shown = merge(n_errors, n_usual_errors, outcome%n_times > 0)
  end function n_shown

  pure logical function has_estimates(outcome)
    type(validation_t), intent(in) :: outcome

    has_estimates = any(outcome%error_estimate >= 0)
  end function has_estimates

  pure function status(reason) result(text)
    integer, intent(in) :: reason
    character(:), allocatable :: text

    text = 'not_converged'
    if (reason == reason_converged) text = 'converged'
  end function status

  !> Adds to the report: the number of points; minimum, median, p95 and maximum of each error (report_statistics, so not as the
  !> verdict counts them) and of the bounds; the points with the largest e_lambda_rid, and how often it is infinite or no number;
  !> the numbers of answers by each method, with several solutions, and by the fallback; verdict, warnings, times and, after a
  !> benchmark, the speed-up.
  subroutine report_validation(deck, solver_type, outcome, verdict, report)
    type(deck_config_t), intent(in) :: deck
    !> type of the solver that solved the full-order points
    character(*), intent(in) :: solver_type
    type(validation_t), intent(in) :: outcome
    type(verdict_t), intent(in) :: verdict
    type(run_report_t), intent(inout) :: report
    type(string_t), allocatable :: names(:)
    integer, allocatable :: counts(:)
    integer :: i_error, i_method

    call report%add('errors/n_points', size(outcome%points, 2))
    do i_error = 1, n_shown(outcome)
      call report_statistics(report, 'errors/' // trim(error_names(i_error)), outcome%errors(i_error, :))
    end do
    call report_bounds('error_bound', outcome%error_bound, report)
    call report_bounds('displacement_bound', outcome%displacement_bound, report)
    if (outcome%n_times > 0) call report_histories(outcome, report)
    call report%add('errors/warnings', validation_warnings(outcome))
    call report%add('errors/e_lambda_rid/largest_at', worst_points(deck, outcome, 2))
    call count_methods(outcome, names, counts)
    do i_method = 1, size(names)
      call report%add('answers/' // names(i_method)%text, counts(i_method))
    end do
    call report%add('answers/several_solutions', count(outcome%n_solutions > 1))
    call report%add('answers/by_fallback', verdict%n_fallbacks)
    call report%add('validation/accepted', verdict%is_accepted)
    call report%add('validation/verdict', verdict%sentence)
    call report%add('validation/forces', verdict%forces%sentence)
    call report%add('validation/fields', verdict%fields%sentence)
    if (outcome%n_times > 0) call report%add('validation/strains', verdict%strains%sentence)
    call report%add('errors/e_lambda_rid/no_contact', count(is_no_number(outcome%errors(2, :)) .and. &
      outcome%reason_full_order == reason_converged))
    call report%add('errors/e_lambda_rid/infinite', count(outcome%errors(2, :) > huge(1.0_rk)))
    call report%add('times/full_order_setup', outcome%setup_seconds)
    call report%add('times/full_order_per_point', outcome%full_order_seconds)
    if (outcome%benchmark%is_done) call report_benchmark(solver_type, outcome, report)
  end subroutine report_validation

  !> Adds to the report the errors of whole histories, and how well the estimate tells the error of the forces before their
  !> correction, which it estimates.
  subroutine report_histories(outcome, report)
    type(validation_t), intent(in) :: outcome
    type(run_report_t), intent(inout) :: report
    type(estimate_quality_t) :: quality

    associate (histories => outcome%histories)
      call report%add('histories/n_histories', size(histories%forces))
      call report_statistics(report, 'histories/forces_not_corrected', histories%raw_forces)
      call report_statistics(report, 'histories/forces', histories%forces)
      call report_statistics(report, 'histories/error_estimate', histories%estimate)
      call report_statistics(report, 'histories/displacement', histories%displacement)
      call report_statistics(report, 'histories/von_mises', histories%stress)
      if (any(histories%plastic_strain >= 0)) call report_statistics(report, 'histories/plastic_strain', histories%plastic_strain)
      if (any(histories%creep_strain >= 0)) call report_statistics(report, 'histories/creep_strain', histories%creep_strain)
      quality = quality_of_estimates(histories%estimate, histories%raw_forces)
    end associate
    call report%add('histories/estimate_over_error/n_histories', quality%n_histories)
    call report%add('histories/estimate_over_error/median', quality%median_ratio)
    call report%add('histories/estimate_over_error/share_from_0.5_to_1.2', quality%share_near)
    call report%add('histories/estimate_over_error/rank_correlation', quality%rank_correlation)
  end subroutine report_histories

  !> Adds to the report minimum, median, p95 and maximum of the bounds that are known; nothing if none is.
  subroutine report_bounds(name, bounds, report)
    character(*), intent(in) :: name
    !> [-] negative where there is none, shape (n_points)
    real(rk), intent(in) :: bounds(:)
    type(run_report_t), intent(inout) :: report

    if (any(bounds >= 0)) call report_statistics(report, 'errors/' // name, pack(bounds, bounds >= 0))
  end subroutine report_bounds

  !> Logs the warnings of validation_warnings.
  subroutine warn_of_errors(outcome)
    type(validation_t), intent(in) :: outcome
    type(string_t), allocatable :: warnings(:)

    warnings = validation_warnings(outcome)
    call log_warnings(warnings)
  end subroutine warn_of_errors

  !> Returns the warnings of error_warnings (e_lambda_rid and e_lambda_all that are large or could not be measured, displacements
  !> that are not unique), and that of motion_warning.
  pure function validation_warnings(outcome) result(warnings)
    type(validation_t), intent(in) :: outcome
    type(string_t), allocatable :: warnings(:)
    character(:), allocatable :: of_motion

    warnings = error_warnings(outcome%model_kind, error_names, outcome%errors)
    of_motion = motion_warning(outcome%rotation, outcome%deformation)
    if (of_motion /= '') call append_text(warnings, of_motion)
  end function validation_warnings

  !> Adds the times [s] of a query and of a point by the refactoring active set method, and the speed-up of a query over two
  !> full-order solvers: the deck's solver, which is usually faster because it may solve many points at once, and this method,
  !> unless contacts have friction.
  !> Requires: the benchmark is done.
  subroutine report_benchmark(solver_type, outcome, report)
    !> type of the deck's solver, for the key
    character(*), intent(in) :: solver_type
    type(validation_t), intent(in) :: outcome
    type(run_report_t), intent(inout) :: report

    associate (benchmark => outcome%benchmark)
      call report%add('times/query', benchmark%query_seconds)
      call report%add('speed_up/over_' // solver_type, outcome%full_order_seconds / benchmark%query_seconds)
      if (.not. benchmark%refactored_seconds > 0) return
      call report%add('times/refactored_per_point', benchmark%refactored_seconds)
      call report%add('speed_up/over_refactored', benchmark%refactored_seconds / benchmark%query_seconds)
    end associate
  end subroutine report_benchmark

  !> Lists the names of all methods and the number of points that each answered; points without an answer come first, as `none`.
  pure subroutine count_methods(outcome, names, counts)
    type(validation_t), intent(in) :: outcome
    type(string_t), allocatable, intent(out) :: names(:)
    !> number of points of each name
    integer, allocatable, intent(out) :: counts(:)
    integer :: i

    allocate (names(n_answer_methods + 1), counts(n_answer_methods + 1))
    do i = 0, n_answer_methods
      names(i + 1)%text = method_name(i)
      counts(i + 1) = count(outcome%method == i)
    end do
  end subroutine count_methods

  !> Whether the value is NaN or negative.
  elemental logical function is_no_number(value)
    real(rk), intent(in) :: value

    is_no_number = .not. (value >= 0)
  end function is_no_number

  !> Returns up to 5 lines, each with a point, its error and its number of active pairs in the full-order solution; the largest
  !> error, also an infinite one, first. Points whose error is 0 or NaN are left out.
  function worst_points(deck, outcome, i_error) result(points)
    type(deck_config_t), intent(in) :: deck
    type(validation_t), intent(in) :: outcome
    !> position in error_names, 1-based
    integer, intent(in) :: i_error
    type(string_t), allocatable :: points(:)
    logical :: is_left(size(outcome%points, 2))
    integer :: i

    allocate (points(0))
    is_left = outcome%errors(i_error, :) > 0
    do while (size(points) < n_worst .and. any(is_left))
      i = maxloc(outcome%errors(i_error, :), 1, is_left)
      is_left(i) = .false.
      call append_text(points, format_point(deck%state_parameters, outcome%points(:, i)) // ': ' // &
        csv_number(outcome%errors(i_error, i)) // ', ' // counted(outcome%n_active_full_order(i), 'active pair'))
    end do
  end function worst_points

  !> Copies the verdict, the statistics of the errors (measured_statistics: without NaN values; those of contact as counted_errors)
  !> and the number of answers by each method into the model; replaces those of an earlier validation.
  subroutine keep_statistics(outcome, verdict, model)
    type(validation_t), intent(in) :: outcome
    type(verdict_t), intent(in) :: verdict
    type(model_t), intent(inout) :: model
    type(statistics_t) :: statistics(n_shown(outcome))
    real(rk), allocatable :: errors(:)
    integer :: i_error

    if (allocated(model%validation%names)) deallocate (model%validation%names)
    allocate (model%validation%names(n_shown(outcome)))
    do i_error = 1, n_shown(outcome)
      model%validation%names(i_error)%text = trim(error_names(i_error))
      statistics(i_error) = measured_statistics(outcome%errors(i_error, :))
      ! contact as in the table of the terminal: a point where nothing touches counts as 0
      if (error_names(i_error) (:8) == 'e_lambda' .or. error_names(i_error) == 'e_pressure') then
        errors = counted_errors(outcome, error_names(i_error))
        where (errors >= huge(errors)) errors = ieee_value(1.0_rk, ieee_positive_inf)
        statistics(i_error) = measured_statistics(errors)
      end if
    end do
    model%validation%verdict = verdict%sentence
    model%validation%minimum = statistics%minimum
    model%validation%median = statistics%median
    model%validation%p95 = statistics%p95
    model%validation%maximum = statistics%maximum
    call count_methods(outcome, model%validation%method_names, model%validation%method_counts)
  end subroutine keep_statistics
end module sig_validation_output
