! SPDX-License-Identifier: BSD-3-Clause
!> Tries guessed contacts of a mesh before a deck names them: `signorom check` must accept what `signorom init` writes.
module sig_guessed_contacts
  use sig_boundary_conditions, only: boundary_conditions_t
  use sig_contact_building, only: build_contact_rows
  use sig_contact_rows, only: contact_rows_t
  use sig_deck_config, only: averaged_tolerance, contact_config_t, deck_config_t
  use sig_elastic_body, only: create_elastic_body, elastic_body_t
  use sig_errors, only: error_t
  use sig_facing_groups, only: facing_groups_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_term_set, only: start_terms, term_set_t
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: try_contacts

contains

  !> Finds the pairs that can be contacts of one deck. All are tried together; one that is refused first loses its direction, then
  !> swaps its surfaces, and is left out if it is still refused. So of two contacts that exclude each other the later one is left
  !> out. Supports are not known yet, and nothing is prescribed.
  subroutine try_contacts(mesh, model, pairs, why_not)
    type(mesh_t), intent(in) :: mesh
    !> name of a mechanical model
    character(*), intent(in) :: model
    !> in: guessed pairs; out: the same, without a direction or with swapped surfaces where that helps
    type(facing_groups_t), intent(inout) :: pairs(:)
    !> why a pair is left out; empty if it is accepted; shape (size(pairs))
    type(string_t), allocatable, intent(out) :: why_not(:)
    type(error_t), allocatable :: error
    logical :: is_swapped(size(pairs))
    integer :: i

    is_swapped = .false.
    allocate (why_not(size(pairs)))
    do i = 1, size(pairs)
      why_not(i)%text = ''
    end do
    do
      call build(mesh, model, pairs, why_not, error)
      if (.not. allocated(error)) exit
      ! the line of a surface's name is the number of its pair; what is no pair's fault is left to `check`
      i = error%line
      if (i == 0) exit
      if (norm2(pairs(i)%direction) > 0) then
        pairs(i)%direction = 0
      else if (.not. is_swapped(i)) then
        is_swapped(i) = .true.
        call swap(pairs(i))
      else
        why_not(i)%text = error%message(index(error%message, ': ') + 2:)
      end if
    end do
  end subroutine try_contacts

  !> Makes the second surface of a pair the first one. Requires: no direction.
  pure subroutine swap(pair)
    type(facing_groups_t), intent(inout) :: pair
    integer :: first

    associate (area => pair%facing_area / pair%share)
      pair%share = min(1.0_rk, pair%facing_area / (pair%whole_area - area))
    end associate
    first = pair%first
    pair%first = pair%second
    pair%second = first
  end subroutine swap

  !> Makes the contact rows of all pairs that are not left out. Errors: those of build_contact_rows, with the number of the pair as
  !> line.
  subroutine build(mesh, model, pairs, why_not, error)
    type(mesh_t), intent(in) :: mesh
    character(*), intent(in) :: model
    type(facing_groups_t), intent(in) :: pairs(:)
    type(string_t), intent(in) :: why_not(:)
    type(error_t), allocatable, intent(out) :: error
    type(deck_config_t) :: deck
    type(elastic_body_t) :: body
    type(boundary_conditions_t) :: boundary
    type(term_set_t) :: terms
    type(contact_rows_t) :: rows
    type(string_t), allocatable :: notes(:)
    logical :: is_swapped(size(pairs))
    integer :: i, material_of_cell(mesh%n_cells)

    deck%path = ''
    allocate (deck%contact(0))
    do i = 1, size(pairs)
      if (len(why_not(i)%text) == 0) deck%contact = [deck%contact, contact_of(mesh, pairs(i), i)]
    end do
    material_of_cell = 1
    call create_elastic_body(model, [1.0_rk], [0.0_rk], material_of_cell, body)
    call start_terms([string_t ::], [string_t ::], body%mechanics%is_round, terms)
    allocate (boundary%is_prescribed(mesh%n_dim * mesh%n_nodes), source=.false.)
    call build_contact_rows(deck, mesh, body, boundary, terms, rows, notes, is_swapped(:size(deck%contact)), error)
  end subroutine build

  !> Returns the entry of a deck for a pair, with the number of the pair as its line.
  pure type(contact_config_t) function contact_of(mesh, pair, i_pair) result(contact)
    type(mesh_t), intent(in) :: mesh
    type(facing_groups_t), intent(in) :: pair
    integer, intent(in) :: i_pair

    contact%first%text = mesh%groups(pair%first)%name
    contact%second%text = mesh%groups(pair%second)%name
    contact%first%line = i_pair
    contact%second%line = i_pair
    contact%direction_line = i_pair
    contact%has_direction = norm2(pair%direction) > 0
    contact%direction = pair%direction(:mesh%n_dim)
    if (.not. contact%has_direction) contact%pairing_tolerance = averaged_tolerance
  end function contact_of
end module sig_guessed_contacts
