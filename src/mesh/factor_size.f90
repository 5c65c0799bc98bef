! SPDX-License-Identifier: BSD-3-Clause
!> Counts the entries of the stiffness of a mesh and of its factor, before anything is assembled.
module sig_factor_size
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_node_graph, only: node_graph
  implicit none(type, external)
  private
  public :: compact_factor, measure_factor

  !> seed of METIS
  integer(c_int), parameter :: seed = 1

  ! include/signorom/factor_size.h describes this procedure in C.
  interface
    integer(c_int) function sig_count_factor(n_vertices, offsets, neighbors, n_dim, seed, entries, operations) bind(c)
      import :: c_double, c_int
      integer(c_int), value :: n_vertices
      integer(c_int), intent(in) :: offsets(*), neighbors(*)
      integer(c_int), value :: n_dim, seed
      real(c_double), intent(out) :: entries, operations
    end function sig_count_factor
  end interface

contains

  !> Counts the entries of K without contact, those of its Cholesky factor, and the operations of the factorization, with the
  !> unknowns ordered by nested dissection. In space METIS orders the nodes and the factor is counted. In the plane, where this
  !> would take as long as the factorization, a formula gives it.
  subroutine measure_factor(mesh, stiffness_entries, factor_entries, operations)
    type(mesh_t), intent(in) :: mesh
    real(rk), intent(out) :: stiffness_entries
    real(rk), intent(out) :: factor_entries
    !> a column with m entries counts m^2
    real(rk), intent(out) :: operations
    integer, allocatable :: offsets(:), neighbors(:)
    real(c_double) :: entries, work
    integer :: i

    call node_graph(mesh, [(i, i=1, mesh%n_nodes)], mesh%n_nodes, offsets, neighbors)
    stiffness_entries = real(mesh%n_dim, rk)**2 * (real(size(neighbors), rk) + mesh%n_nodes)
    call compact_factor(mesh%n_dim, mesh%n_dim * mesh%n_nodes, factor_entries, operations)
    if (mesh%n_dim < 3) return
    ! without memory for METIS the formula has to do
    if (sig_count_factor(mesh%n_nodes, offsets, neighbors - 1, mesh%n_dim, seed, entries, work) /= 0) return
    factor_entries = entries
    operations = work
  end subroutine measure_factor

  !> Estimates the factor of a compact part: nested dissection gives n log n entries and n^1.5 operations in the plane, n^(4/3) and
  !> n^2 in space (A. George 1973, R. Lipton 1979). The constants are counts of METIS for T3, T6, H8 and T10. A thin part has less.
  pure subroutine compact_factor(n_dim, n_dofs, entries, operations)
    integer, intent(in) :: n_dim
    integer, intent(in) :: n_dofs
    real(rk), intent(out) :: entries
    real(rk), intent(out) :: operations
    real(rk) :: n

    n = max(n_dofs, 4)
    if (n_dim == 2) then
      entries = 4.5_rk * n * log(n / 2) / log(2.0_rk)
      operations = 34 * n**1.5_rk
    else
      entries = 13.5_rk * n**(4 / 3.0_rk)
      operations = 8 * n**2
    end if
  end subroutine compact_factor
end module sig_factor_size
