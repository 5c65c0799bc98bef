! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Displacements L that open or close each contact row by moving its own nodes alone, B L = 1, and their stiffness L' K L.
!>
!> A side moves along the free components of its coefficients, n_free / |n_free|^2. Where both sides can, the stiffer one moves
!> less, so that the energy is least; where a side has no free component, or meets other rows, too, the other one moves.
module sig_contact_lift
  use sig_contact_rows, only: contact_rows_t
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_lifted_error_bound, only: sparse_matrix_t
  use sig_mesh, only: cells_around_nodes, mesh_t
  use petsc
  implicit none(type, external)
  private
  public :: contact_lift_t

  !> [-] square of free components below which a side cannot move
  real(rk), parameter :: negligible = 1.0e-20_rk

  type :: contact_lift_t
    !> every row has a side that can move
    logical :: is_possible = .false.
    !> [-] L on the dofs of the rows, as contact_rows_t has them
    real(rk), allocatable :: values(:)
    !> [force/length] L' K L
    type(sparse_matrix_t) :: stiffness
  contains
    procedure :: create
  end type contact_lift_t

contains

  !> A few products with K. Collective; the same on all ranks.
  subroutine create(self, system, mesh, ierr)
    class(contact_lift_t), intent(out) :: self
    type(contact_system_t), intent(inout) :: system
    type(mesh_t), intent(in) :: mesh
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: energy(:), first(:), second(:)
    integer, allocatable :: colors(:)
    integer :: k
    real(rk) :: share

    ierr = 0
    associate (rows => system%rows, lift => self%stiffness)
      call move_sides(rows, mesh%n_nodes, system%boundary%is_prescribed, first, second)
      self%is_possible = all([(moves(rows, first, k) .or. moves(rows, second, k), k=1, rows%n_rows)])
      if (.not. self%is_possible) return
      call find_neighbors(rows, mesh, lift)
      colors = color_rows(lift)
      PetscCall(probe(system, first, colors, lift, ierr))
      energy = lift%diagonal()
      PetscCall(probe(system, second, colors, lift, ierr))
      associate (other => lift%diagonal())
        do k = 1, rows%n_rows
          share = merge(1.0_rk, 0.0_rk, moves(rows, first, k))
          if (moves(rows, first, k) .and. moves(rows, second, k)) share = other(k) / (energy(k) + other(k))
          associate (from => rows%offsets(k) + 1, to => rows%offsets(k + 1))
            first(from:to) = share * first(from:to) + (1 - share) * second(from:to)
          end associate
        end do
      end associate
      PetscCall(probe(system, first, colors, lift, ierr))
    end associate
    call move_alloc(first, self%values)
  end subroutine create

  !> Each side alone, where it can move.
  subroutine move_sides(rows, n_nodes, is_prescribed, first, second)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: n_nodes
    logical, intent(in) :: is_prescribed(:)
    !> [-] on the dofs of the rows; zero of a side that cannot
    real(rk), allocatable, intent(out) :: first(:), second(:)
    integer :: k, n(n_nodes)

    n = rows%rows_per_node(n_nodes)
    allocate (first(size(rows%dofs)), second(size(rows%dofs)), source=0.0_rk)
    do k = 1, rows%n_rows
      if (all(n(rows%first_nodes_of(k)) == 1)) call move(rows%offsets(k) + 1, rows%splits(k), first)
      if (all(n(rows%second_nodes_of(k)) == 1)) call move(rows%splits(k) + 1, rows%offsets(k + 1), second)
    end do

  contains

    !> n_free / |n_free|^2.
    subroutine move(from, to, values)
      integer, intent(in) :: from
      integer, intent(in) :: to
      real(rk), intent(inout) :: values(:)
      real(rk) :: square

      values(from:to) = merge(0.0_rk, rows%coefficients(from:to), is_prescribed(rows%dofs(from:to)))
      square = sum(values(from:to)**2)
      ! a component this small is rounding of a direction
      values(from:to) = merge(values(from:to) / max(square, tiny(square)), 0.0_rk, square > negligible)
    end subroutine move
  end subroutine move_sides

  pure logical function moves(rows, values, k)
    type(contact_rows_t), intent(in) :: rows
    real(rk), intent(in) :: values(:)
    integer, intent(in) :: k

    moves = any(abs(values(rows%offsets(k) + 1:rows%offsets(k + 1))) > 0)
  end function moves

  !> Rows that share a cell, as the places of L' K L that may differ from zero.
  subroutine find_neighbors(rows, mesh, lift)
    type(contact_rows_t), intent(in) :: rows
    type(mesh_t), intent(in) :: mesh
    !> without values
    type(sparse_matrix_t), intent(out) :: lift
    integer, allocatable :: cell_offsets(:), cells(:), rows_at(:, :)
    integer :: found(rows%n_rows), k, last_of(rows%n_rows), n

    call cells_around_nodes(mesh, cell_offsets, cells)
    call list_rows_at_nodes(rows, mesh%n_nodes, rows_at)
    allocate (lift%starts(rows%n_rows + 1), source=0)
    last_of = 0
    do k = 1, rows%n_rows
      call look_around(rows%nodes_of(k), k)
      lift%starts(k + 1) = lift%starts(k) + n
    end do
    allocate (lift%columns(lift%starts(rows%n_rows + 1)), source=0)
    allocate (lift%values(lift%starts(rows%n_rows + 1)), source=0.0_rk)
    last_of = 0
    do k = 1, rows%n_rows
      call look_around(rows%nodes_of(k), k)
      lift%columns(lift%starts(k) + 1:lift%starts(k + 1)) = found(:n)
    end do

  contains

    !> The first n of found are the rows at the cells around some nodes.
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

  !> Rows that meet each node, 0 beyond their number; shape (most rows of a node, n_nodes).
  pure subroutine list_rows_at_nodes(rows, n_nodes, rows_at)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: n_nodes
    integer, allocatable, intent(out) :: rows_at(:, :)
    integer, allocatable :: nodes(:)
    integer :: i, k, n(n_nodes)

    n = rows%rows_per_node(n_nodes)
    allocate (rows_at(max(1, maxval(n)), n_nodes), source=0)
    n = 0
    do k = 1, rows%n_rows
      nodes = rows%nodes_of(k)
      do i = 1, size(nodes)
        n(nodes(i)) = n(nodes(i)) + 1
        rows_at(n(nodes(i)), nodes(i)) = k
      end do
    end do
  end subroutine list_rows_at_nodes

  !> Colors such that no row has two neighbors of the same color, itself among them.
  pure function color_rows(lift) result(colors)
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

  !> L' K L by a product with K per color. Collective.
  subroutine probe(system, values, colors, lift, ierr)
    type(contact_system_t), intent(inout) :: system
    !> [-] L on the dofs of the rows
    real(rk), intent(in) :: values(:)
    integer, intent(in) :: colors(:)
    !> in: its places
    type(sparse_matrix_t), intent(inout) :: lift
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: field(system%map%n_dofs), forces(system%map%n_dofs)
    integer :: color, i, k

    ierr = 0
    associate (offsets => system%rows%offsets, dofs => system%rows%dofs)
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
