! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Contact forces at training points and at probes, and their changes with each parameter, at which training measures the error of
!> displacements. As these are linear in loads and forces, a change of the forces is a state like any other.
module sig_contact_states
  use sig_answer, only: answer_t, comparable_size
  use sig_condensed_model, only: condensed_model_t
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_gradient, only: gradient_t
  use sig_kinds, only: rk
  use sig_petsc_support, only: rank_and_size, sum_over_ranks
  use sig_probe_points, only: find_probes
  use sig_problem, only: problem_t
  use sig_progress, only: progress_t
  use sig_reduced, only: room_t
  use sig_term_derivatives, only: differentiate_terms, term_failure_t
  use sig_term_values, only: evaluate_points, term_values_t
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
    procedure :: measure_solutions
    procedure :: largest_error
    procedure, private :: solve
    procedure, private :: take
    procedure, private :: take_changes
  end type contact_states_t

  !> Points to solve.
  type :: points_t
    !> shape (n_parameters, n_points)
    real(rk), allocatable :: parameters(:, :)
    !> [-] values of the terms at each point, shape (n_terms, n_points)
    real(rk), allocatable :: theta(:, :)
    !> training point nearest to each point, shape (n_points)
    integer, allocatable :: nearest(:)
    !> [unit of each parameter] lengths of their ranges, 1 of none; shape (n_parameters)
    real(rk), allocatable :: lengths(:)
    !> [force] forces that are known, shape (n_multipliers, n_points); not allocated where the model finds them
    real(rk), allocatable :: forces(:, :)
  end type points_t

  !> [s] progress is told only if the states take longer
  real(rk), parameter :: seconds_of_silence = 3

contains

  !> Finds the states: at the training points, then at the probes, and at each the forces, then their change with each parameter
  !> times the length of its range. What has no answer or no derivative is left out. With friction, ties or materials that flow the
  !> states are the forces of the snapshots. Also sets reduced%compliance%largest_field, the
  !> largest size of the displacement at the training points. Collective on all ranks, with the same result on each. Requires:
  !> `reduced` answers queries and is the same on all ranks.
  subroutine find(self, problem, snapshots, reduced, ierr)
    class(contact_states_t), intent(out) :: self
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(condensed_model_t), intent(inout) :: reduced
    PetscErrorCode, intent(out) :: ierr
    type(points_t) :: points, probes
    integer, allocatable :: point_of(:), solved(:)
    integer :: i, k, n_each, n_points

    call take_training_points(problem, snapshots, points)
    n_points = size(points%nearest)
    if (allocated(points%forces)) then
      PetscCall(self%solve(problem, points, 1, reduced, ierr))
      call raise_largest_field(self%sizes, reduced)
      self%is_for_modes = [(modulo(i, 2) == 0, i=1, n_points)]
      self%sizes = max([(comparable_size(self%sizes(i), reduced%compliance%largest_field), i=1, n_points)], tiny(1.0_rk))
      return
    end if
    call find_probes(problem, snapshots%parameters, probes%parameters, probes%theta, probes%nearest)
    points%parameters = reshape([points%parameters, probes%parameters], [size(points%lengths), n_points + size(probes%nearest)])
    points%theta = reshape([points%theta, probes%theta], [size(points%theta, 1), n_points + size(probes%nearest)])
    points%nearest = [points%nearest, probes%nearest]
    n_each = 1 + size(points%lengths)
    PetscCall(self%solve(problem, points, n_each, reduced, ierr))
    call raise_largest_field(self%sizes(:n_each * n_points:n_each), reduced)
    point_of = [((i, k=1, n_each), i=1, size(points%nearest))]
    solved = pack([(i, i=1, size(self%sizes))], self%sizes >= 0)
    self%unknowns = self%unknowns(:, solved)
    self%energies = self%energies(solved)
    self%is_for_modes = point_of(solved) <= n_points .or. modulo(point_of(solved), 2) == 0
    self%sizes = [(max(comparable_size(self%sizes(solved(i)), reduced%compliance%largest_field), tiny(1.0_rk)), i=1, size(solved))]
  end subroutine find

  !> Sets reduced%compliance%largest_field, the largest size of the displacement at the training points; the states are only those
  !> of the forces there. Collective on all ranks. Requires: as for `find`.
  subroutine measure_solutions(self, problem, snapshots, reduced, ierr)
    class(contact_states_t), intent(out) :: self
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(condensed_model_t), intent(inout) :: reduced
    PetscErrorCode, intent(out) :: ierr
    type(points_t) :: points

    call take_training_points(problem, snapshots, points)
    PetscCall(self%solve(problem, points, 1, reduced, ierr))
    call raise_largest_field(self%sizes, reduced)
  end subroutine measure_solutions

  subroutine take_training_points(problem, snapshots, points)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(points_t), intent(out) :: points
    integer :: i, i_bad_point, i_bad_source

    points%parameters = snapshots%parameters
    call evaluate_points(problem%terms, points%parameters, points%theta, i_bad_point, i_bad_source)
    points%nearest = [(i, i=1, size(points%theta, 2))]
    points%lengths = problem%deck%state_parameters%maximum - problem%deck%state_parameters%minimum
    where (.not. points%lengths > 0) points%lengths = 1
    if (problem%remembers() .or. .not. problem%laws%is_plain()) points%forces = snapshots%forces()
  end subroutine take_training_points

  subroutine raise_largest_field(sizes, reduced)
    !> -1 without an answer
    real(rk), intent(in) :: sizes(:)
    type(condensed_model_t), intent(inout) :: reduced

    reduced%compliance%largest_field = maxval([reduced%compliance%largest_field, sizes])
  end subroutine raise_largest_field

  !> Solves the points, each rank some of them, and sets the unknowns, energies and sizes of all states; without an answer the size
  !> is -1. Collective on all ranks.
  subroutine solve(self, problem, points, n_each, reduced, ierr)
    class(contact_states_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    type(points_t), intent(in) :: points
    !> states of each point: 1 for the forces only, or 1 and the number of parameters
    integer, intent(in) :: n_each
    type(condensed_model_t), intent(inout) :: reduced
    PetscErrorCode, intent(out) :: ierr
    class(room_t), allocatable :: room
    type(answer_t) :: answer
    type(progress_t) :: progress
    type(term_values_t) :: terms
    character(:), allocatable :: message
    integer :: first, i, n, n_ranks, rank

    PetscCall(rank_and_size(PETSC_COMM_WORLD, rank, n_ranks, ierr))
    n = size(points%nearest)
    call terms%create(problem%terms, message)
    call reduced%compliance%prepare()
    call reduced%create_room(room)
    allocate (self%unknowns(reduced%n_rows(), n_each * n), self%energies(n_each * n), self%sizes(n_each * n), source=0.0_rk)
    call progress%start('points at which the error of displacements is measured', n, seconds_of_silence)
    do i = rank + 1, n, n_ranks
      call progress%advance(min(i + n_ranks - 1, n))
      if (allocated(points%forces)) then
        call self%take(i, reduced, room, points%theta(:, i), points%forces(:, i))
        cycle
      end if
      call reduced%ask(points%theta(:, i), points%nearest(i), room, answer)
      first = n_each * (i - 1) + 1
      self%sizes(first:first + n_each - 1) = -1
      if (answer%reason <= 0) cycle
      call self%take(first, reduced, room, answer%theta, answer%unknowns)
      if (n_each > 1) call self%take_changes(first + 1, reduced, room, points%parameters(:, i), points%lengths, answer, terms)
    end do
    call progress%finish()
    call terms%destroy()
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, self%unknowns, ierr))
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, self%energies, ierr))
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, self%sizes, ierr))
  end subroutine solve

  !> Sets one state. Local.
  subroutine take(self, i_state, reduced, room, theta, unknowns)
    class(contact_states_t), intent(inout) :: self
    integer, intent(in) :: i_state
    type(condensed_model_t), intent(in) :: reduced
    !> its point is the one that was asked for last
    class(room_t), intent(in) :: room
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] shape (n_multipliers); values on anchors do not count
    real(rk), contiguous, intent(in) :: unknowns(:)

    self%unknowns(:, i_state) = reduced%compliance%with_closed_anchors(unknowns)
    self%energies(i_state) = reduced%size_of_forces(room, unknowns)**2
    self%sizes(i_state) = reduced%size_of_field(room, theta, unknowns)
  end subroutine take

  !> Sets the states of the changes of an answer with each parameter, times the length of its range; they keep their size -1 where
  !> there is no derivative. Local.
  subroutine take_changes(self, first, reduced, room, point, lengths, answer, terms)
    class(contact_states_t), intent(inout) :: self
    !> first state
    integer, intent(in) :: first
    type(condensed_model_t), intent(in) :: reduced
    class(room_t), intent(in) :: room
    !> values of the parameters, and lengths of their ranges
    real(rk), intent(in) :: point(:)
    real(rk), intent(in) :: lengths(:)
    type(answer_t), intent(in) :: answer
    type(term_values_t), intent(inout) :: terms
    type(gradient_t) :: gradient
    type(term_failure_t) :: failure
    character(:), allocatable :: message
    integer :: i

    allocate (gradient%is_one_sided(size(point)), gradient%theta(size(answer%theta), size(point)))
    gradient%lengths = lengths
    call differentiate_terms(terms, point, answer%theta, lengths, gradient%direction, gradient%theta, gradient%is_one_sided, &
      failure)
    if (failure%i_parameter > 0) return
    call reduced%differentiate(answer, gradient, message)
    if (allocated(message)) return
    do i = 1, size(point)
      call self%take(first + i - 1, reduced, room, lengths(i) * gradient%theta(:, i), lengths(i) * gradient%unknowns(:, i))
    end do
  end subroutine take_changes

  !> [-] Returns the largest error of the displacement of all states, by the field's own figure, relative to their sizes. Local.
  real(rk) function largest_error(self, fixed) result(error)
    class(contact_states_t), intent(in) :: self
    type(fixed_compliance_t), intent(in) :: fixed
    integer :: i

    error = maxval([0.0_rk, [(fixed%field%error_of(self%unknowns(:, i), self%energies(i)) / &
      self%sizes(i), i=1, size(self%sizes))]])
  end function largest_error
end module sig_contact_states
