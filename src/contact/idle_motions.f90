! SPDX-License-Identifier: BSD-3-Clause
!> Idle motions: rigid motions that neither a prescribed displacement nor a contact row can hold, such as the rotation of a washer
!> between two plates. Where the loads do no work on them, the solution is unique but for them, and we take the one without them.
!>
!> Bodies that are in contact with each other may move as one. Of such a group one body carries the motion: its displacement has no
!> part in the motion, and the others keep their place relative to it. "No part" means: over the nodes of the carrier, the sum of
!> the scalar products of displacement and motion is zero. Ranks, units and the order of the nodes do not matter.
module sig_idle_motions
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  use sig_rigid_bodies, only: rigid_bodies_t
  use sig_rounding, only: dependent
  use sig_singular_values, only: svd
  implicit none(type, external)
  private
  public :: idle_motions_t, find_idle_motions

  !> The idle motions of all bodies. The motions of one carrier do not move the carriers before it.
  type :: idle_motions_t
    integer :: n = 0
    !> body that carries each motion, ascending, shape (n)
    integer, allocatable :: carriers(:)
    !> [-] amplitudes of the rigid modes of each body. The motions of one carrier are orthonormal on its nodes. Shape (n_rigid,
    !> n_bodies, n)
    real(rk), allocatable :: amplitudes(:, :, :)
    !> dofs of the carriers. Fixing them prevents the motions; natural, ascending, shape (n)
    integer, allocatable :: supports(:)
  contains
    procedure :: at_node
    procedure :: work
    procedure :: leave_out
    procedure :: shares_of_carriers
    procedure :: take_from_carriers
  end type idle_motions_t

contains

  !> Finds the carriers, their motions and the supports from a basis of the idle motions.
  subroutine find_idle_motions(bodies, basis, rows, idle)
    class(rigid_bodies_t), intent(in) :: bodies
    !> [-] independent idle motions, orthonormal as amplitudes; shape (n_rigid, n_bodies, n)
    real(rk), intent(in) :: basis(:, :, :)
    !> supports are dofs that no row moves, where the body has such dofs
    type(contact_rows_t), intent(in) :: rows
    type(idle_motions_t), intent(out) :: idle
    logical :: is_outside(size(bodies%coordinates))
    real(rk), allocatable :: left(:, :), carried(:, :)
    integer :: i_body, n_modes

    n_modes = size(basis, 1) * size(basis, 2)
    allocate (idle%carriers(0), idle%supports(0), idle%amplitudes(size(basis, 1), size(basis, 2), size(basis, 3)))
    is_outside = .true.
    is_outside(pack(rows%dofs, abs(rows%coefficients) > 0)) = .false.
    left = reshape(basis, [n_modes, size(basis, 3)])
    do i_body = 1, bodies%n_bodies
      if (size(left, 2) == 0) exit
      call carry(bodies, i_body, left, carried)
      associate (n => size(carried, 2))
        if (n == 0) cycle
        idle%amplitudes(:, :, idle%n + 1:idle%n + n) = reshape(carried, [size(basis, 1), size(basis, 2), n])
        idle%carriers = [idle%carriers, spread(i_body, 1, n)]
        idle%supports = [idle%supports, bodies%support_body(i_body, &
          idle%amplitudes(:, i_body, idle%n + 1:idle%n + n), is_outside)]
        idle%n = idle%n + n
      end associate
    end do
    call hold_others(idle)
    call sort(idle%supports)
  end subroutine find_idle_motions

  !> Leaves bodies where they are that a motion moves by rounding only: a large load on one of them would seem to drive the motion.
  pure subroutine hold_others(idle)
    type(idle_motions_t), intent(inout) :: idle
    real(rk) :: sizes(size(idle%amplitudes, 2))
    integer :: i, i_body

    do i = 1, idle%n
      sizes = sum(idle%amplitudes(:, :, i)**2, dim=1)
      do i_body = 1, size(sizes)
        if (sizes(i_body) <= dependent**2 * maxval(sizes)) idle%amplitudes(:, i_body, i) = 0
      end do
    end do
  end subroutine hold_others

  !> Splits motions into those that a body carries, which are orthonormal on its nodes, and those that do not move it.
  subroutine carry(bodies, i_body, left, carried)
    class(rigid_bodies_t), intent(in) :: bodies
    integer, intent(in) :: i_body
    !> in: motions, as amplitudes of the modes of all bodies one after the other; out: those that do not move this body
    real(rk), allocatable, intent(inout) :: left(:, :)
    real(rk), allocatable, intent(out) :: carried(:, :)
    real(rk) :: gram(size(left, 2), size(left, 2)), moved(size(bodies%coordinates, 1), size(left, 2))
    real(rk), allocatable :: u(:, :), s(:), vt(:, :)
    integer :: i_node, n, n_nodes

    gram = 0
    n_nodes = 0
    do i_node = 1, size(bodies%body_of_node)
      if (bodies%body_of_node(i_node) /= i_body) cycle
      n_nodes = n_nodes + 1
      moved = matmul(bodies%modes_at(i_node), left((i_body - 1) * bodies%n_rigid + 1:i_body * bodies%n_rigid, :))
      gram = gram + matmul(transpose(moved), moved)
    end do
    call svd(gram, u, s, vt)
    ! of squares of displacements by motions of size 1
    n = count(s > dependent**2 * n_nodes)
    carried = matmul(left, transpose(vt(:n, :))) / spread(sqrt(s(:n)), 1, size(left, 1))
    left = matmul(left, transpose(vt(n + 1:, :)))
    left((i_body - 1) * bodies%n_rigid + 1:i_body * bodies%n_rigid, :) = 0
  end subroutine carry

  !> Sorts a few numbers.
  pure subroutine sort(numbers)
    integer, intent(inout) :: numbers(:)
    integer :: i, lowest

    do i = 1, size(numbers) - 1
      lowest = i - 1 + minloc(numbers(i:), dim=1)
      numbers([i, lowest]) = numbers([lowest, i])
    end do
  end subroutine sort

  !> Returns the displacements of a node by the idle motions, shape (n_dim, n).
  pure function at_node(self, bodies, i_node) result(moved)
    class(idle_motions_t), intent(in) :: self
    class(rigid_bodies_t), intent(in) :: bodies
    !> natural, 1-based
    integer, intent(in) :: i_node
    real(rk) :: moved(size(bodies%coordinates, 1), self%n)

    moved = 0
    if (self%n > 0) moved = matmul(bodies%modes_at(i_node), self%amplitudes(:, bodies%body_of_node(i_node), :))
  end function at_node

  !> Returns the work of forces on each idle motion, and what its rounding is compared with: the sum over the forces of their size
  !> times that of the motion of their node. A force across the motion counts, too: its own rounding may be along the motion.
  pure subroutine work(self, bodies, dofs, forces, done, size_of_parts)
    class(idle_motions_t), intent(in) :: self
    class(rigid_bodies_t), intent(in) :: bodies
    !> natural; a dof may come several times
    integer, intent(in) :: dofs(:)
    !> [force] on these dofs
    real(rk), intent(in) :: forces(:)
    !> [force] shape (n)
    real(rk), intent(out) :: done(:), size_of_parts(:)
    real(rk) :: moved(size(bodies%coordinates, 1), self%n)
    integer :: i, i_node, n_dim

    done = 0
    size_of_parts = 0
    n_dim = size(bodies%coordinates, 1)
    do i = 1, size(dofs)
      i_node = (dofs(i) - 1) / n_dim + 1
      moved = self%at_node(bodies, i_node)
      done = done + forces(i) * moved(dofs(i) - n_dim * (i_node - 1), :)
      size_of_parts = size_of_parts + abs(forces(i)) * norm2(moved, dim=1)
    end do
  end subroutine work

  !> Takes the idle motions out of a displacement: bodies move as rigid ones until the displacements of the carriers have no part in
  !> their motions. Gaps and stresses stay.
  pure subroutine leave_out(self, bodies, displacement)
    class(idle_motions_t), intent(in) :: self
    class(rigid_bodies_t), intent(in) :: bodies
    !> [length] natural, shape (n_dofs)
    real(rk), intent(inout) :: displacement(:)
    real(rk) :: share
    integer :: i, i_node, n_dim

    n_dim = size(bodies%coordinates, 1)
    do i = 1, self%n
      share = 0
      do i_node = 1, size(bodies%body_of_node)
        if (bodies%body_of_node(i_node) == self%carriers(i)) &
          share = share + dot_product(motion_at(i_node), displacement(n_dim * (i_node - 1) + 1:n_dim * i_node))
      end do
      do i_node = 1, size(bodies%body_of_node)
        if (.not. any(abs(self%amplitudes(:, bodies%body_of_node(i_node), i)) > 0)) cycle
        associate (moved => displacement(n_dim * (i_node - 1) + 1:n_dim * i_node))
          moved = moved - share * motion_at(i_node)
        end associate
      end do
    end do

  contains

    pure function motion_at(i_node) result(moved)
      integer, intent(in) :: i_node
      real(rk) :: moved(size(bodies%coordinates, 1))

      moved = matmul(bodies%modes_at(i_node), self%amplitudes(:, bodies%body_of_node(i_node), i))
    end function motion_at
  end subroutine leave_out

  !> Returns the shares [length] of the idle motions in the displacements of some nodes of their carriers, one column per field,
  !> shape (n, n_columns). The sum over all nodes is what take_from_carriers needs.
  pure function shares_of_carriers(self, bodies, nodes, columns) result(shares)
    class(idle_motions_t), intent(in) :: self
    class(rigid_bodies_t), intent(in) :: bodies
    !> natural, 1-based
    integer, intent(in) :: nodes(:)
    !> [length] at these nodes, shape (n_dim * size(nodes), n_columns)
    real(rk), intent(in) :: columns(:, :)
    real(rk) :: shares(self%n, size(columns, 2))
    real(rk) :: moved(size(bodies%coordinates, 1), self%n)
    integer :: i, n_dim

    n_dim = size(bodies%coordinates, 1)
    shares = 0
    do i = 1, size(nodes)
      if (.not. any(self%carriers == bodies%body_of_node(nodes(i)))) cycle
      moved = motions_of_carrier(self, bodies, nodes(i))
      shares = shares + matmul(transpose(moved), columns(n_dim * (i - 1) + 1:n_dim * i, :))
    end do
  end function shares_of_carriers

  !> Takes the idle motions out of the displacements of the carriers; other bodies stay where they are. This is enough where contact
  !> moves them afterwards.
  pure subroutine take_from_carriers(self, bodies, nodes, shares, columns)
    class(idle_motions_t), intent(in) :: self
    class(rigid_bodies_t), intent(in) :: bodies
    !> natural, 1-based
    integer, intent(in) :: nodes(:)
    !> [length] of shares_of_carriers, summed over all nodes
    real(rk), intent(in) :: shares(:, :)
    !> [length] at these nodes, shape (n_dim * size(nodes), n_columns)
    real(rk), intent(inout) :: columns(:, :)
    integer :: i, n_dim

    n_dim = size(bodies%coordinates, 1)
    do i = 1, size(nodes)
      if (.not. any(self%carriers == bodies%body_of_node(nodes(i)))) cycle
      associate (moved => columns(n_dim * (i - 1) + 1:n_dim * i, :))
        moved = moved - matmul(motions_of_carrier(self, bodies, nodes(i)), shares)
      end associate
    end do
  end subroutine take_from_carriers

  !> Returns the displacements of a node by the motions that its own body carries, zero by others; shape (n_dim, n).
  pure function motions_of_carrier(idle, bodies, i_node) result(moved)
    type(idle_motions_t), intent(in) :: idle
    class(rigid_bodies_t), intent(in) :: bodies
    integer, intent(in) :: i_node
    real(rk) :: moved(size(bodies%coordinates, 1), idle%n)

    moved = idle%at_node(bodies, i_node)
    where (spread(idle%carriers /= bodies%body_of_node(i_node), 1, size(moved, 1))) moved = 0
  end function motions_of_carrier
end module sig_idle_motions
