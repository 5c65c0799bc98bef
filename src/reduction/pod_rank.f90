! SPDX-License-Identifier: BSD-3-Clause
!> How many modes a snapshot set needs: the rank from the energy that the left-out modes carry; and snapshots of equal weight.
module sig_pod_rank
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: available_modes, normalize_snapshots, pod_rank, rank_from_energy_tail

  !> [-] vectors whose value is this small against the first are rounding of the snapshots, whatever the tolerance asks for
  real(rk), parameter :: noise = 1.0e-13_rk

contains

  !> Modes of a reduced model: as many as the energy tail asks for, but none that is rounding. Local.
  pure integer function pod_rank(singular_values, tolerance) result(n_modes)
    !> [-] descending, >= 0
    real(rk), intent(in) :: singular_values(:)
    !> [-] the deck's pod_tolerance
    real(rk), intent(in) :: tolerance

    n_modes = min(rank_from_energy_tail(singular_values, tolerance), available_modes(singular_values))
  end function pod_rank

  !> Modes that are no rounding.
  pure integer function available_modes(singular_values) result(n_modes)
    !> [-] descending, >= 0
    real(rk), intent(in) :: singular_values(:)

    n_modes = 0
    if (size(singular_values) > 0) n_modes = count(singular_values > noise * singular_values(1))
  end function available_modes

  !> Divides each snapshot by its Euclidean norm, so that weak ones count like strong ones; what is rounding beside the largest
  !> becomes zero.
  pure subroutine normalize_snapshots(snapshots)
    !> shape (n_dofs, n_snapshots)
    real(rk), intent(inout) :: snapshots(:, :)
    !> [-] a snapshot this small beside the largest is what rounding left of no displacement
    real(rk), parameter :: negligible = 1.0e-10_rk
    real(rk) :: sizes(size(snapshots, 2))
    integer :: i

    sizes = norm2(snapshots, dim=1)
    do i = 1, size(sizes)
      if (sizes(i) > negligible * maxval(sizes)) then
        snapshots(:, i) = snapshots(:, i) / sizes(i)
      else
        snapshots(:, i) = 0
      end if
    end do
  end subroutine normalize_snapshots

  !> Smallest l with sum_{i > l} s_i**2 / sum_i s_i**2 < tolerance; all of them where no l does, none where all are zero.
  !>
  !> Source: (20), read as the energy tail; method.md section 2 says why not its square root or s_l / s_1. Local.
  pure integer function rank_from_energy_tail(singular_values, tolerance) result(n_modes)
    !> [-] descending, >= 0
    real(rk), intent(in) :: singular_values(:)
    !> [-] the deck's pod_tolerance
    real(rk), intent(in) :: tolerance
    real(rk) :: tail, total
    integer :: i_value

    n_modes = 0
    if (size(singular_values) == 0) return
    if (singular_values(1) <= 0) return
    ! Squares of values relative to the first neither overflow nor vanish; small ones first, so that the tail keeps its digits.
    total = 0
    do i_value = size(singular_values), 1, -1
      total = total + (singular_values(i_value) / singular_values(1))**2
    end do
    tail = 0
    n_modes = size(singular_values)
    do i_value = size(singular_values), 1, -1
      tail = tail + (singular_values(i_value) / singular_values(1))**2
      if (tail >= tolerance * total) return
      n_modes = i_value - 1
    end do
  end function rank_from_energy_tail
end module sig_pod_rank
