! SPDX-License-Identifier: BSD-3-Clause
!> Prescribed displacements as a sum of terms: value = sum over t of theta_t(mu) * pattern_t, with theta_1 = 1.
module sig_boundary_conditions
  use sig_deck_config, only: boundary_config_t, value_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_checks, only: nodes_of_boundary
  use sig_text, only: append_text, string_t, to_text
  implicit none(type, external)
  private
  public :: boundary_conditions_t, create_boundary_conditions

  type :: boundary_conditions_t
    integer :: n_terms = 1
    !> theta_t as expressions of the parameters; the first is 1
    type(string_t), allocatable :: term_texts(:)
    !> natural, ascending
    integer, allocatable :: prescribed_dofs(:)
    !> [length] shape (n_prescribed, n_terms)
    real(rk), allocatable :: prescribed_values(:, :)
    !> shape (n_dofs)
    logical, allocatable :: is_prescribed(:)
  end type boundary_conditions_t

contains

  !> Errors: unknown boundary name; a dof prescribed by two entries with different values.
  subroutine create_boundary_conditions(mesh, entries, deck_path, conditions, error)
    type(mesh_t), intent(in) :: mesh
    type(boundary_config_t), intent(in) :: entries(:)
    character(*), intent(in) :: deck_path
    type(boundary_conditions_t), intent(out) :: conditions
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: nodes(:), entry_of_dof(:)
    integer :: i_entry, i_component

    allocate (entry_of_dof(mesh%n_dim * mesh%n_nodes), source=0)
    do i_entry = 1, size(entries)
      call nodes_of_boundary(mesh, entries(i_entry)%boundary, deck_path, nodes, error)
      if (allocated(error)) return
      do i_component = 1, mesh%n_dim
        if (.not. entries(i_entry)%is_prescribed(i_component)) cycle
        call claim_dofs(entries, i_entry, i_component, mesh, nodes, deck_path, entry_of_dof, error)
        if (allocated(error)) return
      end do
    end do
    call collect_terms(mesh%n_dim, entries, entry_of_dof, conditions)
  end subroutine create_boundary_conditions

  !> Notes which entry prescribes the dofs; two entries may meet at a corner if they say the same.
  subroutine claim_dofs(entries, i_entry, i_component, mesh, nodes, deck_path, entry_of_dof, error)
    type(boundary_config_t), intent(in) :: entries(:)
    integer, intent(in) :: i_entry
    integer, intent(in) :: i_component
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: nodes(:)
    character(*), intent(in) :: deck_path
    integer, intent(inout) :: entry_of_dof(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i, i_dof, other

    do i = 1, size(nodes)
      i_dof = mesh%n_dim * (nodes(i) - 1) + i_component
      other = entry_of_dof(i_dof)
      if (other == 0) then
        entry_of_dof(i_dof) = i_entry
      else if (differ(entries(other)%displacement(i_component), entries(i_entry)%displacement(i_component))) then
        call make_error(error, 'node ' // to_text(mesh%node_tags(nodes(i))) // ' belongs to ''' // &
          entries(other)%boundary%text // ''' and ''' // entries(i_entry)%boundary%text // ''', which prescribe different ' // &
          entries(i_entry)%axes(i_component) // ' displacements there; they must agree', deck_path, &
          entries(i_entry)%boundary%line, entries(i_entry)%boundary%column)
        return
      end if
    end do
  end subroutine claim_dofs

  !> Constants by value: 0 and 0.0 are the same.
  pure logical function differ(one, other)
    type(value_config_t), intent(in) :: one
    type(value_config_t), intent(in) :: other

    if (one%is_constant .and. other%is_constant) then
      differ = abs(one%constant - other%constant) > 0
    else
      differ = one%text /= other%text
    end if
  end function differ

  !> One term for all constants, then one per entry and component whose value depends on the parameters.
  pure subroutine collect_terms(n_dim, entries, entry_of_dof, conditions)
    integer, intent(in) :: n_dim
    type(boundary_config_t), intent(in) :: entries(:)
    integer, intent(in) :: entry_of_dof(:)
    type(boundary_conditions_t), intent(inout) :: conditions
    integer :: term_of(n_dim, size(entries)), i, i_component, i_dof, i_entry

    call append_text(conditions%term_texts, '1')
    do i_entry = 1, size(entries)
      do i_component = 1, n_dim
        term_of(i_component, i_entry) = 1
        if (.not. entries(i_entry)%is_prescribed(i_component)) cycle
        if (entries(i_entry)%displacement(i_component)%is_constant) cycle
        call append_text(conditions%term_texts, entries(i_entry)%displacement(i_component)%text)
        term_of(i_component, i_entry) = size(conditions%term_texts)
      end do
    end do
    conditions%n_terms = size(conditions%term_texts)
    conditions%is_prescribed = entry_of_dof > 0
    conditions%prescribed_dofs = pack([(i_dof, i_dof=1, size(entry_of_dof))], conditions%is_prescribed)
    allocate (conditions%prescribed_values(size(conditions%prescribed_dofs), conditions%n_terms), source=0.0_rk)
    do i = 1, size(conditions%prescribed_dofs)
      i_dof = conditions%prescribed_dofs(i)
      i_entry = entry_of_dof(i_dof)
      i_component = modulo(i_dof - 1, n_dim) + 1
      associate (value => entries(i_entry)%displacement(i_component))
        conditions%prescribed_values(i, term_of(i_component, i_entry)) = merge(value%constant, 1.0_rk, value%is_constant)
      end associate
    end do
  end subroutine collect_terms
end module sig_boundary_conditions
