! SPDX-License-Identifier: BSD-3-Clause
!> Computes the forces that the supports exert: one resultant per named boundary with prescribed displacements.
module sig_reactions
  use sig_deck_config, only: boundary_config_t
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_mesh_checks, only: nodes_of_boundary
  implicit none(type, external)
  private
  public :: reaction_t, boundary_reactions

  !> The resultant of one boundary.
  type :: reaction_t
    !> name of the boundary
    character(:), allocatable :: boundary
    !> names of the components
    character(1) :: axes(3) = ' '
    !> components that the boundary prescribes
    logical :: is_prescribed(3) = .false.
    !> [force] resultant on the body; over the full turn in axisymmetry, where the component along r is a sum of radial forces, not
    !> a resultant in space
    real(rk) :: force(3) = 0
  end type reaction_t

contains

  !> Computes the resultant of each boundary: the sum of the reactions at its nodes, along the components that its entries
  !> prescribe. Each boundary comes once, in the order of the entries.
  !>
  !> A dof that two boundaries share counts for the first one, so that the sum of all resultants is the whole reaction. Requires:
  !> create_boundary_conditions accepted the entries; an unknown boundary gets no forces.
  pure subroutine boundary_reactions(mesh, entries, nodal_reactions, reactions)
    type(mesh_t), intent(in) :: mesh
    !> section boundary_conditions of the deck
    type(boundary_config_t), intent(in) :: entries(:)
    !> [force] of the supports on the body, natural, shape (n_dofs)
    real(rk), intent(in) :: nodal_reactions(:)
    !> one per name of a boundary
    type(reaction_t), allocatable, intent(out) :: reactions(:)
    type(error_t), allocatable :: error
    integer, allocatable :: nodes(:), dofs(:)
    logical :: is_free(size(nodal_reactions))
    integer :: i_component, i_entry, i_row

    call list_boundaries(entries, reactions)
    is_free = .true.
    do i_entry = 1, size(entries)
      call nodes_of_boundary(mesh, entries(i_entry)%boundary, '', nodes, error)
      if (allocated(error)) cycle
      i_row = row_of(reactions, entries(i_entry)%boundary%text)
      do i_component = 1, mesh%n_dim
        if (.not. entries(i_entry)%is_prescribed(i_component)) cycle
        dofs = mesh%n_dim * (nodes - 1) + i_component
        reactions(i_row)%is_prescribed(i_component) = .true.
        reactions(i_row)%force(i_component) = reactions(i_row)%force(i_component) + &
          sum(nodal_reactions(dofs), mask=is_free(dofs))
        is_free(dofs) = .false.
      end do
    end do
  end subroutine boundary_reactions

  !> Lists the boundaries of the entries, one per name in the order of the entries; a boundary may have several entries. No forces
  !> are set.
  pure subroutine list_boundaries(entries, reactions)
    type(boundary_config_t), intent(in) :: entries(:)
    type(reaction_t), allocatable, intent(out) :: reactions(:)
    logical :: is_first(size(entries))
    integer :: i_entry, i_row, j

    is_first = .true.
    do i_entry = 1, size(entries)
      do j = 1, i_entry - 1
        if (entries(j)%boundary%text == entries(i_entry)%boundary%text) is_first(i_entry) = .false.
      end do
    end do
    allocate (reactions(count(is_first)))
    i_row = 0
    do i_entry = 1, size(entries)
      if (.not. is_first(i_entry)) cycle
      i_row = i_row + 1
      reactions(i_row)%boundary = entries(i_entry)%boundary%text
      reactions(i_row)%axes = entries(i_entry)%axes
    end do
  end subroutine list_boundaries

  !> Returns the index of the boundary with this name, 1-based; 0 if there is none.
  pure integer function row_of(reactions, boundary) result(i_row)
    !> result of list_boundaries
    type(reaction_t), intent(in) :: reactions(:)
    character(*), intent(in) :: boundary

    do i_row = 1, size(reactions)
      if (reactions(i_row)%boundary == boundary) return
    end do
    i_row = 0
  end function row_of
end module sig_reactions
