! SPDX-License-Identifier: BSD-3-Clause
!> Prescribed displacements as equations on the reduced coordinates, for a basis of whole fields (`dirichlet: multiplier`).
module sig_dirichlet_rows
  use sig_kinds, only: rk
  use sig_singular_values, only: svd
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: impose_dirichlet_rows

contains

  !> Divides the reduced coordinates gamma into a part that the prescribed displacements fix and a part that stays free.
  !>
  !> The prescribed displacements are the equations C gamma = g theta with C = V[dofs, :]. Their solutions are gamma = C^+ g theta +
  !> Z z, where the columns of Z are orthonormal and C Z = 0. The problem on the basis V Z with the lifting V C^+ g has no
  !> prescribed rows, and its solution is the same as with multipliers for these rows. Dependent rows (both ends of a symmetric
  !> body, a fixed component that no mode moves) are left out: only `rank` rows count. Values that no combination of the modes takes
  !> are met in the sense of least squares, without an error. Local.
  subroutine impose_dirichlet_rows(basis, dofs, values, rank_tolerance, free_basis, lifting, rank)
    !> V, shape (n_dofs, n_modes)
    real(rk), intent(in) :: basis(:, :)
    !> prescribed dofs, natural (order of the mesh file), shape (n_rows)
    integer, intent(in) :: dofs(:)
    !> [length] g, the prescribed displacement per term, shape (n_rows, n_terms)
    real(rk), intent(in) :: values(:, :)
    !> [-] singular values of C below this times the largest count as zero
    real(rk), intent(in) :: rank_tolerance
    !> V Z, shape (n_dofs, n_modes - rank)
    real(rk), allocatable, intent(out) :: free_basis(:, :)
    !> [length] V C^+ g, shape (n_dofs, n_terms)
    real(rk), allocatable, intent(out) :: lifting(:, :)
    !> number of independent rows
    integer, intent(out) :: rank
    real(rk), allocatable :: particular(:, :), null_space(:, :)

    call solve_rows(basis(dofs, :), values, rank_tolerance, particular, null_space)
    rank = size(basis, 2) - size(null_space, 2)
    free_basis = matmul(basis, null_space)
    lifting = matmul(basis, particular)
  end subroutine impose_dirichlet_rows

  !> Computes the solution of least norm of C x = g, in the sense of least squares, and an orthonormal basis of the null space of C,
  !> by the singular values of C.
  subroutine solve_rows(matrix, rhs, rank_tolerance, particular, null_space)
    !> C, shape (n_rows, n)
    real(rk), intent(in) :: matrix(:, :)
    !> g, shape (n_rows, n_terms)
    real(rk), intent(in) :: rhs(:, :)
    !> [-] as in impose_dirichlet_rows
    real(rk), intent(in) :: rank_tolerance
    !> C^+ g, shape (n, n_terms)
    real(rk), allocatable, intent(out) :: particular(:, :)
    !> Z, shape (n, n - rank)
    real(rk), allocatable, intent(out) :: null_space(:, :)
    real(rk), allocatable :: padded(:, :), left(:, :), sigma(:), right(:, :), scaled(:, :)
    integer :: i_value, n, n_rows, rank

    n_rows = size(matrix, 1)
    n = size(matrix, 2)
    ! Rows of zeros make the thin decomposition return all n right vectors, the null space among them.
    allocate (padded(max(n_rows, n), n), source=0.0_rk)
    padded(:n_rows, :) = matrix
    call svd(padded, left, sigma, right)
    rank = 0
    if (n > 0) rank = count(sigma > 0 .and. sigma >= rank_tolerance * sigma(1))
    scaled = matmul(transpose(left(:n_rows, :rank)), rhs)
    do i_value = 1, rank
      scaled(i_value, :) = scaled(i_value, :) / sigma(i_value)
    end do
    particular = matmul(transpose(right(:rank, :)), scaled)
    null_space = complement(right(:rank, :))
  end subroutine solve_rows

  !> Returns an orthonormal basis of all vectors that are orthogonal to the given rows. It is made from the unit vectors that are
  !> farthest from the span of the rows, projected and orthonormalized in ascending order. It therefore depends on the span alone,
  !> not on rounding.
  pure function complement(rows) result(basis)
    !> orthonormal, shape (rank, n)
    real(rk), intent(in) :: rows(:, :)
    !> shape (n, n - rank)
    real(rk) :: basis(size(rows, 2), size(rows, 2) - size(rows, 1))
    logical :: is_near(size(rows, 2))
    integer :: i, n_found, repetition

    is_near = nearest_unit_vectors(rows)
    n_found = 0
    do i = 1, size(rows, 2)
      if (is_near(i)) cycle
      n_found = n_found + 1
      associate (column => basis(:, n_found), before => basis(:, :n_found - 1))
        column = 0
        column(i) = 1
        ! twice, because the first pass leaves rounding errors relative to the part that it subtracts
        do repetition = 1, 2
          column = column - matmul(matmul(rows, column), rows)
          column = column - matmul(before, matmul(column, before))
          column = column / norm2(column)
        end do
      end associate
    end do
  end function complement

  !> Chooses as many unit vectors as there are rows, those with the largest components in the span of the rows. The method is a
  !> Cholesky decomposition with pivots of the projector on the span. Of nearly equal pivots the lowest number is taken.
  pure function nearest_unit_vectors(rows) result(is_near)
    !> orthonormal, shape (rank, n)
    real(rk), intent(in) :: rows(:, :)
    !> unit vector i is chosen
    logical :: is_near(size(rows, 2))
    real(rk) :: projector(size(rows, 2), size(rows, 2)), diagonal(size(rows, 2)), column(size(rows, 2))
    integer :: i, k

    projector = matmul(transpose(rows), rows)
    is_near = .false.
    do k = 1, size(rows, 1)
      diagonal = [(projector(i, i), i=1, size(diagonal))]
      i = findloc(diagonal >= (1 - tie_tolerance) * maxval(diagonal, mask=.not. is_near) .and. .not. is_near, .true., dim=1)
      is_near(i) = .true.
      column = projector(:, i) / sqrt(projector(i, i))
      projector = projector - matmul(reshape(column, [size(column), 1]), reshape(column, [1, size(column)]))
    end do
  end function nearest_unit_vectors
end module sig_dirichlet_rows
