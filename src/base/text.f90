! SPDX-License-Identifier: BSD-3-Clause
!> Helpers for short texts: numbers as text, lists of names, the nearest known word.
module sig_text
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int
  use sig_kinds, only: lk, rk
  implicit none(type, external)
  private
  public :: string_t, to_text, short_number, csv_number, join, append_text
  public :: counted, are, lost_digits
  public :: lower, split, read_real, read_integer, did_you_mean

  !> digits for short_number that are enough to find a place or to compare two sizes
  integer, parameter, public :: fine_digits = 6

  !> A text with its own length, so that arrays can hold texts.
  type :: string_t
    character(:), allocatable :: text
  end type string_t

  !> Returns a number as text: all digits of a whole number, or the shortest decimal that reads back as the same real number.
  interface to_text
    procedure integer_to_text, long_to_text, real_to_text
  end interface to_text

  !> Joins texts or numbers with a separator between them.
  interface join
    procedure join_texts, join_reals
  end interface join

  ! include/signorom/number_text.h describes this procedure in C.
  interface
    pure subroutine sig_shortest_decimal(number, text, length) bind(c)
      import :: c_char, c_double, c_int
      real(c_double), value :: number
      character(kind=c_char), intent(inout) :: text(*)
      integer(c_int), intent(out) :: length
    end subroutine sig_shortest_decimal
  end interface

contains

  pure function integer_to_text(number) result(text)
    integer, intent(in) :: number
    character(:), allocatable :: text

    text = long_to_text(int(number, lk))
  end function integer_to_text

  pure function long_to_text(number) result(text)
    integer(lk), intent(in) :: number
    character(:), allocatable :: text
    character(24) :: buffer
    integer(lk) :: rest
    integer :: i

    rest = number
    do i = len(buffer), 2, -1
      ! this also works for a negative number whose opposite does not exist
      buffer(i:i) = achar(iachar('0') + int(abs(mod(rest, 10_lk))))
      rest = rest / 10
      if (rest == 0) exit
    end do
    text = buffer(i:)
    if (number < 0) text = '-' // text
  end function long_to_text

  !> Returns a number with its noun: `1 point`, `2 points`, `3 stiffnesses`, `0 entries`. A last `y` always becomes `ies`.
  pure function counted(n, noun) result(text)
    integer, intent(in) :: n
    !> noun in the singular
    character(*), intent(in) :: noun
    character(:), allocatable :: text

    text = to_text(n) // ' ' // noun
    if (n == 1) return
    if (noun(len(noun):) == 'y') then
      text = text(:len(text) - 1) // 'ies'
    else if (noun(len(noun):) == 's') then
      text = text // 'es'
    else
      text = text // 's'
    end if
  end function counted

  !> Returns the verb for n things: `is` if n is 1, otherwise `are`.
  pure function are(n) result(verb)
    integer, intent(in) :: n
    character(:), allocatable :: verb

    verb = trim(merge('is ', 'are', n == 1))
  end function are

  !> Returns the shortest decimal that reads back as the same number, with a point: 0.15, 1.0e-8, 2.1e11; nan, inf, -inf. Zero has
  !> no sign. From 1e-4 to below 1e7 there is no exponent.
  pure function real_to_text(number) result(text)
    real(rk), intent(in) :: number
    character(:), allocatable :: text
    character(kind=c_char) :: buffer(32)
    integer(c_int) :: n
    integer :: i

    if (.not. ieee_is_finite(number)) then
      text = 'inf'
      if (sign(1.0_rk, number) < 0) text = '-inf'
      if (ieee_is_nan(number)) text = 'nan'
      return
    end if
    if (.not. abs(number) > 0) then
      text = '0.0'
      return
    end if
    call sig_shortest_decimal(number, buffer, n)
    allocate (character(n) :: text)
    do i = 1, n
      text(i:i) = buffer(i)
    end do
    text = plain_decimal(text)
  end function real_to_text

  !> Rewrites `-1.2340e+02` as `-123.4` from 1e-4 to below 1e7, else as d.ddde<n>, without zeros at the end after the first decimal.
  pure function plain_decimal(scientific) result(text)
    character(*), intent(in) :: scientific
    character(:), allocatable :: text
    character(:), allocatable :: sign, digits
    integer :: exponent, i_digit, i_e, i_start

    i_start = merge(2, 1, scientific(1:1) == '-')
    sign = scientific(:i_start - 1)
    i_e = index(scientific, 'e')
    exponent = 0
    do i_digit = i_e + 2, len(scientific)
      exponent = 10 * exponent + iachar(scientific(i_digit:i_digit)) - iachar('0')
    end do
    if (scientific(i_e + 1:i_e + 1) == '-') exponent = -exponent
    digits = scientific(i_start:i_start) // scientific(i_start + 2:i_e - 1)
    digits = digits(:max(1, verify(digits, '0', back=.true.)))
    if (exponent < -4 .or. exponent > 6) then
      text = digits(1:1) // '.' // or_zero(digits(2:)) // 'e' // to_text(exponent)
    else if (exponent < 0) then
      text = '0.' // repeat('0', -exponent - 1) // digits
    else
      digits = digits // repeat('0', max(0, exponent + 1 - len(digits)))
      text = digits(:exponent + 1) // '.' // or_zero(digits(exponent + 2:))
    end if
    text = sign // text
  end function plain_decimal

  pure function or_zero(digits) result(text)
    character(*), intent(in) :: digits
    character(:), allocatable :: text

    text = digits
    if (len(digits) == 0) text = '0'
  end function or_zero

  !> Returns a number rounded to a few significant digits, for messages; nan and inf as to_text.
  pure function short_number(value, n_digits) result(text)
    real(rk), intent(in) :: value
    !> number of significant digits, 1 to 15; default 4
    integer, intent(in), optional :: n_digits
    character(:), allocatable :: text
    character(24) :: buffer
    character(12) :: form
    real(rk) :: rounded
    integer :: status

    ! comparing a NaN would end a host that traps floating-point exceptions
    if (.not. ieee_is_finite(value)) then
      text = to_text(value)
      return
    end if
    form = '(es24.3e3)'
    if (present(n_digits)) write (form, '(a, i0, a)') '(es24.', n_digits - 1, 'e3)'
    write (buffer, form) value
    read (buffer, *, iostat=status) rounded
    ! adding zero turns -0 into 0
    text = to_text(merge(rounded, value, status == 0) + 0.0_rk)
  end function short_number

  !> Returns how many digits a condition number costs (its log10, rounded, at most 16): `8 of 16 digits`.
  pure function lost_digits(condition) result(text)
    !> [-] >= 1
    real(rk), intent(in) :: condition
    character(:), allocatable :: text

    text = '16 of 16 digits'
    if (condition < 1.0e16_rk) text = to_text(nint(log10(max(condition, 1.0_rk)))) // ' of 16 digits'
  end function lost_digits

  !> Returns a number with seven significant digits (`1.234567E-03`), `inf` or `nan`. A number below 0 gives `nan`, too.
  pure function csv_number(value) result(text)
    real(rk), intent(in) :: value
    character(:), allocatable :: text
    character(24) :: buffer

    if (value > huge(value)) then
      text = 'inf'
    else if (value >= 0) then
      write (buffer, '(es14.6)') value
      ! an exponent of three digits leaves no room for its E
      if (index(buffer, 'E') == 0) write (buffer, '(es15.6e3)') value
      text = trim(adjustl(buffer))
    else
      text = 'nan'
    end if
  end function csv_number

  !> Appends a text to a list, which may be unallocated. An array constructor of string_t loses a computed text in gfortran 12.
  pure subroutine append_text(list, text)
    type(string_t), allocatable, intent(inout) :: list(:)
    character(*), intent(in) :: text
    type(string_t), allocatable :: longer(:)
    integer :: i

    if (.not. allocated(list)) allocate (list(0))
    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      call move_alloc(list(i)%text, longer(i)%text)
    end do
    longer(size(longer))%text = text
    call move_alloc(longer, list)
  end subroutine append_text

  !> Returns the texts with the separator between them.
  pure function join_texts(names, separator) result(text)
    type(string_t), intent(in) :: names(:)
    character(*), intent(in) :: separator
    character(:), allocatable :: text
    integer :: i_name

    text = ''
    do i_name = 1, size(names)
      if (i_name > 1) text = text // separator
      text = text // names(i_name)%text
    end do
  end function join_texts

  !> Returns the numbers as to_text writes them, with the separator between them.
  pure function join_reals(numbers, separator) result(text)
    real(rk), intent(in) :: numbers(:)
    character(*), intent(in) :: separator
    character(:), allocatable :: text
    type(string_t) :: texts(size(numbers))
    integer :: i

    do i = 1, size(numbers)
      texts(i)%text = to_text(numbers(i))
    end do
    text = join(texts, separator)
  end function join_reals

  !> Returns the text with ASCII capitals in lower case; all other bytes stay.
  pure function lower(text) result(lowered)
    character(*), intent(in) :: text
    character(len(text)) :: lowered
    integer :: i

    lowered = text
    do i = 1, len(text)
      if (text(i:i) >= 'A' .and. text(i:i) <= 'Z') lowered(i:i) = achar(iachar(text(i:i)) + 32)
    end do
  end function lower

  !> Splits a text at its separators. A text without separator is one piece, so the result is never empty.
  pure function split(text, separator) result(pieces)
    character(*), intent(in) :: text
    !> not empty
    character(*), intent(in) :: separator
    type(string_t), allocatable :: pieces(:)
    integer :: i_piece, i_start, i_found, n_pieces

    n_pieces = 1
    i_start = 1
    do
      i_found = index(text(i_start:), separator)
      if (i_found == 0) exit
      n_pieces = n_pieces + 1
      i_start = i_start + i_found - 1 + len(separator)
    end do
    allocate (pieces(n_pieces))
    i_start = 1
    do i_piece = 1, n_pieces - 1
      i_found = index(text(i_start:), separator)
      pieces(i_piece)%text = text(i_start:i_start + i_found - 2)
      i_start = i_start + i_found - 1 + len(separator)
    end do
    pieces(n_pieces)%text = text(i_start:)
  end function split

  !> Reads a decimal number such as `-1.5e-3`, `2` or `.5`; only blanks may stand around it. Not valid: nan, inf, overflow,
  !> Fortran's own forms (`1d0`, `2*3`, `1,`). A number too small for its type becomes 0 and is valid.
  pure subroutine read_real(text, value, is_valid)
    character(*), intent(in) :: text
    !> zero when not valid
    real(rk), intent(out) :: value
    logical, intent(out) :: is_valid
    character(:), allocatable :: word
    integer :: status

    value = 0
    word = trim(adjustl(text))
    is_valid = is_decimal(word)
    if (.not. is_valid) return
    read (word, *, iostat=status) value
    is_valid = status == 0 .and. ieee_is_finite(value)
    if (.not. is_valid) value = 0
  end subroutine read_real

  !> Reads a whole number, with or without a sign, within the default integer's range; only blanks may stand around it.
  pure subroutine read_integer(text, value, is_valid)
    character(*), intent(in) :: text
    !> zero when not valid
    integer, intent(out) :: value
    logical, intent(out) :: is_valid
    character(:), allocatable :: word
    integer :: i_digit, status

    value = 0
    word = trim(adjustl(text))
    i_digit = 1 + n_of_set(word, 1, '+-', 1)
    is_valid = n_of_set(word, i_digit, '0123456789', len(word)) == len(word) - i_digit + 1 .and. i_digit <= len(word)
    if (.not. is_valid) return
    read (word, *, iostat=status) value
    is_valid = status == 0
    if (.not. is_valid) value = 0
  end subroutine read_integer

  !> Whether the text is digits with at most one point, after an optional sign and before an optional exponent: e or E, an optional
  !> sign, digits. At least one digit stands before the exponent. Blanks are not allowed.
  pure logical function is_decimal(word)
    character(*), intent(in) :: word
    character(*), parameter :: digits = '0123456789'
    integer :: i, n_before, n_after

    is_decimal = .false.
    i = 1 + n_of_set(word, 1, '+-', 1)
    n_before = n_of_set(word, i, digits, len(word))
    i = i + n_before
    n_after = 0
    if (n_of_set(word, i, '.', 1) == 1) then
      n_after = n_of_set(word, i + 1, digits, len(word))
      i = i + 1 + n_after
    end if
    if (n_before + n_after == 0) return
    if (n_of_set(word, i, 'eE', 1) == 1) then
      i = i + 1
      i = i + n_of_set(word, i, '+-', 1)
      n_after = n_of_set(word, i, digits, len(word))
      if (n_after == 0) return
      i = i + n_after
    end if
    is_decimal = i == len(word) + 1
  end function is_decimal

  !> Counts the characters from position i_start on that belong to the set: up to the first one that does not, and at most n_max.
  pure integer function n_of_set(word, i_start, set, n_max) result(n)
    character(*), intent(in) :: word
    integer, intent(in) :: i_start
    character(*), intent(in) :: set
    integer, intent(in) :: n_max

    n = 0
    do while (n < n_max .and. i_start + n <= len(word))
      if (scan(word(i_start + n:i_start + n), set) == 0) exit
      n = n + 1
    end do
  end function n_of_set

  !> Returns the candidate that differs least from the word: by at most a third of the word's letters (rounded up, at least one),
  !> and by fewer letters than the candidate has. Empty if there is none. Upper and lower case are equal; of equally near candidates
  !> the first one is taken.
  pure function did_you_mean(word, candidates) result(text)
    character(*), intent(in) :: word
    type(string_t), intent(in) :: candidates(:)
    character(:), allocatable :: text
    integer :: distance, i_candidate, smallest

    text = ''
    smallest = max(1, (len(word) + 2) / 3) + 1
    do i_candidate = 1, size(candidates)
      distance = edit_distance(lower(word), lower(candidates(i_candidate)%text))
      if (distance >= smallest .or. distance >= len(candidates(i_candidate)%text)) cycle
      smallest = distance
      text = candidates(i_candidate)%text
    end do
  end function did_you_mean

  !> Returns the fewest edits between two words: insert, delete or replace a letter, or swap two neighbors; no letter twice.
  pure integer function edit_distance(first, second) result(distance)
    character(*), intent(in) :: first
    character(*), intent(in) :: second
    integer :: table(0:len(first), 0:len(second))
    integer :: i, j

    table(:, 0) = [(i, i=0, len(first))]
    table(0, :) = [(j, j=0, len(second))]
    do j = 1, len(second)
      do i = 1, len(first)
        table(i, j) = min(table(i - 1, j) + 1, table(i, j - 1) + 1, &
          table(i - 1, j - 1) + merge(0, 1, first(i:i) == second(j:j)))
        if (i == 1 .or. j == 1) cycle
        if (first(i:i) == second(j - 1:j - 1) .and. first(i - 1:i - 1) == second(j:j)) &
          table(i, j) = min(table(i, j), table(max(i, 2) - 2, max(j, 2) - 2) + 1)
      end do
    end do
    distance = table(len(first), len(second))
  end function edit_distance
end module sig_text
