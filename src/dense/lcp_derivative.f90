! SPDX-License-Identifier: BSD-3-Clause
!> Derivatives of the solution of a linear complementarity problem z >= 0, w = W z + q >= 0, z' w = 0 with respect to W and q.
!>
!> Rows A with a force stay closed, and rows with an opening stay open: W_AA dz_A = -(dW z + dq)_A. Rows G that graze have neither a
!> force nor an opening, so they may close or open. Their dz_G is the solution of a small complementarity problem. The derivative in
!> the opposite direction is then in general not just the negative of this one.
!>
!> Anchors are rows whose unknown is an opening, by which a body moves that only contact holds (sig_compliance). Where the rows
!> with a force do not hold such a motion, its change F is any number, and W_AA would be singular with it: the change of the forces
!> does no work on the motion, W_FG dz_G + p_F = 0, and W dz of the other rows contains dz_F. dz_A and dz_G are unique all the same:
!> they are the solution of a strictly convex quadratic program, whatever the place of the body is.
module sig_lcp_derivative
  use sig_dense_kernels, only: multiply
  use sig_independent_columns, only: independent_columns
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_solution_t, solve_lcp
  use sig_linear_algebra, only: lu_t
  use sig_rounding, only: dependent, rounding, rounding_of_data
  implicit none(type, external)
  private
  public :: differentiate_lcp, lcp_derivative_t

  !> The directional derivatives of z and w.
  type :: lcp_derivative_t
    !> dz and dw, shape (n, n_directions)
    real(rk), allocatable :: unknowns(:, :)
    real(rk), allocatable :: openings(:, :)
    !> whether the derivative in the opposite direction is not just the negative of this one, shape (n_directions)
    logical, allocatable :: is_one_sided(:)
    !> number of rows G
    integer :: n_grazing = 0
    !> the matrix of the active rows is singular, or dz_G was not found; then dz and dw are of no use
    logical :: is_singular = .false.
    !> dz_G was not found in a direction that changes the work of the loads on a motion
    logical :: is_pushed = .false.
  end type lcp_derivative_t

contains

  !> Computes the derivatives dz and dw of the solution of z >= 0, w = W z + q >= 0, z' w = 0 in some directions, which are changes
  !> of W and q. Where the matrix of the active rows is singular, or solve_lcp finds no solution for the grazing rows,
  !> derivative%is_singular is true and the derivatives are of no use. dz of motions that no force holds is one of many possible.
  subroutine differentiate_lcp(matrix, q, terms, z, changes, derivative, anchors)
    !> W, shape (n, n)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> size of the terms of which q is the sum, shape (n): it may be much larger than |q|, and rounding is a fraction of it
    real(rk), intent(in) :: terms(:)
    !> the solution of the problem, shape (n)
    real(rk), contiguous, intent(in) :: z(:)
    !> dW z + dq for each direction, shape (n, n_directions)
    real(rk), intent(in) :: changes(:, :)
    type(lcp_derivative_t), intent(out) :: derivative
    !> rows whose unknown is an opening, 1-based; default: none
    integer, intent(in), optional :: anchors(:)
    logical :: grazes(size(z)), is_active(size(z))
    integer :: i
    integer, allocatable :: active(:), free(:), grazing(:)
    type(lu_t) :: factors

    call find_grazing(matrix, q, terms, z, grazes)
    is_active = z > 0 .and. .not. grazes
    allocate (free(0))
    if (present(anchors)) free = free_anchors(matrix, is_active, anchors)
    is_active(free) = .false.
    active = pack([(i, i=1, size(z))], is_active)
    grazing = pack([(i, i=1, size(z))], grazes)
    derivative%n_grazing = size(grazing)
    allocate (derivative%is_one_sided(size(changes, 2)), source=.false.)
    allocate (derivative%unknowns(size(z), size(changes, 2)), source=0.0_rk)
    allocate (derivative%openings, source=changes)
    call factors%factor(matrix(active, active))
    derivative%is_singular = factors%is_singular
    if (derivative%is_singular) return
    derivative%unknowns(active, :) = -factors%solve(changes(active, :))
    if (size(grazing) + size(free) > 0) call close_grazing(matrix, changes, active, grazing, free, factors, derivative)
    if (derivative%is_singular .and. present(anchors)) derivative%is_pushed = any(abs(changes(anchors, :)) > 0)
    do i = 1, size(changes, 2)
      call multiply(1.0_rk, matrix, derivative%unknowns(:, i), 1.0_rk, derivative%openings(:, i))
    end do
    derivative%openings(active, :) = 0
    derivative%openings(free, :) = 0
  end subroutine differentiate_lcp

  !> Returns the open anchors whose motions depend on those of other open anchors if the contacts with a force stay closed: with
  !> them the matrix of the active rows would be singular.
  pure function free_anchors(matrix, is_active, anchors) result(free)
    real(rk), intent(in) :: matrix(:, :)
    !> whether an unknown is positive, shape (n)
    logical, intent(in) :: is_active(:)
    !> 1-based
    integer, intent(in) :: anchors(:)
    integer, allocatable :: free(:)
    logical :: is_closed(size(is_active))
    integer :: i

    is_closed = is_active
    is_closed(anchors) = .false.
    associate (open => pack(anchors, is_active(anchors)), closed => pack([(i, i=1, size(is_closed))], is_closed))
      associate (held => independent_columns(matrix(closed, open), dependent * maxval(abs(matrix(:, open)))))
        free = pack(open, [(all(held /= i), i=1, size(open))])
      end associate
    end associate
  end function free_anchors

  !> Sets `grazes` to whether a row has neither a force nor an opening, up to rounding: an opening is rounding where it is at most
  !> rounding_of_data of the terms of q and `rounding` of those of W z, a force where it closes its row by at most as much. W comes
  !> from no data that were rounded, and its terms may be large and cancel: those of a body that only contact holds move it, held at
  !> its anchors, by 1e4 of what it moves in the end. The other arguments are those of differentiate_lcp.
  subroutine find_grazing(matrix, q, terms, z, grazes)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    real(rk), intent(in) :: terms(:)
    real(rk), contiguous, intent(in) :: z(:)
    logical, intent(out) :: grazes(:)
    real(rk) :: closing(size(z)), diagonal(size(z)), forces(size(z)), w(size(z)), noise(size(z))
    integer :: k

    diagonal = [(matrix(k, k), k=1, size(z))]
    w = q
    call multiply(1.0_rk, matrix, z, 1.0_rk, w)
    noise = rounding_of_data * (abs(q) + terms)
    do k = 1, size(z)
      if (z(k) > 0) noise = noise + rounding * abs(matrix(:, k)) * z(k)
    end do
    closing = diagonal * z
    ! rows of bodies that only contact holds may have a zero diagonal
    where (.not. closing > 0) closing = z * maxval(diagonal)
    ! a force that is rounding moves other rows, also those whose own terms are zero
    forces = 0
    where (diagonal > 0) forces = noise / diagonal
    noise = noise + [(maxval(abs(matrix(k, :)) * forces), k=1, size(z))]
    grazes = closing <= noise .and. abs(w) <= noise
  end subroutine find_grazing

  !> Computes dz_G of the grazing rows and dz_F of the free ones, and corrects dz_A of the active ones. With the Schur complement S
  !> of W_AA and the change p of the openings of G and F without dz_G and dz_F: dz_G >= 0, w_G >= 0, dz_G' w_G = 0 and w_F = 0 for
  !> w = S dz + p. Sets is_one_sided for each direction (p of G is not zero, except for rounding; with free rows, dz_G in the
  !> opposite direction is not just -dz_G), and is_singular if solve_lcp finds no solution for some direction. `active`, `grazing`
  !> and `free` are numbers of rows, 1-based, and `factors` those of W_AA.
  subroutine close_grazing(matrix, changes, active, grazing, free, factors, derivative)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: changes(:, :)
    integer, intent(in) :: active(:)
    integer, intent(in) :: grazing(:)
    integer, intent(in) :: free(:)
    type(lu_t), intent(in) :: factors
    type(lcp_derivative_t), intent(inout) :: derivative
    integer :: rows(size(grazing) + size(free)), k
    real(rk) :: coupling(size(active), size(rows)), schur(size(rows), size(rows))
    real(rk) :: backward(size(rows)), openings(size(rows)), terms(size(rows)), z(size(rows)), ease(size(active))
    logical :: is_solved

    rows = [grazing, free]
    coupling = factors%solve(matrix(active, rows))
    schur = matrix(rows, rows) - matmul(matrix(rows, active), coupling)
    call round_motions(matrix, rows, size(free), schur)
    ! the largest force that closes a row again after its change alone: rounding of forces that vanish is a share of this
    ease = [(matrix(active(k), active(k)), k=1, size(active))]
    where (ease > 0) ease = 1 / ease
    do k = 1, size(changes, 2)
      associate (unknowns => derivative%unknowns(:, k), n => size(grazing))
        openings = changes(rows, k) + matmul(matrix(rows, active), unknowns(active))
        terms = abs(changes(rows, k)) + matmul(abs(matrix(rows, active)), &
          abs(unknowns(active)) + maxval([0.0_rk, abs(changes(active, k)) * ease]))
        where (abs(openings) <= rounding_of_data * terms) openings = 0
        call solve_mixed(schur, openings, n, z, is_solved)
        derivative%is_singular = derivative%is_singular .or. .not. is_solved
        derivative%is_one_sided(k) = any(abs(openings(:n)) > 0)
        if (size(free) > 0 .and. derivative%is_one_sided(k)) then
          call solve_mixed(schur, -openings, n, backward, is_solved)
          derivative%is_one_sided(k) = .not. is_solved .or. &
            any(abs(z(:n) + backward(:n)) > rounding_of_data * maxval(abs([z, backward])))
        end if
        unknowns(rows) = z
        unknowns(active) = unknowns(active) - matmul(coupling, z)
      end associate
    end do
  end subroutine close_grazing

  !> Sets entries of S in the rows and columns of anchors to zero if they are rounding: where a motion does not move a contact or,
  !> with the forces that hold it, does no work; and those between free motions, which are the last rows.
  pure subroutine round_motions(matrix, rows, n_free, schur)
    real(rk), intent(in) :: matrix(:, :)
    !> rows of S among those of the matrix, 1-based
    integer, intent(in) :: rows(:)
    integer, intent(in) :: n_free
    real(rk), intent(inout) :: schur(:, :)
    real(rk) :: sizes(size(rows)), softest
    integer :: i, k, n

    softest = maxval([(matrix(k, k), k=1, size(matrix, 1))])
    if (.not. softest > 0) return
    ! the largest opening by a unit of each unknown; stiffnesses against motions are squares of these over a compliance
    sizes = [(maxval(abs(matrix(:, rows(i)))) / sqrt(softest), i=1, size(rows))]
    do i = 1, size(rows)
      if (matrix(rows(i), rows(i)) > 0) cycle
      where (abs(schur(:, i)) <= rounding_of_data * sizes(i) * sizes) schur(:, i) = 0
      where (abs(schur(i, :)) <= rounding_of_data * sizes(i) * sizes) schur(i, :) = 0
    end do
    n = size(rows) - n_free
    schur(n + 1:, n + 1:) = 0
  end subroutine round_motions

  !> Solves w = S z + p, where z >= 0, w >= 0, z' w = 0 for the first n rows, and w = 0 for the others, whose z may have either
  !> sign: as a complementarity problem in which these are differences of two unknowns.
  subroutine solve_mixed(matrix, p, n, z, is_solved)
    !> S, shape (m, m)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (m)
    real(rk), intent(in) :: p(:)
    integer, intent(in) :: n
    !> shape (m), zero if is_solved is false
    real(rk), intent(out) :: z(:)
    logical, intent(out) :: is_solved
    real(rk) :: extended(2 * size(p) - n, 2 * size(p) - n)
    type(lcp_solution_t) :: solution

    associate (m => size(p))
      extended(:m, :m) = matrix
      extended(m + 1:, :m) = -matrix(n + 1:, :)
      extended(:, m + 1:) = -extended(:, n + 1:m)
      call solve_lcp(extended, [p, -p(n + 1:)], [logical ::], solution)
      is_solved = solution%reason > 0
      z = solution%lambda(:m)
      z(n + 1:) = z(n + 1:) - solution%lambda(m + 1:)
    end associate
  end subroutine solve_mixed
end module sig_lcp_derivative
