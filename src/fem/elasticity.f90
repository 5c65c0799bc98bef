! SPDX-License-Identifier: BSD-3-Clause
!> Isotropic linear elasticity in Voigt's notation, for every mechanical model.
module sig_elasticity
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  implicit none(type, external)
  private
  public :: hooke_matrix, n_strains, n_stresses, stress_matrix

  !> xx, yy, zz, xy, yz, xz: the order of symmetric tensors in VTK; in axisymmetry rr, zz, hoop, rz
  integer, parameter :: n_stresses = 6

contains

  !> Strain components that do work in a model; 0 for an unknown one.
  pure integer function n_strains(model)
    !> name of a mechanical model
    character(*), intent(in) :: model
    type(mechanical_model_t) :: row

    row = mechanical_model(model)
    n_strains = row%n_strains
  end function n_strains

  !> Stress = hooke * strain in the components that do work, shear strains as angles (2 eps_xy).
  pure function hooke_matrix(model, young_modulus, poisson_ratio) result(hooke)
    !> name of a mechanical model
    character(*), intent(in) :: model
    !> [force/length**2] > 0
    real(rk), intent(in) :: young_modulus
    !> [-] in (-1, 0.5)
    real(rk), intent(in) :: poisson_ratio
    !> [force/length**2] symmetric, shape (n_strains, n_strains)
    real(rk) :: hooke(n_strains(model), n_strains(model))
    real(rk) :: all_stresses(n_stresses, n_strains(model))
    type(mechanical_model_t) :: row

    row = mechanical_model(model)
    all_stresses = stress_matrix(model, young_modulus, poisson_ratio)
    hooke = all_stresses(row%strains(:row%n_strains), :)
  end function hooke_matrix

  !> All six stresses from the strains that do work.
  !>
  !> lambda (tr eps) I + 2 mu eps, where the other strains are zero; in plane stress eps_zz is such that sigma_zz is zero.
  pure function stress_matrix(model, young_modulus, poisson_ratio) result(stresses)
    !> name of a mechanical model
    character(*), intent(in) :: model
    !> [force/length**2] > 0
    real(rk), intent(in) :: young_modulus
    !> [-] in (-1, 0.5)
    real(rk), intent(in) :: poisson_ratio
    !> [force/length**2] shape (n_stresses, n_strains)
    real(rk) :: stresses(n_stresses, n_strains(model))
    real(rk) :: hooke(n_stresses, n_stresses), shear, lame
    type(mechanical_model_t) :: row
    integer :: i

    row = mechanical_model(model)
    shear = young_modulus / (2 * (1 + poisson_ratio))
    lame = young_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    hooke = 0
    hooke(:3, :3) = lame
    do i = 1, 3
      hooke(i, i) = lame + 2 * shear
      hooke(3 + i, 3 + i) = shear
    end do
    if (row%is_thin) then
      do i = 1, 2
        hooke(:, i) = hooke(:, i) - hooke(:, 3) * (hooke(3, i) / hooke(3, 3))
      end do
      ! the difference above leaves rounding there
      hooke(3, :) = 0
    end if
    stresses = hooke(:, row%strains(:row%n_strains))
  end function stress_matrix
end module sig_elasticity
