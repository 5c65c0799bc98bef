! SPDX-License-Identifier: BSD-3-Clause
!> The surfaces of all contacts that carry the multipliers, as cells of their own: contact.h5 and contact.xdmf beside those of the
!> fields.
module sig_contact_surfaces
  use sig_cell_collection, only: cell_collection_t
  use sig_contact_rows, only: contact_rows_t
  use sig_contact_state, only: contact_state_t
  use sig_errors, only: error_t
  use sig_field_file, only: field_file_t
  use sig_file_system, only: remove_file
  use sig_kinds, only: rk
  use sig_mesh_checks, only: group_of_surface
  use sig_nodal_values, only: nodal_gaps, nodal_pressures, nodal_status
  use sig_parameter_space, only: format_point
  use sig_problem, only: force_unit, parameter_names, problem_t, stress_unit, surface_of_side
  implicit none(type, external)
  private
  public :: contact_surfaces_t

  !> Rows of one entry of the deck's contact section.
  type :: entry_rows_t
    !> among all rows
    integer, allocatable :: indices(:)
    type(contact_rows_t) :: rows
  end type entry_rows_t

  !> create; then write_point and write_reduced for each point; close. Does nothing where the deck has no contact or wants no fields
  !> of it. Contacts that share a node have one each, so that none hides the other's values. Local: one rank writes.
  type :: contact_surfaces_t
    private
    logical :: is_used = .false.
    type(field_file_t) :: file
    !> facets of the mesh of the bodies; the label is the entry of the deck's contact section
    type(cell_collection_t) :: cells
    !> node of the bodies' mesh, shape (n_nodes)
    integer, allocatable :: nodes(:)
    !> nodes of entry i are starts(i) + 1 ... starts(i + 1)
    integer, allocatable :: starts(:)
    !> shape (n_entries)
    type(entry_rows_t), allocatable :: entry_rows(:)
  contains
    procedure :: create
    procedure :: write_point
    procedure :: write_reduced
    procedure :: close => close_file
    procedure, private :: add_surface
  end type contact_surfaces_t

contains

  !> Starts the files. Errors: they cannot be created.
  subroutine create(self, problem, folder, error)
    class(contact_surfaces_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    character(*), intent(in) :: folder
    type(error_t), allocatable, intent(out) :: error
    integer :: i, k

    self%is_used = problem%deck%output%has_contact .and. size(problem%deck%contact) > 0
    if (.not. self%is_used) then
      call remove_old_files(folder, error)
      return
    end if
    call self%cells%start(problem%mesh%n_dim, 1)
    allocate (self%nodes(0))
    self%starts = [0]
    allocate (self%entry_rows(size(problem%deck%contact)))
    do i = 1, size(problem%deck%contact)
      call self%add_surface(problem, i, error)
      if (allocated(error)) return
      self%entry_rows(i)%indices = pack([(k, k=1, problem%rows%n_rows)], problem%rows%contact_entry == i)
      self%entry_rows(i)%rows = problem%rows%select(self%entry_rows(i)%indices)
    end do
    self%cells%mesh%n_nodes = size(self%nodes)
    self%cells%mesh%coordinates = problem%mesh%coordinates(:, self%nodes)
    call self%file%create(folder // '/contact.h5', self%cells%mesh, problem%deck%units%length, parameter_names(problem%deck), error)
    if (allocated(error)) return
    call self%file%add_shared_array('mesh/nodes', self%nodes, '-', 'of the mesh of the bodies, 1-based')
    call self%file%add_shared_array('mesh/node_tags', problem%mesh%node_tags(self%nodes), '-', 'of the mesh file')
  end subroutine create

  !> Those of an earlier run would stand beside fields of another problem. Errors: they cannot be removed.
  subroutine remove_old_files(folder, error)
    character(*), intent(in) :: folder
    type(error_t), allocatable, intent(out) :: error

    call remove_file(folder // '/contact.xdmf', error)
    if (.not. allocated(error)) call remove_file(folder // '/contact.h5', error)
  end subroutine remove_old_files

  !> Facets and nodes of the surface of an entry with its multipliers.
  subroutine add_surface(self, problem, i_entry, error)
    class(contact_surfaces_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    integer, intent(in) :: i_entry
    type(error_t), allocatable, intent(out) :: error
    integer :: numbers(problem%mesh%n_nodes), i, i_group

    call group_of_surface(problem%mesh, surface_of_side(problem, i_entry, 1), problem%deck%path, i_group, error)
    if (allocated(error)) return
    associate (group => problem%mesh%groups(i_group))
      numbers = 0
      numbers(group%nodes) = [(size(self%nodes) + i, i=1, size(group%nodes))]
      self%nodes = [self%nodes, group%nodes]
      self%starts = [self%starts, size(self%nodes)]
      call self%cells%add_facets(problem%mesh, group%entities, numbers, [i_entry])
    end associate
  end subroutine add_surface

  !> A full-order answer.
  subroutine write_point(self, problem, point, state, opening)
    class(contact_surfaces_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: point(:)
    type(contact_state_t), intent(in) :: state
    !> [length] of each row, shape (n_rows)
    real(rk), intent(in) :: opening(:)
    real(rk) :: force(self%cells%mesh%n_dim, self%cells%mesh%n_nodes), pressure(self%cells%mesh%n_nodes)
    real(rk), dimension(self%cells%mesh%n_nodes) :: gap, status
    real(rk) :: displacement(problem%mesh%n_dim, problem%mesh%n_nodes)

    if (.not. self%is_used) return
    associate (deck => problem%deck)
      call self%file%start_point(format_point(deck%parameters, point), point)
      displacement = reshape(state%displacement, shape(displacement))
      if (deck%output%has_displacement) call self%file%add_node_field('displacement', displacement(:, self%nodes), &
        deck%units%length, 'displacement, full-order model')
      call gather(self, state%multipliers, problem%mesh%n_nodes, force, pressure)
      call gather_state(self, state%multipliers, opening, problem%mesh%n_nodes, gap, status)
      call self%file%add_node_field('contact_force', force, force_unit(deck), 'force of the other body on the node')
      call self%file%add_node_field('contact_pressure', pressure, stress_unit(deck), &
        'multiplier over area, on faces of six or eight nodes as a field in their changed basis')
      call self%file%add_node_field('gap', gap, deck%units%length, &
        'open distance; no number where there is none')
      call self%file%add_node_field('status', status, '-', '0 no row (faces nothing, or inert), 1 open, 2 closed')
    end associate
    call self%file%add_cell_field('contact', self%cells%labels(1, :), '-', 'entry of the deck''s contact section, 1-based')
  end subroutine write_point

  !> The answer of a reduced model at the same point.
  subroutine write_reduced(self, problem, multipliers)
    class(contact_surfaces_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> [force] shape (n_rows)
    real(rk), intent(in) :: multipliers(:)
    real(rk) :: force(self%cells%mesh%n_dim, self%cells%mesh%n_nodes), pressure(self%cells%mesh%n_nodes)

    if (.not. self%is_used) return
    call gather(self, multipliers, problem%mesh%n_nodes, force, pressure)
    call self%file%add_node_field('contact_force_reduced', force, force_unit(problem%deck), &
      'force of the other body on the node, reduced model')
    call self%file%add_node_field('contact_pressure_reduced', pressure, stress_unit(problem%deck), &
      'multiplier over area, as contact_pressure; reduced model')
  end subroutine write_reduced

  !> Forces and pressures at the nodes, from the rows of their entry alone.
  subroutine gather(self, multipliers, n_nodes, force, pressure)
    class(contact_surfaces_t), intent(in) :: self
    !> [force] of all rows
    real(rk), intent(in) :: multipliers(:)
    !> of the bodies' mesh
    integer, intent(in) :: n_nodes
    !> [force] shape (n_dim, self%cells%mesh%n_nodes)
    real(rk), intent(out) :: force(:, :)
    !> [force / area] shape (self%cells%mesh%n_nodes)
    real(rk), intent(out) :: pressure(:)
    real(rk) :: forces(self%cells%mesh%n_dim, n_nodes), all_pressures(n_nodes)
    integer :: i

    do i = 1, size(self%entry_rows)
      associate (first => self%starts(i) + 1, last => self%starts(i + 1), rows => self%entry_rows(i)%rows, &
        own => multipliers(self%entry_rows(i)%indices))
        ! the opposite of B' lambda, which the stiffness balances
        forces = -reshape(rows%apply_transpose(own, size(forces)), shape(forces))
        all_pressures = nodal_pressures(rows, own, n_nodes)
        force(:, first:last) = forces(:, self%nodes(first:last))
        pressure(first:last) = all_pressures(self%nodes(first:last))
      end associate
    end do
  end subroutine gather

  !> Gaps and what became of them.
  subroutine gather_state(self, multipliers, opening, n_nodes, gap, status)
    class(contact_surfaces_t), intent(in) :: self
    !> [force] of all rows
    real(rk), intent(in) :: multipliers(:)
    !> [length] shape (n_rows)
    real(rk), intent(in) :: opening(:)
    integer, intent(in) :: n_nodes
    !> [length] shape (self%cells%mesh%n_nodes)
    real(rk), intent(out) :: gap(:)
    !> one of status_* of sig_nodal_values, same shape
    real(rk), intent(out) :: status(:)
    real(rk) :: gaps(n_nodes)
    integer :: i, states(n_nodes)

    do i = 1, size(self%entry_rows)
      associate (first => self%starts(i) + 1, last => self%starts(i + 1), rows => self%entry_rows(i)%rows, &
        indices => self%entry_rows(i)%indices)
        gaps = nodal_gaps(rows, opening(indices), n_nodes)
        states = nodal_status(rows, multipliers(indices), n_nodes)
        gap(first:last) = gaps(self%nodes(first:last))
        status(first:last) = states(self%nodes(first:last))
      end associate
    end do
  end subroutine gather_state

  !> Gives the files their names. Errors: the first failure since create.
  subroutine close_file(self, error)
    class(contact_surfaces_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error

    if (self%is_used) call self%file%close(error)
  end subroutine close_file
end module sig_contact_surfaces
