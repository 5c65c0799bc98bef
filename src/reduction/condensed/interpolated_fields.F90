! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The displacements of an interpolated model at many points of the box, from which the modes of its displacements are chosen. The
!> states are the training points and probes (sig_probe_points); the model itself gives the contact forces at the probes.
!>
!> Many states are taken, because other contacts touch in small parts of the box, such as that of the smallest loads, and there,
!> too, displacements differ with all elastic constants. The number of modes hardly depends on the number of states. Every tenth
!> probe is left out, to measure the error.
!>
!> Displacements are interpolated like contact forces, u = sum_i w_i K_i^-1 (F theta - B'z) with the nodes i, but the responses of
!> all dofs are not kept. So each node is factored once more, and only the combinations of contact forces that the states have are
!> solved for.
module sig_interpolated_fields
  use sig_answer, only: answer_t, comparable_size
  use sig_body_compliance, only: body_compliance_t
  use sig_body_constants, only: joined_body_t
  use sig_body_data, only: body_data_t
  use sig_body_nodes, only: dofs_of_body, responses_t, solve_node
  use sig_body_response, only: body_weights_t
  use sig_compliance, only: compliance_point_t
  use sig_condensed_model, only: condensed_model_t
  use sig_errors, only: error_t
  use sig_full_order, only: team_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: add_product, multiply
  use sig_probe_points, only: find_probes
  use sig_problem, only: problem_t
  use sig_progress, only: progress_t
  use sig_reduced, only: room_t
  use sig_reduced_kinds, only: bodies_of
  use sig_singular_values, only: svd
  use sig_term_values, only: evaluate_points
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: field_states_t, find_field_states, interpolate_fields, told_errors

  !> Points with their contact forces.
  type :: field_states_t
    !> [-] values of the terms, shape (n_terms, n_states)
    real(rk), allocatable :: theta(:, :)
    !> [force] z, zero on anchors; shape (n_multipliers, n_states)
    real(rk), allocatable :: forces(:, :)
    !> [sqrt(force*length)] size of the displacement to which errors are relative, shape (n_states)
    real(rk), allocatable :: sizes(:)
  contains
    procedure, private :: take
  end type field_states_t

  !> most training points that are states; of more points as many are taken, spread evenly
  integer, parameter :: most_training_points = 200
  !> number of probes: the largest and the smallest one, and the values of all their displacements for which there is room between
  integer, parameter :: most_probes = 1000, least_probes = 200
  real(rk), parameter :: most_values = 5.0e7_rk
  !> [-] combinations of contact forces below this share of the largest one are left out; the error is far below that of modes
  real(rk), parameter :: negligible = 1.0e-8_rk
  !> [s] progress is told only if the nodes take longer
  real(rk), parameter :: seconds_of_silence = 3

contains

  !> Finds the states: training points with their full-order forces, and the probes at which the model has an answer. With friction
  !> a probe is the first step of a history. Local. Requires: largest_field of the bodies.
  subroutine find_field_states(problem, snapshots, model, states, others)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(condensed_model_t), target, intent(inout) :: model
    !> for the modes
    type(field_states_t), intent(out) :: states
    !> for the error
    type(field_states_t), intent(out) :: others
    type(field_states_t) :: all_states, probes
    type(body_compliance_t), pointer :: bodies
    real(rk), allocatable :: forces(:, :), theta(:, :)
    logical, allocatable :: is_answered(:)
    integer, allocatable :: chosen(:)
    integer :: i, i_bad_point, i_bad_source

    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    chosen = spread_evenly(snapshots%n_snapshots())
    forces = snapshots%forces()
    call answer_probes(problem, snapshots, model, probes, is_answered)
    bodies => bodies_of(model)
    associate (n => size(chosen))
      all_states%theta = reshape([theta(:, chosen), probes%theta], [size(theta, 1), n + size(is_answered)])
      all_states%forces = reshape([forces(:, chosen), probes%forces], [size(forces, 1), n + size(is_answered)])
      all_states%forces(bodies%anchors, :) = 0
      call measure_sizes(bodies, all_states)
      call all_states%take([spread(.true., 1, n), [(is_answered(i) .and. modulo(i, 10) > 0, i=1, size(is_answered))]], states)
      call all_states%take([spread(.false., 1, n), [(is_answered(i) .and. modulo(i, 10) == 0, i=1, size(is_answered))]], others)
    end associate
  end subroutine find_field_states

  !> Asks the model for the contact forces at probes. Local.
  subroutine answer_probes(problem, snapshots, model, probes, is_answered)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(condensed_model_t), intent(in) :: model
    !> without sizes
    type(field_states_t), intent(inout) :: probes
    logical, allocatable, intent(out) :: is_answered(:)
    type(answer_t) :: answer
    type(progress_t) :: progress
    class(room_t), allocatable :: room
    real(rk), allocatable :: points(:, :)
    integer, allocatable :: nearest(:)
    integer :: i, n

    n = max(least_probes, min(most_probes, int(most_values / (problem%mesh%n_dim * problem%mesh%n_nodes))))
    call find_probes(problem, snapshots%parameters, points, probes%theta, nearest, n)
    allocate (probes%forces(problem%force_rows%n_rows, size(nearest)), is_answered(size(nearest)))
    call model%create_room(room)
    call progress%start('points for modes of displacements', size(nearest), seconds_of_silence)
    do i = 1, size(nearest)
      call model%forget(room)
      call model%ask(probes%theta(:, i), nearest(i), room, answer)
      is_answered(i) = answer%reason > 0
      probes%forces(:, i) = answer%multipliers
      call progress%advance(i)
    end do
    call progress%finish()
  end subroutine answer_probes

  !> Takes some of the states.
  pure subroutine take(self, is_wanted, some)
    class(field_states_t), intent(in) :: self
    !> shape (n_states)
    logical, intent(in) :: is_wanted(:)
    type(field_states_t), intent(inout) :: some
    integer, allocatable :: wanted(:)
    integer :: i

    wanted = pack([(i, i=1, size(is_wanted))], is_wanted)
    some%theta = self%theta(:, wanted)
    some%forces = self%forces(:, wanted)
    some%sizes = self%sizes(wanted)
  end subroutine take

  !> Returns numbers from 1 to n: all, or most_training_points of them, spread evenly.
  pure function spread_evenly(n) result(chosen)
    integer, intent(in) :: n
    integer, allocatable :: chosen(:)
    integer :: i

    associate (n_chosen => min(n, most_training_points))
      chosen = [(1 + ((i - 1) * (n - 1)) / max(1, n_chosen - 1), i=1, n_chosen)]
    end associate
  end function spread_evenly

  !> Sets the sizes of the states, those of the displacement under the forces; a small one counts as a thousandth of the largest.
  subroutine measure_sizes(bodies, states)
    type(body_compliance_t), intent(in) :: bodies
    type(field_states_t), intent(inout) :: states
    type(compliance_point_t) :: point
    real(rk) :: opening(size(states%forces, 1))
    integer :: i
    logical :: is_possible

    allocate (states%sizes(size(states%theta, 2)))
    call bodies%create_point(point)
    do i = 1, size(states%sizes)
      associate (theta => states%theta(:, i), forces => states%forces(:, i))
        call bodies%evaluate(theta, point, is_possible)
        opening = 0
        if (is_possible) call multiply(1.0_rk, point%matrix, forces, 0.0_rk, opening)
        states%sizes(i) = max(tiny(1.0_rk), comparable_size(bodies%driven_size(theta, forces, dot_product(forces, opening)), &
          bodies%largest_field))
      end associate
    end do
  end subroutine measure_sizes

  !> Computes the displacement of each state over its size, without motions of anchors. That of a body is taken times the square
  !> root of its modulus ratio s, so that its norm for s = 1 is about its energy at the point. Changes the stiffness of the team and
  !> the constants in `joined`. Collective on all ranks.
  !>
  !> Errors: the stiffness could not be factored.
  subroutine interpolate_fields(problem, team, joined, states, data, fields, error, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(joined_body_t), intent(inout) :: joined
    type(field_states_t), intent(in) :: states
    !> its bodies have their responses
    class(body_data_t), intent(inout) :: data
    !> [length/sqrt(force*length)] rows of this rank, shape (n_local_dofs, n_states)
    real(rk), allocatable, intent(out) :: fields(:, :)
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(responses_t) :: responses
    type(progress_t) :: progress
    real(rk), allocatable :: combinations(:, :), coordinates(:, :)
    integer :: i, i_node, n_nodes

    ierr = 0
    call combine_forces(states, combinations, coordinates)
    allocate (fields(team%solver%system%map%n_local_dofs, size(states%sizes)), source=0.0_rk)
    n_nodes = maxval([(data%bodies(i)%nodes%n_nodes(), i=1, size(data%bodies))])
    call progress%start('interpolation nodes for displacements', n_nodes, seconds_of_silence)
    do i_node = 1, n_nodes
      call progress%advance(i_node)
      do i = 1, size(data%bodies)
        if (i_node <= data%bodies(i)%nodes%n_nodes()) call joined%set(problem, i, data%bodies(i)%nodes%node(i_node))
      end do
      PetscCall(solve_node(problem, team, joined, data, responses, error, ierr, combinations))
      if (allocated(error)) exit
      do i = 1, size(data%bodies)
        if (i_node <= data%bodies(i)%nodes%n_nodes()) &
          call add_node(problem, team, responses, i, i_node, states, coordinates, data, fields)
      end do
    end do
    call progress%finish()
  end subroutine interpolate_fields

  !> Finds as few combinations of contact forces as the states need, each state relative to its size: forces / sizes = combinations
  !> times coordinates. Local, with the same result on each rank.
  subroutine combine_forces(states, combinations, coordinates)
    type(field_states_t), intent(in) :: states
    !> orthonormal columns, shape (n_multipliers, n)
    real(rk), allocatable, intent(out) :: combinations(:, :)
    !> [1/sqrt(length/force)] shape (n, n_states)
    real(rk), allocatable, intent(out) :: coordinates(:, :)
    real(rk), allocatable :: u(:, :), s(:), vt(:, :)
    integer :: i, n

    call svd(states%forces / spread(states%sizes, 1, size(states%forces, 1)), u, s, vt)
    n = count(s > negligible * maxval([0.0_rk, s]))
    combinations = u(:, :n)
    coordinates = vt(:n, :)
    do i = 1, n
      coordinates(i, :) = s(i) * coordinates(i, :)
    end do
  end subroutine combine_forces

  !> Adds the share of one node of one body to the displacements of all states. Local.
  subroutine add_node(problem, team, responses, i_body, i_node, states, coordinates, data, fields)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(in) :: team
    !> of this node, under the combinations of combine_forces
    type(responses_t), intent(in) :: responses
    integer, intent(in) :: i_body
    integer, intent(in) :: i_node
    type(field_states_t), intent(in) :: states
    !> of combine_forces
    real(rk), intent(in) :: coordinates(:, :)
    class(body_data_t), intent(in) :: data
    real(rk), intent(inout) :: fields(:, :)
    type(body_weights_t) :: weights
    real(rk), allocatable :: own(:, :)
    real(rk), dimension(size(states%sizes)) :: of_forces, of_prescribed
    logical, allocatable :: is_own(:)
    integer, allocatable :: rows(:)
    integer :: i

    is_own = dofs_of_body(problem, i_body)
    associate (local => team%solver%system%map%local_dofs, body => data%bodies(i_body), n => size(responses%loaded, 2))
      rows = pack([(i, i=1, size(local))], is_own(local))
      do i = 1, size(of_forces)
        weights = body%weights_at(states%theta(:, i))
        associate (root => sqrt(body%modulus_ratio(states%theta(:, i))))
          of_forces(i) = root * weights%of_forces(i_node)
          of_prescribed(i) = root * weights%of_prescribed(i_node) / states%sizes(i)
        end associate
      end do
      own = fields(rows, :)
      call add_product(-1.0_rk, responses%contact(rows, :), coordinates * spread(of_forces, 1, size(coordinates, 1)), own)
      call add_product(1.0_rk, responses%loaded(rows, :), &
        states%theta(:n, :) * spread(of_forces / states%sizes, 1, n), own)
      call add_product(1.0_rk, responses%prescribed(rows, :), states%theta(:n, :) * spread(of_prescribed, 1, n), own)
      fields(rows, :) = own
    end associate
  end subroutine add_node

  !> [-] Returns the errors of displacements that the model tells at the states, relative to their sizes. Where forces have a bound,
  !> only the part of modes counts. Local. Requires: modes.
  function told_errors(bodies, states) result(errors)
    type(body_compliance_t), intent(inout) :: bodies
    type(field_states_t), intent(in) :: states
    real(rk) :: errors(size(states%sizes))
    type(compliance_point_t) :: point
    type(answer_t) :: answer
    integer :: i
    logical :: is_possible

    call bodies%prepare()
    call bodies%create_point(point)
    do i = 1, size(errors)
      associate (theta => states%theta(:, i))
        call bodies%evaluate(theta, point, is_possible)
        call answer%start(1, size(theta), bodies%n_modes(), bodies%n_rows(), bodies%n_rows())
        answer%theta = theta
        answer%unknowns = states%forces(:, i)
        call bodies%solve_modes(point, answer)
        errors(i) = max(point%residual / states%sizes(i), answer%relative_displacement_bound)
      end associate
    end do
  end function told_errors
end module sig_interpolated_fields
