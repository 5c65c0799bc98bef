! SPDX-License-Identifier: BSD-3-Clause
!> Greedy choice among vectors. Each time it takes the vector with the largest distance from the span of those taken before.
!>
!> The method is modified Gram-Schmidt with pivoting: each new direction of an orthonormal basis is subtracted from the vectors. An
!> error is then the length of what is left of a vector, so that small errors are exact, too. Errors never grow. A vector is
!> therefore updated only when its last known error is the largest one.
module sig_greedy_projection
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply, multiply_transpose
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: greedy_projection_t

  !> The vectors and those that are taken. Call `create`, then `find_worst` and `take` in turn.
  type :: greedy_projection_t
    private
    !> each vector minus its projection on the basis, shape (n, n_vectors)
    real(rk), allocatable :: rests(:, :)
    !> lengths of the rests; an upper bound where a rest is not up to date
    real(rk), allocatable :: errors(:)
    !> number of directions of the basis that were subtracted from each rest
    integer, allocatable :: n_lost(:)
    logical, allocatable :: is_taken(:)
    !> orthonormal columns, of which the first n_directions are set, shape (n, n_most)
    real(rk), allocatable :: basis(:, :)
    integer :: n_directions = 0
  contains
    procedure :: create
    procedure :: find_worst
    procedure :: take
  end type greedy_projection_t

contains

  !> Starts a choice among the vectors. No vector is taken yet. The array is moved, so that `vectors` is not allocated afterwards.
  subroutine create(self, vectors, n_most)
    class(greedy_projection_t), intent(out) :: self
    !> shape (n, n_vectors); scale them before, because errors are lengths of what is left of them
    real(rk), allocatable, intent(inout) :: vectors(:, :)
    !> largest number of vectors that will be taken; `take` may not be called more often
    integer, intent(in) :: n_most
    integer :: n

    n = size(vectors, 2)
    call move_alloc(vectors, self%rests)
    self%errors = norm2(self%rests, dim=1)
    allocate (self%n_lost(n), source=0)
    allocate (self%is_taken(n), source=.false.)
    allocate (self%basis(size(self%rests, 1), n_most))
  end subroutine create

  !> Finds the vector with the largest error among those that are not taken; of nearly equal ones the first. i_worst and error are 0
  !> where all are taken.
  subroutine find_worst(self, i_worst, error)
    class(greedy_projection_t), intent(inout) :: self
    !> number of the vector, 1-based
    integer, intent(out) :: i_worst
    !> [as vectors] its distance from the span of those taken
    real(rk), intent(out) :: error
    integer :: i
    logical :: is_current

    is_current = .false.
    do while (.not. is_current)
      error = maxval(self%errors, mask=.not. self%is_taken)
      is_current = .true.
      i_worst = 0
      do i = 1, size(self%errors)
        if (self%is_taken(i) .or. self%errors(i) < (1 - tie_tolerance) * error) cycle
        if (i_worst == 0) i_worst = i
        if (self%n_lost(i) == self%n_directions) cycle
        call update(self, i)
        is_current = .false.
      end do
    end do
    if (i_worst == 0) error = 0
  end subroutine find_worst

  !> Subtracts from the rest of vector i its projection on the directions that were added since its last update, and measures the
  !> length of this rest again (errors).
  subroutine update(self, i)
    type(greedy_projection_t), intent(inout) :: self
    integer, intent(in) :: i
    real(rk) :: shares(self%n_directions - self%n_lost(i))

    associate (directions => self%basis(:, self%n_lost(i) + 1:self%n_directions))
      call multiply_transpose(1.0_rk, directions, self%rests(:, i), 0.0_rk, shares)
      call multiply(-1.0_rk, directions, shares, 1.0_rk, self%rests(:, i))
    end associate
    self%n_lost(i) = self%n_directions
    self%errors(i) = norm2(self%rests(:, i))
  end subroutine update

  !> Takes vector i: it is not a candidate any more, and the span grows by its direction unless the span contains it up to rounding.
  subroutine take(self, i)
    class(greedy_projection_t), intent(inout) :: self
    !> number of the vector, 1-based, not taken yet
    integer, intent(in) :: i
    real(rk) :: direction(size(self%rests, 1)), shares(self%n_directions)

    self%is_taken(i) = .true.
    call update(self, i)
    if (self%errors(i) <= 0) return
    direction = self%rests(:, i) / self%errors(i)
    ! a second time: the rest of a vector that lies nearly in the span is not orthogonal to the span
    call multiply_transpose(1.0_rk, self%basis(:, :self%n_directions), direction, 0.0_rk, shares)
    call multiply(-1.0_rk, self%basis(:, :self%n_directions), shares, 1.0_rk, direction)
    ! the rest was only rounding
    if (norm2(direction) < 0.5_rk) return
    self%n_directions = self%n_directions + 1
    self%basis(:, self%n_directions) = direction / norm2(direction)
  end subroutine take
end module sig_greedy_projection
