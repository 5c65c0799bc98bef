! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Estimates the error of time steps where materials flow, by solving each history again with every step halved.
!>
!> Backward Euler is of first order: with the steps h, an answer q(h) = q + c h + O(h^2). So q(h) - q(h/2) = c h/2, and 2 (q(h) -
!> q(h/2)) is the error of q(h), except for O(h^2). Data in the middle of a step are the means of its ends.
module sig_time_error
  use sig_contact_state, only: contact_state_t
  use sig_errors, only: error_t
  use sig_field_map, only: field_values_t
  use sig_field_output, only: describe_problem, find_flow_values, solve_points, solved_points_t
  use sig_full_order, only: team_t
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged
  use sig_run_report, only: run_report_t
  use sig_text, only: append_text, join, short_number, string_t
  use petsc
  implicit none(type, external)
  private
  public :: time_error_t, estimate_time_error

  !> what is compared, with its key in the report
  integer, parameter :: n_quantities = 6
  character(20), parameter :: keys(n_quantities) = [character(20) :: 'contact_forces', 'support_forces', 'displacement', &
    'von_mises', 'plastic_strain', 'creep_strain']
  character(20), parameter :: names(n_quantities) = [character(20) :: 'contact forces', 'forces of supports', 'displacement', &
    'largest stress', 'plastic strain', 'creep strain']
  integer, parameter :: of_stress = 4

  !> Estimated errors, each over the largest size of its quantity at all points.
  type :: time_error_t
    !> [-] in the order of keys
    real(rk) :: errors(n_quantities) = 0
    !> whether there is such a quantity
    logical :: is_there(n_quantities) = .false.
    !> number of points at which both solutions are there
    integer :: n_points = 0
  contains
    procedure :: sentence
    procedure :: report
  end type time_error_t

contains

  !> Solves the points again by halved steps, and estimates the time error of the first solution. The estimate is that of the first
  !> rank. Collective on all ranks. Errors: those of solve_points and describe_problem.
  subroutine estimate_time_error(problem, team, points, solved, estimate, error, ierr)
    type(problem_t), intent(in) :: problem
    !> as for write_fields
    type(team_t), intent(inout) :: team
    !> shape (n_parameters, n_points), checked
    real(rk), intent(in) :: points(:, :)
    !> in: the solution by the deck's steps; is_stopped is set after a signal
    type(solved_points_t), intent(inout) :: solved
    type(time_error_t), intent(out) :: estimate
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(solved_points_t) :: halved

    team%solver%halves_steps = .true.
    PetscCall(solve_points(problem, team, points, halved, error, ierr))
    team%solver%halves_steps = .false.
    solved%is_stopped = halved%is_stopped
    if (halved%is_stopped .or. allocated(error) .or. team%groups%world_rank > 0) return
    call compare(problem, points, solved%states, halved%states, estimate, error)
  end subroutine estimate_time_error

  !> Compares both solutions. Local. Errors: those of describe_problem.
  subroutine compare(problem, points, states, halved, estimate, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> by the deck's steps, and by halved ones; shape (n_points)
    type(contact_state_t), intent(in) :: states(:), halved(:)
    type(time_error_t), intent(inout) :: estimate
    type(error_t), allocatable, intent(out) :: error
    type(model_t) :: header
    real(rk) :: differences(n_quantities), sizes(n_quantities), stresses(2)
    integer :: i

    call describe_problem(problem, header, error)
    if (allocated(error)) return
    differences = 0
    sizes = 0
    do i = 1, size(states)
      if (states(i)%reason /= reason_converged .or. halved(i)%reason /= reason_converged) cycle
      estimate%n_points = estimate%n_points + 1
      call take(1, states(i)%multipliers, halved(i)%multipliers)
      call take(2, states(i)%reactions, halved(i)%reactions)
      call take(3, states(i)%displacement, halved(i)%displacement)
      stresses = [largest_stress(problem, header, points(:, i), states(i)), &
        largest_stress(problem, header, points(:, i), halved(i))]
      call take(of_stress, stresses(:1), stresses(2:))
      associate (one => states(i)%flow, other => halved(i)%flow)
        if (problem%flow%has_plasticity) call take(5, one%plastic(7, :), other%plastic(7, :))
        if (problem%flow%has_creep) call take(6, one%creep(7, :), other%creep(7, :))
      end associate
    end do
    estimate%is_there = sizes > 0
    where (estimate%is_there) estimate%errors = 2 * differences / sizes

  contains

    subroutine take(i_quantity, one, other)
      integer, intent(in) :: i_quantity
      real(rk), intent(in) :: one(:), other(:)

      if (size(one) == 0) return
      differences(i_quantity) = max(differences(i_quantity), maxval(abs(one - other)))
      sizes(i_quantity) = max(sizes(i_quantity), maxval(abs(other)))
    end subroutine take
  end subroutine compare

  !> Returns the largest von Mises stress of a state [force/length**2], of the means over cells.
  real(rk) function largest_stress(problem, header, point, state)
    type(problem_t), intent(in) :: problem
    type(model_t), intent(in) :: header
    real(rk), intent(in) :: point(:)
    type(contact_state_t), intent(in) :: state
    type(field_values_t) :: values

    call find_flow_values(problem, header, point, state, values)
    largest_stress = maxval(values%von_mises)
  end function largest_stress

  !> Returns what is estimated: `the steps err by about 3.1 % of the contact forces, ...`.
  function sentence(self) result(text)
    class(time_error_t), intent(in) :: self
    character(:), allocatable :: text
    type(string_t), allocatable :: parts(:)
    integer :: i

    if (.not. any(self%is_there)) then
      text = 'halved steps give no estimate of the time error: at no point do both solutions exist'
      return
    end if
    allocate (parts(0))
    do i = 1, n_quantities
      if (self%is_there(i)) call append_text(parts, trim(names(i)) // ' ' // short_number(100 * self%errors(i)) // ' %')
    end do
    text = 'the deck''s steps err by about (twice the change by halved steps, over the largest value): ' // join(parts, ', ') // &
      '; half of that with halved steps'
  end function sentence

  !> Adds the estimate to the report.
  subroutine report(self, to)
    class(time_error_t), intent(in) :: self
    type(run_report_t), intent(inout) :: to
    integer :: i

    do i = 1, n_quantities
      if (self%is_there(i)) call to%add('time_error/' // trim(keys(i)), self%errors(i))
    end do
  end subroutine report
end module sig_time_error
