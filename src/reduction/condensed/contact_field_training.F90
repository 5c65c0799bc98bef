! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Finds how a condensed model keeps the displacements H z of all dofs: by modes if few are enough, else compressed. Both are chosen
!> by their error in the norm of K at training points and at probes, where the model itself gives the contact forces.
!>
!> Half of the probes help to choose the modes. The other half measures them, because modes are always good where they come from.
module sig_contact_field_training
  use sig_condensed, only: condensed_t
  use sig_condensed_model, only: condensed_model_t
  use sig_contact_field, only: contact_field_t
  use sig_contact_states, only: contact_states_t
  use sig_contact_system, only: contact_system_t
  use sig_energy_modes, only: choose_combinations, product_of
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_full_order, only: full_order_t, team_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: transposed_product
  use sig_log, only: log_info
  use sig_petsc_support, only: broadcast_columns
  use sig_problem, only: problem_t
  use sig_progress, only: duration_text, progress_t
  use sig_reduced_kinds, only: fixed_of
  use sig_response_compression, only: choose_soft_combinations, compress_responses
  use sig_solver_costs, only: cost_t, multigrid_cost, problem_size_t
  use sig_text, only: counted, short_number
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: add_contact_field, measure_displacements

  !> Modes are taken if they are at most this share of the contacts: compressed responses need about as much memory then.
  real(rk), parameter :: most_modes = 0.1_rk
  integer, parameter :: few_modes = 10
  !> [s] progress is told only if the modes take longer
  real(rk), parameter :: seconds_of_silence = 3

contains

  !> Adds G and H of all dofs to the model, so that the error of displacements at the states is at most
  !> reduction.displacement_tolerance, if single precision allows it. Collective on all ranks, with the same result on each.
  !> Requires: `model` answers queries.
  subroutine add_contact_field(full_order, snapshots, model, error, ierr)
    type(full_order_t), intent(inout) :: full_order
    type(training_set_t), intent(in) :: snapshots
    !> its compliance, a fixed one, gets field, free_response of all dofs and largest_field
    type(condensed_model_t), target, intent(inout) :: model
    !> [-] largest error of displacements at the states
    real(rk), intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    type(condensed_t), pointer :: condensed
    type(fixed_compliance_t), pointer :: fixed
    type(contact_states_t) :: states
    real(rk), allocatable :: combinations(:, :), motions(:, :)
    real(rk) :: tolerance
    logical :: has_few

    PetscCall(full_order%ready_team(team, ierr))
    PetscCall(team%solver%condense(condensed, ierr))
    PetscCall(states%find(full_order%problem, snapshots, model, ierr))
    fixed => fixed_of(model)
    tolerance = full_order%problem%deck%reduction%displacement_tolerance
    associate (system => team%solver%system, field => fixed%field)
      call field%complete(system%map%n_dofs, system%rows%n_rows)
      PetscCall(system%share_columns(condensed%free_response, size(condensed%free_response, 2), fixed%free_response, ierr))
      PetscCall(broadcast_columns(fixed%free_response, PETSC_COMM_WORLD, ierr))
      allocate (motions(system%map%n_local_dofs, size(fixed%anchors)))
      PetscCall(condensed%respond_to_rows(system, fixed%anchors, motions, ierr))
      PetscCall(system%share_columns(motions, size(motions, 2), field%motions, ierr))
      PetscCall(broadcast_columns(field%motions, PETSC_COMM_WORLD, ierr))
      call choose_modes(states, fixed, tolerance, condensed%is_multigrid, combinations)
      has_few = allocated(combinations)
      if (.not. has_few) call choose_soft_combinations(full_order%problem, fixed, combinations)
      if (condensed%is_multigrid) call announce_modes(full_order%problem%sizes, size(combinations, 2))
      PetscCall(make_modes(system, condensed, combinations, field, ierr))
      if (.not. has_few) then
        PetscCall(compress(full_order%problem, system, condensed, states, tolerance, fixed, ierr))
      end if
    end associate
    error = states%largest_error(fixed)
    call log_info('displacements ' // fixed%field%describe() // ': their error in energy is at most ' // &
      short_number(error, 2) // ' at ' // counted(size(states%sizes), 'point'))
  end subroutine add_contact_field

  !> Sets largest_field of the model, the largest size of the displacement at the training points. Collective on all ranks.
  !> Requires: `model` answers queries.
  subroutine measure_displacements(problem, snapshots, model, ierr)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(condensed_model_t), intent(inout) :: model
    PetscErrorCode, intent(out) :: ierr
    type(contact_states_t) :: states

    PetscCall(states%measure_solutions(problem, snapshots, model, ierr))
  end subroutine measure_displacements

  !> Finds the combinations S of contact forces whose displacements H S are the modes, orthonormal in the norm of K: the principal
  !> ones of the states, each state relative to its size. There are as many as bring the error of all states to the tolerance.
  !> They are not allocated if that takes too many (takes_all). Local, with the same result on each rank.
  subroutine choose_modes(states, fixed, tolerance, takes_all, combinations)
    type(contact_states_t), intent(in) :: states
    type(fixed_compliance_t), intent(in) :: fixed
    !> [-]
    real(rk), intent(in) :: tolerance
    !> as many modes as there are may be taken: compressed responses need a solve for each contact, which takes too long with
    !> multigrid
    logical, intent(in) :: takes_all
    !> [force/sqrt(force*length)] S, shape (n_multipliers, n_modes)
    real(rk), allocatable, intent(out) :: combinations(:, :)
    real(rk), allocatable :: all_combinations(:, :), chosen(:, :), coordinates(:, :)
    integer :: i, n

    chosen = states%unknowns(:, pack([(i, i=1, size(states%sizes))], states%is_for_modes))
    associate (sizes => pack(states%sizes, states%is_for_modes))
      do i = 1, size(chosen, 2)
        chosen(:, i) = chosen(:, i) / sizes(i)
      end do
    end associate
    call choose_combinations(chosen, fixed%compliance, all_combinations)
    coordinates = transposed_product(product_of(fixed%compliance, all_combinations), states%unknowns)
    n = number_of_modes(states, coordinates, tolerance)
    if (takes_all) then
      n = min(n, size(coordinates, 1))
    else if (n > min(size(coordinates, 1), max(few_modes, int(most_modes * fixed%n_rows())))) then
      return
    end if
    combinations = all_combinations(:, :n)
  end subroutine choose_modes

  !> Returns the least number of modes with which the error of all states is at most the tolerance; one more than there are if all
  !> are not enough.
  pure integer function number_of_modes(states, coordinates, tolerance) result(n)
    type(contact_states_t), intent(in) :: states
    !> of the states in all modes, shape (n_modes, n_states)
    real(rk), intent(in) :: coordinates(:, :)
    real(rk), intent(in) :: tolerance
    real(rk) :: squares(size(states%sizes))

    squares = states%energies
    do n = 0, size(coordinates, 1)
      if (n > 0) squares = squares - coordinates(n, :)**2
      if (all(sqrt(max(squares, 0.0_rk)) <= tolerance * states%sizes)) return
    end do
  end function number_of_modes

  !> Tells what a solution by multigrid for each mode will take.
  subroutine announce_modes(sizes, n_modes)
    type(problem_size_t), intent(in) :: sizes
    integer, intent(in) :: n_modes
    type(cost_t) :: cost

    cost = multigrid_cost(sizes, n_modes, 1)
    if (cost%seconds > seconds_of_silence) call log_info(counted(n_modes, 'mode') // ' of displacements, a solution by ' // &
      'multigrid for each: about ' // duration_text(cost%seconds))
  end subroutine announce_modes

  !> Sets modes and coordinates of the field. Without any mode there is one of zeros, so that the model keeps G of all dofs.
  !> Collective on all ranks.
  subroutine make_modes(system, condensed, combinations, field, ierr)
    type(contact_system_t), intent(in) :: system
    type(condensed_t), intent(inout) :: condensed
    !> S
    real(rk), intent(in) :: combinations(:, :)
    type(contact_field_t), intent(inout) :: field
    PetscErrorCode, intent(out) :: ierr
    type(progress_t) :: progress
    real(rk), allocatable :: local(:, :), used(:, :)
    integer :: first, last

    allocate (used(size(combinations, 1), max(1, size(combinations, 2))), source=0.0_rk)
    used(:, :size(combinations, 2)) = combinations
    allocate (local(system%map%n_local_dofs, size(used, 2)))
    call progress%start('modes of displacements', size(used, 2), seconds_of_silence)
    do first = 1, size(used, 2), condensed%n_columns_at_once()
      last = min(first + condensed%n_columns_at_once() - 1, size(used, 2))
      PetscCall(condensed%respond(system, used(:, first:last), local(:, first:last), ierr))
      call progress%advance(last)
    end do
    call progress%finish()
    PetscCall(system%share_columns(local, size(local, 2), field%modes, ierr))
    PetscCall(broadcast_columns(field%modes, PETSC_COMM_WORLD, ierr))
    field%coordinates = transposed_product(used, condensed%compliance)
    field%coordinates(:, condensed%anchors%rows) = 0
    PetscCall(broadcast_columns(field%coordinates, PETSC_COMM_WORLD, ierr))
  end subroutine make_modes

  !> Compresses what the modes leave of H so that the error of all states is at most the tolerance, in at most two
  !> attempts. Collective on all ranks.
  subroutine compress(problem, system, condensed, states, tolerance, fixed, ierr)
    type(problem_t), intent(in) :: problem
    type(contact_system_t), intent(inout) :: system
    type(condensed_t), intent(inout) :: condensed
    type(contact_states_t), intent(in) :: states
    !> [-]
    real(rk), intent(in) :: tolerance
    type(fixed_compliance_t), intent(inout) :: fixed
    PetscErrorCode, intent(out) :: ierr
    real(rk), parameter :: safety = 0.8_rk
    real(rk) :: error

    PetscCall(compress_responses(problem, system, condensed, states, safety * tolerance, fixed, ierr))
    error = states%largest_error(fixed)
    if (error <= tolerance) return
    PetscCall(compress_responses(problem, system, condensed, states, (safety * tolerance)**2 / error, fixed, ierr))
  end subroutine compress
end module sig_contact_field_training
