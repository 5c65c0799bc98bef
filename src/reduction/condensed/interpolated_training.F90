! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Trains a condensed model of bodies whose elastic constants depend on the parameters. The responses of each body are interpolated
!> between nodes, which are chosen values of its constants. Nodes are added until the contact forces at the training points are
!> exact enough.
!>
!> The training points were solved with their own elastic constants. They measure the error of the interpolation, and are not used
!> to build it.
module sig_interpolated_training
  use sig_body_compliance, only: body_compliance_t
  use sig_body_constants, only: body_constants_t, find_body_constants, joined_body_t, usual_nodes_of
  use sig_body_nodes, only: close_anchors, fill_nodes, grow_nodes, start_body
  use sig_condensed_model, only: condensed_model_t
  use sig_condensed_plan, only: displacement_plan_t, plan_displacements, why_not_condensed
  use sig_contact_responses, only: anchor_forces
  use sig_displacement_modes, only: add_displacement_modes
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_full_order, only: full_order_t, team_t
  use sig_holding, only: anchors_t, find_anchors
  use sig_interpolated_fields, only: field_states_t, find_field_states, told_errors
  use sig_interpolation_residuals, only: may_have_bounds, measure_residuals
  use sig_kinds, only: rk
  use sig_log, only: log_info, log_warning
  use sig_parameter_space, only: format_point
  use sig_polynomial_nodes, only: most_variables, number_of_polynomials
  use sig_problem, only: problem_t
  use sig_reduced, only: reduced_t
  use sig_reduced_kinds, only: bodies_of
  use sig_reference_sets, only: start_sets_of
  use sig_response_errors, only: measure_fields, measure_responses, probes_t
  use sig_statistics, only: statistics_t, summarize
  use sig_text, only: counted, short_number, to_text
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: any_variable, interpolate_fallback, interpolate_responses, train_interpolated

  !> [-] the measured error must be at most this fraction of the tolerance, because other points can have larger errors
  real(rk), parameter :: caution = 0.25_rk
  !> most nodes of a body; more would cost too much time
  integer, parameter :: most_nodes = 170

contains

  !> Trains the whole model: responses at nodes, residuals for bounds of the error, and displacement modes where they are planned.
  !> Afterwards the stiffness of the team is that of other elastic constants. Collective on all ranks, with the same result on each.
  !>
  !> Errors: an elastic constant is out of its range somewhere in the box; those of interpolate_responses: a body would need more
  !> than 170 interpolation nodes, or has too many variable constants; the stiffness could not be factored.
  subroutine train_interpolated(full_order, snapshots, may_have_modes, part, error, ierr)
    !> loaded problem
    type(full_order_t), intent(inout) :: full_order
    !> full-order solutions
    type(training_set_t), intent(in) :: snapshots
    !> allow displacement modes
    logical, intent(in) :: may_have_modes
    !> the model; not allocated after an error
    class(reduced_t), allocatable, intent(out) :: part
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(body_constants_t), allocatable :: constants(:)
    type(joined_body_t) :: joined
    type(condensed_model_t), allocatable, target :: model
    type(body_compliance_t), pointer :: bodies
    type(displacement_plan_t) :: plan
    type(field_states_t) :: others, states
    type(team_t), pointer :: team

    PetscCall(full_order%ready_team(team, ierr))
    associate (problem => full_order%problem)
      call find_body_constants(problem, constants, error)
      if (allocated(error)) return
      call joined%create(problem, constants)
      allocate (model)
      allocate (body_compliance_t :: model%compliance)
      bodies => bodies_of(model)
      plan = plan_displacements(problem, usual_nodes_of(constants), .not. may_have_modes .or. may_have_bounds(constants))
      PetscCall(interpolate_responses(problem, team, snapshots, plan, most_nodes, joined, model, error, ierr))
      if (allocated(error)) return
      PetscCall(measure_residuals(problem, team, joined, bodies, error, ierr))
      if (allocated(error)) return
      if (bodies%has_displacement() .or. may_have_modes) call measure_fields(problem, snapshots, bodies)
      if (plan%has_modes .and. may_have_modes) then
        call find_field_states(problem, snapshots, model, states, others)
        PetscCall(add_displacement_modes(problem, team, joined, states, bodies, error, ierr))
        if (allocated(error)) return
        call tell_error(bodies%n_modes(), told_errors(bodies, others), problem%deck%reduction%displacement_tolerance)
      end if
    end associate
    call log_nodes(constants, bodies, error_text(full_order%problem, snapshots, bodies), &
      has_bounds=.not. full_order%problem%flow%is_there())
    call move_alloc(model, part)
  end subroutine train_interpolated

  !> Logs the errors of displacements that the model tells at points which its modes do not come from; warns if more than 5 % of
  !> them miss the tolerance.
  subroutine tell_error(n_modes, errors, tolerance)
    integer, intent(in) :: n_modes
    !> [-] in energy, relative
    real(rk), intent(in) :: errors(:)
    real(rk), intent(in) :: tolerance
    character(:), allocatable :: text
    type(statistics_t) :: statistics

    statistics = summarize(errors)
    text = 'displacements by ' // counted(n_modes, 'mode') // ': the error in energy that answers tell is at most ' // &
      short_number(statistics%p95, 2) // ' at 95 % of ' // counted(statistics%n_values, 'other point') // ', ' // &
      short_number(statistics%maximum, 2) // ' at the worst of them'
    if (statistics%p95 <= tolerance) then
      call log_info(text)
    else
      call log_warning(text // '; reduction.displacement_tolerance is ' // short_number(tolerance, 2))
    end if
  end subroutine tell_error

  !> Computes the responses at more and more nodes, until the errors of the contact forces, measured at the solved points and
  !> estimated at probes (sig_response_errors), are at most a quarter of reduction.stiffness_tolerance. Where no body needs an
  !> interpolation (any_variable), one round is enough, and its error is not compared. Collective on all ranks, with the same result
  !> on each.
  !>
  !> Errors: that would need more than n_most nodes of a body, or a body has more than most_variables variable constants; the
  !> stiffness at a node could not be factored.
  subroutine interpolate_responses(problem, team, solved, plan, n_most, joined, model, error, ierr)
    type(problem_t), intent(in) :: problem
    !> from ready_team; its stiffness changes
    type(team_t), intent(inout) :: team
    !> points with full-order contact forces; their displacements are not used
    type(training_set_t), intent(in) :: solved
    type(displacement_plan_t), intent(in) :: plan
    !> largest number of interpolation nodes of a body
    integer, intent(in) :: n_most
    !> after its step `create`; its elastic constants change
    type(joined_body_t), intent(inout) :: joined
    !> its compliance are bodies; in: without data; out: the responses, measured_error, worst_point, largest_size and the active
    !> sets of the solved points; incomplete after an error
    type(condensed_model_t), target, intent(inout) :: model
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(probes_t) :: probes
    type(body_compliance_t), pointer :: bodies
    integer :: i_round
    logical :: is_good

    ierr = 0
    bodies => bodies_of(model)
    call start_data(problem, team, joined%constants, solved, plan, bodies)
    call model%take_laws(problem%laws)
    call probes%create(problem, solved)
    i_round = 0
    is_good = .false.
    do while (.not. is_good)
      if (.not. has_room(joined%constants, i_round, n_most)) then
        call refuse(problem, joined%constants, solved, bodies, error)
        return
      end if
      call grow_nodes(joined%constants, i_round, bodies)
      PetscCall(fill_nodes(problem, team, joined, bodies, error, ierr))
      if (allocated(error)) return
      call measure_responses(problem, solved, model)
      call probes%compare(model)
      is_good = .not. any_variable(joined%constants) .or. &
        max(bodies%measured_error, probes%error) <= caution * problem%deck%reduction%stiffness_tolerance
      i_round = i_round + 1
    end do
  end subroutine interpolate_responses

  !> Makes the fallback of a hyper-reduced model: an interpolated model of all contact forces, with the displacements of all nodes
  !> or of none. Where it cannot be made, the log has a warning; without contact rows, or where reduction.max_full_order_size is 0,
  !> there is none and no warning. Collective on all ranks, with the same result on each.
  !>
  !> Errors: an elastic constant is out of its range somewhere in the box.
  subroutine interpolate_fallback(full_order, snapshots, has_starts, part, error, ierr)
    type(full_order_t), intent(inout) :: full_order
    !> points with full-order contact forces; their displacements are not used
    type(training_set_t), intent(in) :: snapshots
    !> the snapshots are the training points of the model; otherwise their active sets are not kept as starts
    logical, intent(in) :: has_starts
    !> the fallback; not allocated where there is none
    class(reduced_t), allocatable, intent(out) :: part
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(body_constants_t), allocatable :: constants(:)
    type(body_compliance_t), pointer :: bodies
    type(error_t), allocatable :: refusal
    character(:), allocatable :: reason

    ierr = 0
    call find_body_constants(full_order%problem, constants, error)
    if (allocated(error) .or. full_order%problem%rows%n_rows == 0 .or. &
      full_order%problem%deck%reduction%max_full_order_size <= 0) return
    reason = why_not_condensed(full_order%problem)
    if (reason == '') then
      PetscCall(train_interpolated(full_order, snapshots, .false., part, refusal, ierr))
      if (allocated(refusal)) reason = refusal%message
    end if
    if (reason /= '') then
      call log_warning('the model keeps no full-order operator: ' // reason // &
        '; a point has no answer where the reduced problem has no solution')
      return
    end if
    select type (part)
    type is (condensed_model_t)
      bodies => bodies_of(part)
      if (size(bodies%exact_boundaries) > 0) call drop_field(bodies)
      if (.not. has_starts) bodies%start_sets = bodies%start_sets(:, :0)
    end select
  end subroutine interpolate_fallback

  !> Removes the displacements of single boundaries, so that the modes of the hyper-reduced model answer those of all nodes. Local.
  pure subroutine drop_field(data)
    type(body_compliance_t), intent(inout) :: data
    integer :: i

    data%exact_dofs = data%exact_dofs(:0)
    data%exact_boundaries = data%exact_boundaries(:0)
    data%anchor_motions = data%anchor_motions(:0, :)
    do i = 1, size(data%bodies)
      associate (body => data%bodies(i))
        body%own = body%own(:0)
        body%loaded_field = body%loaded_field(:0, :)
        body%prescribed_field = body%prescribed_field(:0, :)
        body%contact_field = body%contact_field(:0, :)
      end associate
    end do
  end subroutine drop_field

  !> Sets the data that do not depend on the elastic constants, and gives each body its data without nodes. Local.
  subroutine start_data(problem, team, constants, snapshots, plan, data)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(in) :: team
    type(body_constants_t), intent(in) :: constants(:)
    type(training_set_t), intent(in) :: snapshots
    type(displacement_plan_t), intent(in) :: plan
    type(body_compliance_t), intent(inout) :: data
    type(anchors_t) :: anchors
    integer :: i

    data%exact_dofs = plan%exact_dofs
    data%exact_boundaries = plan%boundaries
    call find_anchors(team%solver%system%motions, anchors)
    data%anchors = anchors%rows
    data%anchor_closing = anchors%closing
    data%gap = problem%force_rows%gap
    call close_anchors(anchors, data%gap)
    data%anchor_forces = anchor_forces(team%solver%system, anchors)
    call move_anchors(team, anchors, data)
    allocate (data%bodies(size(constants)))
    do i = 1, size(constants)
      call start_body(problem, constants(i), i, data)
    end do
    data%start_sets = start_sets_of(snapshots%forces(), data%anchors)
  end subroutine start_data

  !> Sets data%anchor_motions, the displacements of the exact dofs by the rigid motions of the anchors. Local.
  subroutine move_anchors(team, anchors, data)
    type(team_t), intent(in) :: team
    type(anchors_t), intent(in) :: anchors
    type(body_compliance_t), intent(inout) :: data
    real(rk), allocatable :: motion(:)
    integer :: i

    allocate (data%anchor_motions(size(data%exact_dofs), size(anchors%rows)))
    do i = 1, size(anchors%rows)
      motion = team%solver%system%motions%field(anchors%amplitudes(:, i))
      data%anchor_motions(:, i) = motion(data%exact_dofs)
    end do
  end subroutine move_anchors

  !> Whether some body needs an interpolation, because its Young's moduli do not all scale together or a Poisson's ratio of it
  !> varies.
  pure logical function any_variable(constants)
    type(body_constants_t), intent(in) :: constants(:)
    integer :: i

    any_variable = any([(size(constants(i)%numerators) > 0, i=1, size(constants))])
  end function any_variable

  !> Whether the interpolation nodes of round i_round (from 0 on) are allowed for every body: at most n_most nodes, and at most
  !> most_variables variables.
  pure logical function has_room(constants, i_round, n_most)
    type(body_constants_t), intent(in) :: constants(:)
    integer, intent(in) :: i_round
    !> largest number of interpolation nodes of a body
    integer, intent(in) :: n_most
    integer :: i

    has_room = .true.
    do i = 1, size(constants)
      associate (n_variables => size(constants(i)%numerators))
        if (n_variables > most_variables) has_room = .false.
        if (has_room) has_room = number_of_polynomials(n_variables, constants(i)%degree(i_round)) <= n_most
      end associate
    end do
  end function has_room

  !> Makes the error that a body has more than most_variables variable constants; where none has, the error that the interpolation
  !> does not reach the tolerance.
  subroutine refuse(problem, constants, solved, data, error)
    type(problem_t), intent(in) :: problem
    type(body_constants_t), intent(in) :: constants(:)
    !> points at which the errors in `data` were measured
    type(training_set_t), intent(in) :: solved
    type(body_compliance_t), intent(in) :: data
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: bodies, hint
    integer :: i

    hint = 'let the elastic constants vary less, let the moduli of a body share one factor, or take a larger tolerance'
    if (.not. problem%flow%is_there()) hint = hint // ' or reduction.method: hhr'
    bodies = ''
    do i = 1, size(constants)
      if (size(constants(i)%numerators) > most_variables) then
        call make_error(error, 'body ' // constants(i)%name // ' has ' // to_text(size(constants(i)%numerators)) // &
          ' Poisson''s ratios and ratios of moduli that vary; at most ' // to_text(most_variables) // ' can be interpolated', &
          problem%deck%path, &
          hint='let fewer Poisson''s ratios of this body depend on the parameters, or let its moduli share one factor', &
          exit_code=exit_not_converged)
        return
      end if
      if (size(constants(i)%numerators) > 0) bodies = bodies // '; body ' // constants(i)%name // ' is interpolated over ' // &
        counted(size(constants(i)%numerators), 'constant')
    end do
    associate (reduction => problem%deck%reduction)
      call make_error(error, 'interpolation over the elastic constants needs more interpolation nodes than are allowed for ' // &
        'a body: after ' // &
        counted(data%n_factorizations, 'factorization') // ' ' // error_text(problem, solved, data) // '; the relative errors ' // &
        'at all training points, and their estimates at other points, must be at most a quarter of ' // &
        'reduction.stiffness_tolerance (' // to_text(reduction%stiffness_tolerance) // ')' // bodies, problem%deck%path, &
        hint=hint, exit_code=exit_not_converged)
    end associate
  end subroutine refuse

  !> Returns a sentence without a full stop: the largest relative error of the contact forces at the training points, or a training
  !> point at which the model has no answer.
  function error_text(problem, solved, data) result(text)
    type(problem_t), intent(in) :: problem
    !> the training points
    type(training_set_t), intent(in) :: solved
    !> measured_error and worst_point must be set for `solved`; worst_point is 0 as long as no error is measured
    type(body_compliance_t), intent(in) :: data
    character(:), allocatable :: text

    if (data%worst_point == 0) then
      text = 'no error of the contact forces at the training points is known'
    else if (data%measured_error < huge(data%measured_error)) then
      text = 'the contact forces have relative errors of up to ' // short_number(data%measured_error) // ' at the training points'
    else
      text = 'the model has no answer at the training point ' // &
        format_point(problem%deck%state_parameters, solved%parameters(:, data%worst_point))
    end if
  end function error_text

  !> Writes to the log how the constants are interpolated, the measured error, and, where answers have no bound of their error, how
  !> to get one.
  subroutine log_nodes(constants, data, measured, has_bounds)
    type(body_constants_t), intent(in) :: constants(:)
    type(body_compliance_t), intent(in) :: data
    !> result of error_text
    character(*), intent(in) :: measured
    !> whether models of this kind have bounds
    logical, intent(in) :: has_bounds
    integer :: i

    do i = 1, size(constants)
      if (size(constants(i)%numerators) == 0) then
        ! drafts of a greedy selection would say it again and again
        if (has_bounds) call log_info('body ' // constants(i)%name // &
          ': its responses are exact, because its moduli are fixed or all scale together')
      else
        call log_info('body ' // constants(i)%name // ': its responses are interpolated over ' // &
          counted(size(constants(i)%numerators), 'elastic constant') // ', ' // &
          counted(data%bodies(i)%nodes%n_nodes(), 'node'))
      end if
    end do
    call log_info(counted(data%n_factorizations, 'factorization') // '; ' // measured)
    if (data%has_bound() .or. .not. has_bounds) return
    call log_info('there is no bound of the error of answers; the error at the training ' // &
      'points is an estimate. For a bound, at most one constant of each body may vary: either the ratio of two ' // &
      'of its moduli, by a factor of at most about 9; or, if the body has one material, Poisson''s ratio nu, so that 1 - 2 nu ' // &
      'varies by at most this factor. A common factor of all moduli of a body may vary freely')
  end subroutine log_nodes
end module sig_interpolated_training
