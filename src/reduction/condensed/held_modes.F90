! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> POD modes of one body without its rigid motions. Two parts are first subtracted from the snapshots: the response to prescribed
!> displacements (lifting), and the rigid motion of a body that only contact holds. This motion is taken from the displacements of
!> the artificial supports of the body, which are then zero. At last the idle motions are taken out.
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
    !> [-] shape (size(dofs), n_modes); orthonormal before the idle motions are taken out
    real(rk), allocatable, intent(out) :: modes(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(pod_t) :: pod
    real(rk), allocatable :: motions(:, :), amplitudes(:, :), field(:), theta(:, :)
    logical, allocatable :: is_held(:)
    integer, allocatable :: nodes(:), own(:)
    integer :: i, i_bad_point, i_bad_source

    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    PetscCall(find_motions(system, snapshots, lifting, theta(lifted_terms, :), motions, amplitudes, ierr))
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
    nodes = dofs(system%map%n_dim::system%map%n_dim) / system%map%n_dim
    associate (idle => system%motions%idle)
      if (idle%n > 0) call idle%take_from_carriers(system%motions, nodes, &
        idle%shares_of_carriers(system%motions, nodes, modes), modes)
    end associate
  end subroutine find_held_modes

  !> Returns the rigid motions of bodies that only contact or nothing holds, and their amplitudes in each snapshot without its
  !> lifting from its displacements at the supports. Both are empty where there is no such body. Collective on all ranks.
  subroutine find_motions(system, snapshots, lifting, theta, motions, amplitudes, ierr)
    type(contact_system_t), intent(in) :: system
    type(training_set_t), intent(in) :: snapshots
    !> as in find_held_modes
    real(rk), intent(in) :: lifting(:, :)
    !> [-] values of the lifted terms, shape (size(lifting, 2), n_snapshots)
    real(rk), intent(in) :: theta(:, :)
    !> [-] shape (n_dofs, n_free + number of idle motions)
    real(rk), allocatable, intent(out) :: motions(:, :)
    !> [length] shape (size(motions, 2), n_snapshots)
    real(rk), allocatable, intent(out) :: amplitudes(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: moved(:, :)
    integer, allocatable :: supports(:)
    integer :: i, i_node, k, row
    logical :: is_singular

    ierr = 0
    associate (free => system%motions, idle => system%motions%idle, n_dim => system%map%n_dim)
      supports = [free%pick_supports(), idle%supports]
      allocate (motions(system%map%n_dofs, free%n_free + idle%n))
      do k = 1, free%n_free
        motions(:, k) = free%field(unit_vector(free%n_free, k))
      end do
      do i_node = 1, size(free%body_of_node)
        motions(n_dim * (i_node - 1) + 1:n_dim * i_node, free%n_free + 1:) = idle%at_node(free, i_node)
      end do
    end associate
    allocate (moved(size(supports), snapshots%n_snapshots()), source=0.0_rk)
    allocate (amplitudes(size(supports), size(moved, 2)))
    if (size(supports) == 0) return
    do k = 1, size(supports)
      row = supports(k) - snapshots%first_dof + 1
      if (row < 1 .or. row > snapshots%n_own) cycle
      do i = 1, size(moved, 2)
        moved(k, i) = snapshots%displacement(i)%values(row) - dot_product(lifting(supports(k), :), theta(:, i))
      end do
    end do
    PetscCall(sum_over_ranks(PETSC_COMM_WORLD, moved, ierr))
    call solve_dense(motions(supports, :), moved, amplitudes, is_singular)
  end subroutine find_motions
end module sig_held_modes
