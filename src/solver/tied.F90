! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The contact problem where some rows are always closed and some always open: a dense problem of the other rows, without W of all
!> rows.
!>
!> With K tied at the closed rows C (B_C u = D_C theta), the displacement under forces on the changing rows N is u = G theta - H
!> lambda_N. One factorization, and one solve per changing row and per term, give a value of each row, R theta + S lambda_N: the
!> force of a closed row, the opening of each other row. The values of the rows N are the complementarity problem; there S is
!> symmetric. Tangential rows are rows like others: those of a contact that always sticks are closed.
module sig_tied
  use sig_bound_form, only: bound_form_t
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: add_product, unit_vector
  use sig_linear_solver, only: constrain, linear_solver_t
  use sig_petsc_support, only: multiply_block
  use sig_reasons, only: reason_converged
  use sig_tied_compliance, only: row_changing, row_closed
  use petsc
  implicit none(type, external)
  private
  public :: solve_tied, tied_response_t

  !> number of right-hand sides that are solved at a time
  integer, parameter :: chunk = 64

  !> What the dense problem of a tied cluster needs; on all ranks.
  type :: tied_response_t
    !> reason_converged, or why the tied stiffness could not be factored or a solve failed
    integer :: reason = 0
    !> R, shape (n_rows, n_terms): [force per unit of theta] of closed rows, [length per unit of theta] opening of other rows
    real(rk), allocatable :: free(:, :)
    !> S, shape (n_rows, n_changing): [-] for closed rows, [length/force] for other rows
    real(rk), allocatable :: operator(:, :)
    !> [length per unit of theta, length/force] G and -H on the wanted dofs (`dofs` of solve_tied), shapes (size(dofs), n_terms)
    !> and (size(dofs), n_changing)
    real(rk), allocatable :: free_field(:, :)
    real(rk), allocatable :: field(:, :)
    !> [length per unit of theta] G on all dofs, and [length/force] -H times each pattern of forces; shapes (n_dofs, n_terms) and
    !> (n_dofs, n_patterns); empty without patterns
    real(rk), allocatable :: whole_free_field(:, :)
    real(rk), allocatable :: pattern_fields(:, :)
  end type tied_response_t

  !> The factored system, the status of the rows, and the wanted dofs.
  type :: tied_system_t
    type(bound_form_t) :: form
    !> T' K T
    Mat :: stiffness
    type(linear_solver_t) :: linear_solver
    !> row_*, shape (n_rows)
    integer, allocatable :: status(:)
    !> unknowns of the bound form that are held at given values, natural
    integer, allocatable :: held(:)
    !> dofs whose displacements are wanted, natural
    integer, allocatable :: dofs(:)
    !> [force] forces on the changing rows whose displacements of all dofs are wanted, shape (n_changing, n_patterns)
    real(rk), allocatable :: patterns(:, :)
  end type tied_system_t

contains

  !> Computes the response of a problem where closed rows are tied and open rows have no force. R and G are the response to each
  !> term, S and -H that to a unit force on each changing row. R and S have the force of each closed row and the opening of each
  !> other row, G and -H the displacements of the wanted dofs. The response is the same on all ranks of the system. If the tied
  !> stiffness cannot be factored or a solve fails, response%reason says so. Requires: closed rows hold all bodies, and each row has
  !> a free dof of its own. Collective.
  subroutine solve_tied(system, status, dofs, patterns, response, ierr)
    type(contact_system_t), intent(inout) :: system
    !> row_closed, row_changing or row_open (sig_tied_compliance) of each row, shape (n_rows)
    integer, intent(in) :: status(:)
    !> dofs whose displacements are wanted, natural
    integer, intent(in) :: dofs(:)
    !> [force] forces on the changing rows whose displacements of all dofs are wanted, shape (n_changing, n_patterns)
    real(rk), intent(in) :: patterns(:, :)
    type(tied_response_t), intent(out) :: response
    PetscErrorCode, intent(out) :: ierr
    type(tied_system_t) :: tied
    real(rk) :: nothing(system%map%n_dofs)
    Mat :: matrix
    Vec :: rhs

    nothing = 0
    PetscCall(tied%form%create(system, ierr))
    PetscCall(tied%form%create_matrix(system, tied%stiffness, ierr))
    tied%status = status
    tied%held = [system%boundary%prescribed_dofs, pack(tied%form%bounded_dofs, status == row_closed)]
    tied%dofs = dofs
    tied%patterns = patterns
    PetscCall(constrain(system, tied%stiffness, tied%held, nothing, nothing, matrix, rhs, ierr))
    PetscCall(tied%linear_solver%factor(matrix, 'active_set_', ierr))
    response%reason = tied%linear_solver%reason
    if (response%reason == reason_converged) then
      PetscCall(solve_terms(system, tied, response, ierr))
    end if
    if (response%reason == reason_converged) then
      PetscCall(solve_forces(system, tied, response, ierr))
    end if
    PetscCall(tied%linear_solver%destroy(ierr))
    PetscCall(MatDestroy(matrix, ierr))
    PetscCall(VecDestroy(rhs, ierr))
    PetscCall(MatDestroy(tied%stiffness, ierr))
  end subroutine solve_tied

  !> Computes R and G: the responses to loads, prescribed displacements and gaps of each term. Sets response%reason. Collective.
  subroutine solve_terms(system, tied, response, ierr)
    type(contact_system_t), intent(inout) :: system
    type(tied_system_t), intent(inout) :: tied
    type(tied_response_t), intent(inout) :: response
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: forces(system%map%n_dofs, system%boundary%n_terms), values(system%map%n_dofs, system%boundary%n_terms)
    real(rk) :: bounds(size(tied%status), system%boundary%n_terms)
    real(rk), allocatable :: fields(:, :)
    real(rk) :: prescribed(system%map%n_dofs)
    integer :: i

    values = 0
    do i = 1, size(forces, 2)
      associate (theta => unit_vector(size(forces, 2), i))
        forces(:, i) = system%load(theta)
        call tied%form%to_forces_on_unknowns(system, forces(:, i))
        bounds(:, i) = tied%form%bounds(system, theta)
        prescribed = system%prescribed_displacement(theta)
      end associate
      prescribed(tied%form%bounded_dofs) = bounds(:, i)
      values(tied%held, i) = prescribed(tied%held)
    end do
    PetscCall(respond(system, tied, forces, values, response%free, fields, ierr))
    response%free_field = fields(tied%dofs, :)
    allocate (response%whole_free_field(size(fields, 1), 0))
    if (size(tied%patterns, 2) > 0) response%whole_free_field = fields
    response%reason = tied%linear_solver%reason
    do i = 1, size(forces, 2)
      response%free(:, i) = response%free(:, i) + merge(0.0_rk, tied%form%norms * bounds(:, i), tied%status == row_closed)
    end do
  end subroutine solve_terms

  !> Computes S and -H: the responses to a unit force on each changing row, which pushes its sides apart. Stops at a failed
  !> solve. Sets response%reason. Collective.
  subroutine solve_forces(system, tied, response, ierr)
    type(contact_system_t), intent(inout) :: system
    type(tied_system_t), intent(inout) :: tied
    type(tied_response_t), intent(inout) :: response
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: changing(:)
    real(rk), allocatable :: forces(:, :), values(:, :), rows(:, :), fields(:, :)
    integer :: first, i, last

    ierr = 0
    changing = pack([(i, i=1, size(tied%status))], tied%status == row_changing)
    allocate (response%operator(size(tied%status), size(changing)), response%field(size(tied%dofs), size(changing)))
    allocate (response%pattern_fields(system%map%n_dofs, size(tied%patterns, 2)), source=0.0_rk)
    do first = 1, size(changing), chunk
      last = min(first + chunk - 1, size(changing))
      allocate (forces(system%map%n_dofs, last - first + 1), values(system%map%n_dofs, last - first + 1), source=0.0_rk)
      do i = first, last
        forces(tied%form%bounded_dofs(changing(i)), i - first + 1) = -tied%form%norms(changing(i))
      end do
      PetscCall(respond(system, tied, forces, values, rows, fields, ierr))
      if (tied%linear_solver%reason /= reason_converged) exit
      response%operator(:, first:last) = rows
      response%field(:, first:last) = fields(tied%dofs, :)
      call add_product(1.0_rk, fields, tied%patterns(first:last, :), response%pattern_fields)
      deallocate (forces, values)
    end do
    response%reason = tied%linear_solver%reason
  end subroutine solve_forces

  !> Computes the forces of closed rows, minus the displacement along the other rows, and the displacements of all dofs, under
  !> forces on the unknowns of the bound form while some unknowns are held at given values. Collective.
  subroutine respond(system, tied, forces, values, rows, fields, ierr)
    type(contact_system_t), intent(inout) :: system
    type(tied_system_t), intent(inout) :: tied
    !> [force] natural, shape (n_dofs, n_columns)
    real(rk), intent(in) :: forces(:, :)
    !> [length] zero where nothing is held, same shape
    real(rk), intent(in) :: values(:, :)
    !> [force] in closed rows, [length] minus the part of B u on free dofs in the others, shape (n_rows, n_columns)
    real(rk), allocatable, intent(out) :: rows(:, :)
    !> [length] natural, shape (n_dofs, n_columns)
    real(rk), allocatable, intent(out) :: fields(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: local(:, :), rhs(:, :), unknowns(:, :), residual(:, :)
    logical :: is_held(system%map%n_dofs)
    integer :: i

    is_held = .false.
    is_held(tied%held) = .true.
    associate (own => system%map%local_dofs)
      local = values(own, :)
      allocate (rhs, mold=local)
      PetscCall(multiply_block(tied%stiffness, local, rhs, ierr))
      rhs = merge(0.0_rk, forces(own, :) - rhs, spread(is_held(own), 2, size(rhs, 2)))
      PetscCall(tied%linear_solver%solve_many(rhs, local, ierr))
      local = merge(values(own, :), local, spread(is_held(own), 2, size(rhs, 2)))
      PetscCall(multiply_block(tied%stiffness, local, rhs, ierr))
      rhs = rhs - forces(own, :)
    end associate
    PetscCall(system%share_columns(local, size(local, 2), unknowns, ierr))
    PetscCall(system%share_columns(rhs, size(rhs, 2), residual, ierr))
    allocate (rows(size(tied%status), size(local, 2)), fields(system%map%n_dofs, size(local, 2)))
    do i = 1, size(rows, 2)
      rows(:, i) = merge(tied%form%multipliers(residual(:, i)), -tied%form%norms * unknowns(tied%form%bounded_dofs, i), &
        tied%status == row_closed)
      call tied%form%to_displacement(system, unknowns(:, i))
      call system%motions%idle%leave_out(system%motions, unknowns(:, i))
      fields(:, i) = unknowns(:, i)
    end do
  end subroutine respond
end module sig_tied
