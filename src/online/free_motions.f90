! SPDX-License-Identifier: BSD-3-Clause
!> Motions of bodies that only contact holds, and that no contact force holds at a point: the place of such a body is not unique
!> there.
module sig_free_motions
  use sig_independent_columns, only: independent_columns
  use sig_kinds, only: rk
  use sig_linear_algebra, only: solve_dense
  use sig_rounding, only: dependent
  implicit none(type, external)
  private
  public :: anchor_work, count_free_motions, free_motions

contains

  !> Returns the number of independent combinations of rigid motions on which no contact force does work: the number of motions
  !> minus the rank of the rows of `work` that have a force.
  pure integer function count_free_motions(work, forces) result(n_free)
    !> work of a unit force of each contact on each motion, shape (n, n_motions)
    real(rk), intent(in) :: work(:, :)
    !> [force] >= 0, and 0 where they are only rounding, shape (n)
    real(rk), intent(in) :: forces(:)
    integer :: i

    n_free = size(work, 2)
    if (n_free == 0) return
    associate (rows => pack([(i, i=1, size(forces))], forces > 0))
      n_free = n_free - size(independent_columns(work(rows, :), dependent))
    end associate
  end function count_free_motions

  !> Returns a basis of the combinations of motions on which the forces of some contacts do no work, one per column.
  function free_motions(work, is_holding) result(motions)
    !> as for count_free_motions
    real(rk), intent(in) :: work(:, :)
    !> whether a contact has a force, shape (n)
    logical, intent(in) :: is_holding(:)
    !> [-] shape (n_motions, n_free)
    real(rk), allocatable :: motions(:, :)
    integer, allocatable :: held(:), others(:), rows(:)
    real(rk), allocatable :: shares(:, :)
    logical :: is_singular
    integer :: i

    rows = pack([(i, i=1, size(is_holding))], is_holding)
    held = independent_columns(work(rows, :), dependent)
    others = pack([(i, i=1, size(work, 2))], [(all(held /= i), i=1, size(work, 2))])
    allocate (motions(size(work, 2), size(others)), source=0.0_rk)
    allocate (shares(size(held), size(others)))
    associate (of_held => work(rows, held))
      call solve_dense(matmul(transpose(of_held), of_held), matmul(transpose(of_held), work(rows, others)), shares, is_singular)
    end associate
    motions(held, :) = -shares
    do i = 1, size(others)
      motions(others(i), i) = 1
    end do
  end function free_motions

  !> Returns [N; 1] of a condensed problem: the work of a unit force of each contact on the motion that belongs to each anchor,
  !> which opens this anchor by 1 and no other anchor. Shape (n, n_anchors).
  pure function anchor_work(compliance, anchors, scale) result(work)
    !> [length/force] W, whose columns of anchors are N times `scale`; shape (n, n)
    real(rk), intent(in) :: compliance(:, :)
    !> 1-based
    integer, intent(in) :: anchors(:)
    !> [length/force]
    real(rk), intent(in) :: scale
    real(rk) :: work(size(compliance, 1), size(anchors))
    integer :: i

    do i = 1, size(anchors)
      work(:, i) = compliance(:, anchors(i)) / scale
    end do
    work(anchors, :) = 0
    do i = 1, size(anchors)
      work(anchors(i), i) = 1
    end do
  end function anchor_work
end module sig_free_motions
