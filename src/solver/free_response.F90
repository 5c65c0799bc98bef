! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Elastic responses without contact, one displacement field per term: to prescribed displacements and loads, or, as lifting, to
!> prescribed displacements and imposed strains alone.
module sig_free_response
  use sig_contact_system, only: contact_system_t
  use sig_holding, only: anchors_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: unit_vector
  use sig_linear_interpolant, only: set_linear_interpolant
  use sig_linear_solver, only: constrain, linear_solver_t, set_near_null_space
  use sig_progress, only: progress_t
  use sig_reasons, only: reason_converged, reason_floating_body
  use petsc
  implicit none(type, external)
  private
  public :: compute_lifting, factor_without_contact, held_dofs, respond, solve_free_response, solve_lifting

  !> [s] progress is told only if responses take longer
  real(rk), parameter :: seconds_of_silence = 3

contains

  !> Prepares solves with K, in which the prescribed dofs are held. Bodies that only contact holds get statically determinate
  !> supports, which have no reactions under forces in equilibrium. If contact cannot hold a body, K cannot be factored, or the
  !> multigrid levels cannot be made, the reason of the linear solver says so. Collective.
  subroutine factor_without_contact(system, linear_solver, ierr)
    type(contact_system_t), intent(in) :: system
    !> in: is_multigrid; out: ready for solves, or with a reason why not
    class(linear_solver_t), intent(inout) :: linear_solver
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: nothing(system%map%n_dofs)
    logical, allocatable :: all_closed(:)
    integer, allocatable :: dofs(:)
    integer :: i
    Mat :: constrained
    Vec :: unused

    ierr = 0
    linear_solver%reason = reason_floating_body
    allocate (all_closed(system%rows%n_rows), source=.true.)
    if (.not. system%motions%are_held_by(all_closed)) return
    nothing = 0
    dofs = pack([(i, i=1, system%map%n_dofs)], held_dofs(system))
    PetscCall(constrain(system, system%stiffness, dofs, nothing, nothing, constrained, unused, ierr))
    if (linear_solver%is_multigrid) then
      PetscCall(set_near_null_space(system, constrained, ierr))
      PetscCall(set_linear_interpolant(system, constrained, ierr))
    end if
    PetscCall(linear_solver%factor(constrained, 'fom_', ierr))
    PetscCall(MatDestroy(constrained, ierr))
    PetscCall(VecDestroy(unused, ierr))
  end subroutine factor_without_contact

  !> Returns which dofs are prescribed, or are supports of bodies that only contact holds. Right-hand sides must be 0 there. Local.
  function held_dofs(system) result(is_held)
    type(contact_system_t), intent(in) :: system
    !> natural, shape (n_dofs)
    logical, allocatable :: is_held(:)

    is_held = system%boundary%is_prescribed
    associate (supports => system%motions%pick_supports())
      is_held(supports) = .true.
    end associate
  end function held_dofs

  !> Computes the displacements under forces, with the held dofs at 0, and without idle motions. Sets the reason of the linear
  !> solver: if it is not reason_converged, response is of no use. Collective.
  subroutine respond(system, linear_solver, forces, response, ierr, label)
    type(contact_system_t), intent(in) :: system
    !> solver from factor_without_contact
    class(linear_solver_t), intent(inout) :: linear_solver
    !> [force] 0 on held dofs; rows of this rank, shape (n_local_dofs, n_columns)
    real(rk), contiguous, intent(in) :: forces(:, :)
    !> [length] rows of this rank, same shape
    real(rk), contiguous, intent(inout) :: response(:, :)
    PetscErrorCode, intent(out) :: ierr
    !> name of the work, for progress where multigrid solves; default: nothing is told
    character(*), intent(in), optional :: label

    if (linear_solver%is_multigrid .and. present(label)) then
      PetscCall(solve_in_turn(linear_solver, forces, label, response, ierr))
    else
      PetscCall(linear_solver%solve_many(forces, response, ierr))
    end if
    PetscCall(system%leave_out_idle(response, ierr))
  end subroutine respond

  !> Solves for one column after the other and tells progress. Ends where a column fails. Collective.
  subroutine solve_in_turn(linear_solver, forces, label, response, ierr)
    class(linear_solver_t), intent(inout) :: linear_solver
    !> as in respond
    real(rk), contiguous, intent(in) :: forces(:, :)
    character(*), intent(in) :: label
    real(rk), contiguous, intent(inout) :: response(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(progress_t) :: progress
    integer :: i

    ierr = 0
    call progress%start(label, size(forces, 2), seconds_of_silence)
    do i = 1, size(forces, 2)
      PetscCall(linear_solver%solve_many(forces(:, i:i), response(:, i:i), ierr))
      if (linear_solver%reason /= reason_converged) exit
      call progress%advance(i)
    end do
    call progress%finish()
  end subroutine solve_in_turn

  !> Computes the displacement without contact under each of the leading terms alone, prescribed values included. Forces of the
  !> anchors balance the loads of bodies that only contact holds. Sets the reason of the linear solver: if it is not
  !> reason_converged, response is of no use. Collective.
  subroutine solve_free_response(system, linear_solver, n_terms, response, ierr, anchors)
    type(contact_system_t), intent(inout) :: system
    !> solver from factor_without_contact
    class(linear_solver_t), intent(inout) :: linear_solver
    !> number of leading terms
    integer, intent(in) :: n_terms
    !> [length] rows of this rank, shape (n_local_dofs, n_terms)
    real(rk), allocatable, intent(out) :: response(:, :)
    PetscErrorCode, intent(out) :: ierr
    !> from find_anchors; without this argument the loads are left out
    type(anchors_t), intent(in), optional :: anchors
    real(rk) :: prescribed(system%map%n_dofs), forces(system%map%n_dofs)
    real(rk), allocatable :: rhs(:, :)
    logical, allocatable :: is_held(:)
    integer :: i_term

    is_held = held_dofs(system)
    associate (local => system%map%local_dofs, n_all => system%boundary%n_terms)
      allocate (rhs(size(local), n_terms), response(size(local), n_terms))
      do i_term = 1, n_terms
        forces = 0
        if (has_prescribed_values(system, i_term)) then
          prescribed = system%prescribed_displacement(unit_vector(n_all, i_term))
          PetscCall(system%apply_stiffness(prescribed, forces, ierr))
        end if
        forces = -forces
        if (present(anchors)) forces = forces + balanced_load(system, anchors, unit_vector(n_all, i_term))
        rhs(:, i_term) = merge(0.0_rk, forces(local), is_held(local))
      end do
      PetscCall(respond(system, linear_solver, rhs, response, ierr, 'responses to loads'))
      do i_term = 1, n_terms
        if (.not. has_prescribed_values(system, i_term)) cycle
        prescribed = system%prescribed_displacement(unit_vector(n_all, i_term))
        response(:, i_term) = response(:, i_term) + prescribed(local)
      end do
    end associate
  end subroutine solve_free_response

  !> Whether a term prescribes a displacement that is not zero. Most terms of a load that moves are forces alone.
  pure logical function has_prescribed_values(system, i_term)
    type(contact_system_t), intent(in) :: system
    !> 1-based
    integer, intent(in) :: i_term

    has_prescribed_values = .false.
    if (i_term <= size(system%boundary%prescribed_values, 2)) &
      has_prescribed_values = any(abs(system%boundary%prescribed_values(:, i_term)) > 0)
  end function has_prescribed_values

  !> Returns the load F - B_T' (work of F on the anchors' motions), which does no work on any free motion; without anchors F.
  function balanced_load(system, anchors, theta) result(forces)
    type(contact_system_t), intent(in) :: system
    type(anchors_t), intent(in) :: anchors
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [force] natural, shape (n_dofs)
    real(rk) :: forces(system%map%n_dofs)
    real(rk) :: multipliers(system%rows%n_rows)

    forces = system%load(theta)
    if (size(anchors%rows) == 0) return
    multipliers = 0
    multipliers(anchors%rows) = matmul(system%motions%work(forces), anchors%amplitudes)
    forces = forces - system%rows%apply_transpose(multipliers, size(forces))
  end function balanced_load

  !> Computes the displacements under the terms of the prescribed displacements alone, without loads, then under the lifted forces
  !> (those of imposed strains). A term that prescribes only zeros has zeros. Sets the reason of the linear solver
  !> if anything is solved: if it is not reason_converged, response is of no use. Collective.
  subroutine solve_lifting(system, linear_solver, response, ierr)
    type(contact_system_t), intent(inout) :: system
    !> solver from factor_without_contact
    class(linear_solver_t), intent(inout) :: linear_solver
    !> [length] rows of this rank, shape (n_local_dofs, n_lifted_terms)
    real(rk), allocatable, intent(out) :: response(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: prescribed(:, :)

    ierr = 0
    allocate (response(system%map%n_local_dofs, system%boundary%n_lifted_terms()), source=0.0_rk)
    associate (n => size(system%boundary%prescribed_values, 2))
      if (moves_boundaries(system)) then
        PetscCall(solve_free_response(system, linear_solver, n, prescribed, ierr))
        response(:, :n) = prescribed
        if (linear_solver%reason /= reason_converged) return
      end if
      if (size(response, 2) == n) return
      PetscCall(solve_lifted_forces(system, linear_solver, response(:, n + 1:), ierr))
    end associate
  end subroutine solve_lifting

  !> Computes the responses to the forces of imposed strains, one per lifted force. These forces are in equilibrium, so the supports
  !> have no reactions. Sets the reason of the linear solver. Collective.
  subroutine solve_lifted_forces(system, linear_solver, response, ierr)
    type(contact_system_t), intent(in) :: system
    class(linear_solver_t), intent(inout) :: linear_solver
    !> [length] out: all columns; rows of this rank, shape (n_local_dofs, n_forces)
    real(rk), intent(inout) :: response(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: forces(system%map%n_dofs), rhs(size(response, 1), size(response, 2))
    real(rk), allocatable :: solved(:, :)
    integer :: i

    do i = 1, size(rhs, 2)
      forces = system%boundary%lifted_forces%forces(unit_vector(size(rhs, 2), i), size(forces))
      where (held_dofs(system)) forces = 0
      rhs(:, i) = forces(system%map%local_dofs)
    end do
    allocate (solved, mold=rhs)
    PetscCall(respond(system, linear_solver, rhs, solved, ierr))
    response = solved
  end subroutine solve_lifted_forces

  !> Whether any term prescribes a displacement that is not zero.
  pure logical function moves_boundaries(system)
    type(contact_system_t), intent(in) :: system

    moves_boundaries = any(abs(system%boundary%prescribed_values) > 0)
  end function moves_boundaries

  !> Computes the lifting, the responses to the prescribed terms and then to the forces of imposed strains (result of
  !> solve_lifting), on every rank and in natural order. Factors K, or builds multigrid for it, only if there is anything to lift.
  !> If there is nothing, or if this or a solve fails, the lifting is zero. Collective.
  subroutine compute_lifting(system, is_multigrid, response, reason, ierr)
    type(contact_system_t), intent(inout) :: system
    !> conjugate gradients with multigrid instead of a factorization
    logical, intent(in) :: is_multigrid
    !> [length] shape (n_dofs, n_lifted_terms)
    real(rk), allocatable, intent(out) :: response(:, :)
    !> reason_converged, also if there is nothing to lift; or why K could not be factored or a solve failed
    integer, intent(out) :: reason
    PetscErrorCode, intent(out) :: ierr
    type(linear_solver_t) :: linear_solver
    real(rk), allocatable :: local(:, :)

    ierr = 0
    reason = reason_converged
    allocate (local(system%map%n_local_dofs, 0))
    if (moves_boundaries(system) .or. system%boundary%lifted_forces%n_entries() > 0) then
      linear_solver%is_multigrid = is_multigrid
      PetscCall(factor_without_contact(system, linear_solver, ierr))
      reason = linear_solver%reason
      if (reason == reason_converged) then
        PetscCall(solve_lifting(system, linear_solver, local, ierr))
        ! conjugate gradients may fail here
        reason = linear_solver%reason
      end if
      if (reason /= reason_converged) local = 0
      PetscCall(linear_solver%destroy(ierr))
    end if
    PetscCall(system%share_columns(local, system%boundary%n_lifted_terms(), response, ierr))
  end subroutine compute_lifting
end module sig_free_response
