! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The model against the full-order model at the test points: errors of each, their statistics, times of both.
module sig_validation
  use sig_clock, only: wall_time
  use sig_contact_state, only: contact_state_t, reason_converged
  use sig_domain_energy, only: domain_energy_t
  use sig_error_norms, only: measure_errors, point_errors_t
  use sig_errors, only: error_t, exit_internal, make_error
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_online_model, only: online_model_t
  use sig_full_order, only: team_t
  use sig_point_solver, only: point_solver_t
  use sig_problem, only: problem_t
  use sig_progress, only: progress_t
  use sig_query, only: answer_t, query_t
  use sig_rank_groups, only: rank_groups_t
  use sig_signals, only: is_stop_requested
  use sig_solver_plan, only: solver_plan_t
  use sig_statistics, only: summarize, statistics_t
  use sig_petsc_support, only: max_over_ranks, sum_over_ranks
  use petsc
  implicit none(type, external)
  private
  public :: validate, validation_t, n_errors, error_names

  integer, parameter :: n_errors = 7
  !> columns of validation.csv
  character(*), parameter :: error_names(n_errors) = [character(22) :: 'e_u', 'e_lambda_rid', 'e_lambda_all', 'e_energy', &
    'e_energy_rid', 'e_energy_relative', 'e_energy_rid_relative']
  !> largest number of points on which the refactored solver is timed
  integer, parameter :: n_timed_points = 5
  !> [s] least time over which the queries are repeated
  real(rk), parameter :: query_time = 0.2_rk

  type :: validation_t
    !> shape (n_parameters, n_points)
    real(rk), allocatable :: points(:, :)
    !> shape (n_errors, n_points), rows as in error_names
    real(rk), allocatable :: errors(:, :)
    !> shape (n_points); active pairs of the reduced model are those of its domain
    integer, allocatable :: cluster(:)
    integer, allocatable :: n_active(:)
    integer, allocatable :: n_active_full_order(:)
    !> method of the answer (0 = there is none), and reason of the full-order solve
    integer, allocatable :: method(:)
    !> that the answer's two starts found
    integer, allocatable :: n_solutions(:)
    integer, allocatable :: reason_full_order(:)
    logical :: is_stopped = .false.
    !> [s] wall time: the deck's solver once and per point (median), refactored active set per point (median), a query (mean)
    real(rk) :: setup_seconds = 0
    real(rk) :: full_order_seconds = 0
    real(rk) :: refactored_seconds = 0
    real(rk) :: query_seconds = 0
  end type validation_t

contains

  !> Collective on all ranks; the result is the same on each.
  subroutine validate(problem, team, model, points, outcome, error, ierr)
    type(problem_t), intent(in) :: problem
    !> shares out the points
    type(team_t), intent(inout) :: team
    type(model_t), intent(in) :: model
    !> shape (n_parameters, n_points), checked
    real(rk), intent(in) :: points(:, :)
    type(validation_t), intent(out) :: outcome
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(online_model_t) :: online
    type(query_t) :: query
    character(:), allocatable :: message
    real(rk) :: table(n_errors + 7, size(points, 2))

    ierr = 0
    outcome%points = points
    online%model = model
    call online%prepare(message)
    if (.not. allocated(message)) call query%create(online, message)
    if (allocated(message)) then
      call make_error(error, 'the model cannot answer: ' // message, problem%deck%path, exit_code=exit_internal)
      return
    end if
    PetscCall(team%make_ready(problem, ierr))
    outcome%setup_seconds = team%solver%setup_seconds
    PetscCall(compare_points(problem, team%groups, online, query, team%solver, points, outcome%is_stopped, table, ierr))
    if (outcome%is_stopped) then
      call query%destroy()
      return
    end if
    call unpack_table(table, outcome)
    PetscCall(time_refactored(problem, team%groups, points, outcome%refactored_seconds, ierr))
    call time_queries(online, query, points, outcome%query_seconds)
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, outcome%query_seconds, ierr))
    call query%destroy()
  end subroutine validate

  !> One column of the table per point, filled by the leader of the group that solved it.
  subroutine compare_points(problem, groups, online, query, solver, points, is_stopped, table, ierr)
    type(problem_t), intent(in) :: problem
    type(rank_groups_t), intent(in) :: groups
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    type(point_solver_t), intent(inout) :: solver
    real(rk), intent(in) :: points(:, :)
    logical, intent(out) :: is_stopped
    real(rk), intent(out) :: table(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(progress_t) :: progress
    type(domain_energy_t) :: domains(size(online%model%clusters))
    real(rk) :: flag, column(size(table, 1))
    integer :: i

    ierr = 0
    table = 0
    flag = 0
    do i = 1, size(domains)
      call domains(i)%create(problem%mesh, problem%body, online%model%clusters(i)%cells)
    end do
    call progress%start('validating', size(points, 2))
    do i = 1, size(points, 2)
      if (groups%has_point(i)) then
        flag = merge(1.0_rk, 0.0_rk, is_stop_requested())
        PetscCall(max_over_ranks(groups%comm, flag, ierr))
        if (flag > 0) exit
        PetscCall(compare_point(problem, domains, online, query, solver, points(:, i), column, ierr))
        if (groups%is_leader()) table(:, i) = column
      end if
      call progress%advance(i)
    end do
    call progress%finish()
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, flag, ierr))
    is_stopped = flag > 0
    do i = 1, size(table, 2)
      PetscCall(sum_over_ranks(PETSC_COMM_WORLD, table(:, i), ierr))
    end do
  end subroutine compare_points

  subroutine compare_point(problem, domains, online, query, solver, point, column, ierr)
    type(problem_t), intent(in) :: problem
    !> cells of each cluster's domain
    type(domain_energy_t), intent(in) :: domains(:)
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    type(point_solver_t), intent(inout) :: solver
    real(rk), intent(in) :: point(:)
    real(rk), intent(out) :: column(:)
    PetscErrorCode, intent(out) :: ierr
    type(contact_state_t) :: state
    type(answer_t) :: answer
    type(point_errors_t) :: errors

    PetscCall(solver%solve(problem, point, state, ierr))
    call query%evaluate(online, point, answer)
    PetscCall(measure_errors(solver%system, domains(answer%cluster), online, answer, state, errors, ierr))
    column = [errors%displacement, errors%multipliers_rid, errors%multipliers_all, errors%energy, errors%energy_rid, &
      errors%energy_relative, errors%energy_rid_relative, real(answer%cluster, rk), real(count(answer%is_active), rk), &
      real(count(state%multipliers > 0), rk), &
      real(merge(answer%method, 0, answer%reason > 0), rk), real(state%reason, rk), state%seconds, &
      real(answer%n_solutions, rk)]
  end subroutine compare_point

  subroutine unpack_table(table, outcome)
    real(rk), intent(in) :: table(:, :)
    type(validation_t), intent(inout) :: outcome
    type(statistics_t) :: seconds

    outcome%errors = table(:n_errors, :)
    outcome%cluster = nint(table(n_errors + 1, :))
    outcome%n_active = nint(table(n_errors + 2, :))
    outcome%n_active_full_order = nint(table(n_errors + 3, :))
    outcome%method = nint(table(n_errors + 4, :))
    outcome%reason_full_order = nint(table(n_errors + 5, :))
    outcome%n_solutions = nint(table(n_errors + 7, :))
    seconds = summarize(pack(table(n_errors + 6, :), outcome%reason_full_order == reason_converged))
    outcome%full_order_seconds = seconds%median
  end subroutine unpack_table

  !> What a point costs without condensation: an active set that factors at every step. The first group measures.
  subroutine time_refactored(problem, groups, points, median, ierr)
    type(problem_t), intent(in) :: problem
    type(rank_groups_t), intent(in) :: groups
    real(rk), intent(in) :: points(:, :)
    real(rk), intent(out) :: median
    PetscErrorCode, intent(out) :: ierr
    type(point_solver_t) :: solver
    type(solver_plan_t) :: plan
    type(contact_state_t) :: state
    type(statistics_t) :: seconds
    real(rk) :: times(min(n_timed_points, size(points, 2)))
    integer :: i, i_point

    median = 0
    ierr = 0
    if (groups%i_group == 1) then
      plan = problem%plan
      plan%type = 'active_set'
      PetscCall(solver%create(problem, plan, groups%comm, ierr))
      do i = 1, size(times)
        i_point = 1 + (i - 1) * (size(points, 2) - 1) / max(1, size(times) - 1)
        PetscCall(solver%solve(problem, points(:, i_point), state, ierr))
        times(i) = state%seconds
      end do
      PetscCall(solver%destroy(ierr))
      seconds = summarize(times)
      median = seconds%median
    end if
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, median, ierr))
  end subroutine time_refactored

  !> Mean time of a query over all points, repeated until the clock can be trusted. Local.
  subroutine time_queries(online, query, points, seconds)
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    real(rk), intent(in) :: points(:, :)
    real(rk), intent(out) :: seconds
    type(answer_t) :: answer
    real(rk) :: start
    integer :: i, n_queries

    n_queries = 0
    start = wall_time()
    do while (wall_time() - start < query_time)
      do i = 1, size(points, 2)
        call query%evaluate(online, points(:, i), answer)
      end do
      n_queries = n_queries + size(points, 2)
    end do
    seconds = (wall_time() - start) / n_queries
  end subroutine time_queries
end module sig_validation
