! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Validation: compares the answers of a model with full-order solutions at the test points.
module sig_validation
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_positive_inf, ieee_quiet_nan, ieee_value
  use sig_body_rotations, only: largest_deformation, largest_rotation
  use sig_benchmark, only: benchmark_t, run_benchmark
  use sig_contact_state, only: contact_state_t
  use sig_elastic_body, only: elastic_body_t
  use sig_error_norms, only: measure_errors, measured_bodies_t, point_errors_t
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t, exit_internal, make_error
  use sig_field_mapping, only: create_field_map
  use sig_full_order, only: team_t
  use sig_history_errors, only: history_errors_t, largest_of_history, least_share, over_histories
  use sig_kinds, only: rk
  use sig_materials, only: varying_constants
  use sig_model, only: model_t
  use sig_online_model, only: online_model_t
  use sig_petsc_support, only: max_over_ranks, sum_over_ranks
  use sig_point_batches, only: deal_points, point_batches_t
  use sig_problem, only: body_at, problem_t
  use sig_progress, only: progress_t
  use sig_answer, only: answer_t
  use sig_answer_errors, only: comparison_t, negligible_share
  use sig_query, only: query_t
  use sig_reasons, only: reason_converged
  use sig_rounding, only: rounding
  use sig_statistics, only: summarize, statistics_t
  use sig_stop_request, only: agree_to_stop
  use sig_term_values, only: evaluate_points
  use petsc
  implicit none(type, external)
  private
  public :: validate, validation_t, n_errors, n_usual_errors, error_names

  !> number of errors, and of those that do not need materials that flow
  integer, parameter :: n_errors = 15, n_usual_errors = 12
  !> number of comparisons of a point (point_errors_t)
  integer, parameter :: n_comparisons = 13
  !> rows of the table that ranks share, of which each point has a column: differences, sizes and other numbers
  integer, parameter :: n_others = 2 * n_comparisons
  integer, parameter :: n_columns = n_others + 13
  !> columns of validation.csv
  character(*), parameter :: error_names(n_errors) = [character(22) :: 'e_u', 'e_lambda_rid', 'e_lambda_all', 'e_energy', &
    'e_energy_rid', 'e_energy_relative', 'e_energy_rid_relative', 'e_u_energy', 'e_u_energy_relative', 'e_von_mises_largest', &
    'e_von_mises', 'e_pressure', 'e_lambda_raw', 'e_plastic_strain', 'e_creep_strain']

  !> The results of a validation at all test points.
  type :: validation_t
    !> shape (n_parameters, n_points)
    real(rk), allocatable :: points(:, :)
    !> rows as in error_names, in the units of point_errors_t, shape (n_errors, n_points). Strains are relative to the largest of
    !> their history, but to no less than least_share of the largest of all. All errors are NaN where the full order has no
    !> solution. Where the model has no answer (method 0), all are infinite, except that errors of displacements and energies
    !> stay NaN if the model has no displacements
    real(rk), allocatable :: errors(:, :)
    !> kind of the model that answered
    character(:), allocatable :: model_kind
    !> whether the model gives the displacements of all dofs, and whether it keeps the data for fields (reduction.fields)
    logical :: has_displacements = .false.
    logical :: has_fields = .false.
    !> number of states of a history where materials flow, 0 where none flows; then `histories` has errors of histories
    integer :: n_times = 0
    type(history_errors_t) :: histories
    !> false if the deck has no contact
    logical :: has_contact = .true.
    !> cluster that the model chooses; this array and all arrays below have shape (n_points)
    integer, allocatable :: cluster(:)
    !> active pairs in the reduced domain of the model, and all active pairs of the full-order solution
    integer, allocatable :: n_active(:)
    integer, allocatable :: n_active_full_order(:)
    !> method of the answer; 0 = there is no answer
    integer, allocatable :: method(:)
    !> number of solutions that the query found: 0 without an answer; 2 if the reduced problem has several
    integer, allocatable :: n_solutions(:)
    !> reason of the full-order solution
    integer, allocatable :: reason_full_order(:)
    !> [-] certificate of the answer; negative: there is none
    real(rk), allocatable :: error_bound(:)
    !> [-] certificate of the displacement; negative: there is none
    real(rk), allocatable :: displacement_bound(:)
    !> [-] error_estimate of the answers; no_bound without one
    real(rk), allocatable :: error_estimate(:)
    !> [rad] largest rotation of a body that only contact holds, over all full-order solutions
    real(rk) :: rotation = 0
    !> [-] largest deformation of a body, over all full-order solutions
    real(rk) :: deformation = 0
    !> the model's fallback answered
    logical, allocatable :: is_fallback(:)
    !> a signal ended the validation; the values of some points are missing
    logical :: is_stopped = .false.
    !> [s] wall time of the full-order solver: of its setup, and per point (median)
    real(rk) :: setup_seconds = 0
    real(rk) :: full_order_seconds = 0
    type(benchmark_t) :: benchmark
  end type validation_t

contains

  !> Solves the full-order problem at the points and compares the answers of the model with the solutions. Collective on all ranks;
  !> the result is the same on each, except for setup_seconds. A signal ends it early (outcome%is_stopped), without the benchmark.
  !>
  !> Errors: the model cannot answer (an internal error).
  subroutine validate(problem, team, model, points, has_benchmark, outcome, error, ierr)
    type(problem_t), intent(in) :: problem
    !> shares out the points
    type(team_t), intent(inout) :: team
    type(model_t), intent(in) :: model
    !> shape (n_parameters, n_points), checked
    real(rk), intent(in) :: points(:, :)
    !> the benchmark is run, too
    logical, intent(in) :: has_benchmark
    type(validation_t), intent(out) :: outcome
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(online_model_t) :: online
    type(query_t) :: query
    character(:), allocatable :: message
    real(rk) :: table(n_columns, size(points, 2))

    ierr = 0
    outcome%points = points
    outcome%model_kind = model%parts(1)%reduced%kind()
    outcome%has_displacements = gives_displacements(model)
    outcome%has_fields = model%fields%is_there()
    outcome%has_contact = size(problem%deck%contact) > 0
    if (problem%flow%is_there()) outcome%n_times = problem%deck%history%states%n_times()
    online%model = model
    call online%prepare(message)
    if (.not. allocated(message)) call query%create(online, message)
    if (allocated(message)) then
      call make_error(error, 'the model cannot answer: ' // message, problem%deck%path, exit_code=exit_internal)
      return
    end if
    PetscCall(team%make_ready(problem, ierr))
    outcome%setup_seconds = team%solver%setup_seconds
    PetscCall(compare_points(problem, team, online, query, points, outcome%is_stopped, table, error, ierr))
    if (allocated(error)) return
    call unpack_table(table, outcome)
    if (has_benchmark .and. .not. outcome%is_stopped) then
      PetscCall(run_benchmark(problem, team%groups, online, query, points, outcome%benchmark, ierr))
    end if
    call query%destroy()
  end subroutine validate

  !> Whether each cluster of the model gives the displacements of all dofs.
  pure logical function gives_displacements(model)
    type(model_t), intent(in) :: model
    integer :: i

    gives_displacements = all([(model%parts(i)%reduced%has_displacement() .and. &
      model%parts(i)%reduced%has_whole_field(model%n_dofs), i=1, model%n_clusters())])
  end function gives_displacements

  !> Fills one column of the table per point. Each group of ranks solves its share of the points, as many at once as the solver
  !> takes; then all ranks get the whole table. Collective on all ranks. Errors: those of create_field_map.
  subroutine compare_points(problem, team, online, query, points, is_stopped, table, error, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> a signal ended the loop of some group
    logical, intent(out) :: is_stopped
    !> columns of table_column, 0 at points that a signal left out; shape (n_columns, n_points)
    real(rk), intent(out) :: table(:, :)
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(progress_t) :: progress
    type(point_batches_t) :: own
    type(measured_bodies_t) :: bodies
    real(rk) :: flag
    integer :: first, i, last

    ierr = 0
    table = 0
    is_stopped = .false.
    call create_bodies(problem, online, bodies)
    if (team%groups%is_leader()) call create_field_map(problem, bodies%fields, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    if (allocated(error)) return
    call deal_points(varying_constants(problem%deck, problem%material_terms, points), team%groups%i_group, &
      team%groups%n_groups, team%solver%n_points_at_once(), team%solver%n_times(), own)
    call progress%start('validating', size(points, 2))
    last = 0
    do i = 1, size(own%ends)
      PetscCall(agree_to_stop(team%groups%comm, is_stopped, ierr))
      if (is_stopped) exit
      first = last + 1
      last = own%ends(i)
      PetscCall(compare_batch(problem, bodies, online, query, team, points, own%points(first:last), table, ierr))
      call progress%advance(min(last * team%groups%n_groups, size(points, 2)))
    end do
    call progress%finish()
    flag = merge(1.0_rk, 0.0_rk, is_stopped)
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, flag, ierr))
    is_stopped = flag > 0
    do i = 1, size(table, 2)
      PetscCall(sum_over_ranks(PETSC_COMM_WORLD, table(:, i), ierr))
    end do
  end subroutine compare_points

  !> Prepares the computation of energies of all bodies and of the reduced domain of each cluster, with the elastic constants of
  !> problem%body. Local.
  subroutine create_bodies(problem, online, bodies)
    type(problem_t), intent(in) :: problem
    type(online_model_t), intent(in) :: online
    type(measured_bodies_t), intent(out) :: bodies

    allocate (bodies%domains(online%model%n_clusters()))
    call measure_with(problem, online, problem%body, bodies)
  end subroutine create_bodies

  !> Sets the elastic constants, those of `body`, with which `bodies` measures energies. Local. Requires: bodies%domains has its
  !> size.
  subroutine measure_with(problem, online, body, bodies)
    type(problem_t), intent(in) :: problem
    type(online_model_t), intent(in) :: online
    type(elastic_body_t), intent(in) :: body
    type(measured_bodies_t), intent(inout) :: bodies
    integer :: i

    do i = 1, size(bodies%domains)
      associate (cells => online%model%parts(i)%reduced%cells(), domain => bodies%domains(i))
        call domain%stiffness%create(problem%mesh, body, cells)
        call domain%imposed%create(problem%mesh, body, problem%strains, cells)
      end associate
    end do
    call bodies%whole%imposed%create(problem%mesh, body, problem%strains, [(i, i=1, problem%mesh%n_cells)])
  end subroutine measure_with

  !> Sets in `bodies` the values of the terms of imposed strains and fields at points that share a stiffness, and, if the stiffness
  !> depends on the parameters, the elastic constants, those of the first of these points. Local.
  subroutine update_bodies(problem, online, points, bodies)
    type(problem_t), intent(in) :: problem
    type(online_model_t), intent(in) :: online
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(measured_bodies_t), intent(inout) :: bodies
    type(elastic_body_t) :: body
    integer :: i_bad_point, i_bad_source

    call evaluate_points(problem%strains%terms, points, bodies%strain_theta, i_bad_point, i_bad_source)
    if (bodies%fields%is_there()) call evaluate_points(bodies%fields%terms, points, bodies%field_theta, i_bad_point, i_bad_source)
    if (problem%has_fixed_stiffness) return
    call body_at(problem, points(:, 1), body)
    call measure_with(problem, online, body, bodies)
  end subroutine update_bodies

  !> Solves the points of one batch, which share a stiffness, and compares the answers with the solutions. The leader fills their
  !> columns of the table; other ranks leave it as it is. Collective on the team's group.
  subroutine compare_batch(problem, bodies, online, query, team, points, numbers, table, ierr)
    type(problem_t), intent(in) :: problem
    type(measured_bodies_t), intent(inout) :: bodies
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    type(team_t), intent(inout) :: team
    !> all, shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> those of the batch, 1-based
    integer, intent(in) :: numbers(:)
    !> shape (n_columns, n_points)
    real(rk), intent(inout) :: table(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(contact_state_t) :: states(size(numbers))
    type(answer_t) :: answers(size(numbers))
    type(point_errors_t) :: errors(size(numbers))
    integer :: i

    PetscCall(team%solver%solve_points(problem, points(:, numbers), states, ierr))
    do i = 1, size(numbers)
      call query%continue(online, points(:, numbers(i)), answers(i))
    end do
    call update_bodies(problem, online, points(:, numbers), bodies)
    PetscCall(measure_errors(team%solver%system, bodies, online, answers, states, errors, ierr))
    if (.not. team%groups%is_leader()) return
    do i = 1, size(numbers)
      table(:, numbers(i)) = table_column(answers(i), states(i), errors(i), &
        count(problem%laws%are_closed(states(i)%multipliers)), largest_rotation(problem%motions, states(i:i)), &
        largest_deformation(problem%motions, states(i:i)))
    end do
  end subroutine compare_batch

  !> Returns the numbers of a point that ranks share, in the order in which unpack_table takes them.
  pure function table_column(answer, state, errors, n_closed, rotation, deformation) result(column)
    type(answer_t), intent(in) :: answer
    type(contact_state_t), intent(in) :: state
    type(point_errors_t), intent(in) :: errors
    !> number of contacts that are closed in the full-order solution
    integer, intent(in) :: n_closed
    !> [rad] largest_rotation and [-] largest_deformation of the full-order solution
    real(rk), intent(in) :: rotation
    real(rk), intent(in) :: deformation
    real(rk) :: column(n_columns)
    type(comparison_t) :: comparisons(n_comparisons)

    comparisons = [errors%displacement, errors%multipliers_rid, errors%multipliers_all, errors%energy, errors%energy_rid, &
      errors%field, errors%von_mises_largest, errors%von_mises, errors%pressure, errors%raw_forces, errors%plastic_strain, &
      errors%creep_strain, errors%correction]
    column = [comparisons%difference, comparisons%size, real(answer%cluster, rk), real(count(answer%is_active), rk), &
      real(n_closed, rk), real(merge(answer%method, 0, answer%reason > 0), rk), real(state%reason, rk), &
      state%seconds, real(answer%n_solutions, rk), answer%relative_bound, &
      real(merge(1, 0, answer%reason > 0 .and. answer%part /= answer%cluster), rk), answer%relative_displacement_bound, rotation, &
      deformation, answer%error_estimate]
  end function table_column

  !> Sets the arrays of the outcome except for the points, the errors to NaN where there is no full-order solution and to infinite
  !> where there is no answer, and full_order_seconds, the median over the points that converged (0 without such points).
  subroutine unpack_table(table, outcome)
    !> columns of table_column, shape (n_columns, n_points)
    real(rk), intent(in) :: table(:, :)
    type(validation_t), intent(inout) :: outcome
    type(statistics_t) :: seconds
    integer :: i

    outcome%cluster = nint(table(n_others + 1, :))
    outcome%n_active = nint(table(n_others + 2, :))
    outcome%n_active_full_order = nint(table(n_others + 3, :))
    outcome%method = nint(table(n_others + 4, :))
    outcome%reason_full_order = nint(table(n_others + 5, :))
    call relate_errors(table(:n_others, :), outcome%n_times, outcome%reason_full_order == reason_converged, outcome%errors)
    if (outcome%n_times > 0) call compare_histories(table(:n_others, :), outcome)
    do i = 1, size(table, 2)
      if (outcome%method(i) == 0) call fail_point(outcome%errors(:, i))
      ! without a full-order solution there is nothing to compare with
      if (outcome%reason_full_order(i) /= reason_converged) outcome%errors(:, i) = ieee_value(1.0_rk, ieee_quiet_nan)
    end do
    outcome%n_solutions = nint(table(n_others + 7, :))
    outcome%error_bound = table(n_others + 8, :)
    outcome%is_fallback = table(n_others + 9, :) > 0
    outcome%displacement_bound = table(n_others + 10, :)
    outcome%error_estimate = table(n_others + 13, :)
    outcome%rotation = maxval([0.0_rk, table(n_others + 11, :)])
    outcome%deformation = maxval([0.0_rk, table(n_others + 12, :)])
    seconds = summarize(pack(table(n_others + 6, :), outcome%reason_full_order == reason_converged))
    outcome%full_order_seconds = seconds%median
  end subroutine unpack_table

  !> Computes the errors of all points from their comparisons. A size is negligible below a share of the largest one at all points
  !> with a full-order solution; for the forces of the reduced domain, of all forces. The share is negligible_share, and 1e-12 for
  !> energies, which is rounding where a body moves as a whole. Strains are related to the largest ones of their history.
  pure subroutine relate_errors(table, n_times, is_solved, errors)
    !> differences, then sizes, as in table_column; shape (2 * n_comparisons, n_points)
    real(rk), intent(in) :: table(:, :)
    !> as in validation_t
    integer, intent(in) :: n_times
    !> the point has a full-order solution, shape (n_points)
    logical, intent(in) :: is_solved(:)
    !> rows as in error_names, shape (n_errors, n_points)
    real(rk), allocatable, intent(out) :: errors(:, :)
    type(comparison_t) :: comparisons(n_comparisons)
    real(rk) :: floors(n_comparisons), relative(n_comparisons), shares(n_comparisons), strains(2, size(table, 2))
    integer :: i

    do i = 1, n_comparisons
      floors(i) = max(0.0_rk, maxval(table(n_comparisons + i, :), mask=is_solved))
    end do
    floors(2) = floors(3)
    shares = negligible_share
    shares(4:5) = rounding
    shares(11:12) = least_share
    floors = floors * shares
    strains = 0
    do i = 1, 2
      if (n_times > 0) strains(i, :) = largest_of_history(table(n_comparisons + 10 + i, :), n_times, is_solved)
    end do
    allocate (errors(n_errors, size(table, 2)))
    do i = 1, size(table, 2)
      comparisons%difference = table(:n_comparisons, i)
      comparisons%size = table(n_comparisons + 1:, i)
      comparisons(11:12)%size = strains(:, i)
      relative = comparisons%relative(floors)
      ! a field that vanishes in both models is right; that of forces says by NaN that nothing touches
      where (comparisons(6:8)%difference <= 0 .and. comparisons(6:8)%size <= 0) relative(6:8) = 0
      where (comparisons(11:12)%difference <= 0 .and. comparisons(11:12)%size <= 0) relative(11:12) = 0
      errors(:, i) = [relative(:3), comparisons(4:5)%difference, relative(4:5), comparisons(6)%difference, relative(6:12)]
    end do
  end subroutine relate_errors

  !> Computes the errors of whole histories. Requires: materials flow.
  pure subroutine compare_histories(table, outcome)
    !> as for relate_errors
    real(rk), intent(in) :: table(:, :)
    !> in: all arrays that say which points have solutions and answers
    type(validation_t), intent(inout) :: outcome

    associate (histories => outcome%histories)
      histories%forces = errors_of(3)
      histories%displacement = errors_of(6)
      histories%stress = errors_of(8)
      histories%raw_forces = errors_of(10)
      histories%plastic_strain = errors_of(11)
      histories%creep_strain = errors_of(12)
      histories%estimate = errors_of(13)
    end associate

  contains

    pure function errors_of(i) result(errors)
      !> position among the comparisons of a point
      integer, intent(in) :: i
      real(rk) :: errors(size(table, 2) / outcome%n_times)

      errors = over_histories(table(i, :), table(n_comparisons + i, :), outcome%n_times, &
        outcome%reason_full_order == reason_converged, outcome%method > 0)
    end function errors_of
  end subroutine compare_histories

  !> Sets the errors of a point without an answer to infinite. Those that are NaN stay so, except for errors of contact: the model
  !> may have no displacement to compare.
  pure subroutine fail_point(errors)
    !> as in error_names
    real(rk), intent(inout) :: errors(n_errors)

    where (.not. ieee_is_nan(errors) .or. error_names(:) (:8) == 'e_lambda' .or. error_names == 'e_pressure') errors = &
      ieee_value(1.0_rk, ieee_positive_inf)
  end subroutine fail_point
end module sig_validation
