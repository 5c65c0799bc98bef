! SPDX-License-Identifier: BSD-3-Clause
!> Contact rows of two surfaces whose nodes need not match: n_j . (u_j - sum_l w_jl u_l) <= D_j at each node j of the first surface
!> that faces the second one, with w_jl = integral Phi_j N_l / integral Phi_j and D_j = integral Phi_j g / integral Phi_j; on faces
!> of six or eight nodes with u~_j of sig_changed_basis in the place of u_j.
module sig_mortar_rows
  use sig_contact_rows, only: contact_rows_t
  use sig_deck_config, only: contact_config_t
  use sig_errors, only: error_t
  use sig_initial_gap, only: set_initial_gaps
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model_t
  use sig_mesh, only: mesh_t
  use sig_mortar_entries, only: create_mortar_rows
  use sig_mortar_sides, only: create_side, mortar_side_t
  use sig_mortar_sums, only: mortar_sums_t
  use sig_mortar_surfaces, only: integrate_mortar
  use sig_mortar_words, only: cover_text, far_text, finer_text, gap_text, largest_share
  use sig_node_pairs, only: node_pairs_t
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
    integer :: n_rows

    call open_surfaces(mesh, contact, i_entry, deck_path, surfaces, error)
    if (allocated(error)) return
    call check_common_nodes(mesh, surfaces, error)
    if (allocated(error)) return
    sites = sites_of(mesh, surfaces, is_prescribed)
    call create_side(mesh, surfaces%first_facets, surfaces%first_geometry, first, spread_normals(mesh%n_nodes, sites), &
      model%is_round)
    call create_side(mesh, surfaces%second_facets, surfaces%second_geometry, second)
    limit = default_search * max(first%longest, second%longest)
    if (contact(i_entry)%has_search_distance) limit = contact(i_entry)%search_distance
    call integrate_mortar(model, mesh%n_nodes, first, second, limit, sums)
    call keep_sites(sums%has_row(sites%first_node), first, sites, n_rows)
    if (n_rows == 0) then
      call refuse_facing(surfaces, error, 'no part of the first faces the second' // far_text(sums))
      return
    end if
    associate (owners => sites%first_node(:n_rows))
      sites%initial_gap(:n_rows) = sums%gaps(owners) / sums%areas(owners)
    end associate
    note = cover_text(surfaces, sums, limit) // gap_text(sites%initial_gap(:n_rows), first%longest)
    call check_overlap(surfaces, sites%initial_gap(:n_rows), first, error)
    if (.not. allocated(error)) call set_initial_gaps(mesh, contact, deck_path, terms, sites, error)
    if (allocated(error)) return
    call create_mortar_rows(sites, n_rows, first, sums, contact(i_entry)%has_initial_gap, terms%n_terms(), more)
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
    allocate (sites%second_node(sites%n_pairs), source=0)
    allocate (sites%gap_factors(sites%n_pairs, 0))
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

  !> The sites with rows, and behind them those that rows take part of: corners without a row beside a mid-side node with one.
  pure subroutine keep_sites(has_row, first, sites, n_rows)
    !> of the sites
    logical, intent(in) :: has_row(:)
    type(mortar_side_t), intent(in) :: first
    type(node_pairs_t), intent(inout) :: sites
    integer, intent(out) :: n_rows
    logical :: is_end(0:size(first%ends, 2))
    integer :: i

    is_end = .false.
    do i = 1, sites%n_pairs
      if (has_row(i)) is_end(first%ends(:, sites%first_node(i))) = .true.
    end do
    n_rows = count(has_row)
    associate (kept => [pack([(i, i=1, sites%n_pairs)], has_row), &
      pack([(i, i=1, sites%n_pairs)], is_end(sites%first_node) .and. .not. has_row)])
      sites%n_pairs = size(kept)
      sites%first_node = sites%first_node(kept)
      sites%second_node = sites%second_node(kept)
      sites%normal = sites%normal(:, kept)
      sites%gap_factors = sites%gap_factors(kept, :)
      sites%contact_entry = sites%contact_entry(kept)
    end associate
    allocate (sites%initial_gap(sites%n_pairs), source=0.0_rk)
  end subroutine keep_sites

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
        if (any(n_rows_of_node(owner) > 0)) then
          call refuse_other_contact(mesh, surfaces, owner(findloc(n_rows_of_node(owner) > 0, .true., dim=1)), error)
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
  pure subroutine check_overlap(surfaces, gaps, first, error)
    type(surface_pair_t), intent(in) :: surfaces
    !> [length] of the rows
    real(rk), intent(in) :: gaps(:)
    type(mortar_side_t), intent(in) :: first
    type(error_t), allocatable, intent(out) :: error

    if (maxval(gaps) < -first%longest) call refuse_overlap(surfaces, 'node', -maxval(gaps), error)
  end subroutine check_overlap
end module sig_mortar_rows
