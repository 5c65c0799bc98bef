! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Keeps the data from which a query reconstructs the contact forces outside of the reduced integration domain.
module sig_training_duals
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  use sig_hhr_data, only: hhr_data_t
  use sig_linear_algebra, only: unit_vector
  use sig_petsc_support, only: sum_over_ranks
  use sig_problem, only: problem_t
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: keep_dual_snapshots, snapshot_contact_values

contains

  !> Fills in `cluster` the contact forces of the snapshots, the normal displacements of basis and lifting at the contacts, the
  !> gaps, and the data of the force balance. Requires: cluster%basis and cluster%lifting.
  subroutine keep_dual_snapshots(problem, snapshots, cluster)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(hhr_data_t), intent(inout) :: cluster

    cluster%dual_snapshots = snapshots%forces()
    cluster%contact_value_basis = normal_displacements(problem%rows, cluster%basis)
    cluster%contact_value_lifting = normal_displacements(problem%rows, cluster%lifting)
    cluster%contact_gap = problem%rows%gap
    call keep_resultants(problem, cluster)
  end subroutine keep_dual_snapshots

  !> Sets cluster%motion_load (Z'F per term) and cluster%motion_closing of the force balance Z'F = Z'B' lambda for the rigid motions
  !> Z that no prescribed displacement holds.
  subroutine keep_resultants(problem, cluster)
    type(problem_t), intent(in) :: problem
    type(hhr_data_t), intent(inout) :: cluster
    integer :: n_terms, t

    n_terms = size(problem%rows%gap, 2)
    associate (motions => problem%motions)
      cluster%motion_closing = motions%closing
      allocate (cluster%motion_load(n_terms, motions%n_free))
      if (motions%n_free == 0) return
      do t = 1, n_terms
        cluster%motion_load(t, :) = motions%work(problem%boundary%forces(unit_vector(n_terms, t)))
      end do
    end associate
  end subroutine keep_resultants

  !> Computes the normal displacements of both sides of each contact row for all snapshots, the same on every rank. Collective on
  !> comm, over which the dofs of the snapshots are spread.
  subroutine snapshot_contact_values(rows, snapshots, comm, values, ierr)
    type(contact_rows_t), intent(in) :: rows
    type(training_set_t), intent(in) :: snapshots
    MPI_Comm, intent(in) :: comm
    !> [length] first sides, then second sides (0 for obstacles), shape (2 * n_rows, n_snapshots)
    real(rk), allocatable, intent(out) :: values(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: i, k

    allocate (values(2 * rows%n_rows, snapshots%n_snapshots()))
    do i = 1, size(values, 2)
      associate (own => snapshots%displacement(i)%values, first_dof => snapshots%first_dof)
        do k = 1, rows%n_rows
          associate (first => rows%offsets(k) + 1, split => rows%splits(k), last => rows%offsets(k + 1))
            values(k, i) = own_sum(rows%coefficients(first:split), rows%dofs(first:split), own, first_dof)
            values(rows%n_rows + k, i) = -own_sum(rows%coefficients(split + 1:last), rows%dofs(split + 1:last), own, first_dof)
          end associate
        end do
      end associate
    end do
    PetscCall(sum_over_ranks(comm, values, ierr))
  end subroutine snapshot_contact_values

  !> Returns the sum of c_j u_j over the dofs of this rank.
  pure real(rk) function own_sum(coefficients, dofs, own, first_dof)
    !> [-] c, one per dof
    real(rk), intent(in) :: coefficients(:)
    !> natural (order of the mesh file)
    integer, intent(in) :: dofs(:)
    !> [length] of the dofs from first_dof on
    real(rk), intent(in) :: own(:)
    integer, intent(in) :: first_dof
    integer :: j

    own_sum = 0
    do j = 1, size(dofs)
      if (dofs(j) >= first_dof .and. dofs(j) < first_dof + size(own)) &
        own_sum = own_sum + coefficients(j) * own(dofs(j) - first_dof + 1)
    end do
  end function own_sum

  !> Returns the normal displacements of both sides of each contact row: row k of the result for the first side, row n_rows + k for
  !> the second side. The latter is 0 for obstacles. Their difference is B u.
  pure function normal_displacements(rows, fields) result(values)
    type(contact_rows_t), intent(in) :: rows
    !> [length] shape (n_dofs, n_fields)
    real(rk), intent(in) :: fields(:, :)
    !> [length] shape (2 * n_rows, n_fields)
    real(rk) :: values(2 * rows%n_rows, size(fields, 2))
    integer :: k

    values = 0
    do k = 1, rows%n_rows
      associate (first => rows%offsets(k) + 1, split => rows%splits(k), last => rows%offsets(k + 1))
        values(k, :) = matmul(rows%coefficients(first:split), fields(rows%dofs(first:split), :))
        values(rows%n_rows + k, :) = -matmul(rows%coefficients(split + 1:last), fields(rows%dofs(split + 1:last), :))
      end associate
    end do
  end function normal_displacements
end module sig_training_duals
