! SPDX-License-Identifier: BSD-3-Clause
!> Gaps that the deck gives, in place of the distances between the nodes.
module sig_initial_gap
  use sig_deck_config, only: contact_config_t
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_node_pairs, only: node_pairs_t
  use sig_term_set, only: term_set_t
  use sig_value_terms, only: split_value, value_terms_t
  implicit none(type, external)
  private
  public :: set_initial_gaps

contains

  !> Sets the gaps of the entries that have an expression for them, at the coordinates of the first nodes.
  !>
  !> Errors: a gap that is not finite at a node.
  subroutine set_initial_gaps(mesh, contact, deck_path, terms, pairs, error)
    type(mesh_t), intent(in) :: mesh
    type(contact_config_t), intent(in) :: contact(:)
    character(*), intent(in) :: deck_path
    !> grows by what the gaps depend on
    type(term_set_t), intent(inout) :: terms
    type(node_pairs_t), intent(inout) :: pairs
    type(error_t), allocatable, intent(out) :: error
    type(value_terms_t) :: parts
    integer :: i, i_entry

    do i_entry = 1, size(contact)
      if (.not. contact(i_entry)%has_initial_gap) cycle
      associate (members => pack([(i, i=1, pairs%n_pairs)], pairs%contact_entry == i_entry))
        call split_value(mesh, pairs%first_node(members), contact(i_entry)%initial_gap, deck_path, terms, parts, error)
        if (allocated(error)) return
        pairs%initial_gap(members) = merge(parts%factors, 0.0_rk, parts%terms == 1)
        pairs%gap_term(members) = merge(0, parts%terms, parts%terms == 1)
      end associate
    end do
  end subroutine set_initial_gaps
end module sig_initial_gap
