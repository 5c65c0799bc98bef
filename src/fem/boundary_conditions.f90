! SPDX-License-Identifier: BSD-3-Clause
!> Prescribed displacements and loads as sums of terms: value = sum over t of theta_t(mu) * pattern_t, with theta_1 = 1.
module sig_boundary_conditions
  use sig_deck_config, only: boundary_config_t, value_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_load_pattern, only: load_pattern_t
  use sig_mesh, only: mesh_t
  use sig_mesh_checks, only: nodes_of_boundary
  use sig_term_set, only: term_set_t
  use sig_text, only: to_text
  use sig_value_terms, only: split_sum, value_terms_t
  implicit none(type, external)
  private
  public :: boundary_conditions_t, create_boundary_conditions

  !> Prescribed displacements and nodal forces of a problem.
  type :: boundary_conditions_t
    !> number of all terms of the problem: first those of the prescribed displacements, then of loads, imposed strains, and the rest
    integer :: n_terms = 1
    !> number of the first terms that belong to displacements, loads and imposed strains; no force has a later term
    integer :: n_driving_terms = 1
    !> natural, ascending
    integer, allocatable :: prescribed_dofs(:)
    !> [length] displacement of each prescribed dof for each of the first terms, shape (n_prescribed, n_prescribed_terms)
    real(rk), allocatable :: prescribed_values(:, :)
    !> whether a dof is prescribed, shape (n_dofs)
    logical, allocatable :: is_prescribed(:)
    !> external forces, and those that imposed strains cause
    type(load_pattern_t) :: loads
    type(load_pattern_t) :: strain_forces
    !> forces whose responses are lifted beside the prescribed displacements; their terms are numbered 1, 2, ...
    type(load_pattern_t) :: lifted_forces
  contains
    procedure :: hold_dofs
    procedure :: n_lifted_terms
    procedure :: prescribed_displacement
    procedure :: get_forces
    procedure :: forces
  end type boundary_conditions_t

contains

  !> Creates the prescribed displacements of the deck's entries, and their terms. No forces are set. If several entries prescribe a
  !> dof, the first of them gives its terms.
  !>
  !> Errors: an unknown boundary, or another one that nodes_of_boundary refuses; a dof that two entries prescribe with different
  !> numbers or expressions (see differ); a function of the place that is not finite at a node. A value with one term per node (see
  !> split_sum) is not evaluated here.
  subroutine create_boundary_conditions(mesh, entries, deck_path, terms, conditions, error)
    type(mesh_t), intent(in) :: mesh
    !> section boundary_conditions of the deck
    type(boundary_config_t), intent(in) :: entries(:)
    !> for messages
    character(*), intent(in) :: deck_path
    !> grows by the terms of these conditions
    type(term_set_t), intent(inout) :: terms
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
        call claim_dofs(entries, i_entry, i_component, mesh, nodes, deck_path, terms, entry_of_dof, error)
        if (allocated(error)) return
      end do
    end do
    call collect_terms(mesh, entries, entry_of_dof, deck_path, terms, conditions, error)
  end subroutine create_boundary_conditions

  !> Prescribes the displacement 0 on more dofs. Requires: they are not prescribed yet.
  pure subroutine hold_dofs(self, dofs)
    class(boundary_conditions_t), intent(inout) :: self
    !> natural
    integer, intent(in) :: dofs(:)
    real(rk), allocatable :: values(:, :)
    logical :: was_prescribed(size(self%is_prescribed))
    integer :: i

    was_prescribed = self%is_prescribed
    self%is_prescribed(dofs) = .true.
    allocate (values(count(self%is_prescribed), size(self%prescribed_values, 2)), source=0.0_rk)
    values(pack([(i, i=1, size(values, 1))], pack(was_prescribed, self%is_prescribed)), :) = self%prescribed_values
    self%prescribed_dofs = pack([(i, i=1, size(self%is_prescribed))], self%is_prescribed)
    call move_alloc(values, self%prescribed_values)
  end subroutine hold_dofs

  !> Returns the number of columns of a lifting: one for each term of the prescribed displacements (always at least term 1), then
  !> one for each term of lifted_forces.
  pure integer function n_lifted_terms(self)
    class(boundary_conditions_t), intent(in) :: self

    n_lifted_terms = size(self%prescribed_values, 2) + self%lifted_forces%n_terms()
  end function n_lifted_terms

  !> Returns the prescribed displacement u_D(mu) on the prescribed dofs, and 0 on all others.
  pure function prescribed_displacement(self, theta) result(displacement)
    class(boundary_conditions_t), intent(in) :: self
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [length] shape (n_dofs)
    real(rk) :: displacement(size(self%is_prescribed))

    displacement = 0
    displacement(self%prescribed_dofs) = matmul(self%prescribed_values, theta(:size(self%prescribed_values, 2)))
  end function prescribed_displacement

  !> Returns the pattern of the nodal forces of the loads and of the imposed strains together.
  pure subroutine get_forces(self, pattern)
    class(boundary_conditions_t), intent(in) :: self
    type(load_pattern_t), intent(out) :: pattern

    pattern = self%loads
    call pattern%add_pattern(self%strain_forces)
  end subroutine get_forces

  !> Returns the nodal forces F(mu): those of the loads plus those of the imposed strains. Before they are added, forces that are
  !> only rounding are set to zero in each of the two patterns (see forces of load_pattern_t).
  pure function forces(self, theta)
    class(boundary_conditions_t), intent(in) :: self
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [force] shape (n_dofs)
    real(rk) :: forces(size(self%is_prescribed))

    forces = self%loads%forces(theta, size(forces)) + self%strain_forces%forces(theta, size(forces))
  end function forces

  !> Notes that an entry prescribes one component of nodes; a dof stays with its first entry. Errors: a dof whose first entry gives
  !> another number or expression (see differ), even if both give the same displacement at the node.
  subroutine claim_dofs(entries, i_entry, i_component, mesh, nodes, deck_path, terms, entry_of_dof, error)
    type(boundary_config_t), intent(in) :: entries(:)
    integer, intent(in) :: i_entry
    integer, intent(in) :: i_component
    type(mesh_t), intent(in) :: mesh
    !> natural, 1-based
    integer, intent(in) :: nodes(:)
    character(*), intent(in) :: deck_path
    type(term_set_t), intent(in) :: terms
    !> entry that prescribes each natural dof, 0 = none, shape (n_dofs)
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
          entries(other)%boundary%text // ''' and ''' // entries(i_entry)%boundary%text // ''', whose ' // &
          entries(i_entry)%axes(i_component) // ' displacements are different numbers or expressions; write the same in both, ' // &
          'or leave the node out of one of the two groups', deck_path, entries(i_entry)%boundary%line, &
          entries(i_entry)%boundary%column)
        return
      end if
    end do
  end subroutine claim_dofs

  !> Whether two values differ. Constants are compared by value, so that 0 and 0.0 are equal; all others are compared as texts.
  pure logical function differ(one, other)
    type(value_config_t), intent(in) :: one
    type(value_config_t), intent(in) :: other

    if (one%is_constant .and. other%is_constant) then
      differ = abs(one%constant - other%constant) > 0
    else
      differ = one%text /= other%text
    end if
  end function differ

  !> Lists the prescribed dofs. Then it finds, for each entry and component, the terms and their factors at those dofs that belong
  !> to this entry in entry_of_dof. Errors: those of split_sum.
  subroutine collect_terms(mesh, entries, entry_of_dof, deck_path, terms, conditions, error)
    type(mesh_t), intent(in) :: mesh
    type(boundary_config_t), intent(in) :: entries(:)
    !> as in claim_dofs
    integer, intent(in) :: entry_of_dof(:)
    character(*), intent(in) :: deck_path
    type(term_set_t), intent(inout) :: terms
    type(boundary_conditions_t), intent(inout) :: conditions
    type(error_t), allocatable, intent(out) :: error
    type(value_terms_t), allocatable :: parts(:)
    integer, allocatable :: dofs(:)
    integer :: i, i_component, i_entry

    conditions%is_prescribed = entry_of_dof > 0
    conditions%prescribed_dofs = pack([(i, i=1, size(entry_of_dof))], conditions%is_prescribed)
    allocate (conditions%prescribed_values(size(conditions%prescribed_dofs), 0))
    do i_entry = 1, size(entries)
      do i_component = 1, mesh%n_dim
        if (.not. entries(i_entry)%is_prescribed(i_component)) cycle
        dofs = pack([(i, i=1, size(entry_of_dof))], entry_of_dof == i_entry .and. &
          [(modulo(i - 1, mesh%n_dim) + 1 == i_component, i=1, size(entry_of_dof))])
        call split_sum(mesh, (dofs - 1) / mesh%n_dim + 1, entries(i_entry)%displacement(i_component), deck_path, terms, parts, &
          error)
        if (allocated(error)) return
        call add_values(dofs, parts, terms%n_terms(), conditions)
      end do
    end do
    conditions%n_terms = terms%n_terms()
    call widen(conditions%prescribed_values, conditions%n_terms)
  end subroutine collect_terms

  !> Adds the values of one component of an entry to prescribed_values, which gets columns for all terms until now.
  pure subroutine add_values(dofs, parts, n_terms, conditions)
    !> ascending
    integer, intent(in) :: dofs(:)
    !> at the nodes of these dofs
    type(value_terms_t), intent(in) :: parts(:)
    !> number of terms until now
    integer, intent(in) :: n_terms
    type(boundary_conditions_t), intent(inout) :: conditions
    integer :: i, i_part, row

    call widen(conditions%prescribed_values, n_terms)
    row = 0
    do i = 1, size(dofs)
      row = row + 1
      do while (conditions%prescribed_dofs(row) /= dofs(i))
        row = row + 1
      end do
      do i_part = 1, size(parts)
        associate (value => conditions%prescribed_values(row, parts(i_part)%terms(i)))
          value = value + parts(i_part)%factors(i)
        end associate
      end do
    end do
  end subroutine add_values

  !> Appends columns of zeros up to n_columns.
  pure subroutine widen(values, n_columns)
    real(rk), allocatable, intent(inout) :: values(:, :)
    integer, intent(in) :: n_columns
    real(rk), allocatable :: wider(:, :)

    if (size(values, 2) >= n_columns) return
    allocate (wider(size(values, 1), n_columns), source=0.0_rk)
    wider(:, :size(values, 2)) = values
    call move_alloc(wider, values)
  end subroutine widen
end module sig_boundary_conditions
