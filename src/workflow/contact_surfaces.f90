! SPDX-License-Identifier: BSD-3-Clause
!> Writes contact.h5 and contact.xdmf: contact forces and gaps on the surfaces that carry the multipliers. The facets of these
!> surfaces are the cells of the files.
module sig_contact_surfaces
  use sig_contact_rows, only: contact_rows_t
  use sig_element_types, only: element_type_with
  use sig_errors, only: error_t
  use sig_field_file, only: field_file_t
  use sig_field_map, only: field_values_t
  use sig_file_system, only: remove_file
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_model, only: model_t
  use sig_nodal_values, only: cell_contact, nodal_contact, nodal_friction, nodal_gaps, nodal_pressures, nodal_vectors
  implicit none(type, external)
  private
  public :: contact_surfaces_t

  !> what the numbers of friction_status say
  character(*), parameter, public :: friction_states = '0 no row, 1 open, 2 sticks, 3 slips (also closed without friction), 4 tied'

  !> The rows of one entry of the deck's contact section.
  type :: entry_rows_t
    !> their numbers among all rows
    integer, allocatable :: indices(:)
    type(contact_rows_t) :: rows
  end type entry_rows_t

  !> Call create; then for each point start_point, write_values and, if there is a reduced model, write_reduced; then close. If the
  !> deck has no contact or wants no fields of it, create only removes old files, and the others do nothing. A node that two
  !> contacts share is written once for each contact. Local: one rank writes.
  type :: contact_surfaces_t
    private
    logical :: is_used = .false.
    type(field_file_t) :: file
    !> mesh of the facets, with a node numbering of its own
    type(mesh_t) :: mesh
    !> number in the mesh of the bodies of each node, shape (n_nodes)
    integer, allocatable :: nodes(:)
    !> contact entry i has the nodes starts(i) + 1 ... starts(i + 1)
    integer, allocatable :: starts(:)
    !> shape (n_entries)
    type(entry_rows_t), allocatable :: entry_rows(:)
    !> contact entry of each facet
    integer, allocatable :: entries(:)
    integer :: n_body_nodes = 0
    character(:), allocatable :: length_unit
    character(:), allocatable :: force_unit
    character(:), allocatable :: stress_unit
  contains
    procedure :: create
    procedure :: start_point
    procedure :: write_values
    procedure :: write_reduced
    procedure :: write_friction
    procedure :: close => close_file
  end type contact_surfaces_t

contains

  !> Starts the files; if they are not wanted or the deck has no contact, removes those of an earlier run instead, and the other
  !> procedures do nothing. Errors: they cannot be created or removed.
  subroutine create(self, model, has_contact, folder, error)
    class(contact_surfaces_t), intent(inout) :: self
    !> its header and its field map are used
    type(model_t), intent(in) :: model
    !> fields of contact are wanted
    logical, intent(in) :: has_contact
    !> results folder, or that of predict --fields
    character(*), intent(in) :: folder
    type(error_t), allocatable, intent(out) :: error
    integer :: i, k

    self%is_used = has_contact .and. model%resultants%n_entries() > 0
    if (.not. self%is_used) then
      call remove_old_files(folder, error)
      return
    end if
    call build_mesh(self, model)
    self%length_unit = model%length_unit
    self%force_unit = model%force_unit
    self%stress_unit = model%fields%stress_unit
    self%n_body_nodes = model%n_nodes
    allocate (self%entry_rows(model%resultants%n_entries()))
    do i = 1, size(self%entry_rows)
      associate (rows => model%fields%rows)
        self%entry_rows(i)%indices = pack([(k, k=1, rows%n_rows)], rows%contact_entry == i)
        self%entry_rows(i)%rows = rows%select(self%entry_rows(i)%indices)
      end associate
    end do
    call self%file%create(folder // '/contact.h5', self%mesh, model%length_unit, model%parameter_names, model%parameter_units, &
      error, model%i_time())
    if (allocated(error)) return
    call self%file%add_shared_array('mesh/nodes', self%nodes, '-', 'of the mesh of the bodies, 1-based')
    call self%file%add_shared_array('mesh/node_tags', model%node_tags(self%nodes), '-', 'of the mesh file')
    call self%file%add_shared_array('contact/names', model%resultants%names, '-', 'surfaces of 1, 2, ... in the field contact')
  end subroutine create

  !> Removes contact.h5 and contact.xdmf of an earlier run, if there are any: they would stand beside fields of another problem.
  !> Errors: they cannot be removed.
  subroutine remove_old_files(folder, error)
    !> results folder, or that of predict --fields
    character(*), intent(in) :: folder
    type(error_t), allocatable, intent(out) :: error

    call remove_file(folder // '/contact.xdmf', error)
    if (allocated(error)) return
    call remove_file(folder // '/contact.h5', error)
  end subroutine remove_old_files

  !> Builds self%mesh from the facets of the model's field map. Each contact entry has its own copies of its nodes, in ascending
  !> order of the nodes of the bodies; the nodes of entry 1 come first.
  pure subroutine build_mesh(self, model)
    class(contact_surfaces_t), intent(inout) :: self
    type(model_t), intent(in) :: model
    integer :: i, i_entry, k, numbers(model%n_nodes)
    logical :: is_own(model%n_nodes)

    associate (map => model%fields, mesh => self%mesh)
      mesh%n_dim = model%n_dim
      mesh%n_cells = size(map%facet_entries)
      mesh%cell_offsets = map%facet_starts
      mesh%cell_types = [(element_type_with(model%n_dim - 1, map%facet_starts(i + 1) - map%facet_starts(i)), i=1, mesh%n_cells)]
      self%entries = map%facet_entries
      allocate (self%nodes(0), mesh%cell_nodes(size(map%facet_nodes)))
      self%starts = [0]
      do i_entry = 1, model%resultants%n_entries()
        is_own = .false.
        do i = 1, mesh%n_cells
          if (map%facet_entries(i) == i_entry) is_own(map%facet_nodes(map%facet_starts(i) + 1:map%facet_starts(i + 1))) = .true.
        end do
        numbers = 0
        numbers(pack([(k, k=1, size(is_own))], is_own)) = [(size(self%nodes) + k, k=1, count(is_own))]
        self%nodes = [self%nodes, pack([(k, k=1, size(is_own))], is_own)]
        self%starts = [self%starts, size(self%nodes)]
        do i = 1, mesh%n_cells
          if (map%facet_entries(i) /= i_entry) cycle
          associate (first => map%facet_starts(i) + 1, last => map%facet_starts(i + 1))
            mesh%cell_nodes(first:last) = numbers(map%facet_nodes(first:last))
          end associate
        end do
      end do
      mesh%n_nodes = size(self%nodes)
      mesh%coordinates = model%coordinates(:, self%nodes)
    end associate
  end subroutine build_mesh

  !> Starts the fields of the next point. Does nothing if create started no files.
  subroutine start_point(self, label, point)
    class(contact_surfaces_t), intent(inout) :: self
    !> text that viewers show
    character(*), intent(in) :: label
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)

    if (self%is_used) call self%file%start_point(label, point)
  end subroutine start_point

  !> Writes contact forces and pressures, gaps and contact status of a full-order solution or of a reduced answer at the present
  !> point, with friction also its tractions, slip and status, and the contact entry of each facet. Does nothing if create started
  !> no files.
  subroutine write_values(self, values, has_displacement)
    class(contact_surfaces_t), intent(inout) :: self
    type(field_values_t), intent(in) :: values
    !> the displacement is written, too
    logical, intent(in) :: has_displacement
    real(rk) :: force(self%mesh%n_dim, self%mesh%n_nodes)
    real(rk), dimension(self%mesh%n_nodes) :: gap, pressure, status
    integer :: contact(self%mesh%n_cells)

    if (.not. self%is_used) return
    if (allocated(values%slips)) call self%write_friction(values, '')
    if (has_displacement) call self%file%add_node_field('displacement', values%displacement(:, self%nodes), self%length_unit, &
      'displacement')
    call gather(self, values%multipliers, force, pressure)
    call gather_state(self, values, gap, status, contact)
    call self%file%add_node_field('contact_force', force, self%force_unit, 'force of the other body on the node')
    call self%file%add_node_field('contact_pressure', pressure, self%stress_unit, &
      'multiplier over area, on faces of six or eight nodes as a field in their changed basis')
    call self%file%add_node_field('gap', gap, self%length_unit, 'open distance; no number where there is none')
    call self%file%add_node_field('status', status, '-', '0 no row (faces nothing, or inert), 1 open, 2 closed, 4 tied')
    call self%file%add_cell_field('contact_status', contact, '-', &
      '0 no row at its nodes, 1 open, 2 closed at all of them, 3 closed at some, 4 tied')
    call self%file%add_cell_field('contact', self%entries, '-', 'entry of the deck''s contact section, 1-based')
  end subroutine write_values

  !> Writes friction, slip and status of the nodes, each from the rows of its own contact entry. Does nothing if create started no
  !> files.
  subroutine write_friction(self, values, suffix)
    class(contact_surfaces_t), intent(inout) :: self
    type(field_values_t), intent(in) :: values
    !> behind the names of the fields
    character(*), intent(in) :: suffix
    real(rk), dimension(self%mesh%n_dim, self%mesh%n_nodes) :: slip, traction
    real(rk) :: status(self%mesh%n_nodes), vectors(self%mesh%n_dim, self%n_body_nodes)
    integer :: i, states(self%n_body_nodes)

    if (.not. self%is_used) return
    do i = 1, size(self%entry_rows)
      associate (first => self%starts(i) + 1, last => self%starts(i + 1), rows => self%entry_rows(i)%rows, &
        indices => self%entry_rows(i)%indices)
        vectors = nodal_vectors(rows, values%row_tractions(:, indices), self%n_body_nodes)
        traction(:, first:last) = vectors(:, self%nodes(first:last))
        vectors = nodal_vectors(rows, values%row_slips(:, indices), self%n_body_nodes)
        slip(:, first:last) = vectors(:, self%nodes(first:last))
        states = nodal_friction(rows, values%is_closed(indices), values%is_tied(indices), values%slips(indices), &
          self%n_body_nodes)
        status(first:last) = states(self%nodes(first:last))
      end associate
    end do
    call self%file%add_node_field('tangential_traction' // suffix, traction, self%stress_unit, &
      'friction over area, on this surface')
    call self%file%add_node_field('slip' // suffix, slip, self%length_unit, &
      'of this surface over the other one since the last time')
    call self%file%add_node_field('friction_status' // suffix, status, '-', friction_states)
  end subroutine write_friction

  !> Writes the contact forces and pressures of a reduced model beside the full-order ones at the same point. Does nothing if create
  !> started no files.
  subroutine write_reduced(self, multipliers)
    class(contact_surfaces_t), intent(inout) :: self
    !> [force] shape (n_rows)
    real(rk), intent(in) :: multipliers(:)
    real(rk) :: force(self%mesh%n_dim, self%mesh%n_nodes), pressure(self%mesh%n_nodes)

    if (.not. self%is_used) return
    call gather(self, multipliers, force, pressure)
    call self%file%add_node_field('contact_force_reduced', force, self%force_unit, &
      'force of the other body on the node, reduced model')
    call self%file%add_node_field('contact_pressure_reduced', pressure, self%stress_unit, &
      'multiplier over area, as contact_pressure; reduced model')
  end subroutine write_reduced

  !> Computes the contact forces and pressures (nodal_pressures) at the nodes of self%mesh. At each node only the rows of its own
  !> contact entry count; both are 0 without such rows.
  subroutine gather(self, multipliers, force, pressure)
    class(contact_surfaces_t), intent(in) :: self
    !> [force] of all rows
    real(rk), intent(in) :: multipliers(:)
    !> [force] of the other body or obstacle on the node, shape (n_dim, self%mesh%n_nodes)
    real(rk), intent(out) :: force(:, :)
    !> [force / area] shape (self%mesh%n_nodes)
    real(rk), intent(out) :: pressure(:)
    real(rk) :: forces(self%mesh%n_dim, self%n_body_nodes), all_pressures(self%n_body_nodes)
    integer :: i

    do i = 1, size(self%entry_rows)
      associate (first => self%starts(i) + 1, last => self%starts(i + 1), rows => self%entry_rows(i)%rows, &
        own => multipliers(self%entry_rows(i)%indices))
        ! the opposite of B' lambda, which the stiffness balances
        forces = -reshape(rows%apply_transpose(own, size(forces)), shape(forces))
        all_pressures = nodal_pressures(rows, own, self%n_body_nodes)
        force(:, first:last) = forces(:, self%nodes(first:last))
        pressure(first:last) = all_pressures(self%nodes(first:last))
      end associate
    end do
  end subroutine gather

  !> Computes gaps and contact status at the nodes of self%mesh, each from the rows of its own contact entry, and the contact status
  !> of the facets.
  subroutine gather_state(self, values, gap, status, contact)
    class(contact_surfaces_t), intent(in) :: self
    type(field_values_t), intent(in) :: values
    !> [length] NaN at nodes without rows, shape (self%mesh%n_nodes)
    real(rk), intent(out) :: gap(:)
    !> nodal_contact, same shape as gap
    real(rk), intent(out) :: status(:)
    !> cell_contact of each facet, shape (self%mesh%n_cells)
    integer, intent(out) :: contact(:)
    real(rk) :: gaps(self%n_body_nodes)
    integer :: i, states(self%n_body_nodes), touching(self%mesh%n_nodes)

    do i = 1, size(self%entry_rows)
      associate (first => self%starts(i) + 1, last => self%starts(i + 1), rows => self%entry_rows(i)%rows, &
        indices => self%entry_rows(i)%indices)
        gaps = nodal_gaps(rows, values%opening(indices), self%n_body_nodes)
        gap(first:last) = gaps(self%nodes(first:last))
        states = nodal_contact(rows, values%is_closed(indices), values%is_tied(indices), self%n_body_nodes)
        touching(first:last) = states(self%nodes(first:last))
      end associate
    end do
    status = touching
    contact = cell_contact(touching, self%mesh%cell_offsets, self%mesh%cell_nodes)
  end subroutine gather_state

  !> Closes the files and gives them their final names. Does nothing if create started no files. Errors: the first failure since
  !> create.
  subroutine close_file(self, error)
    class(contact_surfaces_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error

    if (self%is_used) call self%file%close(error)
  end subroutine close_file
end module sig_contact_surfaces
