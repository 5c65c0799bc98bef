! SPDX-License-Identifier: BSD-3-Clause
!> The data of two surfaces during the pairing of their nodes, and the errors if nodes cannot be paired.
module sig_surface_pair
  use sig_deck_config, only: contact_config_t, name_config_t
  use sig_errors, only: error_t, make_error
  use sig_k_d_tree, only: k_d_tree_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_surface_geometry, only: surface_geometry_t
  use sig_text, only: fine_digits, join, short_number, string_t, to_text
  implicit none(type, external)
  private
  public :: surface_pair_t, pairing_t
  public :: refuse, refuse_facing, refuse_unpaired, refuse_second_pair, refuse_common_node, refuse_overlap
  public :: offset_text, node_text, place_text, direction_text

  !> One entry of the deck's contact section on the mesh. All indices are 1-based.
  type :: surface_pair_t
    !> number of the entry in the deck's contact section, and the entry
    integer :: i_entry = 0
    type(contact_config_t) :: entry
    character(:), allocatable :: deck_path
    integer, allocatable :: first_nodes(:)
    !> nodes of the second surface; none for an obstacle
    integer, allocatable :: second_nodes(:)
    integer, allocatable :: first_facets(:)
    integer, allocatable :: second_facets(:)
    type(surface_geometry_t) :: first_geometry
    type(surface_geometry_t) :: second_geometry
    !> [length] smallest and largest coordinates of both surfaces, shape (n_dim, 2); an obstacle has no second box
    real(rk), allocatable :: first_box(:, :), second_box(:, :)
    !> [-] normals from the first body to the second at each first node, shape (n_dim, n_first_nodes)
    real(rk), allocatable :: normals(:, :)
    !> [-] averaged outward normals of the second surface, shape (n_dim, n_second_nodes); only without a fixed direction
    real(rk), allocatable :: second_normals(:, :)
    !> tree of the places of the second nodes
    type(k_d_tree_t) :: tree
    !> [length] largest lateral offset of a pair
    real(rk) :: tolerance = 0
  end type surface_pair_t

  !> The pairs that were found for all entries so far.
  type :: pairing_t
    !> node on the other side, 0 = none or an obstacle; shape (n_nodes)
    integer, allocatable :: partner(:)
    !> entry that has the node in a pair, 0 = none; shape (n_nodes)
    integer, allocatable :: entry(:)
    !> whether the node is on the first side; shape (n_nodes)
    logical, allocatable :: is_first(:)
    !> [-] normals at first nodes, shape (n_dim, n_nodes)
    real(rk), allocatable :: normals(:, :)
  end type pairing_t

contains

  !> Makes the error `contact[<number of the entry>]: <message>` at the line and column of `name` in the deck.
  pure subroutine refuse(surfaces, name, message, error, hint)
    type(surface_pair_t), intent(in) :: surfaces
    type(name_config_t), intent(in) :: name
    character(*), intent(in) :: message
    type(error_t), allocatable, intent(out) :: error
    character(*), intent(in), optional :: hint

    call make_error(error, entry_text(surfaces%i_entry) // ': ' // message, file=surfaces%deck_path, line=name%line, &
                    column=name%column, hint=hint)
  end subroutine refuse

  !> Makes the error that the surfaces do not face each other along the entry's direction, or along the averaged normals if it has
  !> none, at the deck's name of the first surface. Requires: two surfaces, no obstacle.
  pure subroutine refuse_facing(surfaces, error, reason, hint)
    type(surface_pair_t), intent(in) :: surfaces
    type(error_t), allocatable, intent(out) :: error
    !> end of the message
    character(*), intent(in) :: reason
    !> default: where_text
    character(*), intent(in), optional :: hint
    character(:), allocatable :: line, remedy

    line = 'the averaged normals of the first'
    if (surfaces%entry%has_direction) line = place_text(surfaces%entry%direction)
    remedy = where_text(surfaces)
    if (present(hint)) remedy = hint
    call refuse(surfaces, surfaces%entry%first, "the surfaces '" // surfaces%entry%first%text // "' and '" // &
                surfaces%entry%second%text // "' do not face each other along " // line // ': ' // reason, error, remedy)
  end subroutine refuse_facing

  !> Returns a hint: the boxes of both surfaces, by which a user sees wrong names, units or places, and what to correct.
  pure function where_text(surfaces) result(text)
    type(surface_pair_t), intent(in) :: surfaces
    character(:), allocatable :: text

    text = "'" // surfaces%entry%first%text // "' lies within " // box_text(surfaces%first_box) // ", '" // &
      surfaces%entry%second%text // "' within " // box_text(surfaces%second_box) // &
      '; name two surfaces that face each other, or correct the direction or the position of a body'
  end function where_text

  pure function box_text(box) result(text)
    !> shape (n_dim, 2)
    real(rk), intent(in) :: box(:, :)
    character(:), allocatable :: text

    text = place_text(box(:, 1)) // ' to ' // place_text(box(:, 2))
  end function box_text

  !> Makes the error that some nodes of a surface have no partner, at the deck's name of this surface.
  pure subroutine refuse_unpaired(surfaces, is_second, lonely_nodes, reason, error)
    type(surface_pair_t), intent(in) :: surfaces
    !> whether the nodes lie on the second surface
    logical, intent(in) :: is_second
    !> these nodes; the message has only their number
    integer, intent(in) :: lonely_nodes(:)
    !> reason, about the first of these nodes
    character(*), intent(in) :: reason
    type(error_t), allocatable, intent(out) :: error
    type(name_config_t) :: surface, other
    integer :: n_nodes

    surface = surfaces%entry%first
    other = surfaces%entry%second
    n_nodes = size(surfaces%first_nodes)
    if (is_second) then
      surface = surfaces%entry%second
      other = surfaces%entry%first
      n_nodes = size(surfaces%second_nodes)
    end if
    call refuse(surfaces, surface, to_text(size(lonely_nodes)) // ' of ' // to_text(n_nodes) // " nodes of '" // surface%text // &
                "' have no partner on '" // other%text // "'; " // reason, error, &
                'node-to-node contact needs facing nodes one to one: mesh both surfaces alike, name only what faces, or take ' // &
                'formulation: mortar')
  end subroutine refuse_unpaired

  !> Makes the error that a node in a pair, of this or another entry, would get a second partner, at the deck's name of the first
  !> surface. A partner may be an obstacle.
  pure subroutine refuse_second_pair(mesh, surfaces, pairing, node, other, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    !> all pairs so far
    type(pairing_t), intent(in) :: pairing
    !> 1-based
    integer, intent(in) :: node
    !> partner of the node by this entry, 0 = an obstacle
    integer, intent(in) :: other
    type(error_t), allocatable, intent(out) :: error

    call refuse(surfaces, surfaces%entry%first, node_text(mesh, node) // ' would be in two contact pairs, with ' // &
                partner_text(mesh, pairing%partner(node)) // ' by ' // entry_text(pairing%entry(node)) // ' and with ' // &
                partner_text(mesh, other) // ' by ' // entry_text(surfaces%i_entry), error)
  end subroutine refuse_second_pair

  !> Makes the error that a node is on both surfaces, so that it would be in contact with itself, at the deck's name of the first
  !> surface.
  pure subroutine refuse_common_node(mesh, surfaces, node, error)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    integer, intent(in) :: node
    type(error_t), allocatable, intent(out) :: error

    call refuse(surfaces, surfaces%entry%first, node_text(mesh, node) // " is on both surfaces, '" // &
                surfaces%entry%first%text // "' and '" // surfaces%entry%second%text // "'", error, &
                'contact needs two bodies with nodes of their own: leave the common nodes out of one surface, or draw the ' // &
                'surface once for each body')
  end subroutine refuse_common_node

  !> Makes the error that the surfaces overlap everywhere by more than the size of an element, in the form of refuse_facing.
  pure subroutine refuse_overlap(surfaces, what, overlap, error)
    type(surface_pair_t), intent(in) :: surfaces
    !> word for what overlaps: `pair` of nodes, or `node` with a mortar row
    character(*), intent(in) :: what
    !> [length] smallest overlap, positive
    real(rk), intent(in) :: overlap
    type(error_t), allocatable, intent(out) :: error

    call refuse_facing(surfaces, error, 'at the start every ' // what // ' overlaps by ' // short_number(overlap, fine_digits) // &
                       ' or more, which is more than the size of an element')
  end subroutine refuse_overlap

  pure function partner_text(mesh, i_node) result(text)
    type(mesh_t), intent(in) :: mesh
    !> node, 0 = the obstacle
    integer, intent(in) :: i_node
    character(:), allocatable :: text

    text = 'the obstacle'
    if (i_node > 0) text = node_text(mesh, i_node)
  end function partner_text

  !> Returns a sentence for messages, without a full stop: the distance between the normal's line through a first node and the node
  !> of the second surface that is nearest to this line, and the allowed distance.
  pure function offset_text(mesh, surfaces, i_first) result(text)
    type(mesh_t), intent(in) :: mesh
    type(surface_pair_t), intent(in) :: surfaces
    !> index in surfaces%first_nodes
    integer, intent(in) :: i_first
    character(:), allocatable :: text
    integer :: nearest
    real(rk) :: offset

    call surfaces%tree%nearest(mesh%coordinates(:, surfaces%first_nodes(i_first)), nearest, offset, surfaces%normals(:, i_first))
    text = node_text(mesh, surfaces%first_nodes(i_first)) // ' has its nearest node on the second surface ' // &
      short_number(offset, fine_digits) // ' off its normal; allowed is ' // short_number(surfaces%tolerance, fine_digits) // &
      ' (pairing_tolerance ' // to_text(surfaces%entry%pairing_tolerance) // ' times the mesh size ' // &
      short_number(surfaces%first_geometry%mesh_size, fine_digits) // ')'
  end function offset_text

  !> Returns the name of a contact entry for messages, `contact[2]` for the second one.
  pure function entry_text(i_entry) result(text)
    integer, intent(in) :: i_entry
    character(:), allocatable :: text

    text = 'contact[' // to_text(i_entry) // ']'
  end function entry_text

  !> Returns a node for messages, `node 17 (0.25, 1.0)`, with its number in gmsh.
  pure function node_text(mesh, i_node) result(text)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_node
    character(:), allocatable :: text

    text = 'node ' // to_text(mesh%node_tags(i_node)) // ' ' // place_text(mesh%coordinates(:, i_node))
  end function node_text

  !> Returns coordinates for messages, `(0.25, 1.0)`, rounded to six digits.
  pure function place_text(place) result(text)
    real(rk), intent(in) :: place(:)
    character(:), allocatable :: text
    type(string_t) :: numbers(size(place))
    integer :: i

    do i = 1, size(place)
      numbers(i)%text = short_number(place(i), fine_digits)
    end do
    text = '(' // join(numbers, ', ') // ')'
  end function place_text

  !> Returns a direction as it is written in decks, `[0.0, 1.0]`, rounded to six digits.
  pure function direction_text(direction) result(text)
    real(rk), intent(in) :: direction(:)
    character(:), allocatable :: text

    text = place_text(direction)
    text = '[' // text(2:len(text) - 1) // ']'
  end function direction_text
end module sig_surface_pair
