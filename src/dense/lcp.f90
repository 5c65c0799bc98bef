! SPDX-License-Identifier: BSD-3-Clause
!> Linear complementarity problem 0 <= lambda _|_ W lambda + q >= 0, W any square matrix: a fast method first, a safe one last.
module sig_lcp
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_kinds, only: rk
  use sig_lcp_active_set, only: run_active_set
  use sig_lcp_block_pivoting, only: run_block_pivoting
  use sig_lcp_lemke, only: run_lemke
  use sig_lcp_types, only: evaluate_set, lcp_active_set, lcp_block_pivoting, lcp_candidate_t, lcp_failed_accuracy, &
    lcp_failed_cycle, lcp_failed_input, lcp_failed_iterations, lcp_failed_ray, lcp_lemke, lcp_method_name, lcp_reason_text, &
    lcp_solution_t, lcp_solved, sign_tolerance
  implicit none(type, external)
  private
  public :: solve_lcp, lcp_solution_t, lcp_method_name, lcp_reason_text
  public :: lcp_active_set, lcp_block_pivoting, lcp_lemke
  public :: lcp_solved, lcp_failed_accuracy, lcp_failed_input, lcp_failed_iterations, lcp_failed_ray

  !> largest accepted error of an answer, relative to the terms summed in each row
  real(rk), parameter :: accepted_residual = 1.0e-8_rk
  !> covering vectors tried with Lemke's method before a problem counts as without solution
  integer, parameter :: n_paths = 4

contains

  !> Solves 0 <= lambda _|_ W lambda + q >= 0.
  !>
  !> Active set, then block pivoting, then Lemke with a few covering vectors; each is bounded, so the call ends. An answer that
  !> is not unique (W no P-matrix) may depend on the start. q >= 0 is answered by zero. Tolerances are relative to what is summed:
  !> a change of units changes nothing.
  subroutine solve_lcp(matrix, q, is_active_start, solution)
    !> W, shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> guess of the active set, shape (n); of size 0: q < 0 is the guess
    logical, intent(in) :: is_active_start(:)
    type(lcp_solution_t), intent(out) :: solution
    integer :: i_path
    logical :: is_done

    allocate (solution%lambda(size(q)), source=0.0_rk)
    allocate (solution%is_active(size(q)), source=.false.)
    if (.not. (all(ieee_is_finite(matrix)) .and. all(ieee_is_finite(q)))) return
    solution%reason = lcp_solved
    if (all(q >= 0)) return
    solution%is_active = q < 0
    if (size(is_active_start) == size(q)) solution%is_active = is_active_start
    call try_active_set(matrix, q, solution, is_done)
    if (is_done) return
    call try_block_pivoting(matrix, q, solution, is_done)
    if (is_done) return
    do i_path = 1, n_paths
      call try_lemke(matrix, q, i_path, solution, is_done)
      if (is_done) return
    end do
  end subroutine solve_lcp

  subroutine try_active_set(matrix, q, solution, is_done)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    type(lcp_solution_t), intent(inout) :: solution
    logical, intent(out) :: is_done

    solution%method = lcp_active_set
    call run_active_set(matrix, q, solution%is_active, solution%lambda, solution%reason, solution%n_iterations)
    call finish(matrix, q, solution, is_done)
  end subroutine try_active_set

  subroutine try_block_pivoting(matrix, q, solution, is_done)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    type(lcp_solution_t), intent(inout) :: solution
    logical, intent(out) :: is_done
    integer :: n_solves

    solution%method = lcp_block_pivoting
    solution%is_active = .false.
    call run_block_pivoting(matrix, q, solution%is_active, solution%lambda, solution%reason, n_solves)
    solution%n_iterations = solution%n_iterations + n_solves
    call finish(matrix, q, solution, is_done)
  end subroutine try_block_pivoting

  !> Lemke, then one solve on the set that it ends with: its tableau has gathered the round-off of all the pivots.
  subroutine try_lemke(matrix, q, i_path, solution, is_done)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    !> 1 to n_paths
    integer, intent(in) :: i_path
    type(lcp_solution_t), intent(inout) :: solution
    logical, intent(out) :: is_done
    type(lcp_candidate_t) :: candidate
    integer :: n_pivots

    solution%method = lcp_lemke
    call run_lemke(matrix, q, covering_vector(matrix, i_path), solution%lambda, solution%is_active, solution%reason, n_pivots)
    solution%n_iterations = solution%n_iterations + n_pivots
    if (solution%reason == lcp_solved) then
      call evaluate_set(matrix, q, solution%is_active, candidate)
      if (.not. candidate%is_singular) solution%lambda = candidate%lambda
    end if
    call finish(matrix, q, solution, is_done)
  end subroutine try_lemke

  !> Positive vectors without a unit: the size of each row, ones, then ones spread by multiples of the golden ratio.
  pure function covering_vector(matrix, i_path) result(covering)
    real(rk), intent(in) :: matrix(:, :)
    integer, intent(in) :: i_path
    real(rk) :: covering(size(matrix, 1))
    real(rk), parameter :: golden_ratio = 0.5_rk * (1 + sqrt(5.0_rk))
    integer :: i_row

    covering = 1
    if (i_path == 1) covering = sum(abs(matrix), dim=2)
    if (i_path > 2) covering = [(0.1_rk + modulo(i_path * i_row * golden_ratio, 1.0_rk), i_row=1, size(covering))]
    where (covering <= sign_tolerance * maxval(covering)) covering = max(maxval(covering), tiny(covering))
    covering = covering / maxval(covering)
  end function covering_vector

  !> Cuts round-off below zero and checks the answer; no answer leaves zeros behind.
  subroutine finish(matrix, q, solution, is_done)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    type(lcp_solution_t), intent(inout) :: solution
    logical, intent(out) :: is_done

    if (solution%reason == lcp_solved) then
      where (solution%lambda <= sign_tolerance * maxval(solution%lambda)) solution%lambda = 0
      if (.not. is_complementary(matrix, q, solution%lambda)) solution%reason = lcp_failed_accuracy
    end if
    is_done = solution%reason == lcp_solved
    if (.not. is_done) solution%lambda = 0
    solution%is_active = solution%lambda > 0
  end subroutine finish

  !> Whether w = W lambda + q vanishes where lambda > 0 and is not negative elsewhere, against the terms of each row.
  pure function is_complementary(matrix, q, lambda) result(is_answer)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    real(rk), intent(in) :: lambda(:)
    logical :: is_answer
    real(rk) :: row_size(size(q)), w(size(q))

    w = q + matmul(matrix, lambda)
    row_size = abs(q) + matmul(abs(matrix), lambda)
    is_answer = all(merge(abs(w), -w, lambda > 0) <= accepted_residual * row_size)
  end function is_complementary
end module sig_lcp
