! SPDX-License-Identifier: BSD-3-Clause
!> Sets of indices stored as bits: one integer keeps 32 flags.
module sig_bits
  implicit none(type, external)
  private
  public :: n_words, pack_bits, pack_columns, unpack_bits, unpack_columns

  integer, parameter :: word_size = bit_size(1)

contains

  !> Returns the number of integers ("words") that keep n_flags flags as bits, 32 flags in each.
  elemental integer function n_words(n_flags)
    integer, intent(in) :: n_flags

    n_words = (n_flags + word_size - 1) / word_size
  end function n_words

  !> Writes flags into the bits of integers: flag 1 is the lowest bit of words(1), flag 33 that of words(2). Bits without a flag
  !> are 0.
  pure subroutine pack_bits(flags, words)
    logical, intent(in) :: flags(:)
    !> shape (n_words(size(flags)))
    integer, intent(out) :: words(:)
    integer :: i

    words = 0
    do i = 1, size(flags)
      if (flags(i)) words((i - 1) / word_size + 1) = ibset(words((i - 1) / word_size + 1), modulo(i - 1, word_size))
    end do
  end subroutine pack_bits

  !> Reads flags from the bits of integers, as many as `flags` has.
  pure subroutine unpack_bits(words, flags)
    !> from pack_bits, shape (>= n_words(size(flags)))
    integer, intent(in) :: words(:)
    logical, intent(out) :: flags(:)
    integer :: i

    do i = 1, size(flags)
      flags(i) = btest(words((i - 1) / word_size + 1), modulo(i - 1, word_size))
    end do
  end subroutine unpack_bits

  !> Packs each column of flags by pack_bits: returns the words, one column for each column of flags.
  pure function pack_columns(flags) result(words)
    !> shape (n_flags, n)
    logical, intent(in) :: flags(:, :)
    !> shape (n_words(n_flags), n)
    integer :: words(n_words(size(flags, 1)), size(flags, 2))
    integer :: i

    do i = 1, size(flags, 2)
      call pack_bits(flags(:, i), words(:, i))
    end do
  end function pack_columns

  !> Returns the flags of each column of words, shape (n_flags, n). It undoes pack_columns.
  pure function unpack_columns(words, n_flags) result(flags)
    !> shape (n_words(n_flags), n)
    integer, intent(in) :: words(:, :)
    !> number of flags of a column
    integer, intent(in) :: n_flags
    logical :: flags(n_flags, size(words, 2))
    integer :: i

    do i = 1, size(words, 2)
      call unpack_bits(words(:, i), flags(:, i))
    end do
  end function unpack_columns
end module sig_bits
