! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The errors of reduced answers, compared with the full-order solutions at the same points: (17), (18), (19), and those of the
!> fields: the norm of the stiffness, von Mises stresses and contact pressures.
module sig_error_norms
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_answer_errors, only: all_forces, compare_displacements, compare_forces, comparison_t, rid_forces
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_domain_energy, only: domain_energy_t
  use sig_field_errors, only: compare_pressures, compare_von_mises
  use sig_field_map, only: field_map_t, field_values_t
  use sig_imposed_energy, only: imposed_energy_t
  use sig_kinds, only: rk
  use sig_online_model, only: online_model_t
  use sig_petsc_support, only: multiply_block, sum_over_ranks
  use sig_answer, only: answer_t
  use sig_reconstruction, only: reconstruct_displacement, reconstruct_multipliers
  use sig_rooms, only: rooms_t
  use petsc
  implicit none(type, external)
  private
  public :: point_errors_t, measured_domain_t, measured_bodies_t, measure_errors

  !> What computes the energies of a set of cells.
  type :: measured_domain_t
    !> 1/2 u' K u; not used for all cells, because the contact system has their K
    type(domain_energy_t) :: stiffness
    !> the part of the energy that comes from imposed strains
    type(imposed_energy_t) :: imposed
  end type measured_domain_t

  !> What computes the energies of all bodies and of the reduced domains.
  type :: measured_bodies_t
    !> the cells of the reduced domain of each cluster
    type(measured_domain_t), allocatable :: domains(:)
    !> all cells
    type(measured_domain_t) :: whole
    !> [-] values of the terms of the imposed strains at the points, shape (n_strain_terms, n_points)
    real(rk), allocatable :: strain_theta(:, :)
    !> whole mesh, on the leader of a group of ranks only, and the values of its terms at the points, shape (n_terms, n_points)
    type(field_map_t) :: fields
    real(rk), allocatable :: field_theta(:, :)
  end type measured_bodies_t

  !> The errors of an answer at one point, as differences from the full-order solution and its sizes.
  type :: point_errors_t
    !> [length] (17)
    type(comparison_t) :: displacement
    !> [force] (18) on the reduced domain, and on all contacts after reconstruction
    type(comparison_t) :: multipliers_rid
    type(comparison_t) :: multipliers_all
    !> [force*length] (19), the difference of the strain energies less the work of the loads F' u, on all bodies and on the reduced
    !> domain (there F only on the dofs of A); the size is that of the full-order energy on the same cells
    type(comparison_t) :: energy
    type(comparison_t) :: energy_rid
    !> [sqrt(force*length)] error of the displacement in the norm of the stiffness; the difference is NaN if some dofs have no
    !> displacement
    type(comparison_t) :: field
    !> [force/length**2] results of compare_von_mises and compare_pressures; only on ranks that have the field map
    type(comparison_t) :: von_mises_largest
    type(comparison_t) :: von_mises
    type(comparison_t) :: pressure
    !> where materials flow: [force] contact forces before their correction, [-] the largest equivalent plastic and creep strains,
    !> whose differences are NaN where no material has such strains, and [force] by how much the correction moved the forces
    type(comparison_t) :: raw_forces
    type(comparison_t) :: plastic_strain
    type(comparison_t) :: creep_strain
    type(comparison_t) :: correction
  end type point_errors_t

contains

  !> Computes the errors of the answers at several points that share the stiffness of the system. They mean nothing where an answer
  !> or a full-order solution failed. Collective on system%comm.
  subroutine measure_errors(system, bodies, online, answers, states, errors, ierr)
    type(contact_system_t), intent(inout) :: system
    !> with the elastic constants and strain_theta of these points
    type(measured_bodies_t), intent(in) :: bodies
    !> prepared
    type(online_model_t), intent(in) :: online
    !> answers of the model, shape (n_points)
    type(answer_t), intent(in) :: answers(:)
    !> full-order solutions at the same points, shape (n_points)
    type(contact_state_t), intent(in) :: states(:)
    !> shape (n_points)
    type(point_errors_t), intent(out) :: errors(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: displacement(:)
    real(rk) :: fields(system%map%n_dofs, 2 * size(states)), energies(2, 2 * size(states))
    integer :: i, n

    n = size(states)
    do i = 1, n
      call reconstruct_displacement(online%model, answers(i), displacement)
      fields(:, i) = displacement
      fields(:, n + i) = states(i)%displacement
      errors(i)%displacement = compare_displacements(online, answers(i), displacement, states(i)%displacement)
      errors(i)%multipliers_rid = compare_forces(rid_forces, online, answers(i), states(i)%multipliers)
      errors(i)%multipliers_all = compare_forces(all_forces, online, answers(i), states(i)%multipliers)
    end do
    PetscCall(measure_fields(system, fields, errors, ierr))
    PetscCall(measure_energies(system, bodies, online, answers, fields, energies, ierr))
    errors%energy%difference = abs(energies(1, :n) - energies(1, n + 1:))
    errors%energy%size = abs(energies(1, n + 1:))
    errors%energy_rid%difference = abs(energies(2, :n) - energies(2, n + 1:))
    errors%energy_rid%size = abs(energies(2, n + 1:))
    do i = 1, n
      ! where materials flow, equilibrium is no minimum of this energy
      if (.not. allocated(states(i)%flow)) cycle
      errors(i)%energy = no_comparison()
      errors(i)%energy_rid = errors(i)%energy
      call compare_flow(answers(i), states(i), errors(i))
    end do
    if (bodies%fields%is_there()) call measure_stresses(bodies, online, answers, states, fields, errors)
  end subroutine measure_errors

  !> Returns the comparison of what is not there.
  pure type(comparison_t) function no_comparison()

    no_comparison = comparison_t(ieee_value(1.0_rk, ieee_quiet_nan), 0.0_rk)
  end function no_comparison

  !> Compares what there is only where materials flow. Does nothing where the answer or the full order has no solution. Local.
  pure subroutine compare_flow(answer, state, errors)
    type(answer_t), intent(in) :: answer
    type(contact_state_t), intent(in) :: state
    type(point_errors_t), intent(inout) :: errors

    if (answer%reason <= 0 .or. .not. allocated(state%flow%plastic)) return
    errors%raw_forces = comparison_t(norm2(answer%raw_multipliers - state%multipliers), norm2(state%multipliers))
    errors%correction = comparison_t(norm2(answer%raw_multipliers - answer%multipliers), norm2(answer%multipliers))
    errors%plastic_strain = no_comparison()
    errors%creep_strain = no_comparison()
    if (allocated(answer%plastic)) errors%plastic_strain = compare_strains(answer%plastic, state%flow%plastic)
    if (allocated(answer%creep)) errors%creep_strain = compare_strains(answer%creep, state%flow%creep)
  end subroutine compare_flow

  !> [-] Compares equivalent strains at all integration points: the largest difference, and the largest of the full order.
  pure type(comparison_t) function compare_strains(answered, exact) result(comparison)
    !> shape (7, n_points), the last number is the equivalent strain
    real(rk), intent(in) :: answered(:, :)
    real(rk), intent(in) :: exact(:, :)

    associate (n => size(exact, 1))
      comparison = comparison_t(maxval(abs(answered(n, :) - exact(n, :))), maxval(exact(n, :)))
    end associate
  end function compare_strains

  !> Sets the errors of von Mises stresses and contact pressures at each point. Local.
  subroutine measure_stresses(bodies, online, answers, states, fields, errors)
    type(measured_bodies_t), intent(in) :: bodies
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answers(:)
    type(contact_state_t), intent(in) :: states(:)
    !> [length] displacements of the answers, then of the full-order model, natural; shape (n_dofs, 2 * n_points)
    real(rk), intent(in) :: fields(:, :)
    type(point_errors_t), intent(inout) :: errors(:)
    type(rooms_t) :: rooms
    type(field_values_t) :: answered, exact
    real(rk) :: multipliers(online%model%n_multipliers)
    integer :: i, i_exact

    do i = 1, size(errors)
      i_exact = size(errors) + i
      call take_flow(bodies%fields, answers(i), states(i), answered, exact)
      call compare_von_mises(bodies%fields, bodies%field_theta(:, i), fields(:, i), fields(:, i_exact), answered, exact, &
        errors(i)%von_mises_largest, errors(i)%von_mises)
      call reconstruct_multipliers(online, answers(i), rooms, multipliers)
      errors(i)%pressure = compare_pressures(bodies%fields%rows, online%model%n_nodes, &
        multipliers(:bodies%fields%rows%n_rows), states(i)%normal_forces())
    end do
  end subroutine measure_stresses

  !> Takes the plastic strains and creep strains of both, where materials flow and both have a solution.
  pure subroutine take_flow(map, answer, state, answered, exact)
    type(field_map_t), intent(in) :: map
    type(answer_t), intent(in) :: answer
    type(contact_state_t), intent(in) :: state
    type(field_values_t), intent(inout) :: answered
    type(field_values_t), intent(inout) :: exact

    if (.not. allocated(state%flow) .or. answer%reason <= 0) return
    if (.not. allocated(state%flow%plastic)) return
    call exact%take_flow(map, state%flow%plastic, state%flow%creep)
    call answered%take_flow(map, answer%plastic, answer%creep)
  end subroutine take_flow

  !> Sets errors%field to |u_r - u|_K and |u|_K (energy norm, K of the system; u_r of the answer) at each point. Collective on
  !> system%comm.
  subroutine measure_fields(system, fields, errors, ierr)
    type(contact_system_t), intent(inout) :: system
    !> [length] displacements of the answers, then of the full-order model, natural; shape (n_dofs, 2 * n_points)
    real(rk), intent(in) :: fields(:, :)
    type(point_errors_t), intent(inout) :: errors(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: wrong(size(errors)), whole(size(errors))
    integer :: n

    n = size(errors)
    PetscCall(measure_strain_energies(system, fields(:, :n) - fields(:, n + 1:), wrong, ierr))
    PetscCall(measure_strain_energies(system, fields(:, n + 1:), whole, ierr))
    errors%field%difference = sqrt(2 * max(wrong, 0.0_rk))
    errors%field%size = sqrt(2 * max(whole, 0.0_rk))
  end subroutine measure_fields

  !> Computes the strain energy less the work of the loads, for each field, on the bodies and on the reduced domain of the cluster
  !> that the model chooses at the point. Collective on system%comm.
  subroutine measure_energies(system, bodies, online, answers, fields, energies, ierr)
    type(contact_system_t), intent(inout) :: system
    type(measured_bodies_t), intent(in) :: bodies
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answers(:)
    !> [length] displacements of the answers, then of the full-order model, natural; shape (n_dofs, 2 * n_points)
    real(rk), intent(in) :: fields(:, :)
    !> [force*length] on all bodies, on the reduced domain; columns as `fields`, shape (2, 2 * n_points)
    real(rk), intent(out) :: energies(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: load(system%map%n_dofs), strain_energies(size(fields, 2))
    integer :: i, k

    PetscCall(measure_strain_energies(system, fields, strain_energies, ierr))
    do i = 1, size(fields, 2)
      k = modulo(i - 1, size(answers)) + 1
      load = system%boundary%loads%forces(answers(k)%theta, size(load))
      energies(1, i) = strain_energies(i) - dot_product(load, fields(:, i)) + &
        bodies%whole%imposed%value(fields(:, i), bodies%strain_theta(:, k))
      associate (dofs => online%model%parts(answers(k)%cluster)%reduced%interior_dofs(), &
        domain => bodies%domains(answers(k)%cluster))
        energies(2, i) = domain%stiffness%strain_energy(fields(:, i)) - dot_product(load(dofs), fields(dofs, i)) + &
          domain%imposed%value(fields(:, i), bodies%strain_theta(:, k))
      end associate
    end do
  end subroutine measure_energies

  !> Computes 1/2 u' K u of each field, with the stiffness of the system. Collective on system%comm.
  subroutine measure_strain_energies(system, fields, energies, ierr)
    type(contact_system_t), intent(inout) :: system
    !> [length] natural, shape (n_dofs, n_fields)
    real(rk), intent(in) :: fields(:, :)
    !> [force*length] shape (n_fields)
    real(rk), intent(out) :: energies(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: local(:, :), forces(:, :)
    integer :: i

    local = fields(system%map%local_dofs, :)
    allocate (forces, mold=local)
    PetscCall(multiply_block(system%stiffness, local, forces, ierr))
    do i = 1, size(energies)
      energies(i) = dot_product(local(:, i), forces(:, i)) / 2
    end do
    PetscCall(sum_over_ranks(system%comm, energies, ierr))
  end subroutine measure_strain_energies
end module sig_error_norms
