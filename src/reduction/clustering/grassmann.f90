! SPDX-License-Identifier: BSD-3-Clause
!> Distances of two subspaces, or of two snapshots, by the principal angles between them.
module sig_grassmann
  use sig_kinds, only: rk
  use sig_singular_values, only: svd
  implicit none(type, external)
  private
  public :: subspace_t, subspace_distance, snapshot_angle

  !> [-] above this cosine (45 degrees) the angle is computed from its sine, because near 1 the arc cosine loses half of the digits
  real(rk), parameter :: cosine_of_sines = sqrt(0.5_rk)
  real(rk), parameter :: half_pi = 2 * atan(1.0_rk)

  !> A subspace, given by an orthonormal basis.
  type :: subspace_t
    !> [-] orthonormal columns, shape (n_coordinates, dimension)
    real(rk), allocatable :: basis(:, :)
  end type subspace_t

contains

  !> Returns the distance d of two subspaces with the orthonormal bases A and B and the dimensions a and b, which may differ.
  !>
  !> d**2 = (pi/2)**2 |a - b| + sum of the squared principal angles. Each missing dimension therefore counts as a right angle. The
  !> cosines of the angles are the singular values C of A'B = Y C Z'. The sine of angle i is the length of (B - A A'B) z_i.
  !> Source: (14), (15); sines: Björck and Golub, Math. Comp. 27 (1973) 579. Local.
  function subspace_distance(first, second) result(distance)
    type(subspace_t), intent(in) :: first
    type(subspace_t), intent(in) :: second
    !> [rad] 0 for equal subspaces
    real(rk) :: distance

    ! the formula for the sines needs vectors of the smaller subspace
    if (size(first%basis, 2) >= size(second%basis, 2)) then
      distance = distance_from_larger(first%basis, second%basis)
    else
      distance = distance_from_larger(second%basis, first%basis)
    end if
  end function subspace_distance

  function distance_from_larger(larger, smaller) result(distance)
    real(rk), intent(in) :: larger(:, :)
    real(rk), intent(in) :: smaller(:, :)
    real(rk) :: distance
    real(rk), allocatable :: cosines(:), left(:, :), product(:, :), residual(:, :), right_rows(:, :)
    real(rk) :: angle
    integer :: i

    product = matmul(transpose(larger), smaller)
    call svd(product, left, cosines, right_rows)
    residual = matmul(smaller - matmul(larger, product), transpose(right_rows))
    distance = half_pi**2 * (size(larger, 2) - size(smaller, 2))
    do i = 1, size(cosines)
      if (cosines(i) > cosine_of_sines) then
        angle = asin(min(1.0_rk, norm2(residual(:, i))))
      else
        angle = acos(cosines(i))
      end if
      distance = distance + angle**2
    end do
    distance = sqrt(distance)
  end function distance_from_larger

  !> Returns the angle between two snapshots of length 1.
  !>
  !> Source: (16). Local. Paper: (16) has no modulus, so that the angle between opposite snapshots is pi. But they span the same
  !> line. Here their angle is 0 unless is_signed asks for the form of the paper.
  pure function snapshot_angle(first, second, is_signed) result(angle)
    !> [-] of length 1
    real(rk), intent(in) :: first(:)
    real(rk), intent(in) :: second(:)
    !> the angle between opposite snapshots is pi, otherwise 0
    logical, intent(in) :: is_signed
    !> [rad] in [0, pi/2]; in [0, pi] with is_signed
    real(rk) :: angle
    real(rk) :: cosine

    cosine = dot_product(first, second)
    if (abs(cosine) <= cosine_of_sines) then
      angle = acos(abs(cosine))
    else
      angle = 2 * asin(min(1.0_rk, norm2(first - sign(1.0_rk, cosine) * second) / 2))
    end if
    if (is_signed .and. cosine < 0) angle = 2 * half_pi - angle
  end function snapshot_angle
end module sig_grassmann
