! SPDX-License-Identifier: BSD-3-Clause
!> Finds pairs of facing nodes of two surfaces (node-to-node contact), with their normals and gaps.
module sig_node_pairs
  use sig_deck_config, only: contact_config_t
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_quadratic_contact, only: check_axis, first_weak_facet
  use sig_surface_pair, only: pairing_t, surface_pair_t
  use sig_surface_pairing, only: gap_of_pair, open_surfaces, pair_surfaces
  use sig_text, only: append_text, string_t
  implicit none(type, external)
  private
  public :: node_pairs_t, find_node_pairs

  !> The pairs in ascending order of their first node, and nodes that face an obstacle. All indices are 1-based.
  type :: node_pairs_t
    integer :: n_pairs = 0
    integer, allocatable :: first_node(:)
    !> second node of each pair; 0 = a rigid obstacle
    integer, allocatable :: second_node(:)
    !> [-] unit vector from the first body to the second or to the obstacle, shape (n_dim, n_pairs)
    real(rk), allocatable :: normal(:, :)
    !> [length] (x_second - x_first) . normal in the mesh, negative if the bodies overlap; 0 for an obstacle. If the deck gives a
    !> gap or an obstacle, set_initial_gaps replaces it
    real(rk), allocatable :: initial_gap(:)
    !> [length] gap that each term adds to the initial gap when its value is 1, shape (n_pairs, n_terms); no terms at first
    real(rk), allocatable :: gap_factors(:, :)
    !> entry of the deck's contact section that made each pair
    integer, allocatable :: contact_entry(:)
  end type node_pairs_t

contains

  !> Finds the pairs of all contact entries that can have pairs, and says for the others why they need mortar, or a changed basis
  !> against an obstacle. An entry with the formulation mortar gets no pairs. One with auto gets pairs if pair_surfaces and, in an
  !> axisymmetric model, check_axis find no error. Local. Cost: O(n log n) in the nodes of the surfaces.
  !>
  !> Errors, with the entry's place in the deck: those of open_surfaces for all entries; for entries with the formulation
  !> node_to_node, those of pair_surfaces and, in an axisymmetric model, of check_axis; a node of an obstacle's surface that is in a
  !> pair of an earlier entry.
  pure subroutine find_node_pairs(mesh, is_round, contact, deck_path, pairs, error, why_mortar)
    type(mesh_t), intent(in) :: mesh
    !> whether the body is the mesh turned around the axis x = 0
    logical, intent(in) :: is_round
    !> section contact of the deck
    type(contact_config_t), intent(in) :: contact(:)
    !> for messages
    character(*), intent(in) :: deck_path
    type(node_pairs_t), intent(out) :: pairs
    type(error_t), allocatable, intent(out) :: error
    !> reason why an entry needs other rows, empty if it has pairs; shape (size(contact)). Without this argument, entries with auto
    !> must have pairs, too
    type(string_t), allocatable, intent(out), optional :: why_mortar(:)
    type(surface_pair_t) :: surfaces
    type(pairing_t) :: before, pairing
    character(:), allocatable :: why
    integer :: i_entry

    if (present(why_mortar)) allocate (why_mortar(0))
    allocate (pairing%partner(mesh%n_nodes), pairing%entry(mesh%n_nodes), source=0)
    allocate (pairing%is_first(mesh%n_nodes), source=.false.)
    allocate (pairing%normals(mesh%n_dim, mesh%n_nodes), source=0.0_rk)
    do i_entry = 1, size(contact)
      call open_surfaces(mesh, contact, i_entry, deck_path, surfaces, error)
      if (allocated(error)) return
      before = pairing
      call pair_entry(mesh, is_round, surfaces, pairing, why, error)
      if (present(why_mortar)) then
        call append_text(why_mortar, why)
        if (len(why) > 0 .and. allocated(error)) deallocate (error)
        if (len(why) > 0) pairing = before
      end if
      if (allocated(error)) return
    end do
    call collect_pairs(mesh, pairing, pairs)
  end subroutine find_node_pairs

  !> Finds the pairs of one entry, or the reason why it needs other rows instead. Errors: those of pair_surfaces and, in an
  !> axisymmetric model, of check_axis; none with formulation mortar.
  pure subroutine pair_entry(mesh, is_round, surfaces, pairing, why, error)
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: is_round
    type(surface_pair_t), intent(in) :: surfaces
    !> gets the pairs of this entry
    type(pairing_t), intent(inout) :: pairing
    !> the reason; empty if the entry has pairs, or must have them and has an error. With formulation mortar there is no error, and
    !> pairing does not change. With auto a reason comes with an error, and pairing is not complete
    character(:), allocatable, intent(out) :: why
    type(error_t), allocatable, intent(out) :: error

    why = 'as the deck says'
    if (surfaces%entry%formulation == 'mortar') return
    call pair_surfaces(mesh, surfaces, pairing, error)
    if (.not. allocated(error)) then
      if (is_round) call check_axis(mesh, surfaces, error)
      why = 'because node-to-node contact cannot use an edge of three nodes that ends on the axis'
    else if (first_weak_facet(mesh, [surfaces%first_facets, surfaces%second_facets]) > 0) then
      why = 'because node-to-node contact cannot use faces of six or eight nodes'
    else if (surfaces%entry%has_obstacle) then
      why = ''
    else
      why = 'because node-to-node contact cannot pair the nodes of both surfaces'
    end if
    if (.not. allocated(error) .or. surfaces%entry%formulation /= 'auto') why = ''
  end subroutine pair_entry

  pure subroutine collect_pairs(mesh, pairing, pairs)
    type(mesh_t), intent(in) :: mesh
    type(pairing_t), intent(in) :: pairing
    type(node_pairs_t), intent(out) :: pairs
    integer :: i_node, i_pair

    pairs%first_node = pack([(i_node, i_node=1, mesh%n_nodes)], pairing%is_first)
    pairs%n_pairs = size(pairs%first_node)
    pairs%second_node = pairing%partner(pairs%first_node)
    pairs%contact_entry = pairing%entry(pairs%first_node)
    pairs%normal = pairing%normals(:, pairs%first_node)
    allocate (pairs%gap_factors(pairs%n_pairs, 0))
    allocate (pairs%initial_gap(pairs%n_pairs), source=0.0_rk)
    do i_pair = 1, pairs%n_pairs
      if (pairs%second_node(i_pair) == 0) cycle
      pairs%initial_gap(i_pair) = gap_of_pair(mesh, pairs%first_node(i_pair), pairs%second_node(i_pair), pairs%normal(:, i_pair))
    end do
  end subroutine collect_pairs
end module sig_node_pairs
