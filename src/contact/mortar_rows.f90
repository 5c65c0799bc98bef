! SPDX-License-Identifier: BSD-3-Clause
!> Contact rows of two surfaces whose nodes need not match: n_j . (u_j - sum_l w_jl u_l) <= D_j at each node j of the first surface
!> that faces the second one, with w_jl = integral Phi_j N_l / integral Phi_j and the gap D_j at node j (sig_node_gaps). On facets
!> with a changed basis (sig_mortar_sides), u_j and D_j are those of sig_mortar_entries.
module sig_mortar_rows
  use sig_contact_rows, only: contact_rows_t
  use sig_deck_config, only: contact_config_t, name_config_t
  use sig_errors, only: error_t
  use sig_initial_gap, only: set_initial_gaps
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model_t
  use sig_mesh, only: mesh_t
  use sig_mortar_conflicts, only: conflict_t, find_conflict, shared_text
  use sig_mortar_entries, only: create_mortar_rows
  use sig_mortar_sides, only: create_side, mortar_side_t
  use sig_mortar_sums, only: mortar_sums_t
  use sig_mortar_surfaces, only: integrate_mortar
  use sig_mortar_words, only: cover_text, far_text, finer_text, flat_text, gap_text, largest_share
  use sig_node_gaps, only: find_node_gaps
  use sig_node_pairs, only: node_pairs_t
  use sig_surface_geometry, only: normal_in_symmetry
  use sig_surface_pair, only: refuse, refuse_common_node, refuse_facing, refuse_overlap, surface_pair_t
  use sig_surface_pairing, only: open_surfaces
  use sig_term_set, only: term_set_t
  use sig_text, only: fine_digits, short_number
  implicit none(type, external)
  private
  public :: add_mortar_rows, may_swap, side_choice_t

  !> [-] default search distance over the longest edge of both surfaces
  real(rk), parameter :: default_search = 50.0_rk

  !> The rows of one entry of the deck's contact section, with their terms and a note.
  type :: new_rows_t
    type(surface_pair_t) :: surfaces
    type(contact_rows_t) :: rows
    !> the terms before, and those that an initial gap needs
    type(term_set_t) :: terms
    !> how much of the first surface faces the second one
    character(:), allocatable :: note
  end type new_rows_t

  !> The choice of the side of an entry that carries the rows.
  type :: side_choice_t
    !> why it is the second surface of the deck; not allocated if it is the first one
    character(:), allocatable :: why_swapped
    !> of use only after an error: number of another contact entry that could make this one possible by swapping its own sides, 0 =
    !> none; and why it would
    integer :: i_other = 0
    character(:), allocatable :: why_other
    !> how much of the surface with the rows faces the other one
    character(:), allocatable :: note
  end type side_choice_t

contains

  !> Appends the mortar rows of one entry of the deck's contact section. If find_conflict has a reason against the rows of the first
  !> surface and none against those of the second one, the sides are swapped where may_swap allows it.
  !>
  !> Errors: those of open_surfaces and set_initial_gaps; surfaces that have a common node, do not face each other, or, if the mesh
  !> gives their gap, overlap everywhere by more than the longest edge of the first one; a reason of find_conflict against the order
  !> that is tried first, if the other order is not allowed or is refused, too. Then rows and terms are unchanged.
  subroutine add_mortar_rows(mesh, model, contact, i_entry, deck_path, is_prescribed, terms, rows, choice, error)
    type(mesh_t), intent(in) :: mesh
    type(mechanical_model_t), intent(in) :: model
    !> entries of the deck's contact section
    type(contact_config_t), intent(in) :: contact(:)
    !> number of the entry, 1-based
    integer, intent(in) :: i_entry
    !> path of the deck, for messages
    character(*), intent(in) :: deck_path
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    !> grows by the terms that an initial gap needs
    type(term_set_t), intent(inout) :: terms
    !> in: rows of pairs and of the mortar entries before; out: with the new rows behind them
    type(contact_rows_t), intent(inout) :: rows
    !> in: why_swapped is allocated if the sides must be swapped; out: the choice
    type(side_choice_t), intent(inout) :: choice
    type(error_t), allocatable, intent(out) :: error
    type(new_rows_t) :: more
    type(conflict_t), allocatable :: conflict, its_conflict
    type(error_t), allocatable :: its_error

    call try_order(allocated(choice%why_swapped), conflict, error)
    if (allocated(error)) return
    if (allocated(conflict)) then
      choice%i_other = conflict%i_owner
      if (choice%i_other > 0) choice%why_other = shared_text(mesh, contact, conflict%node, i_entry)
      call refuse(more%surfaces, more%surfaces%entry%first, conflict%message, error, conflict%hint)
      if (.not. may_swap(contact(i_entry)) .or. allocated(choice%why_swapped)) return
      call try_order(.true., its_conflict, its_error)
      if (allocated(its_error)) return
      if (allocated(its_conflict)) then
        if (choice%i_other > 0 .or. its_conflict%i_owner == 0) return
        choice%i_other = its_conflict%i_owner
        choice%why_other = shared_text(mesh, contact, its_conflict%node, i_entry)
        return
      end if
      deallocate (error)
      choice%why_swapped = conflict%message
    end if
    call take_rows(more, terms, rows, choice)

  contains

    !> Builds the rows for one order of the sides and finds what prevents it. Errors: those of build_rows.
    subroutine try_order(is_swapped, speaks_against, failure)
      !> whether the deck's second surface carries the rows
      logical, intent(in) :: is_swapped
      !> reason of find_conflict against this order
      type(conflict_t), allocatable, intent(out) :: speaks_against
      type(error_t), allocatable, intent(out) :: failure
      type(contact_config_t) :: entries(size(contact))

      entries = contact
      if (is_swapped) call swap_sides(entries(i_entry))
      more%terms = terms
      call build_rows(mesh, model, entries, i_entry, deck_path, is_prescribed, is_swapped, more, failure)
      if (allocated(failure)) return
      call find_conflict(mesh, contact, is_prescribed, rows, more%rows, speaks_against)
    end subroutine try_order
  end subroutine add_mortar_rows

  !> Appends new rows, replaces the terms, and sets the note of the choice, which says why the sides are swapped, if they are.
  subroutine take_rows(more, terms, rows, choice)
    type(new_rows_t), intent(in) :: more
    type(term_set_t), intent(inout) :: terms
    type(contact_rows_t), intent(inout) :: rows
    type(side_choice_t), intent(inout) :: choice

    call rows%append(more%rows)
    terms = more%terms
    choice%note = more%note
    if (allocated(choice%why_swapped)) choice%note = 'sides swapped, because ' // choice%why_swapped // &
      " (formulation: mortar keeps the deck's order); " // more%note
  end subroutine take_rows

  !> Whether the sides of an entry may be swapped: it has two, its formulation is auto, and the deck gives no gap that depends on
  !> the place, because such a gap belongs to the nodes of the deck's first surface.
  pure logical function may_swap(entry)
    type(contact_config_t), intent(in) :: entry

    may_swap = entry%formulation == 'auto' .and. .not. entry%has_obstacle .and. &
      .not. (entry%has_initial_gap .and. entry%initial_gap%uses_coordinates)
  end function may_swap

  pure subroutine swap_sides(entry)
    type(contact_config_t), intent(inout) :: entry
    type(name_config_t) :: first

    first = entry%first
    entry%first = entry%second
    entry%second = first
    if (entry%has_direction) entry%direction = -entry%direction
  end subroutine swap_sides

  !> Builds the contact rows of one entry, in the order of its sides. Errors: those of add_mortar_rows except the reasons of
  !> find_conflict.
  subroutine build_rows(mesh, model, contact, i_entry, deck_path, is_prescribed, is_swapped, more, error)
    type(mesh_t), intent(in) :: mesh
    type(mechanical_model_t), intent(in) :: model
    type(contact_config_t), intent(in) :: contact(:)
    integer, intent(in) :: i_entry
    character(*), intent(in) :: deck_path
    logical, intent(in) :: is_prescribed(:)
    !> the entry's first surface is the deck's second one
    logical, intent(in) :: is_swapped
    !> in: the terms that are there; out: with all components
    type(new_rows_t), intent(inout) :: more
    type(error_t), allocatable, intent(out) :: error
    type(mortar_side_t) :: first, second
    type(mortar_sums_t) :: sums
    type(node_pairs_t) :: sites
    logical, allocatable :: has_gap(:)
    real(rk) :: limit
    integer :: n_rows

    call open_surfaces(mesh, contact, i_entry, deck_path, more%surfaces, error)
    if (allocated(error)) return
    associate (surfaces => more%surfaces)
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
      call set_mesh_gaps(mesh, second, sums, limit, n_rows, sites, has_gap)
      more%note = cover_text(surfaces, sums, limit) // gap_text(sites%initial_gap(:n_rows), first%longest)
      if (contact(i_entry)%has_initial_gap) then
        has_gap = .true.
        call set_initial_gaps(mesh, contact, deck_path, more%terms, sites, error)
      else
        call check_overlap(surfaces, sites%initial_gap(:n_rows), first, error)
      end if
      if (allocated(error)) return
      call create_mortar_rows(sites, n_rows, first, sums, has_gap, more%terms%n_terms(), more%rows)
      more%note = more%note // ', shares of up to ' // short_number(largest_share(more%rows), fine_digits) // &
        finer_text(surfaces, first, second, is_swapped) // flat_text(surfaces, is_swapped)
    end associate
  end subroutine build_rows

  !> Returns the nodes of the first surface with their normals, which at a plane of symmetry lie in this plane.
  pure function sites_of(mesh, surfaces, is_prescribed) result(sites)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    logical, intent(in) :: is_prescribed(:)
    type(node_pairs_t) :: sites
    integer :: i

    sites%n_pairs = size(surfaces%first_nodes)
    sites%first_node = surfaces%first_nodes
    sites%normal = surfaces%normals
    allocate (sites%second_node(sites%n_pairs), source=0)
    allocate (sites%gap_factors(sites%n_pairs, 0))
    allocate (sites%contact_entry(sites%n_pairs), source=surfaces%i_entry)
    do i = 1, sites%n_pairs
      sites%normal(:, i) = normal_in_symmetry(sites%normal(:, i), is_held(mesh%n_dim, sites%first_node(i), is_prescribed))
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

  !> Keeps the sites with rows and, behind them, the corners without a row beside a mid-side node with one. Sets their initial gaps
  !> to 0.
  pure subroutine keep_sites(has_row, first, sites, n_rows)
    !> whether each site has a row, shape (n_pairs)
    logical, intent(in) :: has_row(:)
    type(mortar_side_t), intent(in) :: first
    type(node_pairs_t), intent(inout) :: sites
    !> number of sites with rows
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

  !> Sets the gaps of the sites to those that the mesh has at their nodes; a row whose node does not face the second surface, as
  !> where this ends, gets its mean gap.
  pure subroutine set_mesh_gaps(mesh, second, sums, limit, n_rows, sites, has_gap)
    type(mesh_t), intent(in) :: mesh
    type(mortar_side_t), intent(in) :: second
    type(mortar_sums_t), intent(in) :: sums
    !> [length] search distance
    real(rk), intent(in) :: limit
    !> number of sites with rows, which come first
    integer, intent(in) :: n_rows
    type(node_pairs_t), intent(inout) :: sites
    !> whether the gap is that of the node, shape (n_pairs)
    logical, allocatable, intent(out) :: has_gap(:)

    allocate (has_gap(sites%n_pairs))
    call find_node_gaps(mesh%coordinates(:, sites%first_node), sites%normal, second, limit, sites%initial_gap, has_gap)
    where (.not. has_gap) sites%initial_gap = 0
    associate (owners => sites%first_node(:n_rows), gaps => sites%initial_gap(:n_rows))
      gaps = merge(gaps, sums%mean_gap(owners), has_gap(:n_rows))
    end associate
  end subroutine set_mesh_gaps

  !> Checks that no node belongs to both surfaces. Errors: a node on both surfaces.
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

  !> Checks the gaps of the mesh. Errors: every row overlaps by more than the longest edge of the first surface.
  pure subroutine check_overlap(surfaces, gaps, first, error)
    type(surface_pair_t), intent(in) :: surfaces
    !> [length] gaps of the rows
    real(rk), intent(in) :: gaps(:)
    type(mortar_side_t), intent(in) :: first
    type(error_t), allocatable, intent(out) :: error

    if (maxval(gaps) < -first%longest) call refuse_overlap(surfaces, 'node', -maxval(gaps), error)
  end subroutine check_overlap
end module sig_mortar_rows
