! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> POD modes of one body that are zero on its held dofs. Two parts are first subtracted from the snapshots: the response to
!> prescribed displacements (lifting), and the rigid motion of a body that only contact holds. This motion is taken from the
!> displacements of the artificial supports of the body.
module sig_held_modes
  use sig_contact_system, only: contact_system_t
  use sig_free_response, only: held_dofs
  use sig_kinds, only: rk
  use sig_linear_algebra, only: solve_dense, unit_vector
  use sig_petsc_support, only: sum_over_ranks
  use sig_pod, only: pod_t
  use sig_pod_rank, only: pod_rank
  use sig_problem, only: problem_t
  use sig_term_values, only: evaluate_points
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: find_held_modes

contains

  !> Computes the POD modes of one body, as many as reduction.pod_tolerance asks for (none where only rounding is left), from the
  !> snapshots without lifting and free rigid motions. Collective on all ranks, with the same result on each.
  subroutine find_held_modes(problem, system, snapshots, dofs, lifting, lifted_terms, modes, ierr)
    type(problem_t), intent(in) :: problem
    type(contact_system_t), intent(in) :: system
    type(training_set_t), intent(in) :: snapshots
    !> dofs of the body, natural (order of the mesh file), ascending
    integer, intent(in) :: dofs(:)
    !> [length] response of all dofs of the mesh to prescribed displacements, shape (n_dofs, size(lifted_terms))
    real(rk), intent(in) :: lifting(:, :)
    !> numbers of the terms of the prescribed displacements
    integer, intent(in) :: lifted_terms(:)
    !> [-] shape (size(dofs), n_modes); orthonormal before rounding errors on held dofs are set to zero
    real(rk), allocatable, intent(out) :: modes(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(pod_t) :: pod
    real(rk), allocatable :: motions(:, :), amplitudes(:, :), field(:), theta(:, :)
    logical, allocatable :: is_held(:)
    integer, allocatable :: own(:)
    integer :: i, i_bad_point, i_bad_source

    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    PetscCall(find_motions(system, snapshots, motions, amplitudes, ierr))
    own = pack(dofs, dofs >= snapshots%first_dof .and. dofs < snapshots%first_dof + snapshots%n_own)
    PetscCall(pod%create(size(own), size(dofs), snapshots%n_snapshots(), PETSC_COMM_WORLD, ierr))
    do i = 1, snapshots%n_snapshots()
      field = snapshots%displacement(i)%values(own - snapshots%first_dof + 1)
      field = field - matmul(motions(own, :), amplitudes(:, i)) - matmul(lifting(own, :), theta(lifted_terms, i))
      PetscCall(pod%set_snapshot(i, field, ierr))
    end do
    PetscCall(pod%decompose(ierr))
    PetscCall(pod%left_vectors(pod_rank(pod%singular_values, problem%deck%reduction%pod_tolerance), modes, ierr))
    PetscCall(pod%destroy(ierr))
    is_held = held_dofs(system)
    do i = 1, size(dofs)
      if (is_held(dofs(i))) modes(i, :) = 0
    end do
  end subroutine find_held_modes

  !> Returns the rigid motions of bodies that only contact holds, and their amplitudes in each snapshot from its displacements at
  !> the supports. Both are empty where there is no such body. Collective on all ranks.
  subroutine find_motions(system, snapshots, motions, amplitudes, ierr)
    type(contact_system_t), intent(in) :: system
    type(training_set_t), intent(in) :: snapshots
    !> [-] shape (n_dofs, n_free)
    real(rk), allocatable, intent(out) :: motions(:, :)
    !> [length] shape (n_free, n_snapshots)
    real(rk), allocatable, intent(out) :: amplitudes(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: moved(:, :)
    integer, allocatable :: supports(:)
    integer :: i, k, row
    logical :: is_singular

    ierr = 0
    supports = system%motions%pick_supports()
    allocate (motions(system%map%n_dofs, system%motions%n_free))
    do k = 1, size(motions, 2)
      motions(:, k) = system%motions%field(unit_vector(size(motions, 2), k))
    end do
    allocate (moved(size(supports), snapshots%n_snapshots()), source=0.0_rk)
    allocate (amplitudes(size(supports), size(moved, 2)))
    if (size(supports) == 0) return
    do k = 1, size(supports)
      row = supports(k) - snapshots%first_dof + 1
      if (row < 1 .or. row > snapshots%n_own) cycle
      do i = 1, size(moved, 2)
        moved(k, i) = snapshots%displacement(i)%values(row)
      end do
    end do
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, moved, ierr))
    call solve_dense(motions(supports, :), moved, amplitudes, is_singular)
  end subroutine find_motions
end module sig_held_modes
