! SPDX-License-Identifier: BSD-3-Clause
!> Turns values of contact rows (pressure, gap, status; of friction vectors) into values at the nodes of both surfaces.
!>
!> On the first side, the value of row k is a weighted sum of nodal values u~_k = w_1 u_1 + w_2 u_2 + ..., where w are the shares of
!> its nodes and node 1 is its owner. So the value at the owner is (u~_k - w_2 u_2 - ...) / w_1; if the owner is alone, it is u~_k.
!> The gap of an owner is along the normal of its own row; in the sum of row k, its component along the normal of row k counts. A
!> node of the second side that owns no row has the mean pressure of the rows that contain it, weighted by their areas and the sizes
!> of its shares.
module sig_nodal_values
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: cell_contact, nodal_areas, nodal_contact, nodal_friction, nodal_gaps, nodal_pressures, nodal_vectors

  !> status of a node: in no row that counts, open, closed, tied; of friction: closed and sticking, or slipping. That of a cell that
  !> is tied at all of its nodes is status_tied, too
  integer, parameter :: status_none = 0, status_open = 1, status_closed = 2, status_slips = 3, status_tied = 4
  !> status of a cell: closed at some of its nodes and open at others
  integer, parameter :: status_partly = 3

contains

  !> Returns the area of each node: for an owner the area of its row, for other nodes the sum of their shares of the areas of the
  !> rows that contain them.
  pure function nodal_areas(rows, n_nodes) result(areas)
    type(contact_rows_t), intent(in) :: rows
    !> number of nodes of the mesh
    integer, intent(in) :: n_nodes
    !> [length**2, length in the plane] 0 at nodes without rows; may be negative, as a share may be; shape (n_nodes)
    real(rk) :: areas(n_nodes)
    integer :: k

    areas = 0
    do k = 1, rows%n_rows
      associate (nodes => rows%nodes_of(k))
        areas(nodes) = areas(nodes) + rows%areas(k) * rows%weights_of(k)
      end associate
    end do
    areas(rows%owners()) = rows%areas
  end function nodal_areas

  !> Returns the contact pressure at each node. The pressure of a row is its multiplier over its area, or 0 if the area is not
  !> positive. An owner has the pressure for which the sum of share times pressure over the first side of its row is the pressure of
  !> the row; in this sum a further node has the pressure of its own row, or of this row if it owns none. A node that owns no row
  !> but is on the second side of rows has their mean pressure, weighted by area times size of its share. All other nodes have 0.
  pure function nodal_pressures(rows, multipliers, n_nodes) result(pressures)
    type(contact_rows_t), intent(in) :: rows
    !> [force] shape (n_rows)
    real(rk), intent(in) :: multipliers(:)
    !> number of nodes of the mesh
    integer, intent(in) :: n_nodes
    !> [force / area] shape (n_nodes)
    real(rk) :: pressures(n_nodes)
    logical :: is_owner(n_nodes)

    call values_at_nodes(rows, merge(multipliers / max(rows%areas, tiny(1.0_rk)), 0.0_rk, rows%areas > 0), is_owner, pressures)
  end function nodal_pressures

  !> Returns vectors of the rows, such as tractions or slips of the first side, at each node, as nodal_pressures does for each
  !> component; at nodes that own no row with the opposite sign: there they are those of the second side.
  pure function nodal_vectors(rows, of_rows, n_nodes) result(vectors)
    type(contact_rows_t), intent(in) :: rows
    !> shape (n_dim, n_rows)
    real(rk), intent(in) :: of_rows(:, :)
    !> number of nodes of the mesh
    integer, intent(in) :: n_nodes
    real(rk) :: vectors(size(of_rows, 1), n_nodes)
    real(rk) :: component(n_nodes)
    logical :: is_owner(n_nodes)
    integer :: i

    do i = 1, size(of_rows, 1)
      call values_at_nodes(rows, of_rows(i, :), is_owner, component)
      vectors(i, :) = merge(component, -component, is_owner)
    end do
  end function nodal_vectors

  !> Computes values at nodes from those of rows, as nodal_pressures says.
  pure subroutine values_at_nodes(rows, of_rows, is_owner, values)
    type(contact_rows_t), intent(in) :: rows
    !> shape (n_rows)
    real(rk), intent(in) :: of_rows(:)
    !> shape (n_nodes)
    logical, intent(out) :: is_owner(:)
    real(rk), intent(out) :: values(:)
    real(rk) :: sums(size(values)), weights(size(values))
    integer :: k

    call values_at_owners(rows, of_rows, .false., is_owner, values)
    sums = 0
    weights = 0
    do k = 1, rows%n_rows
      associate (nodes => rows%second_nodes_of(k), shares => rows%weights_of(k))
        associate (weight => rows%areas(k) * abs(shares(size(shares) - size(nodes) + 1:)))
          weights(nodes) = weights(nodes) + weight
          sums(nodes) = sums(nodes) + weight * of_rows(k)
        end associate
      end associate
    end do
    where (.not. is_owner .and. weights > 0) values = sums / weights
  end subroutine values_at_nodes

  !> Returns the gap at each node. An owner has the gap for which the sum of share times gap over the first side of its row is the
  !> opening of the row; in this sum a further node has the opening of its own row, projected on this row's normal, or that of this
  !> row if it owns none. A node that owns no row has the smallest opening of the rows that contain it.
  pure function nodal_gaps(rows, opening, n_nodes) result(gaps)
    type(contact_rows_t), intent(in) :: rows
    !> [length] gap of each row after the displacement, shape (n_rows)
    real(rk), intent(in) :: opening(:)
    !> number of nodes of the mesh
    integer, intent(in) :: n_nodes
    !> [length] NaN at nodes without rows, shape (n_nodes)
    real(rk) :: gaps(n_nodes)
    real(rk) :: least(n_nodes)
    logical :: is_owner(n_nodes)
    integer :: k

    call values_at_owners(rows, opening, .true., is_owner, gaps)
    least = huge(least)
    do k = 1, rows%n_rows
      associate (nodes => rows%nodes_of(k))
        least(nodes) = min(least(nodes), opening(k))
      end associate
    end do
    where (.not. is_owner) gaps = least
    where (rows%rows_per_node(n_nodes) == 0) gaps = ieee_value(gaps, ieee_quiet_nan)
  end function nodal_gaps

  !> Returns the status of each node: status_tied (4) if a row at the node is tied, else status_closed (2) if one is closed, else
  !> status_open (1); status_none (0) if there is no row. At an owner, these rows are its own and those that have it on their
  !> second side: other rows contain it for the changed basis only. At any other node they are all rows that contain it.
  pure function nodal_contact(rows, is_closed, is_tied, n_nodes) result(status)
    type(contact_rows_t), intent(in) :: rows
    !> whether it has a force, and whether it is tied, shape (n_rows)
    logical, intent(in) :: is_closed(:)
    logical, intent(in) :: is_tied(:)
    integer, intent(in) :: n_nodes
    integer :: status(n_nodes)

    status = largest_status(rows, merge(status_tied, merge(status_closed, status_open, is_closed), is_tied), n_nodes)
  end function nodal_contact

  !> Returns the status of each node with friction: status_none (0), status_open (1), 2 for a closed row that sticks, 3
  !> (status_slips) for one that slips, status_tied (4) for one that is tied; of several rows at a node (those of nodal_contact) the
  !> largest number.
  pure function nodal_friction(rows, is_closed, is_tied, slips, n_nodes) result(status)
    type(contact_rows_t), intent(in) :: rows
    !> whether it has a force, whether it is tied, and whether it slips, shape (n_rows)
    logical, intent(in) :: is_closed(:)
    logical, intent(in) :: is_tied(:)
    logical, intent(in) :: slips(:)
    integer, intent(in) :: n_nodes
    integer :: status(n_nodes)

    status = largest_status(rows, merge(status_tied, merge(merge(status_slips, status_closed, slips), status_open, is_closed), &
      is_tied), n_nodes)
  end function nodal_friction

  !> Returns the largest status of the rows at each node that nodal_contact names, status_none (0) without such rows.
  pure function largest_status(rows, of_rows, n_nodes) result(status)
    type(contact_rows_t), intent(in) :: rows
    !> > 0, shape (n_rows)
    integer, intent(in) :: of_rows(:)
    integer, intent(in) :: n_nodes
    integer :: status(n_nodes)
    logical :: is_owner(n_nodes)
    integer :: i, k

    is_owner = .false.
    is_owner(rows%owners()) = .true.
    status = status_none
    do k = 1, rows%n_rows
      associate (first => rows%first_nodes_of(k), second => rows%second_nodes_of(k))
        do i = 1, size(first)
          if (i == 1 .or. .not. is_owner(first(i))) status(first(i)) = max(status(first(i)), of_rows(k))
        end do
        status(second) = max(status(second), of_rows(k))
      end associate
    end do
  end function largest_status

  !> Returns the status of each cell from that of its nodes: status_open (1), status_closed (2), status_tied (4) if all are tied, or
  !> status_partly (3) if it has open nodes and others. Nodes with status_none (0) do not count; a cell with no others has
  !> status_none.
  pure function cell_contact(of_nodes, starts, nodes) result(status)
    !> status of each node, by nodal_contact
    integer, intent(in) :: of_nodes(:)
    !> nodes of cell i are nodes(starts(i) + 1:starts(i + 1))
    integer, intent(in) :: starts(:)
    integer, intent(in) :: nodes(:)
    integer :: status(size(starts) - 1)
    integer :: i, n_closed, n_open, n_tied

    do i = 1, size(status)
      n_open = count(of_nodes(nodes(starts(i) + 1:starts(i + 1))) == status_open)
      n_closed = count(of_nodes(nodes(starts(i) + 1:starts(i + 1))) == status_closed)
      n_tied = count(of_nodes(nodes(starts(i) + 1:starts(i + 1))) == status_tied)
      status(i) = status_none
      if (n_open > 0) status(i) = status_open
      if (n_tied > 0) status(i) = status_tied
      if (n_closed > 0) status(i) = status_closed
      if (n_open > 0 .and. n_closed + n_tied > 0) status(i) = status_partly
    end do
  end function cell_contact

  !> Computes the values at the owners for which the sum of share times value over the first side of each row is the row's value
  !> of_rows. In this sum a further node has the value of its own row, or, if it owns none, that of the row of the sum.
  pure subroutine values_at_owners(rows, of_rows, is_along_normal, is_owner, values)
    type(contact_rows_t), intent(in) :: rows
    !> shape (n_rows)
    real(rk), intent(in) :: of_rows(:)
    !> whether values are lengths along the normals of the rows, as gaps are: in a sum, the value of another row is then projected
    !> on the normal of the row of the sum
    logical, intent(in) :: is_along_normal
    !> shape (n_nodes)
    logical, intent(out) :: is_owner(:)
    !> zero at all other nodes, same shape
    real(rk), intent(out) :: values(:)
    real(rk) :: normals(rows%n_dim, rows%n_rows), others
    integer :: i, k, row_of(size(is_owner))

    row_of = 0
    row_of(rows%owners()) = [(k, k=1, rows%n_rows)]
    is_owner = row_of > 0
    values = 0
    values(rows%owners()) = of_rows
    do k = 1, rows%n_rows
      normals(:, k) = rows%coefficients(rows%offsets(k) + 1:rows%offsets(k) + rows%n_dim)
      normals(:, k) = normals(:, k) / norm2(normals(:, k))
    end do
    do k = 1, rows%n_rows
      associate (nodes => rows%first_nodes_of(k), weights => rows%weights_of(k))
        if (size(nodes) == 1) cycle
        others = 0
        do i = 2, size(nodes)
          if (.not. is_owner(nodes(i))) then
            others = others + weights(i) * of_rows(k)
          else if (is_along_normal) then
            others = others + weights(i) * of_rows(row_of(nodes(i))) * dot_product(normals(:, row_of(nodes(i))), normals(:, k))
          else
            others = others + weights(i) * of_rows(row_of(nodes(i)))
          end if
        end do
        values(nodes(1)) = (of_rows(k) - others) / weights(1)
      end associate
    end do
  end subroutine values_at_owners
end module sig_nodal_values
