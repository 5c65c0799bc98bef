! SPDX-License-Identifier: BSD-3-Clause
!> Semismooth Newton method for the step problem of Coulomb friction (sig_friction_types): the projections are differentiated in
!> full, so that the force of a contact that slips follows its normal force.
!>
!> A step solves for closed contacts alone. A contact that sticks has w_n = 0 and v = 0. One that slips in the direction d has w_n =
!> 0 and lambda_t = f lambda_n d + lambda_e e with e across d, where v_e + k lambda_e = 0; k is the softness of sig_friction_types.
!> In the plane there is no e, and a step is the solution of one set of states. With the inverse of W, a step may solve for the
!> openings of the other contacts instead, where these are fewer (sig_friction_openings).
module sig_friction_newton
  use sig_dense_kernels, only: factor_lu, reciprocal_condition_lu, solve_lu
  use sig_friction_openings, only: assemble_openings, count_openings, take_openings
  use sig_friction_types, only: contact_open, contact_slips, contact_sticks, friction_contacts_t, friction_solution_t, &
    friction_workspace_t, most_steps, project, sum_up
  use sig_kinds, only: rk
  use sig_lcp_types, only: measure_pivots, trusted_pivots
  use sig_linear_algebra, only: singular_reciprocal
  implicit none(type, external)
  private
  public :: run_newton

  !> where directions change, the method ends after this number of steps without a new lowest residual
  integer, parameter :: patience = 8
  !> [-] natural residual from which on W is multiplied by the forces of a step for openings
  real(rk), parameter :: near = 1.0e-8_rk

contains

  !> Runs Newton's method from the states, directions and softness of the workspace. It ends when the natural residual is at most
  !> workspace%tolerance (solved), a matrix is singular, a set of states comes back in which no direction can change, or the
  !> residual does not fall. Requires: scale_projections.
  subroutine run_newton(matrix, friction, contacts, solution, workspace, is_solved, inverse)
    !> W, shape (n_rows, n_rows)
    real(rk), intent(in) :: matrix(:, :)
    !> [-] f of each contact, shape (n_contacts)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> lambda, states, n_steps and residual change
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_solved
    !> of W, shape (n_rows, n_rows); default: steps do without it. Requires: workspace%base
    real(rk), intent(in), optional :: inverse(:, :)
    logical :: has_openings, is_singular
    integer :: i_lowest, i_step

    is_solved = .false.
    workspace%lowest = huge(workspace%lowest)
    i_lowest = 1
    do i_step = 1, most_steps
      if (was_seen(contacts, workspace, i_step)) return
      solution%states = workspace%states(:contacts%n_contacts)
      has_openings = present(inverse)
      if (has_openings) has_openings = 2 * count_openings(contacts, workspace) < contacts%n_rows()
      if (has_openings) then
        call solve_openings(inverse, friction, contacts, solution%lambda, workspace, is_singular)
      else
        call solve_states(matrix, friction, contacts, solution%lambda, workspace, is_singular)
        if (.not. is_singular) call sum_up(matrix, solution%lambda, workspace)
      end if
      if (is_singular) return
      solution%n_steps = solution%n_steps + 1
      call project(friction, contacts, solution%lambda, workspace, solution%residual)
      if (has_openings .and. solution%residual <= near) then
        ! the openings of the step are right up to rounding in the inverse: the last word has W
        call sum_up(matrix, solution%lambda, workspace)
        call project(friction, contacts, solution%lambda, workspace, solution%residual)
      end if
      is_solved = solution%residual <= workspace%tolerance
      if (is_solved) return
      if (solution%residual < workspace%lowest) i_lowest = i_step
      workspace%lowest = min(workspace%lowest, solution%residual)
      if (i_step - i_lowest >= patience .and. can_turn(contacts, workspace)) return
    end do
  end subroutine run_newton

  !> Whether the states of the workspace are those of an earlier step, and no direction can change. Keeps them. A set is known by
  !> its states and by the signs of its directions.
  logical function was_seen(contacts, workspace, i_step)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: i_step
    integer :: i

    was_seen = .false.
    associate (n => contacts%n_contacts)
      workspace%history(:n, i_step) = merge(-1, 1, workspace%states(:n) == contact_slips .and. workspace%directions(1, :n) < 0) * &
        workspace%states(:n)
      if (can_turn(contacts, workspace)) return
      do i = 1, i_step - 1
        was_seen = all(workspace%history(:n, i) == workspace%history(:n, i_step))
        if (was_seen) return
      end do
    end associate
  end function was_seen

  !> Whether a contact slips in space, so that its direction may change from step to step.
  pure logical function can_turn(contacts, workspace)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(in) :: workspace

    can_turn = any(workspace%states(:contacts%n_contacts) == contact_slips .and. contacts%tangents(2, :) > 0)
  end function can_turn

  !> Solves the linear problem of one step.
  subroutine solve_states(matrix, friction, contacts, lambda, workspace, is_singular)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> [force] shape (n_rows)
    real(rk), intent(inout) :: lambda(:)
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_singular
    real(rk) :: norm
    integer :: i, j, n

    call list_unknowns(friction, contacts, workspace, n)
    call assemble(matrix, n, workspace, norm)
    call factor(n, norm, workspace, is_singular)
    if (is_singular) return
    if (n > 0) call solve_lu(n, workspace%factors, workspace%pivots, workspace%x)
    lambda = 0
    do j = 1, n
      do i = 1, workspace%n_parts(j)
        lambda(workspace%parts(i, j)) = lambda(workspace%parts(i, j)) + workspace%shares(i, j) * workspace%x(j)
      end do
    end do
  end subroutine solve_states

  !> Solves the linear problem of one step for the openings of contacts that do not stick. Sets workspace%w to them, while
  !> workspace%row_size stays that of earlier forces.
  subroutine solve_openings(inverse, friction, contacts, lambda, workspace, is_singular)
    real(rk), contiguous, intent(in) :: inverse(:, :)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    real(rk), contiguous, intent(inout) :: lambda(:)
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_singular
    real(rk) :: norm
    integer :: n

    call assemble_openings(inverse, friction, contacts, workspace, n, norm)
    call factor(n, norm, workspace, is_singular)
    if (is_singular) return
    if (n > 0) call solve_lu(n, workspace%factors, workspace%pivots, workspace%x)
    call take_openings(inverse, friction, contacts, n, lambda, workspace)
  end subroutine solve_openings

  !> Lists the unknowns of the closed contacts and of the motions.
  pure subroutine list_unknowns(friction, contacts, workspace, n)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace
    !> number of unknowns
    integer, intent(out) :: n
    integer :: i, k

    n = 0
    do k = 1, contacts%n_contacts
      if (workspace%states(k) == contact_open) cycle
      associate (rows => contacts%tangents(:contacts%n_tangents(k), k), d => workspace%directions(:, k))
        if (workspace%states(k) == contact_sticks) then
          call add_unknown(workspace, [k], [1.0_rk], 1, n)
          do i = 1, size(rows)
            call add_unknown(workspace, rows(i:i), [1.0_rk], 1, n)
          end do
        else
          call add_unknown(workspace, [k, rows], [1.0_rk, friction(k) * d(:size(rows))], 1, n)
          if (workspace%softness(k) < huge(d) .and. size(rows) == 2) &
            call add_unknown(workspace, rows, [-d(2), d(1)], 2, n, workspace%softness(k))
        end if
      end associate
    end do
    do i = contacts%n_forces() + 1, contacts%n_rows()
      call add_unknown(workspace, [i], [1.0_rk], 1, n)
    end do
  end subroutine list_unknowns

  !> Adds an unknown: forces in some rows by their shares. The same sum of the first n_equation of these rows is its equation.
  pure subroutine add_unknown(workspace, rows, shares, n_equation, n, extra)
    type(friction_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: rows(:)
    real(rk), intent(in) :: shares(:)
    integer, intent(in) :: n_equation
    integer, intent(inout) :: n
    !> [length/force] added to its diagonal; default: 0
    real(rk), intent(in), optional :: extra

    n = n + 1
    workspace%parts(:size(rows), n) = rows
    workspace%shares(:size(rows), n) = shares
    workspace%n_parts(n) = size(rows)
    workspace%n_equation(n) = n_equation
    workspace%extra(n) = 0
    if (present(extra)) workspace%extra(n) = extra
  end subroutine add_unknown

  !> Writes the matrix of the unknowns into workspace%factors and the right-hand side into workspace%x.
  pure subroutine assemble(matrix, n, workspace, norm)
    real(rk), intent(in) :: matrix(:, :)
    integer, intent(in) :: n
    type(friction_workspace_t), intent(inout) :: workspace
    !> 1-norm of the matrix
    real(rk), intent(out) :: norm
    integer :: a, b, i, j

    norm = 0
    associate (parts => workspace%parts, shares => workspace%shares, column => workspace%work(:size(matrix, 1)))
      do j = 1, n
        column = shares(1, j) * matrix(:, parts(1, j))
        do b = 2, workspace%n_parts(j)
          column = column + shares(b, j) * matrix(:, parts(b, j))
        end do
        do i = 1, n
          workspace%factors(i, j) = shares(1, i) * column(parts(1, i))
          if (workspace%n_equation(i) == 2) workspace%factors(i, j) = workspace%factors(i, j) + shares(2, i) * column(parts(2, i))
        end do
        workspace%factors(j, j) = workspace%factors(j, j) + workspace%extra(j)
        workspace%x(j) = 0
        do a = 1, workspace%n_equation(j)
          workspace%x(j) = workspace%x(j) - shares(a, j) * workspace%free(parts(a, j))
        end do
        norm = max(norm, sum(abs(workspace%factors(:n, j))))
      end do
    end associate
  end subroutine assemble

  !> Factors the matrix, and finds whether it is numerically singular.
  subroutine factor(n, norm, workspace, is_singular)
    integer, intent(in) :: n
    real(rk), intent(in) :: norm
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_singular
    real(rk) :: ratio
    integer :: info

    is_singular = .false.
    if (n == 0) return
    call factor_lu(n, workspace%factors, workspace%pivots, info)
    call measure_pivots(workspace%factors, n, ratio)
    is_singular = info /= 0 .or. .not. ratio > 0
    if (is_singular .or. ratio >= trusted_pivots) return
    is_singular = .not. reciprocal_condition_lu(n, workspace%factors, norm, workspace%work, workspace%signs) > singular_reciprocal
  end subroutine factor
end module sig_friction_newton
