! SPDX-License-Identifier: BSD-3-Clause
!> Displacements of a condensed model: u = G theta - H z, exactly at some dofs, by sig_contact_field at others, or not at all.
module sig_condensed_displacement
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_condensed_data, only: condensed_data_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_shape_checks, only: place_in_ascending
  implicit none(type, external)
  private
  public :: condensed_anchor_motion, condensed_displacement_of_dof, fill_condensed_displacement

contains

  !> Computes the displacement of all dofs; it is NaN for dofs of which the model has none.
  subroutine fill_condensed_displacement(data, theta, unknowns, displacement)
    class(condensed_data_t), intent(in) :: data
    !> values of the model's terms, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z (unknowns of answer_t), shape (n_multipliers)
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [length] shape (n_dofs)
    real(rk), contiguous, intent(inout) :: displacement(:)
    real(rk) :: exact(size(data%exact_dofs))

    associate (leading => theta(:size(data%free_response, 2)))
      if (data%has_modes()) then
        call multiply(1.0_rk, data%free_response, leading, 0.0_rk, displacement)
        exact = displacement(data%exact_dofs)
        call data%field%subtract_from(data%anchors, unknowns, displacement)
      else
        displacement = ieee_value(1.0_rk, ieee_quiet_nan)
        call multiply(1.0_rk, data%free_response, leading, 0.0_rk, exact)
      end if
    end associate
    call multiply(-1.0_rk, data%contact_response, unknowns, 1.0_rk, exact)
    displacement(data%exact_dofs) = exact
  end subroutine fill_condensed_displacement

  !> Returns the displacement [length] of one dof; NaN if the model has none of this dof. The result is linear in theta and
  !> unknowns, so that their derivatives give its derivative.
  pure real(rk) function condensed_displacement_of_dof(data, theta, unknowns, dof) result(displacement)
    class(condensed_data_t), intent(in) :: data
    !> values of the model's terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [force] z (unknowns of answer_t), shape (n_multipliers)
    real(rk), intent(in) :: unknowns(:)
    !> 1-based
    integer, intent(in) :: dof
    integer :: i_exact

    i_exact = place_in_ascending(data%exact_dofs, dof)
    associate (leading => theta(:size(data%free_response, 2)), has_modes => data%has_modes())
      if (i_exact == 0 .and. .not. has_modes) then
        displacement = ieee_value(1.0_rk, ieee_quiet_nan)
        return
      end if
      displacement = dot_product(data%free_response(merge(dof, i_exact, has_modes), :), leading)
    end associate
    if (i_exact > 0) then
      displacement = displacement - dot_product(data%contact_response(i_exact, :), unknowns)
    else
      displacement = displacement - data%field%dof_value(data%anchors, unknowns, dof)
    end if
  end function condensed_displacement_of_dof

  !> Returns the displacement [-] of one dof, with the sign changed, as each anchor opens by 1; zero if the model has none of this
  !> dof.
  pure function condensed_anchor_motion(data, dof) result(motion)
    class(condensed_data_t), intent(in) :: data
    !> 1-based
    integer, intent(in) :: dof
    !> shape (n_anchors)
    real(rk) :: motion(size(data%anchors))
    integer :: i

    i = place_in_ascending(data%exact_dofs, dof)
    motion = 0
    if (i > 0) then
      motion = data%contact_response(i, data%anchors) / data%scale
    else if (data%has_modes()) then
      motion = data%field%motion_of_dof(dof) / data%scale
    end if
  end function condensed_anchor_motion
end module sig_condensed_displacement
