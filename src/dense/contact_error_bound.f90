! SPDX-License-Identifier: BSD-3-Clause
!> How far approximate contact forces can be from the solution of the complementarity problem 0 <= lambda, w = W lambda + q >= 0.
module sig_contact_error_bound
  use sig_dense_kernels, only: factor_cholesky, solve_cholesky
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: contact_error_bound_t

  !> W ready for bounds of any number of approximations.
  type :: contact_error_bound_t
    !> W is symmetric positive definite: otherwise there is no bound
    logical :: is_valid = .false.
    !> [sqrt(length/force)] Cholesky factor of W, shape (n, n)
    real(rk), allocatable, private :: factor(:, :)
    !> [force/length] of W's diagonal, inverted, shape (n)
    real(rk), allocatable, private :: stiffness(:)
  contains
    procedure :: create
    procedure :: evaluate
    procedure, private :: bound_of_set
  end type contact_error_bound_t

contains

  subroutine create(self, compliance)
    class(contact_error_bound_t), intent(out) :: self
    !> W, shape (n, n)
    real(rk), intent(in) :: compliance(:, :)
    integer :: i, info

    self%factor = compliance
    allocate (self%stiffness(size(compliance, 1)))
    do i = 1, size(compliance, 1)
      self%stiffness(i) = 1 / max(compliance(i, i), tiny(1.0_rk))
    end do
    call factor_cholesky(size(compliance, 1), self%factor, info)
    self%is_valid = info == 0
  end subroutine create

  !> Upper bound of |lambda_r - lambda| in the norm of W, the energy norm of the displacement that the difference causes.
  !>
  !> For any set S of rows, e = lambda_r - lambda, w = W lambda_r + q: e' W e = e' w - e' w(lambda) <= e' rho + c, as lambda_r
  !> and w(lambda) are not negative and lambda' w(lambda) = 0, with rho = w on S, min(w, 0) elsewhere, and c the sum of
  !> lambda_r max(w, 0) elsewhere. With d = |rho| in the norm of W^-1 follows |e| <= d/2 + sqrt(d^2/4 + c). The smaller bound of
  !> two sets is taken: rows with a force, and rows that the primal-dual active set method would close next (a trace of force
  !> across a wide gap is no contact).
  !>
  !> Requires: is_valid.
  real(rk) function evaluate(self, lambda, opening, enough) result(bound)
    class(contact_error_bound_t), intent(in) :: self
    !> [force] lambda_r >= 0, shape (n)
    real(rk), contiguous, intent(in) :: lambda(:)
    !> [length] w = W lambda + q, shape (n)
    real(rk), contiguous, intent(in) :: opening(:)
    !> a bound of the first set as small as this needs no second one; default 0
    real(rk), intent(in), optional :: enough

    bound = 0
    if (size(lambda) == 0) return
    bound = self%bound_of_set(lambda, opening, lambda > 0)
    if (present(enough)) then
      if (bound <= enough) return
    end if
    bound = min(bound, self%bound_of_set(lambda, opening, lambda > self%stiffness * opening))
  end function evaluate

  real(rk) function bound_of_set(self, lambda, opening, is_in_set) result(bound)
    class(contact_error_bound_t), intent(in) :: self
    real(rk), intent(in) :: lambda(:)
    real(rk), intent(in) :: opening(:)
    logical, intent(in) :: is_in_set(:)
    real(rk) :: misfit(size(lambda)), force(size(lambda)), square, surplus

    misfit = merge(opening, min(opening, 0.0_rk), is_in_set)
    surplus = sum(lambda * max(opening, 0.0_rk), mask=.not. is_in_set)
    force = misfit
    call solve_cholesky(size(lambda), self%factor, force)
    square = max(0.0_rk, dot_product(misfit, force))
    bound = sqrt(square) / 2 + sqrt(square / 4 + surplus)
  end function bound_of_set
end module sig_contact_error_bound
