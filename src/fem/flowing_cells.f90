! SPDX-License-Identifier: BSD-3-Clause
!> The cells of a rank whose material flows, with the state of the material at their integration points.
module sig_flowing_cells
  use sig_cell_stiffness, only: cell_dofs
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: n_stresses
  use sig_flow_strains, only: strain_matrices, tangent_stiffness
  use sig_kinds, only: rk
  use sig_material_law, only: creep_work, inelastic_strain, material_law_t, plastic_strain_at, plastic_work
  use sig_mesh, only: mesh_t
  use sig_point_values, only: count_points
  implicit none(type, external)
  private
  public :: dofs_of_flowing_bodies, flowing_cells_t, flow_laws_t, flow_work_t, point_data_t

  !> The law of each material of the deck; not allocated where the material is elastic.
  type :: flow_laws_t
    class(material_law_t), allocatable :: law
  end type flow_laws_t

  !> What is given at the integration points at one time. Points stand in the order of the cells.
  type :: point_data_t
    !> [-] imposed strains, shears as angles, shape (n_stresses, n_points)
    real(rk), allocatable :: imposed(:, :)
    !> properties of the laws, of which the first n_properties of each point's law count; shape (n_most_properties, n_points)
    real(rk), allocatable :: properties(:, :)
  end type point_data_t

  !> [force*length, force in the plane] Work since the last time. Between two times forces change along a straight line: their work
  !> is the mean of both ends times the change of displacement. As the forces of all stresses balance loads, supports and contact at
  !> both ends, loads + supports = energy + imposed + inelastic + contact, exactly but for rounding. With the stress at the end of
  !> the step instead of the mean, inelastic is plastic + creep.
  type :: flow_work_t
    !> loads, without the forces of imposed strains in cells that flow; forces of the supports
    real(rk) :: loads = 0
    real(rk) :: supports = 0
    !> change of the elastic energy: of the stress in cells that flow, u . K u / 2 in others
    real(rk) :: energy = 0
    !> mean contact forces on the displacements of the contacts and on the changes of the gaps; forces at the end on slips
    real(rk) :: contact = 0
    real(rk) :: gaps = 0
    real(rk) :: friction = 0
    !> work of the mean of both ends' stresses on the change of imposed strains, and of inelastic strains
    real(rk) :: imposed = 0
    real(rk) :: inelastic = 0
    !> work of the stress at the end on the changes of plastic strain and of creep strain
    real(rk) :: plastic = 0
    real(rk) :: creep = 0
  end type flow_work_t

  !> Call create; then begin for each history, evaluate for each iterate, and accept at the end of a step.
  type :: flowing_cells_t
    !> 1-based, ascending; of this rank
    integer, allocatable :: cells(:)
    !> the points of cells(i) are offsets(i) + 1 to offsets(i + 1); shape (n_cells + 1)
    integer, allocatable :: offsets(:)
    !> number of the first of them among the points of the flowing cells of all ranks, less 1, shape (n_cells)
    integer, allocatable :: places(:)
    !> number of points of the flowing cells of all ranks
    integer :: n_all_points = 0
    type(flow_laws_t), allocatable :: laws(:)
    !> shape (n_most_state, n_points): accepted, and of the last evaluate
    real(rk), allocatable :: old_states(:, :), states(:, :)
    !> [force/length**2] same points: accepted, and of the last evaluate; shape (n_stresses, n_points)
    real(rk), allocatable :: old_stresses(:, :), stresses(:, :)
    !> of the last evaluate: [-] total strains, shape as stresses; [force/length**2] shape (n_stresses, n_stresses, n_points)
    real(rk), allocatable :: strains(:, :), tangents(:, :, :)
    !> [-] imposed strains that were accepted, shape as strains
    real(rk), allocatable :: old_imposed(:, :)
  contains
    procedure :: create
    procedure :: n_points
    procedure :: begin
    procedure :: evaluate
    procedure :: imposed_forces
    procedure :: tangent_of_cell
    procedure :: accept
    procedure :: count_yielding
    procedure :: count_bad_properties
  end type flowing_cells_t

contains

  !> Returns which dofs belong to bodies with cells that flow.
  pure function dofs_of_flowing_bodies(mesh, body, body_of_node) result(flows)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based, shape (n_nodes)
    integer, intent(in) :: body_of_node(:)
    !> natural, shape (n_dofs)
    logical, allocatable :: flows(:)
    logical :: body_flows(maxval(body_of_node))
    integer :: i

    body_flows = .false.
    do i = 1, mesh%n_cells
      if (body%flows_in(i)) body_flows(body_of_node(mesh%cell_nodes(mesh%cell_offsets(i) + 1))) = .true.
    end do
    flows = [(spread(body_flows(body_of_node(i)), 1, mesh%n_dim), i=1, mesh%n_nodes)]
  end function dofs_of_flowing_bodies

  !> Finds the flowing cells of a rank and makes room for their states.
  subroutine create(self, mesh, body, laws, own_cells)
    class(flowing_cells_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> shape (n_materials)
    type(flow_laws_t), intent(in) :: laws(:)
    !> cells of this rank, 1-based
    integer, intent(in) :: own_cells(:)
    integer :: i, k, n_state

    self%laws = laws
    self%cells = pack(own_cells, [(body%flows_in(own_cells(i)), i=1, size(own_cells))])
    allocate (self%offsets(size(self%cells) + 1), self%places(size(self%cells)), source=0)
    do i = 1, size(self%cells)
      self%offsets(i + 1) = self%offsets(i) + count_points(mesh, body, [self%cells(i)])
    end do
    k = 1
    self%n_all_points = 0
    do i = 1, mesh%n_cells
      if (.not. body%flows_in(i)) cycle
      if (k <= size(self%cells)) then
        if (self%cells(k) == i) then
          self%places(k) = self%n_all_points
          k = k + 1
        end if
      end if
      self%n_all_points = self%n_all_points + count_points(mesh, body, [i])
    end do
    n_state = 0
    do i = 1, size(laws)
      if (allocated(laws(i)%law)) n_state = max(n_state, laws(i)%law%n_state)
    end do
    associate (n => self%n_points())
      allocate (self%old_states(n_state, n), self%states(n_state, n), self%old_stresses(n_stresses, n), &
        self%stresses(n_stresses, n), self%strains(n_stresses, n), self%old_imposed(n_stresses, n), &
        self%tangents(n_stresses, n_stresses, n), source=0.0_rk)
    end associate
  end subroutine create

  !> Returns the number of integration points of this rank.
  pure integer function n_points(self)
    class(flowing_cells_t), intent(in) :: self

    n_points = self%offsets(size(self%offsets))
  end function n_points

  !> Begins a history: the virgin state, without stress.
  pure subroutine begin(self)
    class(flowing_cells_t), intent(inout) :: self

    self%old_states = 0
    self%old_stresses = 0
    self%old_imposed = 0
  end subroutine begin

  !> Computes strains, stresses, states and tangents from a displacement, and the forces of the stresses.
  subroutine evaluate(self, mesh, body, displacement, data, dt, forces, sizes, is_solved)
    class(flowing_cells_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> [length] natural, shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    type(point_data_t), intent(in) :: data
    !> [time] since the accepted state
    real(rk), intent(in) :: dt
    !> [force] the integral of B' sigma over the cells of this rank, and the same of |B|' |sigma|; natural, shape (n_dofs)
    real(rk), intent(out) :: forces(:)
    real(rk), intent(out) :: sizes(:)
    !> whether the law has an answer at all points of this rank
    logical, intent(out) :: is_solved
    real(rk), allocatable :: matrices(:, :, :), volumes(:)
    integer :: i, k, n
    logical :: is_point_solved

    forces = 0
    sizes = 0
    is_solved = .true.
    do i = 1, size(self%cells)
      call strain_matrices(mesh, body, self%cells(i), matrices, volumes)
      associate (law => self%laws(body%material_of_cell(self%cells(i)))%law, dofs => cell_dofs(mesh, self%cells(i)))
        do k = 1, size(volumes)
          n = self%offsets(i) + k
          self%strains(:, n) = matmul(matrices(:, :, k), displacement(dofs))
          call law%update(self%strains(:, n) - data%imposed(:, n), dt, data%properties(:law%n_properties(), n), &
            self%old_states(:law%n_state, n), self%stresses(:, n), self%states(:law%n_state, n), self%tangents(:, :, n), &
            is_point_solved)
          is_solved = is_solved .and. is_point_solved
          forces(dofs) = forces(dofs) + volumes(k) * matmul(self%stresses(:, n), matrices(:, :, k))
          sizes(dofs) = sizes(dofs) + volumes(k) * matmul(abs(self%stresses(:, n)), abs(matrices(:, :, k)))
        end do
      end associate
    end do
  end subroutine evaluate

  !> Returns the integral of B' C eps* over the cells of this rank [force], natural, shape (n_dofs): what flowing cells have in the
  !> forces of imposed strains.
  function imposed_forces(self, mesh, body, data) result(forces)
    class(flowing_cells_t), intent(in) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(point_data_t), intent(in) :: data
    real(rk) :: forces(mesh%n_dim * mesh%n_nodes)
    real(rk), allocatable :: matrices(:, :, :), volumes(:)
    integer :: i, k

    forces = 0
    do i = 1, size(self%cells)
      if (.not. any(abs(data%imposed(:, self%offsets(i) + 1:self%offsets(i + 1))) > 0)) cycle
      call strain_matrices(mesh, body, self%cells(i), matrices, volumes)
      associate (hooke => body%stress_matrix(:, :, body%material_of_cell(self%cells(i))), &
        dofs => cell_dofs(mesh, self%cells(i)))
        do k = 1, size(volumes)
          forces(dofs) = forces(dofs) + volumes(k) * matmul(matmul(hooke, data%imposed(:, self%offsets(i) + k)), &
            matrices(:, :, k))
        end do
      end associate
    end do
  end function imposed_forces

  !> Computes the tangent stiffness of one cell at the last evaluate, and the force by which the linear problem misses the stress:
  !> the integral of B' (C_T eps - sigma), so that K_T u minus this force is the integral of B' sigma.
  subroutine tangent_of_cell(self, mesh, body, i, stiffness, forces)
    class(flowing_cells_t), intent(in) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> index into self%cells
    integer, intent(in) :: i
    !> [force/length, force/length**2 in the plane] rows as in cell_dofs
    real(rk), allocatable, intent(out) :: stiffness(:, :)
    !> [force] same rows
    real(rk), allocatable, intent(out) :: forces(:)
    real(rk), allocatable :: matrices(:, :, :), volumes(:)
    integer :: k, n

    call strain_matrices(mesh, body, self%cells(i), matrices, volumes)
    stiffness = tangent_stiffness(matrices, volumes, self%tangents(:, :, self%offsets(i) + 1:self%offsets(i + 1)))
    allocate (forces(size(stiffness, 1)), source=0.0_rk)
    do k = 1, size(volumes)
      n = self%offsets(i) + k
      forces = forces + volumes(k) * matmul(matmul(self%tangents(:, :, n), self%strains(:, n)) - self%stresses(:, n), &
        matrices(:, :, k))
    end do
  end subroutine tangent_of_cell

  !> Makes the last evaluate the accepted state, and adds what its step did to the work of this rank.
  subroutine accept(self, mesh, body, data, work, energy)
    class(flowing_cells_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> that of the last evaluate
    type(point_data_t), intent(in) :: data
    !> imposed, inelastic, plastic and creep grow
    type(flow_work_t), intent(inout) :: work
    !> [force*length, force in the plane] elastic energy of these cells
    real(rk), intent(out) :: energy
    real(rk), allocatable :: matrices(:, :, :), volumes(:)
    real(rk) :: mean(n_stresses)
    integer :: i, k, n

    energy = 0
    do i = 1, size(self%cells)
      call strain_matrices(mesh, body, self%cells(i), matrices, volumes)
      do k = 1, size(volumes)
        n = self%offsets(i) + k
        associate (old => self%old_states(:, n), new => self%states(:, n), stress => self%stresses(:, n))
          mean = volumes(k) * (stress + self%old_stresses(:, n)) / 2
          energy = energy + volumes(k) / 2 * dot_product(stress, self%strains(:, n) - data%imposed(:, n) - inelastic_strain(new))
          work%imposed = work%imposed + dot_product(mean, data%imposed(:, n) - self%old_imposed(:, n))
          work%inelastic = work%inelastic + dot_product(mean, inelastic_strain(new) - inelastic_strain(old))
          work%plastic = work%plastic + volumes(k) * plastic_work(stress, old, new)
          work%creep = work%creep + volumes(k) * creep_work(stress, old, new)
        end associate
      end do
    end do
    self%old_states = self%states
    self%old_stresses = self%stresses
    self%old_imposed = data%imposed
  end subroutine accept

  !> Counts the points of this rank of each material, and those whose plastic strain grew from the accepted state to the last
  !> evaluate; shapes (n_materials).
  pure subroutine count_yielding(self, body, n_points, n_yielding)
    class(flowing_cells_t), intent(in) :: self
    type(elastic_body_t), intent(in) :: body
    integer, intent(out) :: n_points(:)
    integer, intent(out) :: n_yielding(:)
    integer :: i

    n_points = 0
    n_yielding = 0
    do i = 1, size(self%cells)
      associate (m => body%material_of_cell(self%cells(i)), first => self%offsets(i) + 1, last => self%offsets(i + 1))
        n_points(m) = n_points(m) + last - first + 1
        n_yielding(m) = n_yielding(m) + count(self%states(plastic_strain_at, first:last) > &
          self%old_states(plastic_strain_at, first:last))
      end associate
    end do
  end subroutine count_yielding

  !> Counts the points of this rank with a property that its law does not take.
  pure integer function count_bad_properties(self, body, data) result(n)
    class(flowing_cells_t), intent(in) :: self
    type(elastic_body_t), intent(in) :: body
    type(point_data_t), intent(in) :: data
    integer :: i, k

    n = 0
    do i = 1, size(self%cells)
      associate (law => self%laws(body%material_of_cell(self%cells(i)))%law)
        do k = self%offsets(i) + 1, self%offsets(i + 1)
          if (law%bad_property(data%properties(:law%n_properties(), k)) > 0) n = n + 1
        end do
      end associate
    end do
  end function count_bad_properties
end module sig_flowing_cells
