! SPDX-License-Identifier: BSD-3-Clause
!> How many modes a snapshot set needs: the rank from the energy that the left-out modes carry; and snapshots of equal weight.
module sig_pod_rank
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: available_modes, equal_weights, pod_rank

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

  !> Factors that make snapshots equally long, so that weak ones count like strong ones; 0 for what is rounding beside the largest.
  pure function equal_weights(sizes) result(weights)
    !> [as snapshots] their Euclidean norms
    real(rk), intent(in) :: sizes(:)
    !> [1 / as snapshots]
    real(rk) :: weights(size(sizes))
    !> [-] a snapshot this small beside the largest is what rounding left of no displacement
    real(rk), parameter :: negligible = 1.0e-10_rk

    weights = 0
    where (sizes > negligible * maxval(sizes)) weights = 1 / sizes
  end function equal_weights

  !> Smallest l with sum_{i > l} s_i**2 / sum_i s_i**2 < tolerance; all of them where no l does, none where all are zero.
  !>
  !> Source: (20), read as the energy tail: with it both cases of the paper get the numbers of modes that the paper tells, with its
  !> square root or with s_l / s_1 they do not. Local.
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
