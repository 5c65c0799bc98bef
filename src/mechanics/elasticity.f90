! SPDX-License-Identifier: BSD-3-Clause
!> Matrices of isotropic linear elasticity in Voigt's notation, for every mechanical model.
module sig_elasticity
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  implicit none(type, external)
  private
  public :: hooke_matrix, n_strains, n_stresses, stress_matrix, hooke_term, modulus_text, n_hooke_terms, von_mises

  !> xx, yy, zz, xy, yz, xz: the order of symmetric tensors in VTK; in axisymmetry rr, zz, hoop, rz
  integer, parameter :: n_stresses = 6

  !> Hooke's matrix is bulk modulus * hooke_term(1) + shear modulus * hooke_term(2)
  integer, parameter :: n_hooke_terms = 2

contains

  !> Returns the number of strain components that do work in a model: 3 in the plane, 4 in axisymmetry, 6 in space; 0 for an unknown
  !> model.
  pure integer function n_strains(model)
    !> name of a mechanical model
    character(*), intent(in) :: model
    type(mechanical_model_t) :: row

    row = mechanical_model(model)
    n_strains = row%n_strains
  end function n_strains

  !> Returns Hooke's matrix for the components that do work, in the order of mechanical_model_t%strains; shear strains are angles (2
  !> eps_xy). Does not check the constants.
  pure function hooke_matrix(model, young_modulus, poisson_ratio) result(hooke)
    !> name of a mechanical model
    character(*), intent(in) :: model
    !> [force/length**2] > 0
    real(rk), intent(in) :: young_modulus
    !> [-] in (-1, 0.5)
    real(rk), intent(in) :: poisson_ratio
    !> [force/length**2] symmetric, shape (n_strains, n_strains)
    real(rk) :: hooke(n_strains(model), n_strains(model))
    real(rk) :: all_stresses(n_stresses, n_stresses)
    type(mechanical_model_t) :: row

    row = mechanical_model(model)
    all_stresses = stress_matrix(model, young_modulus, poisson_ratio)
    hooke = all_stresses(row%strains(:row%n_strains), row%strains(:row%n_strains))
  end function hooke_matrix

  !> Returns Hooke's matrix for all stresses and elastic strains xx, yy, zz, xy, yz, xz (in axisymmetry rr, zz, hoop, rz first);
  !> shear strains are angles. Does not check the constants.
  !>
  !> sigma = lambda (tr eps) I + 2 mu eps. In plane stress, row and column zz are zero: eps_zz follows from sigma_zz = 0, so a given
  !> eps_zz has no effect.
  pure function stress_matrix(model, young_modulus, poisson_ratio) result(hooke)
    !> name of a mechanical model
    character(*), intent(in) :: model
    !> [force/length**2] > 0
    real(rk), intent(in) :: young_modulus
    !> [-] in (-1, 0.5)
    real(rk), intent(in) :: poisson_ratio
    !> [force/length**2] symmetric
    real(rk) :: hooke(n_stresses, n_stresses)
    real(rk) :: shear, lame
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
      hooke(:, 3) = 0
    end if
  end function stress_matrix

  !> Returns the part of stress_matrix that belongs to one modulus, for a modulus of 1: for the bulk modulus sigma = (tr eps) I, for
  !> the shear modulus sigma = 2 (eps - (tr eps) / d I). Both matrices are positive semidefinite.
  !>
  !> d is 3, but 2 in plane stress, where tr eps and I are those of the plane. Shear strains are angles.
  pure function hooke_term(model, i_term) result(hooke)
    !> name of a mechanical model
    character(*), intent(in) :: model
    !> 1 = bulk, 2 = shear
    integer, intent(in) :: i_term
    !> [-] symmetric, stresses and strains as in stress_matrix
    real(rk) :: hooke(n_stresses, n_stresses)
    integer :: i, d

    d = normal_strains(model)
    hooke = 0
    if (i_term == 1) then
      hooke(:d, :d) = 1
      return
    end if
    hooke(:d, :d) = -2.0_rk / d
    do i = 1, d
      hooke(i, i) = 2 - 2.0_rk / d
    end do
    do i = 4, n_stresses
      hooke(i, i) = 1
    end do
  end function hooke_term

  !> Returns the text of an expression: how the modulus of a hooke_term follows from E and nu. Bulk: E / (3 (1 - 2 nu)),
  !> in plane stress E / (2 (1 - nu)). Shear: E / (2 (1 + nu)).
  pure function modulus_text(model, i_term, young_modulus, poisson_ratio) result(text)
    !> name of a mechanical model
    character(*), intent(in) :: model
    !> 1 = bulk, 2 = shear
    integer, intent(in) :: i_term
    !> texts of the expressions of E and nu
    character(*), intent(in) :: young_modulus
    character(*), intent(in) :: poisson_ratio
    character(:), allocatable :: text

    if (i_term == 2) then
      text = '(2*(1+(' // poisson_ratio // ')))'
    else if (normal_strains(model) == 2) then
      text = '(2*(1-(' // poisson_ratio // ')))'
    else
      text = '(3*(1-2*(' // poisson_ratio // ')))'
    end if
    text = '(' // young_modulus // ')/' // text
  end function modulus_text

  !> Returns the number of normal strains in Hooke's law of the model: 2 in plane stress, else 3.
  pure integer function normal_strains(model)
    character(*), intent(in) :: model
    type(mechanical_model_t) :: row

    row = mechanical_model(model)
    normal_strains = merge(2, 3, row%is_thin)
  end function normal_strains

  !> Returns the von Mises stress of each column: sqrt(((xx - yy)**2 + (yy - zz)**2 + (zz - xx)**2) / 2 + 3 (xy**2 + yz**2 +
  !> xz**2)).
  pure function von_mises(stresses) result(equivalent)
    !> [force/length**2] xx, yy, zz, xy, yz, xz; shape (n_stresses, n)
    real(rk), intent(in) :: stresses(:, :)
    !> [force/length**2] shape (n)
    real(rk) :: equivalent(size(stresses, 2))

    equivalent = sqrt(((stresses(1, :) - stresses(2, :))**2 + (stresses(2, :) - stresses(3, :))**2 + &
      (stresses(3, :) - stresses(1, :))**2) / 2 + 3 * sum(stresses(4:6, :)**2, dim=1))
  end function von_mises
end module sig_elasticity
