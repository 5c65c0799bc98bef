! SPDX-License-Identifier: BSD-3-Clause
!> Greedy choice among vectors: each time the one that the span of those chosen so far represents worst.
!>
!> The vectors lose what each new direction of an orthonormal basis represents (modified Gram-Schmidt, with pivoting), so that
!> small errors are lengths of small vectors and have digits of their own. An error never grows: a vector is brought up to date
!> only when its last error is the largest one.
module sig_greedy_projection
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply, multiply_transpose
  use sig_ties, only: tie_tolerance
  implicit none(type, external)
  private
  public :: greedy_projection_t

  type :: greedy_projection_t
    private
    !> what the basis leaves of each vector, shape (n, n_vectors)
    real(rk), allocatable :: rests(:, :)
    !> lengths of the rests; of those that are not up to date an upper bound
    real(rk), allocatable :: errors(:)
    !> directions of the basis that each rest has lost
    integer, allocatable :: n_lost(:)
    logical, allocatable :: is_taken(:)
    !> orthonormal, shape (n, room); the first n_directions count
    real(rk), allocatable :: basis(:, :)
    integer :: n_directions = 0
  contains
    procedure :: create
    procedure :: find_worst
    procedure :: take
  end type greedy_projection_t

contains

  !> Takes the vectors, which are gone from where they were.
  subroutine create(self, vectors, n_most)
    class(greedy_projection_t), intent(out) :: self
    !> divided by what their errors are relative to, shape (n, n_vectors)
    real(rk), allocatable, intent(inout) :: vectors(:, :)
    !> most that will be taken
    integer, intent(in) :: n_most
    integer :: n

    n = size(vectors, 2)
    call move_alloc(vectors, self%rests)
    self%errors = norm2(self%rests, dim=1)
    allocate (self%n_lost(n), source=0)
    allocate (self%is_taken(n), source=.false.)
    allocate (self%basis(size(self%rests, 1), n_most))
  end subroutine create

  !> The vector with the largest error among those that are not taken; of equal ones the first. 0 where all are taken.
  subroutine find_worst(self, i_worst, error)
    class(greedy_projection_t), intent(inout) :: self
    integer, intent(out) :: i_worst
    !> [-] its distance from the span
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

  !> Removes from a rest what the directions since its last update represent.
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

  !> A vector joins the span.
  subroutine take(self, i)
    class(greedy_projection_t), intent(inout) :: self
    integer, intent(in) :: i
    real(rk) :: direction(size(self%rests, 1)), shares(self%n_directions)

    self%is_taken(i) = .true.
    call update(self, i)
    if (self%errors(i) <= 0) return
    direction = self%rests(:, i) / self%errors(i)
    ! once more: what is left of a vector that is nearly in the span is not orthogonal to it
    call multiply_transpose(1.0_rk, self%basis(:, :self%n_directions), direction, 0.0_rk, shares)
    call multiply(-1.0_rk, self%basis(:, :self%n_directions), shares, 1.0_rk, direction)
    ! rounding has no direction
    if (norm2(direction) < 0.5_rk) return
    self%n_directions = self%n_directions + 1
    self%basis(:, self%n_directions) = direction / norm2(direction)
  end subroutine take
end module sig_greedy_projection
