! SPDX-License-Identifier: BSD-3-Clause
!> Algorithm 1: chooses hat functions of contact nodes to add to the basis, so that the contact rows are well conditioned.
module sig_enrichment
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
  use sig_condition_number, only: condition_of_values
  use sig_kinds, only: rk
  use sig_singular_update, only: column_space_t, decompose_columns, keep_largest, ratio_with_column
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: enrichment_rule_t, enrichment_path_t, choose_hats

  !> [-] at a larger kappa, errors of the modes, which may be rounding, become errors of the multipliers that are as large as these
  real(rk), parameter, public :: largest_kappa = 1.0e6_rk

  !> How hats are chosen, from reduction.enrichment of the deck.
  type :: enrichment_rule_t
    !> take the best hat each time, until a limit below is reached; otherwise take all hats in their order
    logical :: is_greedy = .true.
    !> take no hat if, without hats, the rank of (11) is full and kappa is at most largest_kappa; otherwise choose as is_greedy says
    logical :: is_auto = .false.
    !> [-] the greedy choice ends when the rank is full and kappa is at most this
    real(rk) :: max_condition_number = 10
    !> the greedy choice ends at this number of hats
    integer :: max_hats = huge(1)
    !> [-] singular values below this times the largest count as zero
    real(rk) :: rank_tolerance = 1.0e-10_rk
  end type enrichment_rule_t

  !> The chosen hats, and the rank and conditioning of the contact rows before the first hat and after each. Except for `chosen`,
  !> the arrays have one entry more than there are hats; the first entry is for no hat.
  type :: enrichment_path_t
    !> indices of the candidates in the order of the choice
    integer, allocatable :: chosen(:)
    !> rank of the contact rows (11)
    integer, allocatable :: ranks(:)
    !> [-] kappa, infinite below full rank
    real(rk), allocatable :: condition_numbers(:)
    !> [-] largest singular value over the smallest one above the rank tolerance; infinite if all are zero, 1 without rows
    real(rk), allocatable :: ratios(:)
  end type enrichment_path_t

contains

  !> Chooses hats by the rule. The greedy choice adds hats until kappa is small enough and the rank is full, until max_hats is
  !> reached, or until no candidate is left. It adds none where that is so from the start. Without it (is_greedy is false) all
  !> candidates are added in their order, whatever max_hats is. With is_auto, neither adds a hat where the rank is full without
  !> hats and kappa is at most largest_kappa.
  !>
  !> Each hat adds a column to M = B[A_lambda, A_c] V[A_c]. This column is zero except in the contact row of the hat. Source:
  !> Algorithm 1, (11), (12). Local. Of nearly equal candidates the first is taken. Cost: per hat one decomposition of M, and per
  !> candidate n_rows times the steps of a root search.
  !>
  !> Paper: Algorithm 1 does not say what to do where no candidate lowers kappa, and the first hats usually raise it. Here the best
  !> candidate is added anyway. Where the rank is not full, the smallest singular value above the rank tolerance replaces the
  !> smallest one in kappa. Values below the rank tolerance are rounding and must not influence the choice; pairs that are closed in
  !> all snapshots give many such values. The greedy choice gets one candidate per pair, because a hat on the other side adds no
  !> direction to the columns of M.
  subroutine choose_hats(contact_matrix, rows, entries, rule, path)
    !> M, shape (n_rows, n_modes)
    real(rk), intent(in) :: contact_matrix(:, :)
    !> row of M in which the column of each candidate is not zero, shape (n_candidates)
    integer, intent(in) :: rows(:)
    !> [-] the entry of the column in this row, shape (n_candidates)
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

  !> Appends to the path the rank and kappa of M with the hats so far (kappa is infinite below full rank), and the ratio of its
  !> largest singular value to the smallest one above the rank tolerance.
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

  !> Whether the rule allows no further hat: with is_auto if, without hats, the rank is full and kappa is at most largest_kappa; the
  !> greedy choice also at max_hats, and where the rank is full and kappa is at most max_condition_number.
  pure logical function is_finished(path, n_rows, rule)
    type(enrichment_path_t), intent(in) :: path
    integer, intent(in) :: n_rows
    type(enrichment_rule_t), intent(in) :: rule

    associate (last => size(path%ranks))
      is_finished = rule%is_auto .and. path%ranks(1) == n_rows .and. path%condition_numbers(1) <= largest_kappa
      if (is_finished) return
      is_finished = rule%is_greedy .and. (size(path%chosen) >= rule%max_hats .or. &
        (path%ranks(last) == n_rows .and. path%condition_numbers(last) <= rule%max_condition_number))
    end associate
  end function is_finished

  !> Returns the index of the candidate that is left and gives M with its column the smallest ratio of the largest to the smallest
  !> singular value (ratio_with_column); of nearly equal ones the first. Requires: a candidate is left.
  pure integer function best_hat(space, rows, entries, is_left) result(i_best)
    !> of M with the hats so far, without the singular values that count as zero
    type(column_space_t), intent(in) :: space
    !> rows and entries as in choose_hats
    integer, intent(in) :: rows(:)
    real(rk), intent(in) :: entries(:)
    !> the candidate is not chosen yet
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
