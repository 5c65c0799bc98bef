! SPDX-License-Identifier: BSD-3-Clause
!> Interfaces of include/signorom/linear_solver.h and snes_vi.h, where the arguments are explained.
module sig_solver_c_interfaces
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_intptr_t
  implicit none(type, external)
  private
  public :: sig_linear_solver_create, sig_linear_solver_change_unknowns, sig_linear_solver_hold, sig_linear_solver_factor_again
  public :: sig_linear_solver_solve, sig_linear_solver_keep_factor, sig_linear_solver_solve_many, sig_linear_solver_destroy
  public :: sig_set_linear_interpolant, sig_set_near_null_space, sig_linear_solver_solves_per_factorization, sig_snes_vi_solve

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

    function sig_linear_solver_hold(ksp, transformation, inverse, is_free, reason, message) result(status) bind(c)
      import :: c_char, c_int, c_intptr_t
      integer(c_intptr_t), value :: ksp, transformation, inverse, is_free
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

    function sig_set_linear_interpolant(matrix, n_dim, n_nodes, n_corners, offsets, corners_0) result(status) bind(c)
      import :: c_int, c_intptr_t
      integer(c_intptr_t), value :: matrix
      integer(c_int), value :: n_dim, n_nodes, n_corners
      integer(c_int), intent(in) :: offsets(*), corners_0(*)
      integer(c_int) :: status
    end function sig_set_linear_interpolant

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

    function sig_linear_solver_destroy(ksp) result(status) bind(c)
      import :: c_int, c_intptr_t
      integer(c_intptr_t), intent(inout) :: ksp
      integer(c_int) :: status
    end function sig_linear_solver_destroy

    function sig_snes_vi_solve(matrix, rhs, upper, length_scale, force_scale, is_multigrid, max_iterations, solution, &
      n_iterations, reason) result(status) bind(c)
      import :: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: matrix, rhs, upper, solution
      real(c_double), value :: length_scale, force_scale
      integer(c_int), value :: is_multigrid, max_iterations
      integer(c_int), intent(out) :: n_iterations, reason
      integer(c_int) :: status
    end function sig_snes_vi_solve
  end interface
end module sig_solver_c_interfaces
