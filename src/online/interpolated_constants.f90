! SPDX-License-Identifier: BSD-3-Clause
!> Elastic constants as interpolation variables: Poisson's ratios and ratios of moduli.
!>
!> A variable is the constant itself or a logarithm: that of a ratio of moduli, or -log(1 - 2 nu) of a Poisson's ratio, as bulk over
!> shear modulus grows as 1/(1 - 2 nu). If the constants vary widely, polynomials in the logarithms converge far faster than
!> polynomials in the constants, because the logarithms move the values for which the stiffness is singular far away. But
!> interpolation over one constant itself has an error bound (README). So a single constant that varies little is the variable
!> itself.
module sig_interpolated_constants
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: to_constant, to_variable, variable_change

contains

  !> Returns the interpolation variable [-] of an elastic constant c: c itself or, if is_logarithmic, log c of a ratio of moduli and
  !> -log(1 - 2 c) of a Poisson's ratio.
  elemental real(rk) function to_variable(constant, is_ratio_of_moduli, is_logarithmic) result(variable)
    !> [-] elastic constant
    real(rk), intent(in) :: constant
    !> whether the constant is a ratio of moduli; otherwise it is a Poisson's ratio
    logical, intent(in) :: is_ratio_of_moduli
    !> whether the variable is a logarithm
    logical, intent(in) :: is_logarithmic

    variable = constant
    if (.not. is_logarithmic) return
    if (is_ratio_of_moduli) then
      variable = log(constant)
    else
      variable = -log(1 - 2 * constant)
    end if
  end function to_variable

  !> Returns the change [-], to first order, of the variable if the constant changes by `change`.
  elemental real(rk) function variable_change(constant, change, is_ratio_of_moduli, is_logarithmic)
    !> [-] elastic constant
    real(rk), intent(in) :: constant
    !> [-] change of the constant
    real(rk), intent(in) :: change
    !> this and the next: as for to_variable
    logical, intent(in) :: is_ratio_of_moduli
    logical, intent(in) :: is_logarithmic

    variable_change = change
    if (.not. is_logarithmic) return
    if (is_ratio_of_moduli) then
      variable_change = change / constant
    else
      variable_change = 2 * change / (1 - 2 * constant)
    end if
  end function variable_change

  !> Returns the elastic constant [-] of an interpolation variable: the inverse of to_variable.
  elemental real(rk) function to_constant(variable, is_ratio_of_moduli, is_logarithmic) result(constant)
    !> [-] result of to_variable
    real(rk), intent(in) :: variable
    logical, intent(in) :: is_ratio_of_moduli
    logical, intent(in) :: is_logarithmic

    constant = variable
    if (.not. is_logarithmic) return
    if (is_ratio_of_moduli) then
      constant = exp(variable)
    else
      constant = (1 - exp(-variable)) / 2
    end if
  end function to_constant
end module sig_interpolated_constants
