! SPDX-License-Identifier: BSD-3-Clause
!> How far the forces of a step with Coulomb friction may differ if the limits of friction do: the contraction kappa, by which a
!> backward error becomes a bound.
!>
!> Given limits r of the tangential forces (Tresca's friction), the problem is convex. Let lambda_1, lambda_2 be its answers for r_1
!> and r_2, delta their difference, and s_1, s_2 the slips, so that delta_t . (s_1 - s_2) = -delta_t . (W delta)_t. Normal forces
!> and gaps are complementary, and lambda_t . s = r |s|, while other admissible forces have at most this. So
!>
!>     delta' W delta <= sum (r_1 - r_2) (|s_2| - |s_1|) <= sum |r_1 - r_2| |(W delta)_t| = z' W delta <= |z|_W |delta|_W
!>
!> where z is tangential, and as long as r_1 - r_2 at each contact: |delta|_W <= |z|_W. With r = f lambda_n, and D^2 the largest
!> W_tt of each contact, z' W z <= a |D z|^2, where a bounds the eigenvalues of D^-1 W_tt D^-1; and |D delta_n|^2 <=
!> b delta' W delta, where b bounds those of D (W^-1)_nn D. So the limits of friction that follow the forces make a map of forces
!> whose contraction in the norm of W is at most
!>
!>     kappa = max(f) sqrt(a b)
!>
!> Where kappa < 1, a step has one answer lambda, and forces lambda_r that are exact for openings that differ by rho have
!> |lambda_r - lambda|_W <= |rho|_{W^-1} / (1 - kappa): one |rho| with the limits of lambda_r, and kappa |lambda_r - lambda|_W for
!> the limits that are not those of lambda.
module sig_friction_contraction
  use sig_friction_types, only: friction_contacts_t
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: unit_contraction

contains

  !> Returns sqrt(a b) [-], kappa for f = 1; 0 where no contact may slip. Eigenvalues are bounded by sums of rows. Requires: W is
  !> symmetric positive definite, and there are no motions.
  pure real(rk) function unit_contraction(matrix, inverse, contacts) result(kappa)
    !> W [length/force] and its inverse, shape (n_rows, n_rows)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: inverse(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    !> contact of each tangential row, 0 elsewhere and where nothing slips
    integer :: owners(size(matrix, 1))
    !> [sqrt(length/force)] D of each contact, 0 where it has no friction; a and b; a sum of a row
    real(rk) :: d(contacts%n_contacts), largest(2), sum_of_row
    integer :: i, j, k

    owners = 0
    d = 0
    do k = 1, contacts%n_contacts
      if (contacts%is_tied(k)) cycle
      do i = 1, contacts%n_tangents(k)
        owners(contacts%tangents(i, k)) = k
        d(k) = max(d(k), sqrt(matrix(contacts%tangents(i, k), contacts%tangents(i, k))))
      end do
    end do
    largest = 0
    do j = contacts%n_contacts + 1, size(matrix, 1)
      if (owners(j) == 0) cycle
      sum_of_row = 0
      do i = contacts%n_contacts + 1, size(matrix, 1)
        if (owners(i) > 0) sum_of_row = sum_of_row + abs(matrix(i, j)) / (d(owners(i)) * d(owners(j)))
      end do
      largest(1) = max(largest(1), sum_of_row)
    end do
    do j = 1, contacts%n_contacts
      largest(2) = max(largest(2), sum(abs(inverse(:contacts%n_contacts, j)) * d) * d(j))
    end do
    kappa = sqrt(product(largest))
  end function unit_contraction
end module sig_friction_contraction
