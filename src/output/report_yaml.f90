! SPDX-License-Identifier: BSD-3-Clause
!> Writes numbers and texts in YAML so that all readers read the same values.
module sig_report_yaml
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
  use sig_kinds, only: rk
  use sig_text, only: lower, to_text
  implicit none(type, external)
  private
  public :: yaml_of_real, yaml_of_text

contains

  !> Returns a real number in YAML: `.nan`, `.inf` and `-.inf` for what is not finite, and a sign in each exponent, which YAML 1.1
  !> (PyYAML) needs.
  pure function yaml_of_real(value) result(yaml)
    real(rk), intent(in) :: value
    character(:), allocatable :: yaml
    integer :: i_e

    if (ieee_is_finite(value)) then
      yaml = to_text(value)
      i_e = index(yaml, 'e')
      if (i_e > 0 .and. index(yaml, 'e-') == 0) yaml = yaml(:i_e) // '+' // yaml(i_e + 1:)
    else if (ieee_is_nan(value)) then
      yaml = '.nan'
    else
      yaml = trim(merge('-.inf', '.inf ', value < 0))
    end if
  end function yaml_of_real

  !> Returns a text in YAML. It is plain if it begins with an ASCII letter or `_`, has only such letters, digits, blanks and the
  !> characters `_./()+*-`, does not end with a blank, and is no word such as `yes` or `null`. Any other text, also an empty one,
  !> gets double quotes.
  pure function yaml_of_text(value) result(yaml)
    character(*), intent(in) :: value
    character(:), allocatable :: yaml
    integer :: i

    if (is_plain(value)) then
      yaml = value
      return
    end if
    yaml = '"'
    do i = 1, len(value)
      yaml = yaml // escaped(value(i:i))
    end do
    yaml = yaml // '"'
  end function yaml_of_text

  pure logical function is_plain(value)
    character(*), intent(in) :: value
    character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_'
    ! words that one YAML version or the other reads as something else
    character(*), parameter :: taken = ' y n yes no on off true false null nan inf '

    is_plain = .false.
    if (len(value) == 0) return
    if (scan(value(1:1), letters) == 0 .or. value(len(value):) == ' ') return
    if (verify(value, letters // '0123456789 ./()+*-') > 0) return
    is_plain = index(taken, ' ' // lower(value) // ' ') == 0
  end function is_plain

  pure function escaped(letter) result(text)
    character(1), intent(in) :: letter
    character(:), allocatable :: text
    character(4) :: code

    select case (letter)
    case ('"', achar(92))
      text = achar(92) // letter
    case (achar(10))
      text = achar(92) // 'n'
    case (achar(9))
      text = achar(92) // 't'
    case default
      text = letter
      if (iachar(letter) < 32) then
        write (code, '(a, z2.2)') achar(92) // 'x', iachar(letter)
        text = code
      end if
    end select
  end function escaped
end module sig_report_yaml
