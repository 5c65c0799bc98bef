! SPDX-License-Identifier: BSD-3-Clause
!> From an answer back to the mesh: displacement of every dof, multipliers of every pair.
module sig_reconstruction
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_model, only: model_t, reconstruct_with_displacements, reduced_model_t
  use sig_nnls, only: solve_nnls
  use sig_query, only: answer_t, query_condensed
  implicit none(type, external)
  private
  public :: reconstruct_displacement, fill_displacement, displacement_of_dof, reconstruct_multipliers

contains

  !> u = lifting theta + basis gamma, with the terms that prescribe displacements; u = G theta - H lambda where the full-order
  !> operator answered and the model holds G and H.
  subroutine reconstruct_displacement(model, answer, displacement)
    type(model_t), intent(in) :: model
    type(answer_t), intent(in) :: answer
    !> [length] shape (n_dofs)
    real(rk), allocatable, intent(out) :: displacement(:)

    allocate (displacement(model%n_dofs))
    call fill_displacement(model, answer, displacement)
  end subroutine reconstruct_displacement

  !> The same into an array of the caller.
  subroutine fill_displacement(model, answer, displacement)
    type(model_t), intent(in) :: model
    type(answer_t), intent(in) :: answer
    !> [length] shape (n_dofs)
    real(rk), contiguous, intent(inout) :: displacement(:)

    if (answer%method == query_condensed .and. model%full_order%has_displacement()) then
      call multiply(1.0_rk, model%full_order%free_response, answer%theta(:size(model%full_order%free_response, 2)), &
        0.0_rk, displacement)
      call multiply(-1.0_rk, model%full_order%contact_response, answer%multipliers, 1.0_rk, displacement)
      return
    end if
    associate (cluster => model%clusters(answer%cluster))
      call multiply(1.0_rk, cluster%lifting, answer%theta(:size(cluster%lifting, 2)), 0.0_rk, displacement)
      call multiply(1.0_rk, cluster%basis, answer%coordinates, 1.0_rk, displacement)
    end associate
  end subroutine fill_displacement

  !> [length] one component of the same; without a temporary array.
  pure real(rk) function displacement_of_dof(model, answer, dof) result(displacement)
    type(model_t), intent(in) :: model
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof

    if (answer%method == query_condensed .and. model%full_order%has_displacement()) then
      displacement = dot_product(model%full_order%free_response(dof, :), &
        answer%theta(:size(model%full_order%free_response, 2))) &
        - dot_product(model%full_order%contact_response(dof, :), answer%multipliers)
      return
    end if
    associate (cluster => model%clusters(answer%cluster))
      displacement = dot_product(cluster%lifting(dof, :), answer%theta(:size(cluster%lifting, 2))) &
        + dot_product(cluster%basis(dof, :), answer%coordinates)
    end associate
  end function displacement_of_dof

  !> Values of the answer on the reduced integration domain; elsewhere the non-negative combination of the dual snapshots that is
  !> nearest to what the answer knows.
  !>
  !> Known are the multipliers of the domain and, unless model%reconstruction leaves them out, the normal displacements of all the
  !> contact nodes; each of the two blocks is divided by the size of its snapshots, so that units do not matter.
  subroutine reconstruct_multipliers(model, answer, multipliers)
    type(model_t), intent(in) :: model
    type(answer_t), intent(in) :: answer
    !> [force] >= 0, shape (n_multipliers)
    real(rk), allocatable, intent(out) :: multipliers(:)
    real(rk), allocatable :: coefficients(:), known(:), snapshots(:, :)
    real(rk) :: residual_norm

    if (answer%method == query_condensed) then
      multipliers = answer%multipliers
      return
    end if
    allocate (multipliers(model%n_multipliers), source=0.0_rk)
    associate (cluster => model%clusters(answer%cluster))
      if (any(answer%multipliers_rid > 0) .and. cluster%n_rows < model%n_multipliers) then
        call gather_known(cluster, answer, model%reconstruction == reconstruct_with_displacements, snapshots, known)
        allocate (coefficients(size(snapshots, 2)))
        call solve_nnls(snapshots, known, coefficients, residual_norm)
        multipliers = matmul(cluster%dual_snapshots, coefficients)
      end if
      multipliers(cluster%contact_rows) = answer%multipliers_rid
    end associate
  end subroutine reconstruct_multipliers

  !> Rows of the least squares problem.
  subroutine gather_known(cluster, answer, has_displacements, snapshots, known)
    type(reduced_model_t), intent(in) :: cluster
    type(answer_t), intent(in) :: answer
    logical, intent(in) :: has_displacements
    !> shape (n_known, n_snapshots)
    real(rk), allocatable, intent(out) :: snapshots(:, :)
    !> shape (n_known)
    real(rk), allocatable, intent(out) :: known(:)
    real(rk), allocatable :: displacements(:)
    real(rk) :: scale
    integer :: n_known, n_values

    n_values = merge(size(cluster%contact_displacement_snapshots, 1), 0, has_displacements)
    n_known = cluster%n_rows + n_values
    allocate (snapshots(n_known, size(cluster%dual_snapshots, 2)), known(n_known))
    scale = inverse_size(cluster%dual_snapshots(cluster%contact_rows, :))
    snapshots(:cluster%n_rows, :) = scale * cluster%dual_snapshots(cluster%contact_rows, :)
    known(:cluster%n_rows) = scale * answer%multipliers_rid
    if (n_values == 0) return
    displacements = matmul(cluster%contact_value_basis, answer%coordinates) &
      + matmul(cluster%contact_value_lifting, answer%theta(:size(cluster%contact_value_lifting, 2)))
    scale = inverse_size(cluster%contact_displacement_snapshots)
    snapshots(cluster%n_rows + 1:, :) = scale * cluster%contact_displacement_snapshots
    known(cluster%n_rows + 1:) = scale * displacements
  end subroutine gather_known

  !> 1 / Frobenius norm; 1 for zeros.
  pure function inverse_size(block) result(scale)
    real(rk), intent(in) :: block(:, :)
    real(rk) :: scale

    scale = norm2(block)
    scale = merge(1 / max(scale, tiny(scale)), 1.0_rk, scale > 0)
  end function inverse_size
end module sig_reconstruction
