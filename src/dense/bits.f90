! SPDX-License-Identifier: BSD-3-Clause
!> Index sets as bits: 32 flags to an integer.
module sig_bits
  implicit none(type, external)
  private
  public :: n_words, pack_bits, unpack_bits

  integer, parameter :: word_size = bit_size(1)

contains

  !> Integers that hold so many flags.
  elemental integer function n_words(n_flags)
    integer, intent(in) :: n_flags

    n_words = (n_flags + word_size - 1) / word_size
  end function n_words

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

  pure subroutine unpack_bits(words, flags)
    integer, intent(in) :: words(:)
    logical, intent(out) :: flags(:)
    integer :: i

    do i = 1, size(flags)
      flags(i) = btest(words((i - 1) / word_size + 1), modulo(i - 1, word_size))
    end do
  end subroutine unpack_bits
end module sig_bits
