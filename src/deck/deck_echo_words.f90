! SPDX-License-Identifier: BSD-3-Clause
!> Writes single values so that YAML reads them back.
module sig_deck_echo_words
  use sig_kinds, only: rk
  use sig_text, only: lower, read_real, to_text
  implicit none(type, external)
  private
  public :: yaml_text, count_or_word, tolerance_or_none

  !> words in capital or small letters that readers of YAML do not take for a text
  character(*), parameter, public :: yaml_words(7) = [character(5) :: 'true', 'false', 'yes', 'no', 'on', 'off', 'null']

contains

  !> Returns the number `count` as text, or `word` if `count` is `special`.
  pure function count_or_word(count, special, word) result(yaml)
    integer, intent(in) :: count
    integer, intent(in) :: special
    character(*), intent(in) :: word
    character(:), allocatable :: yaml

    yaml = to_text(count)
    if (count == special) yaml = word
  end function count_or_word

  !> Returns a tolerance as text, or `none` if it is not above 0.
  pure function tolerance_or_none(tolerance) result(yaml)
    real(rk), intent(in) :: tolerance
    character(:), allocatable :: yaml

    yaml = 'none'
    if (tolerance > 0) yaml = to_text(tolerance)
  end function tolerance_or_none

  !> Returns a text for YAML. The text is unchanged if YAML, also inside { }, can only read it as this text. Then it begins with a
  !> letter, a digit or one of _ . / (, perhaps behind a minus sign, and goes on with these, blanks and - + * ^ ) < > =. It does
  !> not end with a blank, and is no decimal number, no word such as true, y or null, and not one of is_other_number. Any other
  !> text, such as an empty one or one with accents, is put in double quotes, and in it a backslash before each double quote and
  !> backslash. Requires: the text has no line end.
  pure function yaml_text(text) result(yaml)
    character(*), intent(in) :: text
    character(:), allocatable :: yaml
    integer :: i

    yaml = text
    if (is_plain(text)) return
    yaml = '"'
    do i = 1, len(text)
      if (text(i:i) == '"' .or. text(i:i) == '\') yaml = yaml // '\'
      yaml = yaml // text(i:i)
    end do
    yaml = yaml // '"'
  end function yaml_text

  pure logical function is_plain(text)
    character(*), intent(in) :: text
    character(*), parameter :: first = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./('
    real(rk) :: number
    integer :: i
    logical :: is_number

    is_plain = .false.
    if (len(text) == 0) return
    ! the text may start with a minus sign, as in -squeeze
    i = merge(2, 1, text(1:1) == '-')
    if (i > len(text)) return
    if (index(first, text(i:i)) == 0 .or. verify(text, first // '-+*^)<>= ') > 0 .or. text(len(text):) == ' ') return
    ! words that YAML (here or in another reader) does not read as a text
    select case (lower(text))
    case ('y', 'n', '.nan', '.inf', '-.inf')
      is_plain = .false.
    case default
      call read_real(text, number, is_number)
      is_plain = .not. (is_number .or. is_other_number(text) .or. any(yaml_words == lower(text)))
    end select
  end function is_plain

  !> Whether readers of YAML may take the text for a date, 2026-11-23, or for a number such as 0x1f, 0o17 or 1_000.
  pure logical function is_other_number(text)
    character(*), intent(in) :: text
    character(*), parameter :: digits = '0123456789'

    associate (number => text(merge(2, 1, scan(text(:1), '-+') == 1):))
      is_other_number = verify(number, digits // '_.') == 0
      if (len(number) > 2) is_other_number = is_other_number .or. any(number(:2) == ['0x', '0o', '0b'])
      if (len(number) > 5) is_other_number = is_other_number .or. &
        (verify(number(:4), digits) == 0 .and. number(5:5) == '-' .and. verify(number, digits // '-') == 0)
    end associate
  end function is_other_number
end module sig_deck_echo_words
