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
  public :: window_t, facet_rule_t, facet_rule

  type :: window_t
    !> coordinate that it bounds, 0 = no window
    integer :: axis = 0
    !> [length]
    real(rk) :: minimum = -huge(1.0_rk)
    real(rk) :: maximum = huge(1.0_rk)
    !> cut facets at the bounds; otherwise a facet counts wholly, and only where all of it is inside
    logical :: is_cut = .true.
  end type window_t

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

    bounds = window
    if (.not. window%is_cut .and. window%axis > 0) then
      bounds%axis = 0
      if (.not. is_inside(vertices, window)) bounds%axis = -1
    end if
    allocate (rule%places(size(vertices, 1), 0), rule%values(size(vertices, 2), 0), rule%area_vectors(size(vertices, 1), 0))
    if (bounds%axis < 0) return
    if (size(vertices, 1) == 2) then
      call cut_edge(vertices, bounds, rule)
    else
      call cut_face(vertices, bounds, rule)
    end if
  end function facet_rule

  !> All nodes in the window.
  pure logical function is_inside(vertices, window)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    real(rk) :: margin

    margin = node_tolerance * maxval(maxval(vertices, dim=2) - minval(vertices, dim=2))
    is_inside = all(vertices(window%axis, :) >= window%minimum - margin .and. vertices(window%axis, :) <= window%maximum + margin)
  end function is_inside

  pure subroutine cut_edge(vertices, window, rule)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: piece(2), cuts(2), tangent(2), s
    integer :: i

    piece = [0, 1]
    tangent = vertices(:, 2) - vertices(:, 1)
    if (window%axis > 0) then
      associate (start => vertices(window%axis, 1), slope => tangent(window%axis))
        if (abs(slope) > 0) then
          cuts = ([window%minimum, window%maximum] - start) / slope
          piece = [max(0.0_rk, minval(cuts)), min(1.0_rk, maxval(cuts))]
        else if (start < window%minimum .or. start > window%maximum) then
          return
        end if
      end associate
    end if
    if (piece(2) <= piece(1)) return
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

  pure subroutine add_point(vertices, values, area_vector, rule)
    real(rk), intent(in) :: vertices(:, :)
    real(rk), intent(in) :: values(:)
    real(rk), intent(in) :: area_vector(:)
    type(facet_rule_t), intent(inout) :: rule

    rule%n_points = rule%n_points + 1
    rule%values = reshape([rule%values, values], [size(values), rule%n_points])
    rule%places = reshape([rule%places, matmul(vertices, values)], [size(vertices, 1), rule%n_points])
    rule%area_vectors = reshape([rule%area_vectors, area_vector], [size(vertices, 1), rule%n_points])
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
