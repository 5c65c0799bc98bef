! SPDX-License-Identifier: BSD-3-Clause
!> Kinds of numbers, defined in one place.
module sig_kinds
  use, intrinsic :: iso_fortran_env, only: int64, real32, real64
  implicit none(type, external)
  private
  public :: rk, sk, lk

  !> kind of the real numbers of the code, but for sk
  integer, parameter :: rk = real64
  !> kind of numbers that are kept in single precision, where there are very many
  integer, parameter :: sk = real32
  !> kind of integers that need 64 bits, such as hashes and numbers of bytes
  integer, parameter :: lk = int64
end module sig_kinds
