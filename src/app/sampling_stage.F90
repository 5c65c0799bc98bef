! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The first stage of a study: solves the deck's training points and candidates and keeps them in the results folder.
module sig_sampling_stage
  use sig_accuracy_warnings, only: motion_warning
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_greedy_record, only: training_points
  use sig_greedy_selection, only: select_points
  use sig_kinds, only: rk
  use sig_log, only: log_info, log_warning
  use sig_materials, only: has_fixed_stiffness
  use sig_reporting, only: selection_text
  use sig_run_report, only: run_report_t
  use sig_sampling, only: sample, sampling_result_t
  use sig_selection, only: selection_t
  use sig_session, only: session_t
  use sig_snapshot_merge, only: candidate_store, read_own_snapshots, snapshot_store, snapshots_path, store_in, store_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_stage_report, only: warn_of_leans
  use sig_text, only: counted, to_text
  use petsc
  implicit none(type, external)
  private
  public :: sample_stage, announce_stiffness, need_training

  !> range of dofs for read_own_snapshots: no displacements
  integer, parameter :: no_dofs(2) = [1, 0]

  !> what a signal leaves behind
  character(*), parameter :: finished_are_kept = 'the finished points are kept; run the same command again to go on'

contains

  !> Solves the training points, or selects and solves them (greedy), and writes snapshots.h5; with clusters.target, and by greedy
  !> projection, also candidates.h5. With a share of the points it writes shards only, from which the same command without --share
  !> makes these files. Collective on all ranks.
  !>
  !> Errors are printed and set session%exit_code: the deck has no training, or a greedy selection and a share is asked for; those
  !> of the loading of the problem, of sample and select_points. The exit code is that of "not converged" if a point did not
  !> converge, and exit_stopped after a signal; then the finished points are kept.
  subroutine sample_stage(session, ierr)
    type(session_t), target, intent(inout) :: session
    PetscErrorCode, intent(out) :: ierr
    type(store_t) :: store
    type(sampling_result_t) :: outcome
    type(selection_t) :: selection
    type(error_t), allocatable :: error

    ierr = 0
    session%has_plan = .true.
    work: block
      call need_training(session, error)
      if (.not. allocated(error)) call refuse_greedy_share(session, error)
      if (allocated(error)) exit work
      call announce_stiffness(session)
      PetscCall(session%load_study(error, ierr))
      if (allocated(error)) exit work
      if (session%deck%greedy%is_used) then
        PetscCall(select_points(session%full_order, session%folder, outcome, selection, error, ierr))
      else
        store = store_in(session%folder, snapshot_store, session%share)
        PetscCall(sample(session%full_order, session%deck%training, store, outcome, error, ierr))
      end if
      if (allocated(error) .or. outcome%is_stopped) exit work
      call tell_sampled(session, outcome, sampled_text(session, outcome, selection) // place_text(session, store))
      if (.not. session%share%is_used()) call warn_of_sampled_leans(session)
    end block work
    call session%end_stage(error, outcome%is_stopped, finished_are_kept)
    if (session%deck%clusters%target%is_used .and. session%may_go_on()) then
      PetscCall(sample_candidates(session, ierr))
    end if
  end subroutine sample_stage

  !> Gives the warnings of warn_of_leans for all training points, also for those that an earlier command has solved. Local; the
  !> first rank reads the snapshots, and the others do nothing.
  subroutine warn_of_sampled_leans(session)
    type(session_t), intent(inout) :: session
    type(selection_t) :: selection
    type(snapshot_set_t) :: snapshots
    type(run_report_t) :: unused
    type(error_t), allocatable :: error
    real(rk), allocatable :: points(:, :)
    logical, allocatable :: is_missing(:)

    if (session%rank /= 0) return
    associate (problem => session%full_order%problem)
      call training_points(problem, session%folder, points, selection, error)
      if (allocated(error)) return
      allocate (is_missing(size(points, 2)))
      call read_own_snapshots(problem, snapshots_path(session%folder), snapshots, error, no_dofs, points, is_missing)
    end associate
    ! the stage that needs the file will say what is wrong with it
    if (allocated(error)) return
    call warn_of_leans(session, snapshots%multipliers, snapshots%reasons, unused)
  end subroutine warn_of_sampled_leans

  !> Solves the candidates of clusters.target, at which the errors of local models are measured, and writes candidates.h5.
  !> Collective on all ranks. Errors are printed and set session%exit_code: those of sample. Other exit codes as in sample_stage.
  subroutine sample_candidates(session, ierr)
    type(session_t), target, intent(inout) :: session
    PetscErrorCode, intent(out) :: ierr
    type(sampling_result_t) :: outcome
    type(store_t) :: store
    type(error_t), allocatable :: error

    store = store_in(session%folder, candidate_store, session%share)
    PetscCall(sample(session%full_order, session%deck%clusters%target%candidates, store, outcome, error, ierr))
    if (.not. (allocated(error) .or. outcome%is_stopped)) call tell_sampled(session, outcome, 'solved ' // &
      counted(outcome%n_points, 'candidate') // ' (' // found_text(outcome) // '): ' // place_text(session, store))
    call session%end_stage(error, outcome%is_stopped, finished_are_kept)
  end subroutine sample_candidates

  !> Logs the text of a sampling that came to its end. Warns if a point did not converge, and sets session%exit_code then; warns if
  !> motion_warning has a text.
  subroutine tell_sampled(session, outcome, text)
    type(session_t), intent(inout) :: session
    type(sampling_result_t), intent(in) :: outcome
    character(*), intent(in) :: text
    character(:), allocatable :: warning

    if (outcome%n_failed > 0) then
      if (session%full_order%problem%remembers()) then
        call log_warning(to_text(outcome%n_failed) // ' of the points did not converge (where a state of a history fails, its ' // &
          'later ones do, too), and solve --at says why; the same command tries these again, so change the deck first: loads, ' // &
          'ranges or coefficients of friction, where a body slides or is pulled off its contacts')
      else
        call log_warning(to_text(outcome%n_failed) // ' of the points did not converge, and solve --at says why a point ' // &
          'fails; the same command tries these again, so change the deck first: loads or ranges, where loads pull a body ' // &
          'off its contacts; otherwise the section solver, for example max_iterations or type')
      end if
      session%exit_code = exit_not_converged
    end if
    warning = motion_warning(outcome%rotation, outcome%deformation)
    if (warning /= '') call log_warning(warning)
    call log_info(text)
  end subroutine tell_sampled

  !> Returns `sampled 31 points (12 were there): `. If the stiffness depends on the parameters, the brackets also contain the number
  !> of stiffnesses. With a greedy selection, what it did stands behind the brackets.
  pure function sampled_text(session, outcome, selection) result(text)
    type(session_t), intent(in) :: session
    type(sampling_result_t), intent(in) :: outcome
    type(selection_t), intent(in) :: selection
    character(:), allocatable :: text

    text = 'sampled ' // counted(outcome%n_points, 'point') // ' (' // found_text(outcome)
    if (.not. has_fixed_stiffness(session%deck)) text = text // ', ' // counted(outcome%n_stiffnesses, 'stiffness')
    text = text // ')'
    if (session%deck%greedy%is_used) text = text // ', selected ' // selection_text(selection)
    text = text // ': '
  end function sampled_text

  !> Returns of how many points the store had a converged solution already: `0 were there`, `1 was there`.
  pure function found_text(outcome) result(text)
    type(sampling_result_t), intent(in) :: outcome
    character(:), allocatable :: text

    text = to_text(outcome%n_found) // trim(merge(' was ', ' were', outcome%n_found == 1)) // ' there'
  end function found_text

  !> Returns where the solutions are: the path of the merged file, or the share and how to merge it with the others.
  function place_text(session, store) result(text)
    type(session_t), intent(in) :: session
    !> not set after a greedy selection
    type(store_t), intent(in) :: store
    character(:), allocatable :: text

    if (session%share%is_used()) then
      text = session%share%words() // ' in ' // session%folder // '; when all shares are there, merge them by signorom sample ' // &
        session%deck%path
    else if (allocated(store%name)) then
      text = store%path()
    else
      text = snapshots_path(session%folder)
    end if
  end function place_text

  !> Errors: a share of the points is asked for, and the deck has a greedy selection, whose points are not known before.
  subroutine refuse_greedy_share(session, error)
    type(session_t), intent(in) :: session
    type(error_t), allocatable, intent(out) :: error

    if (session%share%is_used() .and. session%deck%greedy%is_used) call make_error(error, &
      '--share does not go with training.greedy, which chooses each point by the answers at those before it', &
      session%deck%path, session%deck%training%line, session%deck%training%column, &
      hint='list the points (training: {sobol: 64}, or another set), or sample without --share')
  end subroutine refuse_greedy_share

  !> Logs that points with other elastic constants take extra time, if the stiffness depends on the parameters.
  subroutine announce_stiffness(session)
    type(session_t), intent(in) :: session
    character(:), allocatable :: text
    integer :: i

    if (has_fixed_stiffness(session%deck)) return
    text = 'the stiffness depends on the parameters: each new set of elastic constants takes extra time'
    associate (materials => session%deck%materials)
      if (.not. any([(materials(i)%flows(), i=1, size(materials))])) text = text // &
        ' (training.stiffness may save it at training points)'
    end associate
    call log_info(text)
  end subroutine announce_stiffness

  !> Errors: the deck has no training section.
  subroutine need_training(session, error)
    type(session_t), intent(in) :: session
    type(error_t), allocatable, intent(out) :: error

    if (.not. session%deck%has_training) call make_error(error, &
      'the deck has no training section; it must name the points to sample', session%deck%path, &
      hint='for example: training: {sobol: 64}')
  end subroutine need_training
end module sig_sampling_stage
