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
  public :: displacement_error, displacement_squares, forces_error, relative, rid_error, reconstruction_error

contains

  !> [-] Returns the error of the contact forces that has this name: e_lambda_all, or else e_lambda_rid.
  real(rk) function forces_error(name, online, answer, multipliers) result(error)
    character(*), intent(in) :: name
    !> prepared
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer
    !> [force] full-order contact forces, shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)

    if (name == 'e_lambda_all') then
      error = reconstruction_error(online, answer, multipliers)
    else
      error = rid_error(online, answer, multipliers)
    end if
  end function forces_error

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

  !> [-] Returns (17) on the dofs for which the model answers displacements; NaN if there are no such dofs or if both displacements
  !> are 0 there, infinite if only the full-order one is.
  pure real(rk) function displacement_error(online, answer, reduced, displacement) result(error)
    !> prepared
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer
    !> [length] displacement of the answer and of the full-order model, shape (n_dofs)
    real(rk), intent(in) :: reduced(:)
    real(rk), intent(in) :: displacement(:)

    associate (is_known => has_displacements(online%model, answer))
      error = relative(norm2(pack(reduced - displacement, is_known)), norm2(pack(displacement, is_known)))
    end associate
  end function displacement_error

  !> [-] Returns (18) on the reduced domain of the cluster that the model chooses; NaN if nothing touches there in either model,
  !> infinite if only the answer has contact forces there.
  pure real(rk) function rid_error(online, answer, multipliers) result(error)
    !> prepared
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer
    !> [force] full-order contact forces, shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)
    integer, allocatable :: rows(:)

    ! gfortran 14 takes no subscripts by a bound function in an associate
    rows = online%model%parts(answer%cluster)%reduced%contact_rows()
    error = relative(norm2(answer%multipliers_rid - multipliers(rows)), norm2(multipliers(rows)))
  end function rid_error

  !> [-] Returns (18) on all contacts, after the reconstruction of the forces outside of the reduced domain; NaN if nothing touches
  !> in either model, infinite if only the answer has contact forces.
  real(rk) function reconstruction_error(online, answer, multipliers) result(error)
    !> prepared
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer
    !> [force] full-order contact forces, shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)
    type(rooms_t) :: rooms
    real(rk) :: reconstructed(size(multipliers))

    call reconstruct_multipliers(online, answer, rooms, reconstructed)
    error = relative(norm2(reconstructed - multipliers), norm2(multipliers))
  end function reconstruction_error

  !> Returns part / whole; 0/0 is NaN (there is nothing to compare), x/0 is infinite. Neither may be negative.
  pure real(rk) function relative(part, whole)
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
end module sig_answer_errors
