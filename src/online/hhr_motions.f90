! SPDX-License-Identifier: BSD-3-Clause
!> Motions of bodies that no contact force of a hyper-reduced answer holds.
module sig_hhr_motions
  use sig_answer, only: answer_t
  use sig_free_motions, only: count_free_motions
  use sig_hhr_data, only: hhr_data_t
  use sig_hhr_room, only: hhr_room_t
  use sig_kinds, only: rk
  use sig_multiplier_fit, only: multiplier_fit_t
  implicit none(type, external)
  private
  public :: count_hhr_motions

contains

  !> Sets n_free_motions of an answer: by the forces of the domain or, if these do not hold all motions, by the forces of all
  !> contacts, which are then reconstructed. Requires: an answer of the part.
  subroutine count_hhr_motions(data, fit, room, answer)
    type(hhr_data_t), intent(in) :: data
    !> of the part, prepared
    class(multiplier_fit_t), intent(in) :: fit
    !> out: `fit` and `multipliers`, where forces are reconstructed
    type(hhr_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    if (size(data%motion_closing, 2) == 0) return
    answer%n_free_motions = count_free_motions(data%motion_closing(data%contact_rows, :), answer%multipliers_rid)
    if (answer%n_free_motions == 0) return
    call fit%evaluate(data, answer%theta, answer%coordinates, answer%multipliers_rid, room%fit, room%multipliers)
    answer%n_free_motions = count_free_motions(data%motion_closing, room%multipliers)
  end subroutine count_hhr_motions
end module sig_hhr_motions
