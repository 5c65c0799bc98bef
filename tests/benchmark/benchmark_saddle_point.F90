! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> What a sweep costs without condensation: [K B'; B 0] factored by MUMPS in each step of an active set, at some training points.
!>
!> Arguments: deck, its snapshots.h5, number of points (spread evenly over the snapshots). One rank. Prints a line per point:
!> steps, CPU seconds, largest differences of u and lambda from the snapshot (relative to the largest entries of the sweep).
program benchmark_saddle_point
  use sig_contact_system, only: contact_system_t
  use sig_deck_config, only: deck_config_t
  use sig_deck_read, only: read_deck
  use sig_errors, only: error_list_t, error_report, error_t
  use sig_file_system, only: read_text_file
  use sig_kinds, only: rk
  use sig_linear_solver, only: constrain, linear_solver_t
  use sig_petsc_support, only: create_matrix, create_vector, end_petsc, insert_petsc_options, start_petsc
  use sig_problem, only: problem_t
  use sig_problem_loading, only: load_problem
  use sig_reasons, only: reason_converged
  use sig_snapshot_store, only: read_snapshot_set, snapshot_set_t
  use sig_term_values, only: evaluate_points
  use petsc
  implicit none(type, external)
  integer, parameter :: max_steps = 50
  character(1024) :: argument
  character(:), allocatable :: text
  type(deck_config_t) :: deck
  type(error_t), allocatable :: error
  type(error_list_t) :: errors
  type(problem_t) :: problem
  type(contact_system_t) :: system
  type(snapshot_set_t) :: snapshots
  real(rk), allocatable :: theta(:, :), displacement(:), multipliers(:)
  real(rk) :: start
  integer :: i, i_bad_point, i_bad_source, i_point, n_points, n_steps
  PetscErrorCode :: ierr

  PetscCallA(start_petsc(ierr))
  ! the ordering that MUMPS chooses by itself, as a program has it that leaves MUMPS alone
  PetscCallA(insert_petsc_options('-fom_mat_mumps_icntl_7 7', ierr))
  call get_command_argument(2, argument)
  call read_snapshot_set(trim(argument), '', snapshots, error)
  if (allocated(error)) error stop error_report(error)
  call get_command_argument(3, argument)
  read (argument, *) n_points
  call get_command_argument(1, argument)
  call read_text_file(trim(argument), text, error)
  if (allocated(error)) error stop error_report(error)
  call read_deck(trim(argument), text, deck, errors)
  if (errors%n_errors() > 0) error stop error_report(errors%errors(1))
  PetscCallA(load_problem(deck, PETSC_COMM_WORLD, problem, error, ierr))
  if (allocated(error)) error stop error_report(error)
  PetscCallA(system%create(PETSC_COMM_WORLD, problem%mesh, problem%body, problem%boundary, problem%rows, ierr))
  call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
  do i = 1, n_points
    i_point = 1 + nint((i - 1) * (size(theta, 2) - 1) / real(max(1, n_points - 1), rk))
    start = processor_time()
    PetscCallA(solve_point(theta(:, i_point), displacement, multipliers, n_steps, ierr))
    print '(i0, f9.4, 2es10.1)', n_steps, processor_time() - start, &
      maxval(abs(displacement - snapshots%displacement(:, i_point))) / maxval(abs(snapshots%displacement)), &
      maxval(abs(multipliers - snapshots%multipliers(:, i_point))) / maxval(abs(snapshots%multipliers))
  end do
  PetscCallA(system%destroy(ierr))
  PetscCallA(end_petsc(ierr))

contains

  !> Starts without contact; a pair closes when it penetrates and opens when it pulls.
  subroutine solve_point(theta, displacement, multipliers, n_steps, ierr)
    real(rk), intent(in) :: theta(:)
    real(rk), allocatable, intent(out) :: displacement(:)
    real(rk), allocatable, intent(out) :: multipliers(:)
    integer, intent(out) :: n_steps
    PetscErrorCode, intent(out) :: ierr
    !> [-] of the largest displacement or multiplier: rounding, which changes no status
    real(rk), parameter :: rounding = 1.0e-12_rk
    logical :: is_closed(system%rows%n_rows), next(system%rows%n_rows)
    real(rk) :: penetration(system%rows%n_rows)

    is_closed = .false.
    do n_steps = 1, max_steps
      PetscCall(solve_with_closed(theta, is_closed, displacement, multipliers, ierr))
      penetration = system%rows%apply(displacement) - system%gap(theta)
      next = merge(multipliers >= -rounding * maxval(abs(multipliers)), penetration > rounding * maxval(abs(displacement)), &
        is_closed)
      if (all(next .eqv. is_closed)) return
      is_closed = next
    end do
    error stop 'the active set did not settle'
  end subroutine solve_point

  !> K u + B' lambda = F, B u = D on the closed rows, lambda = 0 on the others.
  subroutine solve_with_closed(theta, is_closed, displacement, multipliers, ierr)
    real(rk), intent(in) :: theta(:)
    logical, intent(in) :: is_closed(:)
    real(rk), allocatable, intent(out) :: displacement(:)
    real(rk), allocatable, intent(out) :: multipliers(:)
    PetscErrorCode, intent(out) :: ierr
    type(linear_solver_t) :: linear_solver
    Mat :: constrained, saddle
    Vec :: rhs, whole, solution
    PetscScalar, pointer :: values(:)
    real(rk), allocatable :: answer(:)
    real(rk) :: scale
    integer :: n

    n = system%map%n_dofs
    PetscCall(constrain(system, system%stiffness, system%boundary%prescribed_dofs, system%prescribed_displacement(theta), system%load(theta), constrained, rhs, ierr))
    PetscCall(assemble_saddle(constrained, is_closed, scale, saddle, ierr))
    PetscCall(create_vector(PETSC_COMM_WORLD, n + size(is_closed), whole, ierr))
    PetscCall(VecDuplicate(whole, solution, ierr))
    allocate (answer(n))
    PetscCall(system%get(rhs, answer, ierr))
    PetscCall(VecGetArrayF90(whole, values, ierr))
    values(:n) = answer
    values(n + 1:) = merge(scale * (system%gap(theta) - system%rows%apply(system%prescribed_displacement(theta))), 0.0_rk, &
      is_closed)
    PetscCall(VecRestoreArrayF90(whole, values, ierr))
    PetscCall(linear_solver%factor(saddle, 'fom_', ierr))
    if (linear_solver%reason /= reason_converged) error stop 'the saddle point could not be factored'
    PetscCall(linear_solver%solve_vector(whole, 0.0_rk, solution, ierr))
    PetscCall(VecGetArrayReadF90(solution, values, ierr))
    displacement = values(:n)
    multipliers = scale * values(n + 1:)
    PetscCall(VecRestoreArrayReadF90(solution, values, ierr))
    PetscCall(linear_solver%destroy(ierr))
    PetscCall(MatDestroy(constrained, ierr))
    PetscCall(MatDestroy(saddle, ierr))
    PetscCall(VecDestroy(rhs, ierr))
    PetscCall(VecDestroy(whole, ierr))
    PetscCall(VecDestroy(solution, ierr))
  end subroutine solve_with_closed

  !> B is scaled to the size of K, so that the pivots are comparable.
  subroutine assemble_saddle(stiffness, is_closed, scale, saddle, ierr)
    Mat, intent(in) :: stiffness
    logical, intent(in) :: is_closed(:)
    !> [force/length]
    real(rk), intent(out) :: scale
    Mat, intent(out) :: saddle
    PetscErrorCode, intent(out) :: ierr
    integer, parameter :: max_row = 200
    integer :: columns(max_row), i, k, n, n_columns, n_entries(system%map%n_dofs + size(is_closed))
    real(rk) :: entries(max_row)
    real(rk), allocatable :: coefficients(:)

    n = system%map%n_dofs
    n_entries(:n) = 2
    n_entries(n + 1:) = system%rows%offsets(2:) - system%rows%offsets(:size(is_closed)) + 1
    do i = 0, n - 1
      PetscCall(MatGetRow(stiffness, i, n_columns, columns, entries, ierr))
      n_entries(i + 1) = n_entries(i + 1) + n_columns
      PetscCall(MatRestoreRow(stiffness, i, n_columns, columns, entries, ierr))
    end do
    PetscCall(create_matrix(PETSC_COMM_WORLD, size(n_entries), 1, n_entries, 0 * n_entries, saddle, ierr))
    scale = 0
    do i = 0, n - 1
      PetscCall(MatGetRow(stiffness, i, n_columns, columns, entries, ierr))
      scale = max(scale, maxval(abs(entries(:n_columns))))
      PetscCall(MatSetValues(saddle, 1, [i], n_columns, columns, entries, INSERT_VALUES, ierr))
      PetscCall(MatRestoreRow(stiffness, i, n_columns, columns, entries, ierr))
    end do
    do k = 1, size(is_closed)
      coefficients = merge(scale * system%rows%coefficients_of(k), 0.0_rk, is_closed(k) .and. &
        .not. system%boundary%is_prescribed(system%rows%dofs_of(k)))
      associate (dofs_0 => system%rows%dofs_of(k) - 1, row_0 => n + k - 1)
        PetscCall(MatSetValues(saddle, 1, [row_0], size(dofs_0), dofs_0, coefficients, INSERT_VALUES, ierr))
        PetscCall(MatSetValues(saddle, size(dofs_0), dofs_0, 1, [row_0], coefficients, INSERT_VALUES, ierr))
        PetscCall(MatSetValue(saddle, row_0, row_0, merge(0.0_rk, scale, is_closed(k)), INSERT_VALUES, ierr))
      end associate
    end do
    PetscCall(MatAssemblyBegin(saddle, MAT_FINAL_ASSEMBLY, ierr))
    PetscCall(MatAssemblyEnd(saddle, MAT_FINAL_ASSEMBLY, ierr))
    PetscCall(MatSetOption(saddle, MAT_SYMMETRIC, PETSC_TRUE, ierr))
  end subroutine assemble_saddle

  real(rk) function processor_time()
    call cpu_time(processor_time)
  end function processor_time
end program benchmark_saddle_point
