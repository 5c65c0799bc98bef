! SPDX-License-Identifier: BSD-3-Clause
!> What the methods for the linear complementarity problem share: the answer, its reasons, the candidate of one index set.
module sig_lcp_types
  use sig_kinds, only: rk
  use sig_linear_algebra, only: lu_t
  implicit none(type, external)
  private
  public :: lcp_solution_t, lcp_candidate_t, lcp_method_name, lcp_reason_text, evaluate_set

  !> method that gave the answer (or tried last)
  integer, parameter, public :: lcp_active_set = 1
  integer, parameter, public :: lcp_block_pivoting = 2
  integer, parameter, public :: lcp_lemke = 3

  !> reasons: > 0 solved, < 0 failed
  integer, parameter, public :: lcp_solved = 1
  !> an entry of the matrix or of q is not finite
  integer, parameter, public :: lcp_failed_input = -1
  !> Lemke's path ended on a secondary ray: most often there is no solution
  integer, parameter, public :: lcp_failed_ray = -2
  !> more steps than the method allows
  integer, parameter, public :: lcp_failed_iterations = -3
  !> an answer was found, but round-off has spoiled it
  integer, parameter, public :: lcp_failed_accuracy = -4
  !> an index set came back, or its matrix is singular: the next method takes over
  integer, parameter, public :: lcp_failed_cycle = -5

  !> A sign is wrong only beyond this times the size of what was summed, so that ties do not flicker by round-off.
  real(rk), parameter, public :: sign_tolerance = 1.0e-12_rk
  !> an ill-conditioned set widens the tolerance up to here
  real(rk), parameter :: widest_tolerance = 1.0e-8_rk

  !> Answer of 0 <= lambda _|_ W lambda + q >= 0.
  type :: lcp_solution_t
    !> [unit of W^-1 q] >= 0, shape (n)
    real(rk), allocatable :: lambda(:)
    !> lambda > 0, shape (n)
    logical, allocatable :: is_active(:)
    !> lcp_active_set, lcp_block_pivoting or lcp_lemke
    integer :: method = lcp_active_set
    !> lcp_solved or one of lcp_failed_*
    integer :: reason = lcp_failed_input
    !> linear solves and pivots of all the methods tried
    integer :: n_iterations = 0
  end type lcp_solution_t

  !> lambda and w of one index set, and which of their signs are wrong.
  type :: lcp_candidate_t
    !> zero outside the set, shape (n)
    real(rk), allocatable :: lambda(:)
    !> zero on the set, shape (n)
    real(rk), allocatable :: w(:)
    !> lambda < 0 on the set or w < 0 outside it, beyond the tolerance, shape (n)
    logical, allocatable :: is_violated(:)
    !> the set's matrix has no inverse; nothing else is defined then
    logical :: is_singular = .false.
    !> sign tolerance that its condition allows
    real(rk) :: tolerance = sign_tolerance
  end type lcp_candidate_t

contains

  !> lambda_A = -W_AA^-1 q_A, w = W lambda + q outside A.
  subroutine evaluate_set(matrix, q, is_active, candidate)
    !> shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> the set A, shape (n)
    logical, intent(in) :: is_active(:)
    type(lcp_candidate_t), intent(out) :: candidate
    type(lu_t) :: lu
    integer, allocatable :: active(:)
    integer :: i_row, n

    n = size(q)
    active = pack([(i_row, i_row=1, n)], is_active)
    call lu%factor(matrix(active, active))
    candidate%is_singular = lu%is_singular
    if (lu%is_singular) return
    candidate%tolerance = condition_tolerance(lu%reciprocal_condition)
    allocate (candidate%lambda(n), candidate%w(n), source=0.0_rk)
    allocate (candidate%is_violated(n))
    if (size(active) > 0) candidate%lambda(active) = -lu%solve(q(active))
    call find_violations(matrix, q, is_active, active, candidate)
  end subroutine evaluate_set

  !> Signs against what was summed: each w against the terms of its row, each multiplier against the largest one.
  subroutine find_violations(matrix, q, is_active, active, candidate)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    logical, intent(in) :: is_active(:)
    integer, intent(in) :: active(:)
    type(lcp_candidate_t), intent(inout) :: candidate
    real(rk), allocatable :: row_size(:)
    real(rk) :: largest
    integer :: i_active, k

    candidate%w = q
    row_size = abs(q)
    do i_active = 1, size(active)
      k = active(i_active)
      candidate%w = candidate%w + matrix(:, k) * candidate%lambda(k)
      row_size = row_size + abs(matrix(:, k) * candidate%lambda(k))
    end do
    largest = maxval(abs(candidate%lambda), mask=is_active)
    where (is_active)
      candidate%w = 0
      candidate%is_violated = candidate%lambda < -candidate%tolerance * largest
    else where
      candidate%is_violated = candidate%w < -candidate%tolerance * row_size
    end where
  end subroutine find_violations

  !> Round-off of a solve grows with the condition number, and the sign tolerance with it.
  pure function condition_tolerance(reciprocal_condition) result(tolerance)
    real(rk), intent(in) :: reciprocal_condition
    real(rk) :: tolerance

    tolerance = 10 * epsilon(tolerance) / max(reciprocal_condition, epsilon(tolerance))
    tolerance = min(max(tolerance, sign_tolerance), widest_tolerance)
  end function condition_tolerance

  !> Name of a method as in reports.
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

  !> A reason in words, to stand after "the complementarity problem ".
  pure function lcp_reason_text(reason) result(text)
    integer, intent(in) :: reason
    character(:), allocatable :: text

    select case (reason)
    case (lcp_solved)
      text = 'is solved'
    case (lcp_failed_input)
      text = 'has an entry that is not a finite number'
    case (lcp_failed_ray)
      text = 'has no solution that Lemke''s method can reach'
    case (lcp_failed_iterations)
      text = 'took more pivots than allowed'
    case (lcp_failed_accuracy)
      text = 'is too ill-conditioned for a reliable answer'
    case (lcp_failed_cycle)
      text = 'made the index sets cycle'
    case default
      text = 'ended for an unknown reason'
    end select
  end function lcp_reason_text
end module sig_lcp_types
