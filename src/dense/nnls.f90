! SPDX-License-Identifier: BSD-3-Clause
!> Non-negative least squares: min |A x - b| over x >= 0.
module sig_nnls
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_kinds, only: rk
  use sig_lapack_interfaces, only: dgels
  implicit none(type, external)
  private
  public :: solve_nnls

  !> a unit column whose product with the residual is below this times |b| has nothing to add
  real(rk), parameter :: gradient_tolerance = 1.0e-12_rk
  !> an entry of R below this times the norm of its column: the column depends on the others
  real(rk), parameter :: rank_tolerance = 1.0e-10_rk
  !> coefficients that reach zero this close (relative) to the first one reach it together
  real(rk), parameter :: tie_tolerance = 1.0e-12_rk

contains

  !> Active set method; x is feasible at every step and the residual falls, so that it ends.
  !>
  !> Source: Lawson and Hanson, Solving least squares problems (1974), chapter 23. A column that depends on those in use stays
  !> out. Scaling a column scales its coefficient and changes nothing else.
  subroutine solve_nnls(matrix, rhs, x, residual_norm)
    !> A, shape (n_rows, n_columns)
    real(rk), intent(in) :: matrix(:, :)
    !> b, shape (n_rows)
    real(rk), intent(in) :: rhs(:)
    !> >= 0, shape (n_columns); zero when the data are not finite
    real(rk), intent(out) :: x(:)
    !> |A x - b|
    real(rk), intent(out) :: residual_norm
    real(rk), allocatable :: column_norms(:), gain(:), trial(:)
    real(rk) :: trial_norm
    logical, allocatable :: is_candidate(:), is_used(:), is_used_trial(:)
    integer :: entering

    x = 0
    residual_norm = norm2(rhs)
    if (size(rhs) == 0 .or. size(x) == 0) return
    if (.not. (all(ieee_is_finite(matrix)) .and. all(ieee_is_finite(rhs)))) return
    column_norms = norm2(matrix, dim=1)
    is_used = spread(.false., 1, size(x))
    is_candidate = column_norms > 0
    do
      gain = matmul(rhs - matmul(matrix, x), matrix)
      where (is_candidate) gain = gain / column_norms
      entering = maxloc(gain, dim=1, mask=is_candidate .and. .not. is_used)
      if (entering == 0) exit
      if (gain(entering) <= gradient_tolerance * norm2(rhs)) exit
      is_used_trial = is_used
      is_used_trial(entering) = .true.
      trial = x
      call improve(matrix, rhs, is_used_trial, trial)
      trial_norm = norm2(rhs - matmul(matrix, trial))
      is_candidate(entering) = trial_norm < residual_norm
      if (.not. is_candidate(entering)) cycle
      x = trial
      residual_norm = trial_norm
      is_used = is_used_trial
      is_candidate = column_norms > 0
    end do
  end subroutine solve_nnls

  !> Least squares on the columns in use; columns whose coefficient would turn negative leave one after the other.
  subroutine improve(matrix, rhs, is_used, x)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: rhs(:)
    logical, intent(inout) :: is_used(:)
    !> on entry feasible and zero outside the columns in use; unchanged when these are dependent
    real(rk), intent(inout) :: x(:)
    !> [-] how far each coefficient can go towards the solution before it is zero
    real(rk), allocatable :: reach(:)
    real(rk), allocatable :: solution(:)
    real(rk) :: step
    integer :: i_column
    integer, allocatable :: used(:)
    logical :: is_dependent

    do while (any(is_used))
      used = pack([(i_column, i_column=1, size(x))], is_used)
      call solve_columns(matrix(:, used), rhs, solution, is_dependent)
      if (is_dependent) return
      if (all(solution > 0)) then
        x(used) = solution
        return
      end if
      if (allocated(reach)) deallocate (reach)
      allocate (reach(size(used)), source=huge(step))
      where (solution <= 0) reach = x(used) / max(x(used) - solution, tiny(step))
      step = minval(reach)
      x(used) = x(used) + step * (solution - x(used))
      ! Round-off must not keep the column that ends the step.
      where (reach <= step * (1 + tie_tolerance) .or. x(used) < 0) x(used) = 0
      is_used(used) = x(used) > 0
    end do
  end subroutine improve

  !> Least squares by QR.
  subroutine solve_columns(columns, rhs, solution, is_dependent)
    real(rk), intent(in) :: columns(:, :)
    real(rk), intent(in) :: rhs(:)
    !> shape (size(columns, 2))
    real(rk), allocatable, intent(out) :: solution(:)
    !> there is no unique solution
    logical, intent(out) :: is_dependent
    real(rk), allocatable :: factors(:, :), norms(:), right(:), work(:)
    integer :: info, k, m, n

    m = size(columns, 1)
    n = size(columns, 2)
    is_dependent = n > m
    if (is_dependent) return
    norms = norm2(columns, dim=1)
    factors = columns / spread(norms, 1, m)
    right = rhs
    allocate (work(34 * n))
    call dgels('N', m, n, 1, factors, m, right, m, work, size(work), info)
    is_dependent = info /= 0 .or. any([(abs(factors(k, k)), k=1, n)] < rank_tolerance)
    solution = right(:n) / norms
  end subroutine solve_columns
end module sig_nnls
