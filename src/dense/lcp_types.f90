! SPDX-License-Identifier: BSD-3-Clause
!> What the methods for the linear complementarity problem share: the answer, its reasons, their room, one index set.
module sig_lcp_types
  use sig_bits, only: n_words
  use sig_dense_kernels, only: factor_cholesky, factor_lu, reciprocal_condition_cholesky, reciprocal_condition_lu, &
    solve_cholesky, solve_lu
  use sig_kinds, only: rk
  use sig_linear_algebra, only: singular_reciprocal
  use sig_reasons, only: reason_not_finite
  implicit none(type, external)
  private
  public :: lcp_solution_t, lcp_workspace_t, lcp_method_name, evaluate_set, sum_rows

  !> method that gave the answer (or tried last)
  integer, parameter, public :: lcp_active_set = 1
  integer, parameter, public :: lcp_block_pivoting = 2
  integer, parameter, public :: lcp_lemke = 3

  !> A sign is wrong only beyond this times the size of what was summed, so that ties do not flicker by round-off.
  real(rk), parameter, public :: sign_tolerance = 1.0e-12_rk
  !> an ill-conditioned set widens the tolerance up to here
  real(rk), parameter :: widest_tolerance = 1.0e-8_rk
  !> smallest over largest pivot above which the condition number is asked for only where it decides
  real(rk), parameter :: trusted_pivots = 1.0e-6_rk
  !> an active set that needs more sets than this, and than unknowns, is left to block pivoting
  integer, parameter, public :: usual_sets = 50

  !> Answer of 0 <= lambda _|_ W lambda + q >= 0.
  type :: lcp_solution_t
    !> [unit of W^-1 q] >= 0, shape (n)
    real(rk), allocatable :: lambda(:)
    !> lambda > 0, shape (n)
    logical, allocatable :: is_active(:)
    !> lcp_active_set, lcp_block_pivoting or lcp_lemke
    integer :: method = lcp_active_set
    !> one of sig_reasons
    integer :: reason = reason_not_finite
    !> linear solves and pivots of all the methods tried
    integer :: n_iterations = 0
    !> [-] largest violation of the conditions, relative to what is summed in its row; huge without an answer
    real(rk) :: residual = huge(1.0_rk)
  end type lcp_solution_t

  !> Room for one problem after the other: it grows with the largest, and then nothing is allocated any more. One per thread.
  type :: lcp_workspace_t
    !> unknowns for which there is room
    integer :: capacity = 0
    !> lambda and w of the index set looked at last, shape (capacity); zero outside and inside the set
    real(rk), allocatable :: lambda(:)
    real(rk), allocatable :: w(:)
    !> what each row of w sums, without signs, shape (capacity)
    real(rk), allocatable :: row_size(:)
    !> signs that are wrong beyond the tolerance, shape (capacity)
    logical, allocatable :: is_violated(:)
    !> the set's matrix has no inverse; lambda, w and is_violated are not defined then
    logical :: is_singular = .false.
    !> W is symmetric: its sets are factored by Cholesky, which takes half the work
    logical :: is_symmetric = .false.
    !> the set's factors are Cholesky's
    logical :: is_cholesky = .false.
    !> sets already seen, as bits, shape (n_words, n_sets)
    integer, allocatable :: history(:, :)
    !> factors of the set's matrix, its indices, room for a right side and for an estimate of its condition number
    real(rk), allocatable :: factors(:, :)
    integer, allocatable :: active(:)
    integer, allocatable :: pivots(:)
    real(rk), allocatable :: work(:)
    integer, allocatable :: signs(:)
    !> Lemke: columns of w, lambda, z0 and the values; variable of each row; room for one column and the ratios
    real(rk), allocatable :: tableau(:, :)
    integer, allocatable :: basis(:)
    real(rk), allocatable :: column(:)
    real(rk), allocatable :: ratio(:)
    real(rk), allocatable :: covering(:)
    logical, allocatable :: is_candidate(:)
  contains
    procedure :: reserve
    procedure :: reserve_tableau
  end type lcp_workspace_t

contains

  !> Makes room for n unknowns.
  pure subroutine reserve(self, n)
    class(lcp_workspace_t), intent(inout) :: self
    integer, intent(in) :: n

    if (n <= self%capacity) return
    if (allocated(self%lambda)) deallocate (self%lambda, self%w, self%row_size, self%is_violated, self%history, self%factors, &
      self%active, self%pivots, self%work, self%signs)
    if (allocated(self%tableau)) deallocate (self%tableau, self%basis, self%column, self%ratio, self%covering, self%is_candidate)
    self%capacity = n
    allocate (self%lambda(n), self%w(n), self%row_size(n), self%is_violated(n))
    allocate (self%history(n_words(n), max(usual_sets, n + 1) + 1))
    allocate (self%factors(n, n), self%active(n), self%pivots(n), self%work(n), self%signs(n))
  end subroutine reserve

  !> Makes room for Lemke's method, which few problems need.
  pure subroutine reserve_tableau(self)
    class(lcp_workspace_t), intent(inout) :: self

    if (allocated(self%tableau)) return
    associate (n => self%capacity)
      allocate (self%tableau(n, 2 * n + 2), self%basis(n), self%column(n), self%ratio(n), self%covering(n), self%is_candidate(n))
    end associate
  end subroutine reserve_tableau

  !> lambda_A = -W_AA^-1 q_A, w = W lambda + q outside A, and the signs that are wrong.
  !>
  !> Requires: workspace%reserve.
  subroutine evaluate_set(matrix, q, is_active, workspace)
    !> shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> the set A, shape (n)
    logical, intent(in) :: is_active(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    real(rk) :: doubtful, reciprocal
    integer :: i, info, n

    call gather(matrix, is_active, workspace, n)
    workspace%is_singular = .false.
    reciprocal = 1
    doubtful = 1
    workspace%lambda(:size(q)) = 0
    if (n > 0) then
      call factor_set(matrix, is_active, workspace, n, info)
      call measure_pivots(workspace%factors, n, doubtful)
      if (workspace%is_cholesky) doubtful = doubtful**2
      workspace%is_singular = info /= 0 .or. .not. doubtful > 0
      if (workspace%is_singular) return
      if (doubtful < trusted_pivots) then
        call measure_condition(matrix, workspace, n, reciprocal)
        workspace%is_singular = .not. reciprocal > singular_reciprocal
        if (workspace%is_singular) return
      end if
      call solve_set(q, n, workspace)
    end if
    call sum_rows(matrix, q, workspace%lambda(:size(q)), workspace)
    do i = 1, size(q)
      if (is_active(i)) workspace%w(i) = 0
    end do
    call find_violations(is_active, condition_tolerance(reciprocal), workspace)
    if (doubtful < trusted_pivots .or. n == 0) return
    ! The exact condition number costs as much as the solve: it is asked for only where it decides.
    if (is_decided(size(q), workspace)) return
    call measure_condition(matrix, workspace, n, reciprocal)
    workspace%is_singular = .not. reciprocal > singular_reciprocal
    call find_violations(is_active, condition_tolerance(reciprocal), workspace)
  end subroutine evaluate_set

  !> The set's indices and its matrix.
  pure subroutine gather(matrix, is_active, workspace, n)
    real(rk), intent(in) :: matrix(:, :)
    logical, intent(in) :: is_active(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    !> size of the set
    integer, intent(out) :: n
    integer :: i, j

    n = 0
    do i = 1, size(is_active)
      if (.not. is_active(i)) cycle
      n = n + 1
      workspace%active(n) = i
    end do
    do j = 1, n
      do i = 1, n
        workspace%factors(i, j) = matrix(workspace%active(i), workspace%active(j))
      end do
    end do
  end subroutine gather

  !> Factors the rows and columns of a set: by Cholesky where the matrix is symmetric and positive definite, else with row
  !> exchanges.
  subroutine factor_set(matrix, is_active, workspace, n, info)
    real(rk), intent(in) :: matrix(:, :)
    logical, intent(in) :: is_active(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    integer, intent(inout) :: n
    !> 0 = done
    integer, intent(out) :: info

    workspace%is_cholesky = workspace%is_symmetric
    if (workspace%is_cholesky) then
      call factor_cholesky(n, workspace%factors, info)
      if (info == 0) return
      workspace%is_cholesky = .false.
      call gather(matrix, is_active, workspace, n)
    end if
    call factor_lu(n, workspace%factors, workspace%pivots, info)
  end subroutine factor_set

  !> Smallest over largest pivot; no number where one is none.
  pure subroutine measure_pivots(factors, n, ratio)
    real(rk), intent(in) :: factors(:, :)
    integer, intent(in) :: n
    real(rk), intent(out) :: ratio
    real(rk) :: largest, smallest
    integer :: i

    largest = 0
    smallest = huge(smallest)
    ratio = 0
    do i = 1, n
      if (.not. abs(factors(i, i)) <= huge(largest)) return
      largest = max(largest, abs(factors(i, i)))
      smallest = min(smallest, abs(factors(i, i)))
    end do
    if (largest > 0) ratio = smallest / largest
  end subroutine measure_pivots

  !> Estimates the reciprocal condition number (1-norm) of the active set's matrix from its factors in the workspace.
  subroutine measure_condition(matrix, workspace, n, reciprocal)
    real(rk), intent(in) :: matrix(:, :)
    type(lcp_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: n
    real(rk), intent(out) :: reciprocal
    real(rk) :: column_sum, norm
    integer :: i, j

    norm = 0
    do j = 1, n
      column_sum = 0
      do i = 1, n
        column_sum = column_sum + abs(matrix(workspace%active(i), workspace%active(j)))
      end do
      norm = max(norm, column_sum)
    end do
    if (workspace%is_cholesky) then
      reciprocal = reciprocal_condition_cholesky(n, workspace%factors, norm, workspace%work, workspace%signs)
    else
      reciprocal = reciprocal_condition_lu(n, workspace%factors, norm, workspace%work, workspace%signs)
    end if
  end subroutine measure_condition

  subroutine solve_set(q, n, workspace)
    real(rk), intent(in) :: q(:)
    integer, intent(in) :: n
    type(lcp_workspace_t), intent(inout) :: workspace
    integer :: i

    do i = 1, n
      workspace%work(i) = -q(workspace%active(i))
    end do
    if (workspace%is_cholesky) then
      call solve_cholesky(n, workspace%factors, workspace%work)
    else
      call solve_lu(n, workspace%factors, workspace%pivots, workspace%work)
    end if
    do i = 1, n
      workspace%lambda(workspace%active(i)) = workspace%work(i)
    end do
  end subroutine solve_set

  !> w = W lambda + q, and the size of what each row sums: |q_i| + sum |W_ij lambda_j|. By columns, as they lie in memory.
  pure subroutine sum_rows(matrix, q, lambda, workspace)
    !> shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> shape (n)
    real(rk), intent(in) :: lambda(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    real(rk) :: part
    integer :: i, j

    do i = 1, size(q)
      workspace%w(i) = q(i)
      workspace%row_size(i) = abs(q(i))
    end do
    do j = 1, size(q)
      if (abs(lambda(j)) <= 0) cycle
      do i = 1, size(q)
        part = matrix(i, j) * lambda(j)
        workspace%w(i) = workspace%w(i) + part
        workspace%row_size(i) = workspace%row_size(i) + abs(part)
      end do
    end do
  end subroutine sum_rows

  !> Signs against what was summed: each w against the terms of its row, each multiplier against the largest one.
  pure subroutine find_violations(is_active, tolerance, workspace)
    logical, intent(in) :: is_active(:)
    real(rk), intent(in) :: tolerance
    type(lcp_workspace_t), intent(inout) :: workspace
    real(rk) :: largest
    integer :: i

    largest = maxval(abs(workspace%lambda(:size(is_active))))
    do i = 1, size(is_active)
      workspace%is_violated(i) = .false.
      if (is_active(i)) then
        workspace%is_violated(i) = workspace%lambda(i) < -tolerance * largest
      else
        workspace%is_violated(i) = workspace%w(i) < -tolerance * workspace%row_size(i)
      end if
    end do
  end subroutine find_violations

  !> Whether no sign is wrong by so little that the widest tolerance would allow it.
  pure logical function is_decided(n, workspace)
    !> unknowns
    integer, intent(in) :: n
    type(lcp_workspace_t), intent(in) :: workspace
    real(rk) :: largest
    integer :: i

    is_decided = .false.
    largest = maxval(abs(workspace%lambda(:n)))
    do i = 1, n
      if (.not. workspace%is_violated(i)) cycle
      if (workspace%lambda(i) < 0) then
        if (workspace%lambda(i) >= -widest_tolerance * largest) return
      else if (workspace%w(i) >= -widest_tolerance * workspace%row_size(i)) then
        return
      end if
    end do
    is_decided = .true.
  end function is_decided

  !> Round-off of a solve grows with the condition number, and the sign tolerance with it.
  pure function condition_tolerance(reciprocal_condition) result(tolerance)
    real(rk), intent(in) :: reciprocal_condition
    real(rk) :: tolerance

    tolerance = 10 * epsilon(tolerance) / max(reciprocal_condition, epsilon(tolerance))
    tolerance = min(max(tolerance, sign_tolerance), widest_tolerance)
  end function condition_tolerance

  !> Name of a method as in reports.
  pure function lcp_method_name(method) result(name)
    integer, intent(in) :: method
    character(:), allocatable :: name

    select case (method)
    case (lcp_active_set)
      name = 'active_set'
    case (lcp_block_pivoting)
      name = 'block_pivoting'
    case (lcp_lemke)
      name = 'lemke'
    case default
      name = 'none'
    end select
  end function lcp_method_name
end module sig_lcp_types
