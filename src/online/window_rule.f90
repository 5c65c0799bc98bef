! SPDX-License-Identifier: BSD-3-Clause
!> Integration over the part of a facet that lies in a window `minimum <= coordinate <= maximum`, exact on the cut.
!>
!> An edge is cut to a piece of itself. A face is cut to a polygon in its reference coordinates and split into triangles; that is
!> exact for triangles and parallelograms, where the coordinate is linear in the reference coordinates. Either way the integral is
!> a continuous function of the window.
module sig_window_rule
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: window_t, facet_rule_t, facet_rule, facet_position
  public :: facet_outside, facet_cut, facet_inside

  type :: window_t
    !> coordinate that it bounds, 0 = no window
    integer :: axis = 0
    !> [length]
    real(rk) :: minimum = -huge(1.0_rk)
    real(rk) :: maximum = huge(1.0_rk)
    !> cut facets at the bounds; otherwise a facet counts wholly, and only where all of it is inside
    logical :: is_cut = .true.
  end type window_t

  !> where a facet lies relative to a window
  integer, parameter :: facet_outside = 0, facet_cut = 1, facet_inside = 2

  !> Integration points of one facet, none where it is outside.
  type :: facet_rule_t
    integer :: n_points = 0
    !> [length] shape (n_dim, n_points)
    real(rk), allocatable :: places(:, :)
    !> [-] shape functions, shape (n_nodes, n_points)
    real(rk), allocatable :: values(:, :)
    !> [length**(n_dim - 1)] weight times normal, by the order of the nodes, shape (n_dim, n_points)
    real(rk), allocatable :: area_vectors(:, :)
  end type facet_rule_t

  !> Gauss points on (0, 1) and their weights: exact for polynomials of degree 7
  integer, parameter :: n_gauss = 4
  real(rk), parameter :: inner = sqrt(3.0_rk / 7 - sqrt(6.0_rk / 5) * 2 / 7), outer = sqrt(3.0_rk / 7 + sqrt(6.0_rk / 5) * 2 / 7)
  real(rk), parameter :: gauss_points(n_gauss) = [1 - outer, 1 - inner, 1 + inner, 1 + outer] / 2
  real(rk), parameter :: gauss_weights(n_gauss) = [18 - sqrt(30.0_rk), 18 + sqrt(30.0_rk), 18 + sqrt(30.0_rk), &
    18 - sqrt(30.0_rk)] / 72
  !> [-] of a facet's size: a node this little outside is inside (rounding of coordinates and bounds, in any unit)
  real(rk), parameter :: node_tolerance = 1.0e-9_rk
  !> corners of the reference triangle and of the reference square
  real(rk), parameter :: triangle(2, 3) = reshape([0, 0, 1, 0, 0, 1], [2, 3])
  real(rk), parameter :: square(2, 4) = reshape([-1, -1, 1, -1, 1, 1, -1, 1], [2, 4])

contains

  !> Rule for an edge (n_dim = 2) or a triangle or quadrilateral (n_dim = 3).
  pure function facet_rule(vertices, window) result(rule)
    !> [length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t) :: rule
    type(window_t) :: bounds
    integer :: position

    bounds = window
    position = facet_position(minval(vertices, dim=2), maxval(vertices, dim=2), window)
    if (position == facet_inside) bounds%axis = 0
    allocate (rule%places(size(vertices, 1), 0), rule%values(size(vertices, 2), 0), rule%area_vectors(size(vertices, 1), 0))
    if (position == facet_outside) return
    if (size(vertices, 1) == 2) then
      call cut_edge(vertices, bounds, rule)
    else
      call cut_face(vertices, bounds, rule)
    end if
  end function facet_rule

  !> From the facet's box alone: outside (its part in the window has no area), inside, or to be cut.
  !>
  !> Without cutting a facet is inside where all its nodes are, up to rounding, and else outside.
  pure integer function facet_position(lower, upper, window) result(position)
    !> [length] smallest and largest coordinates of its nodes, shape (n_dim)
    real(rk), intent(in) :: lower(:)
    real(rk), intent(in) :: upper(:)
    type(window_t), intent(in) :: window
    real(rk) :: margin

    position = facet_inside
    if (window%axis == 0) return
    margin = 0
    if (.not. window%is_cut) margin = node_tolerance * maxval(upper - lower)
    associate (low => lower(window%axis), high => upper(window%axis))
      if (low >= window%minimum - margin .and. high <= window%maximum + margin) return
      position = facet_cut
      if (.not. window%is_cut .or. high <= window%minimum .or. low >= window%maximum .or. window%minimum > window%maximum) &
        position = facet_outside
    end associate
  end function facet_position

  pure subroutine cut_edge(vertices, window, rule)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: piece(2), cuts(2), tangent(2), s
    integer :: i

    piece = [0, 1]
    tangent = vertices(:, 2) - vertices(:, 1)
    if (window%axis > 0) then
      cuts = ([window%minimum, window%maximum] - vertices(window%axis, 1)) / tangent(window%axis)
      piece = [max(0.0_rk, minval(cuts)), min(1.0_rk, maxval(cuts))]
    end if
    if (piece(2) <= piece(1)) return
    call make_room(vertices, n_gauss, rule)
    do i = 1, n_gauss
      s = piece(1) + (piece(2) - piece(1)) * gauss_points(i)
      call add_point(vertices, [1 - s, s], (piece(2) - piece(1)) * gauss_weights(i) * [tangent(2), -tangent(1)], rule)
    end do
  end subroutine cut_edge

  pure subroutine cut_face(vertices, window, rule)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t), intent(inout) :: rule
    real(rk), allocatable :: polygon(:, :)
    integer :: i

    if (size(vertices, 2) == 3) then
      polygon = triangle
    else
      polygon = square
    end if
    if (window%axis > 0) then
      call clip(polygon, vertices(window%axis, :), window%minimum, 1.0_rk)
      call clip(polygon, vertices(window%axis, :), window%maximum, -1.0_rk)
    end if
    if (size(polygon, 2) > 2) call make_room(vertices, (size(polygon, 2) - 2) * n_gauss**2, rule)
    do i = 2, size(polygon, 2) - 1
      call add_triangle(vertices, polygon(:, [1, i, i + 1]), rule)
    end do
  end subroutine cut_face

  !> Keeps the part of a convex polygon where sense * (coordinate - bound) >= 0.
  pure subroutine clip(polygon, heights, bound, sense)
    !> [-] reference coordinates, shape (2, n_corners)
    real(rk), allocatable, intent(inout) :: polygon(:, :)
    !> [length] the coordinate at the nodes of the face
    real(rk), intent(in) :: heights(:)
    real(rk), intent(in) :: bound
    real(rk), intent(in) :: sense
    real(rk) :: distance(size(polygon, 2) + 1), kept(2, 2 * size(polygon, 2))
    integer :: i, n, next

    if (abs(bound) >= huge(bound)) return
    do i = 1, size(polygon, 2)
      distance(i) = sense * (dot_product(shape_values(polygon(:, i), size(heights)), heights) - bound)
    end do
    n = 0
    do i = 1, size(polygon, 2)
      next = modulo(i, size(polygon, 2)) + 1
      if (distance(i) >= 0) then
        n = n + 1
        kept(:, n) = polygon(:, i)
      end if
      if ((distance(i) > 0 .and. distance(next) < 0) .or. (distance(i) < 0 .and. distance(next) > 0)) then
        n = n + 1
        kept(:, n) = polygon(:, i) + (polygon(:, next) - polygon(:, i)) * distance(i) / (distance(i) - distance(next))
      end if
    end do
    polygon = kept(:, :n)
  end subroutine clip

  !> Gauss points on a triangle of reference coordinates, as on a square with one side shrunk to a corner.
  pure subroutine add_triangle(vertices, corners, rule)
    real(rk), intent(in) :: vertices(:, :)
    real(rk), intent(in) :: corners(:, :)
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: a(2), b(2), point(2), tangents(3, 2), weight
    integer :: i, j

    a = corners(:, 2) - corners(:, 1)
    b = corners(:, 3) - corners(:, 2)
    do j = 1, n_gauss
      do i = 1, n_gauss
        point = corners(:, 1) + gauss_points(i) * (a + gauss_points(j) * b)
        weight = gauss_weights(i) * gauss_weights(j) * gauss_points(i) * (a(1) * b(2) - a(2) * b(1))
        tangents = matmul(vertices, shape_gradients(point, size(vertices, 2)))
        call add_point(vertices, shape_values(point, size(vertices, 2)), weight * cross(tangents(:, 1), tangents(:, 2)), rule)
      end do
    end do
  end subroutine add_triangle

  pure subroutine make_room(vertices, n_points, rule)
    real(rk), intent(in) :: vertices(:, :)
    integer, intent(in) :: n_points
    type(facet_rule_t), intent(inout) :: rule

    deallocate (rule%places, rule%values, rule%area_vectors)
    allocate (rule%places(size(vertices, 1), n_points), rule%values(size(vertices, 2), n_points))
    allocate (rule%area_vectors(size(vertices, 1), n_points))
  end subroutine make_room

  pure subroutine add_point(vertices, values, area_vector, rule)
    real(rk), intent(in) :: vertices(:, :)
    real(rk), intent(in) :: values(:)
    real(rk), intent(in) :: area_vector(:)
    type(facet_rule_t), intent(inout) :: rule

    rule%n_points = rule%n_points + 1
    rule%values(:, rule%n_points) = values
    rule%places(:, rule%n_points) = matmul(vertices, values)
    rule%area_vectors(:, rule%n_points) = area_vector
  end subroutine add_point

  !> Linear on the triangle, bilinear on the square.
  pure function shape_values(point, n_nodes) result(values)
    real(rk), intent(in) :: point(2)
    integer, intent(in) :: n_nodes
    real(rk) :: values(n_nodes)

    if (n_nodes == 3) then
      values = [1 - point(1) - point(2), point(1), point(2)]
    else
      values = (1 + square(1, :) * point(1)) * (1 + square(2, :) * point(2)) / 4
    end if
  end function shape_values

  !> Their derivatives, shape (n_nodes, 2).
  pure function shape_gradients(point, n_nodes) result(gradients)
    real(rk), intent(in) :: point(2)
    integer, intent(in) :: n_nodes
    real(rk) :: gradients(n_nodes, 2)

    if (n_nodes == 3) then
      gradients = reshape([-1, 1, 0, -1, 0, 1], [3, 2])
    else
      gradients(:, 1) = square(1, :) * (1 + square(2, :) * point(2)) / 4
      gradients(:, 2) = square(2, :) * (1 + square(1, :) * point(1)) / 4
    end if
  end function shape_gradients

  pure function cross(a, b)
    real(rk), intent(in) :: a(3)
    real(rk), intent(in) :: b(3)
    real(rk) :: cross(3)

    cross = [a(2) * b(3) - a(3) * b(2), a(3) * b(1) - a(1) * b(3), a(1) * b(2) - a(2) * b(1)]
  end function cross
end module sig_window_rule
