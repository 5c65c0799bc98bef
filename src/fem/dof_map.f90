! SPDX-License-Identifier: BSD-3-Clause
!> Maps between natural dofs, in the order of the mesh file, and distributed dofs, where the dofs of each rank are one block in
!> natural order.
module sig_dof_map
  use sig_mesh, only: mesh_partition_t, mesh_t
  implicit none(type, external)
  private
  public :: dof_map_t, create_dof_map

  !> The dofs of one rank, and the numbers of all dofs.
  type :: dof_map_t
    integer :: n_dim = 0
    !> number of dofs of the mesh
    integer :: n_dofs = 0
    !> number of dofs that this rank owns
    integer :: n_local_dofs = 0
    !> distributed number (0-based) of the rank's first dof
    integer :: first_dof_0 = 0
    !> natural dofs that this rank owns, ascending; shape (n_local_dofs)
    integer, allocatable :: local_dofs(:)
    !> distributed number (0-based) of each node, shape (n_nodes)
    integer, allocatable :: node_places_0(:)
    !> cells that this rank assembles, ascending
    integer, allocatable :: own_cells(:)
  contains
    procedure :: distributed_0
    procedure :: local_nodes
    procedure :: local_index
    procedure :: count_blocks
  end type dof_map_t

contains

  !> Creates the map of one rank. Local: every rank knows the mesh and its partition.
  pure subroutine create_dof_map(mesh, partition, rank, n_ranks, map)
    type(mesh_t), intent(in) :: mesh
    type(mesh_partition_t), intent(in) :: partition
    !> 0-based, in the communicator of the partition
    integer, intent(in) :: rank
    !> number of ranks of this communicator
    integer, intent(in) :: n_ranks
    type(dof_map_t), intent(out) :: map
    integer :: next_0(0:n_ranks - 1), i_node, i_rank, i, i_cell

    map%n_dim = mesh%n_dim
    map%n_dofs = mesh%n_dim * mesh%n_nodes
    next_0 = 0
    do i_rank = 1, n_ranks - 1
      next_0(i_rank) = next_0(i_rank - 1) + count(partition%node_owner == i_rank - 1)
    end do
    map%first_dof_0 = mesh%n_dim * next_0(rank)
    map%own_cells = pack([(i_cell, i_cell=1, mesh%n_cells)], partition%cell_owner == rank)
    map%n_local_dofs = mesh%n_dim * count(partition%node_owner == rank)
    allocate (map%node_places_0(mesh%n_nodes), map%local_dofs(map%n_local_dofs))
    do i_node = 1, mesh%n_nodes
      i_rank = partition%node_owner(i_node)
      map%node_places_0(i_node) = next_0(i_rank)
      next_0(i_rank) = next_0(i_rank) + 1
      if (i_rank /= rank) cycle
      associate (before => mesh%n_dim * map%node_places_0(i_node) - map%first_dof_0)
        map%local_dofs(before + 1:before + mesh%n_dim) = [(mesh%n_dim * (i_node - 1) + i, i=1, mesh%n_dim)]
      end associate
    end do
  end subroutine create_dof_map

  !> Returns the distributed number (0-based) of a natural dof: the dofs of a node are neighbors in both orders.
  elemental integer function distributed_0(self, dof)
    class(dof_map_t), intent(in) :: self
    !> natural
    integer, intent(in) :: dof
    integer :: i_node

    i_node = (dof - 1) / self%n_dim + 1
    distributed_0 = self%n_dim * self%node_places_0(i_node) + dof - self%n_dim * (i_node - 1) - 1
  end function distributed_0

  !> Returns the nodes that this rank owns, ascending.
  pure function local_nodes(self) result(nodes)
    class(dof_map_t), intent(in) :: self
    integer :: nodes(self%n_local_dofs / self%n_dim)

    nodes = self%local_dofs(self%n_dim::self%n_dim) / self%n_dim
  end function local_nodes

  !> Returns the index (1-based) of a natural dof in local_dofs, 0 if another rank owns it.
  pure integer function local_index(self, dof)
    class(dof_map_t), intent(in) :: self
    !> natural
    integer, intent(in) :: dof

    local_index = self%distributed_0(dof) - self%first_dof_0 + 1
    if (local_index < 1 .or. local_index > self%n_local_dofs) local_index = 0
  end function local_index

  !> Sets how many blocks a matrix has in the rows of some nodes, if it couples all of these: those of this rank's nodes, and the
  !> others.
  pure subroutine count_blocks(self, dofs, is_row, diagonal, off_diagonal)
    class(dof_map_t), intent(in) :: self
    !> a dof of each node, natural
    integer, intent(in) :: dofs(:)
    !> whether the node has such rows; shape as dofs
    logical, intent(in) :: is_row(:)
    !> of each local node, shape (n_local_dofs / n_dim)
    integer, intent(inout) :: diagonal(:), off_diagonal(:)
    integer :: i, i_node, places(size(dofs))

    do i = 1, size(dofs)
      places(i) = self%local_index(dofs(i))
    end do
    do i = 1, size(dofs)
      if (places(i) == 0 .or. .not. is_row(i)) cycle
      i_node = (places(i) - 1) / self%n_dim + 1
      diagonal(i_node) = count(places > 0)
      off_diagonal(i_node) = count(places == 0)
    end do
  end subroutine count_blocks
end module sig_dof_map
