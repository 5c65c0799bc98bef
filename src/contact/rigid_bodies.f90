! SPDX-License-Identifier: BSD-3-Clause
!> The bodies of a mesh and all their rigid motions, whatever holds them.
!>
!> Modes are scaled by the size of their body, so every decision about their rank is free of units.
module sig_rigid_bodies
  use sig_bodies, only: find_bodies
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_rounding, only: dependent
  use sig_singular_values, only: svd
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: rigid_bodies_t, n_rigid_modes, null_space, outer, rigid_modes

  !> The bodies of a mesh.
  type :: rigid_bodies_t
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
  contains
    procedure :: create_bodies
    procedure :: modes_at
    procedure :: support_body
  end type rigid_bodies_t

  !> [-] a preferred dof is taken as a support if it moves at least by this share of the dof that moves most
  real(rk), parameter :: good_enough = 0.01_rk

contains

  !> Finds the bodies of a mesh, their centers and sizes.
  pure subroutine create_bodies(self, mesh, is_round)
    class(rigid_bodies_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    !> whether the model is axisymmetric
    logical, intent(in) :: is_round

    self%is_round = is_round
    self%n_rigid = n_rigid_modes(mesh%n_dim, is_round)
    self%coordinates = mesh%coordinates
    call find_bodies(mesh, self%body_of_node, self%n_bodies)
    call measure_bodies(self)
  end subroutine create_bodies

  !> Returns the number of rigid modes of a body: translations and rotations; in axisymmetry only the axial translation.
  pure integer function n_rigid_modes(n_dim, is_round)
    integer, intent(in) :: n_dim
    logical, intent(in) :: is_round

    n_rigid_modes = n_dim * (n_dim + 1) / 2
    if (is_round) n_rigid_modes = 1
  end function n_rigid_modes

  !> Returns the displacements of the rigid modes at a place, one per column: the translations, then the rotations.
  pure function rigid_modes(place, is_round) result(modes)
    !> [-] relative to the center of the body, divided by its size; shape (n_dim)
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
  pure subroutine measure_bodies(bodies)
    class(rigid_bodies_t), intent(inout) :: bodies
    integer :: i_node, n_nodes(bodies%n_bodies)

    associate (places => bodies%coordinates, body => bodies%body_of_node)
      allocate (bodies%centers(size(places, 1), bodies%n_bodies), bodies%sizes(bodies%n_bodies), source=0.0_rk)
      n_nodes = 0
      do i_node = 1, size(body)
        n_nodes(body(i_node)) = n_nodes(body(i_node)) + 1
        bodies%centers(:, body(i_node)) = bodies%centers(:, body(i_node)) + places(:, i_node)
      end do
      bodies%centers = bodies%centers / spread(real(n_nodes, rk), 1, size(places, 1))
      do i_node = 1, size(body)
        bodies%sizes(body(i_node)) = max(bodies%sizes(body(i_node)), norm2(places(:, i_node) - bodies%centers(:, body(i_node))))
      end do
    end associate
  end subroutine measure_bodies

  !> Returns the displacements of a node (1-based) in all rigid modes of its body, one per column.
  pure function modes_at(self, i_node) result(modes)
    class(rigid_bodies_t), intent(in) :: self
    integer, intent(in) :: i_node
    real(rk) :: modes(size(self%coordinates, 1), self%n_rigid)

    associate (i_body => self%body_of_node(i_node))
      modes = rigid_modes((self%coordinates(:, i_node) - self%centers(:, i_body)) / self%sizes(i_body), self%is_round)
    end associate
  end function modes_at

  !> Returns as many dofs of a body as there are motions. Fixing them prevents these motions, and causes no reactions under forces
  !> that do no work on them.
  !>
  !> Each time the dof that the motions not yet held move most, or a preferred dof that moves nearly as much. Cost: linear in the
  !> nodes per motion.
  function support_body(self, i_body, motions, is_preferred) result(dofs)
    class(rigid_bodies_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: i_body
    !> [-] independent motions as amplitudes of the rigid modes, shape (n_rigid, n)
    real(rk), intent(in) :: motions(:, :)
    !> natural, shape (n_dofs); default: none
    logical, intent(in), optional :: is_preferred(:)
    !> natural, shape (n)
    integer :: dofs(size(motions, 2))
    real(rk) :: held(size(motions, 2), size(motions, 2)), rows(size(self%coordinates, 1), size(motions, 2))
    real(rk) :: best, best_preferred
    integer :: i, i_dof, i_node, n_dim, preferred
    integer :: places(size(motions, 2))

    n_dim = size(self%coordinates, 1)
    held = 0
    do i = 1, size(dofs)
      best = 0
      best_preferred = 0
      do i_node = 1, size(self%body_of_node)
        if (self%body_of_node(i_node) /= i_body) cycle
        rows = matmul(self%modes_at(i_node), motions)
        rows = rows - matmul(matmul(rows, held(:, :i - 1)), transpose(held(:, :i - 1)))
        call compare(n_dim * (i_node - 1), rows, best, places(i))
        if (present(is_preferred)) then
          where (.not. spread(is_preferred(n_dim * (i_node - 1) + 1:n_dim * i_node), 2, size(dofs))) rows = 0
          call compare(n_dim * (i_node - 1), rows, best_preferred, preferred)
        end if
      end do
      dofs(i) = places(i)
      if (best_preferred >= good_enough * best) dofs(i) = preferred
      i_dof = modulo(dofs(i) - 1, n_dim) + 1
      rows = matmul(self%modes_at((dofs(i) - 1) / n_dim + 1), motions)
      rows = rows - matmul(matmul(rows, held(:, :i - 1)), transpose(held(:, :i - 1)))
      held(:, i) = rows(i_dof, :) / norm2(rows(i_dof, :))
    end do
  end function support_body

  !> Takes a dof of a node where it moves more than the best one so far.
  pure subroutine compare(n_before, rows, best, dof)
    !> number of dofs of the nodes before this one
    integer, intent(in) :: n_before
    !> displacement of each component of the node by each motion
    real(rk), intent(in) :: rows(:, :)
    real(rk), intent(inout) :: best
    integer, intent(inout) :: dof
    real(rk) :: size_now
    integer :: i

    do i = 1, size(rows, 1)
      size_now = norm2(rows(i, :))
      ! nodes alike within rounding: the first one, so that the choice is the same everywhere
      if (size_now <= best * (1 + tie_tolerance)) cycle
      best = size_now
      dof = n_before + i
    end do
  end subroutine compare

  !> Returns an orthonormal basis of the null space of a Gram matrix, a vector per column. Eigenvalues up to 1e-12 times the larger
  !> of 1 and the largest one count as zero: 1e-6 (dependent) in the motions.
  function null_space(gram) result(columns)
    !> symmetric, no negative eigenvalue, shape (n, n)
    real(rk), intent(in) :: gram(:, :)
    real(rk), allocatable :: columns(:, :)
    real(rk), allocatable :: u(:, :), s(:), vt(:, :)
    integer :: rank

    call svd(gram, u, s, vt)
    rank = 0
    ! motions have size 1, so that a Gram matrix far below 1 is rounding as a whole
    if (size(s) > 0) rank = count(s > dependent**2 * max(1.0_rk, s(1)))
    columns = transpose(vt(rank + 1:, :))
  end function null_space

  pure function outer(vector) result(matrix)
    real(rk), intent(in) :: vector(:)
    real(rk) :: matrix(size(vector), size(vector))

    matrix = spread(vector, 2, size(vector)) * spread(vector, 1, size(vector))
  end function outer
end module sig_rigid_bodies
