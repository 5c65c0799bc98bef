! SPDX-License-Identifier: BSD-3-Clause
!> The rule by which a step of the primal-dual active set method opens and closes pairs.
module sig_next_active_set
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: next_active_set

contains

  !> Returns which pairs are closed in the next step: a closed pair stays closed unless it pulls, an open one closes if it
  !> penetrates.
  pure function next_active_set(is_closed, multipliers, penetration, length_scale, noise) result(next)
    !> pairs that are closed in this step, shape (n_rows)
    logical, intent(in) :: is_closed(:)
    !> [force] contact forces of this step, > 0 pushes, shape (n_rows)
    real(rk), intent(in) :: multipliers(:)
    !> [length] of each pair, > 0 where the bodies overlap, shape (n_rows)
    real(rk), intent(in) :: penetration(:)
    !> [length] size of the displacements, such as their largest component
    real(rk), intent(in) :: length_scale
    !> [-] a force below noise times the largest force of the closed pairs is rounding, as is a penetration below noise times
    !> length_scale
    real(rk), intent(in) :: noise
    logical :: next(size(is_closed))
    real(rk) :: force_scale

    force_scale = maxval(abs(multipliers), mask=is_closed)
    next = merge(multipliers >= -noise * force_scale, penetration > noise * length_scale, is_closed)
  end function next_active_set
end module sig_next_active_set
