! SPDX-License-Identifier: BSD-3-Clause
!> Interfaces of the C code of this layer that needs no PETSc.
module sig_parallel_c_interfaces
  implicit none(type, external)
  private
  public :: sig_choose_blas_kernels

  interface
    subroutine sig_choose_blas_kernels() bind(c)
    end subroutine sig_choose_blas_kernels
  end interface
end module sig_parallel_c_interfaces
