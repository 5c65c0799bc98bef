! SPDX-License-Identifier: BSD-3-Clause
!> Points in the box of the parameters at which training asks a model, beside the training points. They do not depend on the deck.
module sig_probe_points
  use sig_deck_box, only: in_box
  use sig_deck_config, only: deck_config_t, parameter_config_t
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_latin_hypercube, only: latin_hypercube_points
  use sig_parameter_space, only: find_states
  use sig_problem, only: problem_t
  use sig_term_values, only: evaluate_points
  implicit none(type, external)
  private
  public :: find_probes, nearest_of

  integer, parameter :: n_probes = 200

contains

  !> Chooses probes in the box by a Latin hypercube and evaluates their terms. Only the probes before the first one where a term
  !> has no finite value are kept.
  subroutine find_probes(problem, training_points, points, theta, nearest, n_wanted)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: training_points(:, :)
    !> the probes, shape (n_parameters, n_probes)
    real(rk), allocatable, intent(out) :: points(:, :)
    !> values of the terms, shape (n_terms, n_probes)
    real(rk), allocatable, intent(out) :: theta(:, :)
    !> number of the nearest training point of each probe, from whose active set a query starts; shape (n_probes)
    integer, allocatable, intent(out) :: nearest(:)
    !> number of probes; default: 200
    integer, intent(in), optional :: n_wanted
    integer :: i, i_bad_point, i_bad_source, n

    n = n_probes
    if (present(n_wanted)) n = n_wanted
    points = probes_in(problem%deck, n)
    call evaluate_points(problem%terms, points, theta, i_bad_point, i_bad_source)
    if (i_bad_point > 0) theta = theta(:, :i_bad_point - 1)
    points = points(:, :size(theta, 2))
    nearest = [(nearest_of(problem%deck%state_parameters, training_points, points(:, i)), i=1, size(theta, 2))]
  end subroutine find_probes

  !> Returns points of the box by a Latin hypercube, with a history one state of each, whose time is a further coordinate of the
  !> hypercube; none where a table is not valid. Shape (size(deck%state_parameters), n_points).
  function probes_in(deck, n_points) result(probes)
    type(deck_config_t), intent(in) :: deck
    integer, intent(in) :: n_points
    real(rk), allocatable :: probes(:, :)
    real(rk), allocatable :: places(:, :), states(:, :)
    type(error_t), allocatable :: error
    integer :: i, n, n_times

    n = size(deck%parameters)
    n_times = deck%history%states%n_times()
    places = latin_hypercube_points(n + min(1, n_times), n_points, 1)
    call find_states(deck, in_box(places(:n, :), deck%parameters), states, error)
    if (allocated(error)) then
      allocate (probes(size(deck%state_parameters), 0))
    else if (n_times == 0) then
      probes = states
    else
      probes = states(:, [((i - 1) * n_times + 1 + int(places(n + 1, i) * n_times), i=1, n_points)])
    end if
  end function probes_in

  !> Returns the number of the point that is nearest to `point`, where distances are relative to the sides of the box; of equal ones
  !> the first.
  pure integer function nearest_of(parameters, points, point) result(nearest)
    type(parameter_config_t), intent(in) :: parameters(:)
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    real(rk) :: sides(size(point)), squares(size(points, 2))
    integer :: i

    sides = max(parameters%maximum - parameters%minimum, tiny(1.0_rk))
    squares = [(sum(((points(:, i) - point) / sides)**2), i=1, size(points, 2))]
    nearest = minloc(squares, dim=1)
  end function nearest_of
end module sig_probe_points
