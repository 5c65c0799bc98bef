! SPDX-License-Identifier: BSD-3-Clause
!> Motions of owners that change only their own rows.
!>
!> The owner of a row may also be a node of other rows, as the corner of a quadratic face is in the rows of mid-side nodes. If it
!> moves, the owners of those rows follow it, so that the values of those rows do not change. In the changed basis this motion is
!> the function of the corner: the corner moves by 1, the mid-side nodes by alpha.
module sig_side_motions
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: followers_t, find_followers, following_motion, movable

  !> [-] an owner cannot move along its normal if the sum of the squares of its free coefficients is at most this: rounding
  real(rk), parameter :: movable = 1.0e-20_rk

  !> For each row, the rows whose owners must follow its owner so that their values stay.
  type :: followers_t
    !> whether no other row changes if the owner of a row moves and its followers follow, shape (n_rows). It does not say whether
    !> the owner's own displacement is prescribed
    logical, allocatable :: is_possible(:)
    !> rows whose owners must move along when the owner of row k moves: rows(starts(k) + 1:starts(k + 1)); shape (n_rows + 1)
    integer, allocatable :: starts(:)
    integer, allocatable :: rows(:)
  end type followers_t

contains

  !> Finds for each row whether its owner can move without changing other rows, and the rows whose owners must then follow it. It
  !> can if each other row with this node has the node on its first side, and an owner that is in no further row and can move along
  !> its own normal. Whether the owner itself is prescribed is not checked. Cost: linear in the entries of the rows. Local.
  pure subroutine find_followers(rows, n_nodes, is_prescribed, followers)
    type(contact_rows_t), intent(in) :: rows
    !> number of nodes of the mesh
    integer, intent(in) :: n_nodes
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    type(followers_t), intent(out) :: followers
    integer :: i, k, leader, n_met(n_nodes), next(rows%n_rows), row_of(n_nodes)

    n_met = rows%rows_per_node(n_nodes)
    row_of = 0
    row_of(rows%owners()) = [(k, k=1, rows%n_rows)]
    next = 0
    do k = 1, rows%n_rows
      associate (nodes => rows%first_nodes_of(k))
        do i = 2, size(nodes)
          if (row_of(nodes(i)) > 0) next(row_of(nodes(i))) = next(row_of(nodes(i))) + 1
        end do
      end associate
    end do
    allocate (followers%starts(rows%n_rows + 1), source=0)
    do k = 1, rows%n_rows
      followers%starts(k + 1) = followers%starts(k) + next(k)
    end do
    allocate (followers%rows(followers%starts(rows%n_rows + 1)))
    ! all rows that meet the owner but its own must be followers
    followers%is_possible = n_met(rows%owners()) == next + 1
    next = followers%starts(:rows%n_rows)
    do k = 1, rows%n_rows
      associate (nodes => rows%first_nodes_of(k))
        do i = 2, size(nodes)
          leader = row_of(nodes(i))
          if (leader == 0) cycle
          next(leader) = next(leader) + 1
          followers%rows(next(leader)) = k
          followers%is_possible(leader) = followers%is_possible(leader) .and. n_met(nodes(1)) == 1 .and. &
            sum(free_part(rows, k, is_prescribed)**2) > movable
        end do
      end associate
    end do
  end subroutine find_followers

  !> Returns the smallest motion [-] of the owner of a row, shape (n_dim), that keeps the row unchanged when another node of its
  !> first side moves. It is 0 at prescribed dofs. Requires: not all of free_part is 0.
  pure function following_motion(rows, row, is_prescribed, node, motion) result(answer)
    type(contact_rows_t), intent(in) :: rows
    !> one of followers_t%rows
    integer, intent(in) :: row
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    !> node that moves, natural
    integer, intent(in) :: node
    !> [-] motion of this node, shape (n_dim)
    real(rk), intent(in) :: motion(:)
    real(rk) :: answer(rows%n_dim)
    integer :: place

    associate (nodes => rows%first_nodes_of(row), free => free_part(rows, row, is_prescribed))
      place = rows%offsets(row) + (findloc(nodes, node, dim=1) - 1) * rows%n_dim
      answer = -free / sum(free**2) * dot_product(rows%coefficients(place + 1:place + rows%n_dim), motion)
    end associate
  end function following_motion

  !> Returns the coefficients [-] of the owner of a row, shape (n_dim), 0 where its displacement is prescribed.
  pure function free_part(rows, row, is_prescribed) result(coefficients)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: row
    logical, intent(in) :: is_prescribed(:)
    real(rk) :: coefficients(rows%n_dim)

    associate (first => rows%offsets(row) + 1, last => rows%offsets(row) + rows%n_dim)
      coefficients = merge(0.0_rk, rows%coefficients(first:last), is_prescribed(rows%dofs(first:last)))
    end associate
  end function free_part
end module sig_side_motions
