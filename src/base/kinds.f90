! SPDX-License-Identifier: BSD-3-Clause
!> Kinds of numbers, named once.
module sig_kinds
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none(type, external)
  private
  public :: rk, lk

  !> every real of the code
  integer, parameter :: rk = real64
  !> hashes and file offsets
  integer, parameter :: lk = int64
end module sig_kinds
