! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The stages train, validate and fields of a study. Training reads the snapshots from the results folder. Validation reads the
!> model that training has written there, and so does the stage fields of the command run.
module sig_study
  use sig_deck_config, only: deck_config_t
  use sig_deck_echo, only: differing_setting
  use sig_enrichment_table, only: write_enrichment_table
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t, exit_not_converged, exit_stopped, make_error
  use sig_field_mapping, only: create_field_map
  use sig_field_query, only: why_no_fields
  use sig_field_output, only: solved_points_t, write_fields
  use sig_file_system, only: file_exists
  use sig_full_order, only: team_t
  use sig_greedy_record, only: training_points
  use sig_kinds, only: rk
  use sig_log, only: log_info, log_warning
  use sig_model, only: complete_model, model_t
  use sig_condensed_plan, only: needs_displacements
  use sig_model_building, only: build_model
  use sig_model_file, only: read_model, write_model
  use sig_parameter_space, only: build_states, format_point
  use sig_point_checks, only: check_points
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged, reason_text
  use sig_refinement, only: refinement_result_t
  use sig_refinement_rounds, only: report_refinement, write_refinement_table
  use sig_reporting, only: accuracy_text, model_text, report_model, report_selection, report_snapshots
  use sig_run_report, only: run_report_t
  use sig_sampling_stage, only: announce_stiffness, need_training
  use sig_selection, only: selection_t
  use sig_session, only: session_t
  use sig_snapshot_merge, only: lacks_displacements, read_spread, snapshot_store, snapshots_path, store_in, store_t
  use sig_share, only: share_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_stage_report, only: describe_problem, report_fields, warn_of_leans, warn_of_residuals, write_report
  use sig_stop_request, only: agree_to_stop
  use sig_study_plan, only: forget_training
  use sig_text, only: counted, to_text
  use sig_time_error, only: estimate_time_error, time_error_t
  use sig_clock, only: wall_time
  use sig_validation, only: validate, validation_t
  use sig_verdict, only: estimate_sentence, judge_validation, judgment_t, validation_table, verdict_t
  use sig_validation_output, only: keep_statistics, report_validation, warn_of_errors, write_validation_table
  use petsc
  implicit none(type, external)
  private
  public :: train_stage, validate_stage, fields_stage, stop_if_asked

  !> keys of the report about the training, the model, its errors and fields; a stage replaces those that it makes out of date
  integer, parameter :: key_length = 26
  character(*), parameter :: train_keys(4) = [character(key_length) :: 'sampling', 'iterations', 'residuals', 'refinement']
  character(*), parameter :: model_keys(1) = [character(key_length) :: 'reduction']
  character(*), parameter :: error_keys(8) = [character(key_length) :: 'errors', 'histories', 'answers', 'speed_up', &
    'times/query', 'times/full_order_setup', 'times/full_order_per_point', 'times/refactored_per_point']
  character(*), parameter :: field_keys(3) = [character(key_length) :: 'points', 'deformations', 'time_error']

contains

  !> Ends the session with session%stop if a signal came, unless the session has failed or was stopped already. What earlier stages
  !> wrote stays. Collective on all ranks.
  subroutine stop_if_asked(session, ierr)
    type(session_t), intent(inout) :: session
    PetscErrorCode, intent(out) :: ierr
    logical :: is_stopped

    PetscCall(agree_to_stop(PETSC_COMM_WORLD, is_stopped, ierr))
    if (.not. is_stopped .or. session%exit_code == exit_stopped .or. session%has_failed) return
    call session%stop('the finished stages are kept; run the same command again to go on')
  end subroutine stop_if_asked

  !> Trains the model: reads snapshots.h5; writes model.h5, enrichment.csv, refinement.csv (only after a refinement) and the report.
  !> Collective on all ranks.
  !>
  !> Errors are printed and set session%exit_code: the deck has no training; those of the loading of the problem, of read_snapshots,
  !> build_model and keep_fields; a file cannot be written. If only some training points have a solution, the model is made of
  !> these, and the exit code is that of "not converged". A signal before the training, during a refinement or while a forest is
  !> trained ends the stage without a new model.
  subroutine train_stage(session, report, ierr)
    type(session_t), intent(inout) :: session
    type(run_report_t), intent(inout) :: report
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t) :: snapshots
    type(selection_t) :: selection
    type(model_t) :: model
    type(refinement_result_t) :: refinement
    type(error_t), allocatable :: error
    real(rk) :: start

    ierr = 0
    work: block
      call need_training(session, error)
      if (allocated(error)) exit work
      PetscCall(session%load_study(error, ierr))
      if (allocated(error)) exit work
      PetscCall(read_snapshots(session, session%full_order%problem, snapshots, selection, error, ierr))
      if (allocated(error)) exit work
      PetscCall(stop_if_asked(session, ierr))
      if (session%exit_code == exit_stopped) exit work
      start = wall_time()
      PetscCall(build_model(session%full_order, session%folder, snapshots, model, refinement, error, ierr))
      if (allocated(error) .or. refinement%is_stopped) exit work
      PetscCall(describe_problem(session%full_order%problem, report, ierr))
      call report_training(session, snapshots, selection, model, refinement, report)
      call report%add('times/train', wall_time() - start)
      if (session%rank == 0) call write_training(session, refinement, model, error)
      PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
      if (allocated(error)) exit work
      PetscCall(write_report(session, [train_keys, model_keys, error_keys], report, ierr))
      call log_info('trained ' // model_text(model) // ': ' // model_path(session))
      if (any(snapshots%reasons /= reason_converged)) session%exit_code = exit_not_converged
    end block work
    call session%end_stage(error, refinement%is_stopped, 'no model was written')
  end subroutine train_stage

  !> Adds what training found to the report, and gives the warnings of the snapshots. Local.
  subroutine report_training(session, snapshots, selection, model, refinement, report)
    type(session_t), intent(inout) :: session
    type(snapshot_set_t), intent(in) :: snapshots
    type(selection_t), intent(in) :: selection
    type(model_t), intent(in) :: model
    type(refinement_result_t), intent(in) :: refinement
    type(run_report_t), intent(inout) :: report

    call report_snapshots(session%deck, snapshots, report)
    call warn_of_leans(session, snapshots%multipliers, snapshots%reasons, report)
    call warn_of_residuals(pack(snapshots%residuals(1, :), snapshots%reasons == reason_converged), report)
    if (session%deck%greedy%is_used) call report_selection(session%deck, selection, report)
    call report_model(model, report)
    if (size(refinement%rounds) > 0) call report_refinement(refinement%rounds, refinement%best_round, refinement%is_reached, &
      refinement%ending, report)
  end subroutine report_training

  !> Writes model.h5, with fields if the deck wants them, enrichment.csv and, after a refinement, refinement.csv. Local. Errors:
  !> those of keep_fields; a file cannot be written.
  subroutine write_training(session, refinement, model, error)
    type(session_t), intent(in) :: session
    type(refinement_result_t), intent(in) :: refinement
    type(model_t), intent(inout) :: model
    type(error_t), allocatable, intent(out) :: error

    if (session%deck%reduction%has_fields) call keep_fields(session%full_order%problem, model, error)
    if (allocated(error)) return
    call write_model(model_path(session), model, error)
    if (allocated(error)) return
    call write_enrichment_table(model, session%folder // '/enrichment.csv', error)
    if (allocated(error) .or. size(refinement%rounds) == 0) return
    call write_refinement_table(refinement%rounds, session%folder // '/refinement.csv', error)
  end subroutine write_training

  !> Adds the mesh and the stress maps for fields to the model, and warns if the model cannot answer fields all the same. Local.
  !> Errors: those of create_field_map.
  subroutine keep_fields(problem, model, error)
    type(problem_t), intent(in) :: problem
    type(model_t), intent(inout) :: model
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: reason

    call create_field_map(problem, model%fields, error)
    if (allocated(error)) return
    call complete_model(model)
    reason = why_no_fields(model)
    if (reason /= '') call log_warning('the deck has reduction.fields: true, but predict --fields will not answer: ' // reason)
  end subroutine keep_fields

  !> Reads the snapshots of the deck's training points and distributes their dofs over the ranks. Other points of the file are left
  !> out. With a greedy selection, the training points are those of its record, and `selection` says how it went; else `selection`
  !> keeps its defaults. Collective on all ranks.
  !>
  !> Errors: those of training_points; snapshots.h5 is missing, cannot be read, is of another deck or mesh, lacks points, or lacks
  !> displacements that the model needs.
  subroutine read_snapshots(session, problem, snapshots, selection, error, ierr)
    type(session_t), intent(in) :: session
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(out) :: snapshots
    type(selection_t), intent(out) :: selection
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: points(:, :)
    logical, allocatable :: is_missing(:)
    character(:), allocatable :: hint

    ierr = 0
    hint = 'run first: signorom sample ' // session%deck%path
    if (.not. file_exists(snapshots_path(session%folder))) then
      call make_error(error, 'there are no snapshots yet' // unmerged_text(store_in(session%folder, snapshot_store)), &
        snapshots_path(session%folder), hint=hint)
      return
    end if
    call training_points(problem, session%folder, points, selection, error)
    if (allocated(error)) return
    allocate (is_missing(size(points, 2)))
    PetscCall(read_spread(problem, store_in(session%folder, snapshot_store), points, snapshots, is_missing, error, ierr))
    if (allocated(error)) return
    if (needs_displacements(problem) .and. lacks_displacements(snapshots)) then
      call make_error(error, 'the snapshots hold contact forces only, and this deck''s model needs displacements', &
        snapshots_path(session%folder), hint=hint // ', which solves them again')
      return
    end if
    if (any(is_missing)) call make_error(error, 'the file lacks ' // to_text(count(is_missing)) // ' of the ' // &
      counted(size(is_missing), 'training point'), snapshots_path(session%folder), hint=hint)
  end subroutine read_snapshots

  !> Returns which shares have points that wait to be merged: `, only parts that are not merged, share 1/4, share 3/4`; empty if
  !> there are none.
  function unmerged_text(store) result(text)
    type(store_t), intent(in) :: store
    character(:), allocatable :: text
    type(share_t), allocatable :: shares(:)
    integer :: i

    text = ''
    shares = store%shares_there()
    do i = 1, size(shares)
      if (i > 1) then
        if (shares(i)%equals(shares(i - 1))) cycle
      end if
      text = text // ', ' // shares(i)%words()
    end do
    if (text /= '') text = ', only parts that are not merged' // text
  end function unmerged_text

  !> Validates the model at the test points: reads model.h5; writes validation.csv, the statistics into model.h5, and the report.
  !> Collective on all ranks.
  !>
  !> Errors are printed and set session%exit_code: the deck has no test section; those of build_states, of the loading of the
  !> problem, of check_points, read_own_model and validate; a file cannot be written. The exit code is that of "not converged" if a
  !> point has no full-order solution, or has one but no answer. A model that is not accepted gives a warning only. After a signal
  !> nothing is written.
  subroutine validate_stage(session, report, ierr)
    type(session_t), intent(inout) :: session
    type(run_report_t), intent(inout) :: report
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    type(model_t) :: model
    type(validation_t) :: outcome
    type(error_t), allocatable :: error
    real(rk), allocatable :: points(:, :)

    ierr = 0
    work: block
      call build_test_points(session%deck, points, error)
      if (allocated(error)) exit work
      PetscCall(session%load_study(error, ierr))
      if (allocated(error)) exit work
      associate (problem => session%full_order%problem)
        call check_points(problem, points, error)
        if (allocated(error)) exit work
        call session%announce_plan(points)
        call read_own_model(session, problem, model, error)
        if (allocated(error)) exit work
        call forget_training(problem)
        PetscCall(session%full_order%team_for(problem%deck%test%n_groups, size(points, 2), team, ierr))
        PetscCall(validate(problem, team, model, points, session%has_benchmark, outcome, error, ierr))
        if (allocated(error) .or. outcome%is_stopped) exit work
      end associate
      PetscCall(keep_validation(session, model, outcome, report, error, ierr))
    end block work
    call session%end_stage(error, outcome%is_stopped, 'nothing was written')
  end subroutine validate_stage

  !> Builds the test points of the deck. Errors: it has none; those of build_states.
  subroutine build_test_points(deck, points, error)
    type(deck_config_t), intent(in) :: deck
    !> shape (n_parameters, n_points)
    real(rk), allocatable, intent(out) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error

    if (.not. deck%has_test) then
      call make_error(error, 'the deck has no test section; it must name the points to validate at', deck%path, &
        hint='for example: test: {sobol: 50, seed: 1}')
      return
    end if
    call build_states(deck, deck%test, points, error)
  end subroutine build_test_points

  subroutine keep_validation(session, model, outcome, report, error, ierr)
    type(session_t), intent(inout) :: session
    type(model_t), intent(inout) :: model
    type(validation_t), intent(in) :: outcome
    type(run_report_t), intent(inout) :: report
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(verdict_t) :: verdict

    PetscCall(describe_problem(session%full_order%problem, report, ierr))
    call report_model(model, report)
    verdict = judge_validation(outcome, session%deck%validation)
    call report_validation(session%deck, session%full_order%problem%plan%type, outcome, verdict, report)
    call keep_statistics(outcome, verdict, model)
    work: if (session%rank == 0) then
      call write_validation_table(session%deck, outcome, session%folder // '/validation.csv', error)
      if (allocated(error)) exit work
      call write_model(model_path(session), model, error)
    end if work
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    if (allocated(error)) return
    PetscCall(write_report(session, [model_keys, error_keys], report, ierr))
    call warn_of_errors(outcome)
    call log_info('validated at ' // counted(size(outcome%points, 2), 'point') // ': ' // session%folder // '/validation.csv' // &
      new_line('a') // validation_table(outcome, verdict))
    call log_judgment('forces ', verdict%forces)
    call log_judgment('fields ', verdict%fields)
    if (outcome%n_times > 0) then
      call log_judgment('strains ', verdict%strains)
      call log_info(estimate_sentence(outcome))
    end if
    call warn_of_unsolved(session%deck, outcome)
    if (any(outcome%reason_full_order /= reason_converged) .or. verdict%n_unanswered > 0) session%exit_code = exit_not_converged
  end subroutine keep_validation

  !> Warns of validation points that the full order does not solve: they let the command end with the exit code of this.
  subroutine warn_of_unsolved(deck, outcome)
    type(deck_config_t), intent(in) :: deck
    type(validation_t), intent(in) :: outcome
    integer :: first

    associate (is_lost => outcome%reason_full_order /= reason_converged)
      if (.not. any(is_lost)) return
      first = findloc(is_lost, .true., dim=1)
      call log_warning(to_text(count(is_lost)) // ' of ' // counted(size(is_lost), 'validation point') // ' without a ' // &
        'full-order solution (validation.csv, column full_order); the first one is ' // &
        format_point(deck%state_parameters, outcome%points(:, first)) // ': ' // reason_text(outcome%reason_full_order(first)))
    end associate
  end subroutine warn_of_unsolved

  !> Logs the sentence of a judgment, as a warning if it says `NOT accepted`.
  subroutine log_judgment(subject, judgment)
    !> what was judged, with a blank behind it
    character(*), intent(in) :: subject
    type(judgment_t), intent(in) :: judgment

    if (index(judgment%sentence, 'NOT accepted') == 1) then
      call log_warning(subject // judgment%sentence)
    else
      call log_info(subject // judgment%sentence)
    end if
  end subroutine log_judgment

  !> Solves the full-order problem at the given points and writes the files of write_fields and the report. Collective on all ranks.
  !>
  !> Errors are printed and set session%exit_code: those of the loading of the problem; a point is not valid; those of
  !> read_own_model (has_model only), of write_fields and estimate_time_error (--halve-steps); nothing flows with --halve-steps; the
  !> report cannot be written. The exit code is that of "not converged" if
  !> a point has no full-order solution. After a signal nothing is written.
  subroutine fields_stage(session, points, has_model, report, ierr)
    type(session_t), intent(inout) :: session
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> reads model.h5 and writes its answers, too
    logical, intent(in) :: has_model
    type(run_report_t), intent(inout) :: report
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    type(model_t) :: model
    type(solved_points_t) :: solved
    type(time_error_t) :: time_error
    type(error_t), allocatable :: error

    call announce_stiffness(session)
    work: block
      PetscCall(session%full_order%load(session%deck, error, ierr))
      if (allocated(error)) exit work
      associate (problem => session%full_order%problem)
        call check_points(problem, points, error)
        if (session%halves_steps .and. .not. problem%flow%is_there()) call make_error(error, &
          '--halve-steps needs a material with plasticity or creep: others have no error of time steps', session%deck%path)
        if (allocated(error)) exit work
        call session%announce_plan(points)
        if (has_model) call read_own_model(session, problem, model, error)
        if (allocated(error)) exit work
        PetscCall(session%full_order%ready_team(team, ierr))
        if (has_model) then
          PetscCall(write_fields(problem, team, points, session%folder, solved, error, ierr, model))
        else
          PetscCall(write_fields(problem, team, points, session%folder, solved, error, ierr))
        end if
        if (allocated(error) .or. solved%is_stopped) exit work
        if (session%halves_steps) then
          PetscCall(estimate_time_error(problem, team, points, solved, time_error, error, ierr))
          PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
          if (allocated(error) .or. solved%is_stopped) exit work
          call time_error%report(report)
        end if
        PetscCall(describe_problem(problem, report, ierr))
        call report_fields(problem, points, solved, report)
        call warn_of_leans(session, multipliers_of(solved, problem%rows%n_rows), solved%states%reason, report)
      end associate
      PetscCall(write_report(session, field_keys, report, ierr))
      call tell_fields(session, solved, size(points, 2))
      if (session%halves_steps) call log_info(time_error%sentence())
    end block work
    call session%end_stage(error, solved%is_stopped, 'no fields were written')
  end subroutine fields_stage

  !> Logs at how many points there are fields, and warns if some point has none; then the exit code is that of "not converged".
  subroutine tell_fields(session, solved, n_points)
    type(session_t), intent(inout) :: session
    type(solved_points_t), intent(in) :: solved
    integer, intent(in) :: n_points
    integer :: n_solved

    n_solved = count(solved%states%reason == reason_converged)
    call log_info('fields at ' // counted(n_solved, 'point') // ': ' // session%folder // '/fields.xdmf' // &
      accuracy_text(session%deck, pack(solved%states%residuals, solved%states%reason == reason_converged)))
    if (n_solved == n_points) return
    call log_warning('the files have no fields for ' // counted(n_points - n_solved, 'point') // ' that did not converge')
    session%exit_code = exit_not_converged
  end subroutine tell_fields

  !> Returns the normal forces of solved points [force], shape (n_rows, n_points); 0 at points that did not converge.
  pure function multipliers_of(solved, n_rows) result(multipliers)
    type(solved_points_t), intent(in) :: solved
    integer, intent(in) :: n_rows
    real(rk) :: multipliers(n_rows, size(solved%states))
    integer :: i

    multipliers = 0
    do i = 1, size(solved%states)
      if (solved%states(i)%reason == reason_converged) multipliers(:, i) = solved%states(i)%normal_forces()
    end do
  end function multipliers_of

  !> Reads model.h5 of the results folder. Local; each rank reads it. Errors: it is missing, cannot be read, or was trained for
  !> another deck or mesh, or with other settings (differing_setting).
  subroutine read_own_model(session, problem, model, error)
    type(session_t), intent(in) :: session
    type(problem_t), intent(in) :: problem
    type(model_t), intent(out) :: model
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: setting

    if (.not. file_exists(model_path(session))) then
      call make_error(error, 'there is no model yet', model_path(session), &
        hint='run first: signorom train ' // session%deck%path)
      return
    end if
    call read_model(model_path(session), model, error)
    if (allocated(error)) return
    if (model%provenance /= problem%provenance .or. .not. has_sizes_of(problem, model)) call make_error(error, &
      'the model was trained for another deck, mesh or field file', model_path(session), &
      hint='sample and train again, or choose another output.directory')
    if (allocated(error)) return
    setting = differing_setting(session%deck, model%deck_text)
    if (setting /= '') call make_error(error, 'the model was trained with other settings; the deck now has ''' // setting // '''', &
      model_path(session), hint='make it again: first signorom sample ' // session%deck%path // ', then signorom train ' // &
      session%deck%path)
  end subroutine read_own_model

  !> Whether the model has the problem's dimension and numbers of nodes, contact rows, terms and parameters, and the cells of its
  !> clusters exist in the mesh. The provenance of a file does not prove this, because anybody can change it.
  pure logical function has_sizes_of(problem, model)
    type(problem_t), intent(in) :: problem
    type(model_t), intent(in) :: model
    integer :: i

    has_sizes_of = model%n_dim == problem%mesh%n_dim .and. model%n_nodes == problem%mesh%n_nodes .and. &
      model%n_multipliers == problem%force_rows%n_rows .and. model%terms%n_terms() == problem%terms%n_terms() .and. &
      size(model%parameter_names) == size(problem%deck%state_parameters)
    do i = 1, model%n_clusters()
      has_sizes_of = has_sizes_of .and. all(model%parts(i)%reduced%cells() <= size(problem%mesh%cell_types))
    end do
  end function has_sizes_of

  function model_path(session) result(path)
    type(session_t), intent(in) :: session
    character(:), allocatable :: path

    path = session%folder // '/model.h5'
  end function model_path
end module sig_study
