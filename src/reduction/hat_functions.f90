! SPDX-License-Identifier: BSD-3-Clause
!> The finite element shape functions of contact nodes, along the contact normal: what a basis is enriched with, (12).
module sig_hat_functions
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  use sig_reduced_domain, only: reduced_domain_t
  implicit none(type, external)
  private
  public :: hat_set_t, hats_of_rows, hats_of_all_nodes, hat_columns, select_hats

  !> [-] a component of the unit normal below this is rounding of the deck's direction
  real(rk), parameter :: negligible = 1.0e-12_rk

  !> Hat i moves one node along the contact normal, as far as no displacement of the node is prescribed.
  type :: hat_set_t
    !> contact row of the domain, shape (n_hats)
    integer, allocatable :: rows(:)
    !> natural, shape (n_hats)
    integer, allocatable :: nodes(:)
    !> [-] normal on the free components, 0 on the others, shape (n_dim, n_hats)
    real(rk), allocatable :: values(:, :)
    !> [-] the hat in its own contact row, B hat; all other rows are zero; shape (n_hats)
    real(rk), allocatable :: entries(:)
  end type hat_set_t

contains

  !> One hat per contact row of the domain, in their order: on the node of one side or, where that has none that can move along the
  !> normal, of the other.
  !>
  !> The hats of both sides have the same contact row but for the sign, so they do the same to kappa. Source: section 3.3. Local.
  pure function hats_of_rows(rows, domain, is_prescribed, is_second) result(hats)
    type(contact_rows_t), intent(in) :: rows
    type(reduced_domain_t), intent(in) :: domain
    !> shape (n_dofs), natural
    logical, intent(in) :: is_prescribed(:)
    !> prefer the second body
    logical, intent(in) :: is_second
    type(hat_set_t) :: hats
    type(hat_set_t) :: preferred, other
    integer :: i

    preferred = hats_of_side(rows, domain, is_prescribed, is_second)
    other = hats_of_side(rows, domain, is_prescribed, .not. is_second)
    hats = preferred
    do i = 1, size(hats%rows)
      if (abs(preferred%entries(i)) > 0) cycle
      hats%nodes(i) = other%nodes(i)
      hats%values(:, i) = other%values(:, i)
      hats%entries(i) = other%entries(i)
    end do
    hats = select_hats(hats, movable(hats))
  end function hats_of_rows

  !> Both hats of every pair, L_C = A_c of [9]: all of one body, then those of the other.
  pure function hats_of_all_nodes(rows, domain, is_prescribed, is_second) result(hats)
    type(contact_rows_t), intent(in) :: rows
    type(reduced_domain_t), intent(in) :: domain
    logical, intent(in) :: is_prescribed(:)
    !> start with the second body
    logical, intent(in) :: is_second
    type(hat_set_t) :: hats
    type(hat_set_t) :: one, other
    integer :: n

    one = hats_of_side(rows, domain, is_prescribed, is_second)
    other = hats_of_side(rows, domain, is_prescribed, .not. is_second)
    n = size(one%rows)
    hats%rows = [one%rows, other%rows]
    hats%nodes = [one%nodes, other%nodes]
    allocate (hats%values(rows%n_dim, 2 * n))
    hats%values(:, :n) = one%values
    hats%values(:, n + 1:) = other%values
    hats%entries = [one%entries, other%entries]
    hats = select_hats(hats, movable(hats))
  end function hats_of_all_nodes

  !> The hats of one side, with zeros where nothing can move: on the owners, or where a second side is one node. A node that meets
  !> other rows has none, because a hat must leave them alone.
  pure function hats_of_side(rows, domain, is_prescribed, is_second) result(hats)
    type(contact_rows_t), intent(in) :: rows
    type(reduced_domain_t), intent(in) :: domain
    logical, intent(in) :: is_prescribed(:)
    logical, intent(in) :: is_second
    type(hat_set_t) :: hats
    integer :: i, n_rows(size(is_prescribed) / rows%n_dim), row, start

    n_rows = rows%rows_per_node(size(n_rows))
    hats%rows = [(i, i=1, size(domain%contact_rows))]
    allocate (hats%nodes(size(hats%rows)), source=0)
    allocate (hats%values(rows%n_dim, size(hats%rows)), source=0.0_rk)
    allocate (hats%entries(size(hats%rows)), source=0.0_rk)
    do i = 1, size(hats%rows)
      row = domain%contact_rows(i)
      start = merge(rows%splits(row), rows%offsets(row), is_second)
      if (is_second .and. rows%offsets(row + 1) - start /= rows%n_dim) cycle
      associate (dofs => rows%dofs(start + 1:start + rows%n_dim), normal => rows%coefficients( &
        rows%offsets(row) + 1:rows%offsets(row) + rows%n_dim))
        hats%nodes(i) = (dofs(1) - 1) / rows%n_dim + 1
        if (n_rows(hats%nodes(i)) > 1) cycle
        hats%values(:, i) = merge(0.0_rk, normal, is_prescribed(dofs) .or. abs(normal) <= negligible)
        hats%entries(i) = dot_product(rows%coefficients(start + 1:start + rows%n_dim), hats%values(:, i))
      end associate
    end do
  end function hats_of_side

  pure function movable(hats) result(indices)
    type(hat_set_t), intent(in) :: hats
    integer, allocatable :: indices(:)
    integer :: i

    indices = pack([(i, i=1, size(hats%entries))], abs(hats%entries) > 0)
  end function movable

  !> Some hats of a set, in the given order.
  pure function select_hats(hats, indices) result(selected)
    type(hat_set_t), intent(in) :: hats
    integer, intent(in) :: indices(:)
    type(hat_set_t) :: selected

    selected%rows = hats%rows(indices)
    selected%nodes = hats%nodes(indices)
    selected%values = hats%values(:, indices)
    selected%entries = hats%entries(indices)
  end function select_hats

  !> The hats as displacement fields, shape (n_dofs, n_hats).
  pure function hat_columns(hats, n_dofs) result(columns)
    type(hat_set_t), intent(in) :: hats
    integer, intent(in) :: n_dofs
    !> [-]
    real(rk), allocatable :: columns(:, :)
    integer :: i, n_dim

    n_dim = size(hats%values, 1)
    allocate (columns(n_dofs, size(hats%nodes)), source=0.0_rk)
    do i = 1, size(hats%nodes)
      columns(n_dim * (hats%nodes(i) - 1) + 1:n_dim * hats%nodes(i), i) = hats%values(:, i)
    end do
  end function hat_columns
end module sig_hat_functions
