! SPDX-License-Identifier: BSD-3-Clause
!> Types and procedures that the methods for the linear complementarity problem share: the solution, the workspace, and the
!> evaluation of one active set.
module sig_lcp_types
  use sig_bits, only: n_words
  use sig_dense_kernels, only: extend_cholesky, factor_lu, reciprocal_condition_cholesky, reciprocal_condition_lu, &
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
  !> list_set orders indices in so many steps of their forces and overlaps
  integer, parameter :: most_levels = 32

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
    !> lambda of the active set that was evaluated last, zero outside of the set; w = W lambda + q; shape (capacity)
    real(rk), allocatable :: lambda(:)
    real(rk), allocatable :: w(:)
    !> w and row_size belong to lambda
    logical :: has_openings = .false.
    !> lambda and w belong to a set, evaluated since forget_sets
    logical :: has_depths = .false.
    !> sum of the absolute values of the terms of each row of w, shape (capacity)
    real(rk), allocatable :: row_size(:)
    !> whether lambda inside, or w outside of the set, is negative beyond the tolerance; shape (capacity)
    logical, allocatable :: is_violated(:)
    !> whether W is the same in all problems of solve_lcp: then it is looked at once
    logical :: has_one_matrix = .false.
    !> whether, in addition, factors are kept from one set to the next. Answers then depend, by rounding, on the sets before
    !> (forget_sets)
    logical :: keeps_factors = .false.
    !> W has been looked at: it is finite, and is_symmetric is set
    logical :: is_known = .false.
    !> number of indices in the set, and how many of them, 0 or all, have factors that can be used again
    integer :: n_set = 0
    integer :: n_kept = 0
    !> [-] of the matrix of the set, or 1 while it is not estimated
    real(rk) :: reciprocal_condition = 1
    logical :: is_estimated = .false.
    !> the matrix of the set is singular; lambda, w and is_violated are not defined then
    logical :: is_singular = .false.
    !> W is symmetric: matrices of sets are then factored by Cholesky, with half the work, if they are positive definite
    logical :: is_symmetric = .false.
    !> the factors of the set are from Cholesky
    logical :: is_cholesky = .false.
    !> indices that list_set still has to list, and the place of each index in the kept set or 0; shape (capacity)
    logical, allocatable :: is_listed(:)
    integer, allocatable :: places(:)
    !> sets already seen, as bits, shape (n_words, n_sets)
    integer, allocatable :: history(:, :)
    !> factors of the matrix of the set, indices of the set in their order, pivots, a right-hand side, signs for the estimate of the
    !> condition number
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
    procedure :: forget_sets
    procedure :: take_other_matrix
    procedure :: factor_set
    procedure :: solve_for_set
  end type lcp_workspace_t

contains

  !> Allocates the arrays for n unknowns. If they are large enough already, they stay as they are. Otherwise all contents are lost,
  !> and Lemke's method needs reserve_tableau again.
  pure subroutine reserve(self, n)
    class(lcp_workspace_t), intent(inout) :: self
    integer, intent(in) :: n

    if (n <= self%capacity) return
    if (allocated(self%lambda)) deallocate (self%lambda, self%w, self%row_size, self%is_violated, self%is_listed, self%places, &
      self%history, self%factors, self%active, self%pivots, self%work, self%signs)
    if (allocated(self%tableau)) deallocate (self%tableau, self%basis, self%column, self%ratio, self%covering, self%is_candidate)
    self%capacity = n
    call self%forget_sets()
    allocate (self%lambda(n), self%w(n), self%row_size(n), source=0.0_rk)
    allocate (self%is_violated(n), self%is_listed(n), self%places(n))
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

  !> Forgets factors, so that answers do not depend on the sets before.
  pure subroutine forget_sets(self)
    class(lcp_workspace_t), intent(inout) :: self

    self%n_kept = 0
    self%has_depths = .false.
  end subroutine forget_sets

  !> Forgets what is known of the matrix, before another one is used.
  pure subroutine take_other_matrix(self)
    class(lcp_workspace_t), intent(inout) :: self

    self%is_known = .false.
    call self%forget_sets()
  end subroutine take_other_matrix

  !> Evaluates one active set A: computes lambda_A = -W_AA^-1 q_A, w = W lambda + q, and which of these numbers are negative beyond
  !> rounding (condition_tolerance). The results are lambda (0 outside of A), w, its row_size, and is_violated of the workspace.
  !> Where W_AA is numerically singular, workspace%is_singular is true and the results are of no use.
  !>
  !> Requires: workspace%reserve, and workspace%is_symmetric is set.
  subroutine evaluate_set(matrix, q, is_active, workspace)
    !> W, shape (n, n)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> the set A, shape (n)
    logical, intent(in) :: is_active(:)
    type(lcp_workspace_t), intent(inout) :: workspace

    workspace%has_openings = .false.
    call workspace%factor_set(matrix, is_active)
    if (workspace%is_singular) return
    call solve_set(q, workspace)
    call sum_rows(matrix, workspace%lambda(:size(q)), q, workspace%w, workspace%row_size)
    workspace%has_openings = .true.
    workspace%has_depths = .true.
    call find_violations(is_active, condition_tolerance(workspace%reciprocal_condition, workspace%tolerance), workspace)
    ! The condition number costs as much as the solve, so it is estimated only where a sign depends on the tolerance.
    if (workspace%is_estimated .or. workspace%n_set == 0) return
    if (is_decided(size(q), workspace)) return
    call estimate_condition(matrix, workspace)
    call find_violations(is_active, condition_tolerance(workspace%reciprocal_condition, workspace%tolerance), workspace)
  end subroutine evaluate_set

  !> Factors the matrix of a set A: by Cholesky if is_symmetric and the matrix is positive definite, else by LU with row exchanges.
  !> is_cholesky says which, and is_singular whether the matrix is numerically singular. With keeps_factors nothing is done for
  !> the set of the last call, and a part of the factor is used again where few indices have entered or left it.
  !>
  !> Requires: reserve, and is_symmetric is set.
  subroutine factor_set(self, matrix, is_active)
    class(lcp_workspace_t), intent(inout) :: self
    !> W, shape (n, n)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> A, shape (n)
    logical, intent(in) :: is_active(:)
    real(rk) :: ratio
    integer :: info, n_columns, n_rows

    if (.not. self%keeps_factors) call self%forget_sets()
    call list_set(is_active, self, n_columns, n_rows)
    if (n_rows > 0 .and. n_rows == self%n_kept .and. n_rows == self%n_set) return
    self%is_singular = .false.
    self%is_estimated = .false.
    self%reciprocal_condition = 1
    self%n_kept = 0
    if (self%n_set == 0) return
    call factor_matrix(matrix, n_columns, n_rows, self, info)
    call measure_pivots(self%factors, self%n_set, ratio)
    if (self%is_cholesky) ratio = ratio**2
    self%is_singular = info /= 0 .or. .not. ratio > 0
    if (self%is_singular) return
    if (ratio < trusted_pivots) call estimate_condition(matrix, self)
    if (self%keeps_factors .and. .not. self%is_singular) self%n_kept = self%n_set
  end subroutine factor_set

  !> Lists the indices of a set in workspace%active: first those that the kept set has, too, then the others. Where an index leaves
  !> the kept set, all behind it are factored anew. So indices that are likely to leave soon come last: small forces, and small
  !> overlaps among those that enter.
  pure subroutine list_set(is_active, workspace, n_columns, n_rows)
    logical, intent(in) :: is_active(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    !> size of the leading triangle of the factor that both sets have in common: a multiple of step, for extend_cholesky
    integer, intent(out) :: n_columns
    !> number of indices that both sets have. Their rows of these columns have been moved
    integer, intent(out) :: n_rows
    integer, parameter :: step = 8
    integer :: i, j, n_levels, n_same

    associate (active => workspace%active, n_kept => workspace%n_kept, n => workspace%n_set, &
               is_listed => workspace%is_listed(:size(is_active)), places => workspace%places(:size(is_active)))
      n_same = n_kept
      places = 0
      do i = n_kept, 1, -1
        places(active(i)) = i
        if (.not. is_active(active(i))) n_same = (i - 1) / step * step
      end do
      n_levels = merge(most_levels, 1, workspace%has_depths .and. n_kept > 0)
      n = n_same
      is_listed = is_active .and. places > n_same
      call list_by_size(workspace%lambda, 1.0_rk, n_levels, is_listed, active, n)
      n_rows = n
      n_columns = merge(n_same / step * step, 0, workspace%is_cholesky)
      do j = 1, merge(n_columns, 0, n_same < n_kept)
        do i = n_same + 1, n_rows
          workspace%work(i) = workspace%factors(places(active(i)), j)
        end do
        workspace%factors(n_same + 1:n_rows, j) = workspace%work(n_same + 1:n_rows)
      end do
      is_listed = is_active .and. places == 0
      call list_by_size(workspace%w, -1.0_rk, n_levels, is_listed, active, n)
    end associate
  end subroutine list_set

  !> Appends indices to a list, those of the largest sign * number first, in n_levels steps from the largest one to 0; those of a
  !> step are ascending.
  pure subroutine list_by_size(numbers, sign, n_levels, is_listed, list, n)
    real(rk), intent(in) :: numbers(:)
    real(rk), intent(in) :: sign
    integer, intent(in) :: n_levels
    !> on entry the indices to append, on exit none
    logical, intent(inout) :: is_listed(:)
    integer, intent(inout) :: list(:)
    !> length of the list
    integer, intent(inout) :: n
    real(rk) :: largest
    integer :: i, level

    largest = 0
    do i = 1, merge(size(is_listed), 0, n_levels > 1)
      if (is_listed(i)) largest = max(largest, sign * numbers(i))
    end do
    do level = n_levels - 1, 0, -1
      do i = 1, size(is_listed)
        if (.not. is_listed(i)) cycle
        if (level > 0) then
          if (sign * numbers(i) < largest * level / n_levels) cycle
        end if
        n = n + 1
        list(n) = i
        is_listed(i) = .false.
      end do
    end do
  end subroutine list_by_size

  !> Factors the matrix of the listed set. n_columns and n_rows, of list_set: what is known of the factor.
  subroutine factor_matrix(matrix, n_columns, n_rows, workspace, info)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    integer, intent(in) :: n_columns
    integer, intent(in) :: n_rows
    type(lcp_workspace_t), intent(inout) :: workspace
    !> 0 = factored, else the number of a pivot that is zero or not a number
    integer, intent(out) :: info

    associate (n => workspace%n_set)
      workspace%is_cholesky = workspace%is_symmetric
      if (workspace%is_cholesky) then
        call gather(matrix, 1, n_columns, n_rows, workspace)
        call gather(matrix, n_columns + 1, n, 0, workspace)
        call extend_cholesky(n_columns, n_rows, n, workspace%factors, info)
        if (info == 0) return
        workspace%is_cholesky = .false.
      end if
      call gather(matrix, 1, n, 0, workspace)
      call factor_lu(n, workspace%factors, workspace%pivots, info)
    end associate
  end subroutine factor_matrix

  !> Copies columns `first` to `last` of the matrix of the listed set to workspace%factors, without their first n_rows rows.
  pure subroutine gather(matrix, first, last, n_rows, workspace)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    integer, intent(in) :: first
    integer, intent(in) :: last
    integer, intent(in) :: n_rows
    type(lcp_workspace_t), intent(inout) :: workspace
    integer :: i, j

    associate (active => workspace%active)
      do j = first, last
        do i = n_rows + 1, workspace%n_set
          workspace%factors(i, j) = matrix(active(i), active(j))
        end do
      end do
    end associate
  end subroutine gather

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

  !> Estimates the reciprocal condition number (1-norm) of the set's matrix from its factors. `matrix` is the whole W; the set is
  !> not empty. Sets is_singular, too.
  subroutine estimate_condition(matrix, workspace)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(lcp_workspace_t), intent(inout) :: workspace
    real(rk) :: column_sum, norm
    integer :: i, j

    norm = 0
    associate (n => workspace%n_set, reciprocal => workspace%reciprocal_condition)
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
      workspace%is_estimated = .true.
      workspace%is_singular = .not. reciprocal > singular_reciprocal
      if (workspace%is_singular) call workspace%forget_sets()
    end associate
  end subroutine estimate_condition

  !> Computes lambda_A = -W_AA^-1 q_A with the factors in the workspace; lambda is 0 in the other rows.
  subroutine solve_set(q, workspace)
    real(rk), intent(in) :: q(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    integer :: i

    workspace%lambda(:size(q)) = 0
    associate (n => workspace%n_set)
      if (n == 0) return
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
    end associate
  end subroutine solve_set

  !> Computes the solutions x_A = -W_AA^-1 q_A for several q, with the factors of factor_set; they are 0 in the other rows.
  !> Requires: is_singular is false.
  subroutine solve_for_set(self, q, x)
    class(lcp_workspace_t), intent(in) :: self
    !> shape (n, n_columns)
    real(rk), intent(in) :: q(:, :)
    !> shape (n, n_columns)
    real(rk), intent(out) :: x(:, :)
    real(rk) :: inside(self%n_set, size(q, 2))

    x = 0
    associate (active => self%active(:self%n_set))
      inside = -q(active, :)
      if (self%is_cholesky) then
        call solve_cholesky(self%n_set, self%factors, inside)
      else
        call solve_lu(self%n_set, self%factors, self%pivots, inside)
      end if
      x(active, :) = inside
    end associate
  end subroutine solve_for_set

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
