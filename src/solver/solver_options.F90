! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Finds PETSc options of the contact solver in use that nothing has read, after the first point and not after the last one.
module sig_solver_options
  use sig_errors, only: error_t, make_error
  use sig_petsc_support, only: unused_petsc_options
  use sig_text, only: string_t
  use petsc
  implicit none(type, external)
  private
  public :: refuse_unused_options

contains

  !> Makes an error if there is a PETSc option with the prefix of this solver that no object on this rank has used; the error names
  !> the first such option. Otherwise error is not allocated. Requires: this rank has taken part in solving a point by this solver,
  !> so that every object of the solver has read its options. Only then the result is the same on every rank. Local.
  subroutine refuse_unused_options(solver_type, error, ierr)
    !> active_set, snesvi or condensed
    character(*), intent(in) :: solver_type
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(string_t), allocatable :: options(:)
    integer :: i

    PetscCall(unused_petsc_options(options, ierr))
    do i = 1, size(options)
      if (index(options(i)%text, prefix_of(solver_type)) /= 1) cycle
      call make_error(error, 'the PETSc option ' // options(i)%text // ' was not used', &
        hint='check its name and solver.linear: options of conjugate gradients or multigrid need gamg, those of MUMPS need ' // &
        'cholesky. The run stopped after the first points.')
      return
    end do
  end subroutine refuse_unused_options

  !> Returns the prefix of the options of a solver, with its minus: `-active_set_`, `-vi_` for snesvi, `-fom_` for all others.
  pure function prefix_of(solver_type) result(prefix)
    character(*), intent(in) :: solver_type
    character(:), allocatable :: prefix

    select case (solver_type)
    case ('active_set')
      prefix = '-active_set_'
    case ('snesvi')
      prefix = '-vi_'
    case default
      prefix = '-fom_'
    end select
  end function prefix_of
end module sig_solver_options
