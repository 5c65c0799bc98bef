! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Hands a solution from the rank that knows it to the others.
module sig_state_broadcast
  use mpi, only: MPI_Bcast, MPI_Comm_rank, MPI_DOUBLE_PRECISION, MPI_INTEGER
  use sig_contact_state, only: contact_state_t, flow_answer_t
  use sig_flowing_cells, only: flow_work_t
  use sig_kinds, only: rk
  use petsc
  implicit none(type, external)
  private
  public :: broadcast_state

contains

  !> Copies the state of the root to all other ranks of comm, which may have any state before. Collective on comm.
  subroutine broadcast_state(state, root, comm, ierr)
    type(contact_state_t), intent(inout) :: state
    !> rank in comm, 0-based
    integer, intent(in) :: root
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: counts(4)
    real(rk) :: numbers(7)

    counts = [state%n_iterations, state%n_linear_iterations, state%reason, state%n_solutions]
    PetscCallMPI(MPI_Bcast(counts, size(counts), MPI_INTEGER, root, comm, ierr))
    state%n_iterations = counts(1)
    state%n_linear_iterations = counts(2)
    state%reason = counts(3)
    state%n_solutions = counts(4)
    associate (r => state%residuals)
      numbers = [r%equilibrium, r%penetration, r%negative_multiplier, r%complementarity, r%force_balance, state%seconds, &
        state%energy]
      PetscCallMPI(MPI_Bcast(numbers, size(numbers), MPI_DOUBLE_PRECISION, root, comm, ierr))
      r%equilibrium = numbers(1)
      r%penetration = numbers(2)
      r%negative_multiplier = numbers(3)
      r%complementarity = numbers(4)
      r%force_balance = numbers(5)
    end associate
    state%seconds = numbers(6)
    state%energy = numbers(7)
    PetscCall(broadcast_values(state%displacement, root, comm, ierr))
    PetscCall(broadcast_values(state%multipliers, root, comm, ierr))
    PetscCall(broadcast_values(state%reactions, root, comm, ierr))
    PetscCall(broadcast_values(state%slip, root, comm, ierr))
    PetscCall(broadcast_values(state%origins, root, comm, ierr))
    PetscCall(broadcast_values(state%friction, root, comm, ierr))
    PetscCall(broadcast_values(state%drift, root, comm, ierr))
    PetscCall(broadcast_flags(state%is_active, root, comm, ierr))
    PetscCall(broadcast_flags(state%slips, root, comm, ierr))
    PetscCall(broadcast_flow(state%flow, root, comm, ierr))
  end subroutine broadcast_state

  !> Does the same for what flowing materials add. Collective.
  subroutine broadcast_flow(flow, root, comm, ierr)
    type(flow_answer_t), allocatable, intent(inout) :: flow
    !> rank in comm, 0-based
    integer, intent(in) :: root
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: numbers(:)
    integer :: rank

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    if (rank == root .and. allocated(flow)) then
      associate (w => flow%work)
        numbers = [real(flow%n_cuts, rk), flow%reached, flow%work_residual, w%loads, w%supports, w%energy, w%contact, w%gaps, &
          w%friction, w%imposed, w%inelastic, w%plastic, w%creep]
      end associate
    end if
    PetscCall(broadcast_values(numbers, root, comm, ierr))
    if (rank /= root .and. allocated(flow)) deallocate (flow)
    if (.not. allocated(numbers)) return
    if (rank /= root) allocate (flow)
    flow%n_cuts = nint(numbers(1))
    flow%reached = numbers(2)
    flow%work_residual = numbers(3)
    flow%work = flow_work_t(numbers(4), numbers(5), numbers(6), numbers(7), numbers(8), numbers(9), numbers(10), numbers(11), &
      numbers(12), numbers(13))
    PetscCall(broadcast_strains(flow%plastic, root, comm, ierr))
    PetscCall(broadcast_strains(flow%creep, root, comm, ierr))
    PetscCall(broadcast_values(flow%yielding, root, comm, ierr))
    PetscCall(broadcast_values(flow%residuals, root, comm, ierr))
  end subroutine broadcast_flow

  !> Does the same as broadcast_values for columns of seven values. Collective.
  subroutine broadcast_strains(strains, root, comm, ierr)
    real(rk), allocatable, intent(inout) :: strains(:, :)
    !> rank in comm, 0-based
    integer, intent(in) :: root
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: values(:)

    if (allocated(strains)) then
      values = reshape(strains, [size(strains)])
      deallocate (strains)
    end if
    PetscCall(broadcast_values(values, root, comm, ierr))
    if (allocated(values)) strains = reshape(values, [7, size(values) / 7])
  end subroutine broadcast_strains

  !> Does the same as broadcast_values. Collective.
  subroutine broadcast_flags(flags, root, comm, ierr)
    logical, allocatable, intent(inout) :: flags(:)
    integer, intent(in) :: root
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: values(:)

    if (allocated(flags)) then
      values = merge(1.0_rk, 0.0_rk, flags)
      deallocate (flags)
    end if
    PetscCall(broadcast_values(values, root, comm, ierr))
    if (allocated(values)) flags = values > 0
  end subroutine broadcast_flags

  !> Copies an array of the root to all other ranks. If the root has no array, the others have none afterwards. Collective.
  subroutine broadcast_values(values, root, comm, ierr)
    real(rk), allocatable, intent(inout) :: values(:)
    integer, intent(in) :: root
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: n, rank

    PetscCallMPI(MPI_Comm_rank(comm, rank, ierr))
    n = -1
    if (allocated(values)) n = size(values)
    PetscCallMPI(MPI_Bcast(n, 1, MPI_INTEGER, root, comm, ierr))
    if (rank /= root .and. allocated(values)) deallocate (values)
    if (n < 0) return
    if (rank /= root) allocate (values(n))
    PetscCallMPI(MPI_Bcast(values, n, MPI_DOUBLE_PRECISION, root, comm, ierr))
  end subroutine broadcast_values
end module sig_state_broadcast
