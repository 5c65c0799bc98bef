! SPDX-License-Identifier: BSD-3-Clause
!> The kernels of OpenBLAS.
module sig_blas_kernels
  use sig_parallel_c_interfaces, only: sig_choose_blas_kernels
  implicit none(type, external)
  private
  public :: choose_blas_kernels

contains

  !> Starts the program again, with the same process id and arguments and with OPENBLAS_CORETYPE=Haswell, if OpenBLAS has taken its
  !> slowest kernels because it does not know the processor: factoring takes twice as long. Does nothing if the variable is
  !> set, if the processor is too old, or with another BLAS. Requires: MPI has not been started.
  subroutine choose_blas_kernels()
    call sig_choose_blas_kernels()
  end subroutine choose_blas_kernels
end module sig_blas_kernels
