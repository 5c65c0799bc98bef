! SPDX-License-Identifier: BSD-3-Clause
!> The reduced integration domain (RID): the few cells on which the reduced equations are written, and the sets of its dofs and
!> contact rows.
module sig_reduced_domain
  use sig_contact_rows, only: contact_rows_t
  use sig_mesh, only: cells_around_nodes, mesh_t, nodes_of_cell
  implicit none(type, external)
  private
  public :: reduced_domain_t, build_reduced_domain, nodes_of_dofs

  !> The sets (4)-(9) of the paper. Nodes, cells and dofs are natural (order of the mesh file), 1-based; all sets are ascending.
  type :: reduced_domain_t
    !> L: nodes around which the domain is built
    integer, allocatable :: seed_nodes(:)
    !> L': contact partners of seed nodes, and partners that were added so that no contact row is cut; without the seed nodes
    integer, allocatable :: facing_nodes(:)
    !> Omega_A: every cell that touches a seed or facing node
    integer, allocatable :: cells(:)
    !> A: dofs of interior nodes, whose cells all belong to the domain
    integer, allocatable :: interior_dofs(:)
    !> I: the other dofs of cells that touch an interior node
    integer, allocatable :: interface_dofs(:)
    !> A_c: dofs of A that occur in a contact row with a coefficient that is not zero
    integer, allocatable :: contact_dofs(:)
    !> A_lambda: contact rows with a dof in A_c
    integer, allocatable :: contact_rows(:)
  end type reduced_domain_t

  !> A domain that grows cell by cell. A node is interior when all cells around it belong to the domain.
  type :: growth_t
    !> cells around node i: cells(offsets(i) + 1 : offsets(i + 1))
    integer, allocatable :: offsets(:)
    integer, allocatable :: cells(:)
    logical, allocatable :: is_inside(:)
    !> number of cells around each node that do not belong to the domain
    integer, allocatable :: n_outside(:)
    !> nodes in the order in which they became interior
    integer, allocatable :: interior_nodes(:)
    integer :: n_interior = 0
  end type growth_t

  !> Nodes that share a contact row with node i: partners(offsets(i) + 1 : offsets(i + 1)), possibly repeated, node i included.
  type :: ties_t
    integer, allocatable :: offsets(:)
    integer, allocatable :: partners(:)
  end type ties_t

contains

  !> Builds the domain around the seed nodes. It has whole contact rows only: if one node of a row is interior, all its nodes are.
  !>
  !> Source: (4)-(9). Paper: (4) adds only the partners of L. A node of A outside of L could then face a node outside of A.
  !> Therefore the cells around partners are added until no row is cut. Then each equation of A has all its contact forces, and each
  !> row all its displacements. Rows that share nodes are added together. Local. Cost: one pass over the connectivity of the mesh,
  !> then proportional to the size of the domain.
  pure subroutine build_reduced_domain(mesh, rows, seed_nodes, domain)
    type(mesh_t), intent(in) :: mesh
    type(contact_rows_t), intent(in) :: rows
    !> natural (order of the mesh file), in any order here, repetitions allowed
    integer, intent(in) :: seed_nodes(:)
    type(reduced_domain_t), intent(out) :: domain
    type(growth_t) :: growth
    type(ties_t) :: ties
    logical, allocatable :: is_seed(:), is_facing(:)
    integer :: i_seed

    allocate (is_seed(mesh%n_nodes), is_facing(mesh%n_nodes), source=.false.)
    is_seed(seed_nodes) = .true.
    domain%seed_nodes = true_indices(is_seed)
    call find_ties(rows, mesh%n_nodes, ties)
    call start_growth(mesh, growth)
    do i_seed = 1, size(domain%seed_nodes)
      call take_cells_around(mesh, domain%seed_nodes(i_seed), growth)
      call take_partners(mesh, ties, domain%seed_nodes(i_seed), growth, is_facing)
    end do
    call close_rows(mesh, ties, growth, is_facing)
    domain%facing_nodes = true_indices(is_facing .and. .not. is_seed)
    call collect_sets(mesh, rows, growth, domain)
  end subroutine build_reduced_domain

  !> Lists for each node the nodes of all its contact rows, itself included; there are none for a node without contact rows.
  pure subroutine find_ties(rows, n_nodes, ties)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: n_nodes
    type(ties_t), intent(out) :: ties
    integer :: i, k, next(n_nodes)

    allocate (ties%offsets(n_nodes + 1), source=0)
    do k = 1, rows%n_rows
      associate (nodes => rows%nodes_of(k))
        ties%offsets(nodes + 1) = ties%offsets(nodes + 1) + size(nodes)
      end associate
    end do
    do i = 1, n_nodes
      ties%offsets(i + 1) = ties%offsets(i) + ties%offsets(i + 1)
    end do
    allocate (ties%partners(ties%offsets(n_nodes + 1)))
    next = ties%offsets(:n_nodes)
    do k = 1, rows%n_rows
      associate (nodes => rows%nodes_of(k))
        do i = 1, size(nodes)
          ties%partners(next(nodes(i)) + 1:next(nodes(i)) + size(nodes)) = nodes
        end do
        next(nodes) = next(nodes) + size(nodes)
      end associate
    end do
  end subroutine find_ties

  pure subroutine start_growth(mesh, growth)
    type(mesh_t), intent(in) :: mesh
    type(growth_t), intent(out) :: growth

    call cells_around_nodes(mesh, growth%offsets, growth%cells)
    growth%n_outside = growth%offsets(2:) - growth%offsets(:mesh%n_nodes)
    allocate (growth%is_inside(mesh%n_cells), source=.false.)
    allocate (growth%interior_nodes(mesh%n_nodes), source=0)
  end subroutine start_growth

  !> Adds all cells around a node to the domain, and lists the nodes that become interior.
  pure subroutine take_cells_around(mesh, node, growth)
    type(mesh_t), intent(in) :: mesh
    !> natural
    integer, intent(in) :: node
    type(growth_t), intent(inout) :: growth
    integer, allocatable :: nodes(:)
    integer :: i_around, i_cell, i_node

    do i_around = growth%offsets(node) + 1, growth%offsets(node + 1)
      i_cell = growth%cells(i_around)
      if (growth%is_inside(i_cell)) cycle
      growth%is_inside(i_cell) = .true.
      nodes = nodes_of_cell(mesh, i_cell)
      growth%n_outside(nodes) = growth%n_outside(nodes) - 1
      do i_node = 1, size(nodes)
        if (growth%n_outside(nodes(i_node)) > 0) cycle
        growth%n_interior = growth%n_interior + 1
        growth%interior_nodes(growth%n_interior) = nodes(i_node)
      end do
    end do
  end subroutine take_cells_around

  !> Adds all cells around the contact partners of a node, that is, the other nodes of its contact rows.
  pure subroutine take_partners(mesh, ties, node, growth, is_facing)
    type(mesh_t), intent(in) :: mesh
    type(ties_t), intent(in) :: ties
    integer, intent(in) :: node
    type(growth_t), intent(inout) :: growth
    !> nodes that were added as partners, shape (n_nodes)
    logical, intent(inout) :: is_facing(:)
    integer :: i

    do i = ties%offsets(node) + 1, ties%offsets(node + 1)
      associate (partner => ties%partners(i))
        if (partner == node) cycle
        is_facing(partner) = .true.
        call take_cells_around(mesh, partner, growth)
      end associate
    end do
  end subroutine take_partners

  !> Adds the partners of all interior nodes, and of those that become interior by that, until no row is cut.
  pure subroutine close_rows(mesh, ties, growth, is_facing)
    type(mesh_t), intent(in) :: mesh
    type(ties_t), intent(in) :: ties
    type(growth_t), intent(inout) :: growth
    !> as in take_partners
    logical, intent(inout) :: is_facing(:)
    integer :: i_interior, node

    i_interior = 0
    do while (i_interior < growth%n_interior)
      i_interior = i_interior + 1
      node = growth%interior_nodes(i_interior)
      associate (partners => ties%partners(ties%offsets(node) + 1:ties%offsets(node + 1)))
        if (any(growth%n_outside(partners) > 0)) call take_partners(mesh, ties, node, growth, is_facing)
      end associate
    end do
  end subroutine close_rows

  !> Sets the cells, dofs and contact rows of a finished domain (not its seed and facing nodes).
  !>
  !> Source: (7) asks for dofs with K_ij /= 0, so I are the other dofs of the cells that touch an interior node.
  pure subroutine collect_sets(mesh, rows, growth, domain)
    type(mesh_t), intent(in) :: mesh
    type(contact_rows_t), intent(in) :: rows
    type(growth_t), intent(in) :: growth
    type(reduced_domain_t), intent(inout) :: domain
    logical :: is_interior(mesh%n_nodes), is_interface(mesh%n_nodes), is_contact(mesh%n_dim * mesh%n_nodes)
    logical :: is_row(rows%n_rows)
    integer :: i_cell, i_entry, i_row, dof

    domain%cells = true_indices(growth%is_inside)
    is_interior = .false.
    is_interior(growth%interior_nodes(:growth%n_interior)) = .true.
    is_interface = .false.
    do i_cell = 1, size(domain%cells)
      associate (nodes => nodes_of_cell(mesh, domain%cells(i_cell)))
        if (any(is_interior(nodes))) is_interface(nodes) = .true.
      end associate
    end do
    is_interface = is_interface .and. .not. is_interior
    domain%interior_dofs = dofs_of_nodes(true_indices(is_interior), mesh%n_dim)
    domain%interface_dofs = dofs_of_nodes(true_indices(is_interface), mesh%n_dim)

    is_contact = .false.
    is_row = .false.
    do i_row = 1, rows%n_rows
      do i_entry = rows%offsets(i_row) + 1, rows%offsets(i_row + 1)
        dof = rows%dofs(i_entry)
        if (rows%coefficients(i_entry) == 0 .or. .not. is_interior((dof - 1) / mesh%n_dim + 1)) cycle
        is_contact(dof) = .true.
        is_row(i_row) = .true.
      end do
    end do
    domain%contact_dofs = true_indices(is_contact)
    domain%contact_rows = true_indices(is_row)
  end subroutine collect_sets

  !> Returns the nodes of the given dofs, ascending and each once. It makes seed nodes of the rows that DEIM chooses.
  pure function nodes_of_dofs(dofs, n_dim) result(nodes)
    !> natural (order of the mesh file)
    integer, intent(in) :: dofs(:)
    integer, intent(in) :: n_dim
    integer, allocatable :: nodes(:)
    logical, allocatable :: is_node(:)

    allocate (is_node((maxval([0, dofs]) + n_dim - 1) / n_dim), source=.false.)
    is_node((dofs - 1) / n_dim + 1) = .true.
    nodes = true_indices(is_node)
  end function nodes_of_dofs

  pure function dofs_of_nodes(nodes, n_dim) result(dofs)
    integer, intent(in) :: nodes(:)
    integer, intent(in) :: n_dim
    integer :: dofs(n_dim * size(nodes))
    integer :: i_component

    do i_component = 1, n_dim
      dofs(i_component::n_dim) = n_dim * (nodes - 1) + i_component
    end do
  end function dofs_of_nodes

  pure function true_indices(mask) result(indices)
    logical, intent(in) :: mask(:)
    integer, allocatable :: indices(:)
    integer :: i

    indices = pack([(i, i=1, size(mask))], mask)
  end function true_indices
end module sig_reduced_domain
