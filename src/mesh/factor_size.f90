! SPDX-License-Identifier: BSD-3-Clause
!> Counts the entries of the stiffness of a mesh and of its factor, before anything is assembled.
module sig_factor_size
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_node_graph, only: node_graph
  implicit none(type, external)
  private
  public :: compact_factor, factor_size_t, measure_factor

  !> Numbers of entries of a factor, of operations of the factorization (m^2 for a column with m entries), and of entries of the
  !> largest column: sig_factor_size_t of include/signorom/factor_size.h.
  type, bind(c) :: factor_size_t
    real(c_double) :: entries = 0
    real(c_double) :: operations = 0
    real(c_double) :: largest_column = 0
  end type factor_size_t

  !> seed of METIS
  integer(c_int), parameter :: seed = 1

  ! include/signorom/factor_size.h describes this procedure in C.
  interface
    integer(c_int) function sig_count_factor(n_vertices, offsets, neighbors, n_dim, seed, n_borders, n_rows, row_offsets, &
      row_vertices, factor, bordered) bind(c)
      import :: c_int, factor_size_t
      integer(c_int), value :: n_vertices
      integer(c_int), intent(in) :: offsets(*), neighbors(*)
      integer(c_int), value :: n_dim, seed, n_borders
      integer(c_int), intent(in) :: n_rows(*), row_offsets(*), row_vertices(*)
      type(factor_size_t), intent(out) :: factor
      type(factor_size_t), intent(inout) :: bordered(*)
    end function sig_count_factor
  end interface

contains

  !> Counts the entries of K without contact, and measures its Cholesky factor, with the unknowns ordered by nested dissection:
  !> alone, and bordered by the first rows of some that stay. In space METIS orders the nodes and the factor is counted. In the
  !> plane, where this would take as long as the factorization, formulas give it.
  subroutine measure_factor(mesh, row_offsets, row_nodes, n_rows, stiffness_entries, factor, bordered)
    type(mesh_t), intent(in) :: mesh
    !> nodes of the rows: those of row k are row_nodes(row_offsets(k) + 1:row_offsets(k + 1)), 1-based
    integer, intent(in) :: row_offsets(:)
    integer, intent(in) :: row_nodes(:)
    !> by how many of the rows the factor is bordered, ascending
    integer, intent(in) :: n_rows(:)
    real(rk), intent(out) :: stiffness_entries
    type(factor_size_t), intent(out) :: factor
    !> shape of n_rows
    type(factor_size_t), intent(out) :: bordered(:)
    integer, allocatable :: offsets(:), neighbors(:)
    integer :: i

    call node_graph(mesh, [(i, i=1, mesh%n_nodes)], mesh%n_nodes, offsets, neighbors)
    stiffness_entries = real(mesh%n_dim, rk)**2 * (real(size(neighbors), rk) + mesh%n_nodes)
    if (mesh%n_dim == 3) then
      if (sig_count_factor(mesh%n_nodes, offsets, neighbors - 1, mesh%n_dim, seed, size(n_rows), n_rows, row_offsets, &
                           row_nodes - 1, factor, bordered) == 0) return
    end if
    ! in the plane, or without memory for METIS
    factor = compact_factor(mesh%n_dim, mesh%n_dim * mesh%n_nodes)
    bordered = with_border(factor, n_rows)
  end subroutine measure_factor

  !> Estimates the factor of a compact part: nested dissection gives n log n entries and n^1.5 operations in the plane, n^(4/3) and
  !> n^2 in space (A. George 1973, R. Lipton 1979). The constants are counts of METIS for T3, T6, H8 and T10. A thin part has less.
  pure type(factor_size_t) function compact_factor(n_dim, n_dofs) result(factor)
    integer, intent(in) :: n_dim
    integer, intent(in) :: n_dofs
    real(rk) :: n

    n = max(n_dofs, 4)
    if (n_dim == 2) then
      factor = factor_size_t(4.5_rk * n * log(n / 2) / log(2.0_rk), 34 * n**1.5_rk, 3 * sqrt(n))
    else
      factor = factor_size_t(13.5_rk * n**(4 / 3.0_rk), 8 * n**2, 2 * n**(2 / 3.0_rk))
    end if
  end function compact_factor

  !> Adds rows to the factor of a compact part: each reaches the columns on its way up the tree, which are about as many as the
  !> largest column has entries, twice; the rows of the last ones are all there.
  elemental type(factor_size_t) function with_border(factor, n_rows) result(bordered)
    type(factor_size_t), intent(in) :: factor
    integer, intent(in) :: n_rows

    associate (path => 2 * factor%largest_column, n => real(n_rows, rk))
      bordered = factor_size_t(factor%entries + path * n, factor%operations + path * n * (n + factor%largest_column), &
        factor%largest_column + n)
    end associate
  end function with_border
end module sig_factor_size
