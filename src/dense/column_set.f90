! SPDX-License-Identifier: BSD-3-Clause
!> Least squares on a few columns of a matrix that come and go: their QR factorization is updated.
module sig_column_set
  use sig_dense_kernels, only: multiply, multiply_transpose
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: column_set_t

  !> what a unit column adds to the span of the others is below this: it depends on them
  real(rk), parameter :: rank_tolerance = 1.0e-10_rk

  !> A(:, used(:n)) = Q R.
  type :: column_set_t
    integer :: n = 0
    !> shape (most)
    integer, allocatable :: used(:)
    !> orthonormal columns, shape (n_rows, most)
    real(rk), allocatable :: q(:, :)
    !> upper triangle, shape (most, most)
    real(rk), allocatable :: r(:, :)
    !> room, shape (most)
    real(rk), allocatable, private :: products(:)
  contains
    procedure :: reserve
    procedure :: add
    procedure :: remove
    procedure :: solve
  end type column_set_t

contains

  !> Room for so many columns; the set is empty then.
  subroutine reserve(self, n_rows, most)
    class(column_set_t), intent(inout) :: self
    integer, intent(in) :: n_rows
    integer, intent(in) :: most

    if (allocated(self%used)) deallocate (self%used, self%q, self%r, self%products)
    allocate (self%used(most), self%q(n_rows, most), self%r(most, most), self%products(most))
    self%n = 0
  end subroutine reserve

  !> Takes a column in unless it depends on the others.
  !>
  !> Gram-Schmidt, twice, which leaves Q orthonormal to round-off.
  subroutine add(self, matrix, i_column, is_dependent)
    class(column_set_t), intent(inout) :: self
    !> unit columns, shape (n_rows, n_columns)
    real(rk), intent(in) :: matrix(:, :)
    integer, intent(in) :: i_column
    logical, intent(out) :: is_dependent
    real(rk) :: rest
    integer :: i_pass

    is_dependent = self%n == size(self%used)
    if (is_dependent) return
    associate (n => self%n, column => self%q(:, self%n + 1))
      column = matrix(:, i_column)
      self%r(:n, n + 1) = 0
      do i_pass = 1, 2
        if (n == 0) exit
        call multiply_transpose(1.0_rk, self%q(:, :n), self%q(:, n + 1), 0.0_rk, self%products(:n))
        call multiply(-1.0_rk, self%q(:, :n), self%products(:n), 1.0_rk, self%q(:, n + 1))
        self%r(:n, n + 1) = self%r(:n, n + 1) + self%products(:n)
      end do
      rest = norm2(column)
      is_dependent = .not. rest > rank_tolerance
      if (is_dependent) return
      column = column / rest
      self%r(n + 1, n + 1) = rest
      self%used(n + 1) = i_column
    end associate
    self%n = self%n + 1
  end subroutine add

  !> Drops a column; plane rotations make R triangular again.
  subroutine remove(self, i)
    class(column_set_t), intent(inout) :: self
    !> its place in used
    integer, intent(in) :: i
    real(rk) :: c, radius, s
    integer :: k

    self%n = self%n - 1
    self%used(i:self%n) = self%used(i + 1:self%n + 1)
    do k = i, self%n
      self%r(:k + 1, k) = self%r(:k + 1, k + 1)
    end do
    do k = i, self%n
      radius = hypot(self%r(k, k), self%r(k + 1, k))
      c = self%r(k, k) / radius
      s = self%r(k + 1, k) / radius
      call rotate(c, s, self%r(k, k:self%n), self%r(k + 1, k:self%n))
      call rotate(c, s, self%q(:, k), self%q(:, k + 1))
    end do
  end subroutine remove

  !> (a, b) = (c a + s b, c b - s a).
  elemental subroutine rotate(c, s, a, b)
    real(rk), intent(in) :: c
    real(rk), intent(in) :: s
    real(rk), intent(inout) :: a
    real(rk), intent(inout) :: b
    real(rk) :: turned

    turned = c * a + s * b
    b = c * b - s * a
    a = turned
  end subroutine rotate

  !> The combination of the columns that is nearest to b, and what is left of b.
  subroutine solve(self, rhs, solution, residual)
    class(column_set_t), intent(in) :: self
    !> b, shape (n_rows)
    real(rk), contiguous, intent(in) :: rhs(:)
    !> shape (>= n)
    real(rk), contiguous, intent(inout) :: solution(:)
    !> shape (n_rows)
    real(rk), contiguous, intent(inout) :: residual(:)
    integer :: i

    residual = rhs
    if (self%n == 0) return
    associate (n => self%n)
      call multiply_transpose(1.0_rk, self%q(:, :n), rhs, 0.0_rk, solution(:n))
      call multiply(-1.0_rk, self%q(:, :n), solution(:n), 1.0_rk, residual)
      do i = n, 1, -1
        solution(i) = solution(i) / self%r(i, i)
        solution(:i - 1) = solution(:i - 1) - solution(i) * self%r(:i - 1, i)
      end do
    end associate
  end subroutine solve
end module sig_column_set
