! SPDX-License-Identifier: BSD-3-Clause
!> Isotropic linear elasticity: Hooke's matrix in Voigt's notation.
module sig_elasticity
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: hooke_matrix, n_strains

contains

  !> Strain components that do work in a model: xx, yy, xy in the plane.
  pure integer function n_strains(model)
    !> plane_strain
    character(*), intent(in) :: model

    n_strains = 0
    if (model == 'plane_strain') n_strains = 3
  end function n_strains

  !> Stress = hooke * strain, shear strains as angles (2 eps_xy).
  !>
  !> Plane strain: lambda (tr eps) I + 2 mu eps with eps_zz = 0.
  pure function hooke_matrix(model, young_modulus, poisson_ratio) result(hooke)
    character(*), intent(in) :: model
    !> [force/length**2] > 0
    real(rk), intent(in) :: young_modulus
    !> [-] in (-1, 0.5)
    real(rk), intent(in) :: poisson_ratio
    !> [force/length**2] shape (n_strains, n_strains)
    real(rk) :: hooke(n_strains(model), n_strains(model))
    real(rk) :: shear, lame
    integer :: i

    shear = young_modulus / (2 * (1 + poisson_ratio))
    lame = young_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    hooke = 0
    hooke(:2, :2) = lame
    do i = 1, 2
      hooke(i, i) = lame + 2 * shear
    end do
    hooke(3, 3) = shear
  end function hooke_matrix
end module sig_elasticity
