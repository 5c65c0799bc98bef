! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Displacements L, one column per contact row, and their stiffness L' K L. Column k closes row k by 1 and no other row, B L = 1. It
!> moves only the nodes of this row and, where needed, owners of other rows that must follow (below).
!>
!> Of the first side only the owner moves, with the owners of other rows that must follow where these meet it (sig_side_motions). Of
!> the second side all nodes move, if no other row meets them. The motion is along the free components of the coefficients,
!> n_free / |n_free|^2. Where both sides can move, the stiffer one moves less; the energy is then least if K does not couple the
!> sides. Where a side cannot move, the other one moves alone.
module sig_contact_lift
  use sig_contact_rows, only: contact_rows_t
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_lifted_error_bound, only: sparse_matrix_t
  use sig_mesh, only: cells_around_nodes, mesh_t
  use sig_side_motions, only: find_followers, followers_t, following_motion, movable
  use petsc
  implicit none(type, external)
  private
  public :: contact_lift_t

  !> The matrix L, sparse by columns, and L' K L.
  type :: contact_lift_t
    !> whether every row has a side that can move
    logical :: is_possible = .false.
    !> [-] column k of L: values on dofs(starts(k) + 1:starts(k + 1)), natural
    integer, allocatable :: starts(:)
    integer, allocatable :: dofs(:)
    real(rk), allocatable :: values(:)
    !> [force/length] L' K L
    type(sparse_matrix_t) :: stiffness
  contains
    procedure :: create
  end type contact_lift_t

contains

  !> Computes L and L' K L by a few products with K; they are the same on all ranks. Column k of L is a displacement that closes
  !> contact row k by 1 and no other row. If a row has no side that can move so (head of this file), is_possible is false, and there
  !> are neither values of L nor L' K L. Collective.
  subroutine create(self, system, mesh, ierr)
    class(contact_lift_t), intent(out) :: self
    type(contact_system_t), intent(inout) :: system
    type(mesh_t), intent(in) :: mesh
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: energy(:), first(:), second(:)
    integer, allocatable :: colors(:)
    type(followers_t) :: followers
    integer :: k
    real(rk) :: share

    ierr = 0
    associate (rows => system%rows, lift => self%stiffness, is_prescribed => system%boundary%is_prescribed)
      call find_followers(rows, mesh%n_nodes, is_prescribed, followers)
      call list_dofs(rows, followers, self)
      call move_sides(rows, mesh%n_nodes, is_prescribed, followers, self, first, second)
      self%is_possible = all([(moves(self, first, k) .or. moves(self, second, k), k=1, rows%n_rows)])
      if (.not. self%is_possible) return
      call find_neighbors(self, mesh, lift)
      colors = color_rows(lift)
      PetscCall(probe(self, system, first, colors, lift, ierr))
      energy = lift%diagonal()
      PetscCall(probe(self, system, second, colors, lift, ierr))
      associate (other => lift%diagonal())
        do k = 1, rows%n_rows
          share = merge(1.0_rk, 0.0_rk, moves(self, first, k))
          if (moves(self, first, k) .and. moves(self, second, k)) share = other(k) / (energy(k) + other(k))
          associate (from => self%starts(k) + 1, to => self%starts(k + 1))
            first(from:to) = share * first(from:to) + (1 - share) * second(from:to)
          end associate
        end do
      end associate
      PetscCall(probe(self, system, first, colors, lift, ierr))
    end associate
    call move_alloc(first, self%values)
  end subroutine create

  !> Sets lift%starts and lift%dofs: for each row all its dofs, then those of the owners that must move with its owner so that
  !> other rows do not change (followers). The owner is the first node of a row (contact_rows_t).
  subroutine list_dofs(rows, followers, lift)
    type(contact_rows_t), intent(in) :: rows
    type(followers_t), intent(in) :: followers
    type(contact_lift_t), intent(inout) :: lift
    integer :: i, k, n

    n = size(rows%dofs) + rows%n_dim * size(followers%rows)
    allocate (lift%starts(rows%n_rows + 1), lift%dofs(n), source=0)
    n = 0
    do k = 1, rows%n_rows
      call take(rows%dofs_of(k))
      do i = followers%starts(k) + 1, followers%starts(k + 1)
        associate (first => rows%offsets(followers%rows(i)))
          call take(rows%dofs(first + 1:first + rows%n_dim))
        end associate
      end do
      lift%starts(k + 1) = n
    end do

  contains

    subroutine take(dofs)
      integer, intent(in) :: dofs(:)

      lift%dofs(n + 1:n + size(dofs)) = dofs
      n = n + size(dofs)
    end subroutine take
  end subroutine list_dofs

  !> Computes the motions that close each row by 1 and no other row: by its first side alone (the owner and its followers), and by
  !> its second side alone (all nodes of it, if no other row meets them).
  subroutine move_sides(rows, n_nodes, is_prescribed, followers, lift, first, second)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: n_nodes
    logical, intent(in) :: is_prescribed(:)
    type(followers_t), intent(in) :: followers
    !> of list_dofs
    type(contact_lift_t), intent(in) :: lift
    !> [-] on lift%dofs; zero for a side that cannot move
    real(rk), allocatable, intent(out) :: first(:), second(:)
    integer :: i, k, n(n_nodes)

    n = rows%rows_per_node(n_nodes)
    allocate (first(size(lift%dofs)), second(size(lift%dofs)), source=0.0_rk)
    do k = 1, rows%n_rows
      associate (from => lift%starts(k), n_first => rows%splits(k) - rows%offsets(k), &
        n_all => rows%offsets(k + 1) - rows%offsets(k))
        if (followers%is_possible(k)) then
          call move(rows%offsets(k) + 1, rows%offsets(k) + rows%n_dim, first(from + 1:from + rows%n_dim))
          do i = followers%starts(k) + 1, followers%starts(k + 1)
            associate (to => from + n_all + (i - followers%starts(k)) * rows%n_dim)
              first(to - rows%n_dim + 1:to) = following_motion(rows, followers%rows(i), is_prescribed, &
                (rows%dofs(rows%offsets(k) + 1) - 1) / rows%n_dim + 1, first(from + 1:from + rows%n_dim))
            end associate
          end do
        end if
        if (all(n(rows%second_nodes_of(k)) == 1)) call move(rows%splits(k) + 1, rows%offsets(k + 1), &
          second(from + n_first + 1:from + n_all))
      end associate
    end do

  contains

    !> n_free / |n_free|^2 of some entries of the rows; zero if |n_free|^2 is at most `movable`.
    subroutine move(from, to, values)
      integer, intent(in) :: from
      integer, intent(in) :: to
      real(rk), intent(out) :: values(:)
      real(rk) :: square

      values = merge(0.0_rk, rows%coefficients(from:to), is_prescribed(rows%dofs(from:to)))
      square = sum(values**2)
      values = merge(values / max(square, tiny(square)), 0.0_rk, square > movable)
    end subroutine move
  end subroutine move_sides

  !> Whether row k moves some node by these values.
  pure logical function moves(lift, values, k)
    type(contact_lift_t), intent(in) :: lift
    !> [-] on lift%dofs
    real(rk), intent(in) :: values(:)
    !> row, 1-based
    integer, intent(in) :: k

    moves = any(abs(values(lift%starts(k) + 1:lift%starts(k + 1))) > 0)
  end function moves

  !> Returns the nodes that a row may move: its own and its followers.
  pure function moved_nodes(lift, n_dim, k) result(nodes)
    type(contact_lift_t), intent(in) :: lift
    integer, intent(in) :: n_dim
    !> row, 1-based
    integer, intent(in) :: k
    integer, allocatable :: nodes(:)

    nodes = lift%dofs(lift%starts(k) + n_dim:lift%starts(k + 1):n_dim) / n_dim
  end function moved_nodes

  !> Finds for each row its neighbors: the rows, with itself, that may move a node of a cell of which it may move a node. Only for
  !> these can L' K L differ from zero.
  subroutine find_neighbors(motions, mesh, lift)
    !> of list_dofs
    type(contact_lift_t), intent(in) :: motions
    type(mesh_t), intent(in) :: mesh
    !> entries of L' K L that may differ from zero, without their values
    type(sparse_matrix_t), intent(out) :: lift
    integer, allocatable :: cell_offsets(:), cells(:), rows_at(:, :)
    integer :: found(size(motions%starts) - 1), k, last_of(size(motions%starts) - 1), n

    call cells_around_nodes(mesh, cell_offsets, cells)
    call list_rows_at_nodes(motions, mesh%n_dim, mesh%n_nodes, rows_at)
    allocate (lift%starts(size(found) + 1), source=0)
    last_of = 0
    do k = 1, size(found)
      call look_around(moved_nodes(motions, mesh%n_dim, k), k)
      lift%starts(k + 1) = lift%starts(k) + n
    end do
    allocate (lift%columns(lift%starts(size(found) + 1)), source=0)
    allocate (lift%values(lift%starts(size(found) + 1)), source=0.0_rk)
    last_of = 0
    do k = 1, size(found)
      call look_around(moved_nodes(motions, mesh%n_dim, k), k)
      lift%columns(lift%starts(k) + 1:lift%starts(k + 1)) = found(:n)
    end do

  contains

    !> Makes the first n of `found` the rows at the cells around some nodes.
    subroutine look_around(nodes, row)
      integer, intent(in) :: nodes(:)
      integer, intent(in) :: row
      integer :: i, j, node

      n = 0
      do node = 1, size(nodes)
        do i = cell_offsets(nodes(node)) + 1, cell_offsets(nodes(node) + 1)
          do j = mesh%cell_offsets(cells(i)) + 1, mesh%cell_offsets(cells(i) + 1)
            call visit(rows_at(:, mesh%cell_nodes(j)), row)
          end do
        end do
      end do
    end subroutine look_around

    subroutine visit(others, row)
      integer, intent(in) :: others(:)
      integer, intent(in) :: row
      integer :: i

      do i = 1, size(others)
        if (others(i) == 0) cycle
        if (last_of(others(i)) == row) cycle
        last_of(others(i)) = row
        n = n + 1
        found(n) = others(i)
      end do
    end subroutine visit
  end subroutine find_neighbors

  !> Lists for each node the rows that may move it, 1-based, filled up with 0; shape (largest number of rows of a node, n_nodes).
  pure subroutine list_rows_at_nodes(motions, n_dim, n_nodes, rows_at)
    type(contact_lift_t), intent(in) :: motions
    integer, intent(in) :: n_dim
    integer, intent(in) :: n_nodes
    integer, allocatable, intent(out) :: rows_at(:, :)
    integer, allocatable :: nodes(:)
    integer :: i, k, n(n_nodes)

    n = 0
    do i = n_dim, size(motions%dofs), n_dim
      n(motions%dofs(i) / n_dim) = n(motions%dofs(i) / n_dim) + 1
    end do
    allocate (rows_at(max(1, maxval(n)), n_nodes), source=0)
    n = 0
    do k = 1, size(motions%starts) - 1
      nodes = moved_nodes(motions, n_dim, k)
      do i = 1, size(nodes)
        n(nodes(i)) = n(nodes(i)) + 1
        rows_at(n(nodes(i)), nodes(i)) = k
      end do
    end do
  end subroutine list_rows_at_nodes

  !> Returns a color of each row, 1-based, such that no row has two neighbors of the same color; each row is its own neighbor, too.
  pure function color_rows(lift) result(colors)
    !> of find_neighbors
    type(sparse_matrix_t), intent(in) :: lift
    integer :: colors(size(lift%starts) - 1)
    integer :: i, j, k, taken_by(size(colors))

    colors = 0
    taken_by = 0
    do k = 1, size(colors)
      do i = lift%starts(k) + 1, lift%starts(k + 1)
        associate (near => lift%columns(i))
          do j = lift%starts(near) + 1, lift%starts(near + 1)
            if (colors(lift%columns(j)) > 0) taken_by(colors(lift%columns(j))) = k
          end do
        end associate
      end do
      colors(k) = 1
      do while (taken_by(colors(k)) == k)
        colors(k) = colors(k) + 1
      end do
    end do
  end function color_rows

  !> Computes L' K L by one product with K per color. Collective.
  subroutine probe(motions, system, values, colors, lift, ierr)
    !> of list_dofs
    type(contact_lift_t), intent(in) :: motions
    type(contact_system_t), intent(inout) :: system
    !> [-] L on motions%dofs
    real(rk), intent(in) :: values(:)
    !> of color_rows, shape (n_rows)
    integer, intent(in) :: colors(:)
    !> in: L' K L of find_neighbors; out: with its values
    type(sparse_matrix_t), intent(inout) :: lift
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: field(system%map%n_dofs), forces(system%map%n_dofs)
    integer :: color, i, k

    ierr = 0
    associate (offsets => motions%starts, dofs => motions%dofs)
      do color = 1, maxval([0, colors])
        field = 0
        do k = 1, size(colors)
          if (colors(k) /= color) cycle
          do i = offsets(k) + 1, offsets(k + 1)
            field(dofs(i)) = field(dofs(i)) + values(i)
          end do
        end do
        PetscCall(system%apply_stiffness(field, forces, ierr))
        do k = 1, size(colors)
          do i = lift%starts(k) + 1, lift%starts(k + 1)
            if (colors(lift%columns(i)) == color) lift%values(i) = &
              dot_product(values(offsets(k) + 1:offsets(k + 1)), forces(dofs(offsets(k) + 1:offsets(k + 1))))
          end do
        end do
      end do
    end associate
  end subroutine probe
end module sig_contact_lift
