! SPDX-License-Identifier: BSD-3-Clause
!> Chooses the number of modes of a POD from the singular values; and weights that make snapshots equally long.
module sig_pod_rank
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: available_modes, equal_weights, pod_rank

  !> [-] modes whose singular value is at most this fraction of the first one are rounding of the snapshots
  real(rk), parameter :: noise = 1.0e-13_rk

contains

  !> Returns the number of modes of a reduced model: as many as the tolerance asks for (20), but at most available_modes, that is,
  !> none that is rounding. 0 where all values are zero. Local.
  pure integer function pod_rank(singular_values, tolerance) result(n_modes)
    !> descending, >= 0, in any unit
    real(rk), intent(in) :: singular_values(:)
    !> [-] one of the pod tolerances of the deck
    real(rk), intent(in) :: tolerance

    n_modes = min(rank_from_energy_tail(singular_values, tolerance), available_modes(singular_values))
  end function pod_rank

  !> Returns the number of modes whose singular value is more than rounding, that is, above 1e-13 times the first one.
  pure integer function available_modes(singular_values) result(n_modes)
    !> descending, >= 0, in any unit
    real(rk), intent(in) :: singular_values(:)

    n_modes = 0
    if (size(singular_values) > 0) n_modes = count(singular_values > noise * singular_values(1))
  end function available_modes

  !> Returns factors that scale each snapshot to length 1, so that weak snapshots count as much as strong ones. The factor is 0 for
  !> a snapshot that is only rounding compared with the largest one.
  pure function equal_weights(sizes) result(weights)
    !> [as snapshots] their Euclidean norms
    real(rk), intent(in) :: sizes(:)
    !> [1 / as snapshots]
    real(rk) :: weights(size(sizes))
    !> [-] a snapshot of at most this fraction of the largest length is only rounding
    real(rk), parameter :: negligible = 1.0e-10_rk

    weights = 0
    where (sizes > negligible * maxval(sizes)) weights = 1 / sizes
  end function equal_weights

  !> Returns the smallest l with sum_{i > l} s_i**2 / sum_i s_i**2 < tolerance; the number of all values where no l satisfies this;
  !> 0 where all values are zero.
  !>
  !> Source: (20), understood as the energy of the modes that are left out. With this reading both cases of the paper get the
  !> numbers of modes that the paper gives. With the square root of this ratio, or with s_l / s_1, they do not. Local.
  pure integer function rank_from_energy_tail(singular_values, tolerance) result(n_modes)
    !> [-] descending, >= 0
    real(rk), intent(in) :: singular_values(:)
    !> [-] as in pod_rank
    real(rk), intent(in) :: tolerance
    real(rk) :: tail, total
    integer :: i_value

    n_modes = 0
    if (size(singular_values) == 0) return
    if (singular_values(1) <= 0) return
    ! Values are divided by the first one, so that squares neither overflow nor vanish. Small ones are summed first, for accuracy.
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
