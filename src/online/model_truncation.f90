! SPDX-License-Identifier: BSD-3-Clause
!> Smaller models out of one that was trained: the enrichment after fewer hats, without training again.
module sig_model_truncation
  use sig_model, only: enrichment_history_t, reduced_model_t
  implicit none(type, external)
  private
  public :: keep_first_hats

contains

  !> The reduced model as it was after its first hats: leading columns of the basis, leading blocks of the system.
  !>
  !> Equal to a training with reduction.enrichment.max_hats, but for basis_rank, primal_rank_expected and warnings, which stay.
  !> Requires: 0 <= n_hats <= cluster%n_hats, the history. Cost: copies.
  pure subroutine keep_first_hats(cluster, n_hats)
    type(reduced_model_t), intent(inout) :: cluster
    integer, intent(in) :: n_hats
    integer :: n

    n = cluster%n_modes - cluster%n_hats + n_hats
    cluster%n_modes = n
    cluster%n_hats = n_hats
    cluster%basis = cluster%basis(:, :n)
    cluster%reduced_stiffness = cluster%reduced_stiffness(:n, :n)
    cluster%contact_matrix = cluster%contact_matrix(:, :n)
    cluster%load = cluster%load(:n, :)
    if (size(cluster%contact_value_basis, 1) > 0) cluster%contact_value_basis = cluster%contact_value_basis(:, :n)
    call keep_entries(cluster%history, n_hats + 1)
    cluster%rank = cluster%history%ranks(n_hats + 1)
    cluster%condition_number = cluster%history%condition_numbers(n_hats + 1)
    cluster%stiffness_condition = cluster%history%stiffness_conditions(n_hats + 1)
    cluster%stiffness_rank = min(cluster%stiffness_rank, n)
  end subroutine keep_first_hats

  pure subroutine keep_entries(history, n)
    type(enrichment_history_t), intent(inout) :: history
    integer, intent(in) :: n

    history%rows = history%rows(:n)
    history%nodes = history%nodes(:n)
    history%n_columns = history%n_columns(:n)
    history%ranks = history%ranks(:n)
    history%condition_numbers = history%condition_numbers(:n)
    history%singular_ratios = history%singular_ratios(:n)
    history%stiffness_conditions = history%stiffness_conditions(:n)
  end subroutine keep_entries
end module sig_model_truncation
