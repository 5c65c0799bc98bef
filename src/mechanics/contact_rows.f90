! SPDX-License-Identifier: BSD-3-Clause
!> The contact matrix B and the gap D of (3) as sparse rows. A row may belong to a pair of nodes, to a node and an obstacle, or to a
!> mortar contact. There are far fewer rows than dofs, so every rank holds all of them.
module sig_contact_rows
  use sig_cross_products, only: cross_product, plane_cross_product
  use sig_kinds, only: rk
  use sig_rounding, only: rounding
  implicit none(type, external)
  private
  public :: contact_rows_t, create_contact_rows, separate_inert_rows

  !> Row k says: coefficients(i) u(dofs(i)), summed over i = offsets(k) + 1 ... offsets(k + 1), <= gap(k, :) . theta.
  !>
  !> A row has all components of each of its nodes. The owner comes first. It is the node of the first side that carries the
  !> multiplier as a nodal force, and its coefficients lie along the normal, from the first side to the second. They are the unit
  !> normal if the owner is the only node of its side. A row may have further nodes of the first side, which own other rows or none.
  type :: contact_rows_t
    integer :: n_rows = 0
    integer :: n_dim = 0
    !> entries of row k are offsets(k) + 1 ... offsets(k + 1); shape (n_rows + 1)
    integer, allocatable :: offsets(:)
    !> entries of row k up to splits(k) belong to the first side, the others to the second side; an obstacle has no second side;
    !> shape (n_rows)
    integer, allocatable :: splits(:)
    !> natural dof of each entry, shape (offsets(n_rows + 1))
    integer, allocatable :: dofs(:)
    !> [-] same shape
    real(rk), allocatable :: coefficients(:)
    !> [length] D = gap * theta, shape (n_rows, n_terms)
    real(rk), allocatable :: gap(:, :)
    !> [length**2, length in the plane] area of the row, in axisymmetry of the full turn: pressure = multiplier / area; shape
    !> (n_rows)
    real(rk), allocatable :: areas(:)
    !> entry of the deck's contact section that made the row, shape (n_rows)
    integer, allocatable :: contact_entry(:)
  contains
    procedure :: are_inert
    procedure :: apply
    procedure :: apply_transpose
    procedure :: dofs_of
    procedure :: coefficients_of
    procedure :: owners
    procedure :: nodes_of
    procedure :: first_nodes_of
    procedure :: second_nodes_of
    procedure :: rows_per_node
    procedure :: tied_nodes
    procedure :: list_side
    procedure :: weights_of
    procedure :: unit_resultants
    procedure :: unit_imbalances
    procedure :: select
    procedure :: append
  end type contact_rows_t

contains

  !> Makes the rows, one for each entry of n_first, from the lists of their nodes.
  pure subroutine create_contact_rows(n_first, n_second, nodes, weights, gap, areas, contact_entry, rows)
    !> how many nodes each row has on its first side (at least 1) and on its second side (0 with an obstacle), shape (n_rows)
    integer, intent(in) :: n_first(:), n_second(:)
    !> natural nodes, row by row: its owner, the other nodes of its first side, the nodes of its second side
    integer, intent(in) :: nodes(:)
    !> [-] coefficients of the nodes' components, shape (n_dim, size(nodes))
    real(rk), intent(in) :: weights(:, :)
    !> [length] gap of each row by terms: D = gap * theta; shape (n_rows, n_terms)
    real(rk), intent(in) :: gap(:, :)
    !> [length**2, length in the plane] shape (n_rows)
    real(rk), intent(in) :: areas(:)
    !> entry of the deck's contact section that made each row, shape (n_rows)
    integer, intent(in) :: contact_entry(:)
    type(contact_rows_t), intent(out) :: rows
    integer :: i, k

    rows%n_rows = size(n_first)
    rows%n_dim = size(weights, 1)
    allocate (rows%offsets(rows%n_rows + 1), source=0)
    do k = 1, rows%n_rows
      rows%offsets(k + 1) = rows%offsets(k) + rows%n_dim * (n_first(k) + n_second(k))
    end do
    rows%splits = rows%offsets(:rows%n_rows) + rows%n_dim * n_first
    allocate (rows%dofs(size(weights)))
    do i = 1, rows%n_dim
      rows%dofs(i::rows%n_dim) = rows%n_dim * (nodes - 1) + i
    end do
    rows%coefficients = reshape(weights, [size(weights)])
    rows%gap = gap
    rows%areas = areas
    rows%contact_entry = contact_entry
  end subroutine create_contact_rows

  !> Divides the rows into those with a multiplier and inert ones (are_inert); both keep their order. Inert rows have no multiplier,
  !> and only their gaps are checked.
  pure subroutine separate_inert_rows(all_rows, is_prescribed, rows, inert)
    type(contact_rows_t), intent(in) :: all_rows
    !> whether each natural dof is prescribed, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    type(contact_rows_t), intent(out) :: rows
    type(contact_rows_t), intent(out) :: inert
    logical :: is_inert(all_rows%n_rows)
    integer :: k

    is_inert = all_rows%are_inert(is_prescribed)
    rows = all_rows%select(pack([(k, k=1, all_rows%n_rows)], .not. is_inert))
    inert = all_rows%select(pack([(k, k=1, all_rows%n_rows)], is_inert))
  end subroutine separate_inert_rows

  !> Returns which rows are inert: all their dofs are prescribed, except for dofs whose coefficient is only rounding.
  pure function are_inert(self, is_prescribed) result(is_inert)
    class(contact_rows_t), intent(in) :: self
    !> whether each natural dof is prescribed, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    logical :: is_inert(self%n_rows)
    integer :: k

    do k = 1, self%n_rows
      is_inert(k) = .not. any(.not. is_prescribed(self%dofs_of(k)) .and. abs(self%coefficients_of(k)) > rounding)
    end do
  end function are_inert

  !> Returns B u, the amount by which the gap of each row has become smaller.
  pure function apply(self, displacement) result(closing)
    class(contact_rows_t), intent(in) :: self
    !> [length] shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    !> [length] shape (n_rows)
    real(rk) :: closing(self%n_rows)
    integer :: k

    do k = 1, self%n_rows
      associate (first => self%offsets(k) + 1, last => self%offsets(k + 1))
        closing(k) = dot_product(self%coefficients(first:last), displacement(self%dofs(first:last)))
      end associate
    end do
  end function apply

  !> Returns B' lambda of K u + B' lambda = F. The contact forces that act on the dofs are its opposite.
  pure function apply_transpose(self, multipliers, n_dofs) result(forces)
    class(contact_rows_t), intent(in) :: self
    !> [force] shape (n_rows)
    real(rk), intent(in) :: multipliers(:)
    !> number of all dofs: length of the result
    integer, intent(in) :: n_dofs
    !> [force] shape (n_dofs)
    real(rk) :: forces(n_dofs)
    integer :: i, k

    forces = 0
    do k = 1, self%n_rows
      do i = self%offsets(k) + 1, self%offsets(k + 1)
        forces(self%dofs(i)) = forces(self%dofs(i)) + self%coefficients(i) * multipliers(k)
      end do
    end do
  end function apply_transpose

  !> Returns the natural dofs of a row, all components of each node of nodes_of, one node after the other.
  pure function dofs_of(self, row) result(dofs)
    class(contact_rows_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: row
    integer :: dofs(self%offsets(row + 1) - self%offsets(row))

    dofs = self%dofs(self%offsets(row) + 1:self%offsets(row + 1))
  end function dofs_of

  !> Returns the coefficients of a row, in the order of dofs_of.
  pure function coefficients_of(self, row) result(coefficients)
    class(contact_rows_t), intent(in) :: self
    integer, intent(in) :: row
    !> [-]
    real(rk) :: coefficients(self%offsets(row + 1) - self%offsets(row))

    coefficients = self%coefficients(self%offsets(row) + 1:self%offsets(row + 1))
  end function coefficients_of

  !> Returns the owner of each row: the natural number of the node that carries the multiplier.
  pure function owners(self)
    class(contact_rows_t), intent(in) :: self
    integer :: owners(self%n_rows)

    owners = (self%dofs(self%offsets(:self%n_rows) + 1) - 1) / self%n_dim + 1
  end function owners

  !> Returns the natural nodes of a row: the owner, the rest of the first side, then the second side.
  pure function nodes_of(self, row) result(nodes)
    class(contact_rows_t), intent(in) :: self
    integer, intent(in) :: row
    integer, allocatable :: nodes(:)

    nodes = [self%first_nodes_of(row), self%second_nodes_of(row)]
  end function nodes_of

  !> Returns the natural nodes of a row on the first side, the owner first.
  pure function first_nodes_of(self, row) result(nodes)
    class(contact_rows_t), intent(in) :: self
    integer, intent(in) :: row
    integer :: nodes((self%splits(row) - self%offsets(row)) / self%n_dim)

    nodes = (self%dofs(self%offsets(row) + 1:self%splits(row):self%n_dim) - 1) / self%n_dim + 1
  end function first_nodes_of

  !> Returns the natural nodes of a row on the second side; empty for an obstacle.
  pure function second_nodes_of(self, row) result(nodes)
    class(contact_rows_t), intent(in) :: self
    integer, intent(in) :: row
    integer :: nodes((self%offsets(row + 1) - self%splits(row)) / self%n_dim)

    nodes = (self%dofs(self%splits(row) + 1:self%offsets(row + 1):self%n_dim) - 1) / self%n_dim + 1
  end function second_nodes_of

  !> Returns for each natural node the number of rows that contain it.
  pure function rows_per_node(self, n_nodes) result(n)
    class(contact_rows_t), intent(in) :: self
    integer, intent(in) :: n_nodes
    integer :: n(n_nodes)
    integer :: k

    n = 0
    do k = 1, self%n_rows
      associate (nodes => self%nodes_of(k))
        n(nodes) = n(nodes) + 1
      end associate
    end do
  end function rows_per_node

  !> Finds the rows that have exactly one node on each side, where neither node is in another row, and lists these nodes. The
  !> partition keeps both nodes of such a row on one rank.
  pure subroutine tied_nodes(self, n_nodes, first, second)
    class(contact_rows_t), intent(in) :: self
    integer, intent(in) :: n_nodes
    !> natural nodes of the first and of the second side, same shape; no node is there twice
    integer, allocatable, intent(out) :: first(:), second(:)
    integer :: k, n(n_nodes), nodes(2, self%n_rows)
    logical :: is_tied(self%n_rows)

    n = self%rows_per_node(n_nodes)
    is_tied = .false.
    do k = 1, self%n_rows
      if (self%splits(k) - self%offsets(k) /= self%n_dim .or. self%offsets(k + 1) - self%splits(k) /= self%n_dim) cycle
      nodes(:, k) = self%nodes_of(k)
      is_tied(k) = all(n(nodes(:, k)) == 1)
    end do
    first = pack(nodes(1, :), is_tied)
    second = pack(nodes(2, :), is_tied)
  end subroutine tied_nodes

  !> Lists the nodes of one side of all rows and their weights, for files. Those of row k are the entries starts(k) + 1 ... starts(k
  !> + 1) of both lists; on the first side the owner comes first. An obstacle has no nodes on the second side.
  pure subroutine list_side(self, is_second, starts, nodes, weights)
    class(contact_rows_t), intent(in) :: self
    !> whether to list the second side, and not the first
    logical, intent(in) :: is_second
    !> shape (n_rows + 1)
    integer, allocatable, intent(out) :: starts(:)
    !> natural
    integer, allocatable, intent(out) :: nodes(:)
    !> [-] share of the row's force on each node, shape (size(nodes))
    real(rk), allocatable, intent(out) :: weights(:)
    real(rk), allocatable :: row_weights(:)
    integer :: first(self%n_rows), last(self%n_rows), i, k

    first = merge(self%splits, self%offsets(:self%n_rows), is_second) + 1
    last = merge(self%offsets(2:), self%splits, is_second)
    allocate (starts(self%n_rows + 1), source=0)
    do k = 1, self%n_rows
      starts(k + 1) = starts(k) + (last(k) + 1 - first(k)) / self%n_dim
    end do
    associate (entries => [((i, i=first(k), last(k), self%n_dim), k=1, self%n_rows)])
      nodes = (self%dofs(entries) - 1) / self%n_dim + 1
    end associate
    allocate (weights(size(nodes)))
    do k = 1, self%n_rows
      row_weights = self%weights_of(k)
      associate (from => (first(k) - self%offsets(k) - 1) / self%n_dim, n => starts(k + 1) - starts(k))
        weights(starts(k) + 1:starts(k + 1)) = row_weights(from + 1:from + n)
      end associate
    end do
  end subroutine list_side

  !> Returns the share of the row's force that each of its nodes carries, in the order of nodes_of. The shares of each side sum up
  !> to 1; an obstacle has no second side. A share of a mortar row may be negative: this node is pulled where the others are pushed.
  pure function weights_of(self, row) result(weights)
    class(contact_rows_t), intent(in) :: self
    integer, intent(in) :: row
    !> [-]
    real(rk) :: weights((self%offsets(row + 1) - self%offsets(row)) / self%n_dim)
    integer :: i

    associate (first => self%offsets(row) + 1, n_first => (self%splits(row) - self%offsets(row)) / self%n_dim)
      do i = 1, size(weights)
        associate (coefficients => self%coefficients(first + (i - 1) * self%n_dim:first + i * self%n_dim - 1))
          weights(i) = sign(norm2(coefficients), dot_product(coefficients, self%coefficients(first:first + self%n_dim - 1)))
        end associate
        if (i > n_first) weights(i) = -weights(i)
      end do
    end associate
  end function weights_of

  !> Computes for each row, for a multiplier of 1, the resultant of the contact forces that act on its first side, and their moment
  !> about the origin: x cross f, in the plane (and in the half plane of axisymmetry) x f_y - y f_x. These forces are the opposite
  !> of the coefficients: they push the first side away from the second one.
  pure subroutine unit_resultants(self, coordinates, forces, moments)
    class(contact_rows_t), intent(in) :: self
    !> [length] natural, shape (n_dim, n_nodes)
    real(rk), intent(in) :: coordinates(:, :)
    !> [-] shape (n_dim, n_rows)
    real(rk), allocatable, intent(out) :: forces(:, :)
    !> [length] shape (1 or 3, n_rows)
    real(rk), allocatable, intent(out) :: moments(:, :)
    integer :: k

    allocate (forces(self%n_dim, self%n_rows), moments(merge(3, 1, self%n_dim == 3), self%n_rows))
    do k = 1, self%n_rows
      call add_up(self, coordinates, self%offsets(k), self%splits(k), forces(:, k), moments(:, k))
    end do
  end subroutine unit_resultants

  !> Returns for each row, for a multiplier of 1, the moment about the origin of the contact forces on both of its sides together.
  !> The resultants of both sides cancel, but they may act on different lines. For a row with an obstacle the result is 0, because
  !> the force on the obstacle is not in the row.
  pure function unit_imbalances(self, coordinates) result(moments)
    class(contact_rows_t), intent(in) :: self
    !> [length] natural, shape (n_dim, n_nodes)
    real(rk), intent(in) :: coordinates(:, :)
    !> [length] shape (1 or 3, n_rows)
    real(rk) :: moments(merge(3, 1, self%n_dim == 3), self%n_rows)
    real(rk) :: force(self%n_dim)
    integer :: k

    moments = 0
    do k = 1, self%n_rows
      if (self%splits(k) == self%offsets(k + 1)) cycle
      call add_up(self, coordinates, self%offsets(k), self%offsets(k + 1), force, moments(:, k))
    end do
  end function unit_imbalances

  !> Computes resultant and moment of the contact forces that a multiplier of 1 exerts on some nodes of a row. Results and
  !> coordinates are those of unit_resultants.
  pure subroutine add_up(self, coordinates, first, last, force, moment)
    class(contact_rows_t), intent(in) :: self
    real(rk), intent(in) :: coordinates(:, :)
    !> their dofs are dofs(first + 1:last) of self
    integer, intent(in) :: first, last
    real(rk), intent(out) :: force(:), moment(:)
    real(rk) :: part(size(force))
    integer :: i, node

    force = 0
    moment = 0
    do i = first + 1, last, self%n_dim
      ! the coefficients are what the stiffness balances, the opposite of the force
      part = -self%coefficients(i:i + self%n_dim - 1)
      node = (self%dofs(i) - 1) / self%n_dim + 1
      force = force + part
      if (self%n_dim == 3) then
        moment = moment + cross_product(coordinates(:, node), part)
      else
        moment = moment + plane_cross_product(coordinates(:, node), part)
      end if
    end do
  end subroutine add_up

  !> Returns some of the rows, in the given order.
  pure function select(self, indices) result(rows)
    class(contact_rows_t), intent(in) :: self
    !> rows to take, 1-based
    integer, intent(in) :: indices(:)
    type(contact_rows_t) :: rows
    integer :: i, k

    associate (entries => [((i, i=self%offsets(indices(k)) + 1, self%offsets(indices(k) + 1)), k=1, size(indices))])
      rows%dofs = self%dofs(entries)
      rows%coefficients = self%coefficients(entries)
    end associate
    rows%n_rows = size(indices)
    rows%n_dim = self%n_dim
    allocate (rows%offsets(rows%n_rows + 1), source=0)
    do k = 1, rows%n_rows
      rows%offsets(k + 1) = rows%offsets(k) + self%offsets(indices(k) + 1) - self%offsets(indices(k))
    end do
    rows%splits = rows%offsets(:rows%n_rows) + self%splits(indices) - self%offsets(indices)
    rows%gap = self%gap(indices, :)
    rows%areas = self%areas(indices)
    rows%contact_entry = self%contact_entry(indices)
  end function select

  !> Appends other rows. The gaps of the present rows get zeros for the terms that only the other rows have. Requires: both were
  !> made and have the same n_dim.
  pure subroutine append(self, more)
    class(contact_rows_t), intent(inout) :: self
    !> its gaps have at least as many terms as those of the present rows, and the same terms first
    type(contact_rows_t), intent(in) :: more
    real(rk) :: gap(self%n_rows + more%n_rows, size(more%gap, 2))

    gap = 0
    gap(:self%n_rows, :size(self%gap, 2)) = self%gap
    gap(self%n_rows + 1:, :) = more%gap
    self%gap = gap
    associate (n_entries => size(self%dofs))
      self%splits = [self%splits, more%splits + n_entries]
      self%offsets = [self%offsets, more%offsets(2:) + n_entries]
    end associate
    self%dofs = [self%dofs, more%dofs]
    self%coefficients = [self%coefficients, more%coefficients]
    self%areas = [self%areas, more%areas]
    self%contact_entry = [self%contact_entry, more%contact_entry]
    self%n_rows = self%n_rows + more%n_rows
  end subroutine append
end module sig_contact_rows
