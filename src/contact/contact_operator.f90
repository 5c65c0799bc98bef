! SPDX-License-Identifier: BSD-3-Clause
!> The contact matrix B and the gap D of (3) from node pairs. Its rows are few and short, so every rank holds all of them.
module sig_contact_operator
  use sig_kinds, only: rk
  use sig_node_pairs, only: node_pairs_t
  implicit none(type, external)
  private
  public :: contact_operator_t, create_contact_operator

  !> Row k says: coefficients(:, k) . u(dofs(:, k)) <= gap(k, :) . theta.
  type :: contact_operator_t
    integer :: n_rows = 0
    integer :: n_dim = 0
    !> shape (n_rows), index of the row's pair
    integer, allocatable :: pair_of_row(:)
    !> shape (n_rows), natural
    integer, allocatable :: first_node(:)
    integer, allocatable :: second_node(:)
    !> natural dofs of the first node, then of the second, shape (2 * n_dim, n_rows)
    integer, allocatable :: dofs(:, :)
    !> [-] +n on the first node and -n on the second, shape (2 * n_dim, n_rows); B B' = 2 I
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
    integer :: i_row, i_component

    operator%n_dim = n_dim
    operator%n_rows = size(pair_of_row)
    operator%pair_of_row = pair_of_row
    operator%first_node = pairs%first_node(pair_of_row)
    operator%second_node = pairs%second_node(pair_of_row)
    allocate (operator%dofs(2 * n_dim, operator%n_rows), operator%coefficients(2 * n_dim, operator%n_rows))
    do i_row = 1, operator%n_rows
      do i_component = 1, n_dim
        operator%dofs(i_component, i_row) = n_dim * (operator%first_node(i_row) - 1) + i_component
        operator%dofs(n_dim + i_component, i_row) = n_dim * (operator%second_node(i_row) - 1) + i_component
      end do
      operator%coefficients(:n_dim, i_row) = pairs%normal(:, pair_of_row(i_row))
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

  !> No free displacement has a part in the pair's row.
  pure logical function row_is_prescribed(pairs, i_pair, n_dim, is_prescribed)
    type(node_pairs_t), intent(in) :: pairs
    integer, intent(in) :: i_pair
    integer, intent(in) :: n_dim
    logical, intent(in) :: is_prescribed(:)
    !> a component of the unit normal below this is rounding of the deck's direction
    real(rk), parameter :: negligible = 1.0e-12_rk
    logical :: is_free(n_dim)

    associate (a => n_dim * (pairs%first_node(i_pair) - 1), b => n_dim * (pairs%second_node(i_pair) - 1))
      is_free = .not. (is_prescribed(a + 1:a + n_dim) .and. is_prescribed(b + 1:b + n_dim))
    end associate
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
      closing(i_row) = dot_product(self%coefficients(:, i_row), displacement(self%dofs(:, i_row)))
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
      forces(self%dofs(:, i_row)) = forces(self%dofs(:, i_row)) + self%coefficients(:, i_row) * multipliers(i_row)
    end do
  end function apply_transpose
end module sig_contact_operator
