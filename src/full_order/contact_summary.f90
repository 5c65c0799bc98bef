! SPDX-License-Identifier: BSD-3-Clause
!> Describes the contacts that were found in the mesh, before anything is solved: one line per contact entry of the deck.
module sig_contact_summary
  use sig_contact_rows, only: contact_rows_t
  use sig_deck_config, only: contact_config_t, deck_config_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_rounding, only: rounding
  use sig_term_set, only: term_set_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: append_text, counted, fine_digits, short_number, string_t, to_text
  implicit none(type, external)
  private
  public :: contact_lines, contact_name

contains

  !> Returns a line per contact entry, `contact[1]: lower_arc - upper_arc, 55 pairs (2 inert), friction mu, gaps 0.1 to 2.1 m`: its
  !> surfaces; the number of all its rows (`nodes` with an obstacle, else `pairs`, also for mortar rows) and how many of them are
  !> inert, if any; the smallest and the largest gap of all its rows at all points. Gaps are left out if there are no rows or no
  !> points.
  function contact_lines(deck, mesh, rows, inert, terms, points) result(lines)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    !> rows with a multiplier
    type(contact_rows_t), intent(in) :: rows
    !> rows without a multiplier
    type(contact_rows_t), intent(in) :: inert
    !> of the problem; the gaps of both kinds of rows belong to them
    type(term_set_t), intent(in) :: terms
    !> shape (n_parameters, n_points); check_points accepted them
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable :: lines(:)
    real(rk), allocatable :: theta(:, :)
    integer :: i, i_bad_point, i_bad_source, i_entry

    allocate (lines(0))
    call evaluate_points(terms, points, theta, i_bad_point, i_bad_source)
    do i_entry = 1, size(deck%contact)
      associate (active => pack([(i, i=1, rows%n_rows)], rows%contact_entry == i_entry), &
        idle => pack([(i, i=1, inert%n_rows)], inert%contact_entry == i_entry))
        call append_text(lines, 'contact[' // to_text(i_entry) // ']: ' // contact_name(deck, i_entry) // &
          count_text(deck%contact(i_entry)%has_obstacle, size(active) + size(idle), size(idle)) // &
          law_text(deck%contact(i_entry)) // &
          gaps_text(reshape([transpose(rows%gap(active, :)), transpose(inert%gap(idle, :))], &
          [size(theta, 1), size(active) + size(idle)]), theta, rounding * maxval(abs(mesh%coordinates)), deck%units%length))
      end associate
    end do
  end function contact_lines

  !> Returns the names of both sides of a contact entry in the deck's order, `lower_arc - upper_arc`, or with an obstacle
  !> `lower_arc - rigid sphere` or `lower_arc - rigid plane`.
  pure function contact_name(deck, i_entry) result(text)
    type(deck_config_t), intent(in) :: deck
    !> 1-based
    integer, intent(in) :: i_entry
    character(:), allocatable :: text

    associate (contact => deck%contact(i_entry))
      if (contact%has_obstacle) then
        text = contact%first%text // ' - rigid ' // contact%obstacle%type
      else
        text = contact%first%text // ' - ' // contact%second%text
      end if
    end associate
  end function contact_name

  pure function count_text(has_obstacle, n_pairs, n_inert) result(text)
    logical, intent(in) :: has_obstacle
    integer, intent(in) :: n_pairs
    integer, intent(in) :: n_inert
    character(:), allocatable :: text

    text = ', ' // counted(n_pairs, merge('node', 'pair', has_obstacle))
    if (n_inert > 0) text = text // ' (' // to_text(n_inert) // ' inert)'
  end function count_text

  !> Returns `, friction 0.3`, `, tied` or `, tied along the normal`; empty without friction and ties.
  pure function law_text(contact) result(text)
    type(contact_config_t), intent(in) :: contact
    character(:), allocatable :: text

    text = ''
    if (contact%has_friction) text = ', friction ' // contact%friction%text
    if (contact%tied == 'true') text = ', tied'
    if (contact%tied == 'normal') text = ', tied along the normal'
  end function law_text

  !> Returns `, gaps <smallest> to <largest> <unit>` over all rows and points; empty without rows or points.
  pure function gaps_text(gaps, theta, noise, unit) result(text)
    !> [length] D of each row by term, shape (n_terms, n_rows)
    real(rk), intent(in) :: gaps(:, :)
    !> values of the terms, shape (n_terms, n_points)
    real(rk), intent(in) :: theta(:, :)
    !> [length] an end of the range that is at most so large is shown as 0
    real(rk), intent(in) :: noise
    character(*), intent(in) :: unit
    character(:), allocatable :: text
    real(rk), allocatable :: needed(:, :)
    integer, allocatable :: used(:)
    real(rk) :: at_point(size(gaps, 2)), smallest, largest
    integer :: i, i_point

    text = ''
    if (size(gaps, 2) == 0 .or. size(theta, 2) == 0) return
    smallest = huge(smallest)
    largest = -huge(largest)
    ! if there are many terms, most of them belong to a load, and no gap needs them
    used = pack([(i, i=1, size(gaps, 1))], any(abs(gaps) > 0, dim=2))
    needed = gaps(used, :)
    do i_point = 1, size(theta, 2)
      at_point = matmul(theta(used, i_point), needed)
      smallest = min(smallest, minval(at_point))
      largest = max(largest, maxval(at_point))
    end do
    if (abs(smallest) <= noise) smallest = 0
    if (abs(largest) <= noise) largest = 0
    text = ', gaps ' // short_number(smallest, fine_digits) // ' to ' // short_number(largest, fine_digits) // ' ' // unit
  end function gaps_text
end module sig_contact_summary
