! SPDX-License-Identifier: BSD-3-Clause
!> The contact rows of a deck: pairs of nodes where the nodes face each other one to one, mortar elsewhere, and obstacles at single
!> nodes or, with some quadratic facets, in a changed basis.
module sig_contact_building
  use sig_boundary_conditions, only: boundary_conditions_t
  use sig_contact_rows, only: contact_rows_t
  use sig_deck_config, only: deck_config_t
  use sig_direction_notes, only: add_direction_notes
  use sig_elastic_body, only: elastic_body_t
  use sig_errors, only: error_t
  use sig_initial_gap, only: set_initial_gaps
  use sig_mesh, only: mesh_t
  use sig_mortar_rows, only: add_mortar_rows, may_swap, side_choice_t
  use sig_node_pair_rows, only: areas_of_pairs, create_node_pair_rows
  use sig_node_pairs, only: find_node_pairs, node_pairs_t
  use sig_obstacle_rows, only: add_obstacle_rows
  use sig_term_set, only: term_set_t
  use sig_text, only: append_text, string_t, to_text
  implicit none(type, external)
  private
  public :: build_contact_rows

contains

  !> Makes the contact rows of all contact entries of the deck, those of pairs and obstacles at single nodes first, then the others.
  !> Adds the terms of their gaps behind those that `terms` has.
  !>
  !> Errors: those of find_node_pairs, set_initial_gaps, add_mortar_rows and add_obstacle_rows, such as surfaces that do not face
  !> each other, nodes in two contacts, nodes that cannot carry a contact force, a gap of the deck that is not finite. Then rows,
  !> terms and notes may be incomplete.
  subroutine build_contact_rows(deck, mesh, body, boundary, terms, rows, notes, is_swapped, error)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(boundary_conditions_t), intent(in) :: boundary
    type(term_set_t), intent(inout) :: terms
    type(contact_rows_t), intent(out) :: rows
    !> a sentence for each entry with mortar rows: why it has no pairs, and what was found; then those of add_direction_notes
    type(string_t), allocatable, intent(out) :: notes(:)
    !> whether the multipliers of each entry are on its second surface, possible for mortar rows only; shape (size(deck%contact))
    logical, intent(out) :: is_swapped(:)
    type(error_t), allocatable, intent(out) :: error
    type(node_pairs_t) :: pairs
    type(string_t), allocatable :: why_mortar(:)
    type(contact_rows_t) :: pair_rows

    is_swapped = .false.
    allocate (notes(0))
    call find_node_pairs(mesh, body%mechanics%is_round, deck%contact, deck%path, pairs, error, why_mortar)
    if (allocated(error)) return
    call set_initial_gaps(mesh, deck%contact, deck%path, terms, pairs, error)
    if (allocated(error)) return
    call create_node_pair_rows(pairs, areas_of_pairs(mesh, body, deck%contact, pairs), terms%n_terms(), pair_rows)
    call add_mortar(deck, mesh, body, boundary, why_mortar, pair_rows, terms, rows, notes, is_swapped, error)
    call add_direction_notes(mesh, deck%path, deck%contact, notes)
  end subroutine build_contact_rows

  !> Adds the rows of all entries without pairs, in the deck's order. If an entry is refused and another entry may make it
  !> possible by swapping its sides, that other entry must swap them, and all mortar rows are built anew. No entry is told so twice.
  !>
  !> Errors: those of add_mortar_rows and add_obstacle_rows; if entries swapped in vain, the error from before the first such swap.
  subroutine add_mortar(deck, mesh, body, boundary, why_mortar, pair_rows, terms, rows, notes, is_swapped, error)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(boundary_conditions_t), intent(in) :: boundary
    !> why the entry needs mortar, empty where it has pairs; shape (size(deck%contact))
    type(string_t), intent(in) :: why_mortar(:)
    !> rows of all pairs, which `rows` has first
    type(contact_rows_t), intent(in) :: pair_rows
    type(term_set_t), intent(inout) :: terms
    type(contact_rows_t), intent(out) :: rows
    type(string_t), allocatable, intent(out) :: notes(:)
    !> as in build_contact_rows; false everywhere after an error
    logical, intent(out) :: is_swapped(:)
    type(error_t), allocatable, intent(out) :: error
    type(side_choice_t) :: choices(size(deck%contact)), must(size(deck%contact))
    type(error_t), allocatable :: first_error
    type(term_set_t) :: terms_before
    integer :: i

    terms_before = terms
    do
      terms = terms_before
      rows = pair_rows
      choices = must
      do i = 1, size(deck%contact)
        if (len(why_mortar(i)%text) == 0) cycle
        if (deck%contact(i)%has_obstacle) then
          call add_obstacle_rows(mesh, body, deck%contact, i, deck%path, boundary%is_prescribed, terms, rows, error)
        else
          call add_mortar_rows(mesh, body%mechanics, deck%contact, i, deck%path, boundary%is_prescribed, terms, rows, choices(i), &
            error)
        end if
        if (allocated(error)) exit
      end do
      if (.not. allocated(error)) exit
      if (.not. allocated(first_error)) first_error = error
      if (.not. can_swap(choices(i)%i_other)) exit
      must(choices(i)%i_other)%why_swapped = choices(i)%why_other
    end do
    if (allocated(error)) error = first_error
    allocate (notes(0))
    do i = 1, size(deck%contact)
      is_swapped(i) = allocated(choices(i)%why_swapped) .and. .not. allocated(error)
      if (allocated(choices(i)%note)) call append_text(notes, 'contact[' // to_text(i) // ']: mortar, ' // why_mortar(i)%text // &
        ': ' // choices(i)%note)
    end do

  contains

    !> Whether the entry is a mortar contact that may swap its sides and was not yet told to.
    logical function can_swap(i_entry)
      integer, intent(in) :: i_entry

      can_swap = .false.
      if (i_entry == 0) return
      can_swap = len(why_mortar(i_entry)%text) > 0 .and. may_swap(deck%contact(i_entry)) .and. &
        .not. allocated(must(i_entry)%why_swapped)
    end function can_swap
  end subroutine add_mortar
end module sig_contact_building
