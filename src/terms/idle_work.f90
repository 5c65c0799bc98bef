! SPDX-License-Identifier: BSD-3-Clause
!> The work of the loads on motions that nothing holds, as a sum of terms: sum over t of theta_t(mu) w_t. Where it is not zero,
!> there is no equilibrium.
module sig_idle_work
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: idle_work_t

  !> The work of each term's force on each motion.
  type :: idle_work_t
    !> [force per unit of theta] shape (n_terms, n_motions)
    real(rk), allocatable :: work(:, :)
    !> [force per unit of theta] work up to this size is rounding, or cannot be told from none; same shape
    real(rk), allocatable :: limits(:, :)
  contains
    procedure :: at
    procedure :: is_zero
    procedure :: has_no_terms
  end type idle_work_t

contains

  !> Returns the work of the loads on each motion at a point, shape (n_motions) [force]. Work within the limits is zero.
  pure function at(self, theta) result(work)
    class(idle_work_t), intent(in) :: self
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    real(rk) :: work(size(self%work, 2))
    integer :: i

    do i = 1, size(work)
      work(i) = sum(theta * self%work(:, i))
      if (abs(work(i)) <= sum(abs(theta) * self%limits(:, i))) work(i) = 0
    end do
  end function at

  !> Whether the loads do no work on any of the motions at a point.
  pure logical function is_zero(self, theta)
    class(idle_work_t), intent(in) :: self
    !> [-] values of the terms, or their changes; shape (n_terms)
    real(rk), intent(in) :: theta(:)
    integer :: i

    is_zero = .true.
    if (.not. allocated(self%work)) return
    do i = 1, size(self%work, 2)
      is_zero = is_zero .and. abs(sum(theta * self%work(:, i))) <= sum(abs(theta) * self%limits(:, i))
    end do
  end function is_zero

  !> Whether no term does work on any of the motions, so that there is nothing to check at a point.
  pure logical function has_no_terms(self)
    class(idle_work_t), intent(in) :: self

    has_no_terms = .not. any(abs(self%work) > self%limits)
  end function has_no_terms
end module sig_idle_work
