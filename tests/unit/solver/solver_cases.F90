! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The contact problems that the solvers' tests share, with answers from formulas or from the dense enumeration.
module solver_cases
  use dense_contact, only: dense_stiffness, solve_by_enumeration
  use sig_boundary_conditions, only: boundary_conditions_t
  use sig_contact_rows, only: contact_rows_t, create_contact_rows
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_elastic_body, only: create_elastic_body, elastic_body_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_node_pair_rows, only: create_node_pair_rows
  use sig_node_pairs, only: node_pairs_t
  use sig_petsc_support, only: create_matrix
  use stacked_blocks, only: node_at, prescribe, stack_mesh, stack_pairs, stack_t
  use petsc
  implicit none(type, external)
  private
  public :: case_t, create_bars, create_corners, create_oblique, create_patches, create_sandwich
  public :: create_loose, create_rider, create_small
  public :: bar_state, pressure_of_bars

  !> A system, and what it was made of.
  type :: case_t
    type(stack_t) :: stack
    type(mesh_t) :: mesh
    type(elastic_body_t) :: body
    type(node_pairs_t) :: pairs
    type(contact_system_t) :: system
  contains
    procedure :: reference
    procedure :: dense
  end type case_t

  !> [force/length**2] of the blocks, from below
  real(rk), parameter :: young_moduli(3) = [10.0_rk, 20.0_rk, 40.0_rk]

contains

  !> Column of bars 4 wide and 2 high, 0.1 apart, nu = 0; base held, top driven down by theta_2. Collective on comm.
  subroutine create_bars(comm, case, ierr)
    MPI_Comm, intent(in) :: comm
    type(case_t), intent(out) :: case
    PetscErrorCode, intent(out) :: ierr
    type(boundary_conditions_t) :: boundary

    PetscCall(start(stack_t(n_x=4, n_y=2, n_blocks=2, gap=0.1_rk), 0.0_rk, [0.0_rk, 1.0_rk], case, ierr))
    call hold_ends(case, boundary)
    PetscCall(finish(comm, boundary, case, ierr))
  end subroutine create_bars

  !> Three bars; u_x = 0 on their left sides, so that only contact holds the middle one in y. Collective on comm.
  subroutine create_sandwich(comm, case, ierr)
    MPI_Comm, intent(in) :: comm
    type(case_t), intent(out) :: case
    PetscErrorCode, intent(out) :: ierr
    type(boundary_conditions_t) :: boundary
    integer :: j

    PetscCall(start(stack_t(n_x=2, n_y=2, n_blocks=3, gap=0.1_rk), 0.0_rk, [0.0_rk, 1.0_rk], case, ierr))
    call hold_ends(case, boundary)
    call prescribe(boundary, case%mesh, [(node_at(case%stack, 2, 0, j), j=0, 2)], 1, 0.0_rk, 0.0_rk)
    PetscCall(finish(comm, boundary, case, ierr))
  end subroutine create_sandwich

  !> Two bars of which nothing holds the upper one in x. Collective on comm.
  subroutine create_loose(comm, case, ierr)
    MPI_Comm, intent(in) :: comm
    type(case_t), intent(out) :: case
    PetscErrorCode, intent(out) :: ierr
    type(boundary_conditions_t) :: boundary
    integer :: i

    PetscCall(start(stack_t(n_x=4, n_y=2, n_blocks=2, gap=0.1_rk), 0.3_rk, [0.0_rk, 1.0_rk], case, ierr))
    call prescribe(boundary, case%mesh, [(node_at(case%stack, 1, i, 0), i=0, 4)], 1, 0.0_rk, 0.0_rk)
    call prescribe(boundary, case%mesh, [(node_at(case%stack, 1, i, 0), i=0, 4)], 2, 0.0_rk, 0.0_rk)
    call prescribe(boundary, case%mesh, [(node_at(case%stack, 2, i, 2), i=0, 4)], 2, 0.0_rk, -1.0_rk)
    PetscCall(finish(comm, boundary, case, ierr))
    ! a system holds such a body where no load drives it; here nothing does
    deallocate (case%system%motions%idle%supports)
    allocate (case%system%motions%idle%supports(0))
    case%system%boundary = boundary
  end subroutine create_loose

  !> A block on another one, which is clamped at its base. Of the upper one a single dof is held, u_x in the middle of its foot:
  !> contact must hold its height and its tilt. Forces on the corners of its top: 1 downward on the left, theta_2 on the right.
  !> Uneven gaps. Collective on comm.
  subroutine create_rider(comm, case, ierr)
    MPI_Comm, intent(in) :: comm
    type(case_t), intent(out) :: case
    PetscErrorCode, intent(out) :: ierr
    type(boundary_conditions_t) :: boundary
    integer :: i

    PetscCall(start(stack_t(n_x=4, n_y=2, n_blocks=2, gap=0.1_rk), 0.3_rk, [0.0_rk, 1.0_rk], case, ierr))
    case%pairs%initial_gap = [0.02_rk, 0.05_rk, 0.0_rk, 0.03_rk, 0.1_rk]
    associate (s => case%stack)
      call prescribe(boundary, case%mesh, [(node_at(s, 1, i, 0), i=0, s%n_x)], 1, 0.0_rk, 0.0_rk)
      call prescribe(boundary, case%mesh, [(node_at(s, 1, i, 0), i=0, s%n_x)], 2, 0.0_rk, 0.0_rk)
      call prescribe(boundary, case%mesh, [node_at(s, 2, 2, 0)], 1, 0.0_rk, 0.0_rk)
      boundary%loads%dofs = 2 * [node_at(s, 2, 0, s%n_y), node_at(s, 2, s%n_x, s%n_y)]
    end associate
    boundary%loads%terms = [1, 2]
    boundary%loads%values = [-1.0_rk, -1.0_rk]
    PetscCall(finish(comm, boundary, case, ierr))
  end subroutine create_rider

  !> Three pairs whose first nodes move in y only, coupled by a given matrix: K of these three dofs. Everything else is held.
  subroutine create_small(stiffness, gaps, case, ierr)
    real(rk), intent(in) :: stiffness(3, 3)
    !> [length] of the pairs
    real(rk), intent(in) :: gaps(3)
    type(case_t), intent(out) :: case
    PetscErrorCode, intent(out) :: ierr
    type(boundary_conditions_t) :: boundary
    integer, allocatable :: room(:)
    integer :: i, j, free_0(3)

    PetscCall(start(stack_t(n_x=2, n_y=1, n_blocks=2, gap=0.1_rk), 0.0_rk, [0.0_rk, 1.0_rk], case, ierr))
    case%pairs%initial_gap = gaps
    call hold_ends(case, boundary)
    call prescribe(boundary, case%mesh, [(node_at(case%stack, 1, i, 1), i=0, 2)], 1, 0.0_rk, 0.0_rk)
    call prescribe(boundary, case%mesh, [(node_at(case%stack, 2, i, 0), i=0, 2)], 1, 0.0_rk, 0.0_rk)
    call prescribe(boundary, case%mesh, [(node_at(case%stack, 2, i, 0), i=0, 2)], 2, 0.0_rk, 0.0_rk)
    PetscCall(finish(PETSC_COMM_SELF, boundary, case, ierr))
    PetscCall(MatDestroy(case%system%stiffness, ierr))
    allocate (room(case%mesh%n_nodes), source=case%mesh%n_nodes)
    PetscCall(create_matrix(PETSC_COMM_SELF, 2 * size(room), 2, room, 0 * room, case%system%stiffness, ierr))
    free_0 = [(2 * node_at(case%stack, 1, i, 1), i=0, 2)]
    free_0 = case%system%map%distributed_0(free_0)
    ! multigrid needs blocks of a node's dofs, and no zero on the diagonal
    do i = 0, 2 * size(room) - 1
      do j = 0, 2 * size(room) - 1
        PetscCall(MatSetValue(case%system%stiffness, i, j, merge(1.0_rk, 0.0_rk, i == j .and. all(free_0 /= i)), ADD_VALUES, ierr))
      end do
    end do
    PetscCall(MatSetValues(case%system%stiffness, 3, free_0, 3, free_0, stiffness, ADD_VALUES, ierr))
    PetscCall(MatAssemblyBegin(case%system%stiffness, MAT_FINAL_ASSEMBLY, ierr))
    PetscCall(MatAssemblyEnd(case%system%stiffness, MAT_FINAL_ASSEMBLY, ierr))
    PetscCall(MatSetOption(case%system%stiffness, MAT_SYMMETRIC, PETSC_TRUE, ierr))
  end subroutine create_small

  !> Blocks with Poisson's effect, nodes off the grid, another gap at each pair, direction (0.28, 0.96); of two pairs one side
  !> is prescribed, of the first one in x only; the third first node faces an obstacle. Every reflection differs from a swap of
  !> unknowns. Collective on comm.
  subroutine create_oblique(comm, case, ierr)
    MPI_Comm, intent(in) :: comm
    type(case_t), intent(out) :: case
    PetscErrorCode, intent(out) :: ierr
    type(boundary_conditions_t) :: boundary

    call hold_oblique(case, boundary, ierr)
    case%pairs%initial_gap = [0.05_rk, 0.12_rk, 0.01_rk, 0.02_rk, 0.35_rk]
    case%pairs%second_node(3) = 0
    PetscCall(finish(comm, boundary, case, ierr))
  end subroutine create_oblique

  !> Mesh, bodies and supports of the oblique blocks. Local.
  subroutine hold_oblique(case, boundary, ierr)
    type(case_t), intent(out) :: case
    type(boundary_conditions_t), intent(out) :: boundary
    PetscErrorCode, intent(out) :: ierr

    PetscCall(start(stack_t(n_x=4, n_y=2, n_blocks=2, gap=0.1_rk), 0.35_rk, [0.28_rk, 0.96_rk], case, ierr))
    case%mesh%coordinates(1, :) = case%mesh%coordinates(1, :) + 0.1_rk * sin(3 * case%mesh%coordinates(2, :))
    call hold_ends(case, boundary)
    call prescribe(boundary, case%mesh, [node_at(case%stack, 1, 0, 2)], 1, 0.01_rk, 0.0_rk)
    call prescribe(boundary, case%mesh, [node_at(case%stack, 2, 3, 0)], 1, 0.0_rk, 0.1_rk)
    call prescribe(boundary, case%mesh, [node_at(case%stack, 2, 3, 0)], 2, 0.0_rk, -0.9_rk)
  end subroutine hold_oblique

  !> The oblique blocks, but each of the five nodes below faces unequal shares of two or three nodes above, which several rows
  !> meet; the third one faces an obstacle. Collective on comm.
  subroutine create_patches(comm, case, ierr)
    MPI_Comm, intent(in) :: comm
    type(case_t), intent(out) :: case
    PetscErrorCode, intent(out) :: ierr
    integer, parameter :: n_second(5) = [2, 3, 0, 2, 2]
    integer, parameter :: columns(14) = [0, 0, 1, 1, 0, 1, 2, 2, 3, 3, 4, 4, 3, 4]
    real(rk), parameter :: shares(14) = [-1.0_rk, 0.7_rk, 0.3_rk, -1.0_rk, 0.2_rk, 0.5_rk, 0.3_rk, -1.0_rk, -1.0_rk, 0.7_rk, &
      0.3_rk, -1.0_rk, 0.4_rk, 0.6_rk]
    real(rk), parameter :: normal(2) = [0.28_rk, 0.96_rk]

    PetscCall(create_with_rows(comm, case, spread(1, 1, 5), n_second, columns, shares > 0, spread(normal, 2, size(shares)) * spread(-shares, 1, 2), ierr))
  end subroutine create_patches

  !> The oblique blocks, with the second and the fourth node below as middles of the sides of quadratic faces, between the first and
  !> the third, and the third and the fifth: their rows have part of these corners, and another normal. Nodes above are met by a
  !> corner's row alone, by rows of both kinds, or by none. Collective on comm.
  subroutine create_corners(comm, case, ierr)
    MPI_Comm, intent(in) :: comm
    type(case_t), intent(out) :: case
    PetscErrorCode, intent(out) :: ierr
    integer, parameter :: n_first(5) = [1, 3, 1, 3, 1], n_second(5) = [2, 2, 1, 0, 2]
    !> a share above is negative
    integer, parameter :: columns(16) = [0, 0, 1, 1, 0, 2, 1, 2, 2, 2, 3, 2, 4, 4, 3, 4]
    real(rk), parameter :: weights(16) = [1.0_rk, -0.7_rk, -0.3_rk, 5.0_rk / 3, -1.0_rk / 3, -1.0_rk / 3, -1.2_rk, 0.2_rk, 1.0_rk, &
      -1.0_rk, 5.0_rk / 3, -1.0_rk / 3, -1.0_rk / 3, 1.0_rk, -0.4_rk, -0.6_rk]
    logical, parameter :: is_above(16) = [.false., .true., .true., .false., .false., .false., .true., .true., .false., .true., &
      .false., .false., .false., .false., .true., .true.]
    real(rk), parameter :: normals(2, 2) = reshape([0.28_rk, 0.96_rk, -0.6_rk, 0.8_rk], [2, 2])
    integer, parameter :: of_row(16) = [1, 1, 1, 2, 2, 2, 2, 2, 1, 1, 2, 2, 2, 1, 1, 1]

    PetscCall(create_with_rows(comm, case, n_first, n_second, columns, is_above, normals(:, of_row) * spread(weights, 1, 2), ierr))
  end subroutine create_corners

  !> The oblique blocks with other rows: of the nodes of each row the column, above the interface or below it, and their part of B.
  !> Collective on comm.
  subroutine create_with_rows(comm, case, n_first, n_second, columns, is_above, weights, ierr)
    MPI_Comm, intent(in) :: comm
    type(case_t), intent(out) :: case
    !> shape (5)
    integer, intent(in) :: n_first(:), n_second(:)
    integer, intent(in) :: columns(:)
    logical, intent(in) :: is_above(:)
    !> [-] shape (2, size(columns))
    real(rk), intent(in) :: weights(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(boundary_conditions_t) :: boundary
    type(contact_rows_t) :: rows
    real(rk) :: gap(5, 2)
    integer :: i

    call hold_oblique(case, boundary, ierr)
    gap = 0
    gap(:, 1) = [0.05_rk, 0.12_rk, 0.01_rk, 0.02_rk, 0.15_rk]
    call create_contact_rows(n_first, n_second, [(node_at(case%stack, merge(2, 1, is_above(i)), columns(i), &
      merge(0, 2, is_above(i))), i=1, size(columns))], weights, gap, spread(1.0_rk, 1, 5), spread(1, 1, 5), rows)
    PetscCall(case%system%create(comm, case%mesh, case%body, boundary, rows, ierr))
  end subroutine create_with_rows

  !> Mesh, bodies and pairs. Local, but a step of a create procedure.
  subroutine start(stack, poisson_ratio, direction, case, ierr)
    type(stack_t), intent(in) :: stack
    real(rk), intent(in) :: poisson_ratio
    real(rk), intent(in) :: direction(2)
    type(case_t), intent(inout) :: case
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: block_of_cell(:)
    integer :: i

    ierr = 0
    case%stack = stack
    call stack_mesh(stack, case%mesh)
    block_of_cell = [((case%mesh%cell_nodes(case%mesh%cell_offsets(i) + 1) - 1) / ((stack%n_x + 1) * (stack%n_y + 1)) + 1, &
      i=1, case%mesh%n_cells)]
    call create_elastic_body('plane_strain', young_moduli, spread(poisson_ratio, 1, 3), block_of_cell, case%body)
    call stack_pairs(stack, case%mesh, direction, case%pairs)
  end subroutine start

  !> Base at rest; top driven by (0, -theta_2).
  subroutine hold_ends(case, boundary)
    type(case_t), intent(in) :: case
    type(boundary_conditions_t), intent(inout) :: boundary
    integer :: i

    associate (s => case%stack)
      call prescribe(boundary, case%mesh, [(node_at(s, 1, i, 0), i=0, s%n_x)], 1, 0.0_rk, 0.0_rk)
      call prescribe(boundary, case%mesh, [(node_at(s, 1, i, 0), i=0, s%n_x)], 2, 0.0_rk, 0.0_rk)
      call prescribe(boundary, case%mesh, [(node_at(s, s%n_blocks, i, s%n_y), i=0, s%n_x)], 1, 0.0_rk, 0.0_rk)
      call prescribe(boundary, case%mesh, [(node_at(s, s%n_blocks, i, s%n_y), i=0, s%n_x)], 2, 0.0_rk, -1.0_rk)
    end associate
  end subroutine hold_ends

  subroutine finish(comm, boundary, case, ierr)
    MPI_Comm, intent(in) :: comm
    type(boundary_conditions_t), intent(in) :: boundary
    type(case_t), intent(inout) :: case
    PetscErrorCode, intent(out) :: ierr
    type(contact_rows_t) :: rows

    ierr = 0
    call create_node_pair_rows(case%pairs, spread(1.0_rk, 1, case%pairs%n_pairs), boundary%n_terms, rows)
    PetscCall(case%system%create(comm, case%mesh, case%body, boundary, rows, ierr))
  end subroutine finish

  !> p = (push - all gaps) / (sum of height / E), 0 while a gap is open.
  pure real(rk) function pressure_of_bars(case, push) result(pressure)
    type(case_t), intent(in) :: case
    real(rk), intent(in) :: push

    associate (s => case%stack)
      pressure = max(0.0_rk, push - (s%n_blocks - 1) * s%gap) / sum(s%n_y / young_moduli(:s%n_blocks))
    end associate
  end function pressure_of_bars

  !> Displacement and nodal forces of bars under that pressure; each bar is compressed onto the one below.
  function bar_state(case, push) result(state)
    type(case_t), intent(in) :: case
    real(rk), intent(in) :: push
    type(contact_state_t) :: state
    real(rk) :: foot, pressure
    integer :: i, i_block, j, node

    pressure = pressure_of_bars(case, push)
    associate (s => case%stack)
      allocate (state%displacement(2 * case%mesh%n_nodes), source=0.0_rk)
      foot = 0
      do i_block = 1, s%n_blocks
        ! the foot of a bar comes down by the gap and by what is below; without contact the top bar moves as a whole
        if (i_block > 1) foot = foot - s%gap
        if (pressure <= 0 .and. i_block == s%n_blocks) foot = -push
        do j = 0, s%n_y
          do i = 0, s%n_x
            node = node_at(s, i_block, i, j)
            state%displacement(2 * node) = foot - pressure * j / young_moduli(i_block)
          end do
        end do
        foot = foot - pressure * s%n_y / young_moduli(i_block)
      end do
      state%multipliers = pressure * [((merge(0.5_rk, 1.0_rk, i == 0 .or. i == s%n_x), i=0, s%n_x), j=2, s%n_blocks)]
    end associate
  end function bar_state

  function dense(self) result(stiffness)
    class(case_t), intent(in) :: self
    real(rk), allocatable :: stiffness(:, :)

    stiffness = dense_stiffness(self%mesh, self%body)
  end function dense

  !> Answer of the enumeration; displacement unallocated where no active set fits.
  function reference(self, theta) result(state)
    class(case_t), intent(in) :: self
    real(rk), intent(in) :: theta(:)
    type(contact_state_t) :: state
    logical :: is_found

    call solve_by_enumeration(self%dense(), self%system%boundary, self%system%rows, theta, state%displacement, &
      state%multipliers, is_found)
    if (.not. is_found) deallocate (state%displacement)
  end function reference
end module solver_cases
