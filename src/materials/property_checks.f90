! SPDX-License-Identifier: BSD-3-Clause
!> Ranges of properties that several laws have. Numbers that are not finite are out of every range.
module sig_property_checks
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: bad_creep, bad_elastic_constant, bad_stress, is_positive_or_zero, rule_of

contains

  !> Returns 1 for a Young's modulus that is not positive, 2 for a Poisson's ratio outside of -1 to 1/2, else 0.
  pure integer function bad_elastic_constant(properties) result(bad)
    !> E, nu, ...
    real(rk), intent(in) :: properties(:)

    bad = 0
    if (.not. (properties(2) > -1 .and. properties(2) < 0.5_rk)) bad = 2
    if (.not. (properties(1) > 0 .and. ieee_is_finite(properties(1)))) bad = 1
  end function bad_elastic_constant

  !> Returns which of both properties of creep is out of range: A is negative, or n is less than 1; 0 if there is none.
  pure integer function bad_creep(properties, coefficient, exponent) result(bad)
    real(rk), intent(in) :: properties(:)
    !> their numbers
    integer, intent(in) :: coefficient, exponent

    bad = 0
    if (.not. (properties(exponent) >= 1 .and. ieee_is_finite(properties(exponent)))) bad = exponent
    if (.not. is_positive_or_zero(properties(coefficient))) bad = coefficient
  end function bad_creep

  !> Returns the number of the first yield stress of a curve that is not positive, or less than the one before; 0 if there is none.
  pure integer function bad_stress(properties, first) result(bad)
    real(rk), intent(in) :: properties(:)
    !> number of the first of these stresses
    integer, intent(in) :: first

    do bad = first, size(properties)
      if (.not. (properties(bad) > 0 .and. ieee_is_finite(properties(bad)))) return
      if (bad == first) cycle
      if (properties(bad) < properties(bad - 1)) return
    end do
    bad = 0
  end function bad_stress

  !> Returns what is allowed for a property, as the end of a sentence.
  pure function rule_of(name) result(rule)
    !> one of material_law_t%property_names
    character(*), intent(in) :: name
    character(60) :: rule

    select case (name)
    case ('young_modulus')
      rule = 'it must be positive'
    case ('poisson_ratio')
      rule = 'it must be between -1 and 0.5'
    case ('yield_stress')
      rule = 'it must be positive, and must not fall along a curve'
    case ('exponent')
      rule = 'it must be at least 1'
    case default
      rule = 'it must not be negative'
    end select
  end function rule_of

  !> Whether a property is finite and not negative.
  pure logical function is_positive_or_zero(value)
    real(rk), intent(in) :: value

    is_positive_or_zero = value >= 0 .and. ieee_is_finite(value)
  end function is_positive_or_zero
end module sig_property_checks
