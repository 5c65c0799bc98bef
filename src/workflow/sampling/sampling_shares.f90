! SPDX-License-Identifier: BSD-3-Clause
!> Deals the points of a set to shares, which several jobs sample into one results folder (--share), and finds out what shares
!> lack.
module sig_sampling_shares
  use sig_materials, only: varying_constants
  use sig_kinds, only: rk
  use sig_log, only: log_warning
  use sig_point_batches, only: deal_points, point_batches_t
  use sig_problem, only: problem_t
  use sig_share, only: share_t
  use sig_text, only: append_text, counted, join, string_t, to_text
  implicit none(type, external)
  private
  public :: points_of_share, warn_of_missing_points

contains

  !> Returns the numbers of the states of a share, ascending, 1-based. They follow from all states and the share alone, not from
  !> what is solved already: so shares have no state twice and lack none, whichever jobs are stopped and started again. The states
  !> of a history stay together, and so do those with one stiffness (deal_points).
  function points_of_share(problem, states, share) result(numbers)
    type(problem_t), intent(in) :: problem
    !> all of the set, shape (n_parameters, n_states)
    real(rk), intent(in) :: states(:, :)
    type(share_t), intent(in) :: share
    integer, allocatable :: numbers(:)
    type(point_batches_t) :: own
    logical :: is_own(size(states, 2))
    integer :: i

    call deal_points(varying_constants(problem%deck, problem%material_terms, states), share%number, share%n_shares, 1, &
      max(1, problem%deck%history%states%n_times()), own)
    is_own = .false.
    is_own(own%points) = .true.
    numbers = pack([(i, i=1, size(is_own))], is_own)
  end function points_of_share

  !> Warns if shares of which a store has files lack converged solutions, which the run that merges them then has to find.
  subroutine warn_of_missing_points(problem, states, is_done, shares)
    type(problem_t), intent(in) :: problem
    !> all of the set, shape (n_parameters, n_states)
    real(rk), intent(in) :: states(:, :)
    !> of each state, shape (n_states)
    logical, intent(in) :: is_done(:)
    !> those of the files
    type(share_t), intent(in) :: shares(:)
    type(string_t), allocatable :: lacking(:)
    integer, allocatable :: numbers(:)
    integer :: i, k

    allocate (lacking(0))
    do i = 1, size(shares)
      if (any(shares(:i - 1)%n_shares == shares(i)%n_shares)) cycle
      do k = 1, shares(i)%n_shares
        numbers = points_of_share(problem, states, share_t(k, shares(i)%n_shares))
        if (all(is_done(numbers))) cycle
        call append_text(lacking, to_text(k) // '/' // to_text(shares(i)%n_shares) // ' (' // &
          to_text(count(.not. is_done(numbers))) // ' of ' // counted(size(numbers), 'point') // ')')
      end do
    end do
    if (size(lacking) > 0) call log_warning('these shares lack points, which this run solves now: ' // join(lacking, ', '))
  end subroutine warn_of_missing_points
end module sig_sampling_shares
