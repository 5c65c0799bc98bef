! SPDX-License-Identifier: BSD-3-Clause
!> Integrals of a mortar contact over its first surface: areas, gaps, and the shares of the nodes of the second surface.
module sig_mortar_sums
  use sig_kinds, only: rk
  use sig_rounding, only: rounding
  implicit none(type, external)
  private
  public :: mortar_sums_t

  !> Sums of integrals with the dual function Phi_j of each node j of the first surface.
  type :: mortar_sums_t
    !> [length**2, length in the plane] integral of Phi_j, shape (n_nodes)
    real(rk), allocatable :: areas(:)
    !> [length**2, length in the plane] integral of max(abs(Phi_j), abs(N_j)), shape (n_nodes)
    real(rk), allocatable :: sizes(:)
    !> [length**3, length**2 in the plane] integral of Phi_j g, shape (n_nodes)
    real(rk), allocatable :: gaps(:)
    !> [length] smallest gap at the integration points of the facets of each node; huge if there are none; shape (n_nodes)
    real(rk), allocatable :: lowest(:)
    !> integrals of Phi_j N_l: node j, node l and value of entries 1 to n_shares
    integer :: n_shares = 0
    integer, allocatable :: firsts(:)
    integer, allocatable :: seconds(:)
    real(rk), allocatable :: shares(:)
    !> [length**2, length in the plane] areas of the first surface: all of it; the part that faces the second one and counts; the
    !> part that faces the second one beyond the search distance; the part that faces the second one but does not count, because
    !> too little of its facet does, or because the facet has no dual functions
    real(rk) :: whole = 0
    real(rk) :: covered = 0
    real(rk) :: far = 0
    real(rk) :: lost = 0
  contains
    procedure :: start
    procedure :: add_gaps
    procedure :: add_shares
    procedure :: has_row
    procedure :: mean_gap
    procedure :: collect
  end type mortar_sums_t

contains

  !> Sets all sums to zero.
  subroutine start(self, n_nodes)
    class(mortar_sums_t), intent(out) :: self
    !> number of nodes of the mesh
    integer, intent(in) :: n_nodes

    allocate (self%areas(n_nodes), self%sizes(n_nodes), self%gaps(n_nodes), source=0.0_rk)
    allocate (self%lowest(n_nodes), source=huge(1.0_rk))
    allocate (self%firsts(64), self%seconds(64), self%shares(64))
  end subroutine start

  !> Adds the integrals of Phi_j g over a facet.
  pure subroutine add_gaps(self, nodes, values, lowest)
    class(mortar_sums_t), intent(inout) :: self
    !> nodes j of the facet
    integer, intent(in) :: nodes(:)
    !> [length**3, length**2 in the plane] same shape
    real(rk), intent(in) :: values(:)
    !> [length] smallest gap of the facet
    real(rk), intent(in) :: lowest

    self%gaps(nodes) = self%gaps(nodes) + values
    self%lowest(nodes) = min(self%lowest(nodes), lowest)
  end subroutine add_gaps

  !> Adds the integrals of Phi_j N_l over a piece of a facet, as new entries; `collect` sums entries of the same two nodes.
  pure subroutine add_shares(self, firsts, seconds, values)
    class(mortar_sums_t), intent(inout) :: self
    !> nodes j of the first surface
    integer, intent(in) :: firsts(:)
    !> nodes l of the second surface
    integer, intent(in) :: seconds(:)
    !> [length**2, length in the plane] shape (size(firsts), size(seconds))
    real(rk), intent(in) :: values(:, :)
    integer :: l

    do while (self%n_shares + size(values) > size(self%shares))
      self%firsts = [self%firsts, self%firsts]
      self%seconds = [self%seconds, self%seconds]
      self%shares = [self%shares, self%shares]
    end do
    do l = 1, size(seconds)
      associate (from => self%n_shares + 1, to => self%n_shares + size(firsts))
        self%firsts(from:to) = firsts
        self%seconds(from:to) = seconds(l)
        self%shares(from:to) = values(:, l)
      end associate
      self%n_shares = self%n_shares + size(firsts)
    end do
  end subroutine add_shares

  !> Whether a node of the first surface has a row. Its integral of Phi_j must be larger than a hundredth of its `sizes`, because
  !> huge shares are of no use: a share is at most integral abs(Phi_j) over integral Phi_j in size. So a node on which a uniform
  !> pressure has no force has no row.
  pure elemental logical function has_row(self, node)
    class(mortar_sums_t), intent(in) :: self
    !> natural, 1-based
    integer, intent(in) :: node
    !> [-]
    real(rk), parameter :: largest_share = 100.0_rk

    has_row = self%sizes(node) > 0 .and. largest_share * self%areas(node) > self%sizes(node)
  end function has_row

  !> Returns the mean gap integral Phi_j g / integral Phi_j [length], or 0 if it is negative though g is negative nowhere. Requires:
  !> has_row(node).
  pure elemental real(rk) function mean_gap(self, node)
    class(mortar_sums_t), intent(in) :: self
    !> natural, 1-based
    integer, intent(in) :: node

    mean_gap = self%gaps(node) / self%areas(node)
    if (self%lowest(node) >= 0) mean_gap = max(0.0_rk, mean_gap)
  end function mean_gap

  !> Computes w_jl, the share of each node of the second surface in the row of a node of the first one. The shares of owner k are
  !> entries offsets(k) + 1 ... offsets(k + 1), ascending by node. Those up to 1e-12 in size are left out as rounding. The others
  !> are divided by their sum, so that they add up to 1.
  pure subroutine collect(self, owners, offsets, nodes, shares)
    class(mortar_sums_t), intent(in) :: self
    !> nodes of the first surface for which has_row is true
    integer, intent(in) :: owners(:)
    !> shape (size(owners) + 1)
    integer, allocatable, intent(out) :: offsets(:)
    !> nodes of the second surface
    integer, allocatable, intent(out) :: nodes(:)
    !> [-]
    real(rk), allocatable, intent(out) :: shares(:)
    integer, allocatable :: next(:), order(:), own_nodes(:)
    real(rk), allocatable :: own_shares(:)
    integer :: k

    call sort_by_first(self, next, order)
    allocate (offsets(size(owners) + 1), source=0)
    allocate (nodes(self%n_shares), shares(self%n_shares))
    do k = 1, size(owners)
      call sum_by_node(self, order(next(owners(k)) + 1:next(owners(k) + 1)), own_nodes, own_shares)
      associate (is_kept => abs(own_shares) > rounding * self%areas(owners(k)))
        own_nodes = pack(own_nodes, is_kept)
        own_shares = pack(own_shares, is_kept)
      end associate
      offsets(k + 1) = offsets(k) + size(own_nodes)
      nodes(offsets(k) + 1:offsets(k + 1)) = own_nodes
      shares(offsets(k) + 1:offsets(k + 1)) = own_shares / sum(own_shares)
    end do
    nodes = nodes(:offsets(size(offsets)))
    shares = shares(:offsets(size(offsets)))
  end subroutine collect

  !> Finds the entries of each first node: those of node j are order(next(j) + 1:next(j + 1)), 1-based and ascending.
  pure subroutine sort_by_first(self, next, order)
    class(mortar_sums_t), intent(in) :: self
    integer, allocatable, intent(out) :: next(:), order(:)
    integer :: i, place(size(self%areas))

    allocate (next(size(self%areas) + 1), source=0)
    allocate (order(self%n_shares))
    do i = 1, self%n_shares
      next(self%firsts(i) + 1) = next(self%firsts(i) + 1) + 1
    end do
    do i = 2, size(next)
      next(i) = next(i) + next(i - 1)
    end do
    place = next(:size(place))
    do i = 1, self%n_shares
      associate (first => self%firsts(i))
        place(first) = place(first) + 1
        order(place(first)) = i
      end associate
    end do
  end subroutine sort_by_first

  !> Sums the values of some entries by their second node, nodes ascending.
  pure subroutine sum_by_node(self, entries, nodes, sums)
    class(mortar_sums_t), intent(in) :: self
    !> indices of the entries, 1-based
    integer, intent(in) :: entries(:)
    integer, allocatable, intent(out) :: nodes(:)
    real(rk), allocatable, intent(out) :: sums(:)
    integer :: last

    allocate (nodes(0), sums(0))
    last = 0
    do while (any(self%seconds(entries) > last))
      last = minval(pack(self%seconds(entries), self%seconds(entries) > last))
      nodes = [nodes, last]
      sums = [sums, sum(pack(self%shares(entries), self%seconds(entries) == last))]
    end do
  end subroutine sum_by_node
end module sig_mortar_sums
