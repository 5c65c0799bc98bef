! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> A stiffness matrix made ready once for many right-hand sides: factored by MUMPS, or conjugate gradients with algebraic multigrid,
!> which needs far less memory in three dimensions.
module sig_linear_solver
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_intptr_t, c_null_char
  use sig_c_strings, only: from_c
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_log, only: log_warning
  use sig_petsc_support, only: create_vector, message_size
  use sig_reasons, only: reason_converged, reason_floating_body, reason_linear_solver
  use petsc
  implicit none(type, external)
  private
  public :: coupled_system_t, linear_solver_t, constrain, hold, reason_of, set_near_null_space

  !> A linear solver for one matrix, or with multigrid for T' K T of many sets of held unknowns. Set is_multigrid, call factor, then
  !> the solve procedures, then destroy.
  type :: linear_solver_t
    !> whether conjugate gradients with multigrid solve, and not a factorization
    logical :: is_multigrid = .false.
    !> PETSc's KSP; 0 before `factor`
    integer(c_intptr_t) :: ksp = 0
    !> reason_converged, or why there is no solution; 0 before `factor`
    integer :: reason = 0
    !> number of iterations of conjugate gradients in the last solve_vector
    integer :: n_iterations = 0
  contains
    procedure :: factor
    procedure :: change_unknowns
    procedure :: hold_unknowns
    procedure :: factor_again
    procedure :: solves_per_factorization
    procedure :: keep_factor
    procedure :: solve_many
    procedure :: solve_vector
    procedure :: solve_coupled
    procedure :: destroy
  end type linear_solver_t

  !> A linear system A x + E A x + Z x = f of free unknowns, where E and Z couple unknowns of a contact.
  type :: coupled_system_t
    !> A, only where K is factored; multigrid has its own
    Mat :: stiffness
    !> 1 for free unknowns, 0 for held ones
    Vec :: is_free
    !> Z [force/length], and E [-]; without E the system is symmetric
    Mat :: springs
    Mat :: coupling
    logical :: has_springs = .false.
    logical :: has_coupling = .false.
  end type coupled_system_t

  !> values of linear_solver.h
  integer(c_int), parameter :: kind_cholesky = 1
  integer(c_int), parameter :: kind_multigrid = 2
  integer(c_int), parameter :: is_singular = -2

  ! include/signorom/linear_solver.h describes these procedures in C.
  interface
    function sig_linear_solver_create(matrix, prefix, kind, ksp, reason, message) result(status) bind(c)
      import :: c_char, c_int, c_intptr_t
      integer(c_intptr_t), value :: matrix
      character(kind=c_char), intent(in) :: prefix(*)
      integer(c_int), value :: kind
      integer(c_intptr_t), intent(out) :: ksp
      integer(c_int), intent(out) :: reason
      character(kind=c_char), intent(out) :: message(*)
      integer(c_int) :: status
    end function sig_linear_solver_create

    function sig_linear_solver_change_unknowns(ksp, transformation, inverse, mark, reason, message) result(status) bind(c)
      import :: c_char, c_int, c_intptr_t
      integer(c_intptr_t), value :: ksp, transformation, inverse, mark
      integer(c_int), intent(out) :: reason
      character(kind=c_char), intent(out) :: message(*)
      integer(c_int) :: status
    end function sig_linear_solver_change_unknowns

    function sig_linear_solver_hold(ksp, transformation, inverse, is_free, springs, reason, message) result(status) bind(c)
      import :: c_char, c_int, c_intptr_t
      integer(c_intptr_t), value :: ksp, transformation, inverse, is_free, springs
      integer(c_int), intent(out) :: reason
      character(kind=c_char), intent(out) :: message(*)
      integer(c_int) :: status
    end function sig_linear_solver_hold

    function sig_linear_solver_factor_again(ksp, reason, message) result(status) bind(c)
      import :: c_char, c_int, c_intptr_t
      integer(c_intptr_t), value :: ksp
      integer(c_int), intent(out) :: reason
      character(kind=c_char), intent(out) :: message(*)
      integer(c_int) :: status
    end function sig_linear_solver_factor_again

    function sig_linear_solver_solves_per_factorization(ksp, n_solves) result(status) bind(c)
      import :: c_int, c_intptr_t
      integer(c_intptr_t), value :: ksp
      integer(c_int), intent(out) :: n_solves
      integer(c_int) :: status
    end function sig_linear_solver_solves_per_factorization

    function sig_linear_solver_keep_factor(ksp, max_iterations) result(status) bind(c)
      import :: c_int, c_intptr_t
      integer(c_intptr_t), value :: ksp
      integer(c_int), value :: max_iterations
      integer(c_int) :: status
    end function sig_linear_solver_keep_factor

    function sig_set_near_null_space(matrix, n_modes, n_local, modes) result(status) bind(c)
      import :: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: matrix
      integer(c_int), value :: n_modes, n_local
      real(c_double), intent(in) :: modes(*)
      integer(c_int) :: status
    end function sig_set_near_null_space

    function sig_linear_solver_solve_many(ksp, n_columns, n_local, rhs, solution, reason) result(status) bind(c)
      import :: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: ksp
      integer(c_int), value :: n_columns, n_local
      real(c_double), intent(in) :: rhs(*)
      real(c_double), intent(out) :: solution(*)
      integer(c_int), intent(out) :: reason
      integer(c_int) :: status
    end function sig_linear_solver_solve_many

    function sig_linear_solver_solve(ksp, rhs, tolerance, solution, n_iterations, reason) result(status) bind(c)
      import :: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: ksp, rhs, solution
      real(c_double), value :: tolerance
      integer(c_int), intent(out) :: n_iterations, reason
      integer(c_int) :: status
    end function sig_linear_solver_solve

    function sig_linear_solver_solve_coupled(ksp, stiffness, is_free, springs, coupling, rhs, reduction, size_of_rhs, &
      solution, n_iterations, reason) result(status) bind(c)
      import :: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: ksp, stiffness, is_free, springs, coupling, rhs, solution
      real(c_double), value :: reduction
      real(c_double), intent(inout) :: size_of_rhs
      integer(c_int), intent(out) :: n_iterations, reason
      integer(c_int) :: status
    end function sig_linear_solver_solve_coupled

    function sig_linear_solver_destroy(ksp) result(status) bind(c)
      import :: c_int, c_intptr_t
      integer(c_intptr_t), intent(inout) :: ksp
      integer(c_int) :: status
    end function sig_linear_solver_destroy
  end interface

contains

  !> Copies a matrix and sets the rows and columns of some dofs to zero, except for the diagonal (see hold); makes the right-hand
  !> side for which these dofs take their values. Collective.
  subroutine constrain(system, matrix, dofs, values, forces, constrained, rhs, ierr)
    type(contact_system_t), intent(in) :: system
    !> the matrix to copy, which does not change
    Mat, intent(in) :: matrix
    !> held dofs, natural
    integer, intent(in) :: dofs(:)
    !> [length] natural, shape (n_dofs); read on `dofs` only
    real(rk), intent(in) :: values(:)
    !> [force] natural, shape (n_dofs)
    real(rk), intent(in) :: forces(:)
    !> the caller destroys both
    Mat, intent(out) :: constrained
    Vec, intent(out) :: rhs
    PetscErrorCode, intent(out) :: ierr

    PetscCall(MatDuplicate(matrix, MAT_COPY_VALUES, constrained, ierr))
    PetscCall(create_vector(system%comm, system%map%n_local_dofs, rhs, ierr))
    PetscCall(system%put(forces, rhs, ierr))
    PetscCall(hold(system, dofs, values, constrained, rhs, ierr))
  end subroutine constrain

  !> Holds dofs at given values: sets their rows and columns of the matrix to zero, except for the diagonal, where the mean of all
  !> diagonal entries stands then, and adapts the right-hand side. The matrix keeps its pattern. Collective.
  subroutine hold(system, dofs, values, matrix, rhs, ierr)
    type(contact_system_t), intent(in) :: system
    !> held dofs, natural
    integer, intent(in) :: dofs(:)
    !> [length] natural, shape (n_dofs); read on `dofs` only
    real(rk), intent(in) :: values(:)
    !> symmetric
    Mat, intent(inout) :: matrix
    Vec, intent(inout) :: rhs
    PetscErrorCode, intent(out) :: ierr
    Vec :: prescribed
    integer, allocatable :: own_dofs_0(:)
    real(rk) :: diagonal

    own_dofs_0 = system%map%distributed_0(dofs)
    own_dofs_0 = pack(own_dofs_0, own_dofs_0 >= system%map%first_dof_0 .and. &
      own_dofs_0 < system%map%first_dof_0 + system%map%n_local_dofs)
    PetscCall(VecDuplicate(rhs, prescribed, ierr))
    PetscCall(MatGetDiagonal(matrix, prescribed, ierr))
    PetscCall(VecSum(prescribed, diagonal, ierr))
    diagonal = diagonal / system%map%n_dofs
    PetscCall(system%put(values, prescribed, ierr))
    PetscCall(MatZeroRowsColumns(matrix, size(own_dofs_0), own_dofs_0, diagonal, prescribed, rhs, ierr))
    PetscCall(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE, ierr))
    PetscCall(VecDestroy(prescribed, ierr))
  end subroutine hold

  !> Prepares solves: frees what an earlier call made, and factors the matrix, or, if is_multigrid is set, builds the levels. The
  !> solver keeps the matrix alive, so the caller may destroy its own handle. A matrix that MUMPS finds singular
  !> (reason_floating_body) and other failures of MUMPS or PETSc (reason_linear_solver, with a warning) are reasons, not errors.
  !> Multigrid does not find a singular matrix. Collective.
  subroutine factor(self, matrix, prefix, ierr)
    class(linear_solver_t), intent(inout) :: self
    !> symmetric, with blocks of n_dim rows
    Mat, intent(in) :: matrix
    !> prefix of the PETSc options, such as `fom_`
    character(*), intent(in) :: prefix
    PetscErrorCode, intent(out) :: ierr
    character(kind=c_char) :: message(message_size)
    integer(c_int) :: reason

    PetscCall(self%destroy(ierr))
    ierr = sig_linear_solver_create(matrix%v, prefix // c_null_char, merge(kind_multigrid, kind_cholesky, self%is_multigrid), &
      self%ksp, reason, message)
    call take_result(self, reason, 'the linear solver (' // prefix // ')', from_c(message))
  end subroutine factor

  !> Makes a solver with multigrid for K solve from here on for unknowns x, u = T x, some of which are held: call hold_unknowns,
  !> then and each time they change. The levels keep the interpolations that `factor` made. Sets the reason, as
  !> factor does. Requires: factor has succeeded. Collective.
  subroutine change_unknowns(self, system, transformation, inverse, ierr)
    class(linear_solver_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    !> T and its inverse, with the patterns of all later ones
    Mat, intent(in) :: transformation
    Mat, intent(in) :: inverse
    PetscErrorCode, intent(out) :: ierr
    character(kind=c_char) :: message(message_size)
    integer(c_int) :: reason
    Vec :: mark

    PetscCall(create_vector(system%comm, system%map%n_local_dofs, mark, ierr))
    PetscCall(system%put(merge(1.0_rk, 0.0_rk, system%boundary%is_prescribed), mark, ierr))
    ierr = sig_linear_solver_change_unknowns(self%ksp, transformation%v, inverse%v, mark%v, reason, message)
    CHKERRQ(ierr)
    call take_result(self, reason, 'the linear solver', from_c(message))
    PetscCall(VecDestroy(mark, ierr))
  end subroutine change_unknowns

  !> Makes a solver with multigrid solve T' K T x = f for the free unknowns x; held ones are zero. Sets the reason, as factor does.
  !> Requires: change_unknowns. Collective.
  subroutine hold_unknowns(self, system, transformation, inverse, dofs, ierr, springs)
    class(linear_solver_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    !> T, which the solver keeps, and its inverse
    Mat, intent(in) :: transformation
    Mat, intent(in) :: inverse
    !> held unknowns, natural: prescribed dofs, or such that some T changes
    integer, intent(in) :: dofs(:)
    PetscErrorCode, intent(out) :: ierr
    !> [force/length] between unknowns of a contact that T changes, always with the same pattern; default: none
    Mat, intent(in), optional :: springs
    integer(c_intptr_t) :: springs_or_none
    character(kind=c_char) :: message(message_size)
    integer(c_int) :: reason
    logical :: is_held(system%map%n_dofs)
    Vec :: free_unknowns

    is_held = .false.
    is_held(dofs) = .true.
    PetscCall(create_vector(system%comm, system%map%n_local_dofs, free_unknowns, ierr))
    PetscCall(system%put(merge(0.0_rk, 1.0_rk, is_held), free_unknowns, ierr))
    springs_or_none = 0
    if (present(springs)) springs_or_none = springs%v
    ierr = sig_linear_solver_hold(self%ksp, transformation%v, inverse%v, free_unknowns%v, springs_or_none, reason, message)
    call take_result(self, reason, 'the linear solver', from_c(message))
    PetscCall(VecDestroy(free_unknowns, ierr))
  end subroutine hold_unknowns

  !> Factors again after new values in the matrix, whose pattern stays: MUMPS keeps its ordering. After keep_factor, MUMPS solves
  !> directly again. Sets the reason, as factor does. Requires: factor. Collective.
  subroutine factor_again(self, ierr)
    class(linear_solver_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr
    character(kind=c_char) :: message(message_size)
    integer(c_int) :: reason

    ierr = sig_linear_solver_factor_again(self%ksp, reason, message)
    call take_result(self, reason, 'the linear solver', from_c(message))
  end subroutine factor_again

  !> Estimates how many solves take as long as one factorization, at most 1000; 0 if MUMPS has not factored the matrix. Requires:
  !> factor. Collective.
  subroutine solves_per_factorization(self, n_solves, ierr)
    class(linear_solver_t), intent(in) :: self
    integer, intent(out) :: n_solves
    PetscErrorCode, intent(out) :: ierr

    ierr = sig_linear_solver_solves_per_factorization(self%ksp, n_solves)
  end subroutine solves_per_factorization

  !> Makes the old factor the preconditioner of conjugate gradients after new values in the matrix, whose pattern stays, until the
  !> next factor_again. A solve that needs more than max_iterations fails with reason_linear_solver. Collective.
  subroutine keep_factor(self, max_iterations, ierr)
    class(linear_solver_t), intent(inout) :: self
    integer, intent(in) :: max_iterations
    PetscErrorCode, intent(out) :: ierr

    ierr = sig_linear_solver_keep_factor(self%ksp, max_iterations)
  end subroutine keep_factor

  !> Sets the reason, and warns of a failure.
  subroutine take_result(self, reason, name, message)
    class(linear_solver_t), intent(inout) :: self
    !> one of SIG_LINEAR_* of linear_solver.h
    integer(c_int), intent(in) :: reason
    !> who failed
    character(*), intent(in) :: name
    character(*), intent(in) :: message

    self%reason = reason_of(reason)
    if (self%reason == reason_linear_solver) call log_warning(name // ': ' // message)
  end subroutine take_result

  !> Returns the reason of a linear solver.
  pure integer function reason_of(reason)
    !> one of SIG_LINEAR_* of linear_solver.h
    integer(c_int), intent(in) :: reason

    reason_of = reason_linear_solver
    if (reason > 0) reason_of = reason_converged
    if (reason == is_singular) reason_of = reason_floating_body
  end function reason_of

  !> Gives a matrix, before multigrid is built for it, the fields that have nearly no energy: the rigid motions of all bodies as
  !> one. Each aggregate takes its part of them. Collective.
  subroutine set_near_null_space(system, matrix, ierr)
    type(contact_system_t), intent(in) :: system
    !> matrix whose unknowns are displacements
    Mat, intent(inout) :: matrix
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: modes(system%map%n_local_dofs, system%motions%n_common()), mode(system%map%n_dofs)
    integer :: i

    do i = 1, size(modes, 2)
      mode = system%motions%common_field(i)
      modes(:, i) = mode(system%map%local_dofs)
    end do
    ierr = sig_set_near_null_space(matrix%v, size(modes, 2), size(modes, 1), modes)
  end subroutine set_near_null_space

  !> Solves for several right-hand sides: by the factor, or by conjugate gradients with multigrid to the tightest tolerance.
  !> Arrays hold the rows of this rank. Sets the reason: it is reason_linear_solver if conjugate gradients fail for a column; this
  !> column and those after it are then of no use. The reason of an earlier call is lost. Requires: factor has succeeded, and
  !> keep_factor was not called. Collective.
  subroutine solve_many(self, rhs, solution, ierr)
    class(linear_solver_t), intent(inout) :: self
    !> [force] shape (n_local_dofs, n_columns)
    real(rk), contiguous, intent(in) :: rhs(:, :)
    !> [length] same shape
    real(rk), contiguous, intent(out) :: solution(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer(c_int) :: reason

    ierr = sig_linear_solver_solve_many(self%ksp, size(rhs, 2), size(rhs, 1), rhs, solution, reason)
    self%reason = reason_of(reason)
  end subroutine solve_many

  !> Solves for one right-hand side: by the factor, or by conjugate gradients (multigrid, or after keep_factor). Sets the reason,
  !> and n_iterations, which is 0 with the factor. Requires: factor has succeeded. Collective.
  subroutine solve_vector(self, rhs, tolerance, solution, ierr)
    class(linear_solver_t), intent(inout) :: self
    !> [force]
    Vec, intent(in) :: rhs
    !> [-] relative tolerance of conjugate gradients; 0: the tightest one, that of the options
    real(rk), intent(in) :: tolerance
    !> in: start of conjugate gradients; out: the solution
    Vec, intent(inout) :: solution
    PetscErrorCode, intent(out) :: ierr
    integer(c_int) :: n_iterations, reason

    ierr = sig_linear_solver_solve(self%ksp, rhs%v, tolerance, solution%v, n_iterations, reason)
    self%n_iterations = n_iterations
    self%reason = reason_of(reason)
  end subroutine solve_vector

  !> Solves a coupled system by iterations, with the last factor or multigrid as preconditioner. They begin with the given solution.
  !> Sets the reason and n_iterations. Requires: factor has succeeded; with multigrid hold_unknowns, for nearly the same held
  !> unknowns. Collective.
  subroutine solve_coupled(self, coupled, rhs, reduction, size_of_rhs, solution, ierr)
    class(linear_solver_t), intent(inout) :: self
    type(coupled_system_t), intent(in) :: coupled
    !> [force] 0 for held unknowns
    Vec, intent(in) :: rhs
    !> [-] by which the residual falls; 0: to the tightest tolerance
    real(rk), intent(in) :: reduction
    !> size of the right-hand side, for the tightest tolerance; measured where it is 0, or reduction is
    real(rk), intent(inout) :: size_of_rhs
    !> in: start; out: the solution; 0 for held unknowns
    Vec, intent(inout) :: solution
    PetscErrorCode, intent(out) :: ierr
    integer(c_int) :: n_iterations, reason
    integer(c_intptr_t) :: coupling, springs, stiffness

    stiffness = 0
    springs = 0
    coupling = 0
    if (.not. self%is_multigrid) stiffness = coupled%stiffness%v
    if (coupled%has_springs) springs = coupled%springs%v
    if (coupled%has_coupling) coupling = coupled%coupling%v
    ierr = sig_linear_solver_solve_coupled(self%ksp, stiffness, coupled%is_free%v, springs, coupling, rhs%v, reduction, &
      size_of_rhs, solution%v, n_iterations, reason)
    self%n_iterations = n_iterations
    self%reason = reason_of(reason)
  end subroutine solve_coupled

  !> Frees the solver; one that was not made is no error. The reason stays. Collective.
  subroutine destroy(self, ierr)
    class(linear_solver_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (self%ksp /= 0) ierr = sig_linear_solver_destroy(self%ksp)
  end subroutine destroy
end module sig_linear_solver
