! SPDX-License-Identifier: BSD-3-Clause
!> The errors (17) and (18) of a reduced answer, compared with the full-order solution at the same point.
module sig_answer_errors
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
  use sig_kinds, only: rk
  use sig_rooms, only: rooms_t
  use sig_online_model, only: online_model_t
  use sig_answer, only: answer_t
  use sig_reconstruction, only: has_displacements, reconstruct_displacement, reconstruct_multipliers
  implicit none(type, external)
  private
  public :: comparison_t, compare_displacements, compare_forces, displacement_squares, negligible_share, rid_forces, all_forces

  !> [-] a norm below this share of the largest one at all compared points is rounding: at such a point (a load of 0, say) errors
  !> are relative to this share of the largest norm
  real(rk), parameter :: negligible_share = sqrt(epsilon(1.0_rk))

  !> which contact forces are compared: those of the reduced domain of the cluster that the model chooses, or all
  integer, parameter :: rid_forces = 1, all_forces = 2

  !> A difference and the full-order size to which it is related, both at least 0 and in the same unit.
  type :: comparison_t
    real(rk) :: difference = 0
    real(rk) :: size = 0
  contains
    procedure :: relative
  end type comparison_t

contains

  !> [-] Returns difference / size; if the size is below `floor`, difference / floor. 0/0 is NaN (there is nothing to compare). With
  !> a size of 0, a difference above `floor` gives infinity.
  elemental real(rk) function relative(self, floor)
    class(comparison_t), intent(in) :: self
    !> size that is negligible, in the unit of the comparison, at least 0
    real(rk), intent(in) :: floor

    if (self%size <= 0 .and. self%difference <= 0) then
      relative = ieee_value(relative, ieee_quiet_nan)
    else if (self%size <= 0 .and. self%difference > floor) then
      relative = ieee_value(relative, ieee_positive_inf)
    else
      relative = self%difference / max(self%size, floor)
    end if
  end function relative

  !> [length^2] Returns the two squared norms of which (17) is made, over some dofs: of the answer's difference from the full-order
  !> displacement, and of this displacement. Dofs for which the model answers no displacement are left out.
  function displacement_squares(online, answer, first_dof, displacement) result(squares)
    !> prepared
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer
    !> first of the dofs, 1-based
    integer, intent(in) :: first_dof
    !> [length] full-order displacement of the dofs from first_dof on
    real(rk), intent(in) :: displacement(:)
    real(rk) :: squares(2)
    real(rk), allocatable :: reduced(:)
    logical :: is_known(online%model%n_dofs)

    call reconstruct_displacement(online%model, answer, reduced)
    is_known = has_displacements(online%model, answer)
    associate (first => first_dof, last => first_dof + size(displacement) - 1)
      squares(1) = norm2(pack(reduced(first:last) - displacement, is_known(first:last)))**2
      squares(2) = norm2(pack(displacement, is_known(first:last)))**2
    end associate
  end function displacement_squares

  !> [length] Compares the displacements for (17), on the dofs for which the model answers displacements.
  pure type(comparison_t) function compare_displacements(online, answer, reduced, displacement) result(comparison)
    !> prepared
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer
    !> [length] displacement of the answer and of the full-order model, shape (n_dofs)
    real(rk), intent(in) :: reduced(:)
    real(rk), intent(in) :: displacement(:)

    associate (is_known => has_displacements(online%model, answer))
      comparison%difference = norm2(pack(reduced - displacement, is_known))
      comparison%size = norm2(pack(displacement, is_known))
    end associate
  end function compare_displacements

  !> [force] Compares the contact forces for (18). For all_forces, those outside of the reduced domain are reconstructed first.
  type(comparison_t) function compare_forces(which, online, answer, multipliers) result(comparison)
    !> rid_forces or all_forces
    integer, intent(in) :: which
    !> prepared
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer
    !> [force] full-order contact forces, shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)
    type(rooms_t) :: rooms
    integer, allocatable :: rows(:)
    real(rk) :: reconstructed(size(multipliers))

    if (which == rid_forces) then
      ! gfortran 14 takes no subscripts by a bound function in an associate
      rows = online%model%parts(answer%cluster)%reduced%contact_rows()
      comparison%difference = norm2(answer%multipliers_rid - multipliers(rows))
      comparison%size = norm2(multipliers(rows))
    else
      call reconstruct_multipliers(online, answer, rooms, reconstructed)
      comparison%difference = norm2(reconstructed - multipliers)
      comparison%size = norm2(multipliers)
    end if
  end function compare_forces
end module sig_answer_errors
