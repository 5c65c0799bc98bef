! SPDX-License-Identifier: BSD-3-Clause
!> Derivatives of one body's displacement by modes with respect to the terms, from Galerkin's equations of sig_body_modes.
module sig_body_modes_derivative
  use sig_body_modes, only: body_modes_t, find_coordinates, part_ratios
  use sig_dense_kernels, only: multiply
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: differentiate_modes

contains

  !> Computes the change da, to first order, of the coordinates of the modes for given changes of the terms and of the contact
  !> forces, from K_r da = Phi'(F dtheta - B'dz) - sum_q dk_q Phi'K_q u - Phi'K L dtheta with K_r = Phi'K Phi at the point. da is
  !> zero if K_r is not positive definite.
  subroutine differentiate_modes(modes, theta, theta_change, coordinates, force_change, changes)
    type(body_modes_t), intent(in) :: modes
    !> values of the model's terms and their changes, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    !> [length] a, shape (n_modes)
    real(rk), intent(in) :: coordinates(:)
    !> [force] dz, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: force_change(:)
    !> [length] da, shape (n_modes)
    real(rk), intent(out) :: changes(:)
    real(rk) :: place(size(modes%basis, 2)), place_change(size(modes%basis, 2))
    real(rk) :: stiffness(size(place)**2), stiffness_change(size(place), size(place)), moved(size(place))
    integer :: n_lifted

    n_lifted = size(modes%lifted_terms)
    place = [theta(modes%lifted_terms), coordinates]
    place_change(:n_lifted) = theta_change(modes%lifted_terms)
    call multiply(1.0_rk, modes%stiffness, part_ratios(modes, theta), 0.0_rk, stiffness)
    stiffness_change = reshape(matmul(modes%stiffness, part_ratio_changes(modes, theta, theta_change)), shape(stiffness_change))
    moved = matmul(stiffness_change, place)
    call find_coordinates(modes, size(place), stiffness, theta_change, force_change, place_change, -moved(n_lifted + 1:))
    changes = place_change(n_lifted + 1:)
  end subroutine differentiate_modes

  !> Returns dk_q [-], the changes of part_ratios, to first order, for a change of the terms. Moduli are proportional to Young's
  !> modulus, and d ln(kappa)/d nu = 2/(1 - 2 nu), in plane stress 1/(1 - nu), d ln(G)/d nu = -1/(1 + nu).
  pure function part_ratio_changes(modes, theta, theta_change) result(changes)
    type(body_modes_t), intent(in) :: modes
    !> values of the model's terms and their changes, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    real(rk), intent(in) :: theta_change(:)
    real(rk) :: changes(size(modes%moduli))
    real(rk) :: bulk_slope
    integer :: i

    changes = part_ratios(modes, theta)
    do i = 1, size(modes%modulus_terms)
      associate (e => modes%modulus_terms(i), nu => modes%ratio_terms(i))
        bulk_slope = 2 / (1 - 2 * theta(nu))
        if (modes%is_thin) bulk_slope = 1 / (1 - theta(nu))
        changes(2 * i - 1) = changes(2 * i - 1) * (theta_change(e) / theta(e) + bulk_slope * theta_change(nu))
        changes(2 * i) = changes(2 * i) * (theta_change(e) / theta(e) - theta_change(nu) / (1 + theta(nu)))
      end associate
    end do
  end function part_ratio_changes
end module sig_body_modes_derivative
