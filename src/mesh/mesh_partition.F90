! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Chooses the rank that owns each node and each cell. Both nodes of a pair that the caller gives have the same owner.
module sig_mesh_partition
  use, intrinsic :: iso_c_binding, only: c_int
  use mpi, only: MPI_Bcast, MPI_Comm_rank, MPI_Comm_size, MPI_INTEGER
  use sig_mesh, only: mesh_partition_t, mesh_t, nodes_of_cell
  use sig_node_graph, only: merge_pairs, node_graph
  use sig_petsc_support, only: precondition_failed
  use petsc
  implicit none(type, external)
  private
  public :: partition_mesh

  !> a fixed number, so that the same mesh gets the same owners in every run
  integer, parameter :: seed = 20220503

  ! include/signorom/partition.h describes this procedure in C.
  interface
    integer(c_int) function sig_partition_graph(n_vertices, offsets, neighbors, weights, n_parts, seed, part) bind(c)
      import :: c_int
      integer(c_int), value :: n_vertices
      integer(c_int), intent(in) :: offsets(*), neighbors(*), weights(*)
      integer(c_int), value :: n_parts, seed
      integer(c_int), intent(inout) :: part(*)
    end function sig_partition_graph
  end interface

contains

  !> Chooses an owner among the ranks of comm for each node and each cell. Collective on comm.
  !>
  !> METIS partitions the graph of the nodes, in which the two nodes of each pair are one vertex. With fewer than 4 vertices per
  !> rank, or if METIS leaves a rank without nodes, each rank gets consecutive vertices instead, about equally many; with more ranks
  !> than vertices some get none. Rank 0 does this and sends the result. A cell belongs to the rank that owns most of its nodes, and
  !> to the lowest of several such ranks.
  !>
  !> Errors by ierr: the lists of pairs have different sizes; METIS fails, or there is not enough memory.
  subroutine partition_mesh(mesh, pair_first, pair_second, comm, partition, ierr)
    type(mesh_t), intent(in) :: mesh
    !> first and second node of each pair, 1-based, same size; no node is there twice
    integer, intent(in) :: pair_first(:), pair_second(:)
    MPI_Comm, intent(in) :: comm
    !> the owners are ranks of comm, 0-based
    type(mesh_partition_t), intent(out) :: partition
    PetscErrorCode, intent(out) :: ierr
    integer :: rank, n_ranks, status

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    PetscCallMPI(MPI_Comm_size(comm, n_ranks, ierr))
    SIG_CHECK(size(pair_first) == size(pair_second), PETSC_ERR_ARG_SIZ, 'each pair has two nodes')
    allocate (partition%node_owner(mesh%n_nodes), source=0)
    status = 0
    if (rank == 0) call share_nodes(mesh, pair_first, pair_second, n_ranks, partition%node_owner, status)
    PetscCallMPI(MPI_Bcast(status, 1, MPI_INTEGER, 0, comm, ierr))
    SIG_CHECK(status == 0, PETSC_ERR_LIB, 'METIS could not partition the mesh (out of memory?)')
    PetscCallMPI(MPI_Bcast(partition%node_owner, mesh%n_nodes, MPI_INTEGER, 0, comm, ierr))
    call share_cells(mesh, partition)
  end subroutine partition_mesh

  subroutine share_nodes(mesh, pair_first, pair_second, n_ranks, node_owner, status)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: pair_first(:), pair_second(:)
    integer, intent(in) :: n_ranks
    integer, intent(inout) :: node_owner(:)
    integer, intent(out) :: status
    integer, allocatable :: vertex_of_node(:), offsets(:), neighbors(:), weights(:), part(:)
    integer :: n_vertices, i_node

    call merge_pairs(mesh%n_nodes, pair_first, pair_second, vertex_of_node, n_vertices)
    call node_graph(mesh, vertex_of_node, n_vertices, offsets, neighbors)
    allocate (weights(n_vertices), part(n_vertices), source=0)
    do i_node = 1, mesh%n_nodes
      weights(vertex_of_node(i_node)) = weights(vertex_of_node(i_node)) + 1
    end do
    status = sig_partition_graph(n_vertices, offsets, neighbors - 1, weights, n_ranks, seed, part)
    if (status == 0) node_owner = part(vertex_of_node)
  end subroutine share_nodes

  pure subroutine share_cells(mesh, partition)
    type(mesh_t), intent(in) :: mesh
    type(mesh_partition_t), intent(inout) :: partition
    integer :: i_cell

    allocate (partition%cell_owner(mesh%n_cells))
    do i_cell = 1, mesh%n_cells
      partition%cell_owner(i_cell) = most_frequent(partition%node_owner(nodes_of_cell(mesh, i_cell)))
    end do
  end subroutine share_cells

  !> Returns the number that occurs most often, and the lowest of several such numbers. There must be at least one number.
  pure integer function most_frequent(numbers) result(winner)
    integer, intent(in) :: numbers(:)
    integer :: i, n, n_most

    winner = numbers(1)
    n_most = 0
    do i = 1, size(numbers)
      n = count(numbers == numbers(i))
      if (n < n_most .or. (n == n_most .and. numbers(i) >= winner)) cycle
      winner = numbers(i)
      n_most = n
    end do
  end function most_frequent
end module sig_mesh_partition
