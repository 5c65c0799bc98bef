! SPDX-License-Identifier: BSD-3-Clause
!> The entries of mortar rows: the normal at the nodes of the first side, shares of the second one, and the gap.
!>
!> In a changed basis the coefficient of a mid-side node j contains the displacements of the corners a and b beside it: the row of j
!> reads n_j . (u~_j - sum_l w_jl u_l) <= D_j with u~_j = (u_j - alpha (u_a + u_b)) / (1 - 2 alpha), also if a and b have no rows.
module sig_mortar_entries
  use sig_changed_basis, only: end_weight, owner_weight
  use sig_contact_rows, only: contact_rows_t, create_contact_rows
  use sig_kinds, only: rk
  use sig_mortar_sides, only: mortar_side_t
  use sig_mortar_sums, only: mortar_sums_t
  use sig_node_pairs, only: node_pairs_t
  implicit none(type, external)
  private
  public :: create_mortar_rows

contains

  !> Makes the rows of the first n_rows sites. Requires: the corners beside a mid-side node with a row and a changed basis are
  !> sites, too.
  subroutine create_mortar_rows(sites, n_rows, first, sums, has_gap, n_terms, rows)
    !> nodes of the first surface with normals and gaps; those with a row come first
    type(node_pairs_t), intent(in) :: sites
    !> number of rows
    integer, intent(in) :: n_rows
    !> the first surface
    type(mortar_side_t), intent(in) :: first
    !> of integrate_mortar
    type(mortar_sums_t), intent(in) :: sums
    !> whether the gap of a site is known, shape (sites%n_pairs): rows that need one that is not known take their mean gap
    logical, intent(in) :: has_gap(:)
    !> number of terms of the gaps
    integer, intent(in) :: n_terms
    type(contact_rows_t), intent(out) :: rows
    real(rk), allocatable :: shares(:), weights(:, :)
    integer, allocatable :: members(:), nodes(:), offsets(:)
    integer :: k, n, n_first(n_rows)

    associate (owners => sites%first_node(:n_rows))
      call sums%collect(owners, offsets, nodes, shares)
      n_first = merge(3, 1, first%ends(1, owners) > 0)
      allocate (weights(size(sites%normal, 1), sum(n_first) + size(nodes)), members(sum(n_first) + size(nodes)))
      n = 0
      do k = 1, n_rows
        call add_nodes([owners(k), first%ends(:, owners(k))], first_weights(first, owners(k)), n_first(k))
        call add_nodes(nodes(offsets(k) + 1:offsets(k + 1)), -shares(offsets(k) + 1:offsets(k + 1)), offsets(k + 1) - offsets(k))
      end do
      call create_contact_rows(n_first, offsets(2:) - offsets(:n_rows), members, weights, &
        gaps_of_rows(sites, n_rows, first, sums, has_gap, n_terms), sums%areas(owners), sites%contact_entry(:n_rows), rows)
    end associate

  contains

    !> Adds the first n_new of some nodes, with coefficients along the normal of row k.
    subroutine add_nodes(new_nodes, new_weights, n_new)
      integer, intent(in) :: new_nodes(:)
      !> [-]
      real(rk), intent(in) :: new_weights(:)
      integer, intent(in) :: n_new
      integer :: i

      do i = 1, n_new
        members(n + i) = new_nodes(i)
        weights(:, n + i) = new_weights(i) * sites%normal(:, k)
      end do
      n = n + n_new
    end subroutine add_nodes
  end subroutine create_mortar_rows

  !> Returns the weights [-] of the owner and of the two corners beside it; the corners have a weight only if the owner has a
  !> changed coefficient.
  pure function first_weights(first, owner) result(weights)
    type(mortar_side_t), intent(in) :: first
    !> natural, 1-based
    integer, intent(in) :: owner
    real(rk) :: weights(3)

    weights = [1.0_rk, 0.0_rk, 0.0_rk]
    if (first%ends(1, owner) > 0) weights = [owner_weight, end_weight, end_weight]
  end function first_weights

  !> Returns D of each row by terms. The gaps g of the sites are values at their nodes, in all terms, and change to the basis of the
  !> file's head as displacements g n do. Then D = n_j . integral Phi_j g n / integral Phi_j for every g n that the shape functions
  !> can follow.
  function gaps_of_rows(sites, n_rows, first, sums, has_gap, n_terms) result(gap)
    type(node_pairs_t), intent(in) :: sites
    integer, intent(in) :: n_rows
    type(mortar_side_t), intent(in) :: first
    type(mortar_sums_t), intent(in) :: sums
    !> shape (sites%n_pairs)
    logical, intent(in) :: has_gap(:)
    !> number of terms of the gaps
    integer, intent(in) :: n_terms
    !> [length]
    real(rk) :: gap(n_rows, n_terms)
    real(rk) :: weights(3)
    integer :: i, k, own(3), site_of(size(first%ends, 2))

    site_of = 0
    site_of(sites%first_node) = [(i, i=1, sites%n_pairs)]
    gap = 0
    do k = 1, n_rows
      own = k
      if (first%ends(1, sites%first_node(k)) > 0) own(2:) = site_of(first%ends(:, sites%first_node(k)))
      if (.not. all(has_gap(own))) then
        gap(k, 1) = sums%mean_gap(sites%first_node(k))
        cycle
      end if
      weights = first_weights(first, sites%first_node(k))
      do i = 1, 3
        call add_gap(own(i), weights(i) * dot_product(sites%normal(:, own(i)), sites%normal(:, k)))
      end do
      gap(k, 1) = gap(k, 1) + rise_of_touch(sites, own, weights)
    end do

  contains

    subroutine add_gap(site, weight)
      integer, intent(in) :: site
      real(rk), intent(in) :: weight

      gap(k, 1) = gap(k, 1) + weight * sites%initial_gap(site)
      associate (factors => sites%gap_factors(site, :))
        gap(k, :size(factors)) = gap(k, :size(factors)) + weight * factors
      end associate
    end subroutine add_gap
  end function gaps_of_rows

  !> Returns how far [length] the gap of a row must rise to the smallest one at its nodes. The coefficient of a mid-side node is
  !> below it, by up to h**2 / (12 R), if a surface of radius R is nearest within about the middle 5/6 of a side of length h. Zero
  !> if terms with parameters differ between the nodes, because then the nearest place moves.
  pure real(rk) function rise_of_touch(sites, own, weights) result(rise)
    type(node_pairs_t), intent(in) :: sites
    !> the owner's site and those of the corners beside it, or the owner's alone
    integer, intent(in) :: own(:)
    !> [-] result of first_weights
    real(rk), intent(in) :: weights(:)

    rise = 0
    associate (factors => sites%gap_factors(own, :), gaps => sites%initial_gap(own))
      if (any(abs(factors - spread(factors(1, :), 1, 3)) > 0)) return
      rise = max(0.0_rk, minval(gaps) - dot_product(weights, gaps))
    end associate
  end function rise_of_touch
end module sig_mortar_entries
