! SPDX-License-Identifier: BSD-3-Clause
!> The energy of contact forces that another part found and a bound of their error, from the interpolated problem of all contacts.
module sig_interpolated_certificate
  use sig_contact_error_bound, only: contact_error_bound_t
  use sig_force_balance, only: keep_balance
  use sig_interpolated_data, only: interpolated_data_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  implicit none(type, external)
  private
  public :: interpolated_energy, bound_foreign_forces

contains

  !> Returns the energy E = 1/2 lambda' W lambda + q' lambda [force*length], with W and q of closed anchors. E leaves out
  !> the forces on anchors, but these count in the balance: the result is huge if all forces together do not balance the loads on
  !> bodies that only contact holds.
  real(rk) function interpolated_energy(data, theta, multipliers, opening) result(energy)
    class(interpolated_data_t), intent(in) :: data
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: multipliers(:)
    !> work array, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    real(rk) :: compliance(size(multipliers), size(multipliers)), forces(size(multipliers))

    call data%evaluate(theta, compliance, opening)
    forces = multipliers
    if (size(data%anchors) > 0) then
      energy = huge(energy)
      if (.not. are_balanced(data, opening, multipliers)) return
      forces(data%anchors) = 0
    end if
    call multiply(0.5_rk, compliance, forces, 1.0_rk, opening)
    energy = dot_product(forces, opening)
  end function interpolated_energy

  !> Whether forces balance the loads on bodies that only contact holds, except for rounding.
  logical function are_balanced(data, free_opening, forces)
    class(interpolated_data_t), intent(in) :: data
    !> [length] q; its rows of the anchors are the work of the loads times `scale`
    real(rk), intent(in) :: free_opening(:)
    !> [force] >= 0 of all contacts, shape (n_multipliers)
    real(rk), intent(in) :: forces(:)
    real(rk) :: work(size(forces), size(data%anchors))
    integer :: i

    work = data%anchor_closing
    work(data%anchors, :) = 0
    do i = 1, size(data%anchors)
      work(data%anchors(i), i) = 1
    end do
    are_balanced = keep_balance(work, free_opening(data%anchors) / data%scale, forces)
  end function are_balanced

  !> Returns a bound [sqrt(force*length)] of |lambda_r - lambda| in the norm of W. It is the bound of the interpolated problem times
  !> 1 + data%measured_error, plus the effect of interpolation on these forces (data%bound). The result is huge where the
  !> interpolated W is not positive definite. Source: README. Requires: no anchors, data%has_bound().
  real(rk) function bound_foreign_forces(data, theta, multipliers, compliance, opening, enough) result(bound)
    class(interpolated_data_t), intent(in) :: data
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] lambda_r >= 0 of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: multipliers(:)
    !> [length/force] interpolated W, shape (n_multipliers, n_multipliers), and [length] w = W lambda_r + q at the point
    real(rk), contiguous, intent(in) :: compliance(:, :)
    real(rk), contiguous, intent(in) :: opening(:)
    !> [sqrt(force*length)] a bound of the interpolated problem as small as this need not be improved
    real(rk), intent(in) :: enough
    type(contact_error_bound_t) :: norm

    bound = huge(bound)
    call norm%create(compliance)
    if (.not. norm%is_valid) return
    ! it is assumed that the norms of W and of its interpolation differ by no more than the relative error that training measured
    bound = (1 + data%measured_error) * norm%evaluate(multipliers, opening, enough) + data%bound(theta, multipliers)
  end function bound_foreign_forces
end module sig_interpolated_certificate
