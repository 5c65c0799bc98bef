! SPDX-License-Identifier: BSD-3-Clause
!> Bounds the error of approximate contact forces where the matrix W of all contacts is not known.
!>
!> The bound is that of sig_contact_error_bound, except for d = |rho| in the norm of W^-1. This norm is at most |v| in the norm of K
!> for any displacement v with B v = rho. Here v = X c + L (rho - B X c) for any coefficients c. X are the displacements under a few
!> patterns Y of contact forces. The lift L moves, for each contact row, only the nodes of this row, with B L = 1. Because K X = B'
!> Y: B X = W Y, X' K X = Y' W Y and X' K L = Y'. The displacements themselves are therefore not needed, only W Y and L' K L.
module sig_lifted_error_bound
  use sig_dense_kernels, only: factor_cholesky, multiply, multiply_transpose, solve_cholesky
  use sig_kinds, only: rk
  use sig_linear_algebra, only: solve_dense
  implicit none(type, external)
  private
  public :: lifted_error_bound_t, sparse_matrix_t

  !> A sparse square matrix by rows; the entries of row i are starts(i) + 1 to starts(i + 1) of columns (1-based) and values.
  type :: sparse_matrix_t
    !> shape (n + 1)
    integer, allocatable :: starts(:)
    integer, allocatable :: columns(:)
    real(rk), allocatable :: values(:)
  contains
    procedure :: times
    procedure :: diagonal
  end type sparse_matrix_t

  !> The data for the bounds of any number of approximations; n_modes = n_patterns + n_motions.
  type :: lifted_error_bound_t
    private
    !> closing of each row by the rigid motions that only contact holds, of length 1 in the norm of L' K L; shape (n, n_motions)
    real(rk), allocatable :: motions(:, :)
    !> Y' and (W Y)', then those of the rigid motions, which have an opening but no forces; shape (n_modes, n)
    real(rk), allocatable :: forces(:, :)
    real(rk), allocatable :: openings(:, :)
    !> Y' W Y, shape (n_modes, n_modes)
    real(rk), allocatable :: energy(:, :)
    !> [force/length] L' K L
    type(sparse_matrix_t) :: lift
    !> (L' K L W Y - Y)' and the Cholesky factor of the matrix of the equations for c, where all rows are lifted
    real(rk), allocatable :: pull(:, :)
    real(rk), allocatable :: factor(:, :)
    !> [length/force] approximate diagonal of W, shape (n)
    real(rk), allocatable :: reach(:)
  contains
    procedure :: create
    procedure :: evaluate
    procedure, private :: settle
    procedure, private :: fit_rows
    procedure, private :: bound_of
  end type lifted_error_bound_t

  !> [-] this fraction of the largest diagonal entry is added to the diagonal of the equations for c; that is allowed, because any c
  !> gives a bound
  real(rk), parameter :: damping = 1.0e-12_rk

contains

  !> Returns the product A x of the matrix A and a vector, shape (n).
  pure function times(self, x) result(y)
    class(sparse_matrix_t), intent(in) :: self
    !> shape (n)
    real(rk), intent(in) :: x(:)
    real(rk) :: y(size(x))
    integer :: i, k

    do i = 1, size(x)
      y(i) = 0
      do k = self%starts(i) + 1, self%starts(i + 1)
        y(i) = y(i) + self%values(k) * x(self%columns(k))
      end do
    end do
  end function times

  !> Returns the diagonal of the matrix, shape (n); 0 where it has no entry.
  pure function diagonal(self) result(values)
    class(sparse_matrix_t), intent(in) :: self
    real(rk) :: values(size(self%starts) - 1)
    integer :: i, k

    values = 0
    do i = 1, size(values)
      do k = self%starts(i) + 1, self%starts(i + 1)
        if (self%columns(k) == i) values(i) = self%values(k)
      end do
    end do
  end function diagonal

  !> Stores the arguments, and computes from them all that does not depend on the approximation. After it, `evaluate` may be called.
  subroutine create(self, forces, openings, motions, lift, reach)
    class(lifted_error_bound_t), intent(out) :: self
    !> [force] Y, in balance where only contact holds a body, and [length] W Y; shape (n, n_patterns)
    real(rk), intent(in) :: forces(:, :)
    real(rk), intent(in) :: openings(:, :)
    !> [-] closing of each contact row by the rigid motions that only contact holds, shape (n, n_motions)
    real(rk), intent(in) :: motions(:, :)
    !> [force/length] L' K L
    type(sparse_matrix_t), intent(in) :: lift
    !> [length/force] approximate diagonal of W, shape (n)
    real(rk), intent(in) :: reach(:)
    integer :: i, k, l, n

    n = size(forces, 1)
    l = size(forces, 2)
    k = l + size(motions, 2)
    self%lift = lift
    self%reach = reach
    self%motions = motions
    allocate (self%forces(k, n), self%energy(k, k), self%pull(k, n), source=0.0_rk)
    allocate (self%openings(k, n))
    do i = 1, size(motions, 2)
      associate (length => sqrt(max(tiny(1.0_rk), dot_product(motions(:, i), lift%times(motions(:, i))))))
        self%motions(:, i) = motions(:, i) / length
      end associate
    end do
    self%forces(:l, :) = transpose(forces)
    self%openings(:l, :) = transpose(openings)
    self%openings(l + 1:, :) = -transpose(self%motions)
    self%energy(:l, :l) = matmul(transpose(forces), openings)
    self%energy = (self%energy + transpose(self%energy)) / 2
    do i = 1, k
      self%pull(i, :) = lift%times(self%openings(i, :)) - self%forces(i, :)
    end do
    self%factor = self%energy + matmul(self%openings, transpose(self%pull)) - matmul(self%forces, transpose(self%openings))
    call factor_damped(self%factor)
  end subroutine create

  !> Adds the damping to the diagonal of a symmetric matrix, and replaces its lower triangle by the Cholesky factor. All entries
  !> become zero where the matrix is not positive definite.
  subroutine factor_damped(matrix)
    real(rk), contiguous, intent(inout) :: matrix(:, :)
    integer :: i, info
    real(rk) :: largest

    largest = maxval([tiny(1.0_rk), (matrix(i, i), i=1, size(matrix, 1))])
    do i = 1, size(matrix, 1)
      matrix(i, i) = matrix(i, i) + damping * largest
    end do
    call factor_cholesky(size(matrix, 1), matrix, info)
    if (info /= 0) matrix = 0
  end subroutine factor_damped

  !> Solves a system with the factor of factor_damped: `values` is the right-hand side on entry, and the solution on exit. The
  !> solution is zero where there is no factor.
  subroutine solve_damped(factor, values)
    real(rk), contiguous, intent(in) :: factor(:, :)
    real(rk), contiguous, intent(inout) :: values(:)

    if (size(values) == 0) return
    if (factor(1, 1) > 0) then
      call solve_cholesky(size(values), factor, values)
    else
      values = 0
    end if
  end subroutine solve_damped

  !> [sqrt(force*length)] Returns an upper bound of |lambda_r - lambda| in the norm of W, for approximate forces lambda_r and the
  !> exact ones lambda. For any rho <= w it is d/2 + sqrt(d^2/4 + s), where d = |v| in the norm of K for a displacement v with B v =
  !> rho, and s is the sum of lambda_r (w - rho).
  !>
  !> The smaller one of two bounds is returned. In the first, rho is w on rows with a force, and min(w, 0) elsewhere. In the second,
  !> the rows S are those that the primal-dual active set method would close next. The coefficients c of v are computed as if only
  !> these rows were lifted (fit_rows), so that v is nearly the change of the displacement in this step; rho is w on S and the
  !> smaller one of B X c and w elsewhere.
  !>
  !> Bodies that only contact holds are first moved by settle, which changes w. Any rigid motion is allowed, because forces in
  !> balance do no work on it.
  real(rk) function evaluate(self, lambda, opening) result(bound)
    class(lifted_error_bound_t), intent(in) :: self
    !> [force] lambda_r >= 0, in balance; shape (n)
    real(rk), contiguous, intent(in) :: lambda(:)
    !> [length] w = W lambda_r + q, shape (n)
    real(rk), contiguous, intent(in) :: opening(:)
    real(rk) :: coefficients(size(self%energy, 1)), misfit(size(lambda)), placed(size(lambda)), step(size(lambda))
    logical :: is_closed(size(lambda))

    placed = opening
    if (size(self%motions, 2) > 0) call self%settle(lambda, placed)
    misfit = merge(placed, min(placed, 0.0_rk), lambda > 0)
    call multiply(1.0_rk, self%pull, misfit, 0.0_rk, coefficients)
    call solve_damped(self%factor, coefficients)
    bound = self%bound_of(lambda, placed, misfit, coefficients)
    is_closed = lambda * self%reach > placed
    call self%fit_rows(is_closed, placed, coefficients)
    call multiply_transpose(1.0_rk, self%openings, coefficients, 0.0_rk, step)
    misfit = merge(placed, min(placed, step), is_closed)
    bound = min(bound, self%bound_of(lambda, placed, misfit, coefficients))
  end function evaluate

  !> Changes the openings by those rigid motions that minimize the sum of force times squared opening over the rows. Rows with large
  !> forces are then nearly closed. The openings stay as they are if the equations of this minimum are singular.
  subroutine settle(self, lambda, opening)
    class(lifted_error_bound_t), intent(in) :: self
    !> [force] lambda_r >= 0, shape (n)
    real(rk), intent(in) :: lambda(:)
    !> [length] w, shape (n)
    real(rk), intent(inout) :: opening(:)
    real(rk) :: weighted(size(lambda), size(self%motions, 2)), place(size(self%motions, 2))
    logical :: is_singular

    weighted = self%motions * spread(lambda, 2, size(place))
    call solve_dense(matmul(transpose(weighted), self%motions), -matmul(opening, weighted), place, is_singular)
    opening = opening + matmul(self%motions, place)
  end subroutine settle

  !> Computes the coefficients c that minimize |v| in the norm of K, where B v = w on the closed rows and the lift moves only these
  !> rows; zero where the equations for c are not positive definite. `opening` is w.
  subroutine fit_rows(self, is_closed, opening, coefficients)
    class(lifted_error_bound_t), intent(in) :: self
    logical, intent(in) :: is_closed(:)
    real(rk), intent(in) :: opening(:)
    real(rk), intent(out) :: coefficients(:)
    real(rk) :: square(size(coefficients), size(coefficients)), lifted(size(coefficients))
    integer :: i, j, k

    square = self%energy
    coefficients = 0
    do i = 1, size(is_closed)
      if (.not. is_closed(i)) cycle
      lifted = -self%forces(:, i)
      do k = self%lift%starts(i) + 1, self%lift%starts(i + 1)
        if (is_closed(self%lift%columns(k))) lifted = lifted + self%lift%values(k) * self%openings(:, self%lift%columns(k))
      end do
      coefficients = coefficients + opening(i) * lifted
      do j = 1, size(coefficients)
        square(:, j) = square(:, j) + self%openings(:, i) * lifted(j) - self%forces(:, i) * self%openings(j, i)
      end do
    end do
    call factor_damped(square)
    call solve_damped(square, coefficients)
  end subroutine fit_rows

  !> Returns d/2 + sqrt(d^2/4 + s) as in evaluate, for given rho and coefficients c of v. lambda is lambda_r, and opening is w.
  real(rk) function bound_of(self, lambda, opening, misfit, coefficients) result(bound)
    class(lifted_error_bound_t), intent(in) :: self
    real(rk), intent(in) :: lambda(:)
    real(rk), intent(in) :: opening(:)
    !> [length] rho, shape (n)
    real(rk), intent(in) :: misfit(:)
    real(rk), contiguous, intent(in) :: coefficients(:)
    real(rk) :: rest(size(lambda)), force(size(lambda)), square

    rest = misfit
    call multiply_transpose(-1.0_rk, self%openings, coefficients, 1.0_rk, rest)
    force = self%lift%times(rest)
    call multiply_transpose(2.0_rk, self%forces, coefficients, 1.0_rk, force)
    square = max(0.0_rk, dot_product(coefficients, matmul(self%energy, coefficients)) + dot_product(rest, force))
    bound = sqrt(square) / 2 + sqrt(square / 4 + dot_product(lambda, opening - misfit))
  end function bound_of
end module sig_lifted_error_bound
