! SPDX-License-Identifier: BSD-3-Clause
!> The parts of the mesh that a model keeps for fields: cells, regions, contact surfaces, strains as functions of the displacement,
!> contact rows, elastic constants, and imposed strains as functions of the parameters.
module sig_field_map
  use sig_contact_laws, only: contact_laws_t
  use sig_contact_rows, only: contact_rows_t
  use sig_elasticity, only: n_stresses, stress_matrix, von_mises
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model_t
  use sig_nodal_values, only: cell_contact, nodal_contact, nodal_friction, nodal_gaps, nodal_pressures, nodal_vectors
  use sig_strain_map, only: strain_map_t
  use sig_term_set, only: term_set_t
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: field_map_t, field_values_t, tensors_of

  !> The data for fields. Nothing is allocated in a model without fields.
  type :: field_map_t
    type(mechanical_model_t) :: mechanics
    character(:), allocatable :: stress_unit
    character(:), allocatable :: area_unit
    !> mean strains of the cells, with a row per cell whose entries are the nodes of the cell in the element's order; and smoothed
    !> strains at the nodes, with a row per node
    type(strain_map_t) :: of_cells
    type(strain_map_t) :: of_nodes
    type(string_t), allocatable :: region_names(:)
    !> region of each cell, 1-based; 0 = none
    integer, allocatable :: regions(:)
    !> facets of the first surfaces of all contacts: the nodes of facet i are facet_nodes(facet_starts(i) + 1:facet_starts(i + 1))
    integer, allocatable :: facet_starts(:)
    integer, allocatable :: facet_nodes(:)
    !> entry of the deck's contact section for each facet, 1-based
    integer, allocatable :: facet_entries(:)
    !> rows of all contact forces: normal rows, then tangential ones; and the normal rows alone
    type(contact_rows_t) :: force_rows
    type(contact_rows_t) :: rows
    !> terms of imposed strains and elastic constants
    type(term_set_t) :: terms
    !> numbers (1-based among `terms`) of Young's modulus and Poisson's ratio of the first material, of the second one, ...
    integer, allocatable :: constant_terms(:)
  contains
    procedure :: is_there
    procedure :: set_rows
    procedure :: n_cells
    procedure :: has_imposed_strains
    procedure :: laws
  end type field_map_t

  !> Values of all fields at one point.
  type :: field_values_t
    !> [length] shape (n_dim, n_nodes)
    real(rk), allocatable :: displacement(:, :)
    !> [force/length**2] stresses as means over the cells, shape (n_stresses, n_cells)
    real(rk), allocatable :: stress(:, :)
    !> [force/length**2] von Mises stress of these means, shape (n_cells)
    real(rk), allocatable :: von_mises(:)
    !> [-] imposed strains as means over the cells, shape (n_stresses, n_cells); the shears are components of the tensor
    real(rk), allocatable :: imposed_strain(:, :)
    !> [force/length**2] smoothed stresses at the nodes, shape (n_stresses, n_nodes), and their von Mises stress, shape (n_nodes)
    real(rk), allocatable :: stress_smoothed(:, :)
    real(rk), allocatable :: von_mises_smoothed(:)
    !> [force] force of the other body or of the obstacle on each node, 0 off the contacts, shape (n_dim, n_nodes)
    real(rk), allocatable :: contact_force(:, :)
    !> [force/length**2] contact pressure, 0 off the contacts, shape (n_nodes)
    real(rk), allocatable :: contact_pressure(:)
    !> [length] gap, NaN off the contacts, shape (n_nodes)
    real(rk), allocatable :: gap(:)
    !> results of nodal_contact and cell_contact, shapes (n_nodes) and (n_cells)
    integer, allocatable :: node_contact(:)
    integer, allocatable :: cell_contact(:)
    !> [force] normal force and [length] opening of each contact; whether it is closed, and whether it is tied; shape (n_contacts)
    real(rk), allocatable :: multipliers(:)
    real(rk), allocatable :: opening(:)
    logical, allocatable :: is_closed(:)
    logical, allocatable :: is_tied(:)
    !> the following are not allocated without friction. [force/length**2] friction on the first side of each contact, [length] slip
    !> of the first side since the last time, shapes (n_dim, n_contacts); whether each contact slips, shape (n_contacts)
    real(rk), allocatable :: row_tractions(:, :)
    real(rk), allocatable :: row_slips(:, :)
    logical, allocatable :: slips(:)
    !> the same at nodes (nodal_vectors), shape (n_dim, n_nodes), and their status (nodal_friction), shape (n_nodes)
    real(rk), allocatable :: tangential_traction(:, :)
    real(rk), allocatable :: slip(:, :)
    integer, allocatable :: node_friction(:)
    !> the following are not allocated where no material flows. [-] plastic strains and creep strains as means over the cells and
    !> smoothed at the nodes: shears as angles, and behind them the equivalent strain; shapes (7, n_cells) and (7, n_nodes)
    real(rk), allocatable :: plastic(:, :), plastic_smoothed(:, :)
    real(rk), allocatable :: creep(:, :), creep_smoothed(:, :)
  contains
    procedure :: take_displacement
    procedure :: take_flow
    procedure :: take_contact
    procedure :: take_friction
    procedure :: take_stresses
  end type field_values_t

contains

  !> Whether the model keeps data for fields.
  pure logical function is_there(self)
    class(field_map_t), intent(in) :: self

    is_there = allocated(self%regions)
  end function is_there

  !> Sets the rows of contact forces.
  pure subroutine set_rows(self, force_rows, n_contacts)
    class(field_map_t), intent(inout) :: self
    !> normal rows of all contacts, then tangential rows
    type(contact_rows_t), intent(in) :: force_rows
    integer, intent(in) :: n_contacts
    integer :: k

    self%force_rows = force_rows
    self%rows = force_rows%select([(k, k=1, n_contacts)])
  end subroutine set_rows

  !> Returns the number of cells of the mesh. Requires: is_there.
  pure integer function n_cells(self)
    class(field_map_t), intent(in) :: self

    n_cells = self%of_cells%n_rows()
  end function n_cells

  !> Whether some cell has an imposed strain. Requires: is_there.
  pure logical function has_imposed_strains(self)
    class(field_map_t), intent(in) :: self

    has_imposed_strains = size(self%of_cells%imposed_rows) > 0
  end function has_imposed_strains

  !> Returns Hooke's matrix [force/length**2] of each material at a point, which gives stresses from strains, shape (n_stresses,
  !> n_stresses, n_materials).
  pure function laws(self, theta)
    class(field_map_t), intent(in) :: self
    !> values of self%terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    real(rk) :: laws(n_stresses, n_stresses, size(self%constant_terms) / 2)
    integer :: i

    do i = 1, size(laws, 3)
      laws(:, :, i) = stress_matrix(self%mechanics%name, theta(self%constant_terms(2 * i - 1)), &
        theta(self%constant_terms(2 * i)))
    end do
  end function laws

  !> Copies the displacement of all nodes to self%displacement, for take_contact and take_stresses.
  pure subroutine take_displacement(self, map, displacement)
    class(field_values_t), intent(inout) :: self
    type(field_map_t), intent(in) :: map
    !> [length] shape (n_dofs)
    real(rk), intent(in) :: displacement(:)

    self%displacement = reshape(displacement, [map%mechanics%n_dim, size(displacement) / map%mechanics%n_dim])
  end subroutine take_displacement

  !> Computes the contact fields from self%displacement and the multipliers: the opening of each row; the contact force, contact
  !> pressure, gap and status (nodal_contact) of each node; and the status of each cell (cell_contact). It also copies the
  !> normal forces. Requires: take_displacement.
  pure subroutine take_contact(self, map, laws, theta, multipliers)
    class(field_values_t), intent(inout) :: self
    type(field_map_t), intent(in) :: map
    type(contact_laws_t), intent(in) :: laws
    !> values of the model's terms, which the gaps are linear in
    real(rk), intent(in) :: theta(:)
    !> [force] shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)
    integer :: n_nodes

    n_nodes = size(self%displacement, 2)
    self%multipliers = multipliers(:map%rows%n_rows)
    self%is_closed = laws%are_closed(multipliers)
    self%is_tied = laws%is_tied
    self%opening = matmul(map%rows%gap, theta) - map%rows%apply([self%displacement])
    ! The contact force on each node is the opposite of B' lambda: K u + B' lambda = F.
    self%contact_force = -reshape(map%force_rows%apply_transpose(multipliers, size(self%displacement)), shape(self%displacement))
    self%contact_pressure = nodal_pressures(map%rows, self%multipliers, n_nodes)
    self%gap = nodal_gaps(map%rows, self%opening, n_nodes)
    self%node_contact = nodal_contact(map%rows, self%is_closed, self%is_tied, n_nodes)
    self%cell_contact = cell_contact(self%node_contact, map%of_cells%starts, map%of_cells%nodes)
  end subroutine take_contact

  !> Computes the fields of friction: its traction, slip and status, of each contact and at the nodes. Requires: take_contact with
  !> the same multipliers.
  pure subroutine take_friction(self, map, multipliers, slip, slips)
    class(field_values_t), intent(inout) :: self
    type(field_map_t), intent(in) :: map
    !> [force] shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)
    !> [length] slip since the last time in tangential rows, same shape
    real(rk), intent(in) :: slip(:)
    !> whether each contact slips, shape (n_contacts)
    logical, intent(in) :: slips(:)
    integer :: k, n_nodes

    n_nodes = size(self%displacement, 2)
    ! the multipliers are the forces on the second side
    self%row_tractions = -along_tangents(map, multipliers)
    do k = 1, map%rows%n_rows
      self%row_tractions(:, k) = merge(self%row_tractions(:, k) / max(map%rows%areas(k), tiny(1.0_rk)), 0.0_rk, &
        map%rows%areas(k) > 0)
    end do
    self%row_slips = along_tangents(map, slip)
    self%slips = slips
    self%tangential_traction = nodal_vectors(map%rows, self%row_tractions, n_nodes)
    self%slip = nodal_vectors(map%rows, self%row_slips, n_nodes)
    self%node_friction = nodal_friction(map%rows, self%is_closed, self%is_tied, slips, n_nodes)
  end subroutine take_friction

  !> Returns the sum over the tangential rows of each contact of value times tangent, shape (n_dim, n_contacts). A tangent is the
  !> direction of the coefficients of the row's owner, which owns one contact.
  pure function along_tangents(map, of_rows) result(vectors)
    type(field_map_t), intent(in) :: map
    !> of all rows; those of normal rows are not used
    real(rk), intent(in) :: of_rows(:)
    real(rk) :: vectors(map%rows%n_dim, map%rows%n_rows)
    integer, allocatable :: owners(:)
    integer :: k
    integer :: contact_of(maxval([0, map%rows%owners()]))

    owners = map%rows%owners()
    contact_of(owners) = [(k, k=1, size(owners))]
    owners = map%force_rows%owners()
    vectors = 0
    do k = map%rows%n_rows + 1, map%force_rows%n_rows
      associate (first => map%force_rows%offsets(k) + 1, sum_of => vectors(:, contact_of(owners(k))))
        associate (along => map%force_rows%coefficients(first:first + map%rows%n_dim - 1))
          sum_of = sum_of + of_rows(k) * along / norm2(along)
        end associate
      end associate
    end do
  end function along_tangents

  !> Spreads plastic strains or creep strains, or both, from the integration points of all cells that flow. Those that are not
  !> present do not change.
  pure subroutine take_flow(self, map, plastic, creep)
    class(field_values_t), intent(inout) :: self
    type(field_map_t), intent(in) :: map
    !> [-] shears as angles, and behind them the equivalent strain; shape (7, n_points)
    real(rk), intent(in), optional :: plastic(:, :)
    real(rk), intent(in), optional :: creep(:, :)

    if (present(plastic)) call spread_strains(map, plastic, self%plastic, self%plastic_smoothed)
    if (present(creep)) call spread_strains(map, creep, self%creep, self%creep_smoothed)
  end subroutine take_flow

  pure subroutine spread_strains(map, at_points, of_cells, of_nodes)
    type(field_map_t), intent(in) :: map
    real(rk), intent(in) :: at_points(:, :)
    real(rk), allocatable, intent(inout) :: of_cells(:, :)
    real(rk), allocatable, intent(inout) :: of_nodes(:, :)

    if (.not. allocated(of_cells)) allocate (of_cells(size(at_points, 1), map%of_cells%n_rows()), &
      of_nodes(size(at_points, 1), map%of_nodes%n_rows()))
    call map%of_cells%spread_points(at_points, of_cells)
    call map%of_nodes%spread_points(at_points, of_nodes)
  end subroutine spread_strains

  !> Returns plastic strains or creep strains as tensors, shape (6, n): shears are half of the angles.
  pure function tensors_of(strains) result(tensors)
    !> plastic or creep of field_values_t, shape (7, n)
    real(rk), intent(in) :: strains(:, :)
    real(rk) :: tensors(n_stresses, size(strains, 2))

    tensors = strains(:n_stresses, :)
    tensors(4:, :) = tensors(4:, :) / 2
  end function tensors_of

  !> Computes stresses and their von Mises stresses, as means over the cells and smoothed at the nodes, and the imposed strains as
  !> means over the cells. Where materials flow, their strains cause no stress. Requires: take_displacement; plastic and creep are
  !> set where materials flow.
  pure subroutine take_stresses(self, map, theta)
    class(field_values_t), intent(inout) :: self
    type(field_map_t), intent(in) :: map
    !> values of map%terms
    real(rk), intent(in) :: theta(:)
    real(rk) :: of_materials(n_stresses, n_stresses, size(map%constant_terms) / 2)

    of_materials = map%laws(theta)
    call find_stresses(map%mechanics, map%of_cells, of_materials, theta, self%displacement, self%stress, self%imposed_strain)
    call take_off(map%of_cells, of_materials, self%plastic, self%stress)
    call take_off(map%of_cells, of_materials, self%creep, self%stress)
    self%von_mises = von_mises(self%stress)
    call find_stresses(map%mechanics, map%of_nodes, of_materials, theta, self%displacement, self%stress_smoothed)
    call take_off(map%of_nodes, of_materials, self%plastic_smoothed, self%stress_smoothed)
    call take_off(map%of_nodes, of_materials, self%creep_smoothed, self%stress_smoothed)
    self%von_mises_smoothed = von_mises(self%stress_smoothed)
  end subroutine take_stresses

  !> Takes the stresses of strains off that cause none.
  pure subroutine take_off(rows, of_materials, strains, stresses)
    type(strain_map_t), intent(in) :: rows
    !> result of laws
    real(rk), intent(in) :: of_materials(:, :, :)
    !> [-] not allocated: none; the first six of each row count, shears as angles
    real(rk), allocatable, intent(in) :: strains(:, :)
    !> [force/length**2] shape (n_stresses, n_rows)
    real(rk), intent(inout) :: stresses(:, :)
    real(rk), allocatable :: parts(:, :)

    if (.not. allocated(strains)) return
    allocate (parts, mold=stresses)
    call rows%fill_stresses(of_materials, strains, parts)
    stresses = stresses - parts
  end subroutine take_off

  !> Computes stresses and, if imposed_strains is present, imposed strains of the rows of one strain map. A row is a cell or a node.
  pure subroutine find_stresses(mechanics, rows, of_materials, theta, displacement, stresses, imposed_strains)
    type(mechanical_model_t), intent(in) :: mechanics
    type(strain_map_t), intent(in) :: rows
    !> result of laws
    real(rk), intent(in) :: of_materials(:, :, :)
    !> values of the map's terms, which imposed strains are linear in
    real(rk), intent(in) :: theta(:)
    !> [length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: displacement(:, :)
    !> [force/length**2] shape (n_stresses, n_rows)
    real(rk), allocatable, intent(inout) :: stresses(:, :)
    !> [-] imposed strains, the shears as components of the tensor, same shape
    real(rk), allocatable, intent(inout), optional :: imposed_strains(:, :)
    real(rk), dimension(n_stresses, rows%n_rows()) :: imposed, strains

    call rows%fill_strains(mechanics, displacement, strains)
    call rows%fill_imposed(theta, imposed)
    if (.not. allocated(stresses)) allocate (stresses(n_stresses, rows%n_rows()))
    call rows%fill_stresses(of_materials, strains - imposed, stresses)
    if (.not. present(imposed_strains)) return
    imposed_strains = imposed
    ! shears as angles are twice those of the tensor
    imposed_strains(4:, :) = imposed(4:, :) / 2
  end subroutine find_stresses
end module sig_field_map
