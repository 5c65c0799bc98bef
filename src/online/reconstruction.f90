! SPDX-License-Identifier: BSD-3-Clause
!> Computes from an answer the displacement of every dof and the multipliers of every contact.
module sig_reconstruction
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_t
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_online_model, only: online_model_t
  use sig_reduced, only: displacement_none
  use sig_rooms, only: rooms_t
  implicit none(type, external)
  private
  public :: has_displacements, reconstruct_displacement, fill_displacement, displacement_of_dof, reconstruct_multipliers

contains

  !> Allocates an array and computes the displacement of an answer in it. The displacement is that of the part
  !> answer%displacement_part, and NaN for dofs of which this part has none. It means nothing if the answer has no solution.
  subroutine reconstruct_displacement(model, answer, displacement)
    type(model_t), intent(in) :: model
    type(answer_t), intent(in) :: answer
    !> [length] shape (n_dofs)
    real(rk), allocatable, intent(out) :: displacement(:)

    allocate (displacement(model%n_dofs))
    call fill_displacement(model, answer, displacement)
  end subroutine reconstruct_displacement

  !> Returns for each dof whether the part that gives the displacement of an answer (answer%displacement_part) has a displacement of
  !> this dof, shape (n_dofs).
  pure function has_displacements(model, answer) result(is_known)
    type(model_t), intent(in) :: model
    type(answer_t), intent(in) :: answer
    logical, allocatable :: is_known(:)
    integer :: i

    associate (part => model%parts(answer%displacement_part)%reduced)
      is_known = [(part%has_displacement() .and. part%displacement_source(i) /= displacement_none, i=1, model%n_dofs)]
    end associate
  end function has_displacements

  !> Does the same as reconstruct_displacement, in an array of the caller.
  subroutine fill_displacement(model, answer, displacement)
    type(model_t), intent(in) :: model
    type(answer_t), intent(in) :: answer
    !> [length] shape (n_dofs)
    real(rk), contiguous, intent(inout) :: displacement(:)

    associate (part => model%parts(answer%displacement_part)%reduced)
      if (part%has_displacement()) then
        call part%fill_displacement(answer, displacement)
      else
        displacement = ieee_value(1.0_rk, ieee_quiet_nan)
      end if
    end associate
  end subroutine fill_displacement

  !> Returns the displacement [length] of one dof, without a temporary array: one element of what reconstruct_displacement computes.
  pure real(rk) function displacement_of_dof(model, answer, dof) result(displacement)
    type(model_t), intent(in) :: model
    type(answer_t), intent(in) :: answer
    !> 1-based
    integer, intent(in) :: dof

    associate (part => model%parts(answer%displacement_part)%reduced)
      if (part%has_displacement()) then
        displacement = part%displacement_of_dof(answer, dof)
      else
        displacement = ieee_value(1.0_rk, ieee_quiet_nan)
      end if
    end associate
  end function displacement_of_dof

  !> Computes the forces of all contacts from an answer; they are zero if the answer has no solution.
  subroutine reconstruct_multipliers(online, answer, rooms, multipliers)
    !> the model, after prepare
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer
    !> work arrays of this thread; those of the part are made if they are missing
    type(rooms_t), intent(inout) :: rooms
    !> [force] >= 0, shape (n_multipliers)
    real(rk), intent(out) :: multipliers(:)

    if (answer%reason < 0) then
      multipliers = 0
    else if (answer%is_whole) then
      multipliers = answer%multipliers
    else
      call rooms%enter(online%model, answer%part)
      call online%model%parts(answer%part)%reduced%fill_multipliers(answer, rooms%of_part(answer%part)%room, multipliers)
    end if
  end subroutine reconstruct_multipliers
end module sig_reconstruction
