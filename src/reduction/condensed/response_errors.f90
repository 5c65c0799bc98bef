! SPDX-License-Identifier: BSD-3-Clause
!> Measures the error of contact forces from interpolated responses in two ways: at the training points, against the full-order
!> forces; and at other points (probes), against the forces of the round before.
!>
!> The probes are needed because few training points may not have the worst elastic constants. The change of the forces from round
!> to round is nearly the error of the round before. The training points tell by which factor the error became smaller in the new
!> round.
module sig_response_errors
  use sig_answer, only: answer_t, comparable_size
  use sig_body_compliance, only: body_compliance_t
  use sig_compliance, only: compliance_point_t
  use sig_condensed_model, only: condensed_model_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_probe_points, only: find_probes
  use sig_problem, only: problem_t
  use sig_reduced, only: room_t
  use sig_reduced_kinds, only: bodies_of
  use sig_term_values, only: evaluate_points
  use sig_training_set, only: training_set_t
  implicit none(type, external)
  private
  public :: measure_fields, measure_responses, probes_t

  !> Points in the box of the parameters, and the contact forces of the last round there.
  type :: probes_t
    !> [-] estimated relative error of the contact forces of the last round; huge where there is no estimate (compare)
    real(rk) :: error = huge(1.0_rk)
    !> values of the terms, shape (n_terms, n_probes), and the nearest training point, shape (n_probes)
    real(rk), allocatable, private :: theta(:, :)
    integer, allocatable, private :: nearest(:)
    !> [force] shape (n_multipliers, n_probes)
    real(rk), allocatable, private :: forces(:, :)
    logical, allocatable, private :: is_answered(:)
    !> [-] measured error at the training points in the last round
    real(rk), private :: measured_error = huge(1.0_rk)
  contains
    procedure :: create
    procedure :: compare
  end type probes_t

  !> [-] least factor by which the error is taken to become smaller in a round. A smaller measured factor means that training points
  !> are at interpolation nodes.
  real(rk), parameter :: fastest = 0.05_rk

contains

  !> Sets in the bodies of `model` measured_error and worst_point, the largest relative error of the contact forces at the training
  !> points and the number of this point, and largest_size, the largest norm of the full-order forces in the norm of W. Errors are
  !> Euclidean norms relative to the norm of the full-order forces, but at least to 1e-3 of the largest such norm (comparable_size).
  !> The error is huge(1.0_rk) where a point has no answer. Local.
  subroutine measure_responses(problem, snapshots, model)
    type(problem_t), intent(in) :: problem
    !> points with full-order contact forces, and with openings where materials flow; their displacements are not used
    type(training_set_t), intent(in) :: snapshots
    !> the responses of its bodies are there
    type(condensed_model_t), target, intent(inout) :: model
    type(body_compliance_t), pointer :: bodies
    class(room_t), allocatable :: room
    real(rk), allocatable :: forces(:, :), theta(:, :)
    real(rk) :: errors(snapshots%n_snapshots()), sizes(snapshots%n_snapshots())
    integer :: i, i_bad_point, i_bad_source

    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    forces = snapshots%forces()
    bodies => bodies_of(model)
    call model%create_room(room)
    bodies%largest_size = 0
    do i = 1, size(errors)
      if (begins_history(problem, snapshots%parameters, i)) call model%forget(room)
      if (allocated(snapshots%openings)) call model%open_contacts(room, snapshots%openings(:, i))
      errors(i) = error_at(model, i, theta(:, i), forces(:, i), room)
      sizes(i) = norm2(forces(:, i))
      ! the room holds W of the point
      bodies%largest_size = max(bodies%largest_size, model%size_of_forces(room, forces(:, i)))
    end do
    do i = 1, size(errors)
      ! huge: no answer
      if (errors(i) > 0 .and. errors(i) < huge(errors)) &
        errors(i) = errors(i) / max(comparable_size(sizes(i), maxval(sizes)), tiny(1.0_rk))
    end do
    bodies%measured_error = maxval(errors)
    bodies%worst_point = maxloc(errors, dim=1)
  end subroutine measure_responses

  !> Whether a state is not a later one of the history of the state before. With friction the last states of a history may be
  !> missing, because they have no solution.
  pure logical function begins_history(problem, states, i)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_states)
    real(rk), intent(in) :: states(:, :)
    integer, intent(in) :: i

    begins_history = i == 1
    if (begins_history) return
    associate (n => size(problem%deck%parameters), before => states(:, i - 1), now => states(:, i))
      begins_history = any(abs(now(:n) - before(:n)) > 0)
      if (.not. begins_history .and. size(now) > n) begins_history = now(n + 1) <= before(n + 1)
    end associate
  end function begins_history

  !> [force] Returns the Euclidean norm of the error of the contact forces at training point i; huge where there is no answer.
  real(rk) function error_at(model, i, theta, forces, room) result(error)
    type(condensed_model_t), intent(in) :: model
    !> number of the point, from whose active set the query starts
    integer, intent(in) :: i
    !> [-] values of the terms there, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] of the snapshot at this point, all contacts, shape (n_multipliers)
    real(rk), intent(in) :: forces(:)
    !> work space of `model`; afterwards it has W of the point
    class(room_t), intent(inout) :: room
    type(answer_t) :: answer

    call model%ask(theta, i, room, answer)
    error = huge(error)
    if (answer%reason > 0) error = norm2(answer%multipliers - forces)
  end function error_at

  !> Raises data%largest_field to the largest size |u|_K of the displacement at the training points, under the full-order contact
  !> forces. Local.
  subroutine measure_fields(problem, snapshots, data)
    type(problem_t), intent(in) :: problem
    !> points with full-order contact forces; their displacements are not used
    type(training_set_t), intent(in) :: snapshots
    type(body_compliance_t), intent(inout) :: data
    type(compliance_point_t) :: point
    real(rk), allocatable :: forces(:, :), opening(:), theta(:, :)
    integer :: i, i_bad_point, i_bad_source
    logical :: is_possible

    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    forces = snapshots%forces()
    forces(data%anchors, :) = 0
    call data%create_point(point)
    allocate (opening(size(forces, 1)))
    do i = 1, size(forces, 2)
      call data%evaluate(theta(:, i), point, is_possible)
      if (.not. is_possible) cycle
      call multiply(1.0_rk, point%matrix, forces(:, i), 0.0_rk, opening)
      data%largest_field = max(data%largest_field, data%driven_size(theta(:, i), forces(:, i), dot_product(forces(:, i), opening)))
    end do
  end subroutine measure_fields

  !> Chooses the probes (find_probes).
  subroutine create(self, problem, snapshots)
    class(probes_t), intent(out) :: self
    type(problem_t), intent(in) :: problem
    !> training points; queries at a probe start from the active set of the nearest one
    type(training_set_t), intent(in) :: snapshots
    real(rk), allocatable :: points(:, :)

    call find_probes(problem, snapshots%parameters, points, self%theta, self%nearest)
    allocate (self%forces(problem%force_rows%n_rows, size(self%theta, 2)), source=0.0_rk)
    allocate (self%is_answered(size(self%theta, 2)), source=.false.)
  end subroutine create

  !> Computes the contact forces of a new round at the probes, and from their change the estimate self%error: the largest relative
  !> change times the factor by which the bodies' measured_error became smaller (taken as at least 0.05 and at most 1). A change is
  !> relative to the norm of the new forces, but at least to 1e-3 of the largest such norm. The estimate is huge in the first round,
  !> and where a training point had no answer in the round before. Probes without an answer in this round or in the round before do
  !> not count; the largest change is 0 if none counts. Requires: measure_responses of the same round.
  subroutine compare(self, model)
    class(probes_t), intent(inout) :: self
    type(condensed_model_t), target, intent(inout) :: model
    type(body_compliance_t), pointer :: bodies
    class(room_t), allocatable :: room
    type(answer_t) :: answer
    real(rk) :: changes(size(self%nearest)), sizes(size(self%nearest))
    integer :: i

    bodies => bodies_of(model)
    call model%create_room(room)
    changes = 0
    do i = 1, size(changes)
      associate (theta => self%theta(:, i), forces => self%forces(:, i))
        ! with friction the first step of a history
        call model%forget(room)
        call model%ask(theta, self%nearest(i), room, answer)
        if (answer%reason > 0 .and. self%is_answered(i)) changes(i) = norm2(answer%multipliers - forces)
        self%is_answered(i) = answer%reason > 0
        forces = answer%multipliers
        sizes(i) = norm2(forces)
      end associate
    end do
    do i = 1, size(changes)
      if (changes(i) > 0) changes(i) = changes(i) / max(comparable_size(sizes(i), maxval(sizes)), tiny(1.0_rk))
    end do
    associate (now => bodies%measured_error, before => self%measured_error)
      self%error = huge(self%error)
      if (before < huge(before)) self%error = maxval(changes) * min(1.0_rk, max(fastest, now / max(before, tiny(before))))
      before = now
    end associate
  end subroutine compare
end module sig_response_errors
