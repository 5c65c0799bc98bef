! SPDX-License-Identifier: BSD-3-Clause
!> Primal-dual active set method for a linear complementarity problem. In each step, every index with a wrong sign enters or leaves
!> the active set. Where the method converges, it usually needs four or five solves, but it may cycle.
module sig_lcp_active_set
  use sig_bits, only: n_words, pack_bits
  use sig_kinds, only: rk
  use sig_lcp_types, only: evaluate_set, lcp_workspace_t, usual_sets
  use sig_reasons, only: reason_converged, reason_cycle
  implicit none(type, external)
  private
  public :: run_active_set

contains

  !> Runs the primal-dual active set method for lambda >= 0, w = W lambda + q >= 0, lambda' w = 0. It starts from a given set and
  !> ends when no sign is wrong (solved), a set comes back, the matrix of a set is singular, or max(usual_sets, n + 1) sets were
  !> evaluated; usual_sets is 50. Requires: workspace%reserve, and workspace%is_symmetric is set.
  subroutine run_active_set(matrix, q, is_active, workspace, reason, n_iterations, is_active_known)
    !> W, shape (n, n)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> on entry the start, on exit the last set, shape (n)
    logical, intent(inout) :: is_active(:)
    !> workspace%lambda is the answer where the problem is solved
    type(lcp_workspace_t), intent(inout) :: workspace
    !> reason_converged, or reason_cycle for all other ends
    integer, intent(out) :: reason
    !> number of sets that were evaluated
    integer, intent(out) :: n_iterations
    !> a set whose answer is known already: the method stops there, too, with reason_cycle; shape (n)
    logical, intent(in), optional :: is_active_known(:)
    integer :: i, i_set, max_sets, n

    n = n_words(size(q))
    max_sets = max(usual_sets, size(q) + 1)
    reason = reason_cycle
    call pack_bits(is_active, workspace%history(:n, 1))
    n_iterations = 0
    do i_set = 1, max_sets
      if (present(is_active_known)) then
        if (all(is_active .eqv. is_active_known)) return
      end if
      n_iterations = i_set
      call evaluate_set(matrix, q, is_active, workspace)
      if (workspace%is_singular) return
      if (.not. any(workspace%is_violated(:size(q)))) then
        reason = reason_converged
        return
      end if
      do i = 1, size(q)
        is_active(i) = is_active(i) .neqv. workspace%is_violated(i)
      end do
      call pack_bits(is_active, workspace%history(:n, i_set + 1))
      if (was_visited(workspace%history(:n, :i_set + 1))) return
    end do
  end subroutine run_active_set

  !> Whether the last set is among those before it; one set per column, by pack_bits.
  pure logical function was_visited(history)
    integer, intent(in) :: history(:, :)
    integer :: i_set

    was_visited = .true.
    do i_set = 1, size(history, 2) - 1
      if (all(history(:, i_set) == history(:, size(history, 2)))) return
    end do
    was_visited = .false.
  end function was_visited
end module sig_lcp_active_set
