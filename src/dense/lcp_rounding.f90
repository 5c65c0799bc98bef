! SPDX-License-Identifier: BSD-3-Clause
!> Forces of a condensed contact problem that are only rounding: w = W z + q, where q is a sum of terms, q = sum_t q_t theta_t.
!>
!> The terms of a row and the closings by all forces, added without sign, are the size of what cancels in this row. A force that
!> closes the softest contact by at most 1e-12 of it is rounding. So a force is never compared with other forces: where the loads
!> are in equilibrium by themselves, all forces are rounding.
!>
!> The unknown z of an anchor is its opening over a scale, and its w is its force times this scale.
module sig_lcp_rounding
  use sig_kinds, only: rk
  use sig_rounding, only: rounding
  implicit none(type, external)
  private
  public :: lcp_sizes_t, drop_rounding, drop_forces, small_forces

  !> Sizes of a problem, from its data alone.
  type :: lcp_sizes_t
    !> [length/force] largest |W_ij|
    real(rk) :: compliance = 0
    !> [length per unit of theta] largest |q_t| of each term, shape (n_terms)
    real(rk), allocatable :: terms(:)
  contains
    procedure :: create
    procedure :: has_small
  end type lcp_sizes_t

contains

  !> Measures W and the terms of q.
  pure subroutine create(self, matrix, openings)
    class(lcp_sizes_t), intent(inout) :: self
    !> [length/force] shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> [length per unit of theta] q_t, shape (n, n_terms)
    real(rk), intent(in) :: openings(:, :)

    self%compliance = max(0.0_rk, maxval(abs(matrix)))
    self%terms = max(0.0_rk, maxval(abs(openings), dim=1))
  end subroutine create

  !> Whether some force is so small that it may be rounding. This takes n + n_terms operations, and is nearly never so.
  pure logical function has_small(self, theta, unknowns, softest, forces)
    class(lcp_sizes_t), intent(in) :: self
    !> [-] shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [force] z, shape (n)
    real(rk), intent(in) :: unknowns(:)
    !> [length/force] result of softest_contact
    real(rk), intent(in) :: softest
    !> [force] shape (n)
    real(rk), intent(in) :: forces(:)

    associate (largest => dot_product(self%terms, abs(theta)) + self%compliance * sum(unknowns))
      has_small = any(forces > 0 .and. forces * softest <= rounding * largest)
    end associate
  end function has_small

  !> Returns the largest diagonal entry of W [length/force] at rows with a force, and at least the scale if there are anchors.
  pure real(rk) function softest_contact(matrix, anchors, scale, forces) result(softest)
    !> [length/force] shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> 1-based
    integer, intent(in) :: anchors(:)
    !> [length/force]
    real(rk), intent(in) :: scale
    !> [force] shape (n)
    real(rk), intent(in) :: forces(:)
    integer :: k

    softest = merge(scale, 0.0_rk, size(anchors) > 0)
    do k = 1, size(forces)
      if (forces(k) > 0) softest = max(softest, matrix(k, k))
    end do
  end function softest_contact

  !> Sets forces that are only rounding to zero, of a problem whose terms are known one by one.
  pure subroutine drop_rounding(sizes, matrix, openings, theta, anchors, scale, unknowns, forces)
    !> of this problem
    type(lcp_sizes_t), intent(in) :: sizes
    !> [length/force] W, shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> [length per unit of theta] q_t, shape (n, n_terms)
    real(rk), intent(in) :: openings(:, :)
    !> [-] shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> rows that are anchors, 1-based
    integer, intent(in) :: anchors(:)
    !> [length/force] of the anchors
    real(rk), intent(in) :: scale
    !> [force] z >= 0, shape (n)
    real(rk), intent(in) :: unknowns(:)
    !> [force] >= 0, shape (n)
    real(rk), intent(inout) :: forces(:)

    if (.not. sizes%has_small(theta, unknowns, softest_contact(matrix, anchors, scale, forces), forces)) return
    call drop_forces(matrix, matmul(abs(openings), abs(theta)), anchors, scale, unknowns, forces)
  end subroutine drop_rounding

  !> Sets forces that are only rounding to zero. Arguments: drop_rounding.
  pure subroutine drop_forces(matrix, terms, anchors, scale, unknowns, forces)
    real(rk), intent(in) :: matrix(:, :)
    !> [length] sum of |q_t theta_t|, shape (n)
    real(rk), intent(in) :: terms(:)
    integer, intent(in) :: anchors(:)
    real(rk), intent(in) :: scale
    real(rk), intent(in) :: unknowns(:)
    real(rk), intent(inout) :: forces(:)

    where (small_forces(matrix, terms, anchors, scale, unknowns, forces, rounding)) forces = 0
  end subroutine drop_forces

  !> Returns which forces are only rounding. Other arguments: drop_forces.
  pure function small_forces(matrix, terms, anchors, scale, unknowns, forces, tolerance) result(is_small)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: terms(:)
    integer, intent(in) :: anchors(:)
    real(rk), intent(in) :: scale
    real(rk), intent(in) :: unknowns(:)
    real(rk), intent(in) :: forces(:)
    !> [-] share of the terms that is rounding
    real(rk), intent(in) :: tolerance
    logical :: is_small(size(forces))
    real(rk) :: softest
    integer :: k

    softest = softest_contact(matrix, anchors, scale, forces)
    is_small = .false.
    do k = 1, size(forces)
      ! W is symmetric but for the signs of the rows of anchors
      if (forces(k) > 0) is_small(k) = forces(k) * softest <= tolerance * (terms(k) + dot_product(abs(matrix(:, k)), unknowns))
    end do
  end function small_forces
end module sig_lcp_rounding
