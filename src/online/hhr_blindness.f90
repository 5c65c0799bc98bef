! SPDX-License-Identifier: BSD-3-Clause
!> Whether a hyper-reduced answer without contact forces misses what its domain does not see.
module sig_hhr_blindness
  use sig_hhr_data, only: add_lifted, hhr_data_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_multiplier_fit, only: work_of_loads
  implicit none(type, external)
  private
  public :: is_blind

  !> [-] penetration up to this share of the snapshots' largest normal displacement is what modes leave
  real(rk), parameter :: noticeable = 1.0e-2_rk

contains

  !> Whether something must touch although the domain has no contact forces: loads on a body that only contact holds, or pairs
  !> that penetrate elsewhere.
  logical function is_blind(data, largest_value, theta, coordinates, opening)
    type(hhr_data_t), intent(in) :: data
    !> [length] largest normal displacement in the snapshots
    real(rk), intent(in) :: largest_value
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length] gamma, shape (n_modes)
    real(rk), contiguous, intent(in) :: coordinates(:)
    !> room, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    real(rk) :: values(2 * size(opening))

    is_blind = any(abs(work_of_loads(data, theta)) > 0)
    if (is_blind .or. size(data%contact_gap, 2) /= size(theta)) return
    if (size(data%contact_value_basis, 1) /= size(values)) return
    associate (n => size(opening))
      call multiply(1.0_rk, data%contact_value_basis, coordinates, 0.0_rk, values)
      call add_lifted(data, 1.0_rk, data%contact_value_lifting, theta, values)
      call multiply(1.0_rk, data%contact_gap, theta, 0.0_rk, opening)
      opening = opening - values(:n) + values(n + 1:)
    end associate
    is_blind = any(opening < -noticeable * largest_value)
  end function is_blind
end module sig_hhr_blindness
