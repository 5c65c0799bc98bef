! SPDX-License-Identifier: BSD-3-Clause
!> The contact matrix B and the gap D of (3) from node pairs and nodes that face an obstacle. Its rows are few and short, so every
!> rank holds all of them.
module sig_contact_operator
  use sig_kinds, only: rk
  use sig_node_pairs, only: node_pairs_t
  implicit none(type, external)
  private
  public :: contact_operator_t, create_contact_operator

  !> Row k says: coefficients(:n, k) . u(dofs(:n, k)) <= gap(k, :) . theta with n = n_entries(k).
  !>
  !> A row of a rigid obstacle has the entries of its first node only, and second_node 0: the rest of its columns is 0, and no
  !> dof.
  type :: contact_operator_t
    integer :: n_rows = 0
    integer :: n_dim = 0
    !> shape (n_rows), index of the row's pair
    integer, allocatable :: pair_of_row(:)
    !> shape (n_rows), natural
    integer, allocatable :: first_node(:)
    !> 0 = a rigid obstacle
    integer, allocatable :: second_node(:)
    !> 2 * n_dim, with an obstacle n_dim; shape (n_rows)
    integer, allocatable :: n_entries(:)
    !> natural dofs of the first node, then of the second, shape (2 * n_dim, n_rows)
    integer, allocatable :: dofs(:, :)
    !> [-] +n on the first node and -n on the second, shape (2 * n_dim, n_rows); B B' is 2 for pairs, 1 for obstacles
    real(rk), allocatable :: coefficients(:, :)
    !> [length] D = gap * theta, shape (n_rows, n_terms)
    real(rk), allocatable :: gap(:, :)
  contains
    procedure :: apply
    procedure :: apply_transpose
  end type contact_operator_t

contains

  !> Builds the rows. A pair whose row meets only prescribed displacements is inert: it gets no multiplier, its gap is checked.
  pure subroutine create_contact_operator(pairs, n_dim, n_terms, is_prescribed, operator, inert)
    type(node_pairs_t), intent(in) :: pairs
    integer, intent(in) :: n_dim
    integer, intent(in) :: n_terms
    !> shape (n_dofs), natural
    logical, intent(in) :: is_prescribed(:)
    type(contact_operator_t), intent(out) :: operator
    !> rows of the inert pairs
    type(contact_operator_t), intent(out) :: inert
    integer :: i_pair
    logical :: is_inert(pairs%n_pairs)

    do i_pair = 1, pairs%n_pairs
      is_inert(i_pair) = row_is_prescribed(pairs, i_pair, n_dim, is_prescribed)
    end do
    call fill_rows(pairs, pack([(i_pair, i_pair=1, pairs%n_pairs)], .not. is_inert), n_dim, n_terms, operator)
    call fill_rows(pairs, pack([(i_pair, i_pair=1, pairs%n_pairs)], is_inert), n_dim, n_terms, inert)
  end subroutine create_contact_operator

  pure subroutine fill_rows(pairs, pair_of_row, n_dim, n_terms, operator)
    type(node_pairs_t), intent(in) :: pairs
    integer, intent(in) :: pair_of_row(:)
    integer, intent(in) :: n_dim
    integer, intent(in) :: n_terms
    type(contact_operator_t), intent(out) :: operator
    integer :: i_row

    operator%n_dim = n_dim
    operator%n_rows = size(pair_of_row)
    operator%pair_of_row = pair_of_row
    operator%first_node = pairs%first_node(pair_of_row)
    operator%second_node = pairs%second_node(pair_of_row)
    operator%n_entries = n_dim * merge(2, 1, operator%second_node > 0)
    allocate (operator%dofs(2 * n_dim, operator%n_rows), source=0)
    allocate (operator%coefficients(2 * n_dim, operator%n_rows), source=0.0_rk)
    do i_row = 1, operator%n_rows
      operator%dofs(:n_dim, i_row) = node_dofs(operator%first_node(i_row), n_dim)
      operator%coefficients(:n_dim, i_row) = pairs%normal(:, pair_of_row(i_row))
      if (operator%second_node(i_row) == 0) cycle
      operator%dofs(n_dim + 1:, i_row) = node_dofs(operator%second_node(i_row), n_dim)
      operator%coefficients(n_dim + 1:, i_row) = -pairs%normal(:, pair_of_row(i_row))
    end do
    allocate (operator%gap(operator%n_rows, n_terms), source=0.0_rk)
    operator%gap(:, 1) = pairs%initial_gap(pair_of_row)
    do i_row = 1, operator%n_rows
      associate (i_term => pairs%gap_term(pair_of_row(i_row)))
        if (i_term > 0) operator%gap(i_row, i_term) = operator%gap(i_row, i_term) + 1
      end associate
    end do
  end subroutine fill_rows

  pure function node_dofs(i_node, n_dim) result(dofs)
    integer, intent(in) :: i_node
    integer, intent(in) :: n_dim
    integer :: dofs(n_dim), i

    dofs = n_dim * (i_node - 1) + [(i, i=1, n_dim)]
  end function node_dofs

  !> No free displacement has a part in the pair's row.
  pure logical function row_is_prescribed(pairs, i_pair, n_dim, is_prescribed)
    type(node_pairs_t), intent(in) :: pairs
    integer, intent(in) :: i_pair
    integer, intent(in) :: n_dim
    logical, intent(in) :: is_prescribed(:)
    !> a component of the unit normal below this is rounding of the deck's direction
    real(rk), parameter :: negligible = 1.0e-12_rk
    logical :: is_free(n_dim)

    is_free = .not. is_prescribed(node_dofs(pairs%first_node(i_pair), n_dim))
    if (pairs%second_node(i_pair) > 0) is_free = is_free .or. &
      .not. is_prescribed(node_dofs(pairs%second_node(i_pair), n_dim))
    row_is_prescribed = .not. any(is_free .and. abs(pairs%normal(:, i_pair)) > negligible)
  end function row_is_prescribed

  !> B u: how far each pair has closed.
  pure function apply(self, displacement) result(closing)
    class(contact_operator_t), intent(in) :: self
    !> [length] shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    !> [length] shape (n_rows)
    real(rk) :: closing(self%n_rows)
    integer :: i_row

    do i_row = 1, self%n_rows
      associate (n => self%n_entries(i_row))
        closing(i_row) = dot_product(self%coefficients(:n, i_row), displacement(self%dofs(:n, i_row)))
      end associate
    end do
  end function apply

  !> B' lambda: the contact forces that the bodies' stiffness has to balance, on every dof.
  pure function apply_transpose(self, multipliers, n_dofs) result(forces)
    class(contact_operator_t), intent(in) :: self
    !> [force] shape (n_rows)
    real(rk), intent(in) :: multipliers(:)
    integer, intent(in) :: n_dofs
    !> [force] shape (n_dofs)
    real(rk) :: forces(n_dofs)
    integer :: i_row

    forces = 0
    do i_row = 1, self%n_rows
      associate (n => self%n_entries(i_row))
        forces(self%dofs(:n, i_row)) = forces(self%dofs(:n, i_row)) + self%coefficients(:n, i_row) * multipliers(i_row)
      end associate
    end do
  end function apply_transpose
end module sig_contact_operator
