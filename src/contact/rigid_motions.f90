! SPDX-License-Identifier: BSD-3-Clause
!> The rigid motions that no prescribed displacement holds: those that contact must hold, Z, and idle ones, which nothing holds.
module sig_rigid_motions
  use sig_contact_rows, only: contact_rows_t
  use sig_idle_motions, only: find_idle_motions, idle_motions_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_rigid_bodies, only: n_rigid_modes, null_space, outer, rigid_bodies_t, rigid_modes
  implicit none(type, external)
  private
  public :: rigid_motions_t, create_rigid_motions, create_free_motions

  !> The bodies of a mesh, and those of their rigid motions that neither prescribed displacements nor the supports of the idle
  !> motions hold (free motions).
  type, extends(rigid_bodies_t) :: rigid_motions_t
    !> motions that nothing holds
    type(idle_motions_t) :: idle
    !> number of free motions of all bodies together: columns of Z
    integer :: n_free = 0
    !> shape (n_free)
    integer, allocatable :: body_of_motion(:)
    !> [-] amplitudes of the rigid modes of its body, for each free motion; shape (n_rigid, n_free)
    real(rk), allocatable :: amplitudes(:, :)
    !> [-] B Z, shape (n_rows, n_free)
    real(rk), allocatable :: closing(:, :)
  contains
    procedure :: at_node
    procedure :: field
    procedure :: work
    procedure :: work_size
    procedure :: are_held_by
    procedure :: pick_supports
    procedure :: n_common
    procedure :: common_field
  end type rigid_motions_t

contains

  !> Finds the bodies of a mesh, the idle motions, the rigid motions Z that contact must hold, and B Z.
  subroutine create_rigid_motions(mesh, is_round, is_prescribed, rows, motions)
    type(mesh_t), intent(in) :: mesh
    !> whether the model is axisymmetric
    logical, intent(in) :: is_round
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    type(contact_rows_t), intent(in) :: rows
    type(rigid_motions_t), intent(out) :: motions
    logical :: is_held(size(is_prescribed))

    call create_free_motions(mesh, is_round, is_prescribed, rows, motions)
    call find_idle_motions(motions, idle_basis(motions), rows, motions%idle)
    if (motions%idle%n == 0) return
    is_held = is_prescribed
    is_held(motions%idle%supports) = .true.
    call find_free_motions(is_held, motions)
    call close_rows(rows, motions)
  end subroutine create_rigid_motions

  !> Finds the bodies of a mesh, all rigid motions Z that no prescribed displacement holds, and B Z. Idle ones are not looked for: Z
  !> has them, too.
  subroutine create_free_motions(mesh, is_round, is_prescribed, rows, motions)
    type(mesh_t), intent(in) :: mesh
    !> whether the model is axisymmetric
    logical, intent(in) :: is_round
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    type(contact_rows_t), intent(in) :: rows
    type(rigid_motions_t), intent(out) :: motions

    call motions%create_bodies(mesh, is_round)
    call find_free_motions(is_prescribed, motions)
    call close_rows(rows, motions)
  end subroutine create_free_motions

  !> Sets B Z.
  pure subroutine close_rows(rows, motions)
    type(contact_rows_t), intent(in) :: rows
    type(rigid_motions_t), intent(inout) :: motions
    integer :: i, k

    motions%closing = reshape([real(rk) ::], [rows%n_rows, motions%n_free], pad=[0.0_rk])
    do k = 1, rows%n_rows
      associate (nodes => rows%nodes_of(k), coefficients => reshape(rows%coefficients_of(k), [rows%n_dim, size(rows%nodes_of(k))]))
        do i = 1, size(nodes)
          motions%closing(k, :) = motions%closing(k, :) + matmul(coefficients(:, i), motions%at_node(nodes(i)))
        end do
      end associate
    end do
  end subroutine close_rows

  !> Returns a basis of the combinations of free motions that change the gap of no contact row, as amplitudes of the rigid modes of
  !> each body; shape (n_rigid, n_bodies, n).
  function idle_basis(motions) result(basis)
    type(rigid_motions_t), intent(in) :: motions
    real(rk), allocatable :: basis(:, :, :)
    real(rk), allocatable :: combinations(:, :)
    integer :: i, i_motion

    combinations = null_space(matmul(transpose(motions%closing), motions%closing))
    allocate (basis(motions%n_rigid, motions%n_bodies, size(combinations, 2)), source=0.0_rk)
    do i = 1, size(combinations, 2)
      do i_motion = 1, motions%n_free
        associate (own => basis(:, motions%body_of_motion(i_motion), i))
          own = own + combinations(i_motion, i) * motions%amplitudes(:, i_motion)
        end associate
      end do
    end do
  end function idle_basis

  !> Finds for each body the rigid motions that do not move the prescribed dofs.
  subroutine find_free_motions(is_prescribed, motions)
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    type(rigid_motions_t), intent(inout) :: motions
    real(rk), allocatable :: amplitudes(:, :), gram(:, :, :), free(:, :)
    integer, allocatable :: body_of_motion(:)
    real(rk) :: modes(size(motions%coordinates, 1), motions%n_rigid)
    integer :: i_body, i_component, i_node, n_dim

    n_dim = size(motions%coordinates, 1)
    allocate (gram(motions%n_rigid, motions%n_rigid, motions%n_bodies), source=0.0_rk)
    do i_node = 1, size(motions%body_of_node)
      if (.not. any(is_prescribed(n_dim * (i_node - 1) + 1:n_dim * i_node))) cycle
      i_body = motions%body_of_node(i_node)
      modes = motions%modes_at(i_node)
      do i_component = 1, n_dim
        if (.not. is_prescribed(n_dim * (i_node - 1) + i_component)) cycle
        gram(:, :, i_body) = gram(:, :, i_body) + outer(modes(i_component, :))
      end do
    end do
    allocate (body_of_motion(0), amplitudes(motions%n_rigid, 0))
    do i_body = 1, motions%n_bodies
      free = null_space(gram(:, :, i_body))
      amplitudes = reshape([amplitudes, free], [motions%n_rigid, size(amplitudes, 2) + size(free, 2)])
      body_of_motion = [body_of_motion, spread(i_body, 1, size(free, 2))]
    end do
    motions%n_free = size(body_of_motion)
    call move_alloc(amplitudes, motions%amplitudes)
    call move_alloc(body_of_motion, motions%body_of_motion)
  end subroutine find_free_motions

  !> Returns the rows of Z that belong to a node, shape (n_dim, n_free).
  pure function at_node(self, i_node) result(rows)
    class(rigid_motions_t), intent(in) :: self
    !> natural, 1-based
    integer, intent(in) :: i_node
    real(rk) :: rows(size(self%coordinates, 1), self%n_free)
    real(rk) :: modes(size(self%coordinates, 1), self%n_rigid)
    integer :: i

    rows = 0
    if (.not. any(self%body_of_motion == self%body_of_node(i_node))) return
    modes = self%modes_at(i_node)
    do i = 1, self%n_free
      if (self%body_of_motion(i) == self%body_of_node(i_node)) rows(:, i) = matmul(modes, self%amplitudes(:, i))
    end do
  end function at_node

  !> Returns the displacement field Z times amplitudes, in the unit of the amplitudes, without idle motions of their carriers.
  pure function field(self, amplitudes) result(displacement)
    class(rigid_motions_t), intent(in) :: self
    !> shape (n_free)
    real(rk), intent(in) :: amplitudes(:)
    !> natural, shape (n_dofs)
    real(rk) :: displacement(size(self%coordinates))
    real(rk) :: column(size(displacement), 1)
    integer :: i_node, n_dim

    n_dim = size(self%coordinates, 1)
    do i_node = 1, size(self%body_of_node)
      column(n_dim * (i_node - 1) + 1:n_dim * i_node, 1) = matmul(self%at_node(i_node), amplitudes)
    end do
    if (self%idle%n > 0) then
      associate (nodes => [(i_node, i_node=1, size(self%body_of_node))])
        call self%idle%take_from_carriers(self, nodes, self%idle%shares_of_carriers(self, nodes, column), column)
      end associate
    end if
    displacement = column(:, 1)
  end function field

  !> Returns Z' F, the work of forces on each motion.
  pure function work(self, forces)
    class(rigid_motions_t), intent(in) :: self
    !> [force] natural, shape (n_dofs)
    real(rk), intent(in) :: forces(:)
    !> [force] shape (n_free)
    real(rk) :: work(self%n_free)
    integer :: i_node, n_dim

    work = 0
    if (self%n_free == 0) return
    n_dim = size(self%coordinates, 1)
    do i_node = 1, size(self%body_of_node)
      associate (force => forces(n_dim * (i_node - 1) + 1:n_dim * i_node))
        if (any(abs(force) > 0)) work = work + matmul(force, self%at_node(i_node))
      end associate
    end do
  end function work

  !> Returns |Z|' |F| [force], the sum of the sizes of the parts of `work`, which its rounding is compared with.
  pure function work_size(self, forces)
    class(rigid_motions_t), intent(in) :: self
    !> [force] natural, shape (n_dofs)
    real(rk), intent(in) :: forces(:)
    real(rk) :: work_size(self%n_free)
    integer :: i_node, n_dim

    work_size = 0
    if (self%n_free == 0) return
    n_dim = size(self%coordinates, 1)
    do i_node = 1, size(self%body_of_node)
      associate (force => forces(n_dim * (i_node - 1) + 1:n_dim * i_node))
        if (any(abs(force) > 0)) work_size = work_size + matmul(abs(force), abs(self%at_node(i_node)))
      end associate
    end do
  end function work_size

  !> Whether the closed contacts, taken as equations, hold all the free motions in both directions; true if there are no free
  !> motions.
  logical function are_held_by(self, is_closed)
    class(rigid_motions_t), intent(in) :: self
    !> shape (n_rows)
    logical, intent(in) :: is_closed(:)
    integer :: k

    are_held_by = self%n_free == 0
    if (are_held_by) return
    associate (rows => self%closing(pack([(k, k=1, size(is_closed))], is_closed), :))
      are_held_by = size(null_space(matmul(transpose(rows), rows)), 2) == 0
    end associate
  end function are_held_by

  !> Returns as many dofs as there are free motions. Fixing them holds the bodies, and causes no reactions under forces in
  !> equilibrium.
  function pick_supports(self) result(dofs)
    class(rigid_motions_t), intent(in) :: self
    !> natural, shape (n_free)
    integer :: dofs(self%n_free)
    integer, allocatable :: own(:)
    integer :: i, i_body

    do i_body = 1, self%n_bodies
      own = pack([(i, i=1, self%n_free)], self%body_of_motion == i_body)
      if (size(own) > 0) dofs(own) = self%support_body(i_body, self%amplitudes(:, own))
    end do
  end function pick_supports

  !> Returns the number of rigid motions of all bodies as one: 3 in the plane, 6 in space. Axisymmetric bodies count as plane ones,
  !> which they resemble away from the axis.
  pure integer function n_common(self)
    class(rigid_motions_t), intent(in) :: self

    n_common = n_rigid_modes(size(self%coordinates, 1), .false.)
  end function n_common

  !> Returns a rigid motion of all bodies as one, as a displacement field in natural order, shape (n_dofs). It has no strain energy,
  !> except in axisymmetry, where this energy is small away from the axis.
  pure function common_field(self, i_mode) result(displacement)
    class(rigid_motions_t), intent(in) :: self
    !> 1 to n_common: the translations first, then the rotations
    integer, intent(in) :: i_mode
    !> [-] a translation moves all nodes by 1; a rotation moves a node by its distance from the axis, which goes through the mean of
    !> all nodes, divided by the largest extent of the mesh
    real(rk) :: displacement(size(self%coordinates))
    real(rk) :: center(size(self%coordinates, 1)), modes(size(self%coordinates, 1), self%n_common()), length
    integer :: i_node, n_dim

    n_dim = size(center)
    center = sum(self%coordinates, dim=2) / size(self%coordinates, 2)
    length = maxval(maxval(self%coordinates, dim=2) - minval(self%coordinates, dim=2))
    do i_node = 1, size(self%coordinates, 2)
      modes = rigid_modes((self%coordinates(:, i_node) - center) / length, .false.)
      displacement(n_dim * (i_node - 1) + 1:n_dim * i_node) = modes(:, i_mode)
    end do
  end function common_field
end module sig_rigid_motions
