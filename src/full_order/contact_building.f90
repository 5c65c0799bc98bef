! SPDX-License-Identifier: BSD-3-Clause
!> The contact rows of a deck: pairs of nodes where the nodes face each other one to one, mortar elsewhere, and obstacles.
module sig_contact_building
  use sig_boundary_conditions, only: boundary_conditions_t
  use sig_contact_rows, only: contact_rows_t
  use sig_deck_config, only: deck_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_errors, only: error_t
  use sig_initial_gap, only: set_initial_gaps
  use sig_mesh, only: mesh_t
  use sig_mortar_rows, only: add_mortar_rows
  use sig_node_pair_rows, only: areas_of_pairs, create_node_pair_rows
  use sig_node_pairs, only: find_node_pairs, node_pairs_t
  use sig_term_set, only: term_set_t
  use sig_text, only: append_text, string_t, to_text
  implicit none(type, external)
  private
  public :: build_contact_rows

contains

  !> Rows of all entries. The terms of their gaps come behind all others.
  !>
  !> Errors: surfaces that do not face each other, nodes in two contacts, nodes that cannot carry a contact force.
  subroutine build_contact_rows(deck, mesh, body, boundary, terms, rows, notes, is_swapped, error)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(boundary_conditions_t), intent(in) :: boundary
    type(term_set_t), intent(inout) :: terms
    type(contact_rows_t), intent(out) :: rows
    !> a sentence for each entry that needs mortar
    type(string_t), allocatable, intent(out) :: notes(:)
    !> the multipliers of the entry sit on its second surface; shape (size(deck%contact))
    logical, intent(out) :: is_swapped(:)
    type(error_t), allocatable, intent(out) :: error
    type(node_pairs_t) :: pairs
    character(:), allocatable :: cover
    type(string_t), allocatable :: why_mortar(:)
    integer :: i

    allocate (notes(0))
    is_swapped = .false.
    call find_node_pairs(mesh, body%mechanics%is_round, deck%contact, deck%path, pairs, error, why_mortar)
    if (allocated(error)) return
    call set_initial_gaps(mesh, deck%contact, deck%path, terms, pairs, error)
    if (allocated(error)) return
    call create_node_pair_rows(pairs, areas_of_pairs(mesh, body, deck%contact, pairs), terms%n_terms(), rows)
    do i = 1, size(deck%contact)
      if (len(why_mortar(i)%text) == 0) cycle
      call add_mortar_rows(mesh, body%mechanics, deck%contact, i, deck%path, boundary%is_prescribed, terms, rows, cover, &
        is_swapped(i), error)
      if (allocated(error)) return
      call append_text(notes, 'contact[' // to_text(i) // ']: mortar, ' // why_mortar(i)%text // ': ' // cover)
    end do
  end subroutine build_contact_rows
end module sig_contact_building
