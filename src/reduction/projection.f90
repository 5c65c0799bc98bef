! SPDX-License-Identifier: BSD-3-Clause
!> The blocks of the hyper-reduced system (10): stiffness, load and contact rows on the reduced integration domain, projected on the
!> basis.
module sig_projection
  use sig_cell_stiffness, only: cell_dofs, cell_stiffness
  use sig_contact_rows, only: contact_rows_t
  use sig_elastic_body, only: elastic_body_t
  use sig_kinds, only: rk
  use sig_load_pattern, only: load_pattern_t
  use sig_mesh, only: mesh_t
  use sig_reduced_domain, only: reduced_domain_t
  use sig_shape_checks, only: place_in_ascending
  implicit none(type, external)
  private
  public :: projected_blocks_t, project, project_part, project_contact_rows, expected_stiffness_rank

  !> reduced_stiffness * gamma + contact_matrix' * lambda = load * theta, contact_matrix * gamma <= gap * theta, lambda >= 0.
  type :: projected_blocks_t
    !> [force/length] shape (n_modes, n_modes); not symmetric where the domain is not the whole mesh
    real(rk), allocatable :: reduced_stiffness(:, :)
    !> [force] per term, shape (n_modes, n_terms)
    real(rk), allocatable :: load(:, :)
    !> [-] shape (n_rows, n_modes)
    real(rk), allocatable :: contact_matrix(:, :)
    !> [length] per term, shape (n_rows, n_terms)
    real(rk), allocatable :: gap(:, :)
  end type projected_blocks_t

contains

  !> Computes the blocks of (10) for the displacement = lifting * theta + basis * gamma.
  !>
  !> With the sets A, I, A_c and A_lambda of the domain, the stiffness is V[A]' K[A, A+I] V[A+I], the load is V[A]' (F[A] - K[A,
  !> A+I] lifting), the contact matrix is B[A_lambda, A_c] V[A_c], and the gap is D[A_lambda] - B[A_lambda, :] lifting. Source:
  !> (10). Local. Cost: size of the domain times (n_modes + n_terms) * n_modes.
  subroutine project(mesh, body, rows, loads, domain, basis, lifting, lifted_terms, blocks)
    type(mesh_t), intent(in) :: mesh
    !> materials of all cells, which give K
    type(elastic_body_t), intent(in) :: body
    type(contact_rows_t), intent(in) :: rows
    !> F: nodal forces of loads and imposed strains per term
    type(load_pattern_t), intent(in) :: loads
    type(reduced_domain_t), intent(in) :: domain
    !> V, shape (n_dofs, n_modes)
    real(rk), intent(in) :: basis(:, :)
    !> [length] displacement per lifted term, shape (n_dofs, n_lifted_terms)
    real(rk), intent(in) :: lifting(:, :)
    !> numbers of the terms that have a lifting, shape (n_lifted_terms)
    integer, intent(in) :: lifted_terms(:)
    type(projected_blocks_t), intent(out) :: blocks
    real(rk), allocatable :: tests(:, :), lifted(:, :)
    integer :: i

    tests = transpose(basis(domain%interior_dofs, :))
    blocks%reduced_stiffness = matmul(tests, stiffness_rows(mesh, body, domain, basis))
    allocate (blocks%load(size(basis, 2), size(rows%gap, 2)), source=0.0_rk)
    lifted = -matmul(tests, stiffness_rows(mesh, body, domain, lifting))
    do i = 1, size(lifted_terms)
      blocks%load(:, lifted_terms(i)) = blocks%load(:, lifted_terms(i)) + lifted(:, i)
    end do
    do i = 1, loads%n_entries()
      if (place_in_ascending(domain%interior_dofs, loads%dofs(i)) == 0) cycle
      blocks%load(:, loads%terms(i)) = blocks%load(:, loads%terms(i)) + basis(loads%dofs(i), :) * loads%values(i)
    end do
    blocks%contact_matrix = project_contact_rows(rows, domain, basis)
    blocks%gap = project_gap(rows, domain, lifting, lifted_terms)
  end subroutine project

  !> Computes what one part K_q of the stiffness adds to (10) per unit of its modulus: V[A]' K_q V to the stiffness, and -V[A]' K_q
  !> lifting to the load. Local.
  subroutine project_part(mesh, body, domain, basis, lifting, stiffness, load)
    type(mesh_t), intent(in) :: mesh
    !> materials of all cells with which the stiffness is K_q: the modulus of the part is 1, all other moduli are 0
    type(elastic_body_t), intent(in) :: body
    type(reduced_domain_t), intent(in) :: domain
    !> V, shape (n_dofs, n_modes)
    real(rk), intent(in) :: basis(:, :)
    !> [length] shape (n_dofs, n_lifted_terms)
    real(rk), intent(in) :: lifting(:, :)
    !> [length] column by column, shape (n_modes**2)
    real(rk), intent(out) :: stiffness(:)
    !> [length**2] column by column, shape (n_modes * n_lifted_terms)
    real(rk), intent(out) :: load(:)
    real(rk), allocatable :: tests(:, :)

    tests = transpose(basis(domain%interior_dofs, :))
    stiffness = reshape(matmul(tests, stiffness_rows(mesh, body, domain, basis)), shape(stiffness))
    load = -reshape(matmul(tests, stiffness_rows(mesh, body, domain, lifting)), shape(load))
  end subroutine project_part

  !> Returns K[A, A+I] * fields[A+I, :], in the order of domain%interior_dofs, shape (size of A, n_fields).
  !>
  !> The sum over the cells of the domain is complete, because all cells around a dof of A belong to the domain.
  function stiffness_rows(mesh, body, domain, fields) result(rows)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(reduced_domain_t), intent(in) :: domain
    !> [length], or [-] for modes, shape (n_dofs, n_fields)
    real(rk), intent(in) :: fields(:, :)
    !> [force], or [force/length] for modes
    real(rk), allocatable :: rows(:, :)
    real(rk), allocatable :: forces(:, :)
    integer, allocatable :: dofs(:)
    integer :: i_cell, i_dof, i_row

    allocate (rows(size(domain%interior_dofs), size(fields, 2)), source=0.0_rk)
    do i_cell = 1, size(domain%cells)
      dofs = cell_dofs(mesh, domain%cells(i_cell))
      forces = matmul(cell_stiffness(mesh, body, domain%cells(i_cell)), fields(dofs, :))
      do i_dof = 1, size(dofs)
        i_row = place_in_ascending(domain%interior_dofs, dofs(i_dof))
        if (i_row > 0) rows(i_row, :) = rows(i_row, :) + forces(i_dof, :)
      end do
    end do
  end function stiffness_rows

  !> Returns the contact rows of the domain projected on the basis, B[A_lambda, A_c] V[A_c], shape (size of A_lambda, n_modes).
  !> Source: (10), (11).
  pure function project_contact_rows(rows, domain, basis) result(contact_matrix)
    type(contact_rows_t), intent(in) :: rows
    type(reduced_domain_t), intent(in) :: domain
    !> V, shape (n_dofs, n_modes)
    real(rk), intent(in) :: basis(:, :)
    !> [-]
    real(rk) :: contact_matrix(size(domain%contact_rows), size(basis, 2))
    integer :: i_entry, i_row

    contact_matrix = 0
    do i_row = 1, size(domain%contact_rows)
      associate (row => domain%contact_rows(i_row))
        do i_entry = rows%offsets(row) + 1, rows%offsets(row + 1)
          if (place_in_ascending(domain%contact_dofs, rows%dofs(i_entry)) == 0) cycle
          contact_matrix(i_row, :) = contact_matrix(i_row, :) + rows%coefficients(i_entry) * basis(rows%dofs(i_entry), :)
        end do
      end associate
    end do
  end function project_contact_rows

  !> Returns the gaps under the lifting, D[A_lambda] - B[A_lambda, :] lifting, shape (size of A_lambda, n_terms).
  pure function project_gap(rows, domain, lifting, lifted_terms) result(gap)
    type(contact_rows_t), intent(in) :: rows
    type(reduced_domain_t), intent(in) :: domain
    !> [length] of the lifted terms, shape (n_dofs, n_lifted_terms)
    real(rk), intent(in) :: lifting(:, :)
    !> as in project
    integer, intent(in) :: lifted_terms(:)
    !> [length]
    real(rk) :: gap(size(domain%contact_rows), size(rows%gap, 2)), closing(size(lifted_terms))
    integer :: i, i_row, row

    gap = rows%gap(domain%contact_rows, :)
    do i_row = 1, size(domain%contact_rows)
      row = domain%contact_rows(i_row)
      closing = matmul(rows%coefficients_of(row), lifting(rows%dofs_of(row), :))
      do i = 1, size(closing)
        gap(i_row, lifted_terms(i)) = gap(i_row, lifted_terms(i)) - closing(i)
      end do
    end do
  end function project_gap

  !> Returns the largest rank that the reduced stiffness can have if the modes are combinations of snapshots in equilibrium. Then K
  !> V is zero at all dofs of A without a force, and each independent force adds at most one to the rank.
  !>
  !> Both sides of a contact row carry opposite forces, so a row counts once. A hat function is not in equilibrium and counts once.
  !> The rank is at most the number of modes.
  pure integer function expected_stiffness_rank(domain, driven_dofs, n_patterns, n_hats, n_modes) result(rank)
    type(reduced_domain_t), intent(in) :: domain
    !> loaded dofs, and prescribed dofs on which the basis is not zero; natural (order of the mesh file)
    integer, intent(in) :: driven_dofs(:)
    !> number of force fields that act on whole regions: imposed strains, one per term
    integer, intent(in) :: n_patterns
    integer, intent(in) :: n_hats
    integer, intent(in) :: n_modes
    integer :: i_dof

    rank = size(domain%contact_rows) + n_patterns + n_hats
    do i_dof = 1, size(driven_dofs)
      if (place_in_ascending(domain%interior_dofs, driven_dofs(i_dof)) > 0) rank = rank + 1
    end do
    rank = min(rank, n_modes)
  end function expected_stiffness_rank
end module sig_projection
