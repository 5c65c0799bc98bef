! SPDX-License-Identifier: BSD-3-Clause
!> Contact rows of a surface and a rigid obstacle in a changed basis (sig_changed_basis), for quadratic facets on which a uniform
!> pressure has no or a pulling force at some nodes. They are mortar rows without a second side: the whole surface counts as facing
!> the obstacle, so that integral Phi_j = integral N~_j, and D_j comes from the gaps at the nodes (sig_mortar_entries).
module sig_obstacle_rows
  use sig_changed_basis, only: end_weight, owner_weight
  use sig_contact_rows, only: contact_rows_t
  use sig_deck_config, only: contact_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_errors, only: error_t
  use sig_initial_gap, only: set_initial_gaps
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mortar_conflicts, only: conflict_t, find_conflict
  use sig_mortar_entries, only: create_mortar_rows
  use sig_mortar_sides, only: create_side, mortar_side_t
  use sig_mortar_sums, only: mortar_sums_t
  use sig_node_pairs, only: node_pairs_t
  use sig_surface_measure, only: nodal_areas
  use sig_surface_pair, only: refuse, surface_pair_t
  use sig_surface_pairing, only: open_surfaces
  use sig_term_set, only: term_set_t
  implicit none(type, external)
  private
  public :: add_obstacle_rows

contains

  !> Appends the rows of one entry of the deck's contact section, which has an obstacle: one for each node of its surface.
  !>
  !> Errors: those of open_surfaces and set_initial_gaps; a reason of find_conflict, such as a node in two contacts. Then the rows
  !> are unchanged.
  subroutine add_obstacle_rows(mesh, body, contact, i_entry, deck_path, is_prescribed, terms, rows, error)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> entries of the deck's contact section
    type(contact_config_t), intent(in) :: contact(:)
    !> number of the entry, 1-based
    integer, intent(in) :: i_entry
    !> path of the deck, for messages
    character(*), intent(in) :: deck_path
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    !> grows by the terms of the gap
    type(term_set_t), intent(inout) :: terms
    !> in: rows of the entries before; out: with the new rows behind them
    type(contact_rows_t), intent(inout) :: rows
    type(error_t), allocatable, intent(out) :: error
    type(surface_pair_t) :: surfaces
    type(mortar_side_t) :: side
    type(mortar_sums_t) :: sums
    type(node_pairs_t) :: sites
    type(contact_rows_t) :: more
    type(conflict_t), allocatable :: conflict

    call open_surfaces(mesh, contact, i_entry, deck_path, surfaces, error)
    if (allocated(error)) return
    sites = sites_of(surfaces)
    call create_side(mesh, surfaces%first_facets, surfaces%first_geometry, side, spread(sites%normal(:, 1), 2, mesh%n_nodes), &
      body%mechanics%is_round)
    call set_initial_gaps(mesh, contact, deck_path, terms, sites, error)
    if (allocated(error)) return
    call sums%start(mesh%n_nodes)
    sums%areas = changed_areas(nodal_areas(mesh, body, surfaces%first_facets), side%ends)
    call create_mortar_rows(sites, sites%n_pairs, side, sums, spread(.true., 1, sites%n_pairs), terms%n_terms(), more)
    call find_conflict(mesh, contact, is_prescribed, rows, more, conflict)
    if (allocated(conflict)) then
      call refuse(surfaces, surfaces%entry%first, conflict%message, error, conflict%hint)
      return
    end if
    call rows%append(more)
  end subroutine add_obstacle_rows

  !> Returns the nodes of the surface, which all face the obstacle, with gaps of 0.
  pure function sites_of(surfaces) result(sites)
    type(surface_pair_t), intent(in) :: surfaces
    type(node_pairs_t) :: sites

    sites%n_pairs = size(surfaces%first_nodes)
    sites%first_node = surfaces%first_nodes
    sites%normal = surfaces%normals
    allocate (sites%second_node(sites%n_pairs), source=0)
    allocate (sites%gap_factors(sites%n_pairs, 0))
    allocate (sites%initial_gap(sites%n_pairs), source=0.0_rk)
    allocate (sites%contact_entry(sites%n_pairs), source=surfaces%i_entry)
  end function sites_of

  !> Returns the integrals of N~_j from those of N_j: a mid-side node gives the share alpha to each corner beside it.
  pure function changed_areas(areas, ends) result(changed)
    !> [length**2, length in the plane] integrals of N_j over the surface, shape (n_nodes)
    real(rk), intent(in) :: areas(:)
    !> corners beside a node whose coefficient changes, 0 elsewhere; shape (2, n_nodes)
    integer, intent(in) :: ends(:, :)
    real(rk) :: changed(size(areas))
    integer :: i

    changed = areas
    do i = 1, size(areas)
      if (ends(1, i) == 0) cycle
      changed(i) = areas(i) / owner_weight
      changed(ends(:, i)) = changed(ends(:, i)) - end_weight / owner_weight * areas(i)
    end do
  end function changed_areas
end module sig_obstacle_rows
