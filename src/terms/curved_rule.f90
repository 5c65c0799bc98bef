! SPDX-License-Identifier: BSD-3-Clause
!> Integration points on the part of a quadratic edge or face that lies in a window.
!>
!> A face is described as the image of the unit square (s, t); on a triangle the reference coordinates are xi = s, eta = (1 - s) t.
!> At fixed s, the coordinate that the window bounds is a quadratic function of t. The intervals of t inside of the window therefore
!> follow from the roots of quadratic equations. The same equations give those s at which a bound crosses a side t = 0 or t = 1.
!> Between two such s, the ends of the intervals of t are smooth functions of s, and Gauss points are used for s and for t.
!>
!> The points are exact for a pressure that is a quadratic function of the coordinates, on faces without a cut and on all edges.
module sig_curved_rule
  use sig_cross_products, only: cross_product
  use sig_element_types, only: element_type_with, element_types
  use sig_facet_points, only: add_point, facet_rule_t, fine_points, fine_weights, make_room, n_fine, window_t
  use sig_kinds, only: rk
  use sig_shape_functions, only: shape_coefficients, shape_slopes, shape_values
  implicit none(type, external)
  private
  public :: add_curved_edge, add_curved_face

  !> Gauss points on (0, 1) and their weights: exact for polynomials of degree 11
  integer, parameter :: n_points = 6
  real(rk), parameter :: half_points(3) = [0.23861918608319690863_rk, 0.66120938646626451366_rk, 0.93246951420315202781_rk]
  real(rk), parameter :: half_weights(3) = [0.46791393457269104739_rk, 0.36076157304813860757_rk, 0.17132449237917034504_rk]
  real(rk), parameter :: points(n_points) = [1 - half_points, 1 + half_points] / 2
  real(rk), parameter :: weights(n_points) = [half_weights, half_weights] / 2
  !> most points where a quadratic function equals one of the two bounds: two per bound
  integer, parameter :: most_cuts = 4
  !> most ends of strips: 0, 1, and the cuts of two sides
  integer, parameter :: most_borders = 2 + 2 * most_cuts

  !> The data of a face that its integration points need.
  type :: curved_facet_t
    !> row of element_types
    integer :: i_type = 0
    !> [-] of the shape functions, from shape_coefficients, shape (n_nodes, n_nodes)
    real(rk), allocatable :: coefficients(:, :)
    !> [-] reference coordinates of (s, t) = (0, 0), (1, 0), (1, 1), (0, 1), shape (2, 4)
    real(rk) :: corners(2, 4) = 0
  end type curved_facet_t

contains

  !> Puts into `rule` the integration points of an edge of three nodes, on the part inside of the window. Makes the arrays of `rule`
  !> large enough. Requires: rule%n_points = 0.
  pure subroutine add_curved_edge(vertices, window, rule)
    !> [length] coordinates of the nodes, both ends first, shape (2, 3)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: coefficients(size(vertices, 2), size(vertices, 2)), pieces(2, most_cuts), tangent(2), xi
    integer :: i, i_piece, i_type, n_pieces

    i_type = element_type_with(1, size(vertices, 2))
    coefficients = shape_coefficients(i_type)
    call start_pieces(pieces, n_pieces)
    if (window%axis > 0) call find_pieces(vertices(window%axis, [1, 3, 2]), window, pieces, n_pieces)
    call make_room(vertices, n_pieces * n_points, rule)
    do i_piece = 1, n_pieces
      associate (from => pieces(1, i_piece), length => pieces(2, i_piece) - pieces(1, i_piece))
        do i = 1, n_points
          xi = 2 * (from + length * points(i)) - 1
          tangent = 2 * length * weights(i) * matmul(vertices, shape_slopes(i_type, coefficients, [xi], 1))
          call add_point(vertices, shape_values(i_type, coefficients, [xi]), [tangent(2), -tangent(1), 0.0_rk], rule)
        end do
      end associate
    end do
  end subroutine add_curved_edge

  !> Puts into `rule` the integration points of a face of six, eight or nine nodes, on the part inside of the window. Makes the
  !> arrays of `rule` large enough. Requires: rule%n_points = 0.
  pure subroutine add_curved_face(vertices, window, rule)
    !> [length] coordinates of the nodes, corners first, shape (3, n_nodes)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t), intent(inout) :: rule
    type(curved_facet_t) :: facet
    real(rk) :: borders(most_borders)
    integer :: i, n_strips

    facet%i_type = element_type_with(2, size(vertices, 2))
    facet%coefficients = shape_coefficients(facet%i_type)
    facet%corners = chosen_corners(facet%i_type, vertices, window)
    if (window%axis == 0) then
      call make_room(vertices, n_points**2, rule)
      do i = 1, n_points
        call add_line(facet, vertices, window, points(i), weights(i), rule)
      end do
      return
    end if
    call find_strips(facet, vertices(window%axis, :), window, borders, n_strips)
    call make_room(vertices, n_strips * n_fine * most_cuts * n_points, rule)
    do i = 1, n_strips * n_fine
      associate (j => (i - 1) / n_fine + 1, k => modulo(i - 1, n_fine) + 1)
        call add_line(facet, vertices, window, borders(j) + (borders(j + 1) - borders(j)) * fine_points(k), &
          (borders(j + 1) - borders(j)) * fine_weights(k), rule)
      end associate
    end do
  end subroutine add_curved_face

  !> Returns the reference coordinates of the corners (s, t) = (0, 0), (1, 0), (1, 1), (0, 1) of the unit square. On a triangle the
  !> second and the third are the same. The square is turned so that the bounded coordinate changes along t as much as possible.
  !> Only the corners of the face count: on a triangle the change along the side s = 0, on a quadrilateral the smaller change of
  !> those along s = 0 and s = 1. Without a window the square is not turned.
  pure function chosen_corners(i_type, vertices, window) result(corners)
    !> row of element_types
    integer, intent(in) :: i_type
    !> [length] as in add_curved_face
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    real(rk) :: corners(2, 4)
    integer :: i, order(4)
    real(rk) :: growth(4)

    associate (nodes => element_types(i_type)%reference_nodes, n => element_types(i_type)%n_corners)
      growth = 0
      if (window%axis > 0) then
        do i = 1, n
          growth(i) = abs(vertices(window%axis, modulo(i - 2, n) + 1) - vertices(window%axis, i))
        end do
      end if
      if (n == 4) growth(:2) = [min(growth(1), growth(3)), min(growth(2), growth(4))]
      if (n == 4) growth(3:) = 0
      ! the side s = 0 goes from corner i to the corner before it
      i = maxloc(growth, dim=1)
      order = [i, modulo(i, n) + 1, modulo(i + 1, n) + 1, modulo(i + 2, n) + 1]
      if (n == 3) order(2:) = [order(2), order(2), order(3)]
      corners = nodes(:2, order)
    end associate
  end function chosen_corners

  !> Divides 0 <= s <= 1 into strips, within which no bound crosses a side t = 0 or t = 1. Strips may have the width 0.
  pure subroutine find_strips(facet, coordinates, window, borders, n_strips)
    type(curved_facet_t), intent(in) :: facet
    !> [length] bounded coordinate of the nodes
    real(rk), intent(in) :: coordinates(:)
    type(window_t), intent(in) :: window
    !> ends of the strips, ascending; only the first n_strips + 1 are set
    real(rk), intent(out) :: borders(most_borders)
    integer, intent(out) :: n_strips
    real(rk) :: cuts(most_cuts), places(3)
    integer :: i, i_side, n_cuts

    borders = 1
    borders(1) = 0
    n_strips = 1
    do i_side = 0, 1
      do i = 1, 3
        places(i) = coordinate_at(facet, coordinates, [(i - 1) / 2.0_rk, real(i_side, rk)])
      end do
      call find_cuts(places, window, cuts, n_cuts)
      do i = 1, n_cuts
        call insert(cuts(i), borders, n_strips)
      end do
    end do
  end subroutine find_strips

  !> Returns the bounded coordinate at a point of the face.
  pure real(rk) function coordinate_at(facet, coordinates, place)
    type(curved_facet_t), intent(in) :: facet
    !> [length] bounded coordinate of the nodes
    real(rk), intent(in) :: coordinates(:)
    !> s and t
    real(rk), intent(in) :: place(2)

    coordinate_at = dot_product(coordinates, shape_values(facet%i_type, facet%coefficients, &
      matmul(facet%corners, square_values(place))))
  end function coordinate_at

  !> Returns the bilinear shape functions of the corners (0, 0), (1, 0), (1, 1), (0, 1) of the unit square at (s, t).
  pure function square_values(place) result(values)
    !> s and t
    real(rk), intent(in) :: place(2)
    real(rk) :: values(4)

    associate (s => place(1), t => place(2))
      values = [(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t]
    end associate
  end function square_values

  !> Inserts `cut` into the ascending borders, so that there is one strip more, of width 0 if there is such a border already.
  !> Requires: `cut` is not beyond the last border.
  pure subroutine insert(cut, borders, n_strips)
    real(rk), intent(in) :: cut
    !> ends of the strips or pieces, ascending; only the first n_strips + 1 count
    real(rk), intent(inout) :: borders(most_borders)
    integer, intent(inout) :: n_strips
    integer :: j

    j = count(borders(:n_strips) < cut)
    borders(j + 2:n_strips + 2) = borders(j + 1:n_strips + 1)
    borders(j + 1) = cut
    n_strips = n_strips + 1
  end subroutine insert

  !> Appends the integration points along t at one s: those on the pieces of 0 <= t <= 1 that lie in the window; none if there is no
  !> such piece.
  pure subroutine add_line(facet, vertices, window, s, weight_of_s, rule)
    type(curved_facet_t), intent(in) :: facet
    !> [length] as in add_curved_face
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    !> [-] from 0 to 1
    real(rk), intent(in) :: s
    !> Gauss weight of s times the width of its strip
    real(rk), intent(in) :: weight_of_s
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: pieces(2, most_cuts), places(3)
    integer :: i, i_piece, n_pieces

    call start_pieces(pieces, n_pieces)
    if (window%axis > 0) then
      do i = 1, 3
        places(i) = coordinate_at(facet, vertices(window%axis, :), [s, (i - 1) / 2.0_rk])
      end do
      call find_pieces(places, window, pieces, n_pieces)
    end if
    do i_piece = 1, n_pieces
      associate (length => pieces(2, i_piece) - pieces(1, i_piece))
        do i = 1, n_points
          call add_face_point(facet, vertices, [s, pieces(1, i_piece) + length * points(i)], weight_of_s * length * weights(i), &
            rule)
        end do
      end associate
    end do
  end subroutine add_line

  !> Appends one integration point at (s, t). Its area vector is normal to the face; the length of this vector is `weight` times the
  !> area on the face per area of the unit square at this point.
  pure subroutine add_face_point(facet, vertices, place, weight, rule)
    type(curved_facet_t), intent(in) :: facet
    !> [length] as in add_curved_face
    real(rk), intent(in) :: vertices(:, :)
    !> s and t
    real(rk), intent(in) :: place(2)
    !> [-] product of the weights of s and t
    real(rk), intent(in) :: weight
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: along_s(2), along_t(2), reference(2), tangents(3, 2)
    integer :: i

    associate (c => facet%corners, s => place(1), t => place(2))
      reference = matmul(c, square_values(place))
      along_s = (1 - t) * (c(:, 2) - c(:, 1)) + t * (c(:, 3) - c(:, 4))
      along_t = (1 - s) * (c(:, 4) - c(:, 1)) + s * (c(:, 3) - c(:, 2))
    end associate
    do i = 1, 2
      tangents(:, i) = matmul(vertices, shape_slopes(facet%i_type, facet%coefficients, reference, i))
    end do
    call add_point(vertices, shape_values(facet%i_type, facet%coefficients, reference), &
      weight * (along_s(1) * along_t(2) - along_s(2) * along_t(1)) * cross_product(tangents(:, 1), tangents(:, 2)), rule)
  end subroutine add_face_point

  !> Returns one piece, the whole interval (0, 1).
  pure subroutine start_pieces(pieces, n_pieces)
    real(rk), intent(out) :: pieces(2, most_cuts)
    integer, intent(out) :: n_pieces

    pieces = 0
    pieces(2, 1) = 1
    n_pieces = 1
  end subroutine start_pieces

  !> Returns the pieces of (0, 1) on which a quadratic function lies between the bounds of the window, perhaps none.
  pure subroutine find_pieces(places, window, pieces, n_pieces)
    !> [length] values of the function at 0, 1/2 and 1
    real(rk), intent(in) :: places(3)
    type(window_t), intent(in) :: window
    !> both ends of each piece, shape (2, most_cuts); only the first n_pieces count
    real(rk), intent(out) :: pieces(2, most_cuts)
    integer, intent(out) :: n_pieces
    real(rk) :: borders(most_borders), cuts(most_cuts), middle, place
    integer :: i, n_borders, n_cuts

    borders = 1
    borders(1) = 0
    n_borders = 1
    call find_cuts(places, window, cuts, n_cuts)
    do i = 1, n_cuts
      call insert(cuts(i), borders, n_borders)
    end do
    n_pieces = 0
    pieces = 0
    do i = 1, n_borders
      middle = (borders(i) + borders(i + 1)) / 2
      place = places(1) + middle * (slope_at_start(places) + middle * bend(places))
      if (place < window%minimum .or. place > window%maximum) cycle
      n_pieces = n_pieces + 1
      pieces(:, n_pieces) = borders(i:i + 1)
    end do
  end subroutine find_pieces

  !> Returns the points of (0, 1) where a quadratic function equals one of the bounds of the window. A double root counts twice. A
  !> constant function has none.
  pure subroutine find_cuts(places, window, cuts, n_cuts)
    !> [length] values of the function at 0, 1/2 and 1
    real(rk), intent(in) :: places(3)
    type(window_t), intent(in) :: window
    !> only the first n_cuts count, in no order
    real(rk), intent(out) :: cuts(most_cuts)
    integer, intent(out) :: n_cuts
    real(rk) :: bounds(2), discriminant, q
    integer :: i

    n_cuts = 0
    cuts = 0
    bounds = [window%minimum, window%maximum]
    do i = 1, 2
      if (abs(bounds(i)) >= huge(1.0_rk)) cycle
      associate (a => bend(places), b => slope_at_start(places), c => places(1) - bounds(i))
        discriminant = b**2 - 4 * a * c
        if (.not. discriminant >= 0) cycle
        q = -(b + sign(sqrt(discriminant), b)) / 2
        call keep_cut(q, a, cuts, n_cuts)
        call keep_cut(c, q, cuts, n_cuts)
      end associate
    end do
  end subroutine find_cuts

  !> Adds above / below to the cuts where this quotient lies in (0, 1).
  pure subroutine keep_cut(above, below, cuts, n_cuts)
    real(rk), intent(in) :: above
    real(rk), intent(in) :: below
    real(rk), intent(inout) :: cuts(most_cuts)
    integer, intent(inout) :: n_cuts

    if (above * sign(1.0_rk, below) <= 0 .or. abs(above) >= abs(below)) return
    n_cuts = n_cuts + 1
    cuts(n_cuts) = above / below
  end subroutine keep_cut

  !> Returns b of the function a s**2 + b s + c with the values `places` at s = 0, 1/2 and 1.
  pure real(rk) function slope_at_start(places)
    real(rk), intent(in) :: places(3)

    slope_at_start = 4 * (places(2) - places(1)) - (places(3) - places(1))
  end function slope_at_start

  !> Returns a of the function a s**2 + b s + c with the values `places` at s = 0, 1/2 and 1.
  pure real(rk) function bend(places)
    real(rk), intent(in) :: places(3)

    bend = 2 * (places(3) - places(1)) - 4 * (places(2) - places(1))
  end function bend
end module sig_curved_rule
