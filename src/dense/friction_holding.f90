! SPDX-License-Identifier: BSD-3-Clause
!> Motions of bodies that no contact resists, because its coefficient of friction is 0 at this point: along them a body slides
!> without a force. Where the loads do no work on them, the answer is unique but for these motions, and is the one without them.
module sig_friction_holding
  use sig_friction_types, only: friction_contacts_t
  use sig_independent_columns, only: independent_columns
  use sig_kinds, only: rk
  use sig_linear_algebra, only: solve_dense
  implicit none(type, external)
  private
  public :: hold_unresisted_motions

  !> [-] what is left of a motion's openings, over the largest one, and of the loads' work, over the loads, that is rounding
  real(rk), parameter :: rounding_of_motions = 1.0e-10_rk

contains

  !> Makes a copy of W in which motions that no contact resists and no load drives are held where they were: with a unit motion z
  !> of this kind, the rows of motions get s z z' (m - m_0), and with them equilibrium says z' m = z' m_0. `held` is not allocated
  !> where there is no such motion.
  subroutine hold_unresisted_motions(matrix, before, f, contacts, q, held)
    !> [length/force] W as in solve_friction
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> [force] m_0, shape (n_motions)
    real(rk), intent(in) :: before(:)
    !> [-] coefficient of friction of each contact
    real(rk), intent(in) :: f(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> [length] shape (n_rows); changes with W
    real(rk), intent(inout) :: q(:)
    real(rk), allocatable, intent(out) :: held(:, :)
    real(rk), allocatable :: free(:, :), springs(:, :)
    real(rk) :: size_of_motions

    if (contacts%n_motions == 0) return
    if (.not. any(contacts%tangents(1, :) > 0 .and. .not. contacts%is_tied .and. .not. f > 0)) return
    associate (n => contacts%n_forces(), loads => q(contacts%n_forces() + 1:))
      size_of_motions = maxval(abs(matrix(:n, n + 1:)))
      free = unresisted_motions(matrix(resisting_rows(f, contacts), n + 1:), rounding_of_motions * size_of_motions)
      if (size(free, 2) == 0) return
      if (any(abs(matmul(loads, free)) > rounding_of_motions * norm2(loads))) return
      springs = size_of_motions * matmul(free, transpose(free))
      held = matrix
      held(n + 1:, n + 1:) = held(n + 1:, n + 1:) + springs
      loads = loads - matmul(springs, before)
    end associate
  end subroutine hold_unresisted_motions

  !> Returns the rows of normal forces, and of the tangential forces of contacts that are tied or have friction.
  pure function resisting_rows(f, contacts) result(rows)
    real(rk), intent(in) :: f(:)
    type(friction_contacts_t), intent(in) :: contacts
    integer, allocatable :: rows(:)
    integer :: k

    rows = [(k, k=1, contacts%n_contacts)]
    do k = 1, contacts%n_contacts
      if (f(k) > 0 .or. contacts%is_tied(k)) rows = [rows, contacts%tangents(:contacts%n_tangents(k), k)]
    end do
  end function resisting_rows

  !> Returns unit vectors that span the motions without openings; shape (n_motions, n).
  function unresisted_motions(openings, least) result(free)
    !> [length/force] opening of each row by each motion
    real(rk), intent(in) :: openings(:, :)
    real(rk), intent(in) :: least
    real(rk), allocatable :: free(:, :)
    real(rk), allocatable :: products(:, :), shares(:)
    integer, allocatable :: others(:)
    logical :: is_singular
    integer :: i

    associate (chosen => independent_columns(openings, least))
      others = pack([(i, i=1, size(openings, 2))], [(all(chosen /= i), i=1, size(openings, 2))])
      allocate (free(size(openings, 2), size(others)), source=0.0_rk)
      allocate (shares(size(chosen)))
      products = matmul(transpose(openings(:, chosen)), openings)
      do i = 1, size(others)
        call solve_dense(products(:, chosen), products(:, others(i)), shares, is_singular)
        free(chosen, i) = -shares
        free(others(i), i) = 1
        free(:, i) = free(:, i) / norm2(free(:, i))
      end do
    end associate
  end function unresisted_motions
end module sig_friction_holding
