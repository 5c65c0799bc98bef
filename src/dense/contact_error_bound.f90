! SPDX-License-Identifier: BSD-3-Clause
!> Bounds the error of approximate contact forces lambda_r against the solution lambda of the complementarity problem 0 <= lambda, w
!> = W lambda + q >= 0, lambda' w = 0. The solution itself is not needed.
module sig_contact_error_bound
  use sig_dense_kernels, only: factor_cholesky, reduce_cholesky, solve_cholesky
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: contact_error_bound_t

  !> What bounds need of the matrix W: a lower bound of its eigenvalues, and its factor, which a large W does without.
  type :: contact_error_bound_t
    !> W is positive definite; otherwise there is no bound
    logical :: is_valid = .false.
    !> [length/force] at most the smallest eigenvalue of W; 0: not known
    real(rk), private :: least = 0
    logical, private :: has_factor = .false.
    !> Cholesky factor of W on and below the diagonal, [length/force] W above it; shape (n, n)
    real(rk), allocatable, private :: factor(:, :)
    !> [length/force] diagonal of W, shape (n)
    real(rk), allocatable, private :: diagonal(:)
  contains
    procedure :: create
    procedure :: evaluate
    procedure :: dual_size
    procedure, private :: quick_bound
    procedure, private :: bound_of_step
    procedure, private :: bound_without
    procedure, private :: times
    procedure, private :: bound_of
  end type contact_error_bound_t

  !> up to this number of rows, W is factored at once, in about a second
  integer, parameter :: most_factored = 3000

contains

  !> Computes the Cholesky factor of W, unless W is large and `least` is known. Sets is_valid to whether W is positive definite;
  !> only then may `evaluate` be called.
  subroutine create(self, compliance, least)
    class(contact_error_bound_t), intent(out) :: self
    !> [length/force] W, symmetric, shape (n, n)
    real(rk), intent(in) :: compliance(:, :)
    !> [length/force] at most the smallest eigenvalue of W (bound_of_eigenvalues), or 0, as by default: not known
    real(rk), intent(in), optional :: least
    integer :: i, info

    if (present(least)) self%least = least
    self%is_valid = self%least > 0
    if (self%is_valid .and. size(compliance, 1) > most_factored) return
    self%factor = compliance
    self%diagonal = [(compliance(i, i), i=1, size(compliance, 1))]
    call factor_cholesky(size(compliance, 1), self%factor, info)
    self%is_valid = info == 0
    self%has_factor = self%is_valid
  end subroutine create

  !> [sqrt(force*length)] Returns an upper bound of |e|, e = lambda_r - lambda, in the norm of W, for approximate forces lambda_r
  !> and the exact ones lambda. This is the energy norm of the displacement that the forces e cause.
  !>
  !> Let w = W lambda_r + q, let S be any set of rows, and let rho be any vector with rho = w on S and rho <= w elsewhere. Because
  !> lambda_r, lambda and W lambda + q are not negative and lambda' (W lambda + q) = 0: e' W e <= e' w <= e' rho + c, where c is the
  !> sum of lambda_r (w - rho) over the rows outside of S. With d = |rho| in the norm of W^-1: |e| <= d/2 + sqrt(d^2/4 + c).
  !>
  !> The smallest of three bounds is returned, or the first one if it is at most `enough`; 0 without rows, also with a surplus.
  !> Before them, the first one is bounded by the smallest eigenvalue in place of W^-1, in n operations; that is returned if it is
  !> at most `enough`, and where a large W has no factor.
  !> First bound: S are the rows with a force, and rho = min(w, 0) elsewhere. For an exact answer this bound is only rounding.
  !>
  !> Second bound: S are the rows that the primal-dual active set method would close next; a row with a very small force across a
  !> wide gap is then not in S. Elsewhere rho = min(W v, w), where v is zero outside of S and W_SS v_S = w_S: v is the change of the
  !> forces in this step. If S is the active set of the solution, and lambda_r is zero outside of S, the bound is the error itself.
  !>
  !> Third bound, only without `surplus`, and only if this step opens rows with forces: S as in the second one, but without the
  !> forces D on these rows: |e| <= |D| + |e - D|. A force across a wide gap then adds its own energy, and not its work on the gap.
  !>
  !> Bodies that are held by anchors T: W and the rows are those of the other contacts, with closed anchors. All forces are in
  !> balance, and w = W lambda_r + q + N s for some openings s of the anchors. Because e_T = -N' e, the same bound holds with rho -
  !> N rho_T: `opening` is then w - N rho_T, and `surplus` is the part of c that belongs to the anchors.
  !>
  !> Requires: is_valid.
  real(rk) function evaluate(self, lambda, opening, enough, surplus) result(bound)
    class(contact_error_bound_t), intent(in) :: self
    !> [force] lambda_r >= 0, shape (n)
    real(rk), contiguous, intent(in) :: lambda(:)
    !> [length] w = W lambda_r + q, shape (n)
    real(rk), contiguous, intent(in) :: opening(:)
    !> [sqrt(force*length)] if the first bound is at most this, the others are not computed
    real(rk), intent(in), optional :: enough
    !> [force*length] part of c that does not belong to these rows; default 0
    real(rk), intent(in), optional :: surplus
    real(rk) :: more

    bound = 0
    if (size(lambda) == 0) return
    more = 0
    if (present(surplus)) more = surplus
    if (self%least > 0) then
      bound = self%quick_bound(lambda, opening, more)
      if (.not. self%has_factor) return
      if (present(enough)) then
        if (bound <= enough) return
      end if
    end if
    bound = self%bound_of(lambda, opening, merge(opening, min(opening, 0.0_rk), lambda > 0), more)
    if (present(enough)) then
      if (bound <= enough) return
    end if
    bound = min(bound, self%bound_of_step(lambda, opening, lambda * self%diagonal > opening, more, .not. present(surplus)))
  end function evaluate

  !> [sqrt(force*length)] Returns the size of a change of openings [length, shape (n)] in the norm of W^-1, or a bound of it where a
  !> large W has no factor; 0 without rows. Requires: is_valid.
  real(rk) function dual_size(self, change)
    class(contact_error_bound_t), intent(in) :: self
    real(rk), intent(in) :: change(:)
    real(rk) :: reduced(size(change))

    if (.not. self%has_factor) then
      dual_size = norm2(change) / sqrt(self%least)
      return
    end if
    reduced = change
    if (size(change) > 0) call reduce_cholesky(size(change), self%factor, reduced)
    dual_size = norm2(reduced)
  end function dual_size

  !> Returns the first bound, with |rho| / sqrt(smallest eigenvalue) in place of the norm of W^-1.
  pure real(rk) function quick_bound(self, lambda, opening, more) result(bound)
    class(contact_error_bound_t), intent(in) :: self
    !> as for evaluate
    real(rk), intent(in) :: lambda(:)
    real(rk), intent(in) :: opening(:)
    !> [force*length] added to c
    real(rk), intent(in) :: more
    real(rk) :: misfit, square, work
    integer :: i

    square = 0
    work = more
    do i = 1, size(lambda)
      misfit = opening(i)
      if (.not. lambda(i) > 0) misfit = min(misfit, 0.0_rk)
      square = square + misfit**2 / self%least
      work = work + lambda(i) * (opening(i) - misfit)
    end do
    bound = sqrt(square) / 2 + sqrt(square / 4 + work)
  end function quick_bound

  !> Returns the second bound for the set S = is_closed, or the third one if it is allowed and smaller; huge where W_SS cannot be
  !> factored. It costs a factorization of W_SS.
  real(rk) function bound_of_step(self, lambda, opening, is_closed, more, may_drop) result(bound)
    class(contact_error_bound_t), intent(in) :: self
    !> [force] lambda_r and [length] w, as for evaluate
    real(rk), intent(in) :: lambda(:)
    real(rk), intent(in) :: opening(:)
    !> whether a row is in S, shape (n)
    logical, intent(in) :: is_closed(:)
    !> [force*length] added to c
    real(rk), intent(in) :: more
    !> the third bound is allowed, because forces need not be in balance
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

  !> Returns the third bound: the norm of the forces on the rows outside of S, plus the bound of the other forces; huge if no row
  !> outside of S has a force. lambda, opening and is_closed are those of bound_of_step.
  real(rk) function bound_without(self, lambda, opening, is_closed, closed, block) result(bound)
    class(contact_error_bound_t), intent(in) :: self
    real(rk), intent(in) :: lambda(:)
    real(rk), intent(in) :: opening(:)
    logical, intent(in) :: is_closed(:)
    !> numbers of the rows in S, 1-based and ascending, and the Cholesky factor of W_SS
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

  !> Returns W v, shape (n), for a vector v that has the given values on the given rows and is zero elsewhere.
  pure function times(self, rows, values) result(product)
    class(contact_error_bound_t), intent(in) :: self
    !> numbers of rows, 1-based
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

  !> Returns d/2 + sqrt(d^2/4 + c) for a given rho: d is |rho| in the norm of W^-1, c is `more` plus the sum of lambda_r (w -
  !> rho) over all rows. lambda (lambda_r) and opening (w) are as for evaluate.
  real(rk) function bound_of(self, lambda, opening, misfit, more) result(bound)
    class(contact_error_bound_t), intent(in) :: self
    real(rk), intent(in) :: lambda(:)
    real(rk), intent(in) :: opening(:)
    !> [length] rho <= w, shape (n)
    real(rk), intent(in) :: misfit(:)
    !> [force*length] added to c
    real(rk), intent(in) :: more
    !> L^-1 rho
    real(rk) :: reduced(size(lambda)), square

    reduced = misfit
    call reduce_cholesky(size(lambda), self%factor, reduced)
    square = dot_product(reduced, reduced)
    bound = sqrt(square) / 2 + sqrt(square / 4 + dot_product(lambda, opening - misfit) + more)
  end function bound_of
end module sig_contact_error_bound
