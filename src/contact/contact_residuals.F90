! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> How well an answer meets (3): equilibrium, penetration, sign of the multipliers, complementarity, balance of forces. Beside it
!> the energy, which needs the same product with K.
module sig_contact_residuals
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: largest_size, sum_of_sizes
  use sig_load_pattern, only: load_pattern_t
  use sig_petsc_support, only: max_over_ranks, multiply_block, sum_over_ranks
  use sig_problem_sizes, only: problem_sizes_t, sizes_at
  use sig_reasons, only: reason_linear_solver
  use petsc
  implicit none(type, external)
  private
  public :: measure_residuals, measure_points

  !> [-] forces are compared with at least this share of |K| |u|, because K u of a rigid motion is only rounding, and with at least
  !> this share of the largest load on a dof, the parts of which are added without sign, because they may cancel
  real(rk), parameter :: smallest_share = 1.0e-6_rk
  !> number of sizes that are compared, over all dofs: |K u + B' lambda - F| on the free ones, |K u|, |B' lambda|
  integer, parameter :: n_largest = 3

contains

  !> Computes the residuals, the energy and the reactions of one state. Collective on the system's communicator.
  subroutine measure_residuals(system, theta, state, ierr)
    type(contact_system_t), intent(inout) :: system
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> in: displacement and multipliers; out: also residuals, energy, and reactions on all prescribed dofs (0 elsewhere), on every
    !> rank. A positive reason becomes reason_linear_solver if a displacement or multiplier is not finite
    type(contact_state_t), intent(inout) :: state
    PetscErrorCode, intent(out) :: ierr
    type(contact_state_t) :: states(1)
    real(rk), allocatable :: reactions(:, :)

    states(1) = state
    PetscCall(measure_block(system, reshape(theta, [size(theta), 1]), states, reactions, ierr))
    state%residuals = states(1)%residuals
    state%energy = states(1)%energy
    state%reason = states(1)%reason
    if (.not. allocated(state%reactions)) allocate (state%reactions(system%map%n_dofs))
    state%reactions = 0
    state%reactions(system%map%local_dofs(own_prescribed(system))) = reactions(:, 1)
    PetscCall(sum_over_ranks(system%comm, state%reactions, ierr))
  end subroutine measure_residuals

  !> Does the same as measure_residuals for several states, with one pass over K and two reductions over the ranks for all of them;
  !> no reactions. Collective on the system's communicator.
  subroutine measure_points(system, theta, states, ierr)
    type(contact_system_t), intent(inout) :: system
    !> [-] values of the terms at each point, shape (n_terms, n_points)
    real(rk), intent(in) :: theta(:, :)
    !> in: displacement and multipliers; out: also residuals; reason as in measure_residuals; shape (n_points)
    type(contact_state_t), intent(inout) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: reactions(:, :)

    PetscCall(measure_block(system, theta, states, reactions, ierr))
  end subroutine measure_points

  !> Returns the prescribed dofs of this rank. The supports of idle motions are none: their forces count as residual.
  pure function own_prescribed(system) result(held)
    type(contact_system_t), intent(in) :: system
    !> their positions in map%local_dofs, 1-based, ascending
    integer, allocatable :: held(:)
    logical :: is_held(system%map%n_dofs)
    integer :: i

    is_held = system%boundary%is_prescribed
    is_held(system%motions%idle%supports) = .false.
    held = pack([(i, i=1, system%map%n_local_dofs)], is_held(system%map%local_dofs))
  end function own_prescribed

  !> Computes the residuals and the energy of several states, and the reactions on this rank. Collective.
  subroutine measure_block(system, theta, states, reactions, ierr)
    type(contact_system_t), intent(inout) :: system
    !> [-] values of the terms at each point, shape (n_terms, n_points)
    real(rk), intent(in) :: theta(:, :)
    !> in: displacement and multipliers; out: also residuals; reason as in measure_residuals; shape (n_points)
    type(contact_state_t), intent(inout) :: states(:)
    !> [force] reactions at the prescribed dofs of this rank, in the order of own_prescribed; shape (n_held, n_points)
    real(rk), allocatable, intent(out) :: reactions(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: largest(n_largest, size(states)), sums(system%map%n_dim + 3, size(states))
    real(rk), allocatable :: columns(:, :), forces(:, :)
    type(load_pattern_t) :: pattern
    integer, allocatable :: held(:), loaded(:)
    integer :: i

    held = own_prescribed(system)
    call system%boundary%get_forces(pattern)
    loaded = pattern%loaded_dofs(system%map%n_dofs)
    allocate (columns(system%map%n_local_dofs, size(states)), forces(system%map%n_local_dofs, size(states)))
    allocate (reactions(size(held), size(states)))
    do i = 1, size(states)
      columns(:, i) = states(i)%displacement(system%map%local_dofs)
    end do
    PetscCall(multiply_block(system%stiffness, columns, forces, ierr))
    do i = 1, size(states)
      largest(2, i) = largest_size(forces(:, i))
      sums(system%map%n_dim + 3, i) = dot_product(columns(:, i), forces(:, i)) / 2
      call add_forces(system, theta(:, i), states(i)%multipliers, loaded, forces(:, i), largest(3, i), &
        sums(:system%map%n_dim + 2, i))
      reactions(:, i) = forces(held, i)
      forces(held, i) = 0
      largest(1, i) = largest_size(forces(:, i))
    end do
    PetscCall(max_over_ranks(system%comm, largest, ierr))
    PetscCall(sum_over_ranks(system%comm, sums, ierr))
    do i = 1, size(states)
      call compare(system, theta(:, i), sizes_at(system, theta(:, i)), largest(:, i), sums(:, i), states(i))
      states(i)%energy = sums(system%map%n_dim + 3, i)
    end do
  end subroutine measure_block

  !> Adds the contact forces to K u and subtracts the loads, and computes the sums of this rank for the balance of forces. Local.
  pure subroutine add_forces(system, theta, multipliers, loaded, forces, largest_contact, sums)
    type(contact_system_t), intent(in) :: system
    real(rk), intent(in) :: theta(:)
    !> [force] shape (n_rows)
    real(rk), intent(in) :: multipliers(:)
    !> dofs that can carry a load, natural
    integer, intent(in) :: loaded(:)
    !> [force] K u, then K u + B' lambda - F; shape (n_local_dofs)
    real(rk), contiguous, intent(inout) :: forces(:)
    !> [force] largest |B' lambda| on this rank
    real(rk), intent(out) :: largest_contact
    !> [force] of this rank, shape (n_dim + 2): the sum of K u along each component from first_balanced on (0 before it), which is
    !> the resultant of reactions, loads and obstacles; then the sum of |K u + B' lambda - F| and that of |F|
    real(rk), intent(out) :: sums(:)
    real(rk) :: contact(size(forces)), load(system%map%n_dofs)
    integer :: i, i_local, k, n

    n = system%map%n_dim
    sums = 0
    ! K u sums reactions, loads and contact forces; the latter cancel row by row, except those of obstacles
    do i = system%first_balanced, n
      sums(i) = sum(forces(i::n))
    end do
    contact = 0
    do k = 1, system%rows%n_rows
      do i = system%rows%offsets(k) + 1, system%rows%offsets(k + 1)
        i_local = system%map%local_index(system%rows%dofs(i))
        if (i_local > 0) contact(i_local) = contact(i_local) + system%rows%coefficients(i) * multipliers(k)
      end do
    end do
    largest_contact = largest_size(contact)
    forces = forces + contact
    load = system%load(theta)
    do i = 1, size(loaded)
      i_local = system%map%local_index(loaded(i))
      if (i_local == 0) cycle
      forces(i_local) = forces(i_local) - load(loaded(i))
      sums(n + 2) = sums(n + 2) + abs(load(loaded(i)))
    end do
    sums(n + 1) = sum_of_sizes(forces)
  end subroutine add_forces

  !> Computes the residuals of one point: the penetration is a length, the others are relative. Local.
  pure subroutine compare(system, theta, sizes, largest, sums, state)
    type(contact_system_t), intent(in) :: system
    real(rk), intent(in) :: theta(:)
    type(problem_sizes_t), intent(in) :: sizes
    !> [force] largest of all ranks: see n_largest
    real(rk), intent(in) :: largest(n_largest)
    !> [force] those of add_forces, summed over all ranks; then the energy
    real(rk), intent(in) :: sums(:)
    !> in: displacement and multipliers; out: also residuals; the reason changes if a value is not finite
    type(contact_state_t), intent(inout) :: state
    real(rk) :: opening(system%rows%n_rows), smallest_force, displacement_size, excess, wasted
    integer :: i_component, n, n_contacts

    n = system%map%n_dim
    opening = system%gap(theta) - system%rows%apply(state%displacement)
    displacement_size = largest_size(state%displacement)
    n_contacts = system%laws%n_contacts
    call compare_friction(system, state, opening, excess, wasted)
    smallest_force = smallest_share * max(system%stiffness_size * displacement_size, sizes%force)
    associate (r => state%residuals)
      r%equilibrium = relative(largest(1), maxval([smallest_force, largest(2:)]))
      r%penetration = max(0.0_rk, maxval(-opening(:n_contacts)), maxval(abs(opening(:n_contacts)), mask=system%laws%is_tied))
      r%negative_multiplier = relative(max(excess, maxval(-state%multipliers(:n_contacts), mask=.not. system%laws%is_tied)), &
        maxval(abs(state%multipliers)))
      r%complementarity = relative(abs(dot_product(state%multipliers(:n_contacts), opening(:n_contacts))) + wasted, &
        maxval(abs(state%multipliers)) * max(sizes%gap, displacement_size))
      ! contact forces cancel row by row; radial forces of a turned body balance by the hoop stress
      r%force_balance = maxval([(relative(abs(sums(i_component)), max(smallest_force, sums(n + 1) + sums(n + 2))), &
        i_component=system%first_balanced, n)])
    end associate
    if (state%reason > 0 .and. .not. (all(ieee_is_finite(state%displacement)) .and. all(ieee_is_finite(state%multipliers)))) &
      state%reason = reason_linear_solver
  end subroutine compare

  !> Compares tangential forces with the law of friction. Both results are 0 without friction. Local.
  pure subroutine compare_friction(system, state, opening, excess, wasted)
    type(contact_system_t), intent(in) :: system
    type(contact_state_t), intent(in) :: state
    !> [length] D - B u, shape (n_rows)
    real(rk), intent(in) :: opening(:)
    !> [force] largest |lambda_t| - f lambda_n, at least 0
    real(rk), intent(out) :: excess
    !> [force*length] sum of |f lambda_n |slip| - lambda_t . slip|: the work by which friction misses its largest possible one; of
    !> tied contacts |lambda_t . s|
    real(rk), intent(out) :: wasted
    real(rk) :: places(system%rows%n_rows)
    integer :: k

    excess = 0
    wasted = 0
    if (.not. allocated(state%friction)) return
    places = -opening - state%origins
    do k = 1, system%laws%n_contacts
      associate (rows => system%laws%tangents(:system%laws%n_tangents(k), k))
        associate (force => state%multipliers(rows), slip => places(rows), limit => state%friction(k) * state%multipliers(k))
          if (size(force) == 0) cycle
          if (system%laws%is_tied(k)) then
            wasted = wasted + abs(dot_product(force, slip))
            cycle
          end if
          excess = max(excess, norm2(force) - limit)
          if (state%is_active(k)) wasted = wasted + abs(limit * norm2(slip) - dot_product(force, slip))
        end associate
      end associate
    end do
  end subroutine compare_friction

  !> Returns part / whole; 0 if whole is 0 or less (the maxval of an empty array is negative).
  pure real(rk) function relative(part, whole)
    real(rk), intent(in) :: part
    real(rk), intent(in) :: whole

    relative = 0
    if (.not. whole <= 0) relative = part / whole
  end function relative
end module sig_contact_residuals
