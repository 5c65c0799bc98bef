! SPDX-License-Identifier: BSD-3-Clause
!> Block Gauss-Seidel for the step problem of Coulomb friction (sig_friction_types): one contact after the other gets the forces
!> that solve its own three equations exactly, while all other forces stay. It is slow, but it does not cycle where Newton's method
!> does, and leaves a start from which that converges.
!>
!> Rows of motions have no diagonal. With e = N' lambda - F, which equilibrium makes zero, the contacts meet W + weight N N' and the
!> openings w + weight N e; after each sweep the motions advance by weight e (the method of multipliers).
module sig_friction_sweeps
  use sig_friction_types, only: friction_contacts_t, friction_workspace_t, sum_up
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: run_sweeps, solve_contact

  !> directions in which the slip of a contact in space is sought, and halvings of the interval between two of them
  integer, parameter :: n_angles = 24
  integer, parameter :: n_halvings = 50
  real(rk), parameter :: pi = acos(-1.0_rk)

contains

  !> Runs some sweeps over all contacts. Requires: scale_projections, workspace%free.
  subroutine run_sweeps(matrix, friction, contacts, n_sweeps, lambda, workspace)
    !> W, shape (n_rows, n_rows)
    real(rk), intent(in) :: matrix(:, :)
    !> [-] f of each contact, shape (n_contacts)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    integer, intent(in) :: n_sweeps
    !> [force] shape (n_rows)
    real(rk), intent(inout) :: lambda(:)
    !> w belongs to lambda afterwards
    type(friction_workspace_t), intent(inout) :: workspace
    integer :: i, k

    do i = 1, n_sweeps
      ! anew in each sweep, so that rounding does not grow
      call sum_up(matrix, lambda, workspace)
      do k = 1, contacts%n_contacts
        call relax(matrix, friction(k), contacts, k, lambda, workspace)
      end do
      associate (motions => lambda(contacts%n_forces() + 1:contacts%n_rows()))
        motions = motions - workspace%weight * workspace%w(contacts%n_forces() + 1:contacts%n_rows())
      end associate
    end do
    call sum_up(matrix, lambda, workspace)
  end subroutine run_sweeps

  !> Gives contact k the forces that solve its equations, and moves all openings.
  subroutine relax(matrix, f, contacts, k, lambda, workspace)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: f
    type(friction_contacts_t), intent(in) :: contacts
    integer, intent(in) :: k
    real(rk), intent(inout) :: lambda(:)
    type(friction_workspace_t), intent(inout) :: workspace
    real(rk) :: block(3, 3), forces(3), free(3)
    integer :: i, j, n, rows(3)

    n = 1 + contacts%n_tangents(k)
    rows = [k, contacts%tangents(:, k)]
    associate (first => size(lambda) - contacts%n_motions + 1, last => size(lambda), w => workspace%w)
      do i = 1, n
        forces(i) = lambda(rows(i))
        free(i) = w(rows(i)) - workspace%weight * dot_product(matrix(rows(i), first:last), w(first:last))
        do j = 1, n
          block(i, j) = matrix(rows(i), rows(j)) + &
            workspace%weight * dot_product(matrix(rows(i), first:last), matrix(rows(j), first:last))
          free(i) = free(i) - block(i, j) * lambda(rows(j))
        end do
      end do
      call solve_contact(block(:n, :n), free(:n), f, contacts%is_tied(k), forces(:n))
      do i = 1, n
        w(:last) = w(:last) + matrix(:, rows(i)) * (forces(i) - lambda(rows(i)))
        lambda(rows(i)) = forces(i)
      end do
    end associate
  end subroutine relax

  !> Solves the friction problem of one contact: w = free + block lambda, its normal row first. Where there are several answers,
  !> open comes before stick, and stick before slip; of several directions of slip, the one nearest to the last force counts. Where
  !> none is found (a large f), the normal force is that without friction.
  pure subroutine solve_contact(block, free, f, is_tied, lambda)
    !> [length/force] symmetric, shape (n, n); n is 1 plus the number of tangential rows
    real(rk), intent(in) :: block(:, :)
    !> [length] openings without the forces of this contact, shape (n)
    real(rk), intent(in) :: free(:)
    real(rk), intent(in) :: f
    logical, intent(in) :: is_tied
    !> [force] in: the last forces; shape (n)
    real(rk), intent(inout) :: lambda(:)
    real(rk) :: last(size(free))
    logical :: is_found

    last = lambda
    lambda = 0
    if (is_tied) then
      lambda = -solve_block(block, free)
      return
    end if
    if (free(1) >= 0 .or. .not. block(1, 1) > 0) return
    lambda(1) = -free(1) / block(1, 1)
    if (size(free) == 1 .or. .not. f > 0) return
    lambda = -solve_block(block, free)
    if (lambda(1) >= 0 .and. norm2(lambda(2:)) <= f * lambda(1)) return
    if (size(free) == 2) then
      call slip_in_plane(block, free, f, last, lambda, is_found)
    else
      call slip_in_space(block, free, f, last, lambda, is_found)
    end if
    if (.not. is_found) lambda = [-free(1) / block(1, 1), spread(0.0_rk, 1, size(free) - 1)]
  end subroutine solve_contact

  !> Returns block^-1 b for a symmetric positive definite block, by elimination. Where a pivot is not positive, its unknown is 0.
  pure function solve_block(block, b) result(x)
    real(rk), intent(in) :: block(:, :)
    real(rk), intent(in) :: b(:)
    real(rk) :: x(size(b))
    real(rk) :: a(size(b), size(b))
    integer :: i, j

    a = block
    x = b
    do i = 1, size(b)
      if (.not. a(i, i) > epsilon(a) * block(i, i)) cycle
      do j = i + 1, size(b)
        x(j) = x(j) - a(j, i) / a(i, i) * x(i)
        a(j, i:) = a(j, i:) - a(j, i) / a(i, i) * a(i, i:)
      end do
    end do
    do i = size(b), 1, -1
      if (a(i, i) > epsilon(a) * block(i, i)) then
        x(i) = (x(i) - dot_product(a(i, i + 1:), x(i + 1:))) / a(i, i)
      else
        x(i) = 0
      end if
    end do
  end function solve_block

  !> Finds a slip in the plane: to the side of the last force first.
  pure subroutine slip_in_plane(block, free, f, last, lambda, is_found)
    real(rk), intent(in) :: block(:, :)
    real(rk), intent(in) :: free(:)
    real(rk), intent(in) :: f
    real(rk), intent(in) :: last(:)
    real(rk), intent(inout) :: lambda(:)
    logical, intent(out) :: is_found
    real(rk) :: side, opening(2)
    integer :: i

    side = sign(1.0_rk, last(2))
    do i = 1, 2
      is_found = block(1, 1) + f * side * block(1, 2) > 0
      if (is_found) then
        lambda(1) = -free(1) / (block(1, 1) + f * side * block(1, 2))
        lambda(2) = f * side * lambda(1)
        opening = free + matmul(block, lambda)
        is_found = opening(2) * side <= 0
        if (is_found) return
      end if
      side = -side
    end do
  end subroutine slip_in_plane

  !> Finds a slip in space: a direction d where v is along -d, by the sign changes of the part of v across d.
  pure subroutine slip_in_space(block, free, f, last, lambda, is_found)
    real(rk), intent(in) :: block(:, :)
    real(rk), intent(in) :: free(:)
    real(rk), intent(in) :: f
    real(rk), intent(in) :: last(:)
    real(rk), intent(inout) :: lambda(:)
    logical, intent(out) :: is_found
    real(rk) :: across(0:n_angles), angle, angles(0:n_angles), best, rest, start, trial(3), v(2)
    logical :: is_valid(0:n_angles), is_pushed
    integer :: i

    start = atan2(last(3), last(2))
    ! the answer is often near the last direction, so that this is in the middle of an interval
    angles = [(start + (2 * i - 1) * pi / n_angles, i=0, n_angles)]
    do i = 0, n_angles - 1
      call slip_along(block, free, f, angles(i), trial, v, across(i), is_valid(i))
    end do
    across(n_angles) = across(0)
    is_valid(n_angles) = is_valid(0)
    is_found = .false.
    best = huge(best)
    do i = 1, n_angles
      if (.not. (is_valid(i - 1) .and. is_valid(i))) cycle
      if (across(i - 1) > 0 .eqv. across(i) > 0) cycle
      angle = root_between(block, free, f, angles(i - 1), angles(i), across(i - 1) > 0)
      if (1 - cos(angle - start) >= best) cycle
      call slip_along(block, free, f, angle, trial, v, rest, is_pushed)
      if (.not. is_pushed .or. v(1) * cos(angle) + v(2) * sin(angle) > 0) cycle
      best = 1 - cos(angle - start)
      lambda = trial
      is_found = .true.
    end do
  end subroutine slip_in_space

  !> Returns the angle between two others at which the part of v across the direction changes its sign.
  pure real(rk) function root_between(block, free, f, first, last, is_positive) result(angle)
    real(rk), intent(in) :: block(:, :)
    real(rk), intent(in) :: free(:)
    real(rk), intent(in) :: f
    real(rk), intent(in) :: first, last
    !> at the first angle
    logical, intent(in) :: is_positive
    real(rk) :: across, lambda(3), lower, upper, v(2)
    logical :: is_valid
    integer :: i

    lower = first
    upper = last
    do i = 1, n_halvings
      angle = (lower + upper) / 2
      call slip_along(block, free, f, angle, lambda, v, across, is_valid)
      if (across > 0 .eqv. is_positive) then
        lower = angle
      else
        upper = angle
      end if
    end do
  end function root_between

  !> Computes the forces of a contact that slips with its friction in the direction of an angle.
  pure subroutine slip_along(block, free, f, angle, lambda, v, across, is_valid)
    real(rk), intent(in) :: block(:, :)
    real(rk), intent(in) :: free(:)
    real(rk), intent(in) :: f
    real(rk), intent(in) :: angle
    !> [force] shape (3)
    real(rk), intent(out) :: lambda(:)
    !> [length] the opposite of the slip, shape (2), and its part across the direction
    real(rk), intent(out) :: v(:)
    real(rk), intent(out) :: across
    !> whether the normal force is positive
    logical, intent(out) :: is_valid
    real(rk) :: d(2), compliance

    d = [cos(angle), sin(angle)]
    compliance = block(1, 1) + f * dot_product(block(1, 2:3), d)
    is_valid = compliance > 0
    lambda = 0
    if (is_valid) lambda = -free(1) / compliance * [1.0_rk, f * d(1), f * d(2)]
    v = free(2:3) + matmul(block(2:3, :), lambda)
    across = d(1) * v(2) - d(2) * v(1)
  end subroutine slip_along
end module sig_friction_sweeps
