! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Errors (17)-(19) of a reduced answer against the full-order one.
module sig_error_norms
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
  use sig_cell_stiffness, only: strain_energy
  use sig_contact_state, only: contact_state_t
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_petsc_support, only: sum_over_ranks
  use sig_problem, only: problem_t
  use sig_query, only: answer_t
  use sig_reconstruction, only: reconstruct_displacement, reconstruct_multipliers
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

  !> Collective on comm, for which the problem was loaded.
  subroutine measure_errors(problem, comm, rank, model, answer, state, errors, ierr)
    type(problem_t), intent(in) :: problem
    MPI_Comm, intent(in) :: comm
    !> of this process in comm, 0-based
    integer, intent(in) :: rank
    type(model_t), intent(in) :: model
    type(answer_t), intent(in) :: answer
    type(contact_state_t), intent(in) :: state
    type(point_errors_t), intent(out) :: errors
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: displacement(:), multipliers(:)
    real(rk) :: energies(2), energies_rid(2), load(size(state%displacement))
    logical :: is_inside(size(state%displacement))
    integer, allocatable :: own_cells(:)
    integer :: i

    call reconstruct_displacement(model, answer, displacement)
    call reconstruct_multipliers(model, answer, multipliers)
    load = problem%boundary%loads%forces(answer%theta, size(load))
    errors%displacement = relative(norm2(displacement - state%displacement), norm2(state%displacement))
    errors%multipliers_all = relative(norm2(multipliers - state%multipliers), norm2(state%multipliers))
    associate (rows => model%clusters(answer%cluster)%contact_rows, cells => model%clusters(answer%cluster)%cells)
      errors%multipliers_rid = relative(norm2(answer%multipliers_rid - state%multipliers(rows)), norm2(state%multipliers(rows)))
      is_inside = .false.
      is_inside(model%clusters(answer%cluster)%interior_dofs) = .true.
      energies_rid = [strain_energy(problem%mesh, problem%body, displacement, cells) - sum(load * displacement, is_inside), &
        strain_energy(problem%mesh, problem%body, state%displacement, cells) - sum(load * state%displacement, is_inside)]
    end associate
    own_cells = pack([(i, i=1, problem%mesh%n_cells)], problem%mesh%cell_owner == rank)
    energies = [strain_energy(problem%mesh, problem%body, displacement, own_cells), &
      strain_energy(problem%mesh, problem%body, state%displacement, own_cells)]
    PetscCall(sum_over_ranks(comm, energies, ierr))
    energies = energies - [dot_product(load, displacement), dot_product(load, state%displacement)]
    errors%energy = abs(energies(1) - energies(2))
    errors%energy_rid = abs(energies_rid(1) - energies_rid(2))
    errors%energy_relative = relative(errors%energy, abs(energies(2)))
    errors%energy_rid_relative = relative(errors%energy_rid, abs(energies_rid(2)))
  end subroutine measure_errors

  !> part / whole; 0/0 is no number (there is nothing to compare), x/0 is infinite.
  real(rk) function relative(part, whole)
    real(rk), intent(in) :: part
    real(rk), intent(in) :: whole

    if (whole > 0) then
      relative = part / whole
    else if (part > 0) then
      relative = ieee_value(relative, ieee_positive_inf)
    else
      relative = ieee_value(relative, ieee_quiet_nan)
    end if
  end function relative
end module sig_error_norms
