! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Errors (17)-(19) of a reduced answer against the full-order one.
module sig_error_norms
  use sig_answer_errors, only: displacement_error, reconstruction_error, relative, rid_error
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_domain_energy, only: domain_energy_t
  use sig_kinds, only: rk
  use sig_online_model, only: online_model_t
  use sig_query, only: answer_t
  use sig_reconstruction, only: reconstruct_displacement
  use petsc
  implicit none(type, external)
  private
  public :: point_errors_t, measure_errors

  type :: point_errors_t
    !> [-] (17)
    real(rk) :: displacement = 0
    !> [-] (18) on the reduced domain, and on all contacts after reconstruction; no number where nothing touches in either model
    real(rk) :: multipliers_rid = 0
    real(rk) :: multipliers_all = 0
    !> [force*length] (19) with the energy 1/2 u' K u - F' u, on the bodies and on the reduced domain (there F on the dofs of A)
    real(rk) :: energy = 0
    real(rk) :: energy_rid = 0
    !> [-] the same over the full-order energy
    real(rk) :: energy_relative = 0
    real(rk) :: energy_rid_relative = 0
  end type point_errors_t

contains

  !> Collective on the system's communicator.
  subroutine measure_errors(system, domain, online, answer, state, errors, ierr)
    type(contact_system_t), intent(inout) :: system
    !> cells of the answer's cluster
    type(domain_energy_t), intent(in) :: domain
    !> prepared
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer
    type(contact_state_t), intent(in) :: state
    type(point_errors_t), intent(out) :: errors
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: displacement(:)
    real(rk) :: energies(2), energies_full(2), load(size(state%displacement))

    call reconstruct_displacement(online%model, answer, displacement)
    errors%displacement = displacement_error(displacement, state%displacement)
    errors%multipliers_rid = rid_error(online, answer, state%multipliers)
    errors%multipliers_all = reconstruction_error(online, answer, state%multipliers)
    load = system%load(answer%theta)
    associate (cluster => online%model%clusters(answer%cluster))
      PetscCall(measure_energies(system, domain, cluster%interior_dofs, load, displacement, energies, ierr))
      PetscCall(measure_energies(system, domain, cluster%interior_dofs, load, state%displacement, energies_full, ierr))
    end associate
    errors%energy = abs(energies(1) - energies_full(1))
    errors%energy_rid = abs(energies(2) - energies_full(2))
    errors%energy_relative = relative(errors%energy, abs(energies_full(1)))
    errors%energy_rid_relative = relative(errors%energy_rid, abs(energies_full(2)))
  end subroutine measure_errors

  !> 1/2 u' K u - F' u on the bodies and on the reduced domain. Collective.
  subroutine measure_energies(system, domain, interior_dofs, load, displacement, energies, ierr)
    type(contact_system_t), intent(inout) :: system
    type(domain_energy_t), intent(in) :: domain
    !> A
    integer, intent(in) :: interior_dofs(:)
    !> [force] natural, shape (n_dofs)
    real(rk), intent(in) :: load(:)
    real(rk), intent(in) :: displacement(:)
    real(rk), intent(out) :: energies(2)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: forces(size(displacement))

    PetscCall(system%apply_stiffness(displacement, forces, ierr))
    energies(1) = dot_product(displacement, forces) / 2 - dot_product(load, displacement)
    energies(2) = domain%strain_energy(displacement) - dot_product(load(interior_dofs), displacement(interior_dofs))
  end subroutine measure_energies
end module sig_error_norms
