! SPDX-License-Identifier: BSD-3-Clause
!> The balance A lambda = b between the contact forces and the loads on bodies that only contact holds: for each free rigid motion,
!> the contact forces and the loads do no work together.
module sig_force_balance
  use sig_kinds, only: rk
  use sig_linear_algebra, only: solve_dense
  implicit none(type, external)
  private
  public :: balance_forces, balance_loaded_forces, keep_balance

  !> [-] the steps end when A lambda - b is at most this, relative to the terms of its sum
  real(rk), parameter :: rounding = 1.0e-13_rk
  !> [-] forces count as balanced when A lambda - b is at most this, relative to the terms of its sum
  real(rk), parameter :: balanced = 1.0e-11_rk
  integer, parameter :: most_steps = 50
  !> [-] what Newton's steps leave of A lambda - b counts as rounding if it is at most this, relative to the terms of its sum
  real(rk), parameter :: nearly_balanced = 1.0e-6_rk
  integer, parameter :: most_corrections = 3
  !> [-] this fraction of the trace of A A' is added to the diagonal in Newton's method, so that a step exists where the loaded rows
  !> do not hold the bodies
  real(rk), parameter :: damping = 1.0e-10_rk

contains

  !> Replaces forces lambda_r by the nearest ones with lambda >= 0 and A lambda = b. For lambda_r on all contact rows, the exact
  !> contact forces have these properties, too, and the set of such forces is convex. The Euclidean error of the forces does not
  !> become larger then.
  !>
  !> The result is lambda(y) = max(0, lambda_r + A' y), where y minimizes |lambda(y)|^2/2 - b'y. This function is convex and has the
  !> gradient A lambda(y) - b. The method is Newton's with step halving. Local.
  subroutine balance_forces(matrix, work, forces, is_balanced)
    !> A', the work that a unit force of each row does against each free motion (how much the motion closes the row), shape (n,
    !> n_motions). A row is a contact row, or stands for a pattern of forces on several contact rows
    real(rk), intent(in) :: matrix(:, :)
    !> b, work of the loads on each free motion, shape (n_motions)
    real(rk), intent(in) :: work(:)
    !> [force] in: lambda_r >= 0; out: the balanced forces, if is_balanced; shape (n)
    real(rk), intent(inout) :: forces(:)
    !> false where no non-negative forces with this balance (keep_balance) are found; then the forces do not change
    logical, intent(out) :: is_balanced
    real(rk) :: y(size(work)), step(size(work)), rest(size(work)), given(size(forces)), value, length
    logical :: is_singular
    integer :: i_step

    given = forces
    y = 0
    do i_step = 0, most_steps
      rest = matmul(forces, matrix) - work
      is_balanced = all(abs(rest) <= rounding * (matmul(forces, abs(matrix)) + abs(work)))
      if (is_balanced .or. i_step == most_steps) exit
      call solve_dense(curvature(matrix, forces > 0), -rest, step, is_singular)
      if (is_singular) exit
      value = dual(forces, y)
      length = 1
      do while (length > epsilon(length))
        forces = max(0.0_rk, given + matmul(matrix, y + length * step))
        if (dual(forces, y + length * step) <= value + 1.0e-4_rk * length * dot_product(rest, step) + rounding * abs(value)) exit
        length = length / 2
      end do
      y = y + length * step
    end do
    if (.not. is_balanced) call correct_rounding(matrix, work, forces, is_balanced)
    if (.not. is_balanced) forces = given

  contains

    pure real(rk) function dual(forces, y)
      real(rk), intent(in) :: forces(:)
      real(rk), intent(in) :: y(:)

      dual = dot_product(forces, forces) / 2 - dot_product(work, y)
    end function dual
  end subroutine balance_forces

  !> Removes what rounding leaves of A lambda - b: where y is large, lambda_r + A' y loses digits. Changes only forces above 0, as
  !> little as possible, and nothing if more is left than rounding (nearly_balanced). is_balanced is true if the forces balance the
  !> loads afterwards (keep_balance).
  subroutine correct_rounding(matrix, work, forces, is_balanced)
    !> as for balance_forces
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: work(:)
    real(rk), intent(inout) :: forces(:)
    logical, intent(out) :: is_balanced
    real(rk) :: rest(size(work)), step(size(work))
    logical :: is_singular
    integer :: i

    do i = 0, most_corrections
      is_balanced = keep_balance(matrix, work, forces)
      if (is_balanced .or. i == most_corrections) return
      rest = matmul(forces, matrix) - work
      if (any(abs(rest) > nearly_balanced * (matmul(forces, abs(matrix)) + abs(work)))) return
      call solve_dense(curvature(matrix, forces > 0), -rest, step, is_singular)
      if (is_singular) return
      where (forces > 0) forces = max(0.0_rk, forces + matmul(matrix, step))
    end do
  end subroutine correct_rounding

  !> Does the same as balance_forces, but zeros stay zero if the other forces can carry the loads: contacts that are open stay open.
  !> If they cannot, all forces may change. Local.
  subroutine balance_loaded_forces(matrix, work, forces, is_balanced)
    !> as for balance_forces
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: work(:)
    real(rk), intent(inout) :: forces(:)
    logical, intent(out) :: is_balanced
    integer, allocatable :: loaded(:)
    real(rk), allocatable :: loaded_forces(:)
    integer :: i

    loaded = pack([(i, i=1, size(forces))], forces > 0)
    loaded_forces = forces(loaded)
    call balance_forces(matrix(loaded, :), work, loaded_forces, is_balanced)
    if (is_balanced) then
      forces(loaded) = loaded_forces
    else
      call balance_forces(matrix, work, forces, is_balanced)
    end if
  end subroutine balance_loaded_forces

  !> Whether the forces balance the loads: each component of A lambda - b is at most 1e-11 times the sum of the absolute values of
  !> its terms. True without motions. `matrix` is A' and `work` is b, as for balance_forces.
  pure logical function keep_balance(matrix, work, forces)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: work(:)
    !> [force] >= 0
    real(rk), intent(in) :: forces(:)

    keep_balance = all(abs(matmul(forces, matrix) - work) <= balanced * (matmul(forces, abs(matrix)) + abs(work)))
  end function keep_balance

  !> Returns A D A' with a small addition to its diagonal (`damping`), where `matrix` is A', and D selects the rows with is_loaded.
  pure function curvature(matrix, is_loaded) result(square)
    real(rk), intent(in) :: matrix(:, :)
    logical, intent(in) :: is_loaded(:)
    real(rk) :: square(size(matrix, 2), size(matrix, 2))
    integer :: i, j
    real(rk) :: shift

    shift = damping * sum(matrix**2)
    do j = 1, size(square, 2)
      do i = 1, size(square, 1)
        square(i, j) = sum(matrix(:, i) * matrix(:, j), mask=is_loaded)
      end do
      square(j, j) = square(j, j) + shift
    end do
  end function curvature
end module sig_force_balance
