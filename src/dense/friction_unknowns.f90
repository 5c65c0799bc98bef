! SPDX-License-Identifier: BSD-3-Clause
!> The linear problem of one step of sig_friction_newton, as few unknowns with one equation each.
!>
!> A step fixes the state of each contact: open, lambda = 0; sticks, w_n = 0 and v = 0; slips in the direction d with the softness
!> k, w_n = 0, lambda_t . d = f lambda_n, and v_e + k lambda_e = 0 across d. Rows of motions have w = 0. With w = q + W lambda,
!> either the forces or the openings are the independent numbers z, and the others the dependent ones y:
!>
!>     z = lambda, y = w = q + W z,     or     z = w, y = lambda = -A q + A z,  A = W^-1 (with its rows of motions).
!>
!> Most entries of z are known to be 0: forces of open contacts, or openings of those that stick. The others are sums of a few
!> unknowns x: forces of closed contacts and motions, or openings of contacts that do not stick.
module sig_friction_unknowns
  use sig_dense_kernels, only: add_few_columns, sum_of_sizes
  use sig_friction_types, only: contact_open, contact_slips, contact_sticks, friction_contacts_t, friction_unknown_t
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: list_unknowns, count_unknowns, assemble, fill_independent, start_unknowns, sum_equations

contains

  !> Returns how many unknowns list_unknowns may give at most.
  pure integer function count_unknowns(is_inverse, contacts, states) result(n)
    !> whether the unknowns are openings
    logical, intent(in) :: is_inverse
    type(friction_contacts_t), intent(in) :: contacts
    integer, intent(in) :: states(:)
    integer :: k

    n = merge(0, contacts%n_motions, is_inverse)
    do k = 1, contacts%n_contacts
      associate (n_tangents => contacts%n_tangents(k))
        if (states(k) == contact_slips) then
          n = n + merge(n_tangents, max(1, n_tangents), is_inverse)
        else if (is_inverse .eqv. states(k) == contact_open) then
          n = n + 1 + n_tangents
        end if
      end associate
    end do
  end function count_unknowns

  !> Lists the unknowns and their equations. Where the softness of a contact is huge, no force acts across its direction.
  pure subroutine list_unknowns(is_inverse, friction, contacts, states, directions, softness, c, unknowns, n)
    logical, intent(in) :: is_inverse
    !> [-] f of each contact, shape (n_contacts)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> as in friction_workspace_t
    integer, intent(in) :: states(:)
    real(rk), intent(in) :: directions(:, :)
    real(rk), intent(in) :: softness(:)
    real(rk), intent(in) :: c(:, :)
    type(friction_unknown_t), intent(inout) :: unknowns(:)
    !> number of unknowns
    integer, intent(out) :: n
    integer :: i, k

    n = 0
    do k = 1, contacts%n_contacts
      associate (d => directions(:, k))
        if (states(k) == contact_slips) then
          if (is_inverse) then
            call add_slips(contacts, k, friction(k), d, softness(k), c(2, k), unknowns, n)
          else
            call add_sliding_forces(contacts, k, friction(k), d, softness(k), unknowns, n)
          end if
        else if (is_inverse .eqv. states(k) == contact_open) then
          do i = 1, 1 + contacts%n_tangents(k)
            call add_unknown(contacts, k, i, unknowns, n)
          end do
        end if
      end associate
    end do
    if (is_inverse) return
    i = contacts%n_forces()
    do k = 1, contacts%n_motions
      call start_unknown([i + k, 0, 0], 1, 1, unknowns(n + k))
    end do
    n = n + contacts%n_motions
  end subroutine list_unknowns

  !> Adds an unknown of one row of contact k: an entry of z for which that of y is 0.
  pure subroutine add_unknown(contacts, k, i, unknowns, n)
    type(friction_contacts_t), intent(in) :: contacts
    integer, intent(in) :: k
    !> which one of the rows
    integer, intent(in) :: i
    type(friction_unknown_t), intent(inout) :: unknowns(:)
    integer, intent(inout) :: n

    n = n + 1
    call start_unknown([k, contacts%tangents(:, k)], 1 + contacts%n_tangents(k), i, unknowns(n))
  end subroutine add_unknown

  pure subroutine start_unknown(rows, n_rows, i, one)
    integer, intent(in) :: rows(3)
    integer, intent(in) :: n_rows
    integer, intent(in) :: i
    type(friction_unknown_t), intent(inout) :: one

    one%n_rows = n_rows
    one%rows = rows
    one%home = rows(i)
    one%moves = 0
    one%of_y = 0
    one%of_z = 0
    one%moves(i) = 1
    one%of_y(i) = 1
  end subroutine start_unknown

  !> Adds the forces of a contact that slips: f lambda_n d + lambda_e e. In the plane there is no e.
  pure subroutine add_sliding_forces(contacts, k, f, d, softness, unknowns, n)
    type(friction_contacts_t), intent(in) :: contacts
    integer, intent(in) :: k
    real(rk), intent(in) :: f
    real(rk), intent(in) :: d(2)
    real(rk), intent(in) :: softness
    type(friction_unknown_t), intent(inout) :: unknowns(:)
    integer, intent(inout) :: n

    call add_unknown(contacts, k, 1, unknowns, n)
    unknowns(n)%moves(2:) = f * d
    if (contacts%n_tangents(k) < 2 .or. .not. softness < huge(softness)) return
    call add_unknown(contacts, k, 3, unknowns, n)
    unknowns(n)%moves = [0.0_rk, -d(2), d(1)]
    unknowns(n)%of_y = unknowns(n)%moves
    unknowns(n)%of_z = softness * unknowns(n)%moves
  end subroutine add_sliding_forces

  !> Adds the slips of a contact, with the sum of both conditions times d and e, which does not jump where d turns: (lambda_t . d -
  !> f lambda_n) d + (k c lambda_e + c v_e) / (1 + k c) e = 0. Without a direction its forces are 0.
  pure subroutine add_slips(contacts, k, f, d, softness, c, unknowns, n)
    type(friction_contacts_t), intent(in) :: contacts
    integer, intent(in) :: k
    real(rk), intent(in) :: f
    real(rk), intent(in) :: d(2)
    real(rk), intent(in) :: softness
    !> [force/length]
    real(rk), intent(in) :: c
    type(friction_unknown_t), intent(inout) :: unknowns(:)
    integer, intent(inout) :: n
    real(rk) :: across(2), share
    integer :: i

    across = [-d(2), d(1)]
    share = 0
    if (softness < huge(softness)) share = 1 / (1 + softness * c)
    do i = 1, contacts%n_tangents(k)
      call add_unknown(contacts, k, 1 + i, unknowns, n)
      if (norm2(d) <= 0) cycle
      unknowns(n)%of_y = [-f * d(i), d(i) * d + (1 - share) * across(i) * across]
      unknowns(n)%of_z(2:) = share * c * across(i) * across
      if (contacts%n_tangents(k) == 1) unknowns(n)%of_y(3) = 0
    end do
  end subroutine add_slips

  !> Computes the matrix of the equations.
  subroutine assemble(matrix, unknowns, square, norm)
    !> W or A, shape (n_rows, n_rows)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(friction_unknown_t), intent(in) :: unknowns(:)
    !> shape (>= n, >= n)
    real(rk), contiguous, intent(inout) :: square(:, :)
    !> its 1-norm
    real(rk), intent(out) :: norm
    real(rk) :: column(size(matrix, 1)), last
    integer :: a, i, j
    integer :: homes(size(unknowns)), sums(size(unknowns)), n_sums

    homes = unknowns%home
    call find_sums(unknowns, sums, n_sums)
    norm = 0
    do j = 1, size(unknowns)
      associate (one => unknowns(j))
        column = 0
        do a = 1, one%n_rows
          if (abs(one%moves(a)) > 0) call add_few_columns(matrix(:, one%rows(a):one%rows(a)), one%moves(a:a), column)
        end do
      end associate
      do i = 1, size(homes)
        square(i, j) = column(homes(i))
      end do
      do i = 1, n_sums
        associate (one => unknowns(sums(i)))
          last = 0
          do a = 1, one%n_rows
            last = last + one%of_y(a) * column(one%rows(a))
          end do
          square(sums(i), j) = last
        end associate
      end do
      do i = max(1, j - 2), min(size(unknowns), j + 2)
        if (unknowns(i)%rows(1) == unknowns(j)%rows(1)) &
          square(i, j) = square(i, j) + dot_product(unknowns(i)%of_z, unknowns(j)%moves)
      end do
      norm = max(norm, sum_of_sizes(square(:size(unknowns), j)))
    end do
  end subroutine assemble

  !> Finds the unknowns in whose equations other entries of y than that of their own row stand.
  pure subroutine find_sums(unknowns, sums, n_sums)
    type(friction_unknown_t), intent(in) :: unknowns(:)
    !> 1-based, shape (n)
    integer, intent(out) :: sums(:)
    integer, intent(out) :: n_sums
    integer :: a, i

    n_sums = 0
    do i = 1, size(unknowns)
      associate (one => unknowns(i))
        do a = 1, one%n_rows
          if (abs(one%of_y(a) - merge(1.0_rk, 0.0_rk, one%rows(a) == one%home)) > 0) exit
        end do
        if (a > one%n_rows) cycle
        n_sums = n_sums + 1
        sums(n_sums) = i
      end associate
    end do
  end subroutine find_sums

  !> Sets z to what the unknowns make of it.
  pure subroutine fill_independent(unknowns, x, z)
    type(friction_unknown_t), intent(in) :: unknowns(:)
    !> shape (n)
    real(rk), intent(in) :: x(:)
    !> shape (n_rows)
    real(rk), intent(out) :: z(:)
    integer :: a, j

    z = 0
    do j = 1, size(unknowns)
      associate (one => unknowns(j))
        do a = 1, one%n_rows
          z(one%rows(a)) = z(one%rows(a)) + one%moves(a) * x(j)
        end do
      end associate
    end do
  end subroutine fill_independent

  !> Sets the unknowns to what is nearest to some z.
  pure subroutine start_unknowns(unknowns, z, x)
    type(friction_unknown_t), intent(in) :: unknowns(:)
    real(rk), intent(in) :: z(:)
    real(rk), intent(inout) :: x(:)
    integer :: a, j

    do j = 1, size(unknowns)
      associate (one => unknowns(j))
        x(j) = z(one%rows(1))
        if (abs(one%moves(1)) > 0) cycle
        x(j) = 0
        do a = 2, one%n_rows
          x(j) = x(j) + one%moves(a) * z(one%rows(a))
        end do
      end associate
    end do
  end subroutine start_unknowns

  !> Computes what is left of the equations for some y and z.
  pure subroutine sum_equations(unknowns, y, z, left)
    type(friction_unknown_t), intent(in) :: unknowns(:)
    real(rk), intent(in) :: y(:)
    real(rk), intent(in) :: z(:)
    !> shape (>= n)
    real(rk), intent(inout) :: left(:)
    integer :: a, j

    do j = 1, size(unknowns)
      associate (one => unknowns(j))
        left(j) = 0
        do a = 1, one%n_rows
          left(j) = left(j) + one%of_y(a) * y(one%rows(a)) + one%of_z(a) * z(one%rows(a))
        end do
      end associate
    end do
  end subroutine sum_equations
end module sig_friction_unknowns
