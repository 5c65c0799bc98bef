! SPDX-License-Identifier: BSD-3-Clause
!> Makes the graph of the nodes: a node is a vertex, both nodes of a contact pair are one vertex, and vertices with nodes in a
!> common cell are neighbors.
module sig_node_graph
  use sig_mesh, only: cells_around_nodes, mesh_t
  implicit none(type, external)
  private
  public :: merge_pairs, node_graph

contains

  !> Gives each node its vertex: both nodes of a pair have one vertex, any other node has its own. Vertices are numbered in the
  !> order of their lowest node.
  pure subroutine merge_pairs(n_nodes, pair_first, pair_second, vertex_of_node, n_vertices)
    integer, intent(in) :: n_nodes
    !> first and second node of each pair, 1-based; no node is there twice
    integer, intent(in) :: pair_first(:), pair_second(:)
    !> vertex of each node, 1-based, shape (n_nodes)
    integer, allocatable, intent(out) :: vertex_of_node(:)
    integer, intent(out) :: n_vertices
    integer :: i_node, partner(n_nodes)

    partner = 0
    partner(pair_first) = pair_second
    partner(pair_second) = pair_first
    allocate (vertex_of_node(n_nodes))
    n_vertices = 0
    do i_node = 1, n_nodes
      if (partner(i_node) > 0 .and. partner(i_node) < i_node) then
        vertex_of_node(i_node) = vertex_of_node(partner(i_node))
      else
        n_vertices = n_vertices + 1
        vertex_of_node(i_node) = n_vertices
      end if
    end do
  end subroutine merge_pairs

  !> Lists the neighbors of each vertex, which have a node in a common cell with it: those of v are neighbors(offsets(v) + 1 :
  !> offsets(v + 1)), each once, without v, not sorted. All are 1-based. Cost: linear in the number of cells.
  pure subroutine node_graph(mesh, vertex_of_node, n_vertices, offsets, neighbors)
    type(mesh_t), intent(in) :: mesh
    !> of merge_pairs
    integer, intent(in) :: vertex_of_node(:)
    integer, intent(in) :: n_vertices
    !> the first offset is 0, shape (n_vertices + 1)
    integer, allocatable, intent(out) :: offsets(:)
    integer, allocatable, intent(out) :: neighbors(:)
    integer, allocatable :: cell_offsets(:), cells(:), node_offsets(:), nodes(:)
    integer :: i_vertex, i_sweep, n

    call cells_around_nodes(mesh, cell_offsets, cells)
    call nodes_of_vertices(vertex_of_node, n_vertices, node_offsets, nodes)
    allocate (offsets(n_vertices + 1), source=0)
    ! the first sweep counts, the second one lists
    do i_sweep = 1, 2
      if (i_sweep == 2) allocate (neighbors(offsets(n_vertices + 1)))
      block
        integer :: last_seen(n_vertices)

        last_seen = 0
        do i_vertex = 1, n_vertices
          n = offsets(i_vertex)
          last_seen(i_vertex) = i_vertex
          call visit_neighbors(mesh, vertex_of_node, cell_offsets, cells, i_vertex, &
                               nodes(node_offsets(i_vertex) + 1:node_offsets(i_vertex + 1)), last_seen, n, neighbors)
          offsets(i_vertex + 1) = n
        end do
      end block
    end do
  end subroutine node_graph

  !> Adds the number of neighbors of a vertex to n, and lists them from neighbors(n + 1) on if `neighbors` is allocated. Requires:
  !> last_seen(i_vertex) is i_vertex, so that the vertex is not its own neighbor.
  pure subroutine visit_neighbors(mesh, vertex_of_node, cell_offsets, cells, i_vertex, own_nodes, last_seen, n, neighbors)
    type(mesh_t), intent(in) :: mesh
    !> of merge_pairs and cells_around_nodes
    integer, intent(in) :: vertex_of_node(:), cell_offsets(:), cells(:)
    integer, intent(in) :: i_vertex
    !> nodes of the vertex
    integer, intent(in) :: own_nodes(:)
    !> last visited vertex that had each vertex as a neighbor, 0 = none; shape (n_vertices)
    integer, intent(inout) :: last_seen(:)
    integer, intent(inout) :: n
    integer, allocatable, intent(inout) :: neighbors(:)
    integer :: i, i_cell, i_node, i_other, j

    do i = 1, size(own_nodes)
      do i_cell = cell_offsets(own_nodes(i)) + 1, cell_offsets(own_nodes(i) + 1)
        do j = mesh%cell_offsets(cells(i_cell)) + 1, mesh%cell_offsets(cells(i_cell) + 1)
          i_node = mesh%cell_nodes(j)
          i_other = vertex_of_node(i_node)
          if (last_seen(i_other) == i_vertex) cycle
          last_seen(i_other) = i_vertex
          n = n + 1
          if (allocated(neighbors)) neighbors(n) = i_other
        end do
      end do
    end do
  end subroutine visit_neighbors

  pure subroutine nodes_of_vertices(vertex_of_node, n_vertices, offsets, nodes)
    integer, intent(in) :: vertex_of_node(:)
    integer, intent(in) :: n_vertices
    integer, allocatable, intent(out) :: offsets(:)
    integer, allocatable, intent(out) :: nodes(:)
    integer :: i, next(n_vertices + 1)

    allocate (offsets(n_vertices + 1), source=0)
    do i = 1, size(vertex_of_node)
      offsets(vertex_of_node(i) + 1) = offsets(vertex_of_node(i) + 1) + 1
    end do
    do i = 1, n_vertices
      offsets(i + 1) = offsets(i + 1) + offsets(i)
    end do
    next = offsets
    allocate (nodes(size(vertex_of_node)))
    do i = 1, size(vertex_of_node)
      next(vertex_of_node(i)) = next(vertex_of_node(i)) + 1
      nodes(next(vertex_of_node(i))) = i
    end do
  end subroutine nodes_of_vertices
end module sig_node_graph
