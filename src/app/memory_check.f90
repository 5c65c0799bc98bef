! SPDX-License-Identifier: BSD-3-Clause
!> Too little memory, said in a sentence.
module sig_memory_check
  use, intrinsic :: iso_fortran_env, only: error_unit
  use sig_base_c_interfaces, only: sig_begin_memory_watch, sig_end_memory_watch, sig_memory_use, sig_need_memory
  use sig_kinds, only: rk
  use sig_lapack_interfaces, only: dgetrf
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: start_linear_algebra, hint_at_memory

contains

  !> Lets BLAS take its work space, which it keeps. OpenBLAS asks for it in a loop without an end where there is no memory for it:
  !> then, and where less is left than any command needs, the process ends with a sentence and exit code 2.
  subroutine start_linear_algebra()
    real(rk) :: matrix(1, 1)
    !> [bytes] what the smallest problems take, with room to spare: libraries that lack memory seldom say so
    real(rk), parameter :: least_room = 1.0e8_rk
    integer :: info, pivots(1)

    matrix = 1
    call sig_begin_memory_watch()
    call dgetrf(1, 1, matrix, 1, pivots, info)
    call sig_end_memory_watch()
    call sig_need_memory(least_room)
  end subroutine start_linear_algebra

  !> After an internal error: says so where the limit of memory was nearly reached. The libraries that fail then seldom say why.
  subroutine hint_at_memory()
    !> of the limit
    real(rk), parameter :: near = 0.8_rk
    real(rk) :: limit, peak

    call sig_memory_use(peak, limit)
    if (limit <= 0 .or. peak < near * limit) return
    write (error_unit, '(a)') 'hint: this process may take ' // to_text(nint(limit / 1.0e6_rk)) // &
      ' MB of address space (ulimit -v) and took ' // to_text(nint(peak / 1.0e6_rk)) // &
      ' MB: the cause is probably too little memory'
  end subroutine hint_at_memory
end module sig_memory_check
