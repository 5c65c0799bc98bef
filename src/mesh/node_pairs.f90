! SPDX-License-Identifier: BSD-3-Clause
!> Facing nodes of two surfaces (node-to-node contact): who faces whom, along which normal, how far apart.
module sig_node_pairs
  use sig_deck_config, only: contact_config_t, name_config_t
  use sig_errors, only: error_t, make_error
  use sig_k_d_tree, only: k_d_tree_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_checks, only: group_of_surface
  use sig_surface_geometry, only: measure_surface, surface_geometry_t
  use sig_text, only: join, string_t, to_text
  implicit none(type, external)
  private
  public :: node_pairs_t, find_node_pairs

  !> Pairs in ascending order of their first node. All indices 1-based.
  type :: node_pairs_t
    integer :: n_pairs = 0
    integer, allocatable :: first_node(:)
    integer, allocatable :: second_node(:)
    !> [-] unit vector from the first body to the second, shape (n_dim, n_pairs)
    real(rk), allocatable :: normal(:, :)
    !> [length] (x_second - x_first) . normal; negative where the bodies overlap at the start
    real(rk), allocatable :: initial_gap(:)
    !> entry of the deck's contact section that made the pair
    integer, allocatable :: contact_entry(:)
  end type node_pairs_t

  !> One entry of the deck while its pairs are sought.
  type :: surface_pair_t
    integer :: i_entry = 0
    integer :: first_group = 0
    integer :: second_group = 0
    real(rk), allocatable :: normal(:)
    !> [length] of the first surface
    real(rk) :: mesh_size = 0
    !> [length] largest lateral offset of a pair
    real(rk) :: tolerance = 0
  end type surface_pair_t

  !> [-] a surface counts as turned away from the direction beyond this share of its area
  real(rk), parameter :: turned_tolerance = 1.0e-9_rk

contains

  !> Pairs of all contact entries. Local. Cost: O(n log n) in the nodes of the surfaces.
  !>
  !> Errors: unknown surface, a direction of no use, surfaces that do not face each other, nodes without partner, a node in two
  !> pairs; with the entry's place in the deck.
  pure subroutine find_node_pairs(mesh, contact, deck_path, pairs, error)
    type(mesh_t), intent(in) :: mesh
    type(contact_config_t), intent(in) :: contact(:)
    character(*), intent(in) :: deck_path
    type(node_pairs_t), intent(out) :: pairs
    type(error_t), allocatable, intent(out) :: error
    type(surface_pair_t) :: surfaces
    !> shape (n_nodes), 0 = none
    integer :: partner(mesh%n_nodes), entry_of_first(mesh%n_nodes)
    real(rk) :: normals(mesh%n_dim, size(contact))
    integer :: i_entry

    partner = 0
    entry_of_first = 0
    do i_entry = 1, size(contact)
      call open_surfaces(mesh, contact, i_entry, deck_path, surfaces, error)
      if (allocated(error)) return
      normals(:, i_entry) = surfaces%normal
      call pair_surfaces(mesh, contact(i_entry), surfaces, deck_path, partner, entry_of_first, error)
      if (allocated(error)) return
    end do
    call collect_pairs(mesh, normals, partner, entry_of_first, pairs)
  end subroutine find_node_pairs

  !> Finds the two surfaces and checks that the direction leads out of the first one and into the second one.
  pure subroutine open_surfaces(mesh, contact, i_entry, deck_path, surfaces, error)
    type(mesh_t), intent(in) :: mesh
    type(contact_config_t), intent(in) :: contact(:)
    integer, intent(in) :: i_entry
    character(*), intent(in) :: deck_path
    type(surface_pair_t), intent(out) :: surfaces
    type(error_t), allocatable, intent(out) :: error
    real(rk) :: first_lean, second_lean

    surfaces%i_entry = i_entry
    associate (entry => contact(i_entry))
      call group_of_surface(mesh, entry%first, deck_path, surfaces%first_group, error)
      if (allocated(error)) return
      call group_of_surface(mesh, entry%second, deck_path, surfaces%second_group, error)
      if (allocated(error)) return
      call check_direction(entry, mesh%n_dim, deck_path, error)
      if (allocated(error)) return
      surfaces%normal = entry%direction / norm2(entry%direction)
      call measure(mesh, entry%second, surfaces%second_group, surfaces%normal, deck_path, surfaces%mesh_size, second_lean, error)
      if (allocated(error)) return
      call measure(mesh, entry%first, surfaces%first_group, surfaces%normal, deck_path, surfaces%mesh_size, first_lean, error)
      if (allocated(error)) return
      surfaces%tolerance = entry%pairing_tolerance * surfaces%mesh_size
      if (first_lean < -turned_tolerance .and. second_lean > turned_tolerance) then
        call make_error(error, "the contact direction " // place_text(entry%direction) // " points from '" // &
                        entry%second%text // "' to '" // entry%first%text // "'; it must point from first to second", &
                        file=deck_path, line=entry%direction_line, column=entry%direction_column, &
                        hint='write direction: ' // direction_text(-entry%direction) // ', or swap first and second')
      else if (first_lean < -turned_tolerance .or. second_lean > turned_tolerance) then
        call refuse_facing(entry, deck_path, error, 'the outer sides of both look the same way')
      end if
    end associate
  end subroutine open_surfaces

  pure subroutine check_direction(entry, n_dim, deck_path, error)
    type(contact_config_t), intent(in) :: entry
    integer, intent(in) :: n_dim
    character(*), intent(in) :: deck_path
    type(error_t), allocatable, intent(out) :: error

    if (size(entry%direction) /= n_dim) then
      call make_error(error, 'the contact direction has ' // to_text(size(entry%direction)) // &
                      ' components; the mesh has dimension ' // to_text(n_dim), &
                      file=deck_path, line=entry%direction_line, column=entry%direction_column)
    else if (.not. norm2(entry%direction) > 0) then
      call make_error(error, 'the contact direction is zero; it must point from the first surface to the second', &
                      file=deck_path, line=entry%direction_line, column=entry%direction_column)
    end if
  end subroutine check_direction

  !> Mesh size of a surface, and how far its outer side looks along the direction: 1 = fully, -1 = the other way.
  pure subroutine measure(mesh, surface, i_group, normal, deck_path, mesh_size, lean, error)
    type(mesh_t), intent(in) :: mesh
    type(name_config_t), intent(in) :: surface
    integer, intent(in) :: i_group
    real(rk), intent(in) :: normal(:)
    character(*), intent(in) :: deck_path
    real(rk), intent(out) :: mesh_size
    real(rk), intent(out) :: lean
    type(error_t), allocatable, intent(out) :: error
    type(surface_geometry_t) :: geometry
    integer :: i_node

    call measure_surface(mesh, i_group, geometry)
    if (geometry%inner_facet > 0) then
      i_node = mesh%facet_nodes(mesh%facet_offsets(geometry%inner_facet) + 1)
      call make_error(error, "the surface '" // surface%text // "' lies inside a body at " // node_text(mesh, i_node) // &
                      '; contact needs two bodies with nodes of their own', &
                      file=deck_path, line=surface%line, column=surface%column, &
                      hint='draw the surface once for each body, so that gmsh does not join their nodes')
      return
    end if
    mesh_size = geometry%mesh_size
    lean = dot_product(sum(geometry%area_vectors, dim=2), normal) / sum(norm2(geometry%area_vectors, dim=1))
  end subroutine measure

  pure subroutine refuse_facing(entry, deck_path, error, reason)
    type(contact_config_t), intent(in) :: entry
    character(*), intent(in) :: deck_path
    type(error_t), allocatable, intent(out) :: error
    character(*), intent(in) :: reason

    call make_error(error, "the surfaces '" // entry%first%text // "' and '" // entry%second%text // &
                    "' do not face each other along " // place_text(entry%direction) // ': ' // reason, &
                    file=deck_path, line=entry%first%line, column=entry%first%column)
  end subroutine refuse_facing

  !> Gives every node of the first surface its partner on the second.
  pure subroutine pair_surfaces(mesh, entry, surfaces, deck_path, partner, entry_of_first, error)
    type(mesh_t), intent(in) :: mesh
    type(contact_config_t), intent(in) :: entry
    type(surface_pair_t), intent(in) :: surfaces
    character(*), intent(in) :: deck_path
    integer, intent(inout) :: partner(:)
    integer, intent(inout) :: entry_of_first(:)
    type(error_t), allocatable, intent(out) :: error
    type(k_d_tree_t) :: tree
    integer, allocatable :: candidates(:)
    integer :: i, n_unpaired, first, second
    real(rk) :: largest_gap

    associate (first_nodes => mesh%groups(surfaces%first_group)%nodes, second_nodes => mesh%groups(surfaces%second_group)%nodes)
      call tree%create(lateral(mesh%coordinates(:, second_nodes), surfaces%normal))
      n_unpaired = 0
      largest_gap = -huge(largest_gap)
      do i = 1, size(first_nodes)
        first = first_nodes(i)
        call tree%within(reshape(lateral(mesh%coordinates(:, [first]), surfaces%normal), [mesh%n_dim]), surfaces%tolerance, &
                         candidates)
        if (size(candidates) == 0) then
          n_unpaired = n_unpaired + 1
          cycle
        end if
        second = nearest_along(mesh, first, second_nodes(candidates), surfaces%normal)
        call claim_nodes(mesh, entry, first, second, deck_path, partner, error)
        if (allocated(error)) return
        entry_of_first(first) = surfaces%i_entry
        largest_gap = max(largest_gap, gap_of_pair(mesh, first, second, surfaces%normal))
      end do
      call check_coverage(mesh, entry, surfaces, deck_path, partner, n_unpaired, error)
      if (allocated(error)) return
    end associate
    if (largest_gap < -surfaces%mesh_size) then
      call refuse_facing(entry, deck_path, error, 'at the start every pair overlaps by ' // to_text(-largest_gap) // &
                         ' or more, which is more than an element; is the direction or the position of a body wrong?')
    end if
  end subroutine pair_surfaces

  !> Places without their part along the normal.
  pure function lateral(places, normal) result(projected)
    real(rk), intent(in) :: places(:, :)
    real(rk), intent(in) :: normal(:)
    real(rk) :: projected(size(places, 1), size(places, 2))
    integer :: i

    do i = 1, size(places, 2)
      projected(:, i) = places(:, i) - dot_product(places(:, i), normal) * normal
    end do
  end function lateral

  pure real(rk) function gap_of_pair(mesh, first, second, normal) result(gap)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: first, second
    real(rk), intent(in) :: normal(:)

    gap = dot_product(mesh%coordinates(:, second) - mesh%coordinates(:, first), normal)
  end function gap_of_pair

  !> A line along the normal may meet a surface several times: the place with the smallest gap counts.
  pure integer function nearest_along(mesh, first, candidates, normal) result(second)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: first
    integer, intent(in) :: candidates(:)
    real(rk), intent(in) :: normal(:)
    integer :: i

    second = candidates(1)
    do i = 2, size(candidates)
      if (abs(gap_of_pair(mesh, first, candidates(i), normal)) < abs(gap_of_pair(mesh, first, second, normal))) &
        second = candidates(i)
    end do
  end function nearest_along

  !> Notes a pair. Errors: one of its nodes is in a pair already, or both are the same node.
  pure subroutine claim_nodes(mesh, entry, first, second, deck_path, partner, error)
    type(mesh_t), intent(in) :: mesh
    type(contact_config_t), intent(in) :: entry
    integer, intent(in) :: first, second
    character(*), intent(in) :: deck_path
    integer, intent(inout) :: partner(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: twice

    if (first == second) then
      call make_error(error, node_text(mesh, first) // " is on both surfaces, '" // entry%first%text // "' and '" // &
                      entry%second%text // "'", file=deck_path, line=entry%first%line, column=entry%first%column, &
                      hint='contact needs two bodies with nodes of their own')
    else if (partner(first) /= 0 .or. partner(second) /= 0) then
      twice = merge(first, second, partner(first) /= 0)
      call make_error(error, node_text(mesh, twice) // ' would be in two contact pairs, with ' // &
                      node_text(mesh, partner(twice)) // ' and with ' // node_text(mesh, merge(second, first, twice == first)), &
                      file=deck_path, line=entry%first%line, column=entry%first%column)
    end if
    if (allocated(error)) return
    partner(first) = second
    partner(second) = first
  end subroutine claim_nodes

  !> Errors: a node of either surface has no partner.
  pure subroutine check_coverage(mesh, entry, surfaces, deck_path, partner, n_unpaired, error)
    type(mesh_t), intent(in) :: mesh
    type(contact_config_t), intent(in) :: entry
    type(surface_pair_t), intent(in) :: surfaces
    character(*), intent(in) :: deck_path
    integer, intent(in) :: partner(:)
    integer, intent(in) :: n_unpaired
    type(error_t), allocatable, intent(out) :: error

    associate (first_nodes => mesh%groups(surfaces%first_group)%nodes, second_nodes => mesh%groups(surfaces%second_group)%nodes)
      if (n_unpaired == size(first_nodes)) then
        call refuse_facing(entry, deck_path, error, 'no node of the first has a partner on the second; ' // &
                           offset_text(mesh, surfaces, first_nodes(1), second_nodes, entry))
      else if (n_unpaired > 0) then
        call refuse_unpaired(mesh, entry, entry%first, first_nodes, entry%second, second_nodes, surfaces, deck_path, partner, error)
      else if (any(partner(second_nodes) == 0)) then
        call refuse_unpaired(mesh, entry, entry%second, second_nodes, entry%first, first_nodes, surfaces, deck_path, partner, error)
      end if
    end associate
  end subroutine check_coverage

  pure subroutine refuse_unpaired(mesh, entry, surface, nodes, other, other_nodes, surfaces, deck_path, partner, error)
    type(mesh_t), intent(in) :: mesh
    type(contact_config_t), intent(in) :: entry
    type(name_config_t), intent(in) :: surface
    integer, intent(in) :: nodes(:)
    type(name_config_t), intent(in) :: other
    integer, intent(in) :: other_nodes(:)
    type(surface_pair_t), intent(in) :: surfaces
    character(*), intent(in) :: deck_path
    integer, intent(in) :: partner(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i_lost

    i_lost = nodes(findloc(partner(nodes), 0, dim=1))
    call make_error(error, to_text(count(partner(nodes) == 0)) // ' of ' // to_text(size(nodes)) // " nodes of '" // &
                    surface%text // "' have no partner on '" // other%text // "'; " // &
                    offset_text(mesh, surfaces, i_lost, other_nodes, entry), &
                    file=deck_path, line=surface%line, column=surface%column, &
                    hint='node-to-node contact needs facing nodes one to one: mesh both surfaces alike, or name only what faces')
  end subroutine refuse_unpaired

  !> How far aside the nearest node lies, and how far it may.
  pure function offset_text(mesh, surfaces, i_node, other_nodes, entry) result(text)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    integer, intent(in) :: i_node
    integer, intent(in) :: other_nodes(:)
    type(contact_config_t), intent(in) :: entry
    character(:), allocatable :: text
    type(k_d_tree_t) :: tree
    integer :: nearest
    real(rk) :: offset

    call tree%create(lateral(mesh%coordinates(:, other_nodes), surfaces%normal))
    call tree%nearest(reshape(lateral(mesh%coordinates(:, [i_node]), surfaces%normal), [mesh%n_dim]), nearest, offset)
    text = node_text(mesh, i_node) // ' has its nearest one ' // short_text(offset) // ' aside; allowed are ' // &
      short_text(surfaces%tolerance) // ' (pairing_tolerance ' // to_text(entry%pairing_tolerance) // ' times the mesh size ' // &
      short_text(surfaces%mesh_size) // ')'
  end function offset_text

  !> `node 17 (0.25, 1.0)` by its number in gmsh.
  pure function node_text(mesh, i_node) result(text)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_node
    character(:), allocatable :: text

    text = 'node ' // to_text(mesh%node_tags(i_node)) // ' ' // place_text(mesh%coordinates(:, i_node))
  end function node_text

  pure function place_text(place) result(text)
    real(rk), intent(in) :: place(:)
    character(:), allocatable :: text
    type(string_t) :: numbers(size(place))
    integer :: i

    do i = 1, size(place)
      numbers(i)%text = short_text(place(i))
    end do
    text = '(' // join(numbers, ', ') // ')'
  end function place_text

  !> As the deck has it.
  pure function direction_text(direction) result(text)
    real(rk), intent(in) :: direction(:)
    character(:), allocatable :: text

    text = place_text(direction)
    text = '[' // text(2:len(text) - 1) // ']'
  end function direction_text

  !> Six digits are enough to find a place.
  pure function short_text(number) result(text)
    real(rk), intent(in) :: number
    character(:), allocatable :: text
    character(16) :: buffer
    real(rk) :: rounded

    write (buffer, '(es13.5)') number
    read (buffer, *) rounded
    ! adding zero turns -0 into 0
    text = to_text(rounded + 0.0_rk)
  end function short_text

  pure subroutine collect_pairs(mesh, normals, partner, entry_of_first, pairs)
    type(mesh_t), intent(in) :: mesh
    !> shape (n_dim, entries)
    real(rk), intent(in) :: normals(:, :)
    integer, intent(in) :: partner(:)
    integer, intent(in) :: entry_of_first(:)
    type(node_pairs_t), intent(out) :: pairs
    integer :: i_node, i_pair

    pairs%first_node = pack([(i_node, i_node=1, mesh%n_nodes)], entry_of_first > 0)
    pairs%n_pairs = size(pairs%first_node)
    pairs%second_node = partner(pairs%first_node)
    pairs%contact_entry = entry_of_first(pairs%first_node)
    pairs%normal = normals(:, pairs%contact_entry)
    allocate (pairs%initial_gap(pairs%n_pairs))
    do i_pair = 1, pairs%n_pairs
      pairs%initial_gap(i_pair) = gap_of_pair(mesh, pairs%first_node(i_pair), pairs%second_node(i_pair), pairs%normal(:, i_pair))
    end do
  end subroutine collect_pairs
end module sig_node_pairs
