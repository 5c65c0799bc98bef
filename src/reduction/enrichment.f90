! SPDX-License-Identifier: BSD-3-Clause
!> Algorithm 1: which hat functions of contact nodes join the basis so that the contact rows are well conditioned.
module sig_enrichment
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use sig_condition_number, only: condition_of_values
  use sig_kinds, only: rk
  use sig_singular_update, only: column_space_t, decompose_columns, keep_largest, ratio_with_column
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: enrichment_rule_t, enrichment_path_t, choose_hats

  type :: enrichment_rule_t
    !> take the best hat each time; otherwise all of them in their order
    logical :: is_greedy = .true.
    !> none where the rank of (11) is full without hats
    logical :: is_auto = .false.
    !> [-] greedy ends at this kappa with full rank
    real(rk) :: max_condition_number = 10
    integer :: max_hats = huge(1)
    !> [-] singular values below this times the largest count as zero
    real(rk) :: rank_tolerance = 1.0e-10_rk
  end type enrichment_rule_t

  !> Chosen hats, and what the contact rows are like before the first and after each: arrays from 0 to the number of hats.
  type :: enrichment_path_t
    !> indices of the candidates in the order of the choice
    integer, allocatable :: chosen(:)
    !> of (11)
    integer, allocatable :: ranks(:)
    !> [-] kappa, infinite below full rank
    real(rk), allocatable :: condition_numbers(:)
    !> [-] largest singular value over the smallest one that is not zero
    real(rk), allocatable :: ratios(:)
  end type enrichment_path_t

contains

  !> Adds hats until kappa is small enough and the rank full, or no candidate is left.
  !>
  !> M = B[A_lambda, A_c] V[A_c] grows by a column per hat, which is zero but for the row of the hat's pair.
  !> Source: Algorithm 1, (11), (12). Local. Ties go to the lowest candidate. Cost: per hat one decomposition of M, and per
  !> candidate n_rows times the steps of a root search.
  !> Paper: Algorithm 1 has no branch for a sweep in which no candidate lowers kappa, and the first hats usually raise it: the best
  !> candidate of a sweep joins anyway. Below full rank the smallest value that is not zero stands for the last. What is below
  !> the rank tolerance (pairs that are closed in all snapshots give many such values) is rounding, which must not choose.
  !> Candidates are one hat per pair, because the second one adds no direction to the columns of M.
  subroutine choose_hats(contact_matrix, rows, entries, rule, path)
    !> M, shape (n_rows, n_modes)
    real(rk), intent(in) :: contact_matrix(:, :)
    !> row of each candidate in M
    integer, intent(in) :: rows(:)
    !> [-] and its entry there, not zero
    real(rk), intent(in) :: entries(:)
    type(enrichment_rule_t), intent(in) :: rule
    type(enrichment_path_t), intent(out) :: path
    type(column_space_t) :: space
    real(rk) :: matrix(size(contact_matrix, 1), size(contact_matrix, 2) + size(rows))
    logical :: is_left(size(rows))
    integer :: i_hat, n_columns

    n_columns = size(contact_matrix, 2)
    matrix = 0
    matrix(:, :n_columns) = contact_matrix
    is_left = .true.
    call start_path(path)
    do
      call decompose_columns(matrix(:, :n_columns), space)
      call append_state(space%values, size(matrix, 1), rule, path)
      call keep_largest(space, path%ranks(size(path%ranks)))
      if (.not. any(is_left) .or. is_finished(path, size(matrix, 1), rule)) exit
      i_hat = findloc(is_left, .true., dim=1)
      if (rule%is_greedy) i_hat = best_hat(space, rows, entries, is_left)
      is_left(i_hat) = .false.
      path%chosen = [path%chosen, i_hat]
      n_columns = n_columns + 1
      matrix(rows(i_hat), n_columns) = entries(i_hat)
    end do
  end subroutine choose_hats

  pure subroutine start_path(path)
    type(enrichment_path_t), intent(out) :: path

    allocate (path%chosen(0), path%ranks(0), path%condition_numbers(0), path%ratios(0))
  end subroutine start_path

  pure subroutine append_state(sigma, n_rows, rule, path)
    !> singular values of M, descending
    real(rk), intent(in) :: sigma(:)
    integer, intent(in) :: n_rows
    type(enrichment_rule_t), intent(in) :: rule
    type(enrichment_path_t), intent(inout) :: path
    real(rk) :: kappa, ratio
    integer :: rank

    call condition_of_values(sigma, n_rows, rule%rank_tolerance, kappa, rank)
    ratio = 1
    if (n_rows > 0) ratio = ieee_value(ratio, ieee_positive_inf)
    if (rank > 0) ratio = sigma(1) / sigma(rank)
    path%ranks = [path%ranks, rank]
    path%condition_numbers = [path%condition_numbers, kappa]
    path%ratios = [path%ratios, ratio]
  end subroutine append_state

  pure logical function is_finished(path, n_rows, rule)
    type(enrichment_path_t), intent(in) :: path
    integer, intent(in) :: n_rows
    type(enrichment_rule_t), intent(in) :: rule

    associate (last => size(path%ranks))
      is_finished = rule%is_auto .and. path%ranks(1) == n_rows
      if (is_finished) return
      is_finished = rule%is_greedy .and. (size(path%chosen) >= rule%max_hats .or. &
        (path%ranks(last) == n_rows .and. path%condition_numbers(last) <= rule%max_condition_number))
    end associate
  end function is_finished

  !> Candidate that leaves the lowest ratio.
  pure integer function best_hat(space, rows, entries, is_left) result(i_best)
    type(column_space_t), intent(in) :: space
    integer, intent(in) :: rows(:)
    real(rk), intent(in) :: entries(:)
    logical, intent(in) :: is_left(:)
    real(rk) :: ratios(size(rows)), column(size(space%left, 1))
    integer :: i

    ratios = 0
    do i = 1, size(rows)
      if (.not. is_left(i)) cycle
      column = 0
      column(rows(i)) = entries(i)
      ratios(i) = ratio_with_column(space, column)
    end do
    i_best = findloc(is_left .and. ratios <= (1 + tie_tolerance) * minval(ratios, mask=is_left), .true., dim=1)
  end function best_hat
end module sig_enrichment
