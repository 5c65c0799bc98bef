! SPDX-License-Identifier: BSD-3-Clause
!> What the reconstruction of multipliers outside the reduced integration domain is made of.
module sig_training_duals
  use sig_contact_operator, only: contact_operator_t
  use sig_kinds, only: rk
  use sig_model, only: reduced_model_t
  use sig_snapshot_store, only: snapshot_set_t
  implicit none(type, external)
  private
  public :: keep_dual_snapshots

contains

  !> Multipliers of the snapshots, and the normal displacements of snapshots, basis and lifting. Requires: the basis.
  subroutine keep_dual_snapshots(operator, snapshots, cluster)
    type(contact_operator_t), intent(in) :: operator
    type(snapshot_set_t), intent(in) :: snapshots
    type(reduced_model_t), intent(inout) :: cluster

    cluster%dual_snapshots = snapshots%multipliers
    cluster%contact_displacement_snapshots = normal_displacements(operator, snapshots%displacement)
    cluster%contact_value_basis = normal_displacements(operator, cluster%basis)
    cluster%contact_value_lifting = normal_displacements(operator, cluster%lifting)
  end subroutine keep_dual_snapshots

  !> Displacement along n of the first nodes, then of the second nodes; 0 for obstacles.
  pure function normal_displacements(operator, fields) result(values)
    type(contact_operator_t), intent(in) :: operator
    !> [length] shape (n_dofs, n_fields)
    real(rk), intent(in) :: fields(:, :)
    !> [length] shape (2 * n_rows, n_fields)
    real(rk) :: values(2 * operator%n_rows, size(fields, 2))
    integer :: k, n

    n = operator%n_dim
    values = 0
    do k = 1, operator%n_rows
      associate (dofs => operator%dofs(:, k), normal => operator%coefficients(:n, k))
        values(k, :) = matmul(normal, fields(dofs(:n), :))
        if (operator%second_node(k) > 0) values(operator%n_rows + k, :) = matmul(normal, fields(dofs(n + 1:), :))
      end associate
    end do
  end function normal_displacements
end module sig_training_duals
