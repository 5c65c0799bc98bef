! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Makes a reduced model of the full-order problem condensed to its contacts, as far as the deck allows memory for it. The result is
!> the whole model, or the fallback where a hyper-reduced model has no answer.
module sig_condensed_training
  use sig_condensed, only: condensed_t
  use sig_condensed_data, only: condensed_data_t
  use sig_contact_responses, only: columns_at_once
  use sig_contact_system, only: contact_system_t
  use sig_condensed_plan, only: all_dofs_fit, displacement_plan_t, plan_displacements, why_not_condensed
  use sig_errors, only: error_t
  use sig_full_order, only: full_order_t, team_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply, transposed_product
  use sig_log, only: log_warning
  use sig_petsc_support, only: broadcast_columns, sum_over_ranks
  use sig_pod, only: decompose_contact_parts, pod_t
  use sig_pod_rank, only: pod_rank
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged
  use sig_reduced, only: reduced_t
  use sig_reduced_condensed, only: reduced_condensed_t
  use sig_reference_check, only: drop_inaccurate_references
  use sig_reference_sets, only: choose_references, start_sets_of
  use sig_term_values, only: evaluate_points
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: condense_fallback, share_rows, train_condensed

contains

  !> Makes the fallback of a hyper-reduced model. There is none without contact rows, where reduction.max_full_order_size is 0, or,
  !> with a warning in the log, where the problem cannot be condensed or its stiffness cannot be factored. Collective on all ranks,
  !> with the same result on each.
  subroutine condense_fallback(full_order, multipliers, part, ierr)
    !> loaded problem
    type(full_order_t), intent(inout) :: full_order
    !> [force] contact forces of the snapshots, shape (n_multipliers, n_snapshots)
    real(rk), intent(in) :: multipliers(:, :)
    !> the fallback; not allocated where there is none
    class(reduced_t), allocatable, intent(out) :: part
    PetscErrorCode, intent(out) :: ierr
    type(reduced_condensed_t), allocatable :: reduced
    type(displacement_plan_t) :: plan
    character(:), allocatable :: reason
    integer :: i

    ierr = 0
    reason = why_not_condensed(full_order%problem)
    if (full_order%problem%rows%n_rows == 0 .or. full_order%problem%deck%reduction%max_full_order_size <= 0) return
    if (reason /= '') then
      call warn_of_no_fallback(reason)
      return
    end if
    ! displacements of all nodes or of none: elsewhere the reduced basis gives them
    allocate (plan%boundaries(0), plan%exact_dofs(0))
    if (all_dofs_fit(full_order%problem)) &
      plan%exact_dofs = [(i, i=1, full_order%problem%mesh%n_dim * full_order%problem%mesh%n_nodes)]
    PetscCall(condense(full_order, plan, reduced, ierr))
    if (.not. allocated(reduced)) then
      call warn_of_no_fallback('the stiffness cannot be factored')
      return
    end if
    call measure_forces(multipliers, reduced)
    call move_alloc(reduced, part)
  end subroutine condense_fallback

  !> Warns in the log that the model has no full-order operator.
  subroutine warn_of_no_fallback(reason)
    character(*), intent(in) :: reason

    call log_warning('the model keeps no full-order operator: ' // reason // &
      '; a point has no answer where the reduced problem has no solution, or where the bound of the error, if there is ' // &
      'one, is above certificate.max_error')
  end subroutine warn_of_no_fallback

  !> Makes a model that answers all contact forces exactly, with the active sets from which queries start. Collective on all ranks,
  !> with the same result on each.
  !>
  !> Errors: those of choose_references; the model is there all the same. There is no error where the stiffness could not be
  !> factored.
  subroutine train_condensed(full_order, snapshots, part, error, ierr)
    !> loaded problem
    type(full_order_t), intent(inout) :: full_order
    !> full-order solutions; their displacements are needed only for modes
    type(training_set_t), intent(in) :: snapshots
    !> not allocated where the stiffness could not be factored
    class(reduced_t), allocatable, intent(out) :: part
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(reduced_condensed_t), allocatable :: reduced
    type(displacement_plan_t) :: plan

    plan = plan_displacements(full_order%problem)
    PetscCall(condense(full_order, plan, reduced, ierr))
    if (.not. allocated(reduced)) return
    if (plan%has_modes) then
      PetscCall(add_modes(full_order, snapshots, reduced, ierr))
    end if
    reduced%start_sets = start_sets_of(snapshots%forces(), reduced%anchors)
    call measure_forces(snapshots%forces(), reduced)
    call choose_references(full_order%problem%deck%reduction%max_transforms_size, reduced, error)
    call drop_inaccurate_references(full_order%problem, snapshots, reduced)
    call move_alloc(reduced, part)
  end subroutine train_condensed

  !> Takes from the condensed solver W and q, and the displacements G (per term) and H (per contact force) of the dofs with exact
  !> displacements. Collective on all ranks, with the same result on each.
  subroutine condense(full_order, plan, reduced, ierr)
    type(full_order_t), intent(inout) :: full_order
    type(displacement_plan_t), intent(in) :: plan
    !> not allocated where the stiffness could not be factored
    type(reduced_condensed_t), allocatable, intent(out) :: reduced
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    type(condensed_t), pointer :: condensed

    PetscCall(full_order%ready_team(team, ierr))
    PetscCall(team%solver%condense(condensed, ierr))
    if (condensed%reason /= reason_converged) return
    allocate (reduced)
    associate (problem => full_order%problem, data => reduced)
      data%compliance = condensed%compliance
      data%free_opening = condensed%free_opening
      data%anchors = condensed%anchors%rows
      data%scale = condensed%scale
      data%exact_dofs = plan%exact_dofs
      data%exact_boundaries = plan%boundaries
      PetscCall(share_rows(team, condensed%free_response, problem%boundary%n_terms, plan%exact_dofs, data%free_response, ierr))
      PetscCall(share_contact_response(team, condensed, plan%exact_dofs, data%contact_response, ierr))
    end associate
    PetscCall(agree(reduced, ierr))
  end subroutine condense

  !> Returns some rows of H on every rank; solves for H only if there are any. Collective on the ranks of the team.
  subroutine share_contact_response(team, condensed, dofs, rows, ierr)
    type(team_t), intent(inout) :: team
    type(condensed_t), intent(inout) :: condensed
    !> natural (order of the mesh file)
    integer, intent(in) :: dofs(:)
    !> [length/force] shape (size(dofs), n_multipliers)
    real(rk), allocatable, intent(out) :: rows(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: columns(:, :), shared(:, :)
    integer :: first, last

    ierr = 0
    associate (system => team%solver%system)
      allocate (rows(size(dofs), system%rows%n_rows))
      if (size(dofs) == 0) return
      do first = 1, size(rows, 2), columns_at_once
        last = min(first + columns_at_once - 1, size(rows, 2))
        allocate (columns(system%map%n_local_dofs, last - first + 1))
        PetscCall(condensed%respond_to_rows(system, first, last, columns, ierr))
        PetscCall(share_rows(team, columns, size(columns, 2), dofs, shared, ierr))
        rows(:, first:last) = shared
        deallocate (columns)
      end do
    end associate
  end subroutine share_contact_response

  !> Returns some rows of columns that are spread over the ranks, on every rank. Collective on the ranks of the team.
  subroutine share_rows(team, local, n_columns, dofs, rows, ierr)
    type(team_t), intent(inout) :: team
    !> rows of this rank, shape (n_local_dofs, at most n_columns)
    real(rk), intent(in) :: local(:, :)
    !> number of columns of the result; columns that `local` lacks are zero
    integer, intent(in) :: n_columns
    !> natural (order of the mesh file)
    integer, intent(in) :: dofs(:)
    !> shape (size(dofs), n_columns)
    real(rk), allocatable, intent(out) :: rows(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: i, i_local

    ierr = 0
    allocate (rows(size(dofs), n_columns), source=0.0_rk)
    do i = 1, size(dofs)
      i_local = team%solver%system%map%local_index(dofs(i))
      if (i_local > 0) rows(i, :size(local, 2)) = local(i_local, :)
    end do
    PetscCall(sum_over_ranks(team%solver%system%comm, rows, ierr))
  end subroutine share_rows

  !> Gives every rank W, q, G and H of the first rank, because groups of ranks condense on their own and may differ by rounding.
  !> Collective on all ranks.
  subroutine agree(data, ierr)
    class(condensed_data_t), intent(inout) :: data
    PetscErrorCode, intent(out) :: ierr

    PetscCall(broadcast_columns(data%compliance, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_columns(data%free_opening, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_columns(data%free_response, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_columns(data%contact_response, PETSC_COMM_WORLD, ierr))
  end subroutine agree

  !> Adds displacements of all nodes by POD modes: G of all dofs (in place of G of the exact dofs), the modes, and the coordinates
  !> of H in them. Collective on all ranks.
  subroutine add_modes(full_order, snapshots, data, ierr)
    type(full_order_t), intent(inout) :: full_order
    type(training_set_t), intent(in) :: snapshots
    class(condensed_data_t), intent(inout) :: data
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    type(condensed_t), pointer :: condensed
    real(rk), allocatable :: own(:, :)

    PetscCall(full_order%ready_team(team, ierr))
    PetscCall(team%solver%condense(condensed, ierr))
    associate (problem => full_order%problem, system => team%solver%system)
      PetscCall(system%share_columns(condensed%free_response, problem%boundary%n_terms, data%free_response, ierr))
      PetscCall(broadcast_columns(data%free_response, PETSC_COMM_WORLD, ierr))
      PetscCall(find_modes(problem, snapshots, data, ierr))
      own = data%basis(system%map%local_dofs, :)
      PetscCall(project_contact_response(system, condensed, own, data%contact_coordinates, ierr))
      PetscCall(broadcast_columns(data%contact_coordinates, PETSC_COMM_WORLD, ierr))
    end associate
  end subroutine add_modes

  !> Computes the products of modes with the columns of H, on every rank. Collective on the ranks of the system.
  subroutine project_contact_response(system, condensed, modes, coordinates, ierr)
    type(contact_system_t), intent(in) :: system
    type(condensed_t), intent(inout) :: condensed
    !> rows of this rank, shape (n_local_dofs, n_modes)
    real(rk), intent(in) :: modes(:, :)
    !> shape (n_modes, n_multipliers)
    real(rk), allocatable, intent(out) :: coordinates(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: columns(:, :)
    integer :: first, last

    ierr = 0
    allocate (coordinates(size(modes, 2), system%rows%n_rows))
    do first = 1, size(coordinates, 2), columns_at_once
      last = min(first + columns_at_once - 1, size(coordinates, 2))
      allocate (columns(size(modes, 1), last - first + 1))
      PetscCall(condensed%respond_to_rows(system, first, last, columns, ierr))
      coordinates(:, first:last) = transposed_product(modes, columns)
      deallocate (columns)
    end do
    PetscCall(sum_over_ranks(system%comm, coordinates, ierr))
  end subroutine project_contact_response

  !> Sets data%basis to the POD modes (reduction.pod_tolerance) of u - G theta, the displacements by contact at the training points;
  !> to one column of zeros if these are all 0. Collective on all ranks.
  subroutine find_modes(problem, snapshots, data, ierr)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    !> free_response, which is G, must be set
    class(condensed_data_t), intent(inout) :: data
    PetscErrorCode, intent(out) :: ierr
    type(pod_t) :: pod
    real(rk), allocatable :: theta(:, :)
    integer :: i_bad_point, i_bad_source

    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    theta = theta(:size(data%free_response, 2), :)
    PetscCall(decompose_contact_parts(snapshots, data%free_response, theta, .false., PETSC_COMM_WORLD, pod, ierr))
    PetscCall(pod%left_vectors(pod_rank(pod%singular_values, problem%deck%reduction%pod_tolerance), data%basis, ierr))
    PetscCall(pod%destroy(ierr))
    ! without any mode the model would not keep G of all dofs, which alone gives the displacement here
    if (size(data%basis, 2) == 0) data%basis = spread(0 * data%free_response(:, 1), 2, 1)
  end subroutine find_modes

  !> Raises data%largest_size to the largest norm of the contact forces of one point in the norm of W, without the forces of the
  !> anchors.
  subroutine measure_forces(multipliers, data)
    !> [force] shape (n_multipliers, n_points)
    real(rk), intent(in) :: multipliers(:, :)
    class(condensed_data_t), intent(inout) :: data
    real(rk) :: forces(size(multipliers, 1)), closing(size(multipliers, 1))
    integer :: i

    do i = 1, size(multipliers, 2)
      forces = multipliers(:, i)
      forces(data%anchors) = 0
      call multiply(1.0_rk, data%compliance, forces, 0.0_rk, closing)
      data%largest_size = max(data%largest_size, sqrt(max(0.0_rk, dot_product(forces, closing))))
    end do
  end subroutine measure_forces
end module sig_condensed_training
