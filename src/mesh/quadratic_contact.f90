! SPDX-License-Identifier: BSD-3-Clause
!> Checks whether quadratic facets can be in node-to-node contact.
!>
!> A uniform pressure p has the nodal forces p times the integrals of N_j. Relative to the size of the facet, the integrals are 1/6,
!> 4/6, 1/6 for an edge, and 1/36, 4/36, 16/36 for a face of nine nodes. At the corners of a face of six nodes they are 0, of eight
!> nodes -1/12, so that a closed contact there has no force or a tensile one. In axisymmetry the integral of r N_j is 0 at the end
!> of a quadratic edge on the axis.
module sig_quadratic_contact
  use sig_changed_basis, only: has_weak_corners
  use sig_deck_config, only: name_config_t
  use sig_element_types, only: element_type_with, element_types
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t, nodes_of_facet
  use sig_mesh_axis, only: ends_on_axis
  use sig_surface_pair, only: node_text, pairing_t, refuse, surface_pair_t
  implicit none(type, external)
  private
  public :: check_weights, check_partners, check_axis, first_weak_facet

contains

  !> Checks the facets of one surface for node-to-node contact. Errors: the first facet of which a node has a zero or negative force
  !> under a uniform pressure, that is, a face of six or eight nodes.
  pure subroutine check_weights(mesh, surfaces, surface, facets, error)
    type(mesh_t), intent(in) :: mesh
    !> contact entry, for messages
    type(surface_pair_t), intent(in) :: surfaces
    !> name of the surface in the deck
    type(name_config_t), intent(in) :: surface
    !> facets of the surface in the mesh, 1-based
    integer, intent(in) :: facets(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    i = first_weak_facet(mesh, facets)
    if (i == 0) return
    associate (nodes => nodes_of_facet(mesh, facets(i)))
      call refuse(surfaces, surface, "the surface '" // surface%text // "' has " // &
        trim(element_types(element_type_with(mesh%n_dim - 1, size(nodes)))%name) // ' faces, at ' // node_text(mesh, nodes(1)) // &
        '; node-to-node contact cannot take them, because a uniform pressure gives zero or negative forces at their corners', &
        error, 'take formulation: mortar, or mesh the bodies in contact with linear elements (Mesh.ElementOrder = 1) or ' // &
        'hexahedra of 27 nodes')
    end associate
  end subroutine check_weights

  !> Returns the index in `facets` of the first face of six or eight nodes, whose corners have zero or negative forces under a
  !> uniform pressure; 0 if there is none. An edge that ends on the axis does not count here: see check_axis.
  pure integer function first_weak_facet(mesh, facets) result(i)
    type(mesh_t), intent(in) :: mesh
    !> facets in the mesh, 1-based
    integer, intent(in) :: facets(:)
    integer :: last_type

    last_type = 0
    do i = 1, size(facets)
      associate (i_type => mesh%facet_types(facets(i)))
        if (i_type == last_type) cycle
        last_type = i_type
        if (has_weak_corners(i_type)) return
      end associate
    end do
    i = 0
  end function first_weak_facet

  !> Checks that the partners of the nodes of each quadratic facet are the nodes of one quadratic facet, because otherwise forces
  !> and displacements of both sides do not fit. Errors: the first quadratic facet for which they are not; the first surface is
  !> searched first. Requires: every node of both surfaces has a partner, and check_weights accepted both surfaces.
  !>
  !> The facet is found by its last node, which is in its middle and belongs to no other facet.
  pure subroutine check_partners(mesh, surfaces, pairing, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    type(pairing_t), intent(in) :: pairing
    type(error_t), allocatable, intent(out) :: error
    integer :: facet_of_middle(mesh%n_nodes)

    facet_of_middle = 0
    call note_middles(mesh, surfaces%first_facets, facet_of_middle)
    call note_middles(mesh, surfaces%second_facets, facet_of_middle)
    if (.not. any(facet_of_middle > 0)) return
    call check_side(mesh, surfaces, surfaces%entry%first, surfaces%first_facets, pairing%partner, facet_of_middle, error)
    if (allocated(error)) return
    call check_side(mesh, surfaces, surfaces%entry%second, surfaces%second_facets, pairing%partner, facet_of_middle, error)
  end subroutine check_partners

  !> Sets facet_of_middle at the last node of each quadratic facet to this facet, its number in the mesh. Other nodes keep theirs.
  pure subroutine note_middles(mesh, facets, facet_of_middle)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: facets(:)
    !> shape (n_nodes)
    integer, intent(inout) :: facet_of_middle(:)
    integer :: i

    do i = 1, size(facets)
      associate (nodes => nodes_of_facet(mesh, facets(i)))
        if (element_types(element_type_with(mesh%n_dim - 1, size(nodes)))%order > 1) facet_of_middle(nodes(size(nodes))) = facets(i)
      end associate
    end do
  end subroutine note_middles

  pure subroutine check_side(mesh, surfaces, surface, facets, partner, facet_of_middle, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    type(name_config_t), intent(in) :: surface
    integer, intent(in) :: facets(:)
    integer, intent(in) :: partner(:), facet_of_middle(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i, i_other
    logical :: is_alike

    do i = 1, size(facets)
      associate (nodes => nodes_of_facet(mesh, facets(i)))
        if (element_types(element_type_with(mesh%n_dim - 1, size(nodes)))%order == 1) cycle
        i_other = facet_of_middle(partner(nodes(size(nodes))))
        is_alike = i_other > 0
        if (is_alike) is_alike = has_nodes(nodes_of_facet(mesh, i_other), partner(nodes))
        if (is_alike) cycle
        call refuse(surfaces, surface, "a facet of '" // surface%text // "' with a node in its middle, " // &
          node_text(mesh, nodes(size(nodes))) // ', faces no facet whose nodes are the partners of its own', error, &
          'node-to-node contact needs matching elements on both sides: mesh both with the same Mesh.ElementOrder and equally fine')
        return
      end associate
    end do
  end subroutine check_side

  !> Checks the first surface of an axisymmetric model for node-to-node contact. Errors: a quadratic edge of it ends on the axis
  !> (see ends_on_axis).
  pure subroutine check_axis(mesh, surfaces, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    type(error_t), allocatable, intent(out) :: error

    if (.not. has_quadratic_end(mesh, surfaces%first_facets)) return
    call refuse(surfaces, surfaces%entry%first, "the surface '" // surfaces%entry%first%text // "' has an edge of three nodes " // &
      'that ends on the axis; node-to-node contact cannot take it, because a uniform pressure has no force on the node at r = 0', &
      error, 'take formulation: mortar, or mesh the bodies in contact with linear elements (Mesh.ElementOrder = 1)')
  end subroutine check_axis

  !> Whether one of the facets is an edge of three nodes that ends on the axis.
  pure logical function has_quadratic_end(mesh, facets) result(has_end)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: facets(:)
    integer :: i

    has_end = .false.
    do i = 1, size(facets)
      associate (radii => mesh%coordinates(1, nodes_of_facet(mesh, facets(i))))
        has_end = has_end .or. (size(radii) > 2 .and. ends_on_axis(radii))
      end associate
    end do
  end function has_quadratic_end

  pure logical function has_nodes(nodes, wanted)
    integer, intent(in) :: nodes(:)
    integer, intent(in) :: wanted(:)
    integer :: i

    has_nodes = size(nodes) == size(wanted)
    do i = 1, size(wanted)
      has_nodes = has_nodes .and. any(nodes == wanted(i))
    end do
  end function has_nodes
end module sig_quadratic_contact
