! SPDX-License-Identifier: BSD-3-Clause
!> Hat functions (12): the finite element shape functions of contact nodes, along the contact normal. They are added to a basis to
!> make its contact rows well conditioned.
module sig_hat_functions
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  use sig_reduced_domain, only: reduced_domain_t
  use sig_rounding, only: rounding
  use sig_side_motions, only: find_followers, followers_t, following_motion
  implicit none(type, external)
  private
  public :: hat_set_t, hats_of_rows, hats_of_all_nodes, hat_columns, select_hats

  !> A set of hats. Hat i moves one node along the contact normal; prescribed components of the node do not move. Where other
  !> contact rows contain this node, their owners move, too, so that the openings of these rows do not change.
  type :: hat_set_t
    !> contact row of the hat, an index of domain%contact_rows, shape (n_hats)
    integer, allocatable :: rows(:)
    !> node that the hat moves, natural (order of the mesh file), shape (n_hats)
    integer, allocatable :: nodes(:)
    !> [-] displacement of this node: along the normal (normal_of), 0 in prescribed components; shape (n_dim, n_hats)
    real(rk), allocatable :: values(:, :)
    !> [-] entry of B hat in the row of the hat; all other entries are zero; shape (n_hats)
    real(rk), allocatable :: entries(:)
    !> nodes that move with hat i, and their displacements: entries starts(i) + 1 to starts(i + 1) of more_nodes and more_values;
    !> shapes (n_hats + 1), (n), (n_dim, n)
    integer, allocatable :: starts(:)
    integer, allocatable :: more_nodes(:)
    real(rk), allocatable :: more_values(:, :)
  end type hat_set_t

contains

  !> Returns at most one hat per contact row of the domain, in the order of the rows. The hat is on the preferred side, or on the
  !> other one where the preferred side cannot have a hat. A row where neither side can have one has no hat. A side can have a hat
  !> if a node can move along the normal (some component there is not prescribed) without changing other rows: on the first side the
  !> owner of the row, with which owners of other rows may have to move (more_nodes); on the second side its only node, if no other
  !> row has that node.
  !>
  !> Where both sides are single nodes without prescribed components, their hats change B V in the same way except for the sign, so
  !> both give the same kappa. Source: section 3.3. Local.
  pure function hats_of_rows(rows, domain, is_prescribed, is_second) result(hats)
    type(contact_rows_t), intent(in) :: rows
    type(reduced_domain_t), intent(in) :: domain
    !> whether each dof is prescribed, natural (order of the mesh file), shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    !> prefer the second side
    logical, intent(in) :: is_second
    type(hat_set_t) :: hats
    type(hat_set_t) :: both
    integer :: i, n

    both = joined(hats_of_side(rows, domain, is_prescribed, is_second), hats_of_side(rows, domain, is_prescribed, .not. is_second))
    n = size(domain%contact_rows)
    hats = select_hats(both, [(merge(i, n + i, abs(both%entries(i)) > 0), i=1, n)])
    hats = select_hats(hats, movable(hats))
  end function hats_of_rows

  !> Returns the hats of both sides of every contact row of the domain, where a side can have one: first all hats of the first
  !> side (with is_second: of the second), then those of the other. Conditions and arguments as for hats_of_rows.
  pure function hats_of_all_nodes(rows, domain, is_prescribed, is_second) result(hats)
    type(contact_rows_t), intent(in) :: rows
    type(reduced_domain_t), intent(in) :: domain
    logical, intent(in) :: is_prescribed(:)
    !> start with the second side
    logical, intent(in) :: is_second
    type(hat_set_t) :: hats

    hats = joined(hats_of_side(rows, domain, is_prescribed, is_second), hats_of_side(rows, domain, is_prescribed, .not. is_second))
    hats = select_hats(hats, movable(hats))
  end function hats_of_all_nodes

  !> Returns the hats of both sets, those of `one` first.
  pure function joined(one, other) result(hats)
    type(hat_set_t), intent(in) :: one, other
    type(hat_set_t) :: hats
    integer :: n_dim

    n_dim = size(one%values, 1)
    hats%rows = [one%rows, other%rows]
    hats%nodes = [one%nodes, other%nodes]
    hats%values = reshape([one%values, other%values], [n_dim, size(hats%nodes)])
    hats%entries = [one%entries, other%entries]
    hats%starts = [one%starts, size(one%more_nodes) + other%starts(2:)]
    hats%more_nodes = [one%more_nodes, other%more_nodes]
    hats%more_values = reshape([one%more_values, other%more_values], [n_dim, size(hats%more_nodes)])
  end function joined

  !> Returns the hats of one side: one per row of the domain, with values and entry 0 where there is no hat. The hats of the first
  !> side are on the owners of the rows. The second side has hats only where it is a single node. A hat must not change other rows.
  !> A node that other rows contain, too, has therefore a hat only on the first side, and only where the owners of these rows can
  !> follow.
  pure function hats_of_side(rows, domain, is_prescribed, is_second) result(hats)
    type(contact_rows_t), intent(in) :: rows
    type(reduced_domain_t), intent(in) :: domain
    !> as in hats_of_rows
    logical, intent(in) :: is_prescribed(:)
    !> the second side, otherwise the first
    logical, intent(in) :: is_second
    type(hat_set_t) :: hats
    type(followers_t) :: followers
    integer :: i, n_rows(size(is_prescribed) / rows%n_dim), row, start

    n_rows = rows%rows_per_node(size(n_rows))
    call find_followers(rows, size(n_rows), is_prescribed, followers)
    hats%rows = [(i, i=1, size(domain%contact_rows))]
    allocate (hats%nodes(size(hats%rows)), source=0)
    allocate (hats%values(rows%n_dim, size(hats%rows)), source=0.0_rk)
    allocate (hats%entries(size(hats%rows)), source=0.0_rk)
    allocate (hats%starts(size(hats%rows) + 1), source=0)
    allocate (hats%more_nodes(0), hats%more_values(rows%n_dim, 0))
    do i = 1, size(hats%rows)
      hats%starts(i + 1) = hats%starts(i)
      row = domain%contact_rows(i)
      start = merge(rows%splits(row), rows%offsets(row), is_second)
      if (is_second .and. rows%offsets(row + 1) - start /= rows%n_dim) cycle
      associate (dofs => rows%dofs(start + 1:start + rows%n_dim), normal => normal_of(rows, row))
        hats%nodes(i) = (dofs(1) - 1) / rows%n_dim + 1
        if (merge(n_rows(hats%nodes(i)) > 1, .not. followers%is_possible(row), is_second)) cycle
        hats%values(:, i) = merge(0.0_rk, normal, is_prescribed(dofs) .or. abs(normal) <= rounding)
        hats%entries(i) = dot_product(rows%coefficients(start + 1:start + rows%n_dim), hats%values(:, i))
      end associate
      if (.not. is_second) call add_followers(rows, row, is_prescribed, followers, i, hats)
    end do
  end function hats_of_side

  !> [-] Returns the coefficients of the owner of a row, shape (n_dim): the unit normal if the owner is the only node of its side.
  !> If the first side has further nodes, the owner is a mid-side node of a quadratic face, and the coefficients are scaled: if the
  !> owner moves by them, the row changes by 1. The hat is then the function of this node in the changed basis
  !> (sig_changed_basis), times the unit normal.
  pure function normal_of(rows, row) result(normal)
    type(contact_rows_t), intent(in) :: rows
    !> number among all contact rows
    integer, intent(in) :: row
    real(rk) :: normal(rows%n_dim)

    normal = rows%coefficients(rows%offsets(row) + 1:rows%offsets(row) + rows%n_dim)
    if (rows%splits(row) - rows%offsets(row) > rows%n_dim) normal = normal / sum(normal**2)
  end function normal_of

  !> Adds to hat i_hat, the last one so far, the owners of other rows that must move with its node, and their motions: they keep
  !> these rows unchanged.
  pure subroutine add_followers(rows, row, is_prescribed, followers, i_hat, hats)
    type(contact_rows_t), intent(in) :: rows
    !> of the hat, a number among all contact rows
    integer, intent(in) :: row
    !> as in hats_of_rows
    logical, intent(in) :: is_prescribed(:)
    type(followers_t), intent(in) :: followers
    integer, intent(in) :: i_hat
    type(hat_set_t), intent(inout) :: hats
    real(rk) :: answers(rows%n_dim, followers%starts(row + 1) - followers%starts(row))
    integer :: i, owners(rows%n_rows)

    if (size(answers, 2) == 0) return
    owners = rows%owners()
    associate (following => followers%rows(followers%starts(row) + 1:followers%starts(row + 1)), n => size(hats%more_nodes))
      do i = 1, size(following)
        answers(:, i) = following_motion(rows, following(i), is_prescribed, hats%nodes(i_hat), hats%values(:, i_hat))
      end do
      hats%more_values = reshape([hats%more_values, answers], [rows%n_dim, n + size(following)])
      hats%more_nodes = [hats%more_nodes, owners(following)]
    end associate
    hats%starts(i_hat + 1) = size(hats%more_nodes)
  end subroutine add_followers

  !> Returns the indices of the hats that change their contact row.
  pure function movable(hats) result(indices)
    type(hat_set_t), intent(in) :: hats
    integer, allocatable :: indices(:)
    integer :: i

    indices = pack([(i, i=1, size(hats%entries))], abs(hats%entries) > 0)
  end function movable

  !> Returns the hats with the given indices, in this order.
  pure function select_hats(hats, indices) result(selected)
    type(hat_set_t), intent(in) :: hats
    !> 1-based, of `hats`
    integer, intent(in) :: indices(:)
    type(hat_set_t) :: selected
    integer, allocatable :: places(:)
    integer :: i, j

    selected%rows = hats%rows(indices)
    selected%nodes = hats%nodes(indices)
    selected%values = hats%values(:, indices)
    selected%entries = hats%entries(indices)
    allocate (selected%starts(size(indices) + 1), source=0)
    do i = 1, size(indices)
      selected%starts(i + 1) = selected%starts(i) + hats%starts(indices(i) + 1) - hats%starts(indices(i))
    end do
    places = [((j, j=hats%starts(indices(i)) + 1, hats%starts(indices(i) + 1)), i=1, size(indices))]
    selected%more_nodes = hats%more_nodes(places)
    selected%more_values = hats%more_values(:, places)
  end function select_hats

  !> Returns the hats as displacement fields with natural dofs, one per column: the motion of the hat's node and of the nodes that
  !> move with it.
  pure function hat_columns(hats, n_dofs) result(columns)
    type(hat_set_t), intent(in) :: hats
    !> of the whole mesh
    integer, intent(in) :: n_dofs
    !> [-] shape (n_dofs, n_hats)
    real(rk), allocatable :: columns(:, :)
    integer :: i, j, n_dim

    n_dim = size(hats%values, 1)
    allocate (columns(n_dofs, size(hats%nodes)), source=0.0_rk)
    do i = 1, size(hats%nodes)
      columns(n_dim * (hats%nodes(i) - 1) + 1:n_dim * hats%nodes(i), i) = hats%values(:, i)
      do j = hats%starts(i) + 1, hats%starts(i + 1)
        columns(n_dim * (hats%more_nodes(j) - 1) + 1:n_dim * hats%more_nodes(j), i) = hats%more_values(:, j)
      end do
    end do
  end function hat_columns
end module sig_hat_functions
