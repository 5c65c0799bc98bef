! SPDX-License-Identifier: BSD-3-Clause
!> Integration points of the reference elements.
module sig_quadrature
  use sig_element_types, only: element_types
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: quadrature_rule

contains

  !> Points and weights for one element type: 3 in a T3 and 4 in a Q4 as in the paper's section 5, 4 in a T4, 8 in an H8.
  pure subroutine quadrature_rule(i_type, points, weights)
    !> row of element_types
    integer, intent(in) :: i_type
    !> [-] shape (n_dim, n_points)
    real(rk), allocatable, intent(out) :: points(:, :)
    !> [-] shape (n_points), sum = volume of the reference element
    real(rk), allocatable, intent(out) :: weights(:)

    associate (element => element_types(i_type))
      if (any(sum(element%monomials(:, :element%n_nodes), dim=1) > 1) .or. element%n_nodes == 2**element%n_dim) then
        call gauss_points(element%n_dim, points, weights)
      else
        call simplex_points(element%n_dim, element%reference_volume, points, weights)
      end if
    end associate
  end subroutine quadrature_rule

  !> Tensor product of the two-point Gauss rule on [-1, 1], exact for cubics in each direction.
  pure subroutine gauss_points(n_dim, points, weights)
    integer, intent(in) :: n_dim
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)
    integer :: i_dim, i_point

    allocate (points(n_dim, 2**n_dim))
    do i_point = 1, 2**n_dim
      do i_dim = 1, n_dim
        points(i_dim, i_point) = merge(1, -1, btest(i_point - 1, i_dim - 1)) / sqrt(3.0_rk)
      end do
    end do
    allocate (weights(2**n_dim), source=1.0_rk)
  end subroutine gauss_points

  !> One point towards each corner, exact for quadratics: triangle 1/6 and 2/3, tetrahedron (5 -+ sqrt 5)/20.
  pure subroutine simplex_points(n_dim, volume, points, weights)
    integer, intent(in) :: n_dim
    real(rk), intent(in) :: volume
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)
    real(rk) :: far, near
    integer :: i_dim

    far = 1.0_rk / 6
    if (n_dim == 3) far = (5 - sqrt(5.0_rk)) / 20
    near = 1 - n_dim * far
    allocate (points(n_dim, n_dim + 1), source=far)
    do i_dim = 1, n_dim
      points(i_dim, i_dim + 1) = near
    end do
    allocate (weights(n_dim + 1), source=volume / (n_dim + 1))
  end subroutine simplex_points
end module sig_quadrature
