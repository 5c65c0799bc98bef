! SPDX-License-Identifier: BSD-3-Clause
!> Integration points on the part of a facet that lies in a window `minimum <= coordinate <= maximum`. A facet is cut exactly at the
!> bounds, so an integral is a continuous function of the bounds. Quadratic facets: curved_rule.f90.
!>
!> Of an edge, the window leaves one piece. A face is the image of a unit square (s, t), on which the bounded coordinate is
!> bilinear. At fixed s the window leaves an interval of t. The ends of this interval are rational functions of s between those s
!> where a bound crosses a side t = 0 or t = 1. Gauss points are put on this interval of t, and in s between two such s. On
!> triangles and parallelograms they are exact for a pressure that is a polynomial of the coordinates up to degree 4. On
!> quadrilaterals whose opposite sides differ by up to a factor of 5, they are accurate to 1e-9 or better.
module sig_window_rule
  use sig_cross_products, only: cross_product
  use sig_curved_rule, only: add_curved_edge, add_curved_face
  use sig_element_types, only: corner_type, element_type_with, element_types
  use sig_facet_points, only: add_point, facet_rule_t, fine_points, fine_weights, gauss_points, gauss_weights, make_room, &
    n_fine, n_gauss, window_t
  use sig_kinds, only: rk
  use sig_rounding, only: rounding_of_data
  use sig_shape_functions, only: shape_coefficients, shape_values
  implicit none(type, external)
  private
  public :: facet_rule, find_facet_rule, facet_position, facet_box
  public :: facet_outside, facet_cut, facet_inside

  !> results of facet_position: where a facet lies relative to a window
  integer, parameter :: facet_outside = 0, facet_cut = 1, facet_inside = 2

  !> nodes of a triangle at (s, t) = (0, 0), (1, 0), (1, 1), (0, 1)
  integer, parameter :: triangle_corners(4) = [1, 2, 2, 3]
  !> most corners of a linear face
  integer, parameter :: most_corners = 4
  !> most ends of strips: 0, 1, and the cuts of two bounds with two sides
  integer, parameter :: most_borders = 6

contains

  !> Returns the integration points of an edge (n_dim = 2), or of a triangle or quadrilateral (n_dim = 3), on the part inside of the
  !> window; no points if the facet lies outside. Where the window does not cut facets (is_cut is false), the points are those of
  !> the whole facet, or none. Linear and quadratic facets are known.
  pure function facet_rule(vertices, window) result(rule)
    !> [length] coordinates of the nodes, corners first, shape (n_dim, n_nodes)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t) :: rule

    call find_facet_rule(vertices, window, rule)
    if (rule%n_points == size(rule%places, 2)) return
    rule%places = rule%places(:, :rule%n_points)
    rule%values = rule%values(:, :rule%n_points)
    rule%area_vectors = rule%area_vectors(:, :rule%n_points)
  end function facet_rule

  !> Does the same as facet_rule, but uses the arrays of `rule` again where they are large enough. Points that `rule` had before are
  !> replaced. Only the first rule%n_points points of the arrays are valid.
  pure subroutine find_facet_rule(vertices, window, rule)
    !> [length] as for facet_rule
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
    else if (size(vertices, 1) == 2 .and. size(vertices, 2) == 2) then
      call cut_edge(vertices, bounds, rule)
    else if (size(vertices, 1) == 2) then
      call add_curved_edge(vertices, bounds, rule)
    else if (size(vertices, 2) <= most_corners) then
      call cut_face(vertices, bounds, rule)
    else
      call add_curved_face(vertices, bounds, rule)
    end if
  end subroutine find_facet_rule

  !> Returns where a facet lies relative to a window: facet_inside, facet_outside or facet_cut. Its box (facet_box) decides, so a
  !> curved facet that is near to a bound may count as cut although it is not.
  pure integer function position_of(vertices, window) result(position)
    !> [length] as for facet_rule
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    real(rk) :: lower(size(vertices, 1)), upper(size(vertices, 1))

    position = facet_inside
    if (window%axis == 0) return
    call facet_box(vertices, window%is_cut, lower, upper)
    position = facet_position(lower, upper, window)
  end function position_of

  !> Computes the smallest and largest coordinates of the nodes of a facet. A curved facet may bulge beyond its nodes. For a
  !> quadratic facet that windows cut (is_cut), the box is therefore made larger, so that it contains the whole facet.
  !>
  !> A point of a quadratic facet is a point of the linear facet of its corners plus sum_i N_i d_i over the other nodes. d_i is the
  !> distance of node i from its place on the linear facet, and |N_i| <= 1.
  pure subroutine facet_box(vertices, is_cut, lower, upper)
    !> [length] coordinates of the nodes, shape (n_dim, n_nodes)
    real(rk), intent(in) :: vertices(:, :)
    !> as in window_t
    logical, intent(in) :: is_cut
    !> [length] shape (n_dim)
    real(rk), intent(out) :: lower(:)
    real(rk), intent(out) :: upper(:)
    real(rk) :: bulge(size(lower))
    integer :: i, k

    do k = 1, size(lower)
      lower(k) = minval(vertices(k, :))
      upper(k) = maxval(vertices(k, :))
    end do
    if (.not. is_cut .or. size(vertices, 2) <= merge(2, most_corners, size(lower) == 2)) return
    bulge = 0
    associate (facet => element_types(element_type_with(size(lower) - 1, size(vertices, 2))), &
      i_linear => corner_type(element_type_with(size(lower) - 1, size(vertices, 2))))
      associate (coefficients => shape_coefficients(i_linear))
        do i = facet%n_corners + 1, facet%n_nodes
          bulge = bulge + abs(vertices(:, i) - matmul(vertices(:, :facet%n_corners), &
            shape_values(i_linear, coefficients, facet%reference_nodes(:facet%n_dim, i))))
        end do
      end associate
    end associate
    lower = lower - bulge
    upper = upper + bulge
  end subroutine facet_box

  !> Returns facet_outside (0), facet_cut (1) or facet_inside (2) for the box of a facet. A facet that only touches a bound from
  !> outside is outside; one that is on a bound as a whole is inside. If the minimum of the window is larger than its maximum, every
  !> facet is outside. Without a window (axis = 0) all are inside.
  !>
  !> Where the window does not cut facets (is_cut is false), a facet is inside if its box is inside up to rounding, and else
  !> outside.
  pure integer function facet_position(lower, upper, window) result(position)
    !> [length] from facet_box, shape (n_dim)
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
        margin = max(margin, rounding_of_data * (upper(k) - lower(k)))
      end do
    end if
    associate (low => lower(window%axis), high => upper(window%axis))
      if (low >= window%minimum - margin .and. high <= window%maximum + margin) return
      position = facet_cut
      if (.not. window%is_cut .or. high <= window%minimum .or. low >= window%maximum .or. window%minimum > window%maximum) &
        position = facet_outside
    end associate
  end function facet_position

  !> Puts the points of a linear edge, on the part inside of the window, into the empty `rule`, and makes its arrays large enough.
  pure subroutine cut_edge(vertices, window, rule)
    !> [length] as for facet_rule
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: area_vector(3), piece(2), s, tangent(2), values(4)
    integer :: i

    piece = [0, 1]
    tangent = vertices(:, 2) - vertices(:, 1)
    if (window%axis > 0) piece = piece_inside(vertices(window%axis, 1), vertices(window%axis, 2), window)
    call make_room(vertices, merge(n_gauss, 0, piece(2) > piece(1)), rule)
    if (piece(2) <= piece(1)) return
    do i = 1, n_gauss
      s = piece(1) + (piece(2) - piece(1)) * gauss_points(i)
      values = [1 - s, s, 0.0_rk, 0.0_rk]
      area_vector = (piece(2) - piece(1)) * gauss_weights(i) * [tangent(2), -tangent(1), 0.0_rk]
      call add_point(vertices, values, area_vector, rule)
    end do
  end subroutine cut_edge

  !> Returns the interval of (0, 1) on which a linear function from `first` to `last` lies between the bounds. If there is none, the
  !> end of the interval is not larger than its start. Requires: the minimum of the window is not above its maximum.
  pure function piece_inside(first, last, window) result(piece)
    !> [length]
    real(rk), intent(in) :: first
    real(rk), intent(in) :: last
    type(window_t), intent(in) :: window
    real(rk) :: piece(2), cuts(2)

    if (abs(last - first) > 0) then
      cuts = ([window%minimum, window%maximum] - first) / (last - first)
      piece = [max(0.0_rk, minval(cuts)), min(1.0_rk, maxval(cuts))]
    else
      piece = [0.0_rk, merge(1.0_rk, 0.0_rk, first >= window%minimum .and. first <= window%maximum)]
    end if
  end function piece_inside

  !> Puts the points of a linear face, on the part inside of the window, into the empty `rule`, and makes its arrays large enough.
  !> The face is the image of the unit square (s, t). On a triangle the side s = 1 of the square is only a point, the second node.
  pure subroutine cut_face(vertices, window, rule)
    !> [length] as for facet_rule
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: borders(most_borders), places(4)
    integer :: i, corners(4), n_outer(most_borders - 1), n_strips

    corners = triangle_corners
    if (size(vertices, 2) == 4) corners = [1, 2, 3, 4]
    if (window%axis == 0) then
      call make_room(vertices, n_gauss**2, rule)
      call add_strip(vertices, corners, window, [0.0_rk, 1.0_rk], n_gauss, rule)
      return
    end if
    if (size(vertices, 2) == 4) corners = best_corners(vertices(window%axis, :))
    places = vertices(window%axis, corners)
    call find_borders(places, window, borders, n_strips)
    do i = 1, n_strips
      n_outer(i) = outer_points(places, window, borders(i:i + 1), size(vertices, 2) == 3)
    end do
    call make_room(vertices, n_gauss * sum(n_outer(:n_strips)), rule)
    do i = 1, n_strips
      call add_strip(vertices, corners, window, borders(i:i + 1), n_outer(i), rule)
    end do
  end subroutine cut_face

  !> Returns the corners of a quadrilateral, [1, 2, 3, 4] or [1, 4, 3, 2]: that order in which the bounded coordinate changes more
  !> evenly along t (evenness). A bound cuts the face along a function t(s), which has a pole at each s where the coordinate does
  !> not change along t.
  pure function best_corners(places) result(corners)
    !> [length] bounded coordinate of the nodes
    real(rk), intent(in) :: places(4)
    integer :: corners(4)

    corners = [1, 2, 3, 4]
    if (evenness(places([1, 4, 3, 2])) > evenness(places)) corners = [1, 4, 3, 2]
  end function best_corners

  !> Compares how much the coordinate changes along t on the side s = 0 and on the side s = 1. Returns the smaller change divided by
  !> the larger one, or 0 where the signs of both differ or one is 0.
  pure real(rk) function evenness(places)
    !> [length] bounded coordinate of the corners (0, 0), (1, 0), (1, 1), (0, 1)
    real(rk), intent(in) :: places(4)
    real(rk) :: growth(2)

    growth = [places(4) - places(1), places(3) - places(2)]
    evenness = 0
    if (growth(1) * growth(2) > 0) evenness = minval(abs(growth)) / maxval(abs(growth))
  end function evenness

  !> Divides 0 <= s <= 1 into strips, within which no bound crosses a side t = 0 or t = 1.
  pure subroutine find_borders(places, window, borders, n_strips)
    !> [length] bounded coordinate of the corners (0, 0), (1, 0), (1, 1), (0, 1)
    real(rk), intent(in) :: places(4)
    type(window_t), intent(in) :: window
    !> ends of the strips, ascending; only the first n_strips + 1 are set
    real(rk), intent(out) :: borders(most_borders)
    integer, intent(out) :: n_strips
    real(rk) :: ends(4)
    integer :: i, j

    borders = 1
    borders(1) = 0
    n_strips = 1
    ends = [piece_inside(places(1), places(2), window), piece_inside(places(4), places(3), window)]
    do i = 1, size(ends)
      if (ends(i) <= 0 .or. ends(i) >= 1) cycle
      j = count(borders(:n_strips) < ends(i))
      borders(j + 2:n_strips + 2) = borders(j + 1:n_strips + 1)
      borders(j + 1) = ends(i)
      n_strips = n_strips + 1
    end do
  end subroutine find_borders

  !> Returns the number of Gauss points in s for a strip: 0 where the strip lies outside of the window; n_fine where a bound cuts a
  !> quadrilateral along a function that is not close to a polynomial of s (evenness up to 0.9); else n_gauss. Where the strip lies
  !> is tested in its middle.
  pure integer function outer_points(places, window, strip, is_triangle) result(n_points)
    !> [length] as in find_borders
    real(rk), intent(in) :: places(4)
    type(window_t), intent(in) :: window
    !> interval of s
    real(rk), intent(in) :: strip(2)
    logical, intent(in) :: is_triangle
    real(rk), parameter :: even = 0.9_rk
    real(rk) :: piece(2)

    piece = piece_at(places, sum(strip) / 2, window)
    n_points = n_gauss
    if (piece(2) <= piece(1)) n_points = 0
    if (is_triangle .or. evenness(places) > even) return
    if (piece(2) > piece(1) .and. piece(2) - piece(1) < 1) n_points = n_fine
  end function outer_points

  !> Returns the interval of t that lies in the window at one s; if there is none, its end is not larger than its start.
  pure function piece_at(places, s, window) result(piece)
    !> [length] bounded coordinate of the corners
    real(rk), intent(in) :: places(4)
    !> [-] from 0 to 1
    real(rk), intent(in) :: s
    type(window_t), intent(in) :: window
    real(rk) :: piece(2)

    piece = piece_inside((1 - s) * places(1) + s * places(2), (1 - s) * places(4) + s * places(3), window)
  end function piece_at

  !> Appends to `rule` the points of one strip.
  pure subroutine add_strip(vertices, corners, window, strip, n_outer, rule)
    !> [length] as for facet_rule
    real(rk), intent(in) :: vertices(:, :)
    !> nodes at (s, t) = (0, 0), (1, 0), (1, 1), (0, 1)
    integer, intent(in) :: corners(4)
    type(window_t), intent(in) :: window
    !> interval of s
    real(rk), intent(in) :: strip(2)
    !> number of Gauss points in s: n_gauss, n_fine or 0
    integer, intent(in) :: n_outer
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: points(n_fine), weights(n_fine), piece(2), s
    integer :: i

    points(:n_gauss) = gauss_points
    weights(:n_gauss) = gauss_weights
    if (n_outer == n_fine) then
      points = fine_points
      weights = fine_weights
    end if
    piece = [0, 1]
    do i = 1, n_outer
      s = strip(1) + (strip(2) - strip(1)) * points(i)
      if (window%axis > 0) piece = piece_at(vertices(window%axis, corners), s, window)
      call add_line(vertices, corners, s, piece, weights(i) * (strip(2) - strip(1)), rule)
    end do
  end subroutine add_strip

  !> Appends to `rule` the n_gauss Gauss points with t in `piece`, at one s of the unit square (s, t); with area 0 if the end of
  !> `piece` is not larger than its start.
  pure subroutine add_line(vertices, corners, s, piece, weight_of_s, rule)
    !> [length] as for facet_rule
    real(rk), intent(in) :: vertices(:, :)
    !> as in add_strip
    integer, intent(in) :: corners(4)
    real(rk), intent(in) :: s
    !> interval of t
    real(rk), intent(in) :: piece(2)
    !> Gauss weight of s times the width of its strip
    real(rk), intent(in) :: weight_of_s
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: along_s(3), along_t(3), length, t, values(4)
    integer :: j

    length = max(0.0_rk, piece(2) - piece(1))
    along_t = (1 - s) * (vertices(:, corners(4)) - vertices(:, corners(1))) + &
      s * (vertices(:, corners(3)) - vertices(:, corners(2)))
    ! the order [1, 4, 3, 2] of the corners turns the normal to the other side
    if (corners(2) == 4) along_t = -along_t
    do j = 1, n_gauss
      t = piece(1) + length * gauss_points(j)
      along_s = (1 - t) * (vertices(:, corners(2)) - vertices(:, corners(1))) + &
        t * (vertices(:, corners(3)) - vertices(:, corners(4)))
      values = 0
      values(corners(1)) = (1 - s) * (1 - t)
      values(corners(4)) = (1 - s) * t
      values(corners(2)) = s * (1 - t)
      values(corners(3)) = values(corners(3)) + s * t
      call add_point(vertices, values, weight_of_s * length * gauss_weights(j) * cross_product(along_s, along_t), rule)
    end do
  end subroutine add_line
end module sig_window_rule
