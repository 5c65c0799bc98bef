! SPDX-License-Identifier: BSD-3-Clause
!> Primal-dual active set: every wrong sign changes sides at once. Four or five solves when it converges; it may cycle.
module sig_lcp_active_set
  use sig_kinds, only: rk
  use sig_lcp_types, only: evaluate_set, lcp_candidate_t, lcp_failed_cycle, lcp_solved
  implicit none(type, external)
  private
  public :: run_active_set

  !> a problem that needs more sets than this, and than unknowns, is left to block pivoting
  integer, parameter :: usual_sets = 50

contains

  !> Runs from a given set until no sign is wrong, a set comes back, or its matrix is singular.
  subroutine run_active_set(matrix, q, is_active, lambda, reason, n_iterations)
    !> shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> start; on exit the last set, shape (n)
    logical, intent(inout) :: is_active(:)
    !> defined when solved, shape (n)
    real(rk), intent(inout) :: lambda(:)
    !> lcp_solved or lcp_failed_cycle
    integer, intent(out) :: reason
    !> linear solves
    integer, intent(out) :: n_iterations
    type(lcp_candidate_t) :: candidate
    logical, allocatable :: history(:, :)
    integer :: max_sets

    max_sets = max(usual_sets, size(q) + 1)
    allocate (history(size(q), max_sets))
    reason = lcp_failed_cycle
    do n_iterations = 1, max_sets
      history(:, n_iterations) = is_active
      call evaluate_set(matrix, q, is_active, candidate)
      if (candidate%is_singular) return
      if (.not. any(candidate%is_violated)) then
        lambda = candidate%lambda
        reason = lcp_solved
        return
      end if
      is_active = is_active .neqv. candidate%is_violated
      if (was_visited(history(:, :n_iterations), is_active)) return
    end do
    n_iterations = max_sets
  end subroutine run_active_set

  !> Whether a set is among those of the history.
  pure function was_visited(history, is_active) result(is_known)
    logical, intent(in) :: history(:, :)
    logical, intent(in) :: is_active(:)
    logical :: is_known
    integer :: i_set

    is_known = .true.
    do i_set = 1, size(history, 2)
      if (all(history(:, i_set) .eqv. is_active)) return
    end do
    is_known = .false.
  end function was_visited
end module sig_lcp_active_set
