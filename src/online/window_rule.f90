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
  public :: window_t, facet_rule_t, facet_rule, find_facet_rule, facet_position
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
  !> corners of a quadrilateral after two cuts, and some room
  integer, parameter :: most_corners = 12
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

    call find_facet_rule(vertices, window, rule)
  end function facet_rule

  !> The same in arrays that are kept from facet to facet where they are large enough: only the first n_points count then.
  pure subroutine find_facet_rule(vertices, window, rule)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t), intent(inout) :: rule
    type(window_t) :: bounds
    integer :: position

    bounds = window
    rule%n_points = 0
    position = position_of(vertices, window)
    if (position == facet_inside) bounds%axis = 0
    if (position == facet_outside) then
      call make_room(vertices, 0, rule)
    else if (size(vertices, 1) == 2) then
      call cut_edge(vertices, bounds, rule)
    else
      call cut_face(vertices, bounds, rule)
    end if
  end subroutine find_facet_rule

  pure integer function position_of(vertices, window) result(position)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    real(rk) :: lower(3), upper(3)
    integer :: k

    do k = 1, size(vertices, 1)
      lower(k) = minval(vertices(k, :))
      upper(k) = maxval(vertices(k, :))
    end do
    position = facet_position(lower(:size(vertices, 1)), upper(:size(vertices, 1)), window)
  end function position_of

  !> From the facet's box alone: outside (its part in the window has no area), inside, or to be cut.
  !>
  !> Without cutting a facet is inside where all its nodes are, up to rounding, and else outside.
  pure integer function facet_position(lower, upper, window) result(position)
    !> [length] smallest and largest coordinates of its nodes, shape (n_dim)
    real(rk), intent(in) :: lower(:)
    real(rk), intent(in) :: upper(:)
    type(window_t), intent(in) :: window
    real(rk) :: margin
    integer :: k

    position = facet_inside
    if (window%axis == 0) return
    margin = 0
    if (.not. window%is_cut) then
      do k = 1, size(lower)
        margin = max(margin, node_tolerance * (upper(k) - lower(k)))
      end do
    end if
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
    real(rk) :: area_vector(3), cuts(2), piece(2), s, tangent(2), values(4)
    integer :: i

    piece = [0, 1]
    tangent = vertices(:, 2) - vertices(:, 1)
    if (window%axis > 0) then
      cuts = ([window%minimum, window%maximum] - vertices(window%axis, 1)) / tangent(window%axis)
      piece = [max(0.0_rk, minval(cuts)), min(1.0_rk, maxval(cuts))]
    end if
    call make_room(vertices, merge(n_gauss, 0, piece(2) > piece(1)), rule)
    if (piece(2) <= piece(1)) return
    do i = 1, n_gauss
      s = piece(1) + (piece(2) - piece(1)) * gauss_points(i)
      values = [1 - s, s, 0.0_rk, 0.0_rk]
      area_vector = (piece(2) - piece(1)) * gauss_weights(i) * [tangent(2), -tangent(1), 0.0_rk]
      call add_point(vertices, values, area_vector, rule)
    end do
  end subroutine cut_edge

  pure subroutine cut_face(vertices, window, rule)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: polygon(2, most_corners)
    integer :: i, n

    n = size(vertices, 2)
    if (n == 3) then
      polygon(:, :3) = triangle
    else
      polygon(:, :4) = square
    end if
    if (window%axis > 0) then
      call clip(vertices, window%axis, window%minimum, 1.0_rk, polygon, n)
      call clip(vertices, window%axis, window%maximum, -1.0_rk, polygon, n)
    end if
    call make_room(vertices, max(0, n - 2) * n_gauss**2, rule)
    do i = 2, n - 1
      call add_triangle(vertices, polygon(:, 1), polygon(:, i), polygon(:, i + 1), rule)
    end do
  end subroutine cut_face

  !> Keeps the part of a convex polygon where sense * (coordinate - bound) >= 0.
  pure subroutine clip(vertices, axis, bound, sense, polygon, n_corners)
    real(rk), intent(in) :: vertices(:, :)
    integer, intent(in) :: axis
    real(rk), intent(in) :: bound
    real(rk), intent(in) :: sense
    !> [-] reference coordinates
    real(rk), intent(inout) :: polygon(2, most_corners)
    integer, intent(inout) :: n_corners
    real(rk) :: distance(most_corners), kept(2, most_corners), values(4)
    integer :: i, k, n, next

    if (abs(bound) >= huge(bound)) return
    do i = 1, n_corners
      call find_shape_values(polygon(:, i), size(vertices, 2), values)
      distance(i) = -bound
      do k = 1, size(vertices, 2)
        distance(i) = distance(i) + values(k) * vertices(axis, k)
      end do
      distance(i) = sense * distance(i)
    end do
    n = 0
    do i = 1, n_corners
      next = modulo(i, n_corners) + 1
      if (distance(i) >= 0) then
        n = n + 1
        kept(:, n) = polygon(:, i)
      end if
      if ((distance(i) > 0 .and. distance(next) < 0) .or. (distance(i) < 0 .and. distance(next) > 0)) then
        n = n + 1
        kept(:, n) = polygon(:, i) + (polygon(:, next) - polygon(:, i)) * distance(i) / (distance(i) - distance(next))
      end if
    end do
    n_corners = n
    polygon(:, :n) = kept(:, :n)
  end subroutine clip

  !> Gauss points on a triangle of reference coordinates, as on a square with one side shrunk to a corner.
  pure subroutine add_triangle(vertices, first, second, third, rule)
    real(rk), intent(in) :: vertices(:, :)
    real(rk), intent(in) :: first(2), second(2), third(2)
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: a(2), b(2), gradients(4, 2), point(2), tangents(3, 2), values(4), weight
    integer :: i, j, k

    a = second - first
    b = third - second
    do j = 1, n_gauss
      do i = 1, n_gauss
        point = first + gauss_points(i) * (a + gauss_points(j) * b)
        weight = gauss_weights(i) * gauss_weights(j) * gauss_points(i) * (a(1) * b(2) - a(2) * b(1))
        call find_shape_values(point, size(vertices, 2), values)
        call find_shape_gradients(point, size(vertices, 2), gradients)
        tangents = 0
        do k = 1, size(vertices, 2)
          tangents(:, 1) = tangents(:, 1) + gradients(k, 1) * vertices(:, k)
          tangents(:, 2) = tangents(:, 2) + gradients(k, 2) * vertices(:, k)
        end do
        call add_point(vertices, values, weight * cross(tangents(:, 1), tangents(:, 2)), rule)
      end do
    end do
  end subroutine add_triangle

  !> Arrays of exactly this size in a new rule; larger ones of one that is used again stay.
  pure subroutine make_room(vertices, n_points, rule)
    real(rk), intent(in) :: vertices(:, :)
    integer, intent(in) :: n_points
    type(facet_rule_t), intent(inout) :: rule

    if (allocated(rule%places)) then
      if (size(rule%places, 2) >= n_points .and. size(rule%places, 1) == size(vertices, 1) .and. &
        size(rule%values, 1) == size(vertices, 2)) return
      deallocate (rule%places, rule%values, rule%area_vectors)
    end if
    allocate (rule%places(size(vertices, 1), n_points), rule%values(size(vertices, 2), n_points))
    allocate (rule%area_vectors(size(vertices, 1), n_points))
  end subroutine make_room

  pure subroutine add_point(vertices, values, area_vector, rule)
    real(rk), intent(in) :: vertices(:, :)
    real(rk), intent(in) :: values(4)
    real(rk), intent(in) :: area_vector(3)
    type(facet_rule_t), intent(inout) :: rule
    integer :: k

    rule%n_points = rule%n_points + 1
    associate (i => rule%n_points)
      rule%values(:, i) = values(:size(vertices, 2))
      rule%area_vectors(:, i) = area_vector(:size(vertices, 1))
      rule%places(:, i) = 0
      do k = 1, size(vertices, 2)
        rule%places(:, i) = rule%places(:, i) + values(k) * vertices(:, k)
      end do
    end associate
  end subroutine add_point

  !> Linear on the triangle, bilinear on the square.
  pure subroutine find_shape_values(point, n_nodes, values)
    real(rk), intent(in) :: point(2)
    integer, intent(in) :: n_nodes
    real(rk), intent(out) :: values(4)

    if (n_nodes == 3) then
      values = [1 - point(1) - point(2), point(1), point(2), 0.0_rk]
    else
      values = (1 + square(1, :) * point(1)) * (1 + square(2, :) * point(2)) / 4
    end if
  end subroutine find_shape_values

  !> Their derivatives.
  pure subroutine find_shape_gradients(point, n_nodes, gradients)
    real(rk), intent(in) :: point(2)
    integer, intent(in) :: n_nodes
    real(rk), intent(out) :: gradients(4, 2)

    if (n_nodes == 3) then
      gradients = reshape([-1, 1, 0, 0, -1, 0, 1, 0], [4, 2])
    else
      gradients(:, 1) = square(1, :) * (1 + square(2, :) * point(2)) / 4
      gradients(:, 2) = square(2, :) * (1 + square(1, :) * point(1)) / 4
    end if
  end subroutine find_shape_gradients

  pure function cross(a, b)
    real(rk), intent(in) :: a(3)
    real(rk), intent(in) :: b(3)
    real(rk) :: cross(3)

    cross = [a(2) * b(3) - a(3) * b(2), a(3) * b(1) - a(1) * b(3), a(1) * b(2) - a(2) * b(1)]
  end function cross
end module sig_window_rule
