! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Makes a reduced model of the full-order problem condensed to its contacts, as far as the deck allows memory for it. The result is
!> the whole model, or the fallback where a hyper-reduced model has no answer.
module sig_condensed_training
  use sig_condensed, only: condensed_t
  use sig_condensed_model, only: condensed_model_t
  use sig_condensed_plan, only: all_dofs_fit, displacement_plan_t, plan_displacements, room_for_transforms, &
    why_not_condensed
  use sig_contact_field, only: contact_field_t
  use sig_contact_field_training, only: add_contact_field, measure_displacements
  use sig_errors, only: error_t
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_full_order, only: full_order_t, team_t
  use sig_kinds, only: rk
  use sig_least_eigenvalue, only: bound_of_eigenvalues
  use sig_linear_algebra, only: multiply
  use sig_log, only: log_info, log_warning
  use sig_petsc_support, only: broadcast_columns, sum_over_ranks
  use sig_problem, only: problem_t
  use sig_progress, only: progress_t
  use sig_reasons, only: reason_converged
  use sig_reduced, only: reduced_t
  use sig_reduced_kinds, only: fixed_of
  use sig_reference_check, only: drop_inaccurate_references
  use sig_reference_sets, only: choose_references, start_sets_of
  use sig_text, only: short_number
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: condense_fallback, share_rows, train_condensed

  !> [s] progress is told only if displacements take longer
  real(rk), parameter :: seconds_of_silence = 3

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
    type(condensed_model_t), allocatable :: model
    type(fixed_compliance_t), allocatable :: fixed
    type(displacement_plan_t) :: plan
    character(:), allocatable :: reason
    integer :: i

    ierr = 0
    reason = why_not_condensed(full_order%problem)
    if (full_order%problem%rows%n_rows == 0 .or. full_order%problem%deck%reduction%max_full_order_size <= 0) return
    if (reason == '' .and. .not. full_order%problem%plan%may_factor) &
      reason = 'the stiffness is too large to factor, or solver.linear is gamg'
    if (reason /= '') then
      call warn_of_no_fallback(reason)
      return
    end if
    ! displacements of all nodes or of none: elsewhere the reduced basis gives them
    allocate (plan%boundaries(0), plan%exact_dofs(0))
    if (all_dofs_fit(full_order%problem)) &
      plan%exact_dofs = [(i, i=1, full_order%problem%mesh%n_dim * full_order%problem%mesh%n_nodes)]
    PetscCall(condense(full_order, plan, fixed, ierr))
    if (.not. allocated(fixed)) then
      call warn_of_no_fallback('the stiffness cannot be factored')
      return
    end if
    call measure_forces(multipliers, fixed)
    call bound_compliance(fixed)
    call drop_idle_terms(fixed)
    allocate (model)
    call move_alloc(fixed, model%compliance)
    call move_alloc(model, part)
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
    !> full-order solutions; their displacements are not used
    type(training_set_t), intent(in) :: snapshots
    !> not allocated where the stiffness could not be factored
    class(reduced_t), allocatable, intent(out) :: part
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(condensed_model_t), allocatable, target :: model
    type(fixed_compliance_t), allocatable :: condensed
    type(fixed_compliance_t), pointer :: fixed
    type(displacement_plan_t) :: plan
    real(rk) :: field_error

    plan = plan_displacements(full_order%problem)
    PetscCall(condense(full_order, plan, condensed, ierr))
    if (.not. allocated(condensed)) return
    allocate (model)
    call move_alloc(condensed, model%compliance)
    model%laws = full_order%problem%laws
    fixed => fixed_of(model)
    call measure_forces(snapshots%forces(), fixed)
    call bound_compliance(fixed)
    if (model%laws%is_plain() .and. .not. full_order%problem%flow%is_there()) then
      fixed%start_sets = start_sets_of(snapshots%forces(), fixed%anchors)
      call choose_references(room_for_transforms(full_order%problem), fixed, error)
      call drop_inaccurate_references(full_order%problem, snapshots, model)
    else
      ! a contact that slips has no complementary pair, which a pivot could exchange, and pivot transforms of q know nothing of
      ! inelastic strains
      call fixed%pivots%complete(fixed%n_rows())
    end if
    if (plan%has_modes) then
      PetscCall(add_contact_field(full_order, snapshots, model, field_error, ierr))
      PetscCall(replace_field(full_order, field_error, fixed, ierr))
    else if (size(plan%exact_dofs) > 0) then
      PetscCall(measure_displacements(full_order%problem, snapshots, model, ierr))
    end if
    call drop_idle_terms(fixed)
    call move_alloc(model, part)
  end subroutine train_condensed

  !> Keeps the responses of all dofs as they are where modes or compressed responses miss reduction.displacement_tolerance, if they
  !> have room; else it warns. Single precision is not enough where parts of a displacement are far larger than their sum.
  !> Collective on all ranks.
  subroutine replace_field(full_order, error, fixed, ierr)
    type(full_order_t), intent(inout) :: full_order
    !> [-] largest error of displacements
    real(rk), intent(in) :: error
    !> its free responses are those of all dofs
    type(fixed_compliance_t), intent(inout) :: fixed
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    type(condensed_t), pointer :: condensed
    integer :: i

    ierr = 0
    associate (problem => full_order%problem, tolerance => full_order%problem%deck%reduction%displacement_tolerance)
      if (error <= tolerance) return
      if (problem%deck%reduction%displacement%type /= 'auto' .or. .not. (all_dofs_fit(problem) .and. problem%plan%may_factor)) then
        call log_warning('displacements ' // fixed%field%describe() // ' have an error in energy of up to ' // &
          short_number(error, 2) // ', more than reduction.displacement_tolerance (' // short_number(tolerance, 2) // ')')
        return
      end if
      call log_info('this is more than reduction.displacement_tolerance (' // short_number(tolerance, 2) // &
        '): the responses of all nodes are kept as they are')
      PetscCall(full_order%ready_team(team, ierr))
      PetscCall(team%solver%condense(condensed, ierr))
      fixed%exact_dofs = [(i, i=1, problem%mesh%n_dim * problem%mesh%n_nodes)]
      fixed%field = contact_field_t()
      call fixed%field%complete(size(fixed%exact_dofs), problem%force_rows%n_rows)
      PetscCall(share_contact_response(team, condensed, fixed%exact_dofs, fixed%contact_response, ierr))
      PetscCall(broadcast_columns(fixed%contact_response, PETSC_COMM_WORLD, ierr))
    end associate
  end subroutine replace_field

  !> Leaves out the last terms that displace no dof, such as the gaps of a moving obstacle, one for each node.
  pure subroutine drop_idle_terms(data)
    type(fixed_compliance_t), intent(inout) :: data
    integer :: n

    n = size(data%free_response, 2)
    do while (n > 0)
      if (any(abs(data%free_response(:, n)) > 0)) exit
      n = n - 1
    end do
    data%free_response = data%free_response(:, :n)
  end subroutine drop_idle_terms

  !> Takes from the condensed solver W and q, and the displacements G (per term) and H (per contact force) of the dofs with exact
  !> displacements. Collective on all ranks, with the same result on each.
  subroutine condense(full_order, plan, fixed, ierr)
    type(full_order_t), intent(inout) :: full_order
    type(displacement_plan_t), intent(in) :: plan
    !> not allocated where the stiffness could not be factored
    type(fixed_compliance_t), allocatable, intent(out) :: fixed
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    type(condensed_t), pointer :: condensed

    PetscCall(full_order%ready_team(team, ierr))
    PetscCall(team%solver%condense(condensed, ierr))
    if (condensed%reason /= reason_converged) return
    allocate (fixed)
    associate (problem => full_order%problem, data => fixed)
      data%compliance = condensed%compliance
      data%free_opening = condensed%free_opening
      data%anchors = condensed%anchors%rows
      data%scale = condensed%scale
      data%free_energy = condensed%free_energy
      data%shared_energy = condensed%shared_energy
      data%exact_dofs = plan%exact_dofs
      data%exact_boundaries = plan%boundaries
      PetscCall(share_rows(team, condensed%free_response, size(condensed%free_response, 2), plan%exact_dofs, data%free_response, ierr))
      if (plan%is_eliminated) then
        data%contact_response = condensed%dof_response
      else
        PetscCall(share_contact_response(team, condensed, plan%exact_dofs, data%contact_response, ierr))
      end if
    end associate
    PetscCall(agree(fixed, ierr))
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
    type(progress_t) :: progress
    real(rk), allocatable :: columns(:, :), shared(:, :)
    integer :: first, k, last

    ierr = 0
    associate (system => team%solver%system, n_at_once => condensed%n_columns_at_once())
      allocate (rows(size(dofs), system%rows%n_rows))
      if (size(dofs) == 0) return
      call progress%start('displacements under contact forces', size(rows, 2), seconds_of_silence)
      do first = 1, size(rows, 2), n_at_once
        last = min(first + n_at_once - 1, size(rows, 2))
        allocate (columns(system%map%n_local_dofs, last - first + 1))
        PetscCall(condensed%respond_to_rows(system, [(k, k=first, last)], columns, ierr))
        PetscCall(share_rows(team, columns, size(columns, 2), dofs, shared, ierr))
        rows(:, first:last) = shared
        deallocate (columns)
        call progress%advance(last)
      end do
      call progress%finish()
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

  !> Gives every rank W, q, G, H and the energies of the first rank, because groups of ranks condense on their own and may differ by
  !> rounding. Collective on all ranks.
  subroutine agree(data, ierr)
    type(fixed_compliance_t), intent(inout) :: data
    PetscErrorCode, intent(out) :: ierr

    PetscCall(broadcast_columns(data%compliance, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_columns(data%free_opening, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_columns(data%free_energy, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_columns(data%shared_energy, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_columns(data%free_response, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_columns(data%contact_response, PETSC_COMM_WORLD, ierr))
  end subroutine agree

  !> Sets the bound of the eigenvalues of W, from which certificates follow. Local, with the same result on each rank.
  subroutine bound_compliance(data)
    type(fixed_compliance_t), intent(inout) :: data
    integer, allocatable :: free_rows(:)
    integer :: i

    free_rows = pack([(i, i=1, data%n_rows())], [(all(data%anchors /= i), i=1, data%n_rows())])
    data%least_eigenvalue = bound_of_eigenvalues(data%compliance(free_rows, free_rows))
  end subroutine bound_compliance

  !> Raises data%largest_size to the largest norm of the contact forces of one point in the norm of W, without the forces of the
  !> anchors.
  subroutine measure_forces(multipliers, data)
    !> [force] shape (n_multipliers, n_points)
    real(rk), intent(in) :: multipliers(:, :)
    type(fixed_compliance_t), intent(inout) :: data
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
