! SPDX-License-Identifier: BSD-3-Clause
!> What the reconstruction of multipliers outside the reduced integration domain is made of.
module sig_training_duals
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  use sig_hhr_data, only: hhr_data_t
  use sig_linear_algebra, only: unit_vector
  use sig_problem, only: problem_t
  use sig_snapshot_store, only: snapshot_set_t
  implicit none(type, external)
  private
  public :: keep_dual_snapshots

contains

  !> Multipliers of the snapshots, the normal displacements of snapshots, basis and lifting, and what is known without them: gaps
  !> and resultants. Requires: the basis.
  subroutine keep_dual_snapshots(problem, snapshots, cluster)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(hhr_data_t), intent(inout) :: cluster

    associate (rows => problem%rows)
      call keep_contact_values(rows, snapshots, cluster)
      cluster%contact_gap = rows%gap
    end associate
    call keep_resultants(problem, cluster)
  end subroutine keep_dual_snapshots

  !> Z'F = Z'B' lambda of the rigid motions Z that no prescribed displacement holds.
  subroutine keep_resultants(problem, cluster)
    type(problem_t), intent(in) :: problem
    type(hhr_data_t), intent(inout) :: cluster
    integer :: n_dofs, n_terms, t

    n_dofs = problem%mesh%n_dim * problem%mesh%n_nodes
    n_terms = size(problem%rows%gap, 2)
    associate (motions => problem%motions)
      cluster%motion_closing = motions%closing
      allocate (cluster%motion_load(n_terms, motions%n_free))
      if (motions%n_free == 0) return
      do t = 1, n_terms
        cluster%motion_load(t, :) = motions%work(problem%boundary%loads%forces(unit_vector(n_terms, t), n_dofs))
      end do
    end associate
  end subroutine keep_resultants

  subroutine keep_contact_values(rows, snapshots, cluster)
    type(contact_rows_t), intent(in) :: rows
    type(snapshot_set_t), intent(in) :: snapshots
    type(hhr_data_t), intent(inout) :: cluster

    cluster%dual_snapshots = snapshots%multipliers
    cluster%contact_displacement_snapshots = normal_displacements(rows, snapshots%displacement)
    cluster%contact_value_basis = normal_displacements(rows, cluster%basis)
    cluster%contact_value_lifting = normal_displacements(rows, cluster%lifting)
  end subroutine keep_contact_values

  !> Displacement along n that each row sees of the first side, then of the second side; 0 for obstacles.
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
