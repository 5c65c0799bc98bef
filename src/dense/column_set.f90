! SPDX-License-Identifier: BSD-3-Clause
!> Least squares on a few columns of a matrix. Columns are added and removed; their QR factorization is updated each time.
module sig_column_set
  use sig_dense_kernels, only: multiply, multiply_transpose
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: column_set_t

  !> [-] a column of length 1 depends on the others if at most this length is left after subtracting its projection on them
  real(rk), parameter :: rank_tolerance = 1.0e-10_rk

  !> A set of n columns of a matrix A with their factors: A(:, used(:n)) = Q R. In use are only used(:n), q(:, :n) and r(:n, :n).
  type :: column_set_t
    integer :: n = 0
    !> numbers of the columns in A, 1-based, shape (most)
    integer, allocatable :: used(:)
    !> orthonormal columns, shape (n_rows, most)
    real(rk), allocatable :: q(:, :)
    !> upper triangle, shape (most, most)
    real(rk), allocatable :: r(:, :)
    !> work space, shape (most)
    real(rk), allocatable, private :: products(:)
  contains
    procedure :: reserve
    procedure :: add
    procedure :: remove
    procedure :: solve
  end type column_set_t

contains

  !> Allocates memory for at most `most` columns of n_rows rows. The set is empty afterwards, also if it had columns before.
  subroutine reserve(self, n_rows, most)
    class(column_set_t), intent(inout) :: self
    integer, intent(in) :: n_rows
    integer, intent(in) :: most

    if (allocated(self%used)) deallocate (self%used, self%q, self%r, self%products)
    allocate (self%used(most), self%q(n_rows, most), self%r(most, most), self%products(most))
    self%n = 0
  end subroutine reserve

  !> Adds a column of A to the set as the last one. The set does not change, and is_dependent is true, in two cases: the set is
  !> full, or the column depends on those of the set. It depends on them if at most a length of 1e-10 is left of it after its
  !> projection on them was subtracted; a zero column depends on any set.
  !>
  !> The method is Gram-Schmidt, twice, so that Q stays orthonormal up to rounding.
  subroutine add(self, matrix, i_column, is_dependent)
    class(column_set_t), intent(inout) :: self
    !> A, whose columns have length 1 or are zero; the same A for all columns of the set; shape (n_rows, n_columns)
    real(rk), intent(in) :: matrix(:, :)
    !> number of the column in A, 1-based
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

  !> Removes a column from the set; the others keep their order. Plane rotations make R triangular again.
  subroutine remove(self, i)
    class(column_set_t), intent(inout) :: self
    !> position of the column in `used`, 1 to n
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

  !> Replaces (a, b) by (c a + s b, c b - s a).
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

  !> Computes the coefficients of the combination of the set's columns that is nearest to b (least squares), and the residual: b
  !> minus this combination. For an empty set the residual is b.
  subroutine solve(self, rhs, solution, residual)
    class(column_set_t), intent(in) :: self
    !> b, shape (n_rows)
    real(rk), contiguous, intent(in) :: rhs(:)
    !> coefficients in the order of `used`, shape (>= n); entries beyond n keep their values
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
