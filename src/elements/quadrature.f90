! SPDX-License-Identifier: BSD-3-Clause
!> Integration points of the reference elements.
module sig_quadrature
  use sig_element_types, only: element_types
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: quadrature_rule, reduced_rule

contains

  !> Computes the integration points and weights of an element type: 3 points for a T3 and 4 for a Q4 as in section 5 of the paper,
  !> 4 for a T4, 8 for an H8 and a P5, 6 for a W6, 2 for a line, 1 for a point.
  !>
  !> Quadratic elements have more points, because they can be curved: 7 for triangles, 14 for tetrahedra, 3 per direction for lines,
  !> quadrilaterals and hexahedra, 21 for prisms, 27 for pyramids. These rules are exact for polynomials of degree 5.
  !>
  !> Constant stresses give exact forces on all elements, however distorted or curved: the rules of pyramids are exact for what the
  !> ratio in their shape functions leaves, polynomials of degree 3 (linear) or 5 in xi/(1 - zeta) and eta/(1 - zeta).
  pure subroutine quadrature_rule(i_type, points, weights)
    !> row of element_types
    integer, intent(in) :: i_type
    !> [-] reference coordinates, shape (n_dim, n_points)
    real(rk), allocatable, intent(out) :: points(:, :)
    !> [-] shape (n_points), sum = volume of the reference element
    real(rk), allocatable, intent(out) :: weights(:)

    call rule_of_order(i_type, element_types(i_type)%order, points, weights)
  end subroutine quadrature_rule

  !> Computes the points and weights of a quadratic element whose material flows: those of the linear element of the same shape, so
  !> that it does not lock. They are 4 for a Q8 or Q9, 3 for a T6, 4 for a T10, 8 for an H20, 6 for a W15.
  pure subroutine reduced_rule(i_type, points, weights)
    !> row of element_types
    integer, intent(in) :: i_type
    !> as in quadrature_rule
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)

    call rule_of_order(i_type, 1, points, weights)
  end subroutine reduced_rule

  !> Computes the rule of a shape.
  pure subroutine rule_of_order(i_type, order, points, weights)
    !> row of element_types
    integer, intent(in) :: i_type
    !> 1 or 2
    integer, intent(in) :: order
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)

    associate (n_dim => element_types(i_type)%n_dim, n_corners => element_types(i_type)%n_corners)
      if (n_corners == 2**n_dim) then
        call box_points(n_dim, order, points, weights)
      else if (n_corners == n_dim + 1) then
        call simplex_points(n_dim, order, points, weights)
      else if (n_corners == 6) then
        call prism_points(order, points, weights)
      else
        call pyramid_points(order, points, weights)
      end if
    end associate
  end subroutine rule_of_order

  !> Computes a rule on [-1, 1] in each direction with order + 1 points per direction, exact to degree 2 order + 1 in each.
  pure subroutine box_points(n_dim, order, points, weights)
    integer, intent(in) :: n_dim
    !> 1 or 2
    integer, intent(in) :: order
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)
    real(rk), parameter :: end_point = sqrt(0.6_rk)

    if (order == 1) then
      call gauss_points(n_dim, [-1, 1] / sqrt(3.0_rk), [1.0_rk, 1.0_rk], points, weights)
    else
      call gauss_points(n_dim, [-end_point, 0.0_rk, end_point], [real(rk) :: 5, 8, 5] / 9, points, weights)
    end if
  end subroutine box_points

  !> Computes a rule on a triangle or a tetrahedron, exact to degree 2 (order 1) or 5 (order 2).
  pure subroutine simplex_points(n_dim, order, points, weights)
    !> 2 or 3
    integer, intent(in) :: n_dim
    !> 1 or 2
    integer, intent(in) :: order
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)

    if (order == 1) then
      call one_point_per_corner(n_dim, points, weights)
    else if (n_dim == 2) then
      call seven_points(points, weights)
    else
      call fourteen_points(points, weights)
    end if
  end subroutine simplex_points

  !> Computes the product of the rules of a triangle and a line. The points of the triangle vary fastest.
  pure subroutine prism_points(order, points, weights)
    integer, intent(in) :: order
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)
    real(rk), allocatable :: plane(:, :), plane_weights(:), line(:, :), line_weights(:)
    integer :: i, n

    call simplex_points(2, order, plane, plane_weights)
    call box_points(1, order, line, line_weights)
    n = size(plane_weights)
    allocate (points(3, n * size(line_weights)), weights(n * size(line_weights)))
    do i = 1, size(line_weights)
      points(:2, (i - 1) * n + 1:i * n) = plane
      points(3, (i - 1) * n + 1:i * n) = line(1, i)
      weights((i - 1) * n + 1:i * n) = plane_weights * line_weights(i)
    end do
  end subroutine prism_points

  !> Computes a rule on a pyramid: that of a square in xi/s and eta/s, and one of Gauss and Jacobi for the weight s**2 in s = 1 -
  !> zeta. It is exact for polynomials of degree 2 order + 1.
  pure subroutine pyramid_points(order, points, weights)
    integer, intent(in) :: order
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)
    real(rk), parameter :: two(2) = 2.0_rk / 3 + [-1, 1] * sqrt(2 / 45.0_rk), &
      of_two(2) = 1.0_rk / 6 + [-1, 1] * sqrt(10.0_rk) / 48
    !> zeros of s**3 - 15/8 s**2 + 15/14 s - 5/28, and weights whose moments are 1/3, 1/4 and 1/5
    real(rk), parameter :: three(3) = [0.294997790111501616877601522416_rk, 0.652996233961648115278236456597_rk, &
      0.927005975926850267844162020988_rk], of_three(3) = [0.0299507030085806980114764907559_rk, &
      0.146246269259866022003512020364_rk, 0.157136361064886613318344822213_rk]

    if (order == 1) then
      call shrink_square(order, two, of_two, points, weights)
    else
      call shrink_square(order, three, of_three, points, weights)
    end if
  end subroutine pyramid_points

  !> Computes the points of a square at several distances from the apex of a pyramid.
  pure subroutine shrink_square(order, distances, distance_weights, points, weights)
    integer, intent(in) :: order
    !> [-] s = 1 - zeta, and the weights for integrals of s**2 f(s) over [0, 1]
    real(rk), intent(in) :: distances(:)
    real(rk), intent(in) :: distance_weights(:)
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)
    real(rk), allocatable :: square(:, :), square_weights(:)
    integer :: i, n

    call box_points(2, order, square, square_weights)
    n = size(square_weights)
    allocate (points(3, n * size(distances)), weights(n * size(distances)))
    do i = 1, size(distances)
      points(:2, (i - 1) * n + 1:i * n) = distances(i) * square
      points(3, (i - 1) * n + 1:i * n) = 1 - distances(i)
      weights((i - 1) * n + 1:i * n) = square_weights * distance_weights(i)
    end do
  end subroutine shrink_square

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
  pure subroutine one_point_per_corner(n_dim, points, weights)
    !> 2 or 3
    integer, intent(in) :: n_dim
    real(rk), allocatable, intent(out) :: points(:, :)
    real(rk), allocatable, intent(out) :: weights(:)
    real(rk) :: far

    far = 1.0_rk / 6
    if (n_dim == 3) far = (5 - sqrt(5.0_rk)) / 20
    points = corner_points(n_dim, far)
    allocate (weights(n_dim + 1), source=1.0_rk / (merge(2, 6, n_dim == 2) * (n_dim + 1)))
  end subroutine one_point_per_corner

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
