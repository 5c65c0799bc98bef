! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Builds the model of a deck: trains it once or refines it to a target error. A hyper-reduced model also gets, where possible, the
!> fallback, the active sets from which queries start, and the certificates.
module sig_model_building
  use sig_compliance, only: compliance_t
  use sig_condensed_plan, only: choose_model_kind, place_of_friction
  use sig_condensed_training, only: condense_fallback, train_condensed
  use sig_deck_config, only: reduction_config_t
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_file_system, only: file_exists
  use sig_full_order, only: full_order_t, team_t
  use sig_inelastic_training, only: train_inelastic
  use sig_interpolated_training, only: interpolate_fallback, train_interpolated
  use sig_kinds, only: rk
  use sig_lifted_training, only: add_certificates
  use sig_log, only: log_info, log_warning
  use sig_model, only: model_t
  use sig_model_parts, only: compliance_of, set_fallback
  use sig_model_header, only: fill_model_header
  use sig_parameter_space, only: build_states
  use sig_petsc_support, only: broadcast_columns
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged, reason_text
  use sig_reduced, only: reduced_t
  use sig_refinement, only: refine, refinement_result_t
  use sig_snapshot_merge, only: candidate_store, read_spread, store_in, store_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_hhr_start_sets, only: fill_start_sets
  use sig_text, only: counted, to_text
  use sig_tied_training, only: train_tied
  use sig_training, only: take_solved, train, warn_of_snapshots
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: build_condensed, build_model

  !> [-] default of certificate.max_error for hyper-reduced models, relative
  real(rk), parameter :: hyper_reduced_error = 0.05_rk

contains

  !> Builds the model of the deck from its snapshots. Collective on all ranks; each rank gets the same model. There is no model if
  !> refinement%is_stopped.
  !>
  !> The model is condensed, interpolated or tied if build_exact builds one. Otherwise it is hyper-reduced, trained once or, with
  !> clusters.target, refined in rounds. A hyper-reduced model has a fallback where build_fallback builds one. Without a fallback
  !> and if certificate.max_error is not 0, add_certificates adds data for bounds of errors if the stiffness is fixed; else a
  !> warning says that answers have no bound.
  !>
  !> Errors: those of build_exact, complete_lifting, read_candidates, build_fallback, train and refine.
  subroutine build_model(full_order, folder, snapshots, model, refinement, error, ierr)
    !> loaded problem of the deck
    type(full_order_t), intent(inout) :: full_order
    !> results folder, where the solved candidates of clusters.target are
    character(*), intent(in) :: folder
    !> full-order solutions at the training points; each rank has some of their dofs. On return the displacements may have size 0;
    !> if the model is hyper-reduced, the lifted responses are complete (complete_lifting)
    type(snapshot_set_t), intent(inout) :: snapshots
    type(model_t), intent(out) :: model
    !> how a refinement went; it has no rounds if the deck has no clusters.target
    type(refinement_result_t), intent(out) :: refinement
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t), target :: candidates
    class(reduced_t), allocatable :: fallback
    logical :: is_condensed

    ierr = 0
    allocate (refinement%rounds(0))
    call warn_of_snapshots(full_order%problem, snapshots)
    PetscCall(build_exact(full_order, snapshots, model, is_condensed, error, ierr))
    if (allocated(error) .or. is_condensed) return
    PetscCall(complete_lifting(full_order, snapshots, error, ierr))
    if (allocated(error)) return
    if (full_order%problem%deck%clusters%target%is_used) then
      PetscCall(read_candidates(full_order%problem, store_in(folder, candidate_store), candidates, error, ierr))
      if (allocated(error)) return
      ! refine asks models, which may need the fallback for an answer
      PetscCall(build_fallback(full_order, snapshots, .false., fallback, error, ierr))
      if (allocated(error)) return
      PetscCall(refine(full_order%problem, snapshots, candidates, fallback, model, refinement, error, ierr))
      if (refinement%is_stopped) return
    else
      PetscCall(train(full_order%problem, snapshots, model, error, ierr))
      if (allocated(error)) return
      ! frees memory for the matrices of the fallback
      deallocate (snapshots%displacement)
      allocate (snapshots%displacement(0, size(snapshots%reasons)))
      PetscCall(build_fallback(full_order, snapshots, .true., fallback, error, ierr))
      if (allocated(error)) return
      call set_fallback(model, fallback)
      call fill_start_sets(model)
    end if
    model%max_error = max_error_of(full_order%problem%deck%reduction, hyper_reduced_error)
    if (allocated(error)) return
    call say_why_no_bound(full_order%problem, model)
    if (model%has_fallback .or. model%max_error <= 0) return
    if (full_order%problem%has_fixed_stiffness) then
      PetscCall(add_certificates(full_order, model, ierr))
    else
      call log_warning('hyper-reduced answers will have no bound of their error (certificate): the stiffness depends on the ' // &
        'parameters, and there is no fallback')
    end if
  end subroutine build_model

  !> Says in the log why the answers of a hyper-reduced model will have no bound of their error: the deck wants none; the model has
  !> a fallback, but this cannot bound foreign forces (certify_foreign in sig_condensed_certificate); or the stiffness is fixed,
  !> there is no fallback, and reduction.max_full_order_size is 0. The training of the parts tells other reasons.
  subroutine say_why_no_bound(problem, model)
    type(problem_t), intent(in) :: problem
    !> with the fallback, if there is one, and max_error
    type(model_t), intent(in) :: model
    character(*), parameter :: no_bound = 'hyper-reduced answers will have no bound of their error (certificate): '
    class(compliance_t), pointer :: compliance

    if (model%n_multipliers == 0) return
    if (model%max_error <= 0) then
      call log_info(no_bound // 'certificate.max_error is none')
    else if (model%has_fallback) then
      compliance => compliance_of(model, model%fallback())
      if (.not. associated(compliance)) return
      if (compliance%is_fixed() .or. size(compliance%anchors) == 0 .or. .not. compliance%has_bound()) return
      call log_warning(no_bound // 'the stiffness depends on the parameters, and only contact holds a body; a model with ' // &
        'reduction.method: condensed has bounds')
    else if (problem%has_fixed_stiffness .and. problem%deck%reduction%max_full_order_size <= 0) then
      call log_info(no_bound // 'reduction.max_full_order_size is 0')
    end if
  end subroutine say_why_no_bound

  !> Computes the elastic responses to the lifted terms again if the snapshots have fewer of them, as those of an earlier version
  !> do; all dofs of them are on each rank afterwards. Collective on all ranks. Errors: the responses could not be solved for.
  subroutine complete_lifting(full_order, snapshots, error, ierr)
    type(full_order_t), intent(inout) :: full_order
    type(snapshot_set_t), intent(inout) :: snapshots
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    real(rk), allocatable :: response(:, :)
    integer :: reason

    ierr = 0
    if (size(snapshots%free_response, 2) >= size(full_order%problem%lifted_terms)) return
    PetscCall(full_order%ready_team(team, ierr))
    PetscCall(team%solver%lifting(full_order%problem, response, reason, ierr))
    if (reason /= reason_converged) then
      call make_error(error, 'no elastic response to the prescribed values and imposed strains: ' // reason_text(reason), &
        full_order%problem%deck%path, exit_code=exit_not_converged)
      return
    end if
    PetscCall(broadcast_columns(response, PETSC_COMM_WORLD, ierr))
    call move_alloc(response, snapshots%free_response)
  end subroutine complete_lifting

  !> Builds the fallback, which answers where a hyper-reduced model cannot: a condensed model, or an interpolated one if the
  !> stiffness depends on the parameters. Collective on all ranks; the same on each.
  !>
  !> Errors: an elastic constant is out of its range somewhere in the box; where the stiffness varies, no training point has a
  !> solution.
  subroutine build_fallback(full_order, snapshots, has_starts, fallback, error, ierr)
    type(full_order_t), intent(inout) :: full_order
    type(snapshot_set_t), intent(in), target :: snapshots
    !> queries may start from the active sets of the snapshots, because these are at the training points of the model; counts only
    !> where the stiffness depends on the parameters
    logical, intent(in) :: has_starts
    !> not allocated if it is impossible or takes too much memory
    class(reduced_t), allocatable, intent(out) :: fallback
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(training_set_t) :: solved

    if (full_order%problem%has_fixed_stiffness) then
      PetscCall(condense_fallback(full_order, solved_forces(snapshots), fallback, ierr))
      return
    end if
    ierr = 0
    call take_solved(full_order%problem, snapshots, solved, error)
    if (allocated(error)) return
    PetscCall(interpolate_fallback(full_order, solved, has_starts, fallback, error, ierr))
  end subroutine build_fallback

  !> [force] Returns the contact forces of the snapshots that converged, shape (n_multipliers, number of these snapshots).
  pure function solved_forces(snapshots) result(forces)
    type(snapshot_set_t), intent(in) :: snapshots
    real(rk), allocatable :: forces(:, :)
    integer :: i

    forces = snapshots%multipliers(:, pack([(i, i=1, size(snapshots%reasons))], snapshots%reasons == reason_converged))
  end function solved_forces

  !> Builds a model without hyper-reduction if choose_model_kind allows one and, for a tied model, if its training finds no reason
  !> against it. Collective on all ranks.
  !>
  !> Errors: reduction.method is condensed, or contacts have friction or are tied, and there cannot be such a model; those of
  !> build_condensed.
  subroutine build_exact(full_order, snapshots, model, is_built, error, ierr)
    type(full_order_t), intent(inout) :: full_order
    type(snapshot_set_t), intent(in), target :: snapshots
    type(model_t), intent(out) :: model
    !> there is a model; otherwise, without an error, the log says why the model will be hyper-reduced, unless reduction.method is
    !> hhr
    logical, intent(out) :: is_built
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    character(:), allocatable :: kind, more, reason
    integer :: place(2)

    ierr = 0
    call choose_model_kind(full_order%problem, kind, reason)
    if (kind /= 'hhr') then
      more = ''
      PetscCall(build_condensed(full_order, snapshots, kind, model, more, error, ierr))
      if (more /= '') reason = reason // '; ' // more
    end if
    is_built = kind /= 'hhr' .and. .not. allocated(error)
    if (is_built) is_built = more == ''
    if (is_built .or. allocated(error)) return
    if (reason == '') return
    associate (deck => full_order%problem%deck)
      if (.not. full_order%problem%laws%is_plain()) then
        place = place_of_friction(deck)
        call make_error(error, 'contacts have friction or are tied, but ' // reason, deck%path, place(1), place(2), &
          hint='take a larger reduction.max_full_order_size; the command solve needs no model')
      else if (deck%reduction%method == 'condensed') then
        call make_error(error, 'reduction.method is condensed, but ' // reason, deck%path, &
          hint='take reduction.method: auto or hhr; or a larger reduction.max_full_order_size if the matrix is too large, or ' // &
          'no clusters if the deck asks for them')
      else
        call log_info('hyper-reduction (reduction.method: auto): ' // reason)
        if (deck%reduction%displacement%type /= 'auto') call log_info( &
          'reduction.displacement does not change the hyper-reduced clusters of this model, whose displacements come from modes')
      end if
    end associate
  end subroutine build_exact

  !> [-] Returns certificate.max_error of the deck, or `default` where it is auto (negative in `reduction`).
  pure real(rk) function max_error_of(reduction, default)
    type(reduction_config_t), intent(in) :: reduction
    real(rk), intent(in) :: default

    max_error_of = merge(default, reduction%max_error, reduction%max_error < 0)
  end function max_error_of

  !> Builds a model that has one part of the given kind. Collective on all ranks.
  !>
  !> Errors: no training point has a solution; kind condensed: the stiffness could not be factored; those of the training of this
  !> kind.
  subroutine build_condensed(full_order, snapshots, kind, model, reason, error, ierr)
    type(full_order_t), intent(inout) :: full_order
    type(snapshot_set_t), intent(in), target :: snapshots
    !> condensed, interpolated, inelastic or tied
    character(*), intent(in) :: kind
    type(model_t), intent(out) :: model
    !> kind tied: why the model must not be used, empty where it may; does not change for other kinds
    character(:), allocatable, intent(inout) :: reason
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(training_set_t) :: solved

    ierr = 0
    call take_solved(full_order%problem, snapshots, solved, error)
    if (allocated(error)) return
    call fill_model_header(full_order%problem, solved, model)
    model%max_error = max_error_of(full_order%problem%deck%reduction, 0.0_rk)
    allocate (model%parts(1))
    if (kind == 'interpolated') then
      PetscCall(train_interpolated(full_order, solved, .true., model%parts(1)%reduced, error, ierr))
      return
    else if (kind == 'inelastic') then
      PetscCall(train_inelastic(full_order, solved, model%parts(1)%reduced, error, ierr))
      if (allocated(error) .or. allocated(model%parts(1)%reduced)) return
    else if (kind == 'tied') then
      PetscCall(train_tied(full_order, solved, model%parts(1)%reduced, reason, error, ierr))
      return
    end if
    PetscCall(train_condensed(full_order, solved, model%parts(1)%reduced, error, ierr))
    if (allocated(error) .or. allocated(model%parts(1)%reduced)) return
    call make_error(error, 'the stiffness could not be factored', full_order%problem%deck%path, exit_code=exit_not_converged)
  end subroutine build_condensed

  !> Reads the solved candidates of clusters.target, those that did not converge included; each rank gets some of their dofs.
  !> Collective on all ranks.
  !>
  !> Errors: candidates.h5 is missing, cannot be read, is of another deck or mesh, or lacks candidates; those of build_states.
  subroutine read_candidates(problem, store, candidates, error, ierr)
    type(problem_t), intent(in) :: problem
    type(store_t), intent(in) :: store
    type(snapshot_set_t), intent(out) :: candidates
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    character(:), allocatable :: hint
    real(rk), allocatable :: points(:, :)
    logical, allocatable :: is_missing(:)

    ierr = 0
    hint = 'run first: signorom sample ' // problem%deck%path
    if (.not. file_exists(store%path())) then
      call make_error(error, 'there are no solved candidates yet', store%path(), hint=hint)
      return
    end if
    call build_states(problem%deck, problem%deck%clusters%target%candidates, points, error)
    if (allocated(error)) return
    allocate (is_missing(size(points, 2)))
    PetscCall(read_spread(problem, store, points, candidates, is_missing, error, ierr))
    if (allocated(error)) return
    if (any(is_missing)) call make_error(error, 'the file lacks ' // to_text(count(is_missing)) // &
      ' of the ' // counted(size(is_missing), 'candidate') // ' of the deck', store%path(), hint=hint)
  end subroutine read_candidates
end module sig_model_building
