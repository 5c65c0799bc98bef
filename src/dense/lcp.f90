! SPDX-License-Identifier: BSD-3-Clause
!> Solves the linear complementarity problem lambda >= 0, w = W lambda + q >= 0, lambda' w = 0 for any square matrix W. Fast methods
!> are tried first, a safe one last.
module sig_lcp
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_kinds, only: rk
  use sig_lcp_active_set, only: run_active_set
  use sig_lcp_block_pivoting, only: run_block_pivoting
  use sig_lcp_lemke, only: run_lemke
  use sig_lcp_types, only: evaluate_set, lcp_active_set, lcp_block_pivoting, lcp_lemke, lcp_method_name, lcp_solution_t, &
    lcp_workspace_t, sign_tolerance, widest_tolerance
  use sig_linear_algebra, only: sum_rows
  use sig_reasons, only: reason_converged, reason_cycle, reason_ill_conditioned, reason_max_pivots, reason_not_finite, &
    reason_ray
  implicit none(type, external)
  private
  public :: solve_lcp, change_sets, find_other_solution, lcp_solution_t, lcp_workspace_t, lcp_method_name
  public :: lcp_active_set, lcp_block_pivoting, lcp_lemke

  !> [-] largest accepted violation of the conditions, relative to the terms that each row sums
  real(rk), parameter :: accepted_residual = 1.0e-8_rk
  !> [-] solutions whose multipliers differ by at most this fraction of the largest multiplier count as the same
  real(rk), parameter :: same_solution = 1.0e-6_rk
  !> number of covering vectors that are tried with Lemke's method before a problem counts as without solution
  integer, parameter :: n_paths = 4

contains

  !> Solves lambda >= 0, w = W lambda + q >= 0, lambda' w = 0. solution%reason is reason_converged where that succeeds; otherwise it
  !> says why not, and lambda is zero.
  !>
  !> The methods are active set and block pivoting with a narrow tolerance for wrong signs, then both with a wide one, then Lemke's
  !> with up to four covering vectors. Each has a limited number of steps. The first method whose result meets the conditions within
  !> accepted_residual (1e-8) gives the answer. Otherwise the reason is that of the last path of Lemke's method, or
  !> reason_ill_conditioned if its result misses the conditions; it is reason_not_finite if W or q is not finite. For q >= 0, also
  !> without rows, the answer is zero. Where the solution is not unique (W is no P-matrix), the answer may depend on the start. All
  !> tolerances are relative, so units do not matter. With a workspace and a solution that were used before for a problem of this
  !> size, nothing is allocated, except by the first use of Lemke's method.
  subroutine solve_lcp(matrix, q, is_active_start, solution, workspace)
    !> W, shape (n, n)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> guess of the active set (lambda > 0), from which the active set method starts, shape (n); with size 0 the guess is q < 0
    logical, intent(in) :: is_active_start(:)
    type(lcp_solution_t), intent(inout) :: solution
    !> work space for many problems; default: one for this problem alone. workspace%w is W lambda + q where lambda is not zero
    type(lcp_workspace_t), intent(inout), optional :: workspace
    type(lcp_workspace_t) :: own

    if (present(workspace)) then
      call solve_in(matrix, q, is_active_start, solution, workspace)
    else
      call solve_in(matrix, q, is_active_start, solution, own)
    end if
  end subroutine solve_lcp

  subroutine solve_in(matrix, q, is_active_start, solution, workspace)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    logical, intent(in) :: is_active_start(:)
    type(lcp_solution_t), intent(inout) :: solution
    type(lcp_workspace_t), intent(inout) :: workspace
    real(rk), parameter :: tolerances(2) = [sign_tolerance, widest_tolerance]
    integer :: i_path, i_try
    logical :: is_done

    call start_solution(size(q), solution)
    if (.not. all(ieee_is_finite(q))) return
    if (.not. workspace%is_known) then
      if (.not. is_finite(matrix)) return
    end if
    solution%reason = reason_converged
    solution%residual = 0
    if (all(q >= 0)) return
    call workspace%reserve(size(q))
    if (.not. workspace%is_known) workspace%is_symmetric = is_symmetric(matrix)
    workspace%is_known = workspace%has_one_matrix
    tries: do i_try = 1, size(tolerances)
      workspace%tolerance = tolerances(i_try)
      if (size(is_active_start) == size(q)) then
        solution%is_active = is_active_start
      else
        solution%is_active = q < 0
      end if
      call try_active_set(matrix, q, solution, workspace, is_done)
      if (is_done) exit tries
      call try_block_pivoting(matrix, q, solution, workspace, is_done)
      if (is_done) exit tries
    end do tries
    workspace%tolerance = sign_tolerance
    if (is_done) return
    call workspace%reserve_tableau()
    do i_path = 1, n_paths
      call try_lemke(matrix, q, i_path, solution, workspace, is_done)
      if (is_done) return
    end do
  end subroutine solve_in

  !> Solves the problem of solve_lcp by the active set method alone, for a start that is nearly the active set of the answer. The
  !> matrix must be finite and is taken as not symmetric. If this fails, lambda is zero, and solution%reason is reason_cycle,
  !> reason_ill_conditioned, or reason_not_finite if q is not finite; solve_lcp may still succeed.
  !>
  !> A set of k unknowns costs about k^3 / 3 + 2 n k operations; no cost grows with n^2.
  subroutine change_sets(matrix, q, is_active_start, solution, workspace)
    !> W, shape (n, n)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> guess of the active set, shape (n)
    logical, intent(in) :: is_active_start(:)
    type(lcp_solution_t), intent(inout) :: solution
    !> workspace%w is W lambda + q where the problem is solved
    type(lcp_workspace_t), intent(inout) :: workspace
    logical :: is_done, was_symmetric

    call start_solution(size(q), solution)
    call workspace%reserve(size(q))
    call workspace%forget_sets()
    if (.not. all(ieee_is_finite(q))) return
    was_symmetric = workspace%is_symmetric
    workspace%is_symmetric = .false.
    solution%is_active = is_active_start
    call try_active_set(matrix, q, solution, workspace, is_done)
    call workspace%forget_sets()
    ! of the matrix of solve_lcp
    workspace%is_symmetric = was_symmetric
  end subroutine change_sets

  !> Looks for a second solution of a problem that is already solved, by the active set method alone from another start.
  !>
  !> Nothing is found if the method meets the active set of the known solution, a set for the second time, or a set with a singular
  !> matrix, if it reaches its limit of steps (run_active_set), or if it ends with the same multipliers or with a residual above
  !> accepted_residual. This does not prove that there is only one solution. Nothing is allocated with a workspace and a solution
  !> that were used before for a problem of this size.
  subroutine find_other_solution(matrix, q, is_active_start, known, other, workspace, is_found)
    !> W, shape (n, n)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> guess of the active set, shape (n)
    logical, intent(in) :: is_active_start(:)
    !> from solve_lcp, with reason_converged
    type(lcp_solution_t), intent(in) :: known
    !> the second solution, if is_found; otherwise only its n_iterations (number of sets that were tried) counts
    type(lcp_solution_t), intent(inout) :: other
    type(lcp_workspace_t), intent(inout) :: workspace
    !> whether `other` is a solution with a multiplier that differs from that of `known` by more than same_solution (1e-6) times the
    !> largest multiplier of both
    logical, intent(out) :: is_found

    call start_solution(size(q), other)
    call workspace%reserve(size(q))
    call workspace%take_other_matrix()
    workspace%is_symmetric = is_symmetric(matrix)
    other%is_active = is_active_start
    call run_active_set(matrix, q, other%is_active, workspace, other%reason, other%n_iterations, known%is_active)
    call finish(matrix, q, workspace, other, is_found)
    if (is_found) is_found = maxval(abs(other%lambda - known%lambda)) > &
      same_solution * max(maxval(other%lambda), maxval(known%lambda))
  end subroutine find_other_solution

  !> Sets a solution to n zeros without an answer: its reason is reason_not_finite, its method lcp_active_set, its residual huge.
  pure subroutine start_solution(n, solution)
    integer, intent(in) :: n
    type(lcp_solution_t), intent(inout) :: solution

    if (allocated(solution%lambda)) then
      if (size(solution%lambda) /= n) deallocate (solution%lambda, solution%is_active)
    end if
    if (.not. allocated(solution%lambda)) allocate (solution%lambda(n), solution%is_active(n))
    solution%lambda = 0
    solution%is_active = .false.
    solution%method = lcp_active_set
    solution%reason = reason_not_finite
    solution%n_iterations = 0
    solution%residual = huge(solution%residual)
  end subroutine start_solution

  !> Whether all entries are finite: 0 * x is 0 for a finite x, and else not a number.
  pure logical function is_finite(matrix)
    real(rk), contiguous, intent(in) :: matrix(:, :)

    is_finite = abs(sum(0 * matrix)) <= 0
  end function is_finite

  subroutine try_active_set(matrix, q, solution, workspace, is_done)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    type(lcp_solution_t), intent(inout) :: solution
    type(lcp_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_done

    solution%method = lcp_active_set
    call run_active_set(matrix, q, solution%is_active, workspace, solution%reason, solution%n_iterations)
    call finish(matrix, q, workspace, solution, is_done)
  end subroutine try_active_set

  subroutine try_block_pivoting(matrix, q, solution, workspace, is_done)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    type(lcp_solution_t), intent(inout) :: solution
    type(lcp_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_done
    integer :: n_solves

    solution%method = lcp_block_pivoting
    solution%is_active = .false.
    call run_block_pivoting(matrix, q, solution%is_active, workspace, solution%reason, n_solves)
    solution%n_iterations = solution%n_iterations + n_solves
    call finish(matrix, q, workspace, solution, is_done)
  end subroutine try_block_pivoting

  !> Runs Lemke's method, then solves once with its last active set, because the tableau contains the rounding errors of all pivots.
  !> If the matrix of this set is singular, the tableau's answer counts. is_done: the problem is solved.
  subroutine try_lemke(matrix, q, i_path, solution, workspace, is_done)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    !> 1 to n_paths
    integer, intent(in) :: i_path
    type(lcp_solution_t), intent(inout) :: solution
    type(lcp_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_done
    integer :: n_pivots

    solution%method = lcp_lemke
    call set_covering(matrix, i_path, workspace%covering(:size(q)))
    call run_lemke(matrix, q, workspace, solution%is_active, solution%reason, n_pivots)
    solution%n_iterations = solution%n_iterations + n_pivots
    if (solution%reason == reason_converged) then
      solution%lambda = workspace%lambda(:size(q))
      call evaluate_set(matrix, q, solution%is_active, workspace)
      if (workspace%is_singular) workspace%lambda(:size(q)) = solution%lambda
    end if
    call finish(matrix, q, workspace, solution, is_done)
  end subroutine try_lemke

  !> Chooses the positive covering vector of a path. Path 1: the sum of |W_ij| of each row; a row whose sum is at most 1e-12 of the
  !> largest sum gets the largest one. Path 2: ones. Later paths: numbers between 0.1 and 1.1 by multiples of the golden ratio. All
  !> entries are then divided by the largest one.
  pure subroutine set_covering(matrix, i_path, covering)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    integer, intent(in) :: i_path
    real(rk), intent(out) :: covering(:)
    real(rk), parameter :: golden_ratio = 0.5_rk * (1 + sqrt(5.0_rk))
    real(rk) :: largest
    integer :: i_row

    do i_row = 1, size(covering)
      covering(i_row) = 1
      if (i_path == 1) covering(i_row) = sum(abs(matrix(i_row, :)))
      if (i_path > 2) covering(i_row) = 0.1_rk + modulo(i_path * i_row * golden_ratio, 1.0_rk)
    end do
    largest = maxval(covering)
    where (covering <= sign_tolerance * largest) covering = max(largest, tiny(covering))
    covering = covering / max(largest, tiny(covering))
  end subroutine set_covering

  !> If solution%reason is reason_converged, takes lambda from the workspace, sets values that are negative or at most 1e-12 of the
  !> largest to zero, and checks the conditions: a residual above accepted_residual gives reason_ill_conditioned. Where there is no
  !> answer, lambda is zero and the residual huge. Sets is_active to lambda > 0, and is_done to whether there is an answer.
  pure subroutine finish(matrix, q, workspace, solution, is_done)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    !> workspace%lambda is defined where solution%reason is reason_converged
    type(lcp_workspace_t), intent(inout) :: workspace
    type(lcp_solution_t), intent(inout) :: solution
    logical, intent(out) :: is_done
    real(rk) :: smallest

    solution%lambda = 0
    if (solution%reason == reason_converged) then
      associate (lambda => workspace%lambda(:size(q)))
        smallest = sign_tolerance * maxval(lambda)
        where (lambda > smallest) solution%lambda = lambda
        if (.not. workspace%has_openings .or. any(abs(lambda - solution%lambda) > 0)) &
          call sum_rows(matrix, solution%lambda, q, workspace%w, workspace%row_size)
      end associate
      call measure_residual(matrix, q, smallest, workspace, solution)
      if (.not. solution%residual <= accepted_residual) solution%reason = reason_ill_conditioned
    end if
    is_done = solution%reason == reason_converged
    if (.not. is_done) then
      solution%lambda = 0
      solution%residual = huge(solution%residual)
    end if
    solution%is_active = solution%lambda > 0
  end subroutine finish

  !> Sets solution%residual: the largest of |w| on rows with lambda > 0 and of -w elsewhere, each divided by the size of its row;
  !> w, in the workspace, is W lambda + q for solution%lambda; 0 if none is positive, huge if such a size is not finite. The size
  !> is the sum of the absolute values of the terms of w. Where the residual would be too large, the size is made larger, so that a
  !> w that negligible multipliers would remove is accepted.
  pure subroutine measure_residual(matrix, q, negligible, workspace, solution)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    !> multipliers up to this one were set to zero
    real(rk), intent(in) :: negligible
    type(lcp_workspace_t), intent(inout) :: workspace
    type(lcp_solution_t), intent(inout) :: solution
    real(rk) :: size_of_row, violation
    integer :: i

    solution%residual = 0
    do i = 1, size(q)
      violation = merge(abs(workspace%w(i)), -workspace%w(i), solution%lambda(i) > 0)
      size_of_row = workspace%row_size(i)
      if (violation > accepted_residual * size_of_row) &
        size_of_row = size_of_row + negligible * sum(abs(matrix(i, :))) / accepted_residual
      if (violation > 0) solution%residual = max(solution%residual, violation / size_of_row)
      if (.not. size_of_row <= huge(violation)) solution%residual = huge(violation)
    end do
  end subroutine measure_residual

  !> Whether the matrix is exactly symmetric. Callers make a matrix that should be symmetric exactly so.
  pure logical function is_symmetric(matrix)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    ! a large matrix is not read column by column in one and row by row in the other order
    integer, parameter :: tile = 64
    integer :: first, i, j, last

    is_symmetric = .false.
    do first = 1, size(matrix, 1), tile
      last = min(first + tile - 1, size(matrix, 1))
      do j = 1, last
        do i = max(first, j + 1), last
          if (abs(matrix(i, j) - matrix(j, i)) > 0) return
        end do
      end do
    end do
    is_symmetric = .true.
  end function is_symmetric
end module sig_lcp
