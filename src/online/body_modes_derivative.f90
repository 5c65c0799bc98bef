! SPDX-License-Identifier: BSD-3-Clause
!> How the displacement of one body by modes changes with the terms: Galerkin's equations of sig_body_modes differentiated.
module sig_body_modes_derivative
  use sig_body_modes, only: body_modes_t, part_moduli
  use sig_dense_kernels, only: factor_cholesky, multiply, solve_cholesky
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: differentiate_modes

contains

  !> K_r da = Phi'(F dtheta - B'dz) - sum_q dk_q Phi'K_q u - Phi'K L dtheta.
  subroutine differentiate_modes(modes, theta, theta_change, coordinates, force_change, changes)
    type(body_modes_t), intent(in) :: modes
    !> values of the model's terms and how they change, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    !> [length] a, shape (n_modes)
    real(rk), intent(in) :: coordinates(:)
    !> [force] dz, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: force_change(:)
    !> [length] da, shape (n_modes)
    real(rk), intent(out) :: changes(:)
    real(rk), allocatable :: stiffness(:, :), stiffness_change(:, :)
    real(rk) :: right(size(coordinates)), matrix(size(coordinates), size(coordinates))
    integer :: info, k, n, n_lifted

    n_lifted = size(modes%lifted_terms)
    n = n_lifted + size(coordinates)
    stiffness = reshape(matmul(modes%stiffness, part_ratios(modes, theta)), [n, n])
    stiffness_change = reshape(matmul(modes%stiffness, part_ratio_changes(modes, theta, theta_change)), [n, n])
    call multiply(1.0_rk, modes%loads, theta_change(:size(modes%loads, 2)), 0.0_rk, right)
    call multiply(-1.0_rk, modes%contact(n_lifted + 1:, :), force_change, 1.0_rk, right)
    do k = 1, n_lifted
      right = right - stiffness(n_lifted + 1:, k) * theta_change(modes%lifted_terms(k)) - &
        stiffness_change(n_lifted + 1:, k) * theta(modes%lifted_terms(k))
    end do
    right = right - matmul(stiffness_change(n_lifted + 1:, n_lifted + 1:), coordinates)
    matrix = stiffness(n_lifted + 1:, n_lifted + 1:)
    call factor_cholesky(size(right), matrix, info)
    changes = 0
    if (info /= 0) return
    call solve_cholesky(size(right), matrix, right)
    changes = right
  end subroutine differentiate_modes

  !> [-] k_q.
  pure function part_ratios(modes, theta) result(ratios)
    type(body_modes_t), intent(in) :: modes
    real(rk), intent(in) :: theta(:)
    real(rk) :: ratios(size(modes%moduli))
    integer :: i

    do i = 1, size(modes%modulus_terms)
      ratios(2 * i - 1:2 * i) = part_moduli(theta(modes%modulus_terms(i)), theta(modes%ratio_terms(i)), modes%is_thin)
    end do
    ratios = ratios / modes%moduli
  end function part_ratios

  !> [-] dk_q: moduli are in proportion to Young's, and d ln(kappa)/d nu = 2/(1 - 2 nu), in plane stress 1/(1 - nu),
  !> d ln(G)/d nu = -1/(1 + nu).
  pure function part_ratio_changes(modes, theta, theta_change) result(changes)
    type(body_modes_t), intent(in) :: modes
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
