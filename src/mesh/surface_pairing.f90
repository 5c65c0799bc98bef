! SPDX-License-Identifier: BSD-3-Clause
!> Finds the partner of every node of one surface: the nearest node of another surface along the normal, or an obstacle.
module sig_surface_pairing
  use sig_deck_config, only: contact_config_t, name_config_t
  use sig_errors, only: error_t, make_error
  use sig_folded_surface, only: check_folded
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_checks, only: group_of_surface
  use sig_quadratic_contact, only: check_partners, check_weights
  use sig_rounding, only: rounding_of_data
  use sig_surface_geometry, only: averaged_normals, measure_surface, surface_geometry_t
  use sig_surface_pair, only: direction_text, node_text, offset_text, pairing_t, place_text, refuse, &
    refuse_common_node, refuse_facing, refuse_overlap, refuse_second_pair, refuse_unpaired, surface_pair_t
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: open_surfaces, pair_surfaces, gap_of_pair

contains

  !> Finds the surfaces of a contact entry (only the first one if there is an obstacle) and the normals at the nodes of the first
  !> surface. A normal is the direction that the deck gives, the direction to the obstacle, or without both the averaged outward
  !> normal.
  !>
  !> Errors: a surface that group_of_surface refuses, that has a facet inside of a body, or that is folded onto itself. With a
  !> direction also: it has a wrong number of components, is zero, or leads, on average over the area, into the first body or out of
  !> the second one. With an obstacle also: the surface faces away from it on average. With neither also: a node of the first
  !> surface has no averaged normal. Then `surfaces` is not complete.
  pure subroutine open_surfaces(mesh, contact, i_entry, deck_path, surfaces, error)
    type(mesh_t), intent(in) :: mesh
    !> section contact of the deck, and the number of the entry, 1-based
    type(contact_config_t), intent(in) :: contact(:)
    integer, intent(in) :: i_entry
    !> for messages
    character(*), intent(in) :: deck_path
    type(surface_pair_t), intent(out) :: surfaces
    type(error_t), allocatable, intent(out) :: error
    type(surface_geometry_t) :: geometry
    integer :: first_group, second_group

    surfaces%i_entry = i_entry
    surfaces%entry = contact(i_entry)
    surfaces%deck_path = deck_path
    surfaces%second_nodes = [integer ::]
    surfaces%second_facets = [integer ::]
    call group_of_surface(mesh, surfaces%entry%first, deck_path, first_group, error)
    if (allocated(error)) return
    surfaces%first_nodes = mesh%groups(first_group)%nodes
    surfaces%first_facets = mesh%groups(first_group)%entities
    if (.not. surfaces%entry%has_obstacle) then
      call group_of_surface(mesh, surfaces%entry%second, deck_path, second_group, error)
      if (allocated(error)) return
      surfaces%second_nodes = mesh%groups(second_group)%nodes
      surfaces%second_facets = mesh%groups(second_group)%entities
      call measure(mesh, surfaces, surfaces%entry%second, second_group, geometry, error)
      if (allocated(error)) return
      surfaces%second_geometry = geometry
      surfaces%second_box = box_of(mesh, surfaces%second_nodes)
    end if
    call measure(mesh, surfaces, surfaces%entry%first, first_group, geometry, error)
    if (allocated(error)) return
    surfaces%first_geometry = geometry
    surfaces%first_box = box_of(mesh, surfaces%first_nodes)
    surfaces%tolerance = surfaces%entry%pairing_tolerance * surfaces%first_geometry%mesh_size
    call surfaces%tree%create(mesh%coordinates(:, surfaces%second_nodes))
    if (surfaces%entry%has_obstacle) then
      call face_obstacle(surfaces, error)
    else if (surfaces%entry%has_direction) then
      call fix_direction(mesh%n_dim, surfaces, error)
    else
      surfaces%normals = averaged_normals(mesh, first_group, surfaces%first_geometry%area_vectors)
      surfaces%second_normals = averaged_normals(mesh, second_group, surfaces%second_geometry%area_vectors)
      call check_normals(mesh, surfaces, error)
    end if
  end subroutine open_surfaces

  !> Computes the geometry of a surface by measure_surface. Errors: a facet that is not a side of exactly one cell, as inside of a
  !> body; a surface that is folded onto itself, as check_folded finds it.
  pure subroutine measure(mesh, surfaces, surface, i_group, geometry, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    type(name_config_t), intent(in) :: surface
    !> group of the surface in the mesh
    integer, intent(in) :: i_group
    type(surface_geometry_t), intent(out) :: geometry
    type(error_t), allocatable, intent(out) :: error
    integer :: i_node

    call measure_surface(mesh, i_group, geometry)
    if (geometry%inner_facet == 0) then
      call check_folded(mesh, surfaces, surface, i_group, geometry, error)
      return
    end if
    i_node = mesh%facet_nodes(mesh%facet_offsets(geometry%inner_facet) + 1)
    call refuse(surfaces, surface, "the surface '" // surface%text // "' has a facet, at " // node_text(mesh, i_node) // &
                ', that is not the side of exactly one cell; contact needs two bodies with nodes of their own', error, &
                'draw the surface once for each body, so that gmsh does not join their nodes')
  end subroutine measure

  !> Returns the smallest (box(:, 1)) and the largest coordinates (box(:, 2)) of some nodes.
  pure function box_of(mesh, nodes) result(box)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: nodes(:)
    !> [length]
    real(rk) :: box(mesh%n_dim, 2)

    box(:, 1) = minval(mesh%coordinates(:, nodes), dim=2)
    box(:, 2) = maxval(mesh%coordinates(:, nodes), dim=2)
  end function box_of

  !> Sets surfaces%normals to the direction of the deck at all nodes. Errors: the direction has a wrong number of components or is
  !> zero; on average over the area, it leads into the first body or out of the second one (see lean).
  pure subroutine fix_direction(n_dim, surfaces, error)
    integer, intent(in) :: n_dim
    type(surface_pair_t), intent(inout) :: surfaces
    type(error_t), allocatable, intent(out) :: error
    real(rk) :: first_lean, second_lean

    associate (entry => surfaces%entry)
      if (size(entry%direction) /= n_dim) then
        call refuse_direction(surfaces, 'the contact direction has ' // to_text(size(entry%direction)) // &
                              ' components; the mesh has dimension ' // to_text(n_dim), error)
      else if (.not. norm2(entry%direction) > 0) then
        call refuse_direction(surfaces, 'the contact direction is zero; it must point from the first surface to the second', error)
      end if
      if (allocated(error)) return
      surfaces%normals = spread(entry%direction / norm2(entry%direction), 2, size(surfaces%first_nodes))
      first_lean = lean(surfaces%first_geometry, surfaces%normals(:, 1))
      second_lean = lean(surfaces%second_geometry, surfaces%normals(:, 1))
      if (first_lean < -rounding_of_data .and. second_lean > rounding_of_data) then
        call refuse_direction(surfaces, 'the contact direction ' // place_text(entry%direction) // " points from '" // &
                              entry%second%text // "' to '" // entry%first%text // "'; it must point from first to second", &
                              error, 'write direction: ' // direction_text(-entry%direction) // ', or swap first and second')
      else if (first_lean < -rounding_of_data .or. second_lean > rounding_of_data) then
        call refuse_facing(surfaces, error, 'the outer side of one of them points away from the other')
      end if
    end associate
  end subroutine fix_direction

  !> Sets surfaces%normals to the direction to an obstacle, one and the same at all nodes. Errors: on average over its area (see
  !> lean), the surface faces away from the obstacle.
  pure subroutine face_obstacle(surfaces, error)
    type(surface_pair_t), intent(inout) :: surfaces
    type(error_t), allocatable, intent(out) :: error

    associate (entry => surfaces%entry)
      surfaces%normals = spread(entry%direction / norm2(entry%direction), 2, size(surfaces%first_nodes))
      if (lean(surfaces%first_geometry, surfaces%normals(:, 1)) >= -rounding_of_data) return
      call refuse(surfaces, entry%first, "the outer side of '" // entry%first%text // "' points away from the obstacle, which " // &
                  'lies in the direction ' // place_text(entry%direction), error, &
                  'the normal of a half space points out of it, the direction of a sphere leads from the surface to it')
    end associate
  end subroutine face_obstacle

  pure subroutine refuse_direction(surfaces, message, error, hint)
    type(surface_pair_t), intent(in) :: surfaces
    character(*), intent(in) :: message
    type(error_t), allocatable, intent(out) :: error
    character(*), intent(in), optional :: hint
    type(name_config_t) :: place

    place%line = surfaces%entry%direction_line
    place%column = surfaces%entry%direction_column
    call refuse(surfaces, place, message, error, hint)
  end subroutine refuse_direction

  !> Returns the cosine [-] between the outward normals of a surface and a unit vector, as a mean over the area: 1 = the whole
  !> surface faces along the direction, -1 = along the opposite direction.
  pure real(rk) function lean(geometry, direction)
    type(surface_geometry_t), intent(in) :: geometry
    real(rk), intent(in) :: direction(:)

    lean = dot_product(sum(geometry%area_vectors, dim=2), direction) / sum(norm2(geometry%area_vectors, dim=1))
  end function lean

  !> Checks that every node of the first surface has an averaged normal. Errors: the area vectors of the facets around a node
  !> cancel.
  pure subroutine check_normals(mesh, surfaces, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    type(error_t), allocatable, intent(out) :: error
    integer :: i_lost

    i_lost = findloc(norm2(surfaces%normals, dim=1) > 0, .false., dim=1)
    if (i_lost == 0) return
    call refuse(surfaces, surfaces%entry%first, node_text(mesh, surfaces%first_nodes(i_lost)) // " of '" // &
                surfaces%entry%first%text // "' has no normal: the facets around it point in opposite directions", error, &
                'give the contact a direction, or name only one side')
  end subroutine check_normals

  !> Gives every node of the first surface its partner on the second surface, or the obstacle as its partner (number 0). The partner
  !> is the nearest node along the normal among those whose distance from the normal's line is at most surfaces%tolerance.
  !>
  !> Errors: those of check_weights; a pair that check_facing or claim_nodes refuses; a node of the first surface without a partner,
  !> or of the second one without a partner in this or an earlier entry; pairs that all overlap by more than the first surface's
  !> mean facet size, if the mesh gives their gap; those of check_partners. With an obstacle only those of check_weights and
  !> pair_with_obstacle. Then the pairing is not complete.
  pure subroutine pair_surfaces(mesh, surfaces, pairing, error)
    type(mesh_t), intent(in) :: mesh
    !> of open_surfaces
    type(surface_pair_t), intent(in) :: surfaces
    !> has the pairs of earlier entries, and gets those of this entry
    type(pairing_t), intent(inout) :: pairing
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: candidates(:)
    integer :: i, i_second, i_unpaired, n_unpaired
    real(rk) :: largest_gap

    call check_weights(mesh, surfaces, surfaces%entry%first, surfaces%first_facets, error)
    if (allocated(error)) return
    call check_weights(mesh, surfaces, surfaces%entry%second, surfaces%second_facets, error)
    if (allocated(error)) return
    if (surfaces%entry%has_obstacle) then
      call pair_with_obstacle(mesh, surfaces, pairing, error)
      return
    end if
    n_unpaired = 0
    largest_gap = -huge(largest_gap)
    do i = 1, size(surfaces%first_nodes)
      associate (first => surfaces%first_nodes(i), normal => surfaces%normals(:, i))
        call surfaces%tree%within(mesh%coordinates(:, first), surfaces%tolerance, candidates, normal)
        if (size(candidates) == 0) then
          if (n_unpaired == 0) i_unpaired = i
          n_unpaired = n_unpaired + 1
          cycle
        end if
        i_second = nearest_along(mesh, first, surfaces%second_nodes, candidates, normal)
        call check_facing(mesh, surfaces, i, i_second, error)
        if (allocated(error)) return
        call claim_nodes(mesh, surfaces, i, surfaces%second_nodes(i_second), pairing, error)
        if (allocated(error)) return
        largest_gap = max(largest_gap, gap_of_pair(mesh, first, surfaces%second_nodes(i_second), normal))
      end associate
    end do
    if (n_unpaired > 0) then
      call refuse_lonely_first(mesh, surfaces, pairing, i_unpaired, n_unpaired, error)
    else if (any(pairing%partner(surfaces%second_nodes) == 0)) then
      call refuse_lonely_second(mesh, surfaces, pairing, error)
    else if (largest_gap < -surfaces%first_geometry%mesh_size .and. .not. surfaces%entry%has_initial_gap) then
      call refuse_overlap(surfaces, 'pair', -largest_gap, error)
    else
      call check_partners(mesh, surfaces, pairing, error)
    end if
  end subroutine pair_surfaces

  !> Pairs all nodes of the first surface with the obstacle. Errors: a node is in a pair of an earlier entry.
  pure subroutine pair_with_obstacle(mesh, surfaces, pairing, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    type(pairing_t), intent(inout) :: pairing
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(surfaces%first_nodes)
      associate (first => surfaces%first_nodes(i))
        if (pairing%entry(first) /= 0) call refuse_second_pair(mesh, surfaces, pairing, first, 0, error)
        if (allocated(error)) return
        pairing%entry(first) = surfaces%i_entry
        pairing%is_first(first) = .true.
        pairing%normals(:, first) = surfaces%normals(:, i)
      end associate
    end do
  end subroutine pair_with_obstacle

  !> Returns the distance [length] from a first node to a second node along a normal, (x_second - x_first) . normal; negative if
  !> they overlap.
  pure real(rk) function gap_of_pair(mesh, first, second, normal) result(gap)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: first, second
    !> [-] unit vector from the first body to the second, shape (n_dim)
    real(rk), intent(in) :: normal(:)

    gap = dot_product(mesh%coordinates(:, second) - mesh%coordinates(:, first), normal)
  end function gap_of_pair

  !> Returns the candidate whose distance from the first node along the normal has the smallest absolute value, as its index in
  !> second_nodes. There may be several candidates, because a line along the normal may meet a surface several times.
  pure integer function nearest_along(mesh, first, second_nodes, candidates, normal) result(i_second)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: first
    integer, intent(in) :: second_nodes(:)
    !> indices of the candidates in second_nodes, at least one
    integer, intent(in) :: candidates(:)
    real(rk), intent(in) :: normal(:)
    real(rk) :: gaps(size(candidates))
    integer :: i

    do i = 1, size(candidates)
      gaps(i) = abs(gap_of_pair(mesh, first, second_nodes(candidates(i)), normal))
    end do
    i_second = candidates(minloc(gaps, dim=1))
  end function nearest_along

  !> Checks a pair, unless the deck gives a direction. Errors: the averaged normals of its two nodes are within 90 degrees of each
  !> other, or the second node has none.
  pure subroutine check_facing(mesh, surfaces, i_first, i_second, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    !> indices in surfaces%first_nodes and surfaces%second_nodes
    integer, intent(in) :: i_first, i_second
    type(error_t), allocatable, intent(out) :: error

    if (surfaces%entry%has_direction) return
    associate (normal => surfaces%normals(:, i_first), other => surfaces%second_normals(:, i_second))
      if (dot_product(normal, other) < 0) return
      call refuse_facing(surfaces, error, 'the outer normals of ' // node_text(mesh, surfaces%first_nodes(i_first)) // ' and ' // &
                         node_text(mesh, surfaces%second_nodes(i_second)) // ', ' // place_text(normal) // ' and ' // &
                         place_text(other) // ', do not point against each other')
    end associate
  end subroutine check_facing

  !> Notes a pair. Errors: one of its nodes is in a pair already, of this or an earlier entry, or both are the same node. Then the
  !> pairing stays as it is.
  pure subroutine claim_nodes(mesh, surfaces, i_first, second, pairing, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    !> index in surfaces%first_nodes, and node of the mesh
    integer, intent(in) :: i_first, second
    type(pairing_t), intent(inout) :: pairing
    type(error_t), allocatable, intent(out) :: error

    associate (first => surfaces%first_nodes(i_first))
      if (first == second) then
        call refuse_common_node(mesh, surfaces, first, error)
      else if (pairing%entry(first) /= 0) then
        call refuse_second_pair(mesh, surfaces, pairing, first, second, error)
      else if (pairing%entry(second) /= 0) then
        call refuse_second_pair(mesh, surfaces, pairing, second, first, error)
      end if
      if (allocated(error)) return
      pairing%partner([first, second]) = [second, first]
      pairing%entry([first, second]) = surfaces%i_entry
      pairing%is_first(first) = .true.
      pairing%normals(:, first) = surfaces%normals(:, i_first)
    end associate
  end subroutine claim_nodes

  pure subroutine refuse_lonely_first(mesh, surfaces, pairing, i_unpaired, n_unpaired, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    type(pairing_t), intent(in) :: pairing
    !> first of these nodes
    integer, intent(in) :: i_unpaired
    integer, intent(in) :: n_unpaired
    type(error_t), allocatable, intent(out) :: error

    if (n_unpaired == size(surfaces%first_nodes)) then
      call refuse_facing(surfaces, error, 'no node of the first has a partner on the second; ' // &
                         offset_text(mesh, surfaces, i_unpaired), 'name two surfaces that face each other; where only ' // &
                         'their nodes do not match, take formulation: mortar')
    else
      associate (nodes => surfaces%first_nodes)
        call refuse_unpaired(surfaces, .false., pack(nodes, pairing%partner(nodes) == 0), &
                             offset_text(mesh, surfaces, i_unpaired), error)
      end associate
    end if
  end subroutine refuse_lonely_first

  !> Makes the error that nodes of the second surface have no partner. Requires: there are such nodes, and all nodes of the first
  !> surface have a partner.
  pure subroutine refuse_lonely_second(mesh, surfaces, pairing, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    type(pairing_t), intent(in) :: pairing
    type(error_t), allocatable, intent(out) :: error

    associate (lonely => pack(surfaces%second_nodes, pairing%partner(surfaces%second_nodes) == 0))
      call refuse_unpaired(surfaces, .true., lonely, 'no node of the first surface lies opposite ' // &
                           node_text(mesh, lonely(1)), error)
    end associate
  end subroutine refuse_lonely_second
end module sig_surface_pairing
