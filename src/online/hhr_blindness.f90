! SPDX-License-Identifier: BSD-3-Clause
!> Checks whether a hyper-reduced answer without contact forces misses contacts outside its domain.
module sig_hhr_blindness
  use sig_hhr_data, only: fill_openings, hhr_data_t
  use sig_kinds, only: rk
  use sig_multiplier_fit, only: work_of_loads
  implicit none(type, external)
  private
  public :: is_blind

  !> [-] penetration up to this share of the snapshots' largest normal displacement counts as an error of the modes
  real(rk), parameter :: noticeable = 1.0e-2_rk

contains

  !> Whether some contact must carry a force although no contact of the domain does: the loads do work on a rigid motion that only
  !> contact holds; or, by the reduced displacement, some contact penetrates by more than 1 % of largest_value. The second check is
  !> left out if the model lacks the data for openings. Requires: an answer without contact forces in the domain.
  logical function is_blind(data, largest_value, theta, coordinates, opening)
    type(hhr_data_t), intent(in) :: data
    !> [length] largest normal displacement in the snapshots
    real(rk), intent(in) :: largest_value
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length] gamma, shape (n_modes)
    real(rk), contiguous, intent(in) :: coordinates(:)
    !> work array, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    logical :: is_known

    is_blind = any(abs(work_of_loads(data, theta)) > 0)
    if (is_blind) return
    call fill_openings(data, theta, coordinates, opening, is_known)
    if (is_known) is_blind = any(opening < -noticeable * largest_value)
  end function is_blind
end module sig_hhr_blindness
