! SPDX-License-Identifier: BSD-3-Clause
!> Semismooth Newton method for the step problem of Coulomb friction (sig_friction_types): the projections are differentiated in
!> full, so that the force of a contact that slips follows its normal force.
!>
!> A step solves for closed contacts alone. A contact that sticks has w_n = 0 and v = 0. One that slips in the direction d has w_n =
!> 0 and lambda_t = f lambda_n d + lambda_e e with e across d, where v_e + k lambda_e = 0; k is the softness of sig_friction_types.
!> In the plane there is no e, and a step is the solution of one set of states. With the inverse of W, a step may solve for the
!> openings of the other contacts instead, and go on from the factors of earlier steps (sig_friction_kept).
module sig_friction_newton
  use sig_friction_kept, only: remove_rounding, solve_anew, solve_kept
  use sig_friction_types, only: contact_slips, friction_contacts_t, friction_solution_t, &
    friction_workspace_t, most_steps, project, sum_up
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: can_turn, is_given, run_newton, signs_of

  !> where directions change, the method ends after this number of steps in which the residual has not fallen by a tenth
  integer, parameter :: patience = 8
  real(rk), parameter :: fallen = 0.9_rk
  !> [-] of its change, what a step with kept factors leaves where directions change, so that there is a next one: as much as the
  !> residual of the last one, between these limits, so that the method converges as fast as without
  real(rk), parameter :: least_left = 1.0e-6_rk, most_left = 1.0e-2_rk

contains

  !> Runs Newton's method from the states, directions and softness of the workspace. It ends when the natural residual is at most
  !> workspace%tolerance (solved), a matrix is singular, a set of states comes back in which no direction can change, or the
  !> residual does not fall. Requires: scale_projections.
  subroutine run_newton(matrix, friction, contacts, solution, workspace, is_solved, inverse)
    !> W, shape (n_rows, n_rows)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> [-] f of each contact, shape (n_contacts)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> lambda, states, n_steps and residual change
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_solved
    !> of W, shape (n_rows, n_rows); default, or not allocated: steps do without it and without kept
    !> factors. With it: w belongs to lambda
    real(rk), allocatable, intent(in), optional :: inverse(:, :)
    logical :: is_rounded, is_singular
    real(rk) :: left, to_beat
    integer :: i_lowest, i_step

    is_solved = .false.
    workspace%lowest = huge(workspace%lowest)
    to_beat = huge(to_beat)
    i_lowest = 1
    is_rounded = .false.
    do i_step = 1, most_steps
      if (was_seen(contacts, workspace, i_step) .and. .not. is_rounded) return
      solution%states = workspace%states(:contacts%n_contacts)
      if (is_given(inverse)) then
        left = 0
        if (can_turn(contacts, workspace)) left = max(least_left, min(most_left, to_beat))
        call solve_kept(matrix, inverse, friction, contacts, left, solution%lambda, workspace, is_singular)
      else
        call solve_anew(matrix, friction, contacts, solution%lambda, workspace, is_singular)
        if (.not. is_singular) call sum_up(matrix, solution%lambda, workspace)
      end if
      if (is_singular) return
      solution%n_steps = solution%n_steps + 1
      call project(friction, contacts, solution%lambda, workspace, solution%residual)
      if (is_given(inverse) .and. solution%residual <= workspace%tolerance) then
        ! the last word has W; what rounding in its inverse leaves, one more step of the same states removes
        call remove_rounding(solution%states, friction, contacts, solution%lambda)
        call sum_up(matrix, solution%lambda, workspace)
        call project(friction, contacts, solution%lambda, workspace, solution%residual)
        if (is_rounded .and. solution%residual > workspace%tolerance) return
        is_rounded = .true.
      end if
      is_solved = solution%residual <= workspace%tolerance
      if (is_solved) return
      workspace%lowest = min(workspace%lowest, solution%residual)
      if (solution%residual < fallen * to_beat) then
        to_beat = solution%residual
        i_lowest = i_step
      end if
      if (i_step - i_lowest >= patience .and. can_turn(contacts, workspace)) return
    end do
  end subroutine run_newton

  !> Whether there is an inverse of W. An allocatable argument is never copied.
  pure logical function is_given(inverse)
    real(rk), allocatable, intent(in), optional :: inverse(:, :)

    is_given = present(inverse)
    if (is_given) is_given = allocated(inverse)
  end function is_given

  !> Whether the states of the workspace are those of an earlier step, and no direction can change. Keeps them. A set is known by
  !> its states and by the signs of its directions.
  logical function was_seen(contacts, workspace, i_step)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: i_step
    integer :: i

    was_seen = .false.
    associate (n => contacts%n_contacts)
      workspace%history(:n, i_step) = signs_of(workspace%states(:n), workspace%directions(:, :n))
      if (can_turn(contacts, workspace)) return
      do i = 1, i_step - 1
        was_seen = all(workspace%history(:n, i) == workspace%history(:n, i_step))
        if (was_seen) return
      end do
    end associate
  end function was_seen

  !> Returns the states, those of contacts that slip with the sign of their direction.
  pure function signs_of(states, directions) result(signs)
    integer, intent(in) :: states(:)
    !> [-] shape (2, n_contacts)
    real(rk), intent(in) :: directions(:, :)
    integer :: signs(size(states))

    signs = merge(-1, 1, states == contact_slips .and. directions(1, :) < 0) * states
  end function signs_of

  !> Whether a contact slips in space, so that its direction may change from step to step.
  pure logical function can_turn(contacts, workspace)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(in) :: workspace

    can_turn = any(workspace%states(:contacts%n_contacts) == contact_slips .and. contacts%tangents(2, :) > 0)
  end function can_turn
end module sig_friction_newton
