! SPDX-License-Identifier: BSD-3-Clause
!> How much memory the machine has. Choices that depend on it take a share of the whole and not of what is free at the moment, so
!> that the same deck on the same machine always gets the same solver and the same kind of model.
module sig_memory
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_null_char
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: machine_memory, memory_text, sig_machine_memory, sig_memory_use

  !> [bytes] what a machine that does not tell its memory is taken to have
  real(rk), parameter :: usual_memory = 8.0e9_rk

  ! include/signorom/memory.h describes these procedures in C.
  interface
    subroutine sig_memory_use(peak, limit) bind(c)
      import :: c_double
      real(c_double), intent(out) :: peak, limit
    end subroutine sig_memory_use

    function sig_machine_memory(root) result(n_bytes) bind(c)
      import :: c_char, c_double
      character(kind=c_char), intent(in) :: root(*)
      real(c_double) :: n_bytes
    end function sig_machine_memory
  end interface

contains

  !> [bytes] Returns the memory of this machine. A limit of its control group (containers, batch systems) or of the address space of
  !> this process (ulimit -v) counts instead if it is smaller. It is 8e9 where the system does not tell it.
  real(rk) function machine_memory() result(n_bytes)
    real(rk) :: limit, peak

    n_bytes = sig_machine_memory(c_null_char)
    if (n_bytes <= 0) n_bytes = usual_memory
    call sig_memory_use(peak, limit)
    if (limit > 0) n_bytes = min(n_bytes, limit)
  end function machine_memory

  !> Returns a number of bytes as text for people: `12 MB`, `340 MB`, `1.3 GB`, `24 GB`.
  pure function memory_text(n_bytes) result(text)
    real(rk), intent(in) :: n_bytes
    character(:), allocatable :: text
    character(24) :: buffer

    if (n_bytes < 0.9995e9_rk) then
      write (buffer, '(i0, a)') nint(n_bytes / 1.0e6_rk), ' MB'
    else if (n_bytes < 9.95e9_rk) then
      write (buffer, '(f3.1, a)') n_bytes / 1.0e9_rk, ' GB'
    else
      write (buffer, '(i0, a)') nint(n_bytes / 1.0e9_rk), ' GB'
    end if
    text = trim(buffer)
  end function memory_text
end module sig_memory
