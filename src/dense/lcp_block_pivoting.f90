! SPDX-License-Identifier: BSD-3-Clause
!> Block principal pivoting for a linear complementarity problem. All indices with a wrong sign enter or leave the active set at
!> once. After three such exchanges without a new smallest number of wrong signs, only one index is exchanged at a time (Murty's
!> rule), until there are fewer wrong signs than ever before.
module sig_lcp_block_pivoting
  use sig_bits, only: n_words, pack_bits
  use sig_kinds, only: rk
  use sig_lcp_types, only: evaluate_set, lcp_workspace_t
  use sig_reasons, only: reason_converged, reason_cycle
  implicit none(type, external)
  private
  public :: run_block_pivoting

  !> number of block exchanges in a row that are allowed although there are not fewer wrong signs than ever before
  integer, parameter :: max_trials = 3

contains

  !> Runs block principal pivoting for lambda >= 0, w = W lambda + q >= 0, lambda' w = 0. It starts from a given set and ends when
  !> no sign is wrong (solved), single exchanges come back to a set, the matrix of a set is singular, or 5 n + 50 sets were
  !> evaluated. Requires: workspace%reserve, and workspace%is_symmetric is set.
  !>
  !> Source: Judice and Pires, Comput. Oper. Res. 21 (1994) 587; Murty's rule, here with the highest index. In exact arithmetic the
  !> method ends for P-matrices, but Murty's rule may need 2**n steps there, and it may cycle for other matrices.
  subroutine run_block_pivoting(matrix, q, is_active, workspace, reason, n_iterations)
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
    integer :: fewest, i, max_solves, n_single, n_trials, n_violated
    logical :: is_back

    reason = reason_cycle
    fewest = size(q) + 1
    n_trials = max_trials
    n_single = 0
    max_solves = 5 * size(q) + 50
    do n_iterations = 1, max_solves
      call evaluate_set(matrix, q, is_active, workspace)
      if (workspace%is_singular) return
      n_violated = count(workspace%is_violated(:size(q)))
      if (n_violated == 0) then
        reason = reason_converged
        return
      end if
      n_single = merge(n_single + 1, 0, n_violated >= fewest .and. n_trials == 0)
      call look_back(is_active, n_single, workspace, is_back)
      if (is_back) return
      call choose_exchange(n_violated, workspace%is_violated(:size(q)), fewest, n_trials)
      do i = 1, size(q)
        is_active(i) = is_active(i) .neqv. workspace%is_violated(i)
      end do
    end do
    n_iterations = max_solves
  end subroutine run_block_pivoting

  !> Sets is_back to whether the single exchanges have come back to the set that is kept: they would then repeat without end.
  !>
  !> The set is kept at the exchanges 1, 2, 4, 8 and so on (Brent), so that a cycle of any length is found.
  pure subroutine look_back(is_active, n_single, workspace, is_back)
    !> the set before the exchange
    logical, intent(in) :: is_active(:)
    !> number of single exchanges in a row, this one included; 0 where this is a block exchange
    integer, intent(in) :: n_single
    type(lcp_workspace_t), intent(inout) :: workspace
    logical, intent(out) :: is_back

    is_back = .false.
    if (n_single == 0) return
    associate (now => workspace%history(:n_words(size(is_active)), 1), kept => workspace%history(:n_words(size(is_active)), 2))
      call pack_bits(is_active, now)
      is_back = n_single > 1 .and. all(now == kept)
      if (popcnt(n_single) == 1) kept = now
    end associate
  end subroutine look_back

  !> Chooses the indices to exchange: all wrong signs, or only the one with the highest index if they are not fewer than ever before
  !> and no trials are left. Updates `fewest` and n_trials: fewer wrong signs than ever give max_trials new trials.
  pure subroutine choose_exchange(n_violated, is_violated, fewest, n_trials)
    !> number of wrong signs, > 0
    integer, intent(in) :: n_violated
    !> on entry the wrong signs, on exit the indices to exchange
    logical, intent(inout) :: is_violated(:)
    !> smallest number of wrong signs so far
    integer, intent(inout) :: fewest
    !> number of block exchanges that are still allowed without fewer wrong signs
    integer, intent(inout) :: n_trials
    integer :: i_last

    if (n_violated < fewest) then
      fewest = n_violated
      n_trials = max_trials
    else if (n_trials > 0) then
      n_trials = n_trials - 1
    else
      i_last = findloc(is_violated, .true., dim=1, back=.true.)
      is_violated = .false.
      is_violated(i_last) = .true.
    end if
  end subroutine choose_exchange
end module sig_lcp_block_pivoting
