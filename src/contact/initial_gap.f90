! SPDX-License-Identifier: BSD-3-Clause
!> Gaps that the deck gives, by an expression or by a rigid obstacle, in place of the distances between the nodes.
module sig_initial_gap
  use sig_deck_config, only: contact_config_t, value_config_t
  use sig_errors, only: error_t, make_error
  use sig_expression, only: max_composed
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_node_pairs, only: node_pairs_t
  use sig_obstacle_gap, only: obstacle_gap
  use sig_term_set, only: term_set_t
  use sig_text, only: to_text
  use sig_value_terms, only: split_sum, value_terms_t
  implicit none(type, external)
  private
  public :: set_initial_gaps

contains

  !> Sets the gaps of the entries with an obstacle or with a gap in the deck, at the coordinates of the first nodes. The gaps of the
  !> other entries, which the mesh gives, remain. Requires: the gap_factors of the entries are 0 or not there yet.
  !>
  !> Errors: those of split_sum, such as a gap that is not finite at a node; expressions of an obstacle that are too long together.
  subroutine set_initial_gaps(mesh, contact, deck_path, terms, pairs, error)
    type(mesh_t), intent(in) :: mesh
    !> entries of the deck's contact section
    type(contact_config_t), intent(in) :: contact(:)
    !> path of the deck, for messages
    character(*), intent(in) :: deck_path
    !> grows by the terms that the gaps need
    type(term_set_t), intent(inout) :: terms
    !> in: the pairs of all entries; out: those of entries with an obstacle or with a gap in the deck have new initial_gap and
    !> gap_factors
    type(node_pairs_t), intent(inout) :: pairs
    type(error_t), allocatable, intent(out) :: error
    type(value_config_t) :: shape, shift
    integer :: i, i_entry

    do i_entry = 1, size(contact)
      if (.not. (contact(i_entry)%has_initial_gap .or. contact(i_entry)%has_obstacle)) cycle
      associate (members => pack([(i, i=1, pairs%n_pairs)], pairs%contact_entry == i_entry))
        pairs%initial_gap(members) = 0
        if (contact(i_entry)%has_obstacle) then
          call obstacle_gap(contact(i_entry), terms%coordinate_names, shape, shift)
          shape%name = 'gap of contact[' // to_text(i_entry) // '], ' // contact(i_entry)%obstacle%type // ','
          if (len(shape%text) > max_composed) call make_error(error, 'the expressions of this obstacle are too long', deck_path, &
            shape%line, shape%column, 'shorten them; the gap of a sphere contains its center and radius several times')
          if (allocated(error)) return
          call add_gap(mesh, members, shift, deck_path, terms, pairs, error)
          if (allocated(error)) return
          call add_gap(mesh, members, shape, deck_path, terms, pairs, error)
        else
          call add_gap(mesh, members, contact(i_entry)%initial_gap, deck_path, terms, pairs, error)
        end if
      end associate
      if (allocated(error)) return
    end do
  end subroutine set_initial_gaps

  !> Adds a value of the deck to the gaps of some pairs, computed at their first nodes. Parts with term 1 (see split_sum) are added
  !> to initial_gap, the factors of all other terms to gap_factors. Errors: those of split_sum.
  subroutine add_gap(mesh, members, value, deck_path, terms, pairs, error)
    type(mesh_t), intent(in) :: mesh
    !> indices of these pairs, 1-based
    integer, intent(in) :: members(:)
    type(value_config_t), intent(in) :: value
    character(*), intent(in) :: deck_path
    type(term_set_t), intent(inout) :: terms
    type(node_pairs_t), intent(inout) :: pairs
    type(error_t), allocatable, intent(out) :: error
    type(value_terms_t), allocatable :: parts(:)
    integer :: i, k

    call split_sum(mesh, pairs%first_node(members), value, deck_path, terms, parts, error)
    if (allocated(error)) return
    pairs%gap_factors = reshape(pairs%gap_factors, [pairs%n_pairs, terms%n_terms()], pad=[0.0_rk])
    do k = 1, size(parts)
      do i = 1, size(members)
        associate (member => members(i), term => parts(k)%terms(i), factor => parts(k)%factors(i))
          if (term == 1) then
            pairs%initial_gap(member) = pairs%initial_gap(member) + factor
          else
            pairs%gap_factors(member, term) = pairs%gap_factors(member, term) + factor
          end if
        end associate
      end do
    end do
  end subroutine add_gap
end module sig_initial_gap
