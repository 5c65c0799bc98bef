! SPDX-License-Identifier: BSD-3-Clause
!> Isotropic hardening: the yield stress as a function of the equivalent plastic strain, straight between points and behind the
!> last. One point makes linear hardening.
module sig_hardening
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: hardening_line_t, hardening_line, yield_stress_at

  !> One straight part of the curve.
  type :: hardening_line_t
    !> [-] equivalent plastic strain at both ends
    real(rk) :: start = 0, end = 0
    !> [force/length**2] yield stress at the start
    real(rk) :: stress = 0
    !> [force/length**2] >= 0
    real(rk) :: slope = 0
  contains
    procedure :: at
  end type hardening_line_t

contains

  !> Returns a part of the curve, 1-based; part size(strains) is the one behind the last point.
  pure type(hardening_line_t) function hardening_line(strains, stresses, last_slope, i_part) result(line)
    !> [-] the points, increasing from 0; shape (n_points)
    real(rk), intent(in) :: strains(:)
    !> [force/length**2] not falling; shape (n_points)
    real(rk), intent(in) :: stresses(:)
    !> [force/length**2] slope behind the last point
    real(rk), intent(in) :: last_slope
    integer, intent(in) :: i_part

    line%start = strains(i_part)
    line%stress = stresses(i_part)
    line%end = huge(1.0_rk)
    line%slope = last_slope
    if (i_part == size(strains)) return
    line%end = strains(i_part + 1)
    line%slope = (stresses(i_part + 1) - stresses(i_part)) / (line%end - line%start)
  end function hardening_line

  !> Returns the yield stress on the line, also outside of its ends.
  pure real(rk) function at(self, strain)
    class(hardening_line_t), intent(in) :: self
    !> [-]
    real(rk), intent(in) :: strain

    at = self%stress + self%slope * (strain - self%start)
  end function at

  !> Returns the yield stress.
  pure real(rk) function yield_stress_at(strains, stresses, last_slope, strain) result(stress)
    !> as in hardening_line
    real(rk), intent(in) :: strains(:), stresses(:), last_slope
    !> [-] equivalent plastic strain, >= 0
    real(rk), intent(in) :: strain
    type(hardening_line_t) :: line
    integer :: i

    do i = 1, size(strains)
      line = hardening_line(strains, stresses, last_slope, i)
      if (strain < line%end) exit
    end do
    stress = line%at(strain)
  end function yield_stress_at
end module sig_hardening
