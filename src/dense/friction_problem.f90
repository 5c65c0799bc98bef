! SPDX-License-Identifier: BSD-3-Clause
!> Solves one step of a condensed problem with Coulomb friction: with w = q + W lambda, gaps w_n and slip -(w_t + s_0),
!>
!>     0 <= lambda_n,  w_n >= 0,  lambda_n w_n = 0,   |lambda_t| <= f lambda_n,   slip = 0 or lambda_t = f lambda_n slip / |slip|
!>
!> for every contact, w_n = 0 and slip = 0 where it is tied, and w = 0 in rows of motions (equilibrium of bodies that only contact
!> holds). Newton's method is fast; where it cycles, some sweeps of Gauss-Seidel give it another start.
module sig_friction_problem
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_friction_holding, only: hold_unresisted_motions
  use sig_friction_newton, only: is_given, run_newton
  use sig_friction_rest, only: find_unloaded, place_unloaded
  use sig_friction_sweeps, only: run_sweeps
  use sig_friction_types, only: contact_open, contact_slips, contact_sticks, friction_contacts_t, friction_solution_t, &
    friction_workspace_t, length, project, scale_projections, sum_up
  use sig_kinds, only: rk
  use sig_lcp, only: solve_lcp
  use sig_linear_algebra, only: largest_size
  use sig_reasons, only: reason_converged, reason_ill_conditioned, reason_not_finite, reason_pulled_off, reason_sliding, &
    reason_unsolved_friction
  use sig_rounding, only: rounding
  implicit none(type, external)
  private
  public :: solve_friction, check_forces, count_solutions
  public :: contact_open, contact_slips, contact_sticks, friction_contacts_t, friction_solution_t, friction_workspace_t

  !> [-] largest accepted natural residual
  real(rk), parameter :: accepted_residual = 1.0e-8_rk
  !> [-] natural residual above which rounding in the inverse of W does not matter
  real(rk), parameter :: far = 1.0e-4_rk
  !> sweeps of the first round; each further round has twice as many
  integer, parameter :: first_sweeps = 4
  integer, parameter :: usual_rounds = 8
  !> [-] forces that equilibrium lacks are the same in two sweeps up to this fraction
  real(rk), parameter :: steady = 1.0e-6_rk
  !> [-] a contact slips in a motion by more than this share of its largest opening or slip
  real(rk), parameter :: moving = 1.0e-4_rk
  !> [-] solutions whose forces differ by at most this fraction of the largest force count as the same
  real(rk), parameter :: same_solution = 1.0e-6_rk

contains

  !> Solves one step. solution%reason is reason_converged where that succeeds. Otherwise lambda is zero, and the reason is
  !>
  !> - reason_not_finite: an entry of W, q, the origins or f is not finite;
  !> - reason_sliding, reason_pulled_off: there is no equilibrium, because the loads move bodies that only contact holds
  !>   (find_free_motion). The rows of motions of lambda are then the amplitudes of this motion, up to a factor;
  !> - reason_ill_conditioned: the answer misses the equations by more than 1e-8 of the terms of a row;
  !> - reason_unsolved_friction: neither Newton's method nor the sweeps reach an answer.
  !>
  !> Motions that no contact resists because f is 0, and on which the loads do no work, stay as they were (sig_friction_holding).
  !> Bodies without loads that only contact holds, and that keep no forces by friction, are moved as little as possible
  !> (sig_friction_rest).
  !> Where no contact has friction or is tied and there are no motions, the answer is that of solve_lcp. All tolerances are
  !> relative, so units do not matter. With a workspace and a solution that were used before for a problem of this size, arrays of
  !> W's size are not allocated.
  recursive subroutine solve_friction(matrix, q, origins, friction, contacts, solution, workspace, inverse, most_rounds)
    !> [length/force] W, rows as friction_contacts_t says, shape (n_rows, n_rows); symmetric but for the rows of motions
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> [length] shape (n_rows)
    real(rk), intent(in) :: q(:)
    !> [length] s_0 in tangential rows: positions of slip, -w_t, of the last time; other rows are not read; shape (n_rows)
    real(rk), intent(in) :: origins(:)
    !> [-] coefficient of friction of each contact; that of tied contacts and of contacts without tangential rows is not read; shape
    !> (n_contacts)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> in: the answer of the last time, from which the search starts if its reason is reason_converged and its size is right
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    !> of W, same shape. With it steps are fast, and use what earlier ones left: then W is that of the calls before, since
    !> workspace%kept%forget; default: all are computed anew
    real(rk), allocatable, intent(in), optional :: inverse(:, :)
    !> most rounds of sweeps before the problem counts as unsolved; default: usual_rounds (8)
    integer, intent(in), optional :: most_rounds
    real(rk), allocatable :: held(:, :)
    integer :: n_rounds
    logical :: is_solved
    real(rk) :: f(contacts%n_contacts)

    f = effective_friction(friction, contacts)
    if (.not. has_start(contacts, solution)) call start_cold(contacts, solution)
    solution%n_steps = 0
    solution%n_rounds = 0
    n_rounds = usual_rounds
    if (present(most_rounds)) n_rounds = most_rounds
    call workspace%reserve(contacts)
    if (.not. is_given(inverse)) call workspace%kept%forget()
    if (.not. workspace%kept%is_checked) workspace%kept%is_checked = is_finite(matrix)
    if (.not. (workspace%kept%is_checked .and. are_finite(q, origins, f, contacts))) then
      call give_up(reason_not_finite, solution)
      return
    end if
    call shift_openings(q, origins, contacts, workspace)
    if (contacts%n_motions == 0 .and. .not. (any(contacts%is_tied) .or. any(f > 0))) then
      call solve_without_friction(matrix, contacts, solution, workspace)
    else
      call scale_projections(matrix, contacts, workspace)
      call hold_unresisted_motions(matrix, solution%lambda(contacts%n_forces() + 1:), f, contacts, workspace%free(:size(q)), held)
      if (allocated(held)) then
        call solve_from_start(held, f, contacts, n_rounds, solution, workspace, is_solved)
        call finish(held, f, contacts, is_solved, solution, workspace)
      else
        call solve_from_start(matrix, f, contacts, n_rounds, solution, workspace, is_solved, inverse)
        call finish(matrix, f, contacts, is_solved, solution, workspace)
      end if
    end if
    if (solution%reason == reason_converged) call set_openings(origins, contacts, solution, workspace)
  end subroutine solve_friction

  !> Checks forces that another way than solve_friction has found: sets the natural residual of the solution, and its reason.
  subroutine check_forces(matrix, q, origins, friction, contacts, solution)
    !> as of solve_friction
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    real(rk), intent(in) :: origins(:)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> in: lambda; without an answer, all but its reason is zero
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t) :: workspace
    integer :: j

    call workspace%reserve_projections(contacts)
    call shift_openings(q, origins, contacts, workspace)
    call scale_projections(matrix, contacts, workspace)
    call sum_up(matrix, solution%lambda, workspace)
    do j = contacts%n_forces() + 1, contacts%n_rows()
      ! entries of N may be rounding, and forces of other bodies large
      if (abs(workspace%w(j)) <= rounding * maxval(abs(matrix(j, :))) * maxval(abs(solution%lambda(:contacts%n_forces())))) &
        workspace%w(j) = 0
    end do
    call project(effective_friction(friction, contacts), contacts, solution%lambda, workspace, solution%residual)
    solution%reason = reason_converged
    if (.not. solution%residual <= accepted_residual) call give_up(reason_ill_conditioned, solution)
  end subroutine check_forces

  !> Returns the coefficients of friction, 0 for contacts without tangential rows and for tied ones.
  pure function effective_friction(friction, contacts) result(f)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    real(rk) :: f(contacts%n_contacts)

    f = merge(friction, 0.0_rk, contacts%tangents(1, :) > 0 .and. .not. contacts%is_tied)
  end function effective_friction

  !> Whether the solution is an answer of a problem of this size.
  pure logical function has_start(contacts, solution)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_solution_t), intent(in) :: solution

    has_start = solution%reason == reason_converged .and. allocated(solution%lambda)
    if (has_start) has_start = size(solution%lambda) == contacts%n_rows() .and. size(solution%states) == contacts%n_contacts
  end function has_start

  !> Sets a solution to zeros without an answer.
  pure subroutine start_cold(contacts, solution)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_solution_t), intent(inout) :: solution

    if (allocated(solution%lambda)) deallocate (solution%lambda, solution%openings, solution%states)
    allocate (solution%lambda(contacts%n_rows()), solution%openings(contacts%n_rows()), source=0.0_rk)
    allocate (solution%states(contacts%n_contacts), source=contact_open)
    solution%reason = reason_not_finite
  end subroutine start_cold

  pure logical function is_finite(matrix)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    integer :: j

    is_finite = .true.
    do j = 1, size(matrix, 2)
      is_finite = is_finite .and. largest_size(matrix(:, j)) <= huge(matrix)
    end do
  end function is_finite

  pure logical function are_finite(q, origins, f, contacts)
    real(rk), intent(in) :: q(:)
    real(rk), intent(in) :: origins(:)
    real(rk), intent(in) :: f(:)
    type(friction_contacts_t), intent(in) :: contacts

    are_finite = all(ieee_is_finite(q)) .and. all(ieee_is_finite(f)) .and. &
      all(ieee_is_finite(origins(contacts%n_contacts + 1:contacts%n_forces())))
  end function are_finite

  !> Sets workspace%free.
  pure subroutine shift_openings(q, origins, contacts, workspace)
    real(rk), intent(in) :: q(:)
    real(rk), intent(in) :: origins(:)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace

    associate (first => contacts%n_contacts + 1, last => contacts%n_forces())
      workspace%free(:size(q)) = q
      workspace%free(first:last) = workspace%free(first:last) + origins(first:last)
    end associate
  end subroutine shift_openings

  !> Solves for the normal forces alone.
  subroutine solve_without_friction(matrix, contacts, solution, workspace)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    logical, parameter :: cold(0) = .true.

    associate (n => contacts%n_contacts, answer => workspace%lcp_solution)
      if (solution%reason == reason_converged) then
        call solve_lcp(matrix(:n, :n), workspace%free(:n), solution%states /= contact_open, answer, workspace%lcp)
      else
        call solve_lcp(matrix(:n, :n), workspace%free(:n), cold, answer, workspace%lcp)
      end if
      solution%lambda = 0
      solution%lambda(:n) = answer%lambda
      solution%states = merge(contact_slips, contact_open, answer%is_active)
      solution%n_steps = answer%n_iterations
      solution%residual = answer%residual
      solution%reason = answer%reason
      call sum_up(matrix, solution%lambda, workspace)
    end associate
  end subroutine solve_without_friction

  !> Runs Newton's method from the start, and where it fails again after 4, 8, 16, ... sweeps. Where rows depend on each other, as
  !> in a corner, its matrices are singular; then the sweeps alone may reach an answer. lambda is that of the last sweeps where
  !> nothing helps. Before many sweeps, bodies without loads are tried without forces.
  recursive subroutine solve_from_start(matrix, f, contacts, most_rounds, solution, workspace, is_solved, inverse)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: f(:)
    type(friction_contacts_t), intent(in) :: contacts
    integer, intent(in) :: most_rounds
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_solved
    real(rk), allocatable, intent(in), optional :: inverse(:, :)
    real(rk) :: swept(size(matrix, 1)), motions(contacts%n_motions)
    integer :: i_round
    logical :: is_swept

    swept = solution%lambda
    motions = swept(contacts%n_forces() + 1:)
    call set_start(matrix, f, contacts, solution, workspace)
    call try_newton(matrix, f, contacts, solution, workspace, is_solved, inverse)
    do i_round = 1, most_rounds
      if (is_solved) return
      solution%n_rounds = solution%n_rounds + 1
      call run_sweeps(matrix, f, contacts, first_sweeps * 2**(i_round - 1), swept, workspace)
      call project(f, contacts, swept, workspace, solution%residual)
      is_swept = solution%residual <= rounding
      solution%lambda = swept
      solution%states = workspace%states(:contacts%n_contacts)
      if (.not. is_swept) call try_newton(matrix, f, contacts, solution, workspace, is_solved, inverse)
      is_solved = is_solved .or. is_swept
      if (i_round == 1 .and. .not. is_solved) &
        call lay_down(matrix, f, contacts, motions, solution, workspace, is_solved)
    end do
    if (.not. is_solved) solution%lambda = swept
  end subroutine solve_from_start

  !> Solves the problem without the bodies that have no loads, then moves these to a place where nothing overlaps.
  recursive subroutine lay_down(matrix, f, contacts, motions, solution, workspace, is_solved)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: f(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> [force] those of the last time, shape (n_motions)
    real(rk), intent(in) :: motions(:)
    !> lambda and states where is_solved
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_solved
    type(friction_contacts_t) :: others
    type(friction_solution_t) :: answer
    type(friction_workspace_t) :: own
    real(rk) :: lambda(size(matrix, 1)), moved(size(motions)), nowhere(size(matrix, 1))
    logical :: is_unloaded(size(motions)), is_theirs(contacts%n_contacts)
    integer, allocatable :: rows(:), columns(:), touched(:)
    integer :: k

    is_solved = .false.
    associate (n => contacts%n_forces(), free => workspace%free)
      call find_unloaded(matrix, free(n + 1:contacts%n_rows()), contacts, is_unloaded, is_theirs)
      if (.not. any(is_unloaded)) return
      call contacts%take_part(.not. is_theirs, .not. is_unloaded, rows, others)
      ! other bodies that only contact holds have loads
      if (others%n_contacts == 0 .and. others%n_motions > 0) return
      call start_cold(others, answer)
      if (size(rows) > 0) then
        nowhere = 0
        call solve_friction(matrix(rows, rows), free(rows), nowhere(:size(rows)), pack(f, .not. is_theirs), others, answer, own)
        if (answer%reason /= reason_converged) return
      end if
      touched = pack([(k, k=1, contacts%n_contacts)], is_theirs)
      columns = pack([(k, k=1, size(motions))], is_unloaded)
      lambda = 0
      lambda(rows) = answer%lambda
      lambda(n + columns) = motions(columns)
      moved(:size(columns)) = motions(columns)
      call place_unloaded(free(touched) + matmul(matrix(touched, :), lambda), matrix(touched, n + columns), &
        moved(:size(columns)), is_solved)
      if (.not. is_solved) return
      lambda(n + columns) = moved(:size(columns))
    end associate
    solution%lambda = lambda
    solution%states = unpack(answer%states, .not. is_theirs, contact_open)
    call sum_up(matrix, solution%lambda, workspace)
  end subroutine lay_down

  !> Sets the states in the workspace from which Newton's method starts: those of the last time. Without a last time, contacts start
  !> closed that overlap without forces, and with motions all of them, which holds the bodies.
  subroutine set_start(matrix, f, contacts, solution, workspace)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: f(:)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_solution_t), intent(in) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    real(rk) :: residual
    integer :: k

    call sum_up(matrix, solution%lambda, workspace)
    call project(f, contacts, solution%lambda, workspace, residual)
    if (solution%reason /= reason_converged .and. contacts%n_motions == 0) return
    do k = 1, contacts%n_contacts
      if (solution%reason == reason_converged) then
        call set_state(solution%states(k), f(k), contacts, k, solution%lambda, workspace)
      else
        call set_state(contact_sticks, f(k), contacts, k, solution%lambda, workspace)
      end if
    end do
  end subroutine set_start

  !> Sets the state of a contact in the workspace, as far as its friction allows it: without friction a closed contact slips, and
  !> one without a tangential force sticks, because it has no direction yet.
  pure subroutine set_state(state, f, contacts, k, lambda, workspace)
    integer, intent(in) :: state
    real(rk), intent(in) :: f
    type(friction_contacts_t), intent(in) :: contacts
    integer, intent(in) :: k
    !> [force] whose tangential part gives the direction, shape (n_rows)
    real(rk), intent(in) :: lambda(:)
    type(friction_workspace_t), intent(inout) :: workspace
    real(rk) :: force(2)
    integer :: n

    if (contacts%is_tied(k)) return
    workspace%states(k) = state
    workspace%directions(:, k) = 0
    workspace%softness(k) = huge(f)
    if (state == contact_open) return
    workspace%states(k) = contact_slips
    if (.not. f > 0) return
    n = contacts%n_tangents(k)
    force = contacts%tangential(k, lambda)
    if (state == contact_sticks .or. length(force) <= 0) then
      workspace%states(k) = contact_sticks
    else
      workspace%directions(:, k) = force / length(force)
      if (n == 2) workspace%softness(k) = 0
    end if
  end subroutine set_state

  !> Runs Newton's method, and where the inverse is not accurate enough once more without it; where it stays between 1e-12 and 1e-8
  !> of the terms of a row, as with ill-conditioned matrices, once more until it has this residual again.
  subroutine try_newton(matrix, f, contacts, solution, workspace, is_solved, inverse)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: f(:)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_solved
    real(rk), allocatable, intent(in), optional :: inverse(:, :)

    workspace%tolerance = rounding
    if (is_given(inverse)) then
      call run_newton(matrix, f, contacts, solution, workspace, is_solved, inverse)
      ! where Newton's method is far from an answer, it is not for rounding
      if (is_solved .or. workspace%lowest > far) return
    end if
    call run_newton(matrix, f, contacts, solution, workspace, is_solved)
    if (is_solved .or. workspace%lowest > accepted_residual / 2) return
    workspace%tolerance = 2 * workspace%lowest
    call run_newton(matrix, f, contacts, solution, workspace, is_solved)
  end subroutine try_newton

  !> Removes rounding from an answer and checks it, or finds out why there is none.
  subroutine finish(matrix, f, contacts, is_solved, solution, workspace)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: f(:)
    type(friction_contacts_t), intent(in) :: contacts
    logical, intent(in) :: is_solved
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    integer :: reason
    logical :: is_changed

    if (is_solved) then
      call drop_rounding(matrix, f, contacts, solution, workspace, is_changed)
      if (is_changed) call sum_up(matrix, solution%lambda, workspace)
      call project(f, contacts, solution%lambda, workspace, solution%residual)
      solution%reason = merge(reason_converged, reason_ill_conditioned, solution%residual <= accepted_residual)
      if (solution%reason /= reason_converged) call give_up(reason_ill_conditioned, solution)
    else
      call find_free_motion(matrix, f, contacts, solution%lambda, workspace, reason)
      call give_up(reason, solution)
      if (reason /= reason_unsolved_friction) solution%lambda(contacts%n_forces() + 1:) = workspace%x(:contacts%n_motions)
    end if
  end subroutine finish

  !> Opens contacts whose normal force is negative or only rounding: it closes the softest closed contact by at most 1e-12 of the
  !> sizes of the terms of its row (sig_lcp_rounding). Keeps tangential forces in their discs.
  pure subroutine drop_rounding(matrix, f, contacts, solution, workspace, is_changed)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: f(:)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(in) :: workspace
    !> whether a force is another one afterwards
    logical, intent(out) :: is_changed
    real(rk) :: before(size(solution%lambda))
    real(rk) :: radius, softest, tangential
    integer :: i, k

    before = solution%lambda
    softest = 0
    do k = 1, contacts%n_contacts
      if (solution%lambda(k) > 0) softest = max(softest, matrix(k, k), 1 / workspace%c(1, k))
    end do
    do k = 1, contacts%n_contacts
      if (contacts%is_tied(k)) cycle
      associate (lambda => solution%lambda, normal => solution%lambda(k))
        if (normal * softest <= rounding * workspace%row_size(k)) then
          normal = 0
          solution%states(k) = contact_open
        end if
        radius = f(k) * normal
        tangential = length(contacts%tangential(k, lambda))
        if (.not. tangential > radius) cycle
        do i = 1, contacts%n_tangents(k)
          lambda(contacts%tangents(i, k)) = lambda(contacts%tangents(i, k)) * (radius / tangential)
        end do
      end associate
    end do
    is_changed = any(abs(solution%lambda - before) > 0)
  end subroutine drop_rounding

  !> Finds whether bodies move on and on in the sweeps: one more sweep leaves the forces N' lambda - F that equilibrium lacks as
  !> they are. As the motions advance by these forces over a constant, the bodies then move steadily against the largest forces that
  !> contact and friction can have in this motion.
  subroutine find_free_motion(matrix, f, contacts, lambda, workspace, reason)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: f(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> [force] in: after the last sweeps; out: after one more
    real(rk), intent(inout) :: lambda(:)
    !> x gets the motion
    type(friction_workspace_t), intent(inout) :: workspace
    !> reason_sliding if a contact with a force slips in this motion, else reason_pulled_off; reason_unsolved_friction where there
    !> is no such motion
    integer, intent(out) :: reason
    real(rk) :: before(contacts%n_motions), opening(contacts%n_forces())
    integer :: k

    reason = reason_unsolved_friction
    if (contacts%n_motions == 0) return
    associate (n => contacts%n_forces(), last => contacts%n_rows(), motion => workspace%x(:contacts%n_motions))
      call sum_up(matrix, lambda, workspace)
      before = workspace%w(n + 1:last)
      call run_sweeps(matrix, f, contacts, 1, lambda, workspace)
      motion = -workspace%w(n + 1:last)
      if (all(abs(motion) <= accepted_residual * workspace%row_size(n + 1:last))) return
      if (norm2(motion + before) > steady * norm2(motion)) return
      opening = matmul(matrix(:n, n + 1:), motion)
      reason = reason_pulled_off
      do k = 1, contacts%n_contacts
        associate (slip => opening(contacts%tangents(:contacts%n_tangents(k), k)))
          if (lambda(k) > 0 .and. norm2(slip) > moving * maxval(abs(opening))) reason = reason_sliding
        end associate
      end do
    end associate
  end subroutine find_free_motion

  !> Sets the openings of an answer. Closed contacts have no gap, and those that stick stay exactly where they are, so that rounding
  !> does not add up over many steps.
  pure subroutine set_openings(origins, contacts, solution, workspace)
    real(rk), intent(in) :: origins(:)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(in) :: workspace
    integer :: i, k

    associate (first => contacts%n_contacts + 1, last => contacts%n_forces(), openings => solution%openings)
      openings(:last) = workspace%w(:last)
      openings(first:last) = openings(first:last) - origins(first:last)
      openings(last + 1:) = 0
      do k = 1, contacts%n_contacts
        if (solution%states(k) /= contact_open) openings(k) = 0
        if (solution%states(k) /= contact_sticks) cycle
        do i = 1, contacts%n_tangents(k)
          openings(contacts%tangents(i, k)) = -origins(contacts%tangents(i, k))
        end do
      end do
    end associate
  end subroutine set_openings

  !> Sets a solution to zeros with the reason why there is no answer.
  pure subroutine give_up(reason, solution)
    integer, intent(in) :: reason
    type(friction_solution_t), intent(inout) :: solution

    solution%reason = reason
    solution%lambda = 0
    solution%openings = 0
    solution%states = contact_open
    solution%residual = huge(solution%residual)
  end subroutine give_up

  !> Counts the different solutions of a step that Newton's method finds: the known one, from all contacts sticking, and from all
  !> contacts slipping in their last direction. That it finds one does not prove that there is only one. Without friction there is
  !> one. Arguments: solve_friction, which was called before with the same ones and this workspace.
  subroutine count_solutions(matrix, friction, contacts, known, workspace, n_solutions)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> with reason_converged
    type(friction_solution_t), intent(in) :: known
    type(friction_workspace_t), intent(inout) :: workspace
    integer, intent(out) :: n_solutions
    type(friction_solution_t) :: found(2)
    real(rk) :: f(contacts%n_contacts)
    logical :: is_solved, is_new(2)
    integer :: i, k
    integer, parameter :: starts(2) = [contact_sticks, contact_slips]

    n_solutions = 1
    f = effective_friction(friction, contacts)
    if (.not. any(f > 0)) return
    do i = 1, 2
      found(i) = known
      do k = 1, contacts%n_contacts
        call set_state(starts(i), f(k), contacts, k, known%lambda, workspace)
      end do
      call try_newton(matrix, f, contacts, found(i), workspace, is_solved)
      is_new(i) = is_solved .and. differs(found(i)%lambda, known%lambda)
      if (i == 2) is_new(i) = is_new(i) .and. .not. (is_new(1) .and. .not. differs(found(2)%lambda, found(1)%lambda))
    end do
    n_solutions = 1 + count(is_new)
  end subroutine count_solutions

  pure logical function differs(one, other)
    real(rk), intent(in) :: one(:), other(:)

    differs = maxval(abs(one - other)) > same_solution * max(maxval(abs(one)), maxval(abs(other)))
  end function differs
end module sig_friction_problem
