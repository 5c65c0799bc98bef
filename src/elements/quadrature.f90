! SPDX-License-Identifier: BSD-3-Clause
!> Integration points of the reference elements.
module sig_quadrature
  use sig_element_types, only: element_types
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: quadrature_rule

contains

  !> Computes the integration points and weights of an element type: 3 points for a T3 and 4 for a Q4 as in section 5 of the paper,
  !> 4 for a T4, 8 for an H8, 2 for a line, 1 for a point.
  !>
  !> Quadratic elements have more points, because they can be curved: 7 for triangles, 14 for tetrahedra, 3 per direction for lines,
  !> quadrilaterals and hexahedra. These rules are exact for polynomials of degree 5.
  pure subroutine quadrature_rule(i_type, points, weights)
    !> row of element_types
    integer, intent(in) :: i_type
    !> [-] reference coordinates, shape (n_dim, n_points)
    real(rk), allocatable, intent(out) :: points(:, :)
    !> [-] shape (n_points), sum = volume of the reference element
    real(rk), allocatable, intent(out) :: weights(:)
    real(rk), parameter :: end_point = sqrt(0.6_rk)

    associate (element => element_types(i_type))
      if (element%n_corners == 2**element%n_dim .and. element%order == 1) then
        call gauss_points(element%n_dim, [-1, 1] / sqrt(3.0_rk), [1.0_rk, 1.0_rk], points, weights)
      else if (element%n_corners == 2**element%n_dim) then
        call gauss_points(element%n_dim, [-end_point, 0.0_rk, end_point], [real(rk) :: 5, 8, 5] / 9, points, weights)
      else if (element%order == 1) then
        call simplex_points(element%n_dim, element%reference_volume, points, weights)
      else if (element%n_dim == 2) then
        call seven_points(points, weights)
      else
        call fourteen_points(points, weights)
      end if
    end associate
  end subroutine quadrature_rule

  !> Computes the tensor product of a Gauss rule on [-1, 1]. The first coordinate varies fastest. For n_dim = 0 it is one point with
  !> the weight 1.
  pure subroutine gauss_points(n_dim, line_points, line_weights, points, weights)
    integer, intent(in) :: n_dim
    !> [-] points and weights of the rule on the line, n of each
    real(rk), intent(in) :: line_points(:)
    real(rk), intent(in) :: line_weights(:)
    !> [-] shape (n_dim, n**n_dim)
    real(rk), allocatable, intent(out) :: points(:, :)
    !> [-] shape (n**n_dim)
    real(rk), allocatable, intent(out) :: weights(:)
    integer :: i, i_dim, i_point

    allocate (points(n_dim, size(line_points)**n_dim), weights(size(line_points)**n_dim))
    weights = 1
    do i_point = 1, size(weights)
      do i_dim = 1, n_dim
        i = modulo((i_point - 1) / size(line_points)**(i_dim - 1), size(line_points)) + 1
        points(i_dim, i_point) = line_points(i)
        weights(i_point) = weights(i_point) * line_weights(i)
      end do
    end do
  end subroutine gauss_points

  !> Computes a rule with one point near each corner and equal weights, exact for polynomials of degree 2. The barycentric
  !> coordinates of a point are 1/6 and 2/3 in a triangle, and (5 - sqrt 5)/20 and (5 + 3 sqrt 5)/20 in a tetrahedron.
  pure subroutine simplex_points(n_dim, volume, points, weights)
    !> 2 or 3
    integer, intent(in) :: n_dim
    !> [-] of the reference element
    real(rk), intent(in) :: volume
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)
    real(rk) :: far

    far = 1.0_rk / 6
    if (n_dim == 3) far = (5 - sqrt(5.0_rk)) / 20
    points = corner_points(n_dim, far)
    allocate (weights(n_dim + 1), source=volume / (n_dim + 1))
  end subroutine simplex_points

  !> Computes a rule of degree 5 on a triangle. Source: J. Radon, Monatsh. Math. Phys. 52 (1948) 286.
  pure subroutine seven_points(points, weights)
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)
    real(rk), parameter :: root = sqrt(15.0_rk)

    points = reshape([corner_points(2, (6 - root) / 21), corner_points(2, (6 + root) / 21), 1.0_rk / 3, 1.0_rk / 3], [2, 7])
    weights = [spread((155 - root) / 2400, 1, 3), spread((155 + root) / 2400, 1, 3), 9.0_rk / 80]
  end subroutine seven_points

  !> Computes a rule of degree 5 on a tetrahedron. Source: N. J. Walkington, Quadrature on simplices of arbitrary dimension,
  !> Carnegie Mellon University, 2000.
  pure subroutine fourteen_points(points, weights)
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)
    real(rk), parameter :: outer = 0.31088591926330060980_rk, inner = 0.092735250310891226402_rk, &
      edge = 0.045503704125649649492_rk, rest = 0.5_rk - edge
    real(rk), parameter :: edge_points(3, 6) = reshape([edge, edge, rest, edge, rest, edge, rest, edge, edge, &
      rest, rest, edge, rest, edge, rest, edge, rest, rest], [3, 6])

    points = reshape([corner_points(3, outer), corner_points(3, inner), edge_points], [3, 14])
    weights = [spread(0.018781320953002641800_rk, 1, 4), spread(0.012248840519393658257_rk, 1, 4), &
      spread(0.0070910034628469110730_rk, 1, 6)]
  end subroutine fourteen_points

  !> Returns the reference coordinates of n_dim + 1 points of a simplex, one per corner, that of the origin first. The barycentric
  !> coordinate of a point for its own corner is 1 - n_dim * far, and its others are all `far`.
  pure function corner_points(n_dim, far) result(points)
    integer, intent(in) :: n_dim
    real(rk), intent(in) :: far
    real(rk) :: points(n_dim, n_dim + 1)
    integer :: i_dim

    points = far
    do i_dim = 1, n_dim
      points(i_dim, i_dim + 1) = 1 - n_dim * far
    end do
  end function corner_points
end module sig_quadrature
