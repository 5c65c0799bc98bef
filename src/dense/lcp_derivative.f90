! SPDX-License-Identifier: BSD-3-Clause
!> Derivatives of the solution of a linear complementarity problem z >= 0, w = W z + q >= 0, z' w = 0 with respect to W and q.
!>
!> Rows A with a force stay closed, and rows with an opening stay open: W_AA dz_A = -(dW z + dq)_A. Rows G that graze have neither a
!> force nor an opening, so they may close or open. Their dz_G is the solution of a small complementarity problem. The derivative in
!> the opposite direction is then in general not just the negative of this one.
module sig_lcp_derivative
  use sig_dense_kernels, only: multiply
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_solution_t, solve_lcp
  use sig_linear_algebra, only: lu_t
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
  end type lcp_derivative_t

  !> [-] an opening is rounding where it is at most this fraction of its terms. A force is rounding where it closes its row by at
  !> most as much
  real(rk), parameter :: rounding = 1.0e-9_rk

contains

  !> Computes the derivatives dz and dw of the solution of z >= 0, w = W z + q >= 0, z' w = 0 in some directions, which are changes
  !> of W and q. Where the matrix of the active rows is singular, or solve_lcp finds no solution for the grazing rows,
  !> derivative%is_singular is true and the derivatives are of no use.
  subroutine differentiate_lcp(matrix, q, terms, z, changes, derivative)
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
    logical :: grazes(size(z))
    integer :: i
    integer, allocatable :: active(:), grazing(:)
    type(lu_t) :: factors

    call find_grazing(matrix, q, terms, z, grazes)
    active = pack([(i, i=1, size(z))], z > 0 .and. .not. grazes)
    grazing = pack([(i, i=1, size(z))], grazes)
    derivative%n_grazing = size(grazing)
    allocate (derivative%is_one_sided(size(changes, 2)), source=.false.)
    allocate (derivative%unknowns(size(z), size(changes, 2)), source=0.0_rk)
    allocate (derivative%openings, source=changes)
    call factors%factor(matrix(active, active))
    derivative%is_singular = factors%is_singular
    if (derivative%is_singular) return
    derivative%unknowns(active, :) = -factors%solve(changes(active, :))
    if (size(grazing) > 0) call close_grazing(matrix, changes, active, grazing, factors, derivative)
    do i = 1, size(changes, 2)
      call multiply(1.0_rk, matrix, derivative%unknowns(:, i), 1.0_rk, derivative%openings(:, i))
    end do
    derivative%openings(active, :) = 0
  end subroutine differentiate_lcp

  !> Sets `grazes` to whether a row has neither a force nor an opening, up to rounding. The other arguments are those of
  !> differentiate_lcp.
  subroutine find_grazing(matrix, q, terms, z, grazes)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    real(rk), intent(in) :: terms(:)
    real(rk), contiguous, intent(in) :: z(:)
    logical, intent(out) :: grazes(:)
    real(rk) :: closing(size(z)), w(size(z)), noise(size(z))
    integer :: k

    w = q
    call multiply(1.0_rk, matrix, z, 1.0_rk, w)
    noise = rounding * (abs(q) + terms)
    do k = 1, size(z)
      closing(k) = matrix(k, k) * z(k)
      if (z(k) > 0) noise = noise + rounding * abs(matrix(:, k)) * z(k)
    end do
    ! rows of bodies that only contact holds may have a zero diagonal
    where (.not. closing > 0) closing = z * maxval([(matrix(k, k), k=1, size(z))])
    grazes = closing <= noise .and. abs(w) <= noise
  end subroutine find_grazing

  !> Computes dz_G of the grazing rows and corrects dz_A of the active ones. With the Schur complement S = W_GG - W_GA W_AA^-1 W_AG
  !> and the change p of the openings of G without forces on G: dz_G >= 0, S dz_G + p >= 0, dz_G' (S dz_G + p) = 0. Sets
  !> is_one_sided for each direction (some p is not zero, except for rounding), and is_singular if solve_lcp finds no solution for
  !> some direction. `active` and `grazing` are numbers of rows, 1-based, and `factors` those of W_AA.
  subroutine close_grazing(matrix, changes, active, grazing, factors, derivative)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: changes(:, :)
    integer, intent(in) :: active(:)
    integer, intent(in) :: grazing(:)
    type(lu_t), intent(in) :: factors
    type(lcp_derivative_t), intent(inout) :: derivative
    real(rk) :: coupling(size(active), size(grazing)), openings(size(grazing)), schur(size(grazing), size(grazing))
    real(rk) :: terms(size(grazing))
    type(lcp_solution_t) :: solution
    integer :: k

    coupling = factors%solve(matrix(active, grazing))
    schur = matrix(grazing, grazing) - matmul(matrix(grazing, active), coupling)
    do k = 1, size(changes, 2)
      associate (unknowns => derivative%unknowns(:, k))
        openings = changes(grazing, k) + matmul(matrix(grazing, active), unknowns(active))
        terms = abs(changes(grazing, k)) + matmul(abs(matrix(grazing, active)), abs(unknowns(active)))
        where (abs(openings) <= rounding * terms) openings = 0
        derivative%is_one_sided(k) = any(abs(openings) > 0)
        call solve_lcp(schur, openings, [logical ::], solution)
        derivative%is_singular = derivative%is_singular .or. solution%reason < 0
        unknowns(grazing) = solution%lambda
        unknowns(active) = unknowns(active) - matmul(coupling, solution%lambda)
      end associate
    end do
  end subroutine close_grazing
end module sig_lcp_derivative
