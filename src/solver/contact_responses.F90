! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Displacements without contact, from one factorization of K: G under each driving term, and -H under a unit contact force of each
!> row.
!>
!> Anchors T hold bodies that only contact holds. Their forces balance the others: Z' (F - B' lambda) = 0.
module sig_contact_responses
  use sig_contact_system, only: contact_system_t
  use sig_free_response, only: factor_without_contact, held_dofs, respond, solve_free_response, solve_lifting
  use sig_holding, only: anchors_t, find_anchors
  use sig_kinds, only: rk
  use sig_linear_algebra, only: transposed_product, unit_vector
  use sig_linear_solver, only: linear_solver_t
  use sig_petsc_support, only: max_over_ranks, multiply_block, sum_over_ranks
  use sig_reasons, only: reason_converged
  use sig_rounding, only: rounding
  use petsc
  implicit none(type, external)
  private
  public :: anchor_forces, close_rows, columns_at_once, measure_work, solve_columns, solve_forces, solve_responses

  !> number of columns of H that are computed together: with more of them, solves are hardly faster and take more memory
  integer, parameter :: columns_at_once = 64

contains

  !> Computes G, H and the lifting with one factorization. If the contacts cannot hold a body or K cannot be factored, reason says
  !> why, and there are neither arrays nor anchors. Arrays hold the rows of this rank. Collective.
  subroutine solve_responses(system, anchors, free_response, lifting, contact_response, reason, ierr, forces)
    type(contact_system_t), intent(inout) :: system
    !> pairs that hold the bodies which only contact holds; none if there are no such bodies
    type(anchors_t), intent(out) :: anchors
    !> [length] G, shape (n_local_dofs, n_driving_terms)
    real(rk), allocatable, intent(out) :: free_response(:, :)
    !> [length] displacements under the prescribed displacements alone, one per term, then under each lifted force (those of imposed
    !> strains); shape (n_local_dofs, n_lifted_terms)
    real(rk), allocatable, intent(out) :: lifting(:, :)
    !> [length/force] H = K^-1 (B' - B_T' N'), shape (n_local_dofs, n_rows); with `forces` [length] H times these, shape
    !> (n_local_dofs, n_sets)
    real(rk), allocatable, intent(out) :: contact_response(:, :)
    !> reason_converged, or why there are no responses
    integer, intent(out) :: reason
    PetscErrorCode, intent(out) :: ierr
    !> [force] sets of contact forces, shape (n_rows, n_sets); default: a unit force on each row
    real(rk), allocatable, intent(in), optional :: forces(:, :)
    type(linear_solver_t) :: linear_solver

    PetscCall(factor_without_contact(system, linear_solver, ierr))
    reason = linear_solver%reason
    if (reason == reason_converged) then
      call find_anchors(system%motions, anchors)
      PetscCall(solve_free_response(system, linear_solver, system%boundary%n_driving_terms, free_response, ierr, anchors))
      PetscCall(solve_lifting(system, linear_solver, lifting, ierr))
      if (present(forces)) then
        PetscCall(solve_sets(system, anchors, linear_solver, forces, contact_response, ierr))
      else
        PetscCall(solve_contact(system, anchors, linear_solver, contact_response, ierr))
      end if
    end if
    PetscCall(linear_solver%destroy(ierr))
  end subroutine solve_responses

  !> Computes H = K^-1 (B' - B_T' N'). Collective.
  subroutine solve_contact(system, anchors, linear_solver, response, ierr)
    type(contact_system_t), intent(in) :: system
    type(anchors_t), intent(in) :: anchors
    class(linear_solver_t), intent(inout) :: linear_solver
    !> [length/force] rows of this rank, shape (n_local_dofs, n_rows)
    real(rk), allocatable, intent(out) :: response(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: first, k, last

    ierr = 0
    allocate (response(system%map%n_local_dofs, system%rows%n_rows))
    do first = 1, system%rows%n_rows, columns_at_once
      last = min(first + columns_at_once - 1, system%rows%n_rows)
      PetscCall(solve_columns(system, anchors, linear_solver, [(k, k=first, last)], response(:, first:last), ierr))
    end do
  end subroutine solve_contact

  !> Computes H times any number of sets of contact forces. Collective.
  subroutine solve_sets(system, anchors, linear_solver, forces, response, ierr)
    type(contact_system_t), intent(in) :: system
    type(anchors_t), intent(in) :: anchors
    class(linear_solver_t), intent(inout) :: linear_solver
    !> [force] shape (n_rows, n_sets)
    real(rk), intent(in) :: forces(:, :)
    !> [length] rows of this rank, shape (n_local_dofs, n_sets)
    real(rk), allocatable, intent(out) :: response(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: first, last

    ierr = 0
    allocate (response(system%map%n_local_dofs, size(forces, 2)))
    do first = 1, size(forces, 2), columns_at_once
      last = min(first + columns_at_once - 1, size(forces, 2))
      PetscCall(solve_forces(system, anchors, linear_solver, forces(:, first:last), response(:, first:last), ierr))
    end do
  end subroutine solve_sets

  !> Computes the columns of H = K^-1 (B' - B_T' N') that belong to some rows; those of anchors are zero up to rounding. Sets the
  !> reason of the linear solver, as solve_many does. Collective.
  subroutine solve_columns(system, anchors, linear_solver, chosen, response, ierr)
    type(contact_system_t), intent(in) :: system
    type(anchors_t), intent(in) :: anchors
    class(linear_solver_t), intent(inout) :: linear_solver
    !> rows, 1-based; more than columns_at_once of them only take more memory
    integer, intent(in) :: chosen(:)
    !> [length/force] rows of this rank, shape (n_local_dofs, size(chosen))
    real(rk), contiguous, intent(out) :: response(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: multipliers(:, :)
    integer :: i

    allocate (multipliers(system%rows%n_rows, size(chosen)), source=0.0_rk)
    do i = 1, size(chosen)
      multipliers(chosen(i), i) = 1
    end do
    PetscCall(solve_forces(system, anchors, linear_solver, multipliers, response, ierr))
  end subroutine solve_columns

  !> Computes H lambda = K^-1 (B' - B_T' N') lambda for several sets of contact forces, one solve for each. Sets the reason of the
  !> linear solver, as solve_many does. Collective.
  subroutine solve_forces(system, anchors, linear_solver, multipliers, response, ierr)
    type(contact_system_t), intent(in) :: system
    type(anchors_t), intent(in) :: anchors
    class(linear_solver_t), intent(inout) :: linear_solver
    !> [force] shape (n_rows, n_sets)
    real(rk), intent(in) :: multipliers(:, :)
    !> [length] rows of this rank, shape (n_local_dofs, n_sets)
    real(rk), contiguous, intent(out) :: response(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: forces(size(multipliers, 1))
    real(rk), allocatable :: rhs(:, :)
    logical, allocatable :: is_held(:)
    integer :: i, k

    is_held = held_dofs(system)
    allocate (rhs(size(response, 1), size(response, 2)), source=0.0_rk)
    do i = 1, size(rhs, 2)
      forces = multipliers(:, i)
      if (size(anchors%rows) > 0) forces(anchors%rows) = forces(anchors%rows) - matmul(multipliers(:, i), anchors%closing)
      do k = 1, size(forces)
        if (abs(forces(k)) > 0) call add_row(system, is_held, k, forces(k), rhs(:, i))
      end do
    end do
    PetscCall(respond(system, linear_solver, rhs, response, ierr))
  end subroutine solve_forces

  !> Returns the forces [force per unit of theta] of the closed anchors under each term without other contact forces, positive where
  !> an anchor presses; shape (n_anchors, n_terms). A force that is only rounding is zero. Local.
  function anchor_forces(system, anchors) result(forces)
    type(contact_system_t), intent(in) :: system
    type(anchors_t), intent(in) :: anchors
    real(rk) :: forces(size(anchors%rows), system%boundary%n_terms)
    real(rk) :: work(size(anchors%rows)), work_size(size(anchors%rows))
    integer :: t

    if (size(anchors%rows) == 0) return
    do t = 1, size(forces, 2)
      associate (load => system%load(unit_vector(size(forces, 2), t)))
        work = matmul(system%motions%work(load), anchors%amplitudes)
        work_size = matmul(system%motions%work_size(load), abs(anchors%amplitudes))
      end associate
      forces(:, t) = merge(work, 0.0_rk, abs(work) > rounding * work_size)
    end do
  end function anchor_forces

  !> Adds row k of B times a factor to a vector over the dofs of this rank; held dofs get nothing. Local.
  pure subroutine add_row(system, is_held, k, factor, column)
    type(contact_system_t), intent(in) :: system
    !> result of held_dofs, natural, shape (n_dofs)
    logical, intent(in) :: is_held(:)
    !> row, 1-based
    integer, intent(in) :: k
    real(rk), intent(in) :: factor
    !> in and out: the vector, shape (n_local_dofs)
    real(rk), intent(inout) :: column(:)
    integer :: i, i_local

    do i = system%rows%offsets(k) + 1, system%rows%offsets(k + 1)
      if (is_held(system%rows%dofs(i))) cycle
      i_local = system%map%local_index(system%rows%dofs(i))
      if (i_local == 0) cycle
      column(i_local) = column(i_local) + factor * system%rows%coefficients(i)
    end do
  end subroutine add_row

  !> Computes B times columns that are distributed over the ranks; the result is the same on all ranks. Collective.
  subroutine close_rows(system, columns, closing, ierr, is_counted)
    type(contact_system_t), intent(in) :: system
    !> rows of this rank, shape (n_local_dofs, n_columns)
    real(rk), intent(in) :: columns(:, :)
    !> shape (n_rows, n_columns)
    real(rk), allocatable, intent(out) :: closing(:, :)
    PetscErrorCode, intent(out) :: ierr
    !> whether a dof counts, natural, shape (n_dofs); default: all count
    logical, intent(in), optional :: is_counted(:)
    integer :: i, i_column, i_local, k

    ierr = 0
    allocate (closing(system%rows%n_rows, size(columns, 2)), source=0.0_rk)
    do i_column = 1, size(columns, 2)
      do k = 1, system%rows%n_rows
        do i = system%rows%offsets(k) + 1, system%rows%offsets(k + 1)
          i_local = system%map%local_index(system%rows%dofs(i))
          if (i_local == 0) cycle
          if (present(is_counted)) then
            if (.not. is_counted(system%rows%dofs(i))) cycle
          end if
          closing(k, i_column) = closing(k, i_column) + system%rows%coefficients(i) * columns(i_local, i_column)
        end do
      end do
      PetscCall(sum_over_ranks(system%comm, closing(:, i_column), ierr))
    end do
  end subroutine close_rows

  !> Computes U'K U [force*length per square unit of the columns] of displacements U. Where loads act on surfaces, most rows of K U
  !> are zero but for rounding beside the largest of their column, because columns have different units; they are left out.
  !> Collective.
  subroutine measure_work(system, columns, work, ierr, is_counted)
    type(contact_system_t), intent(in) :: system
    !> U, rows of this rank, shape (n_local_dofs, n_columns)
    real(rk), contiguous, intent(in) :: columns(:, :)
    !> shape (n_columns, n_columns)
    real(rk), allocatable, intent(out) :: work(:, :)
    PetscErrorCode, intent(out) :: ierr
    !> whether a dof counts, natural, shape (n_dofs); default: all count
    logical, intent(in), optional :: is_counted(:)
    real(rk), allocatable :: forces(:, :), largest(:, :), products(:, :)
    integer, allocatable :: rows(:)
    logical :: is_there(size(columns, 1))
    integer :: first, i, last

    ierr = 0
    is_there = .true.
    if (present(is_counted)) is_there = is_counted(system%map%local_dofs)
    allocate (work(size(columns, 2), size(columns, 2)))
    do first = 1, size(work, 2), columns_at_once
      last = min(first + columns_at_once - 1, size(work, 2))
      allocate (forces(size(columns, 1), last - first + 1))
      PetscCall(multiply_block(system%stiffness, columns(:, first:last), forces, ierr))
      largest = reshape(maxval(abs(forces), dim=1), [1, size(forces, 2)])
      PetscCall(max_over_ranks(system%comm, largest, ierr))
      rows = pack([(i, i=1, size(forces, 1))], &
        [(is_there(i) .and. any(abs(forces(i, :)) > rounding * largest(1, :)), i=1, size(forces, 1))])
      products = transposed_product(columns(rows, :), forces(rows, :))
      PetscCall(sum_over_ranks(system%comm, products, ierr))
      work(:, first:last) = products
      deallocate (forces)
    end do
  end subroutine measure_work
end module sig_contact_responses
