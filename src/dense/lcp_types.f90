! SPDX-License-Identifier: BSD-3-Clause
!> Types and procedures that the methods for the linear complementarity problem share: the solution, the workspace, and the
!> evaluation of one active set.
module sig_lcp_types
  use sig_bits, only: n_words
  use sig_dense_kernels, only: factor_cholesky, factor_lu, reciprocal_condition_cholesky, reciprocal_condition_lu, &
    solve_cholesky, solve_lu
  use sig_kinds, only: rk
  use sig_linear_algebra, only: singular_reciprocal, sum_rows
  use sig_reasons, only: reason_not_finite
  implicit none(type, external)
  private
  public :: lcp_solution_t, lcp_workspace_t, lcp_method_name, evaluate_set, measure_pivots

  !> values of lcp_solution_t%method
  integer, parameter, public :: lcp_active_set = 1
  integer, parameter, public :: lcp_block_pivoting = 2
  integer, parameter, public :: lcp_lemke = 3

  !> [-] a negative w is rounding, and no wrong sign, up to this fraction of the terms of its sum; a negative lambda up to this
  !> fraction of the largest |lambda|
  real(rk), parameter, public :: sign_tolerance = 1.0e-12_rk
  !> [-] upper limit of the tolerance for wrong signs in a second try, if the first one with sign_tolerance has found no answer;
  !> only sets with an ill-conditioned matrix reach it. It must not be used in the first try: a thin part between others has
  !> compliances so large that 1e-8 of a sum is more than an opening.
  real(rk), parameter, public :: widest_tolerance = 1.0e-8_rk
  !> [-] where smallest over largest pivot is above this, the condition number is estimated only if a sign depends on it
  real(rk), parameter, public :: trusted_pivots = 1.0e-6_rk
  !> the active set method stops after this number of sets, or after one more than there are unknowns if that is larger
  integer, parameter, public :: usual_sets = 50

  !> The answer of lambda >= 0, w = W lambda + q >= 0, lambda' w = 0.
  type :: lcp_solution_t
    !> [unit of W^-1 q] >= 0, shape (n)
    real(rk), allocatable :: lambda(:)
    !> lambda > 0, shape (n)
    logical, allocatable :: is_active(:)
    !> method that gave the answer or was tried last: lcp_active_set, lcp_block_pivoting or lcp_lemke
    integer :: method = lcp_active_set
    !> one of sig_reasons
    integer :: reason = reason_not_finite
    !> number of steps of the methods that were tried: sets, or pivots of Lemke's method. After a second try with
    !> widest_tolerance, the steps of the first try are not in it
    integer :: n_iterations = 0
    !> [-] largest violation of the conditions, relative to the terms that its row sums; huge where there is no answer
    real(rk) :: residual = huge(1.0_rk)
  end type lcp_solution_t

  !> Work space for one problem after the other. It grows to the largest problem; after that nothing is allocated. Two threads must
  !> not use the same one.
  type :: lcp_workspace_t
    !> number of unknowns for which there is room
    integer :: capacity = 0
    !> [-] largest tolerance for wrong signs: sign_tolerance, or widest_tolerance for a second try
    real(rk) :: tolerance = sign_tolerance
    !> lambda of the active set that was evaluated last, zero outside of the set; w = W lambda + q, which evaluate_set makes zero in
    !> the set, and sum_rows does not; shape (capacity)
    real(rk), allocatable :: lambda(:)
    real(rk), allocatable :: w(:)
    !> sum of the absolute values of the terms of each row of w, shape (capacity)
    real(rk), allocatable :: row_size(:)
    !> whether lambda inside, or w outside of the set, is negative beyond the tolerance; shape (capacity)
    logical, allocatable :: is_violated(:)
    !> the matrix of the set is singular; lambda, w and is_violated are not defined then
    logical :: is_singular = .false.
    !> W is symmetric: matrices of sets are then factored by Cholesky, with half the work, if they are positive definite
    logical :: is_symmetric = .false.
    !> the factors of the set are from Cholesky
    logical :: is_cholesky = .false.
    !> sets already seen, as bits, shape (n_words, n_sets)
    integer, allocatable :: history(:, :)
    !> factors of the matrix of the set, indices of the set, pivots, a right-hand side, signs for the estimate of the condition
    !> number
    real(rk), allocatable :: factors(:, :)
    integer, allocatable :: active(:)
    integer, allocatable :: pivots(:)
    real(rk), allocatable :: work(:)
    integer, allocatable :: signs(:)
    !> for Lemke's method: the tableau (lcp_lemke.f90), the basic variable of each row, a column, the ratios, the covering vector,
    !> the candidate rows
    real(rk), allocatable :: tableau(:, :)
    integer, allocatable :: basis(:)
    real(rk), allocatable :: column(:)
    real(rk), allocatable :: ratio(:)
    real(rk), allocatable :: covering(:)
    logical, allocatable :: is_candidate(:)
  contains
    procedure :: reserve
    procedure :: reserve_tableau
  end type lcp_workspace_t

contains

  !> Allocates the arrays for n unknowns. If they are large enough already, they stay as they are. Otherwise all contents are lost,
  !> and Lemke's method needs reserve_tableau again.
  pure subroutine reserve(self, n)
    class(lcp_workspace_t), intent(inout) :: self
    integer, intent(in) :: n

    if (n <= self%capacity) return
    if (allocated(self%lambda)) deallocate (self%lambda, self%w, self%row_size, self%is_violated, self%history, self%factors, &
      self%active, self%pivots, self%work, self%signs)
    if (allocated(self%tableau)) deallocate (self%tableau, self%basis, self%column, self%ratio, self%covering, self%is_candidate)
    self%capacity = n
    allocate (self%lambda(n), self%w(n), self%row_size(n), self%is_violated(n))
    allocate (self%history(n_words(n), max(usual_sets, n + 1) + 1))
    allocate (self%factors(n, n), self%active(n), self%pivots(n), self%work(n), self%signs(n))
  end subroutine reserve

  !> Allocates the arrays of Lemke's method, which few problems need, if they are not allocated yet. Requires: reserve.
  pure subroutine reserve_tableau(self)
    class(lcp_workspace_t), intent(inout) :: self

    if (allocated(self%tableau)) return
    associate (n => self%capacity)
      allocate (self%tableau(n, 2 * n + 2), self%basis(n), self%column(n), self%ratio(n), self%covering(n), self%is_candidate(n))
    end associate
  end subroutine reserve_tableau

  !> Evaluates one active set A: computes lambda_A = -W_AA^-1 q_A, w = W lambda + q outside of A, and which of these numbers are
  !> negative beyond rounding (condition_tolerance). The results are lambda (0 outside of A), w (0 in A) and is_violated of the
  !> workspace. Where W_AA is numerically singular, workspace%is_singular is true and the results are of no use.
  !>
  !> Requires: workspace%reserve, and workspace%is_symmetric is set.
  subroutine evaluate_set(matrix, q, is_active, workspace)
    !> W, shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> the set A, shape (n)
    logical, intent(in) :: is_active(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    real(rk) :: doubtful, reciprocal
    integer :: i, info, n

    call gather(matrix, is_active, workspace, n)
    workspace%is_singular = .false.
    reciprocal = 1
    doubtful = 1
    workspace%lambda(:size(q)) = 0
    if (n > 0) then
      call factor_set(matrix, is_active, workspace, n, info)
      call measure_pivots(workspace%factors, n, doubtful)
      if (workspace%is_cholesky) doubtful = doubtful**2
      workspace%is_singular = info /= 0 .or. .not. doubtful > 0
      if (workspace%is_singular) return
      if (doubtful < trusted_pivots) then
        call measure_condition(matrix, workspace, n, reciprocal)
        workspace%is_singular = .not. reciprocal > singular_reciprocal
        if (workspace%is_singular) return
      end if
      call solve_set(q, n, workspace)
    end if
    call sum_rows(matrix, workspace%lambda(:size(q)), q, workspace%w, workspace%row_size)
    do i = 1, size(q)
      if (is_active(i)) workspace%w(i) = 0
    end do
    call find_violations(is_active, condition_tolerance(reciprocal, workspace%tolerance), workspace)
    if (doubtful < trusted_pivots .or. n == 0) return
    ! The condition number costs as much as the solve, so it is estimated only where a sign depends on the tolerance.
    if (is_decided(size(q), workspace)) return
    call measure_condition(matrix, workspace, n, reciprocal)
    workspace%is_singular = .not. reciprocal > singular_reciprocal
    call find_violations(is_active, condition_tolerance(reciprocal, workspace%tolerance), workspace)
  end subroutine evaluate_set

  !> Writes the indices of the set, 1-based and ascending, into workspace%active, and its matrix into workspace%factors.
  pure subroutine gather(matrix, is_active, workspace, n)
    real(rk), intent(in) :: matrix(:, :)
    logical, intent(in) :: is_active(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    !> number of indices in the set
    integer, intent(out) :: n
    integer :: i, j

    n = 0
    do i = 1, size(is_active)
      if (.not. is_active(i)) cycle
      n = n + 1
      workspace%active(n) = i
    end do
    do j = 1, n
      do i = 1, n
        workspace%factors(i, j) = matrix(workspace%active(i), workspace%active(j))
      end do
    end do
  end subroutine gather

  !> Factors the matrix of a set in workspace%factors: by Cholesky if workspace%is_symmetric and the matrix is positive definite,
  !> else by LU with row exchanges. workspace%is_cholesky says which. Requires: gather.
  subroutine factor_set(matrix, is_active, workspace, n, info)
    real(rk), intent(in) :: matrix(:, :)
    logical, intent(in) :: is_active(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    !> number of indices in the set, from gather; it does not change
    integer, intent(inout) :: n
    !> 0 = factored, else the number of a pivot that is zero or not a number
    integer, intent(out) :: info

    workspace%is_cholesky = workspace%is_symmetric
    if (workspace%is_cholesky) then
      call factor_cholesky(n, workspace%factors, info)
      if (info == 0) return
      workspace%is_cholesky = .false.
      call gather(matrix, is_active, workspace, n)
    end if
    call factor_lu(n, workspace%factors, workspace%pivots, info)
  end subroutine factor_set

  !> Computes the smallest over the largest absolute value of the first n diagonal entries of the factors (of Cholesky: the roots of
  !> the pivots); 0 where one is not finite or all are zero.
  pure subroutine measure_pivots(factors, n, ratio)
    real(rk), intent(in) :: factors(:, :)
    integer, intent(in) :: n
    real(rk), intent(out) :: ratio
    real(rk) :: largest, smallest
    integer :: i

    largest = 0
    smallest = huge(smallest)
    ratio = 0
    do i = 1, n
      if (.not. abs(factors(i, i)) <= huge(largest)) return
      largest = max(largest, abs(factors(i, i)))
      smallest = min(smallest, abs(factors(i, i)))
    end do
    if (largest > 0) ratio = smallest / largest
  end subroutine measure_pivots

  !> Estimates the reciprocal condition number (1-norm) of the active set's matrix from its factors in the workspace. `matrix` is
  !> the whole W, and n the number of indices in the set, > 0.
  subroutine measure_condition(matrix, workspace, n, reciprocal)
    real(rk), intent(in) :: matrix(:, :)
    type(lcp_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: n
    real(rk), intent(out) :: reciprocal
    real(rk) :: column_sum, norm
    integer :: i, j

    norm = 0
    do j = 1, n
      column_sum = 0
      do i = 1, n
        column_sum = column_sum + abs(matrix(workspace%active(i), workspace%active(j)))
      end do
      norm = max(norm, column_sum)
    end do
    if (workspace%is_cholesky) then
      reciprocal = reciprocal_condition_cholesky(n, workspace%factors, norm, workspace%work, workspace%signs)
    else
      reciprocal = reciprocal_condition_lu(n, workspace%factors, norm, workspace%work, workspace%signs)
    end if
  end subroutine measure_condition

  !> Solves W_AA lambda_A = -q_A with the factors in the workspace, and writes lambda_A to its rows of workspace%lambda; the other
  !> rows keep their values. n is the number of indices in A.
  subroutine solve_set(q, n, workspace)
    real(rk), intent(in) :: q(:)
    integer, intent(in) :: n
    type(lcp_workspace_t), intent(inout) :: workspace
    integer :: i

    do i = 1, n
      workspace%work(i) = -q(workspace%active(i))
    end do
    if (workspace%is_cholesky) then
      call solve_cholesky(n, workspace%factors, workspace%work)
    else
      call solve_lu(n, workspace%factors, workspace%pivots, workspace%work)
    end if
    do i = 1, n
      workspace%lambda(workspace%active(i)) = workspace%work(i)
    end do
  end subroutine solve_set

  !> Sets workspace%is_violated: whether lambda in the active set, or w outside of it, is negative beyond the tolerance. The
  !> tolerance is relative: for w to row_size, for lambda to the largest |lambda|.
  pure subroutine find_violations(is_active, tolerance, workspace)
    logical, intent(in) :: is_active(:)
    real(rk), intent(in) :: tolerance
    type(lcp_workspace_t), intent(inout) :: workspace
    real(rk) :: largest
    integer :: i

    largest = maxval(abs(workspace%lambda(:size(is_active))))
    do i = 1, size(is_active)
      workspace%is_violated(i) = .false.
      if (is_active(i)) then
        workspace%is_violated(i) = workspace%lambda(i) < -tolerance * largest
      else
        workspace%is_violated(i) = workspace%w(i) < -tolerance * workspace%row_size(i)
      end if
    end do
  end subroutine find_violations

  !> Whether all wrong signs (workspace%is_violated) would be wrong with workspace%tolerance, too; true if no sign is wrong.
  pure logical function is_decided(n, workspace)
    !> number of unknowns
    integer, intent(in) :: n
    type(lcp_workspace_t), intent(in) :: workspace
    real(rk) :: largest
    integer :: i

    is_decided = .false.
    largest = maxval(abs(workspace%lambda(:n)))
    do i = 1, n
      if (.not. workspace%is_violated(i)) cycle
      if (workspace%lambda(i) < 0) then
        if (workspace%lambda(i) >= -workspace%tolerance * largest) return
      else if (workspace%w(i) >= -workspace%tolerance * workspace%row_size(i)) then
        return
      end if
    end do
    is_decided = .true.
  end function is_decided

  !> Returns the tolerance for wrong signs, from sign_tolerance (1e-12) to `widest`. It grows with the condition number of the set's
  !> matrix, because rounding errors of a solve do.
  pure function condition_tolerance(reciprocal_condition, widest) result(tolerance)
    real(rk), intent(in) :: reciprocal_condition
    !> [-] at least sign_tolerance
    real(rk), intent(in) :: widest
    real(rk) :: tolerance

    tolerance = 10 * epsilon(tolerance) / max(reciprocal_condition, epsilon(tolerance))
    tolerance = min(max(tolerance, sign_tolerance), widest)
  end function condition_tolerance

  !> Returns the name of a method of lcp_solution_t: `active_set`, `block_pivoting` or `lemke`; `none` for any other number.
  pure function lcp_method_name(method) result(name)
    integer, intent(in) :: method
    character(:), allocatable :: name

    select case (method)
    case (lcp_active_set)
      name = 'active_set'
    case (lcp_block_pivoting)
      name = 'block_pivoting'
    case (lcp_lemke)
      name = 'lemke'
    case default
      name = 'none'
    end select
  end function lcp_method_name
end module sig_lcp_types
