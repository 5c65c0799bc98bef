! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Solutions of the condensed problem at training points and at probes, at which training measures the error of displacements.
module sig_contact_states
  use sig_answer, only: answer_t, comparable_size
  use sig_condensed_model, only: condensed_model_t
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_kinds, only: rk
  use sig_petsc_support, only: rank_and_size, sum_over_ranks
  use sig_probe_points, only: find_probes
  use sig_problem, only: problem_t
  use sig_progress, only: progress_t
  use sig_reduced, only: room_t
  use sig_term_values, only: evaluate_points
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: contact_states_t

  type :: contact_states_t
    !> [force] z, with 0 at anchors; shape (n_multipliers, n_states)
    real(rk), allocatable :: unknowns(:, :)
    !> [force*length] z'C z, shape (n_states)
    real(rk), allocatable :: energies(:)
    !> [sqrt(force*length)] size of the displacement to which errors are relative, shape (n_states)
    real(rk), allocatable :: sizes(:)
    !> whether the state may be used to choose modes, shape (n_states)
    logical, allocatable :: is_for_modes(:)
  contains
    procedure :: find
    procedure :: largest_error
  end type contact_states_t

  !> [s] progress is told only if the states take longer
  real(rk), parameter :: seconds_of_silence = 3

contains

  !> Finds the states: the training points, then the probes if they are wanted. Points without an answer are left out. Also sets
  !> reduced%compliance%largest_field, the largest size of the displacement at the training points. Each rank solves some of the
  !> points. Collective on all ranks, with the same result on each. Requires: `reduced` answers queries and is the same on all
  !> ranks.
  subroutine find(self, problem, snapshots, has_probes, reduced, ierr)
    class(contact_states_t), intent(out) :: self
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    logical, intent(in) :: has_probes
    type(condensed_model_t), intent(inout) :: reduced
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: at_points(:, :), at_probes(:, :), theta(:, :)
    integer, allocatable :: nearest(:), solved(:)
    integer :: i, i_bad_point, i_bad_source, n_points

    call evaluate_points(problem%terms, snapshots%parameters, at_points, i_bad_point, i_bad_source)
    n_points = size(at_points, 2)
    if (has_probes) then
      call find_probes(problem, snapshots%parameters, at_probes, nearest)
    else
      allocate (at_probes(size(at_points, 1), 0), nearest(0))
    end if
    theta = reshape([at_points, at_probes], [size(at_points, 1), n_points + size(nearest)])
    nearest = [[(i, i=1, n_points)], nearest]
    PetscCall(solve(reduced, theta, nearest, self, ierr))
    reduced%compliance%largest_field = maxval([reduced%compliance%largest_field, self%sizes(:n_points)])
    solved = pack([(i, i=1, size(self%sizes))], self%sizes >= 0)
    self%unknowns = self%unknowns(:, solved)
    self%energies = self%energies(solved)
    self%is_for_modes = solved <= n_points .or. modulo(solved, 2) == 0
    self%sizes = [(max(comparable_size(self%sizes(solved(i)), reduced%compliance%largest_field), tiny(1.0_rk)), i=1, size(solved))]
  end subroutine find

  !> Solves the points, and sets the unknowns, energies and sizes of all; without an answer the size is -1. Collective on all ranks.
  subroutine solve(reduced, theta, nearest, states, ierr)
    type(condensed_model_t), intent(inout) :: reduced
    !> [-] values of the terms at each point, shape (n_terms, n_points)
    real(rk), contiguous, intent(in) :: theta(:, :)
    !> training point nearest to each point, shape (n_points)
    integer, intent(in) :: nearest(:)
    class(contact_states_t), intent(inout) :: states
    PetscErrorCode, intent(out) :: ierr
    class(room_t), allocatable :: room
    type(answer_t) :: answer
    type(progress_t) :: progress
    integer :: i, n_ranks, rank

    PetscCall(rank_and_size(PETSC_COMM_WORLD, rank, n_ranks, ierr))
    call reduced%compliance%prepare()
    call reduced%create_room(room)
    allocate (states%unknowns(reduced%n_rows(), size(nearest)), states%energies(size(nearest)), states%sizes(size(nearest)), &
              source=0.0_rk)
    call progress%start('points at which the error of displacements is measured', size(nearest), seconds_of_silence)
    do i = rank + 1, size(nearest), n_ranks
      call reduced%ask(theta(:, i), nearest(i), room, answer)
      call progress%advance(min(i + n_ranks - 1, size(nearest)))
      states%sizes(i) = -1
      if (answer%reason <= 0) cycle
      states%unknowns(:, i) = reduced%compliance%with_closed_anchors(answer%unknowns)
      states%energies(i) = reduced%size_of_forces(room, answer%unknowns)**2
      states%sizes(i) = reduced%size_of_field(room, theta(:, i), answer%unknowns)
    end do
    call progress%finish()
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, states%unknowns, ierr))
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, states%energies, ierr))
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, states%sizes, ierr))
  end subroutine solve

  !> [-] Returns the largest error of the displacement of all states, by the field's own figure, relative to their sizes. Local.
  real(rk) function largest_error(self, fixed) result(error)
    class(contact_states_t), intent(in) :: self
    type(fixed_compliance_t), intent(in) :: fixed
    integer :: i

    error = maxval([0.0_rk, [(fixed%field%error_of(self%unknowns(:, i), self%energies(i)) / &
      self%sizes(i), i=1, size(self%sizes))]])
  end function largest_error
end module sig_contact_states
