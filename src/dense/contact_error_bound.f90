! SPDX-License-Identifier: BSD-3-Clause
!> How far approximate contact forces can be from the solution of the complementarity problem 0 <= lambda, w = W lambda + q >= 0.
module sig_contact_error_bound
  use sig_dense_kernels, only: factor_cholesky, reduce_cholesky, solve_cholesky
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: contact_error_bound_t

  !> W ready for bounds of any number of approximations.
  type :: contact_error_bound_t
    !> W is symmetric positive definite: otherwise there is no bound
    logical :: is_valid = .false.
    !> Cholesky factor of W on and below the diagonal, [length/force] W above it; shape (n, n)
    real(rk), allocatable, private :: factor(:, :)
    !> [length/force] of W, shape (n)
    real(rk), allocatable, private :: diagonal(:)
  contains
    procedure :: create
    procedure :: evaluate
    procedure, private :: bound_of_step
    procedure, private :: bound_without
    procedure, private :: times
    procedure, private :: bound_of
  end type contact_error_bound_t

contains

  subroutine create(self, compliance)
    class(contact_error_bound_t), intent(out) :: self
    !> W, shape (n, n)
    real(rk), intent(in) :: compliance(:, :)
    integer :: i, info

    self%factor = compliance
    self%diagonal = [(compliance(i, i), i=1, size(compliance, 1))]
    call factor_cholesky(size(compliance, 1), self%factor, info)
    self%is_valid = info == 0
  end subroutine create

  !> Upper bound of |lambda_r - lambda| in the norm of W, the energy norm of the displacement that the difference causes.
  !>
  !> For any set S of rows, e = lambda_r - lambda, w = W lambda_r + q: e' W e = e' w - e' w(lambda) <= e' rho + c for any rho that
  !> is w on S and at most w elsewhere, with c the sum of lambda_r (w - rho) elsewhere: lambda_r, lambda and w(lambda) are not
  !> negative, and lambda' w(lambda) = 0. With d = |rho| in the norm of W^-1 follows |e| <= d/2 + sqrt(d^2/4 + c).
  !>
  !> First S are the rows with a force, and rho is min(w, 0) elsewhere: the bound of an exact answer is rounding. Then S are the
  !> rows that the primal-dual active set method closes next (a trace of force across a wide gap is no contact), and rho is
  !> min(W v, w) elsewhere, where W_SS v_S = w_S is what the step changes: on the set of the solution d is the error itself. Last,
  !> without the forces D that this step opens: their own norm and the bound of the rest, because |e| <= |D| + |e - D|; a force
  !> across a wide gap is worth its own energy, not its work on the gap. The smallest bound counts.
  !>
  !> Bodies that hang on anchors T: W and the rows are those of the others with closed anchors, all forces are in balance, and
  !> w = W lambda_r + q + N s under some openings s of the anchors. e' w over all rows is still |e|^2, and as e_T = -N' e the same
  !> bound holds with rho - N rho_T: opening is then w - N rho_T, and c has a share of the anchors.
  !>
  !> Requires: is_valid.
  real(rk) function evaluate(self, lambda, opening, enough, surplus) result(bound)
    class(contact_error_bound_t), intent(in) :: self
    !> [force] lambda_r >= 0, shape (n)
    real(rk), contiguous, intent(in) :: lambda(:)
    !> [length] w = W lambda_r + q, shape (n)
    real(rk), contiguous, intent(in) :: opening(:)
    !> a bound of the first set as small as this needs no other one; default 0
    real(rk), intent(in), optional :: enough
    !> [force*length] share of c that is not of these rows; default 0
    real(rk), intent(in), optional :: surplus
    real(rk) :: more

    bound = 0
    if (size(lambda) == 0) return
    more = 0
    if (present(surplus)) more = surplus
    bound = self%bound_of(lambda, opening, merge(opening, min(opening, 0.0_rk), lambda > 0), more)
    if (present(enough)) then
      if (bound <= enough) return
    end if
    bound = min(bound, self%bound_of_step(lambda, opening, lambda * self%diagonal > opening, more, .not. present(surplus)))
  end function evaluate

  !> The bound of the set that the primal-dual method closes. It costs a factorization of these rows.
  real(rk) function bound_of_step(self, lambda, opening, is_closed, more, may_drop) result(bound)
    class(contact_error_bound_t), intent(in) :: self
    real(rk), intent(in) :: lambda(:)
    real(rk), intent(in) :: opening(:)
    logical, intent(in) :: is_closed(:)
    real(rk), intent(in) :: more
    !> forces need not be in balance, so that some may be left out
    logical, intent(in) :: may_drop
    real(rk) :: block(count(is_closed), count(is_closed)), change(count(is_closed))
    integer :: closed(count(is_closed)), i, info, j

    closed = pack([(i, i=1, size(lambda))], is_closed)
    do i = 1, size(closed)
      block(i, i) = self%diagonal(closed(i))
      do j = i + 1, size(closed)
        block(j, i) = self%factor(closed(i), closed(j))
      end do
    end do
    change = opening(closed)
    call factor_cholesky(size(closed), block, info)
    bound = huge(bound)
    if (info /= 0) return
    call solve_cholesky(size(closed), block, change)
    bound = self%bound_of(lambda, opening, merge(opening, min(opening, self%times(closed, change)), is_closed), more)
    if (may_drop) bound = min(bound, self%bound_without(lambda, opening, is_closed, closed, block))
  end function bound_of_step

  !> The norm of the forces that a step opens, and the bound of the others on the same set.
  real(rk) function bound_without(self, lambda, opening, is_closed, closed, block) result(bound)
    class(contact_error_bound_t), intent(in) :: self
    real(rk), intent(in) :: lambda(:)
    real(rk), intent(in) :: opening(:)
    logical, intent(in) :: is_closed(:)
    !> rows of it, and the factor of W on them
    integer, intent(in) :: closed(:)
    real(rk), contiguous, intent(in) :: block(:, :)
    real(rk) :: change(size(closed)), closing(size(lambda)), rest(size(lambda))
    integer, allocatable :: opened(:)
    integer :: i

    bound = huge(bound)
    opened = pack([(i, i=1, size(lambda))], lambda > 0 .and. .not. is_closed)
    if (size(opened) == 0) return
    closing = self%times(opened, lambda(opened))
    rest = opening - closing
    change = rest(closed)
    call solve_cholesky(size(closed), block, change)
    bound = sqrt(dot_product(lambda(opened), closing(opened))) + &
      self%bound_of(merge(lambda, 0.0_rk, is_closed), rest, merge(rest, min(rest, self%times(closed, change)), is_closed), 0.0_rk)
  end function bound_without

  !> W v of a vector that is zero but on some rows.
  pure function times(self, rows, values) result(product)
    class(contact_error_bound_t), intent(in) :: self
    integer, intent(in) :: rows(:)
    !> shape (size(rows))
    real(rk), intent(in) :: values(:)
    real(rk) :: product(size(self%diagonal))
    integer :: i

    product = 0
    do i = 1, size(rows)
      associate (k => rows(i))
        product(:k - 1) = product(:k - 1) + values(i) * self%factor(:k - 1, k)
        product(k) = product(k) + values(i) * self%diagonal(k)
        product(k + 1:) = product(k + 1:) + values(i) * self%factor(k, k + 1:)
      end associate
    end do
  end function times

  !> Rows where the misfit is w are in S.
  real(rk) function bound_of(self, lambda, opening, misfit, more) result(bound)
    class(contact_error_bound_t), intent(in) :: self
    real(rk), intent(in) :: lambda(:)
    real(rk), intent(in) :: opening(:)
    !> [length] rho, shape (n)
    real(rk), intent(in) :: misfit(:)
    !> added to c
    real(rk), intent(in) :: more
    !> L^-1 rho
    real(rk) :: reduced(size(lambda)), square

    reduced = misfit
    call reduce_cholesky(size(lambda), self%factor, reduced)
    square = dot_product(reduced, reduced)
    bound = sqrt(square) / 2 + sqrt(square / 4 + dot_product(lambda, opening - misfit) + more)
  end function bound_of
end module sig_contact_error_bound
