! SPDX-License-Identifier: BSD-3-Clause
!> Tangential rows s = B_t u of contacts: the displacement of the first side relative to the second one along tangents, with the
!> same shares of the nodes as in the normal row. So forces of friction act on the nodes on which the normal force acts, and those
!> on both sides balance.
!>
!> The tangents depend on the normal alone, and thus not on ranks. In the plane and in the half plane of axisymmetry there is one, t
!> = (-n_y, n_x), with the normal n from the first side to the second; the hoop direction has none, because bodies do not twist. In
!> space t_1 is the axis along which n has its smallest component, without its part along n, and t_2 = n x t_1. On a plane of
!> symmetry across an axis one tangent is then this axis: nothing moves along it, and its row is left out. In the whole body the
!> slip there is 0, because nodes and their mirror images move against each other; half of the body knows half of these nodes.
module sig_tangential_rows
  use sig_contact_rows, only: contact_rows_t
  use sig_cross_products, only: cross_product
  use sig_independent_columns, only: independent_columns
  use sig_kinds, only: rk
  use sig_rounding, only: dependent
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: tangential_rows_t, create_tangential_rows, direction_of, tangents_of, find_dependent

  !> Tangential rows beside the normal rows that they belong to. Rows of a contact follow each other; contacts keep their order.
  type :: tangential_rows_t
    !> gap 0, area and contact_entry of the contact
    type(contact_rows_t) :: rows
    !> normal row of each row, shape (n_rows)
    integer, allocatable :: contacts(:)
    !> which of its contact's tangents each row has, 1 or 2; shape (n_rows)
    integer, allocatable :: directions(:)
  contains
    procedure :: rows_of_contacts
  end type tangential_rows_t

contains

  !> Makes the tangential rows of some contacts. A row is left out where the surfaces cannot slip in its direction: its dofs are all
  !> prescribed, or it lies across a plane of symmetry.
  pure subroutine create_tangential_rows(normal, has_tangents, coordinates, is_prescribed, is_held, tangential)
    !> normal rows, all with the same normal at all of their nodes (contact_rows_t)
    type(contact_rows_t), intent(in) :: normal
    !> which contacts get tangential rows, shape (normal%n_rows)
    logical, intent(in) :: has_tangents(:)
    !> [length] of the nodes, shape (n_dim, n_nodes)
    real(rk), intent(in) :: coordinates(:, :)
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    !> those that are prescribed to stay where they are, same shape
    logical, intent(in) :: is_held(:)
    type(tangential_rows_t), intent(out) :: tangential
    type(contact_rows_t) :: all_rows
    logical, allocatable :: is_kept(:)
    integer :: i, k

    associate (contacts => pack([(k, k=1, normal%n_rows)], has_tangents), n => normal%n_dim - 1)
      tangential%contacts = [((contacts(k), i=1, n), k=1, size(contacts))]
      tangential%directions = [((i, i=1, n), k=1, size(contacts))]
    end associate
    call turn_rows(normal, tangential%contacts, tangential%directions, all_rows)
    is_kept = .not. all_rows%are_inert(is_prescribed)
    do k = 1, all_rows%n_rows
      if (is_kept(k)) is_kept(k) = .not. is_across_symmetry(all_rows, k, coordinates, is_held)
    end do
    tangential%rows = all_rows%select(pack([(k, k=1, all_rows%n_rows)], is_kept))
    tangential%contacts = pack(tangential%contacts, is_kept)
    tangential%directions = pack(tangential%directions, is_kept)
  end subroutine create_tangential_rows

  !> Returns whether a tangential row lies across a plane of symmetry through its owner: its nodes are on this plane or on one side
  !> of it, both surfaces have nodes on it, and none of these moves across it. Where the first surface alone is held, or both are
  !> prescribed to move, the surfaces slip, and so it is no symmetry.
  pure logical function is_across_symmetry(rows, row, coordinates, is_held)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: row
    !> [length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: coordinates(:, :)
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_held(:)
    real(rk), allocatable :: distances(:)
    logical, allocatable :: is_on_plane(:)
    integer :: i

    associate (t => direction_of(rows, row), nodes => rows%nodes_of(row), n_first => size(rows%first_nodes_of(row)))
      associate (owner => coordinates(:, nodes(1)))
        distances = [(dot_product(t, coordinates(:, nodes(i)) - owner), i=1, size(nodes))]
        is_on_plane = abs(distances) <= dependent * maxval([(norm2(coordinates(:, nodes(i)) - owner), i=1, size(nodes))])
      end associate
      is_across_symmetry = (all(distances >= 0 .or. is_on_plane) .or. all(distances <= 0 .or. is_on_plane)) .and. &
        any(is_on_plane(n_first + 1:))
      do i = 1, size(nodes)
        if (is_on_plane(i)) is_across_symmetry = is_across_symmetry .and. &
          all(is_held(rows%n_dim * (nodes(i) - 1) + 1:rows%n_dim * nodes(i)) .or. abs(t) <= dependent)
      end do
    end associate
  end function is_across_symmetry

  !> Makes a row along a tangent from each given normal row.
  pure subroutine turn_rows(normal, contacts, directions, rows)
    type(contact_rows_t), intent(in) :: normal
    !> 1-based, same shape
    integer, intent(in) :: contacts(:), directions(:)
    type(contact_rows_t), intent(out) :: rows
    real(rk) :: tangents(normal%n_dim, normal%n_dim - 1)
    integer :: i, k

    rows = normal%select(contacts)
    rows%gap = 0
    do k = 1, rows%n_rows
      tangents = tangents_of(direction_of(rows, k))
      associate (shares => shares_of(rows, k), first => rows%offsets(k))
        do i = 1, size(shares)
          rows%coefficients(first + rows%n_dim * (i - 1) + 1:first + rows%n_dim * i) = shares(i) * tangents(:, directions(k))
        end do
      end associate
    end do
  end subroutine turn_rows

  !> Returns the unit vector along which a row acts, in a normal row the normal from the first side to the second: the direction of
  !> its owner's coefficients.
  pure function direction_of(rows, row)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: row
    real(rk) :: direction_of(rows%n_dim)

    associate (owner => rows%coefficients(rows%offsets(row) + 1:rows%offsets(row) + rows%n_dim))
      direction_of = owner / norm2(owner)
    end associate
  end function direction_of

  !> Returns what the coefficients of a normal row's nodes are along its normal: their sum is 1 on the first side, -1 on the second.
  pure function shares_of(normal, row) result(shares)
    type(contact_rows_t), intent(in) :: normal
    integer, intent(in) :: row
    real(rk) :: shares((normal%offsets(row + 1) - normal%offsets(row)) / normal%n_dim)

    shares = matmul(direction_of(normal, row), reshape(normal%coefficients_of(row), [normal%n_dim, size(shares)]))
  end function shares_of

  !> Returns the tangents of a normal (head of this file): unit vectors across it and across each other.
  pure function tangents_of(normal) result(tangents)
    !> of length 1, shape (n_dim)
    real(rk), intent(in) :: normal(:)
    !> shape (n_dim, n_dim - 1)
    real(rk) :: tangents(size(normal), size(normal) - 1)
    real(rk) :: axis(size(normal))
    integer :: i

    if (size(normal) == 2) then
      tangents(:, 1) = [-normal(2), normal(1)]
      return
    end if
    i = findloc(abs(normal) <= minval(abs(normal)) + tie_tolerance, .true., dim=1)
    axis = 0
    axis(i) = 1
    axis = axis - normal(i) * normal
    tangents(:, 1) = axis / norm2(axis)
    tangents(:, 2) = cross_product(normal, tangents(:, 1))
  end function tangents_of

  !> Returns the rows of each contact among the tangential rows, the second one 0 where there is one, both 0 where there is none;
  !> shape (2, n_contacts).
  pure function rows_of_contacts(self, n_contacts) result(rows)
    class(tangential_rows_t), intent(in) :: self
    !> number of normal rows
    integer, intent(in) :: n_contacts
    integer :: rows(2, n_contacts)
    integer :: k

    rows = 0
    do k = 1, self%rows%n_rows
      associate (own => rows(:, self%contacts(k)))
        own(merge(1, 2, own(1) == 0)) = k
      end associate
    end do
  end function rows_of_contacts

  !> Finds the first contact whose rows cannot be closed one by one, because prescribed displacements leave its nodes too few
  !> directions: such as a node that moves along one line, which leans on an obstacle. Forces of such rows are not unique. 0 if
  !> there is none.
  pure integer function find_dependent(normal, tangential, is_prescribed) result(contact)
    type(contact_rows_t), intent(in) :: normal
    type(tangential_rows_t), intent(in) :: tangential
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    integer :: rows(2, normal%n_rows)

    rows = tangential%rows_of_contacts(normal%n_rows)
    do contact = 1, normal%n_rows
      if (is_dependent(contact, pack(rows(:, contact), rows(:, contact) > 0))) return
    end do
    contact = 0

  contains

    pure logical function is_dependent(contact, tangents)
      integer, intent(in) :: contact
      integer, intent(in) :: tangents(:)
      real(rk), allocatable :: columns(:, :)
      integer :: i

      allocate (columns(size(normal%dofs_of(contact)), 1 + size(tangents)))
      columns(:, 1) = normal%coefficients_of(contact)
      do i = 1, size(tangents)
        columns(:, 1 + i) = tangential%rows%coefficients_of(tangents(i))
      end do
      do i = 1, size(columns, 2)
        where (is_prescribed(normal%dofs_of(contact))) columns(:, i) = 0
      end do
      is_dependent = size(independent_columns(columns, dependent)) < size(columns, 2)
    end function is_dependent
  end function find_dependent
end module sig_tangential_rows
