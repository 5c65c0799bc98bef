! SPDX-License-Identifier: BSD-3-Clause
!> Kinds of numbers, defined in one place.
module sig_kinds
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none(type, external)
  private
  public :: rk, lk

  !> kind of every real number of the code
  integer, parameter :: rk = real64
  !> kind of integers that need 64 bits, such as hashes and numbers of bytes
  integer, parameter :: lk = int64
end module sig_kinds
