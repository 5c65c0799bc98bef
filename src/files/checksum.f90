! SPDX-License-Identifier: BSD-3-Clause
!> Checksums (FNV-1a, 64 bits). They detect changed files; they do not protect against intended changes.
module sig_checksum
  use, intrinsic :: iso_c_binding, only: c_int64_t, c_size_t
  use sig_c_strings, only: to_c
  use sig_kinds, only: lk, rk
  implicit none(type, external)
  private
  public :: hash_of_text, fnv1a, fnv1a_seed, hash_digits

  !> FNV's offset basis, z'cbf29ce484222325', as a signed number
  integer(lk), parameter :: fnv1a_seed = -3750763034362895579_lk

  !> fnv1a(value, seed) returns the hash of the bytes of a value: a text, a list of integers, or reals of rank 1 or 2. The seed is
  !> fnv1a_seed, or the hash of the values before. Numbers count as the bytes that the machine has for them, matrices column by
  !> column.
  interface fnv1a
    procedure fnv1a_of_text, fnv1a_of_integers, fnv1a_of_reals, fnv1a_of_matrix
  end interface fnv1a

  ! include/signorom/checksum.h describes this procedure in C.
  interface
    pure integer(c_int64_t) function sig_fnv1a(bytes, size, seed) bind(c)
      import :: c_int64_t, c_size_t
      type(*), intent(in) :: bytes(*)
      integer(c_size_t), value :: size
      integer(c_int64_t), value :: seed
    end function sig_fnv1a
  end interface

contains

  !> Returns the hash (fnv1a with fnv1a_seed) of a text as 16 lower-case hexadecimal digits.
  pure function hash_of_text(text) result(digits)
    character(*), intent(in) :: text
    character(16) :: digits

    digits = hash_digits(fnv1a(text, fnv1a_seed))
  end function hash_of_text

  !> Returns a hash as 16 lower-case hexadecimal digits.
  pure function hash_digits(hash) result(digits)
    integer(lk), intent(in) :: hash
    character(16) :: digits
    integer :: i

    write (digits, '(z16.16)') hash
    do i = 1, 16
      if (digits(i:i) >= 'A' .and. digits(i:i) <= 'F') digits(i:i) = achar(iachar(digits(i:i)) + 32)
    end do
  end function hash_digits

  pure integer(lk) function fnv1a_of_text(text, seed) result(hash)
    character(*), intent(in) :: text
    integer(lk), intent(in) :: seed

    hash = sig_fnv1a(to_c(text), len(text, c_size_t), seed)
  end function fnv1a_of_text

  pure integer(lk) function fnv1a_of_integers(values, seed) result(hash)
    integer, intent(in) :: values(:)
    integer(lk), intent(in) :: seed

    hash = sig_fnv1a(values, size(values, kind=c_size_t) * (storage_size(values) / 8), seed)
  end function fnv1a_of_integers

  pure integer(lk) function fnv1a_of_reals(values, seed) result(hash)
    real(rk), intent(in) :: values(:)
    integer(lk), intent(in) :: seed

    hash = sig_fnv1a(values, size(values, kind=c_size_t) * (storage_size(values) / 8), seed)
  end function fnv1a_of_reals

  pure integer(lk) function fnv1a_of_matrix(values, seed) result(hash)
    real(rk), intent(in) :: values(:, :)
    integer(lk), intent(in) :: seed

    hash = sig_fnv1a(values, size(values, kind=c_size_t) * (storage_size(values) / 8), seed)
  end function fnv1a_of_matrix
end module sig_checksum
