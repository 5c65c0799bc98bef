! SPDX-License-Identifier: BSD-3-Clause
!> Contact rows of two surfaces whose nodes need not match: n_j . (u_j - sum_l w_jl u_l) <= D_j at each node j of the first surface
!> that faces the second one, with w_jl = integral Phi_j N_l / integral Phi_j and D_j = integral Phi_j g / integral Phi_j.
module sig_mortar_rows
  use sig_contact_rows, only: contact_rows_t, create_contact_rows
  use sig_deck_config, only: contact_config_t
  use sig_errors, only: error_t
  use sig_initial_gap, only: set_initial_gaps
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model_t
  use sig_mesh, only: mesh_t
  use sig_mortar_sides, only: create_side, mortar_side_t
  use sig_mortar_sums, only: mortar_sums_t
  use sig_mortar_surfaces, only: integrate_mortar
  use sig_node_pairs, only: node_pairs_t
  use sig_quadratic_contact, only: check_weights
  use sig_surface_pair, only: node_text, refuse, refuse_common_node, refuse_facing, refuse_overlap, short_text, surface_pair_t
  use sig_surface_pairing, only: open_surfaces
  use sig_term_set, only: term_set_t
  implicit none(type, external)
  private
  public :: add_mortar_rows

  !> [-] default search distance over the longest edge of both surfaces
  real(rk), parameter :: default_search = 50.0_rk
  !> [-] a normal with a smaller part along free components belongs to a node that cannot move along it
  real(rk), parameter :: free_enough = 1.0e-6_rk
  !> [-] one with a larger part leans on a plane of symmetry, and is straightened
  real(rk), parameter :: nearly_free = 0.9_rk

contains

  !> Rows of one entry of the deck's contact section behind those that are there.
  !>
  !> Errors: surfaces that do not face each other; a node of the first surface that belongs to another contact, or cannot move along
  !> its normal while other rows share the nodes that it faces.
  subroutine add_mortar_rows(mesh, model, contact, i_entry, deck_path, is_prescribed, terms, rows, note, error)
    type(mesh_t), intent(in) :: mesh
    type(mechanical_model_t), intent(in) :: model
    type(contact_config_t), intent(in) :: contact(:)
    integer, intent(in) :: i_entry
    character(*), intent(in) :: deck_path
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    !> grows by what an initial gap depends on
    type(term_set_t), intent(inout) :: terms
    type(contact_rows_t), intent(inout) :: rows
    !> how much of the first surface faces the second one
    character(:), allocatable, intent(out) :: note
    type(error_t), allocatable, intent(out) :: error
    type(surface_pair_t) :: surfaces
    type(mortar_side_t) :: first, second
    type(mortar_sums_t) :: sums
    type(node_pairs_t) :: sites
    type(contact_rows_t) :: more
    real(rk) :: limit
    integer :: i

    call open_surfaces(mesh, contact, i_entry, deck_path, surfaces, error)
    if (allocated(error)) return
    call check_common_nodes(mesh, surfaces, error)
    if (.not. allocated(error)) call check_weights(mesh, surfaces, surfaces%entry%first, surfaces%first_facets, &
      'the first surface of mortar contact', error)
    if (allocated(error)) return
    sites = sites_of(mesh, surfaces, is_prescribed)
    call create_side(mesh, surfaces%first_facets, surfaces%first_geometry, first, spread_normals(mesh%n_nodes, sites))
    call create_side(mesh, surfaces%second_facets, surfaces%second_geometry, second)
    limit = default_search * max(first%longest, second%longest)
    if (contact(i_entry)%has_search_distance) limit = contact(i_entry)%search_distance
    call integrate_mortar(model, mesh%n_nodes, first, second, limit, sums)
    sites = keep_sites(sites, pack([(i, i=1, sites%n_pairs)], sums%has_row(sites%first_node)))
    if (sites%n_pairs == 0) then
      call refuse_facing(surfaces, error, 'no part of the first faces the second' // far_text(sums))
      return
    end if
    sites%initial_gap = sums%gaps(sites%first_node) / sums%areas(sites%first_node)
    note = cover_text(surfaces, sums, limit) // gap_text(sites%initial_gap, first%longest)
    call check_overlap(surfaces, sites, first, error)
    if (.not. allocated(error)) call set_initial_gaps(mesh, contact, deck_path, terms, sites, error)
    if (allocated(error)) return
    call create_rows(sites, sums, terms%n_terms(), more)
    call check_rows(mesh, surfaces, is_prescribed, rows, more, error)
    if (allocated(error)) return
    call rows%append(more)
    note = note // ', shares of up to ' // short_text(largest_share(more)) // finer_text(surfaces, first, second)
  end subroutine add_mortar_rows

  !> The nodes of the first surface with their normals. Where a plane of symmetry holds a node, its normal lies in that plane.
  pure function sites_of(mesh, surfaces, is_prescribed) result(sites)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    logical, intent(in) :: is_prescribed(:)
    type(node_pairs_t) :: sites
    real(rk) :: free(mesh%n_dim)
    integer :: i

    sites%n_pairs = size(surfaces%first_nodes)
    sites%first_node = surfaces%first_nodes
    sites%normal = surfaces%normals
    allocate (sites%second_node(sites%n_pairs), sites%gap_term(sites%n_pairs), source=0)
    allocate (sites%contact_entry(sites%n_pairs), source=surfaces%i_entry)
    do i = 1, sites%n_pairs
      free = merge(0.0_rk, sites%normal(:, i), is_held(mesh%n_dim, sites%first_node(i), is_prescribed))
      if (norm2(free) > nearly_free) sites%normal(:, i) = free / norm2(free)
    end do
  end function sites_of

  pure function is_held(n_dim, node, is_prescribed)
    integer, intent(in) :: n_dim
    integer, intent(in) :: node
    logical, intent(in) :: is_prescribed(:)
    logical :: is_held(n_dim)

    is_held = is_prescribed(n_dim * (node - 1) + 1:n_dim * node)
  end function is_held

  pure function spread_normals(n_nodes, sites) result(normals)
    integer, intent(in) :: n_nodes
    type(node_pairs_t), intent(in) :: sites
    real(rk) :: normals(size(sites%normal, 1), n_nodes)

    normals = 0
    normals(:, sites%first_node) = sites%normal
  end function spread_normals

  pure function keep_sites(sites, indices) result(kept)
    type(node_pairs_t), intent(in) :: sites
    integer, intent(in) :: indices(:)
    type(node_pairs_t) :: kept

    kept%n_pairs = size(indices)
    kept%first_node = sites%first_node(indices)
    kept%second_node = sites%second_node(indices)
    kept%normal = sites%normal(:, indices)
    kept%gap_term = sites%gap_term(indices)
    kept%contact_entry = sites%contact_entry(indices)
  end function keep_sites

  !> Errors: a node on both surfaces.
  pure subroutine check_common_nodes(mesh, surfaces, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    type(error_t), allocatable, intent(out) :: error
    logical :: is_second(mesh%n_nodes)
    integer :: i

    is_second = .false.
    is_second(surfaces%second_nodes) = .true.
    i = findloc(is_second(surfaces%first_nodes), .true., dim=1)
    if (i > 0) call refuse_common_node(mesh, surfaces, surfaces%first_nodes(i), error)
  end subroutine check_common_nodes

  !> Errors: a node of the first surface that other rows meet, too; one that cannot move along its normal.
  pure subroutine check_rows(mesh, surfaces, is_prescribed, rows, more, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    logical, intent(in) :: is_prescribed(:)
    !> of the entries before, and of this one
    type(contact_rows_t), intent(in) :: rows, more
    type(error_t), allocatable, intent(out) :: error
    integer :: k, n_rows_of_node(mesh%n_nodes)
    logical :: is_owner(mesh%n_nodes)

    is_owner = .false.
    is_owner(rows%owners()) = .true.
    n_rows_of_node = rows%rows_per_node(mesh%n_nodes)
    do k = 1, more%n_rows
      associate (owner => more%first_nodes_of(k), met => more%second_nodes_of(k))
        if (n_rows_of_node(owner(1)) > 0) then
          call refuse_other_contact(mesh, surfaces, owner(1), error)
        else if (any(is_owner(met))) then
          call refuse_other_contact(mesh, surfaces, met(findloc(is_owner(met), .true., dim=1)), error)
        else if (is_stuck(more, k, is_prescribed)) then
          call refuse(surfaces, surfaces%entry%first, 'the displacement of ' // node_text(mesh, owner(1)) // &
            ' is prescribed along its normal, so that it cannot carry a contact force', error, &
            'swap first and second, or leave the prescribed part out of the first surface')
        end if
      end associate
      if (allocated(error)) return
    end do
  end subroutine check_rows

  !> The owner cannot move along its normal, others of the row can.
  pure logical function is_stuck(rows, row, is_prescribed)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: row
    logical, intent(in) :: is_prescribed(:)
    real(rk) :: free(size(rows%dofs_of(row)))

    free = merge(0.0_rk, rows%coefficients_of(row), is_prescribed(rows%dofs_of(row)))
    is_stuck = norm2(free(:rows%n_dim)) < free_enough .and. norm2(free) > free_enough
  end function is_stuck

  pure subroutine refuse_other_contact(mesh, surfaces, node, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    integer, intent(in) :: node
    type(error_t), allocatable, intent(out) :: error

    call refuse(surfaces, surfaces%entry%first, node_text(mesh, node) // ' is in another contact, too', error, &
      'give each contact surfaces with nodes of their own')
  end subroutine refuse_other_contact

  !> Errors: every node overlaps by more than an element.
  pure subroutine check_overlap(surfaces, sites, first, error)
    type(surface_pair_t), intent(in) :: surfaces
    type(node_pairs_t), intent(in) :: sites
    type(mortar_side_t), intent(in) :: first
    type(error_t), allocatable, intent(out) :: error

    if (maxval(sites%initial_gap) < -first%longest) call refuse_overlap(surfaces, 'node', -maxval(sites%initial_gap), error)
  end subroutine check_overlap

  subroutine create_rows(sites, sums, n_terms, rows)
    type(node_pairs_t), intent(in) :: sites
    type(mortar_sums_t), intent(in) :: sums
    integer, intent(in) :: n_terms
    type(contact_rows_t), intent(out) :: rows
    real(rk), allocatable :: gap(:, :), shares(:), weights(:, :)
    integer, allocatable :: members(:), nodes(:), offsets(:)
    integer :: i, k, n_dim

    call sums%collect(sites%first_node, offsets, nodes, shares)
    n_dim = size(sites%normal, 1)
    allocate (gap(sites%n_pairs, n_terms), source=0.0_rk)
    gap(:, 1) = sites%initial_gap
    allocate (weights(n_dim, sites%n_pairs + size(nodes)), members(sites%n_pairs + size(nodes)))
    do k = 1, sites%n_pairs
      if (sites%gap_term(k) > 0) gap(k, sites%gap_term(k)) = gap(k, sites%gap_term(k)) + 1
      associate (own => offsets(k) + k)
        members(own) = sites%first_node(k)
        weights(:, own) = sites%normal(:, k)
        do i = 1, offsets(k + 1) - offsets(k)
          members(own + i) = nodes(offsets(k) + i)
          weights(:, own + i) = -shares(offsets(k) + i) * sites%normal(:, k)
        end do
      end associate
    end do
    call create_contact_rows([(1, k=1, sites%n_pairs)], offsets(2:) - offsets(:sites%n_pairs), members, weights, gap, &
      sums%areas(sites%first_node), sites%contact_entry, rows)
  end subroutine create_rows

  !> `96.2 % of 'plate_top' faces 'foot'`, and what is left out.
  pure function cover_text(surfaces, sums, limit) result(text)
    type(surface_pair_t), intent(in) :: surfaces
    type(mortar_sums_t), intent(in) :: sums
    real(rk), intent(in) :: limit
    character(:), allocatable :: text

    associate (entry => surfaces%entry)
      text = percent_text(sums%covered, sums) // " of '" // entry%first%text // "' faces '" // entry%second%text // "'"
      if (sums%far > 0) text = text // ', ' // percent_text(sums%far, sums) // ' beyond the search distance of ' // &
        short_text(limit) // ', where no contact is possible (search_distance)'
      if (sums%lost > 0) text = text // ', ' // percent_text(sums%lost, sums) // ' in facets of which too little faces it, ' // &
        'where no contact is possible'
    end associate
  end function cover_text

  pure function percent_text(area, sums) result(text)
    real(rk), intent(in) :: area
    type(mortar_sums_t), intent(in) :: sums
    character(:), allocatable :: text

    text = short_text(100 * area / sums%whole) // ' %'
  end function percent_text

  !> `, gaps of 0 to 0.02`
  pure function gap_text(gaps, extent) result(text)
    real(rk), intent(in) :: gaps(:)
    !> [length] of an edge
    real(rk), intent(in) :: extent
    character(:), allocatable :: text
    !> [-] of an edge: a smaller gap is rounding
    real(rk), parameter :: rounding = 1.0e-9_rk
    real(rk) :: ends(2)

    ends = [minval(gaps), maxval(gaps)]
    where (abs(ends) < rounding * extent) ends = 0
    text = ', gaps of ' // short_text(ends(1)) // ' to ' // short_text(ends(2))
  end function gap_text

  !> [-] of any node of the second side in any row.
  pure real(rk) function largest_share(rows) result(largest)
    type(contact_rows_t), intent(in) :: rows
    integer :: i

    largest = 0
    associate (coefficients => reshape(rows%coefficients, [rows%n_dim, size(rows%coefficients) / rows%n_dim]))
      do i = 1, rows%n_rows
        associate (second => coefficients(:, rows%splits(i) / rows%n_dim + 1:rows%offsets(i + 1) / rows%n_dim))
          largest = max(largest, maxval(norm2(second, dim=1)))
        end associate
      end do
    end associate
  end function largest_share

  pure function finer_text(surfaces, first, second) result(text)
    type(surface_pair_t), intent(in) :: surfaces
    type(mortar_side_t), intent(in) :: first, second
    character(:), allocatable :: text

    text = ''
    if (first%longest > second%longest) text = "; '" // surfaces%entry%first%text // "' has the longer edges: contact is more " // &
      'accurate with the finer surface as first'
  end function finer_text

  pure function far_text(sums) result(text)
    type(mortar_sums_t), intent(in) :: sums
    character(:), allocatable :: text

    text = ''
    if (sums%far > 0) text = ' within the search distance (search_distance)'
  end function far_text
end module sig_mortar_rows
