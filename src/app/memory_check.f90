! SPDX-License-Identifier: BSD-3-Clause
!> Messages for the case that the process has too little memory.
module sig_memory_check
  use, intrinsic :: iso_c_binding, only: c_double
  use, intrinsic :: iso_fortran_env, only: error_unit
  use sig_kinds, only: rk
  use sig_lapack_interfaces, only: dgetrf
  use sig_memory, only: sig_memory_use
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: start_linear_algebra, hint_at_memory

  ! include/signorom/memory.h describes these procedures in C.
  interface
    subroutine sig_return_large_blocks() bind(c)
    end subroutine sig_return_large_blocks

    subroutine sig_begin_memory_watch() bind(c)
    end subroutine sig_begin_memory_watch

    subroutine sig_end_memory_watch() bind(c)
    end subroutine sig_end_memory_watch

    subroutine sig_need_memory(n_bytes) bind(c)
      import :: c_double
      real(c_double), value :: n_bytes
    end subroutine sig_need_memory
  end interface

contains

  !> Calls LAPACK once, so that BLAS allocates its work space, which it keeps. Without enough memory OpenBLAS would try this without
  !> an end. In this case, and if less than 100 MB are left of a limit of address space (ulimit -v), the process ends with a message
  !> and exit code 2. From here on, large blocks of memory go back to the system when they are freed.
  subroutine start_linear_algebra()
    real(rk) :: matrix(1, 1)
    !> [bytes] more than the smallest problems take; libraries that run out of memory seldom say so
    real(rk), parameter :: least_room = 1.0e8_rk
    integer :: info, pivots(1)

    matrix = 1
    call sig_return_large_blocks()
    call sig_begin_memory_watch()
    call dgetrf(1, 1, matrix, 1, pivots, info)
    call sig_end_memory_watch()
    call sig_need_memory(least_room)
  end subroutine start_linear_algebra

  !> After an internal error: prints a hint to the standard error if this process used 80 % or more of its limit of address space
  !> (ulimit -v) at some time. Without such a limit it prints nothing. Libraries that run out of memory seldom say so.
  subroutine hint_at_memory()
    !> [-] share of the limit from which on the hint is printed
    real(rk), parameter :: near = 0.8_rk
    real(rk) :: limit, peak

    call sig_memory_use(peak, limit)
    if (limit <= 0 .or. peak < near * limit) return
    write (error_unit, '(a)') 'hint: this process may take ' // to_text(nint(limit / 1.0e6_rk)) // &
      ' MB of address space (ulimit -v) and took ' // to_text(nint(peak / 1.0e6_rk)) // &
      ' MB: the cause is probably too little memory'
  end subroutine hint_at_memory
end module sig_memory_check
