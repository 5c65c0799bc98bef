! SPDX-License-Identifier: BSD-3-Clause
!> From an answer back to the mesh: displacement of every dof, multipliers of every pair.
module sig_reconstruction
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_model, only: model_t
  use sig_multiplier_fit, only: multiplier_fit_workspace_t
  use sig_online_model, only: online_model_t
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

  !> Those of the answer on the reduced integration domain, the fit elsewhere; all of them where the full-order operator answered.
  subroutine reconstruct_multipliers(online, answer, workspace, multipliers)
    !> prepared
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer
    type(multiplier_fit_workspace_t), intent(inout) :: workspace
    !> [force] >= 0, shape (n_multipliers)
    real(rk), intent(out) :: multipliers(:)

    if (answer%method == query_condensed) then
      multipliers = answer%multipliers
    else
      call online%fits(answer%cluster)%evaluate(online%model%clusters(answer%cluster), answer%theta, answer%coordinates, &
        answer%multipliers_rid, workspace, multipliers)
    end if
  end subroutine reconstruct_multipliers
end module sig_reconstruction
