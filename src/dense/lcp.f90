! SPDX-License-Identifier: BSD-3-Clause
!> Linear complementarity problem 0 <= lambda _|_ W lambda + q >= 0, W any square matrix: a fast method first, a safe one last.
module sig_lcp
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_kinds, only: rk
  use sig_lcp_active_set, only: run_active_set
  use sig_lcp_block_pivoting, only: run_block_pivoting
  use sig_lcp_lemke, only: run_lemke
  use sig_lcp_types, only: evaluate_set, lcp_active_set, lcp_block_pivoting, lcp_lemke, lcp_method_name, lcp_solution_t, &
    lcp_workspace_t, sign_tolerance, sum_rows
  use sig_reasons, only: reason_converged, reason_cycle, reason_ill_conditioned, reason_max_pivots, reason_not_finite, &
    reason_ray
  implicit none(type, external)
  private
  public :: solve_lcp, change_sets, find_other_solution, lcp_solution_t, lcp_workspace_t, lcp_method_name
  public :: lcp_active_set, lcp_block_pivoting, lcp_lemke

  !> largest accepted error of an answer, relative to the terms summed in each row
  real(rk), parameter :: accepted_residual = 1.0e-8_rk
  !> [-] solutions whose multipliers differ by less than this share of the largest one are one solution
  real(rk), parameter :: same_solution = 1.0e-6_rk
  !> covering vectors tried with Lemke's method before a problem counts as without solution
  integer, parameter :: n_paths = 4

contains

  !> Solves 0 <= lambda _|_ W lambda + q >= 0.
  !>
  !> Active set, then block pivoting, then Lemke with a few covering vectors; each is bounded, so the call ends. An answer that
  !> is not unique (W no P-matrix) may depend on the start. q >= 0 is answered by zero. Tolerances are relative to what is summed:
  !> a change of units changes nothing. With a workspace and a solution that were used before nothing is allocated.
  subroutine solve_lcp(matrix, q, is_active_start, solution, workspace)
    !> W, shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> guess of the active set, shape (n); of size 0: q < 0 is the guess
    logical, intent(in) :: is_active_start(:)
    type(lcp_solution_t), intent(inout) :: solution
    type(lcp_workspace_t), intent(inout), optional :: workspace
    type(lcp_workspace_t) :: own

    if (present(workspace)) then
      call solve_in(matrix, q, is_active_start, solution, workspace)
    else
      call solve_in(matrix, q, is_active_start, solution, own)
    end if
  end subroutine solve_lcp

  subroutine solve_in(matrix, q, is_active_start, solution, workspace)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    logical, intent(in) :: is_active_start(:)
    type(lcp_solution_t), intent(inout) :: solution
    type(lcp_workspace_t), intent(inout) :: workspace
    integer :: i_path
    logical :: is_done

    call start_solution(size(q), solution)
    if (.not. (is_finite(matrix) .and. all(ieee_is_finite(q)))) return
    solution%reason = reason_converged
    solution%residual = 0
    if (all(q >= 0)) return
    call workspace%reserve(size(q))
    workspace%is_symmetric = is_symmetric(matrix)
    if (size(is_active_start) == size(q)) then
      solution%is_active = is_active_start
    else
      solution%is_active = q < 0
    end if
    call try_active_set(matrix, q, solution, workspace, is_done)
    if (is_done) return
    call try_block_pivoting(matrix, q, solution, workspace, is_done)
    if (is_done) return
    call workspace%reserve_tableau()
    do i_path = 1, n_paths
      call try_lemke(matrix, q, i_path, solution, workspace, is_done)
      if (is_done) return
    end do
  end subroutine solve_in

  !> The active set method alone, from a set that is nearly the answer's, for a matrix that is known to be finite and not symmetric:
  !> a set of k unknowns costs k^3 / 3 + 2 n k operations, and nothing grows with n^2. Not solved: solve_lcp may do it.
  subroutine change_sets(matrix, q, is_active_start, solution, workspace)
    !> shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> shape (n)
    logical, intent(in) :: is_active_start(:)
    type(lcp_solution_t), intent(inout) :: solution
    !> its w is M z + q where solved
    type(lcp_workspace_t), intent(inout) :: workspace
    logical :: is_done

    call start_solution(size(q), solution)
    call workspace%reserve(size(q))
    workspace%is_symmetric = .false.
    if (.not. all(ieee_is_finite(q))) return
    solution%is_active = is_active_start
    call try_active_set(matrix, q, solution, workspace, is_done)
  end subroutine change_sets

  !> Looks for another solution of a problem that is solved, by the active set method alone from another start.
  !>
  !> The way ends where it meets the known solution's set, comes back to a set, or meets a singular one: it finds nothing then.
  !> That is no proof that there is one solution only. With a workspace and a solution that were used before nothing is allocated.
  subroutine find_other_solution(matrix, q, is_active_start, known, other, workspace, is_found)
    !> W, shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> guess of the active set, shape (n)
    logical, intent(in) :: is_active_start(:)
    !> of solve_lcp, solved
    type(lcp_solution_t), intent(in) :: known
    type(lcp_solution_t), intent(inout) :: other
    type(lcp_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_found

    call start_solution(size(q), other)
    call workspace%reserve(size(q))
    workspace%is_symmetric = is_symmetric(matrix)
    other%is_active = is_active_start
    call run_active_set(matrix, q, other%is_active, workspace, other%reason, other%n_iterations, known%is_active)
    call finish(matrix, q, workspace, other, is_found)
    if (is_found) is_found = maxval(abs(other%lambda - known%lambda)) > &
      same_solution * max(maxval(other%lambda), maxval(known%lambda))
  end subroutine find_other_solution

  !> Starts a solution of n zeros, without an answer yet.
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

  !> Whether the value is finite: zero times a number is zero, and else no number.
  pure logical function is_finite(matrix)
    real(rk), intent(in) :: matrix(:, :)

    is_finite = abs(sum(0 * matrix)) <= 0
  end function is_finite

  subroutine try_active_set(matrix, q, solution, workspace, is_done)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    type(lcp_solution_t), intent(inout) :: solution
    type(lcp_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_done

    solution%method = lcp_active_set
    call run_active_set(matrix, q, solution%is_active, workspace, solution%reason, solution%n_iterations)
    call finish(matrix, q, workspace, solution, is_done)
  end subroutine try_active_set

  subroutine try_block_pivoting(matrix, q, solution, workspace, is_done)
    real(rk), intent(in) :: matrix(:, :)
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

  !> Runs Lemke's method, then solves once with its last set, because its tableau has collected the round-off of all pivots.
  subroutine try_lemke(matrix, q, i_path, solution, workspace, is_done)
    real(rk), intent(in) :: matrix(:, :)
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

  !> Positive vectors without a unit: the size of each row, ones, then ones spread by multiples of the golden ratio.
  pure subroutine set_covering(matrix, i_path, covering)
    real(rk), intent(in) :: matrix(:, :)
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

  !> Takes over an answer without the round-off below zero, and checks it; no answer leaves zeros behind.
  pure subroutine finish(matrix, q, workspace, solution, is_done)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    !> its lambda is defined when solution%reason is reason_converged
    type(lcp_workspace_t), intent(inout) :: workspace
    type(lcp_solution_t), intent(inout) :: solution
    logical, intent(out) :: is_done
    real(rk) :: smallest

    solution%lambda = 0
    if (solution%reason == reason_converged) then
      associate (lambda => workspace%lambda(:size(q)))
        smallest = sign_tolerance * maxval(lambda)
        where (lambda > smallest) solution%lambda = lambda
      end associate
      call measure_residual(matrix, q, workspace, solution)
      if (.not. solution%residual <= accepted_residual) solution%reason = reason_ill_conditioned
    end if
    is_done = solution%reason == reason_converged
    if (.not. is_done) then
      solution%lambda = 0
      solution%residual = huge(solution%residual)
    end if
    solution%is_active = solution%lambda > 0
  end subroutine finish

  !> Measures the largest of |w| where lambda > 0 and of -w elsewhere, w = W lambda + q, each over the terms of its row.
  pure subroutine measure_residual(matrix, q, workspace, solution)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    type(lcp_solution_t), intent(inout) :: solution
    real(rk) :: violation
    integer :: i

    call sum_rows(matrix, q, solution%lambda, workspace)
    solution%residual = 0
    do i = 1, size(q)
      violation = merge(abs(workspace%w(i)), -workspace%w(i), solution%lambda(i) > 0)
      if (violation > 0) solution%residual = max(solution%residual, violation / workspace%row_size(i))
      if (.not. workspace%row_size(i) <= huge(violation)) solution%residual = huge(violation)
    end do
  end subroutine measure_residual

  !> Whether the matrix is symmetric to the last bit: a matrix that is meant to be symmetric is made so.
  pure logical function is_symmetric(matrix)
    real(rk), intent(in) :: matrix(:, :)
    integer :: i, j

    is_symmetric = .false.
    do j = 1, size(matrix, 2)
      do i = j + 1, size(matrix, 1)
        if (abs(matrix(i, j) - matrix(j, i)) > 0) return
      end do
    end do
    is_symmetric = .true.
  end function is_symmetric
end module sig_lcp
