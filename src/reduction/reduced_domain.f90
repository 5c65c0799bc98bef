! SPDX-License-Identifier: BSD-3-Clause
!> The reduced integration domain (RID): the few cells on which the reduced equations are written, and its sets of unknowns.
module sig_reduced_domain
  use sig_contact_operator, only: contact_operator_t
  use sig_mesh, only: cells_around_nodes, mesh_t, nodes_of_cell
  implicit none(type, external)
  private
  public :: reduced_domain_t, build_reduced_domain, nodes_of_dofs

  !> Sets (4)-(9) of the paper; all natural numbers, 1-based, ascending.
  type :: reduced_domain_t
    !> L: nodes that the domain was asked to hold
    integer, allocatable :: seed_nodes(:)
    !> L': partners of seed nodes, then partners of other interior nodes that had to be added to close the pairs
    integer, allocatable :: facing_nodes(:)
    !> Omega_A: every cell that touches a seed or facing node
    integer, allocatable :: cells(:)
    !> A: dofs of nodes whose cells all belong to the domain
    integer, allocatable :: interior_dofs(:)
    !> I: the other dofs of the domain's cells
    integer, allocatable :: interface_dofs(:)
    !> A_c: dofs of A that occur in a contact row
    integer, allocatable :: contact_dofs(:)
    !> A_lambda: contact rows with a dof in A_c
    integer, allocatable :: contact_rows(:)
  end type reduced_domain_t

  !> A domain that grows node by node; a node is interior once no cell around it is left outside.
  type :: growth_t
    !> cells around node i: cells(offsets(i) + 1 : offsets(i + 1))
    integer, allocatable :: offsets(:)
    integer, allocatable :: cells(:)
    logical, allocatable :: is_inside(:)
    !> cells around each node that are not inside
    integer, allocatable :: n_outside(:)
    !> nodes in the order in which they became interior
    integer, allocatable :: interior_nodes(:)
    integer :: n_interior = 0
  end type growth_t

contains

  !> Domain around the seed nodes, with whole contact pairs only: an interior node's partner is interior too.
  !>
  !> Source: (4)-(9). Paper: (4) adds the partners of L only; a node of A outside L could still face a node outside A, so the
  !> partner's cells are added until no such pair is left (method.md section 2.3).
  !> Local. Cost: one pass over the mesh's connectivity, then the size of the domain.
  pure subroutine build_reduced_domain(mesh, operator, seed_nodes, has_partners, domain)
    type(mesh_t), intent(in) :: mesh
    !> its pairs are the ones that count; an inert pair has no row
    type(contact_operator_t), intent(in) :: operator
    !> natural, in any order, repetitions allowed
    integer, intent(in) :: seed_nodes(:)
    !> partners join (Fig. 2b); otherwise contact nodes without partner have no equations (Fig. 2a, the way of [9])
    logical, intent(in) :: has_partners
    type(reduced_domain_t), intent(out) :: domain
    type(growth_t) :: growth
    logical, allocatable :: is_seed(:), is_facing(:)
    integer, allocatable :: partner(:)
    integer :: i_seed

    allocate (is_seed(mesh%n_nodes), is_facing(mesh%n_nodes), source=.false.)
    is_seed(seed_nodes) = .true.
    domain%seed_nodes = true_indices(is_seed)
    partner = partner_of_nodes(operator, mesh%n_nodes)
    call start_growth(mesh, growth)
    do i_seed = 1, size(domain%seed_nodes)
      associate (node => domain%seed_nodes(i_seed))
        call take_cells_around(mesh, node, growth)
        if (partner(node) == 0 .or. .not. has_partners) cycle
        if (.not. is_seed(partner(node))) is_facing(partner(node)) = .true.
        call take_cells_around(mesh, partner(node), growth)
      end associate
    end do
    if (has_partners) then
      call close_pairs(mesh, partner, growth, is_facing)
    else
      call remove_unpaired(partner, growth)
    end if
    domain%facing_nodes = true_indices(is_facing)
    call collect_sets(mesh, operator, growth, domain)
  end subroutine build_reduced_domain

  !> Node on the other side of the contact, 0 where there is none; shape (n_nodes).
  pure function partner_of_nodes(operator, n_nodes) result(partner)
    type(contact_operator_t), intent(in) :: operator
    integer, intent(in) :: n_nodes
    integer, allocatable :: partner(:)

    allocate (partner(n_nodes), source=0)
    partner(operator%first_node) = operator%second_node
    partner(pack(operator%second_node, operator%second_node > 0)) = pack(operator%first_node, operator%second_node > 0)
  end function partner_of_nodes

  pure subroutine start_growth(mesh, growth)
    type(mesh_t), intent(in) :: mesh
    type(growth_t), intent(out) :: growth

    call cells_around_nodes(mesh, growth%offsets, growth%cells)
    growth%n_outside = growth%offsets(2:) - growth%offsets(:mesh%n_nodes)
    allocate (growth%is_inside(mesh%n_cells), source=.false.)
    allocate (growth%interior_nodes(mesh%n_nodes), source=0)
  end subroutine start_growth

  !> Puts the support of a node's shape function into the domain and notes the nodes that become interior by it.
  pure subroutine take_cells_around(mesh, node, growth)
    type(mesh_t), intent(in) :: mesh
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

  !> Adds partners of interior nodes, and of those that become interior by it, until none is missing.
  pure subroutine close_pairs(mesh, partner, growth, is_facing)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: partner(:)
    type(growth_t), intent(inout) :: growth
    logical, intent(inout) :: is_facing(:)
    integer :: i_interior, node

    i_interior = 0
    do while (i_interior < growth%n_interior)
      i_interior = i_interior + 1
      node = partner(growth%interior_nodes(i_interior))
      if (node == 0) cycle
      if (growth%n_outside(node) == 0) cycle
      is_facing(node) = .true.
      call take_cells_around(mesh, node, growth)
    end do
  end subroutine close_pairs

  !> Takes contact nodes whose partner is not interior from the interior nodes; their cells stay.
  pure subroutine remove_unpaired(partner, growth)
    integer, intent(in) :: partner(:)
    type(growth_t), intent(inout) :: growth
    integer, allocatable :: nodes(:)
    logical :: is_complete(0:size(partner))

    nodes = growth%interior_nodes(:growth%n_interior)
    is_complete = .false.
    is_complete(nodes) = .true.
    is_complete(0) = .true.
    nodes = pack(nodes, is_complete(partner(nodes)))
    growth%n_interior = size(nodes)
    growth%interior_nodes(:size(nodes)) = nodes
  end subroutine remove_unpaired

  !> Reads the sets off a finished domain.
  !>
  !> (7) asks for K_ij /= 0: I is all that is left on the cells that touch an interior node.
  pure subroutine collect_sets(mesh, operator, growth, domain)
    type(mesh_t), intent(in) :: mesh
    type(contact_operator_t), intent(in) :: operator
    type(growth_t), intent(in) :: growth
    type(reduced_domain_t), intent(inout) :: domain
    logical :: is_interior(mesh%n_nodes), is_interface(mesh%n_nodes), is_contact(mesh%n_dim * mesh%n_nodes)
    logical :: is_row(operator%n_rows)
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
    do i_row = 1, operator%n_rows
      do i_entry = 1, operator%n_entries(i_row)
        dof = operator%dofs(i_entry, i_row)
        if (operator%coefficients(i_entry, i_row) == 0 .or. .not. is_interior((dof - 1) / mesh%n_dim + 1)) cycle
        is_contact(dof) = .true.
        is_row(i_row) = .true.
      end do
    end do
    domain%contact_dofs = true_indices(is_contact)
    domain%contact_rows = true_indices(is_row)
  end subroutine collect_sets

  !> Nodes that carry the dofs, ascending, each once: what turns interpolation rows into seed nodes.
  pure function nodes_of_dofs(dofs, n_dim) result(nodes)
    !> natural
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
