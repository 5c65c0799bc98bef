! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Compares the time of a query with that of a full-order solution. It runs with --benchmark only, because it factors the stiffness
!> many times.
module sig_benchmark
  use sig_clock, only: wall_time
  use sig_contact_state, only: contact_state_t
  use sig_kinds, only: rk
  use sig_online_model, only: online_model_t
  use sig_petsc_support, only: max_over_ranks
  use sig_point_solver, only: point_solver_t
  use sig_problem, only: problem_t
  use sig_answer, only: answer_t
  use sig_query, only: query_t
  use sig_rank_groups, only: rank_groups_t
  use sig_solver_plan, only: solver_plan_t
  use sig_statistics, only: summarize, statistics_t
  use petsc
  implicit none(type, external)
  private
  public :: benchmark_t, run_benchmark

  !> The times that a benchmark measured.
  type :: benchmark_t
    !> the benchmark was run
    logical :: is_done = .false.
    !> [s] wall time of the active set method per point (median); 0 where contacts have friction, which it cannot solve
    real(rk) :: refactored_seconds = 0
    !> [s] wall time of a query (the largest mean of a rank)
    real(rk) :: query_seconds = 0
  end type benchmark_t

  !> largest number of points on which the refactored solver is timed
  integer, parameter :: n_timed_points = 5
  !> [s] least time over which the queries are repeated
  real(rk), parameter :: query_time = 0.2_rk

contains

  !> Measures the mean time of a query over all points (the largest of all ranks), and, without friction, the median time of the
  !> active set method, which solves each point anew on the whole mesh, at up to 5 of the points. Collective on all ranks; the
  !> result is the same on each. Requires: one point or more.
  subroutine run_benchmark(problem, groups, online, query, points, benchmark, ierr)
    type(problem_t), intent(in) :: problem
    type(rank_groups_t), intent(in) :: groups
    !> prepared
    type(online_model_t), intent(in) :: online
    !> created for the model
    type(query_t), intent(inout) :: query
    !> shape (n_parameters, n_points); the states of a history follow each other
    real(rk), intent(in) :: points(:, :)
    type(benchmark_t), intent(out) :: benchmark
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (.not. problem%laws%remembers()) then
      PetscCall(time_refactored(problem, groups, points, benchmark%refactored_seconds, ierr))
    end if
    call time_queries(online, query, points, benchmark%query_seconds)
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, benchmark%query_seconds, ierr))
    benchmark%is_done = .true.
  end subroutine run_benchmark

  !> Measures the time of a point without condensation: the active set method solves on the whole mesh in each step, by the linear
  !> solver of the plan. The first group measures up to 5 points, spread evenly over all, or one history of materials that flow; all
  !> ranks get the median. Collective on all ranks.
  subroutine time_refactored(problem, groups, points, median, ierr)
    type(problem_t), intent(in) :: problem
    type(rank_groups_t), intent(in) :: groups
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> [s] wall time per point
    real(rk), intent(out) :: median
    PetscErrorCode, intent(out) :: ierr
    type(point_solver_t) :: solver
    type(solver_plan_t) :: plan
    type(statistics_t) :: seconds
    type(contact_state_t), allocatable :: states(:)
    real(rk) :: times(n_timed_points)
    integer :: first, i, n, n_histories

    median = 0
    ierr = 0
    if (groups%i_group == 1) then
      plan = problem%plan
      plan%type = 'active_set'
      PetscCall(solver%create(problem, plan, groups%comm, ierr))
      n = solver%n_times()
      allocate (states(n))
      n_histories = min(merge(n_timed_points, 1, n == 1), size(points, 2) / n)
      do i = 1, n_histories
        first = 1 + (i - 1) * (size(points, 2) - 1) / max(1, n_histories - 1)
        PetscCall(solver%solve_history(problem, points(:, first:first + n - 1), states, ierr))
        times(i) = sum(states%seconds) / n
      end do
      PetscCall(solver%destroy(ierr))
      seconds = summarize(times(:n_histories))
      median = seconds%median
    end if
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, median, ierr))
  end subroutine time_refactored

  !> Measures the mean time of a query over all points, which are asked again and again for at least 0.2 s. Local. Requires: one
  !> point or more.
  subroutine time_queries(online, query, points, seconds)
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> [s] wall time per query
    real(rk), intent(out) :: seconds
    type(answer_t) :: answer
    real(rk) :: start
    integer :: i, n_queries

    n_queries = 0
    start = wall_time()
    do while (wall_time() - start < query_time)
      do i = 1, size(points, 2)
        call query%continue(online, points(:, i), answer)
      end do
      n_queries = n_queries + size(points, 2)
    end do
    seconds = (wall_time() - start) / n_queries
  end subroutine time_queries
end module sig_benchmark
