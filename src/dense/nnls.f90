! SPDX-License-Identifier: BSD-3-Clause
!> Non-negative least squares: min |A x - b| over x >= 0, for many b and one A.
module sig_nnls
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_column_set, only: column_set_t
  use sig_dense_kernels, only: add_few_columns, add_transposed_product, multiply_transpose
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: nnls_t, nnls_workspace_t

  !> [-] a column of length 1 is not added where its product with the residual is at most this fraction of |b|
  real(rk), parameter :: gradient_tolerance = 1.0e-12_rk
  !> [-] coefficients that become zero within this relative distance of the first one become zero together
  real(rk), parameter :: tie_tolerance = 1.0e-12_rk
  !> with more columns than this, the products of all pairs of columns (more than 32 MB) are not kept
  integer, parameter, public :: most_products = 2000

  !> The data that depend only on A. Any number of threads may share them.
  type :: nnls_t
    private
    !> A with columns scaled to length 1 (a zero column stays zero), shape (n_rows, n_columns), and their lengths before
    real(rk), allocatable :: columns(:, :)
    real(rk), allocatable :: norms(:)
    !> products of the scaled columns with each other, shape (n_columns, n_columns); empty with more than most_products columns
    real(rk), allocatable :: products(:, :)
  contains
    procedure :: prepare
    procedure :: solve
  end type nnls_t

  !> Work space for one problem after the other. Nothing is allocated while the problems have the same size. Two threads must not
  !> use the same one.
  type :: nnls_workspace_t
    private
    type(column_set_t) :: set
    !> b / |b|, and the residual of the columns in use, shape (n_rows)
    real(rk), allocatable :: rhs(:)
    real(rk), allocatable :: residual(:)
    !> [-] products of the columns with rhs and with the residual, shape (n_columns)
    real(rk), allocatable :: rhs_products(:)
    real(rk), allocatable :: gain(:)
    !> minus the coefficients of all columns, zero for columns not in use, shape (n_columns)
    real(rk), allocatable :: taken(:)
    !> columns that may be added to the set, shape (n_columns)
    logical, allocatable :: is_candidate(:)
    !> coefficients of the columns in use, their least squares solution, and the fraction of the step to it at which each becomes
    !> zero
    real(rk), allocatable :: x(:)
    real(rk), allocatable :: solution(:)
    real(rk), allocatable :: reach(:)
    !> the columns in use before the step, and their coefficients
    integer, allocatable :: used_before(:)
    real(rk), allocatable :: x_before(:)
  end type nnls_workspace_t

contains

  !> Keeps a copy of A for `solve`, with columns that are scaled to length 1 (zero columns stay zero). If A has at most 2000 columns
  !> (most_products), it also computes the products of all columns with each other. A matrix with an entry that is not finite is
  !> replaced by zero.
  subroutine prepare(self, matrix)
    class(nnls_t), intent(inout) :: self
    !> A, shape (n_rows, n_columns)
    real(rk), intent(in) :: matrix(:, :)
    integer :: i, n

    n = size(matrix, 2)
    self%columns = matrix
    if (.not. all(ieee_is_finite(matrix))) self%columns = 0
    self%norms = norm2(self%columns, dim=1)
    do i = 1, n
      if (self%norms(i) > 0) self%columns(:, i) = self%columns(:, i) / self%norms(i)
    end do
    if (allocated(self%products)) deallocate (self%products)
    n = merge(n, 0, n <= most_products)
    allocate (self%products(n, n), source=0.0_rk)
    if (n > 0) call add_transposed_product(1.0_rk, self%columns, self%columns, self%products)
  end subroutine prepare

  !> Computes x >= 0 that minimizes |A x - b|. Requires: prepare.
  !>
  !> The method is an active set method. In every step x >= 0, and a step that does not make the residual smaller is undone, so the
  !> method ends. A column that depends on those in use is not added. Source: Lawson and Hanson, Solving least squares problems
  !> (1974), chapter 23.
  subroutine solve(self, rhs, workspace, x, residual_norm, enough)
    class(nnls_t), intent(in) :: self
    !> b, shape (n_rows)
    real(rk), intent(in) :: rhs(:)
    type(nnls_workspace_t), intent(inout) :: workspace
    !> shape (n_columns); zero where A or b is zero or not finite
    real(rk), intent(out) :: x(:)
    !> |A x - b|; |b| where x is zero
    real(rk), intent(out) :: residual_norm
    !> share of |b| with which the method ends early, so that few entries of x are positive; default: 0
    real(rk), intent(in), optional :: enough
    real(rk) :: rhs_norm
    integer :: entering, i

    x = 0
    rhs_norm = norm2(rhs)
    residual_norm = rhs_norm
    if (size(self%columns) == 0 .or. .not. (rhs_norm > 0 .and. ieee_is_finite(rhs_norm))) return
    call start(self, rhs, rhs_norm, workspace)
    residual_norm = 1
    do
      if (present(enough)) then
        if (residual_norm <= enough) exit
      end if
      call find_gains(self, workspace)
      entering = maxloc(workspace%gain, dim=1, mask=workspace%is_candidate)
      if (entering == 0) exit
      if (workspace%gain(entering) <= gradient_tolerance) exit
      call try_column(self, entering, workspace, residual_norm)
    end do
    do i = 1, workspace%set%n
      x(workspace%set%used(i)) = workspace%x(i) * rhs_norm / self%norms(workspace%set%used(i))
    end do
    residual_norm = residual_norm * rhs_norm
  end subroutine solve

  !> Prepares the workspace for b = rhs, whose length rhs_norm is positive and finite: no column is in use, and all are candidates.
  subroutine start(self, rhs, rhs_norm, workspace)
    class(nnls_t), intent(in) :: self
    real(rk), intent(in) :: rhs(:)
    real(rk), intent(in) :: rhs_norm
    type(nnls_workspace_t), intent(inout) :: workspace

    associate (m => size(self%columns, 1), n => size(self%columns, 2))
      call reserve(workspace, m, n)
      workspace%set%n = 0
      workspace%is_candidate = .true.
      workspace%rhs = rhs / rhs_norm
      workspace%residual = workspace%rhs
      call multiply_transpose(1.0_rk, self%columns, workspace%rhs, 0.0_rk, workspace%rhs_products)
    end associate
  end subroutine start

  !> Allocates the arrays of the workspace for a matrix of n_rows x n_columns; keeps them where they have this size already.
  subroutine reserve(workspace, n_rows, n_columns)
    type(nnls_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_columns
    integer :: most

    if (allocated(workspace%gain)) then
      if (size(workspace%rhs) == n_rows .and. size(workspace%gain) == n_columns) return
      deallocate (workspace%rhs, workspace%residual, workspace%rhs_products, workspace%gain, workspace%taken, &
        workspace%is_candidate, &
        workspace%x, workspace%solution, workspace%reach, workspace%used_before, workspace%x_before)
    end if
    most = min(n_rows, n_columns)
    call workspace%set%reserve(n_rows, most)
    allocate (workspace%rhs(n_rows), workspace%residual(n_rows))
    allocate (workspace%rhs_products(n_columns), workspace%gain(n_columns), workspace%taken(n_columns))
    allocate (workspace%is_candidate(n_columns))
    allocate (workspace%x(most), workspace%solution(most), workspace%reach(most))
    allocate (workspace%used_before(most), workspace%x_before(most))
  end subroutine reserve

  !> Sets workspace%gain, the products of the scaled columns of A with the residual.
  subroutine find_gains(self, workspace)
    class(nnls_t), intent(in) :: self
    type(nnls_workspace_t), intent(inout) :: workspace
    integer :: i

    if (size(self%products) == 0) then
      call multiply_transpose(1.0_rk, self%columns, workspace%residual, 0.0_rk, workspace%gain)
      return
    end if
    workspace%taken = 0
    ! a loop: gfortran allocates a temporary array for the vector of indices
    do i = 1, workspace%set%n
      workspace%taken(workspace%set%used(i)) = -workspace%x(i)
    end do
    workspace%gain = workspace%rhs_products
    call add_few_columns(self%products, workspace%taken, workspace%gain)
  end subroutine find_gains

  !> Adds a column to those in use and computes the coefficients again, which may take other columns out of use. Where the residual
  !> does not become smaller, or the column depends on those in use, the columns in use and their coefficients stay as they were.
  !> The column is then no candidate until the columns in use have changed.
  subroutine try_column(self, entering, workspace, residual_norm)
    class(nnls_t), intent(in) :: self
    !> number of the column in A, 1-based
    integer, intent(in) :: entering
    type(nnls_workspace_t), intent(inout) :: workspace
    !> |A x - b| / |b|; in: before the step, out: after it
    real(rk), intent(inout) :: residual_norm
    real(rk) :: trial_norm
    integer :: i, n_before
    logical :: is_dependent

    workspace%is_candidate(entering) = .false.
    n_before = workspace%set%n
    call workspace%set%add(self%columns, entering, is_dependent)
    if (is_dependent) return
    workspace%used_before(:n_before) = workspace%set%used(:n_before)
    workspace%x_before(:n_before) = workspace%x(:n_before)
    workspace%x(n_before + 1) = 0
    call improve(workspace)
    trial_norm = norm2(workspace%residual)
    if (trial_norm < residual_norm) then
      residual_norm = trial_norm
      workspace%is_candidate = .true.
      do i = 1, workspace%set%n
        workspace%is_candidate(workspace%set%used(i)) = .false.
      end do
    else
      call restore(self, n_before, workspace)
    end if
  end subroutine try_column

  !> Solves the least squares problem of the columns in use, and takes out columns whose coefficient would become zero or negative,
  !> until all coefficients are positive or no column is left. Sets x and the residual of the workspace.
  subroutine improve(workspace)
    type(nnls_workspace_t), intent(inout) :: workspace
    real(rk) :: step
    integer :: i, n

    do
      n = workspace%set%n
      associate (x => workspace%x(:n), solution => workspace%solution(:n), reach => workspace%reach(:n))
        call workspace%set%solve(workspace%rhs, solution, workspace%residual)
        if (all(solution > 0)) then
          x = solution
          return
        end if
        reach = huge(step)
        where (solution <= 0) reach = x / max(x - solution, tiny(step))
        step = minval(reach)
        x = x + step * (solution - x)
        ! The column that ends the step must leave in spite of rounding.
        where (reach <= step * (1 + tie_tolerance) .or. x < 0) x = 0
      end associate
      do i = n, 1, -1
        if (workspace%x(i) > 0) cycle
        workspace%x(i:workspace%set%n - 1) = workspace%x(i + 1:workspace%set%n)
        call workspace%set%remove(i)
      end do
    end do
  end subroutine improve

  !> Restores the n_before columns that were in use before the step, their coefficients and the residual.
  subroutine restore(self, n_before, workspace)
    class(nnls_t), intent(in) :: self
    integer, intent(in) :: n_before
    type(nnls_workspace_t), intent(inout) :: workspace
    integer :: i
    logical :: is_dependent

    workspace%set%n = 0
    do i = 1, n_before
      call workspace%set%add(self%columns, workspace%used_before(i), is_dependent)
    end do
    workspace%x(:n_before) = workspace%x_before(:n_before)
    call workspace%set%solve(workspace%rhs, workspace%solution, workspace%residual)
  end subroutine restore
end module sig_nnls
