! SPDX-License-Identifier: BSD-3-Clause
!> The step of sig_friction_newton, solved for the openings of the contacts that do not stick instead of the forces of the closed
!> ones. It pays where most contacts stick.
!>
!> Let A be the inverse of W (with its rows of motions), which is the same for all steps, and let all contacts be closed and stick:
!> the forces are then lambda_0 = -A (q + origins). A contact that is open, or slips, has openings v that are not zero, so that
!>
!>     lambda = lambda_0 + A E v,   E: columns of the unit matrix of these rows,
!>
!> and as many conditions: no force where the contact is open; lambda_t . d = f lambda_n and v_e + k lambda_e = 0 where it slips in
!> the direction d, with e across d.
module sig_friction_openings
  use sig_dense_kernels, only: add_few_columns
  use sig_friction_types, only: contact_open, contact_sticks, friction_contacts_t, friction_workspace_t
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: count_openings, assemble_openings, take_openings

contains

  !> Returns the number of rows of contacts that do not stick, by the states of the workspace.
  pure integer function count_openings(contacts, workspace) result(n)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(in) :: workspace
    integer :: k

    n = 0
    do k = 1, contacts%n_contacts
      if (workspace%states(k) == contact_open) n = n + 1
      if (workspace%states(k) /= contact_sticks) n = n + contacts%n_tangents(k)
    end do
  end function count_openings

  !> Writes the matrix of the openings into workspace%factors and the right-hand side into workspace%x. Requires: workspace%base.
  pure subroutine assemble_openings(inverse, friction, contacts, workspace, n, norm)
    !> A, shape (n_rows, n_rows)
    real(rk), intent(in) :: inverse(:, :)
    !> [-] f of each contact, shape (n_contacts)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace
    !> number of openings
    integer, intent(out) :: n
    !> 1-norm of the matrix
    real(rk), intent(out) :: norm
    real(rk) :: entry
    integer :: a, i, j

    call list_conditions(friction, contacts, workspace, n)
    norm = 0
    associate (parts => workspace%parts, shares => workspace%shares, factors => workspace%factors)
      do j = 1, n
        do i = 1, n
          entry = 0
          do a = 1, workspace%n_parts(i)
            entry = entry + shares(a, i) * inverse(parts(a, i), workspace%opened(j))
          end do
          factors(i, j) = entry
        end do
        ! conditions on openings belong to the second row of a contact, and name both
        factors(j, j) = factors(j, j) + workspace%opening_shares(2, j)
        if (j < n) factors(j + 1, j) = factors(j + 1, j) + workspace%opening_shares(1, j + 1)
        workspace%x(j) = 0
        do a = 1, workspace%n_parts(j)
          workspace%x(j) = workspace%x(j) - shares(a, j) * workspace%base(parts(a, j))
        end do
        norm = max(norm, sum(abs(factors(:n, j))))
      end do
    end associate
  end subroutine assemble_openings

  !> Lists the openings, and a condition for each: sums of forces, and for the slip across a direction also of openings.
  pure subroutine list_conditions(friction, contacts, workspace, n)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_workspace_t), intent(inout) :: workspace
    integer, intent(out) :: n
    integer :: i, k

    n = 0
    do k = 1, contacts%n_contacts
      associate (rows => contacts%tangents(:contacts%n_tangents(k), k), d => workspace%directions(:, k), c => workspace%c(2, k), &
        softness => workspace%softness(k))
        if (workspace%states(k) == contact_open) call add_condition(workspace, k, [k], [1.0_rk], n)
        if (workspace%states(k) == contact_sticks) cycle
        if (workspace%states(k) == contact_open .or. norm2(d(:size(rows))) <= 0) then
          do i = 1, size(rows)
            call add_condition(workspace, rows(i), rows(i:i), [1.0_rk], n)
          end do
          cycle
        end if
        if (size(rows) == 0) cycle
        call add_condition(workspace, rows(1), [k, rows], [-friction(k), d(:size(rows))], n)
        if (size(rows) < 2) cycle
        if (softness < huge(softness)) then
          call add_condition(workspace, rows(2), rows, c * softness * [-d(2), d(1)], n)
          workspace%opening_shares(:, n) = c * [-d(2), d(1)]
        else
          call add_condition(workspace, rows(2), rows, [-d(2), d(1)], n)
        end if
      end associate
    end do
  end subroutine list_conditions

  pure subroutine add_condition(workspace, opened, rows, shares, n)
    type(friction_workspace_t), intent(inout) :: workspace
    !> row that opens
    integer, intent(in) :: opened
    !> rows whose forces are summed by these shares
    integer, intent(in) :: rows(:)
    real(rk), intent(in) :: shares(:)
    integer, intent(inout) :: n

    n = n + 1
    workspace%opened(n) = opened
    workspace%parts(:size(rows), n) = rows
    workspace%shares(:size(rows), n) = shares
    workspace%n_parts(n) = size(rows)
    workspace%opening_shares(:, n) = 0
  end subroutine add_condition

  !> Computes the forces of all rows from the openings in workspace%x, and sets workspace%w to these openings, 0 elsewhere. Forces
  !> meet the conditions exactly, but for those of slip across a direction.
  subroutine take_openings(inverse, friction, contacts, n, lambda, workspace)
    real(rk), contiguous, intent(in) :: inverse(:, :)
    real(rk), intent(in) :: friction(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> number of openings
    integer, intent(in) :: n
    !> [force] shape (n_rows)
    real(rk), contiguous, intent(inout) :: lambda(:)
    type(friction_workspace_t), intent(inout) :: workspace
    integer :: j, k

    workspace%w(:size(lambda)) = 0
    do j = 1, n
      workspace%w(workspace%opened(j)) = workspace%x(j)
    end do
    lambda = workspace%base(:size(lambda))
    call add_few_columns(inverse, workspace%w(:size(lambda)), lambda)
    do k = 1, contacts%n_contacts
      associate (rows => contacts%tangents(:contacts%n_tangents(k), k), d => workspace%directions(:, k))
        if (workspace%states(k) == contact_sticks) cycle
        if (workspace%states(k) == contact_open) lambda(k) = 0
        if (workspace%states(k) == contact_open .or. norm2(d(:size(rows))) <= 0) then
          lambda(rows) = 0
        else
          lambda(rows) = lambda(rows) + (friction(k) * lambda(k) - dot_product(lambda(rows), d(:size(rows)))) * d(:size(rows))
        end if
      end associate
    end do
  end subroutine take_openings
end module sig_friction_openings
