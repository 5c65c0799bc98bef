! SPDX-License-Identifier: BSD-3-Clause
!> Contact forces of interpolated responses against those of the training points, which were solved with constants of their own.
module sig_response_errors
  use sig_answer, only: answer_t, comparable_size
  use sig_kinds, only: rk
  use sig_problem, only: problem_t
  use sig_reduced, only: neighbors_t, reduced_t, room_t
  use sig_reduced_interpolated, only: reduced_interpolated_t
  use sig_term_values, only: evaluate_points
  use sig_training_set, only: training_set_t
  implicit none(type, external)
  private
  public :: measure_responses

contains

  !> Sets measured_error and largest_size. Local.
  subroutine measure_responses(problem, snapshots, reduced)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(reduced_interpolated_t), intent(inout) :: reduced
    class(room_t), allocatable :: room
    real(rk), allocatable :: forces(:, :), theta(:, :)
    real(rk) :: errors(snapshots%n_snapshots()), sizes(snapshots%n_snapshots())
    integer :: i, i_bad_point, i_bad_source

    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    forces = snapshots%forces()
    call reduced%create_room(room)
    reduced%data%largest_size = 0
    do i = 1, size(errors)
      errors(i) = error_at(reduced, i, theta(:, i), forces(:, i), room)
      sizes(i) = norm2(forces(:, i))
      ! the room holds W of the point
      reduced%data%largest_size = max(reduced%data%largest_size, reduced%size_in_energy(room, forces(:, i)))
    end do
    do i = 1, size(errors)
      if (errors(i) > 0) errors(i) = errors(i) / max(comparable_size(sizes(i), maxval(sizes)), tiny(1.0_rk))
    end do
    reduced%data%measured_error = maxval(errors)
    reduced%data%worst_point = maxloc(errors, dim=1)
  end subroutine measure_responses

  !> [force] Euclidean norm of the forces' error at a training point; huge where there is no answer.
  real(rk) function error_at(reduced, i, theta, forces, room) result(error)
    type(reduced_interpolated_t), intent(in) :: reduced
    integer, intent(in) :: i
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] of the snapshot
    real(rk), intent(in) :: forces(:)
    class(room_t), intent(inout) :: room
    class(reduced_t), pointer :: nobody
    type(answer_t) :: answer

    nobody => null()
    call answer%start(1, size(theta), 0, size(forces), size(forces))
    call reduced%solve(theta, neighbors_t(nearest=i), nobody, room, answer)
    error = huge(error)
    if (answer%reason > 0) error = norm2(answer%multipliers - forces)
  end function error_at
end module sig_response_errors
