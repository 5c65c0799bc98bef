! SPDX-License-Identifier: BSD-3-Clause
!> Contact rows of facing nodes and of nodes that face an obstacle: +n on the first node, -n on the second.
module sig_node_pair_rows
  use sig_contact_rows, only: contact_rows_t, create_contact_rows
  use sig_deck_config, only: contact_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_kinds, only: rk
  use sig_mesh, only: find_group, mesh_t
  use sig_node_pairs, only: node_pairs_t
  use sig_surface_measure, only: nodal_areas
  implicit none(type, external)
  private
  public :: create_node_pair_rows, areas_of_pairs

contains

  !> Creates one row per pair, in the order of the pairs: the normal on its first node, minus the normal on its second one if it has
  !> one. As each node is in one pair at most, B B' is diagonal: 2 for a pair and 1 for an obstacle.
  pure subroutine create_node_pair_rows(pairs, areas, n_terms, rows)
    type(node_pairs_t), intent(in) :: pairs
    !> [length**2, length in the plane] shape (n_pairs)
    real(rk), intent(in) :: areas(:)
    !> number of columns of rows%gap: all terms of the problem
    integer, intent(in) :: n_terms
    type(contact_rows_t), intent(out) :: rows
    real(rk) :: gap(pairs%n_pairs, n_terms), weights(size(pairs%normal, 1), 2, pairs%n_pairs)
    integer :: i, n_second(pairs%n_pairs)
    logical :: is_there(2, pairs%n_pairs)

    gap = 0
    gap(:, :size(pairs%gap_factors, 2)) = pairs%gap_factors
    gap(:, 1) = gap(:, 1) + pairs%initial_gap
    do i = 1, pairs%n_pairs
      weights(:, 1, i) = pairs%normal(:, i)
      weights(:, 2, i) = -pairs%normal(:, i)
      is_there(:, i) = [.true., pairs%second_node(i) > 0]
    end do
    n_second = count(is_there, dim=1) - 1
    associate (nodes => [(pairs%first_node(i), pairs%second_node(i), i=1, pairs%n_pairs)], &
      n_dim => size(weights, 1), there => reshape(is_there, [2 * pairs%n_pairs]))
      call create_contact_rows(0 * n_second + 1, n_second, pack(nodes, there), &
        reshape(pack(weights, spread(is_there, 1, n_dim)), [n_dim, count(there)]), gap, areas, pairs%contact_entry, rows)
    end associate
  end subroutine create_node_pair_rows

  !> Returns the share of the first surface's area that belongs to the first node of each pair: per unit thickness in the plane,
  !> with the factor 2 pi r in axisymmetry.
  pure function areas_of_pairs(mesh, body, contact, pairs) result(areas)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> entries of the deck
    type(contact_config_t), intent(in) :: contact(:)
    type(node_pairs_t), intent(in) :: pairs
    !> [length**2, length in the plane] shape (n_pairs)
    real(rk) :: areas(pairs%n_pairs)
    real(rk) :: on_surface(mesh%n_nodes)
    integer :: i_entry, i_group

    areas = 0
    do i_entry = 1, size(contact)
      i_group = find_group(mesh, contact(i_entry)%first%text, mesh%n_dim - 1)
      on_surface = nodal_areas(mesh, body, mesh%groups(i_group)%entities)
      where (pairs%contact_entry == i_entry) areas = on_surface(pairs%first_node)
    end do
  end function areas_of_pairs
end module sig_node_pair_rows
