! SPDX-License-Identifier: BSD-3-Clause
!> The rigid motions that no prescribed displacement holds, Z: contact must hold them, or nothing does.
!>
!> Modes are scaled by the size of their body, so every decision about their rank is free of units.
module sig_rigid_motions
  use sig_bodies, only: find_bodies
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_singular_values, only: svd
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: rigid_motions_t, create_rigid_motions, null_space

  !> The bodies of a mesh, and those of their rigid motions that no prescribed displacement holds (free motions).
  type :: rigid_motions_t
    !> number of rigid motions of one body
    integer :: n_rigid = 0
    !> whether the model is axisymmetric
    logical :: is_round = .false.
    !> [length] shape (n_dim, n_nodes)
    real(rk), allocatable :: coordinates(:, :)
    integer :: n_bodies = 0
    !> shape (n_nodes)
    integer, allocatable :: body_of_node(:)
    !> [length] mean of the nodes of each body, shape (n_dim, n_bodies), and distance of its farthest node from it, shape (n_bodies)
    real(rk), allocatable :: centers(:, :)
    real(rk), allocatable :: sizes(:)
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

  !> [-] eigenvalues of a Gram matrix up to this share of the larger of 1 and the largest eigenvalue count as zero: 1e-6 in the
  !> motions
  real(rk), parameter :: negligible = 1.0e-12_rk

contains

  !> Finds the bodies of a mesh, their rigid motions Z that no prescribed displacement holds, and B Z.
  subroutine create_rigid_motions(mesh, is_round, is_prescribed, rows, motions)
    type(mesh_t), intent(in) :: mesh
    !> whether the model is axisymmetric
    logical, intent(in) :: is_round
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    type(contact_rows_t), intent(in) :: rows
    type(rigid_motions_t), intent(out) :: motions
    integer :: i, k

    motions%is_round = is_round
    motions%n_rigid = n_rigid_modes(mesh%n_dim, is_round)
    motions%coordinates = mesh%coordinates
    call find_bodies(mesh, motions%body_of_node, motions%n_bodies)
    call measure_bodies(motions)
    call find_free_motions(is_prescribed, motions)
    allocate (motions%closing(rows%n_rows, motions%n_free), source=0.0_rk)
    do k = 1, rows%n_rows
      associate (nodes => rows%nodes_of(k), coefficients => reshape(rows%coefficients_of(k), [mesh%n_dim, size(rows%nodes_of(k))]))
        do i = 1, size(nodes)
          motions%closing(k, :) = motions%closing(k, :) + matmul(coefficients(:, i), motions%at_node(nodes(i)))
        end do
      end associate
    end do
  end subroutine create_rigid_motions

  !> Returns the number of rigid modes of a body: translations and rotations; in axisymmetry only the axial translation.
  pure integer function n_rigid_modes(n_dim, is_round)
    integer, intent(in) :: n_dim
    logical, intent(in) :: is_round

    n_rigid_modes = n_dim * (n_dim + 1) / 2
    if (is_round) n_rigid_modes = 1
  end function n_rigid_modes

  !> Returns the displacements of the rigid modes at a place, one per column: the translations, then the rotations.
  pure function rigid_modes(place, is_round) result(modes)
    !> [-] relative to the center of the body, divided by its size (in common_field: of the whole mesh); shape (n_dim)
    real(rk), intent(in) :: place(:)
    logical, intent(in) :: is_round
    real(rk) :: modes(size(place), n_rigid_modes(size(place), is_round))
    integer :: i

    modes = 0
    if (is_round) then
      modes(2, 1) = 1
      return
    end if
    do i = 1, size(place)
      modes(i, i) = 1
    end do
    if (size(place) == 2) then
      modes(:, 3) = [-place(2), place(1)]
    else
      modes(:, 4) = [0.0_rk, -place(3), place(2)]
      modes(:, 5) = [place(3), 0.0_rk, -place(1)]
      modes(:, 6) = [-place(2), place(1), 0.0_rk]
    end if
  end function rigid_modes

  !> Computes the center (mean of the nodes) and the size (distance of the farthest node) of each body.
  pure subroutine measure_bodies(motions)
    type(rigid_motions_t), intent(inout) :: motions
    integer :: i_node, n_nodes(motions%n_bodies)

    associate (places => motions%coordinates, body => motions%body_of_node)
      allocate (motions%centers(size(places, 1), motions%n_bodies), motions%sizes(motions%n_bodies), source=0.0_rk)
      n_nodes = 0
      do i_node = 1, size(body)
        n_nodes(body(i_node)) = n_nodes(body(i_node)) + 1
        motions%centers(:, body(i_node)) = motions%centers(:, body(i_node)) + places(:, i_node)
      end do
      motions%centers = motions%centers / spread(real(n_nodes, rk), 1, size(places, 1))
      do i_node = 1, size(body)
        motions%sizes(body(i_node)) = max(motions%sizes(body(i_node)), &
          norm2(places(:, i_node) - motions%centers(:, body(i_node))))
      end do
    end associate
  end subroutine measure_bodies

  !> Finds for each body the rigid motions that do not move the prescribed dofs.
  subroutine find_free_motions(is_prescribed, motions)
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    type(rigid_motions_t), intent(inout) :: motions
    real(rk), allocatable :: gram(:, :, :), free(:, :)
    real(rk) :: modes(size(motions%coordinates, 1), motions%n_rigid)
    integer :: i_body, i_component, i_node, n_dim

    n_dim = size(motions%coordinates, 1)
    allocate (gram(motions%n_rigid, motions%n_rigid, motions%n_bodies), source=0.0_rk)
    do i_node = 1, size(motions%body_of_node)
      if (.not. any(is_prescribed(n_dim * (i_node - 1) + 1:n_dim * i_node))) cycle
      i_body = motions%body_of_node(i_node)
      modes = modes_at(motions, i_node)
      do i_component = 1, n_dim
        if (.not. is_prescribed(n_dim * (i_node - 1) + i_component)) cycle
        gram(:, :, i_body) = gram(:, :, i_body) + outer(modes(i_component, :))
      end do
    end do
    allocate (motions%body_of_motion(0), motions%amplitudes(motions%n_rigid, 0))
    do i_body = 1, motions%n_bodies
      free = null_space(gram(:, :, i_body))
      motions%amplitudes = reshape([motions%amplitudes, free], [motions%n_rigid, motions%n_free + size(free, 2)])
      motions%body_of_motion = [motions%body_of_motion, spread(i_body, 1, size(free, 2))]
      motions%n_free = size(motions%body_of_motion)
    end do
  end subroutine find_free_motions

  !> Returns an orthonormal basis of the null space of a Gram matrix, a vector per column. Eigenvalues up to 1e-12 times the larger
  !> of 1 and the largest one count as zero.
  function null_space(gram) result(columns)
    !> symmetric, no negative eigenvalue, shape (n, n)
    real(rk), intent(in) :: gram(:, :)
    real(rk), allocatable :: columns(:, :)
    real(rk), allocatable :: u(:, :), s(:), vt(:, :)
    integer :: rank

    call svd(gram, u, s, vt)
    rank = 0
    ! motions have size 1, so that a Gram matrix far below 1 is rounding as a whole
    if (size(s) > 0) rank = count(s > negligible * max(1.0_rk, s(1)))
    columns = transpose(vt(rank + 1:, :))
  end function null_space

  !> Returns the displacements of a node (1-based) in all rigid modes of its body, one per column, whether they are free or not.
  pure function modes_at(motions, i_node) result(modes)
    type(rigid_motions_t), intent(in) :: motions
    integer, intent(in) :: i_node
    real(rk) :: modes(size(motions%coordinates, 1), motions%n_rigid)

    associate (i_body => motions%body_of_node(i_node))
      modes = rigid_modes((motions%coordinates(:, i_node) - motions%centers(:, i_body)) / motions%sizes(i_body), motions%is_round)
    end associate
  end function modes_at

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
    modes = modes_at(self, i_node)
    do i = 1, self%n_free
      if (self%body_of_motion(i) == self%body_of_node(i_node)) rows(:, i) = matmul(modes, self%amplitudes(:, i))
    end do
  end function at_node

  !> Returns the displacement field Z times amplitudes, in the unit of the amplitudes.
  pure function field(self, amplitudes) result(displacement)
    class(rigid_motions_t), intent(in) :: self
    !> shape (n_free)
    real(rk), intent(in) :: amplitudes(:)
    !> natural, shape (n_dofs)
    real(rk) :: displacement(size(self%coordinates))
    integer :: i_node, n_dim

    n_dim = size(self%coordinates, 1)
    do i_node = 1, size(self%body_of_node)
      displacement(n_dim * (i_node - 1) + 1:n_dim * i_node) = matmul(self%at_node(i_node), amplitudes)
    end do
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
  !>
  !> Per body, each time the dof that the motions not yet held move most. Cost: linear in the nodes per motion.
  function pick_supports(self) result(dofs)
    class(rigid_motions_t), intent(in) :: self
    !> natural, shape (n_free)
    integer :: dofs(self%n_free)
    real(rk) :: held(self%n_free, self%n_free), rows(size(self%coordinates, 1), self%n_free), best, size_now
    integer :: i, i_component, i_node, n_dim

    n_dim = size(self%coordinates, 1)
    held = 0
    do i = 1, self%n_free
      best = 0
      do i_node = 1, size(self%body_of_node)
        if (self%body_of_node(i_node) /= self%body_of_motion(i)) cycle
        rows = self%at_node(i_node)
        rows = rows - matmul(matmul(rows, held(:, :i - 1)), transpose(held(:, :i - 1)))
        do i_component = 1, n_dim
          size_now = norm2(rows(i_component, :))
          ! nodes alike within rounding: the first one, so that the choice is the same everywhere
          if (size_now <= best * (1 + tie_tolerance)) cycle
          best = size_now
          dofs(i) = n_dim * (i_node - 1) + i_component
          held(:, i) = rows(i_component, :) / size_now
        end do
      end do
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

  pure function outer(vector) result(matrix)
    real(rk), intent(in) :: vector(:)
    real(rk) :: matrix(size(vector), size(vector))

    matrix = spread(vector, 2, size(vector)) * spread(vector, 1, size(vector))
  end function outer
end module sig_rigid_motions
