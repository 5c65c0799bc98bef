! SPDX-License-Identifier: BSD-3-Clause
!> Friction and ties of a deck: terms of the coefficients of friction, tangential rows, and the laws of all contacts.
module sig_friction_building
  use sig_boundary_conditions, only: boundary_conditions_t
  use sig_contact_laws, only: contact_laws_t, laws_without_friction
  use sig_contact_rows, only: contact_rows_t
  use sig_deck_config, only: contact_config_t, deck_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_tangential_rows, only: create_tangential_rows, direction_of, find_dependent, tangential_rows_t
  use sig_term_set, only: term_set_t
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: add_friction_terms, add_motion_terms, create_contact_laws

contains

  !> Adds a term for each coefficient of friction that depends on the parameters.
  pure subroutine add_friction_terms(contact, terms, friction_terms)
    type(contact_config_t), intent(in) :: contact(:)
    type(term_set_t), intent(inout) :: terms
    !> term of each contact entry, 1 where the coefficient is a constant or missing; shape (size(contact))
    integer, allocatable, intent(out) :: friction_terms(:)
    integer :: i

    allocate (friction_terms(size(contact)), source=1)
    do i = 1, size(contact)
      if (.not. contact(i)%has_friction) cycle
      associate (f => contact(i)%friction)
        if (.not. f%is_constant) call terms%add_expression(f%text, f%line, f%column, friction_terms(i))
      end associate
    end do
  end subroutine add_friction_terms

  !> Adds a term for each component of the motion of an obstacle since the time 0. An obstacle moves by the time and by tables, not
  !> by parameters: they say where it stands.
  pure subroutine add_motion_terms(deck, terms, motion_terms)
    type(deck_config_t), intent(in) :: deck
    type(term_set_t), intent(inout) :: terms
    !> terms of the components of each contact entry's obstacle [length], 0 where it stands still; shape (n_dim, size(contact))
    integer, allocatable, intent(out) :: motion_terms(:, :)
    integer :: i, k

    allocate (motion_terms(size(terms%coordinate_names), size(deck%contact)), source=0)
    do i = 1, size(deck%contact)
      associate (entry => deck%contact(i))
        if (.not. (entry%has_obstacle .and. (entry%has_friction .or. entry%tied /= 'false'))) cycle
        do k = 1, size(entry%obstacle%place)
          associate (place => entry%obstacle%place(k))
            if (place%uses_history) call terms%add_expression('(' // place%text // ') - (' // &
              deck%history%states%at_start(place%text) // ')', entry%obstacle%line, entry%obstacle%column, motion_terms(k, i))
          end associate
        end do
      end associate
    end do
  end subroutine add_motion_terms

  !> Makes the laws of the contacts, and the rows of all their forces: normal rows, then tangential rows. Tied contacts have no gap,
  !> whatever the mesh has, but follow an obstacle. Errors: a contact whose nodes have too few free directions for friction.
  subroutine create_contact_laws(deck, mesh, boundary, friction_terms, motion_terms, normal, force_rows, laws, error)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(boundary_conditions_t), intent(in) :: boundary
    !> of add_friction_terms
    integer, intent(in) :: friction_terms(:)
    !> of add_motion_terms
    integer, intent(in) :: motion_terms(:, :)
    !> normal rows; those of tied contacts lose their gaps
    type(contact_rows_t), intent(inout) :: normal
    type(contact_rows_t), intent(out) :: force_rows
    type(contact_laws_t), intent(out) :: laws
    type(error_t), allocatable, intent(out) :: error
    type(tangential_rows_t) :: tangential
    logical, allocatable :: is_held(:)
    logical :: has_tangents(normal%n_rows)
    integer :: k

    laws = laws_without_friction(normal%n_rows)
    do k = 1, normal%n_rows
      associate (entry => deck%contact(normal%contact_entry(k)))
        laws%is_tied(k) = entry%tied /= 'false'
        if (laws%is_tied(k)) then
          normal%gap(k, :) = 0
          call add_motion(motion_terms, normal, k)
        end if
        has_tangents(k) = entry%has_friction .or. entry%tied == 'true'
        if (.not. entry%has_friction) cycle
        laws%friction_terms(k) = friction_terms(normal%contact_entry(k))
        laws%friction_factors(k) = merge(entry%friction%constant, 1.0_rk, entry%friction%is_constant)
      end associate
    end do
    is_held = boundary%is_prescribed
    is_held(boundary%prescribed_dofs) = all(boundary%prescribed_values == 0, dim=2)
    call create_tangential_rows(normal, has_tangents, mesh%coordinates, boundary%is_prescribed, is_held, tangential)
    do k = 1, tangential%rows%n_rows
      call add_motion(motion_terms, tangential%rows, k)
    end do
    if (tangential%rows%n_rows > 0) call check_directions(deck, mesh, boundary%is_prescribed, normal, tangential, error)
    laws%tangents = tangential%rows_of_contacts(normal%n_rows)
    do k = 1, tangential%rows%n_rows
      where (laws%tangents(:, tangential%contacts(k)) == k) laws%directions(:, tangential%contacts(k)) = tangential%directions(k)
    end do
    where (laws%tangents > 0) laws%tangents = laws%tangents + normal%n_rows
    force_rows = normal
    call force_rows%append(tangential%rows)
    ! the areas of all rows together are those of the contacts
    force_rows%areas(normal%n_rows + 1:) = 0
  end subroutine create_contact_laws

  !> Adds to the gap of a row without one the motion of its obstacle along the row: the surface closes or slips by B u less this
  !> motion.
  pure subroutine add_motion(motion_terms, rows, row)
    !> of add_motion_terms
    integer, intent(in) :: motion_terms(:, :)
    type(contact_rows_t), intent(inout) :: rows
    integer, intent(in) :: row
    integer :: i

    associate (direction => direction_of(rows, row), terms => motion_terms(:, rows%contact_entry(row)))
      do i = 1, size(terms)
        if (terms(i) > 0) rows%gap(row, terms(i)) = direction(i)
      end do
    end associate
  end subroutine add_motion

  !> Errors: find_dependent finds a contact.
  subroutine check_directions(deck, mesh, is_prescribed, normal, tangential, error)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: is_prescribed(:)
    type(contact_rows_t), intent(in) :: normal
    type(tangential_rows_t), intent(in) :: tangential
    type(error_t), allocatable, intent(out) :: error
    integer :: k

    k = find_dependent(normal, tangential, is_prescribed)
    if (k == 0) return
    associate (owners => normal%owners())
      associate (entry => deck%contact(normal%contact_entry(k)), owner => owners(k))
        call make_error(error, 'contact[' // to_text(normal%contact_entry(k)) // ']: prescribed displacements leave node ' // &
          to_text(mesh%node_tags(owner)) // ' too few directions for forces of contact and friction: these forces are not ' // &
          'unique', deck%path, entry%first%line, entry%first%column, &
          'prescribe fewer components there, or leave friction out of this entry')
      end associate
    end associate
  end subroutine check_directions
end module sig_friction_building
