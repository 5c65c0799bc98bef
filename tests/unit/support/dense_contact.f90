! SPDX-License-Identifier: BSD-3-Clause
!> The contact problem (3) solved by brute force: every active set is tried with a dense system. For a handful of pairs.
module dense_contact
  use sig_boundary_conditions, only: boundary_conditions_t
  use sig_cell_stiffness, only: cell_dofs, cell_stiffness
  use sig_contact_rows, only: contact_rows_t
  use sig_elastic_body, only: elastic_body_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: solve_dense
  use sig_mesh, only: mesh_t
  implicit none(type, external)
  private
  public :: dense_stiffness, solve_by_enumeration, solve_closed

contains

  !> K on all dofs, cell by cell.
  function dense_stiffness(mesh, body) result(stiffness)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    real(rk) :: stiffness(mesh%n_dim * mesh%n_nodes, mesh%n_dim * mesh%n_nodes)
    integer :: i_cell

    stiffness = 0
    do i_cell = 1, mesh%n_cells
      associate (dofs => cell_dofs(mesh, i_cell))
        stiffness(dofs, dofs) = stiffness(dofs, dofs) + cell_stiffness(mesh, body, i_cell)
      end associate
    end do
  end function dense_stiffness

  !> The one of the 2**n_rows active sets whose solution meets all inequalities.
  subroutine solve_by_enumeration(stiffness, boundary, rows, theta, displacement, multipliers, is_found)
    !> [force/length] shape (n_dofs, n_dofs)
    real(rk), intent(in) :: stiffness(:, :)
    type(boundary_conditions_t), intent(in) :: boundary
    type(contact_rows_t), intent(in) :: rows
    real(rk), intent(in) :: theta(:)
    !> [length] shape (n_dofs)
    real(rk), allocatable, intent(out) :: displacement(:)
    !> [force] shape (n_rows)
    real(rk), allocatable, intent(out) :: multipliers(:)
    logical, intent(out) :: is_found
    !> [-] of the largest displacement and multiplier: rounding of dense solves
    real(rk), parameter :: rounding = 1.0e-10_rk
    integer :: i_set, i_row
    logical :: is_closed(rows%n_rows)

    allocate (displacement(size(stiffness, 1)), multipliers(rows%n_rows))
    do i_set = 0, 2**rows%n_rows - 1
      is_closed = [(btest(i_set, i_row - 1), i_row=1, rows%n_rows)]
      call solve_closed(stiffness, boundary, rows, theta, is_closed, displacement, multipliers)
      associate (opening => matmul(rows%gap, theta) - rows%apply(displacement))
        is_found = all(opening >= -rounding * maxval(abs(displacement))) .and. &
          all(multipliers >= -rounding * maxval(abs(multipliers)))
      end associate
      if (is_found) return
    end do
  end subroutine solve_by_enumeration

  !> K u + B' lambda = F on the free dofs, u = u_D on the others, B u = D on closed rows, lambda = 0 on open ones.
  subroutine solve_closed(stiffness, boundary, rows, theta, is_closed, displacement, multipliers)
    real(rk), intent(in) :: stiffness(:, :)
    type(boundary_conditions_t), intent(in) :: boundary
    type(contact_rows_t), intent(in) :: rows
    real(rk), intent(in) :: theta(:)
    logical, intent(in) :: is_closed(:)
    real(rk), intent(out) :: displacement(:)
    real(rk), intent(out) :: multipliers(:)
    real(rk), allocatable :: matrix(:, :), rhs(:), solution(:)
    integer :: i, k, n
    logical :: is_singular

    n = size(stiffness, 1)
    allocate (matrix(n + rows%n_rows, n + rows%n_rows), rhs(n + rows%n_rows), source=0.0_rk)
    allocate (solution(n + rows%n_rows))
    matrix(:n, :n) = stiffness
    rhs(:n) = boundary%loads%forces(theta, n)
    do k = 1, rows%n_rows
      associate (dofs => rows%dofs_of(k))
        matrix(dofs, n + k) = rows%coefficients_of(k)
        matrix(n + k, dofs) = rows%coefficients_of(k)
      end associate
      rhs(n + k) = dot_product(rows%gap(k, :), theta)
      if (is_closed(k)) cycle
      matrix(n + k, :) = 0
      matrix(n + k, n + k) = 1
      rhs(n + k) = 0
    end do
    do i = 1, size(boundary%prescribed_dofs)
      associate (dof => boundary%prescribed_dofs(i))
        matrix(dof, :) = 0
        matrix(dof, dof) = 1
        rhs(dof) = dot_product(boundary%prescribed_values(i, :), theta)
      end associate
    end do
    call solve_dense(matrix, rhs, solution, is_singular)
    displacement = solution(:n)
    multipliers = solution(n + 1:)
    if (is_singular) multipliers = -1
  end subroutine solve_closed
end module dense_contact
