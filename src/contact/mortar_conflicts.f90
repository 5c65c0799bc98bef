! SPDX-License-Identifier: BSD-3-Clause
!> Reasons to refuse the rows of a mortar contact: rows of other contacts at the same nodes, owners that cannot move.
module sig_mortar_conflicts
  use sig_contact_rows, only: contact_rows_t
  use sig_deck_config, only: contact_config_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_rounding, only: dependent
  use sig_surface_pair, only: node_text
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: conflict_t, find_conflict, shared_text

  !> A reason against the rows of a contact, as an error for the user.
  type :: conflict_t
    character(:), allocatable :: message
    character(:), allocatable :: hint
    !> number (1-based) of another contact entry that has a row at a node of this contact's second side, 0 = none; if that entry
    !> swapped its sides, the node could be in both contacts
    integer :: i_owner = 0
    !> the node, natural, 1-based; 0 = none
    integer :: node = 0
  end type conflict_t

contains

  !> Finds the first reason against the rows of a contact, row by row: a node of its first side that is in rows of other contacts,
  !> too; a node of its second side that owns a row of another contact; an owner that cannot move along its normal while other nodes
  !> of its row can. `conflict` is not allocated if there is none.
  pure subroutine find_conflict(mesh, contact, is_prescribed, rows, more, conflict)
    type(mesh_t), intent(in) :: mesh
    !> entries of the deck's contact section
    type(contact_config_t), intent(in) :: contact(:)
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    !> rows that other contacts have so far (pairs of all entries, mortar of the entries before), and those of this entry
    type(contact_rows_t), intent(in) :: rows, more
    type(conflict_t), allocatable, intent(out) :: conflict
    integer :: k, n_rows_of_node(mesh%n_nodes)
    logical :: is_owner(mesh%n_nodes)

    is_owner = .false.
    is_owner(rows%owners()) = .true.
    n_rows_of_node = rows%rows_per_node(mesh%n_nodes)
    do k = 1, more%n_rows
      associate (owner => more%first_nodes_of(k), met => more%second_nodes_of(k))
        if (any(n_rows_of_node(owner) > 0)) then
          call name_other_contact(owner(findloc(n_rows_of_node(owner) > 0, .true., dim=1)), conflict)
        else if (any(is_owner(met))) then
          call name_other_contact(met(findloc(is_owner(met), .true., dim=1)), conflict)
          conflict%i_owner = entry_at(rows, conflict%node)
        else if (is_stuck(more, k, is_prescribed)) then
          allocate (conflict)
          conflict%message = 'the displacement of ' // node_text(mesh, owner(1)) // &
            ' is prescribed along its normal, so that it cannot carry a contact force'
          conflict%hint = 'leave the facets at such nodes out of the first surface, or swap first and second if the second ' // &
            'has no such nodes'
        end if
      end associate
      if (allocated(conflict)) return
    end do

  contains

    pure subroutine name_other_contact(node, found)
      integer, intent(in) :: node
      type(conflict_t), allocatable, intent(out) :: found

      allocate (found)
      found%node = node
      found%message = shared_text(mesh, contact, node, entry_at(rows, node))
      found%hint = 'give each contact its own surfaces, which share no node'
    end subroutine name_other_contact
  end subroutine find_conflict

  !> Returns a text such as `node 17 (0.25, 1.0) is in contact[1], too, of 'foot' and 'floor'`.
  pure function shared_text(mesh, contact, node, i_entry) result(text)
    type(mesh_t), intent(in) :: mesh
    type(contact_config_t), intent(in) :: contact(:)
    !> natural, 1-based
    integer, intent(in) :: node
    !> entry that has the node, too, 1-based
    integer, intent(in) :: i_entry
    character(:), allocatable :: text

    text = node_text(mesh, node) // ' is in contact[' // to_text(i_entry) // '], too, of ' // surfaces_text(contact(i_entry))
  end function shared_text

  !> Returns the entry of the row that a node owns, or else of the first row that the node is in.
  pure integer function entry_at(rows, node)
    type(contact_rows_t), intent(in) :: rows
    !> a node of some row
    integer, intent(in) :: node
    integer :: k

    k = findloc(rows%owners(), node, dim=1)
    if (k == 0) then
      do k = 1, rows%n_rows
        if (any(rows%nodes_of(k) == node)) exit
      end do
    end if
    entry_at = rows%contact_entry(k)
  end function entry_at

  pure function surfaces_text(entry) result(text)
    type(contact_config_t), intent(in) :: entry
    character(:), allocatable :: text

    text = "'" // entry%first%text // "' and " // 'an obstacle'
    if (.not. entry%has_obstacle) text = "'" // entry%first%text // "' and '" // entry%second%text // "'"
  end function surfaces_text

  !> Whether the owner cannot move along its normal while others of the row can.
  pure logical function is_stuck(rows, row, is_prescribed)
    type(contact_rows_t), intent(in) :: rows
    !> 1-based
    integer, intent(in) :: row
    logical, intent(in) :: is_prescribed(:)
    real(rk) :: free(size(rows%dofs_of(row)))

    free = merge(0.0_rk, rows%coefficients_of(row), is_prescribed(rows%dofs_of(row)))
    is_stuck = norm2(free(:rows%n_dim)) < dependent .and. norm2(free) > dependent
  end function is_stuck
end module sig_mortar_conflicts
