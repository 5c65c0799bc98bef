! SPDX-License-Identifier: BSD-3-Clause
!> Integration over the part of a facet that lies in a window `minimum <= coordinate <= maximum`, exact on the cut.
!>
!> An edge is cut to a piece of itself. A face is the image of a unit square (s, t) on which the coordinate is bilinear: at each s
!> the window leaves a piece of t, whose ends are rational functions of s between those s where a bound crosses a side. Gauss
!> points in t on that piece and in s between these borders are exact for triangles and parallelograms (polynomials), and to 1e-9
!> or better for quadrilaterals whose opposite sides differ by a factor of 5. The integral is a continuous function of the window.
!> Quadratic facets: curved_rule.f90.
module sig_window_rule
  use sig_cross_products, only: cross_product
  use sig_curved_rule, only: add_curved_edge, add_curved_face
  use sig_element_types, only: corner_type, element_type_with, element_types
  use sig_facet_points, only: add_point, facet_rule_t, fine_points, fine_weights, gauss_points, gauss_weights, make_room, &
    n_fine, n_gauss, window_t
  use sig_kinds, only: rk
  use sig_shape_functions, only: shape_coefficients, shape_values
  implicit none(type, external)
  private
  public :: facet_rule, find_facet_rule, facet_position, facet_box
  public :: facet_outside, facet_cut, facet_inside

  !> where a facet lies relative to a window
  integer, parameter :: facet_outside = 0, facet_cut = 1, facet_inside = 2

  !> [-] of a facet's size: a node this little outside is inside (rounding of coordinates and bounds, in any unit)
  real(rk), parameter :: node_tolerance = 1.0e-9_rk
  !> nodes of a triangle at (0, 0), (1, 0), (1, 1), (0, 1)
  integer, parameter :: triangle_corners(4) = [1, 2, 2, 3]
  !> of a linear face
  integer, parameter :: most_corners = 4
  !> both ends, and two bounds on two sides
  integer, parameter :: most_borders = 6

contains

  !> Returns the rule for an edge (n_dim = 2) or a triangle or quadrilateral (n_dim = 3).
  pure function facet_rule(vertices, window) result(rule)
    !> [length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    type(facet_rule_t) :: rule

    call find_facet_rule(vertices, window, rule)
    if (rule%n_points == size(rule%places, 2)) return
    rule%places = rule%places(:, :rule%n_points)
    rule%values = rule%values(:, :rule%n_points)
    rule%area_vectors = rule%area_vectors(:, :rule%n_points)
  end function facet_rule

  !> As facet_rule, in arrays that are kept from facet to facet where they are large enough: only the first n_points count then.
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

  pure integer function position_of(vertices, window) result(position)
    real(rk), intent(in) :: vertices(:, :)
    type(window_t), intent(in) :: window
    real(rk) :: lower(size(vertices, 1)), upper(size(vertices, 1))

    position = facet_inside
    if (window%axis == 0) return
    call facet_box(vertices, window%is_cut, lower, upper)
    position = facet_position(lower, upper, window)
  end function position_of

  !> Box of the nodes; of a facet that is cut, whose middle may bulge beyond them, at least as large as the facet.
  !>
  !> Its places are those of its corners' linear facet plus sum_i N_i d_i with d_i the further nodes' offset from there, |N_i| <= 1.
  pure subroutine facet_box(vertices, is_cut, lower, upper)
    !> [length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: vertices(:, :)
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

  !> From where to where on (0, 1) a coordinate that goes from first to last lies between the bounds; where it never does, the
  !> end is not behind the start.
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

  !> The face is the image of the unit square (s, t); of a triangle the side s = 1 has shrunk to the second node.
  pure subroutine cut_face(vertices, window, rule)
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

  !> The quadrilateral's corners in the sense, and in the order, in which the coordinate grows along t as evenly as it can: where a
  !> bound cuts the face is a function t(s) with a pole at the s where the coordinate does not grow.
  pure function best_corners(places) result(corners)
    !> [length] coordinate of the nodes
    real(rk), intent(in) :: places(4)
    integer :: corners(4)

    corners = [1, 2, 3, 4]
    if (evenness(places([1, 4, 3, 2])) > evenness(places)) corners = [1, 4, 3, 2]
  end function best_corners

  !> Smaller over larger growth of the coordinate along t on the sides s = 0 and s = 1; 0 where one grows and one falls.
  pure real(rk) function evenness(places)
    !> [length] coordinate of the corners (0, 0), (1, 0), (1, 1), (0, 1)
    real(rk), intent(in) :: places(4)
    real(rk) :: growth(2)

    growth = [places(4) - places(1), places(3) - places(2)]
    evenness = 0
    if (growth(1) * growth(2) > 0) evenness = minval(abs(growth)) / maxval(abs(growth))
  end function evenness

  !> Ends of strips of s, within which no bound crosses a side t = 0 or t = 1.
  pure subroutine find_borders(places, window, borders, n_strips)
    real(rk), intent(in) :: places(4)
    type(window_t), intent(in) :: window
    !> ascending; the first n_strips + 1 count
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

  !> How many values of s a strip needs. What a bound cuts of a triangle is a polynomial of s, of a quadrilateral the less one the
  !> less even the coordinate grows.
  pure integer function outer_points(places, window, strip, is_triangle) result(n_points)
    real(rk), intent(in) :: places(4)
    type(window_t), intent(in) :: window
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

  !> From where to where in t the window leaves the face at one s.
  pure function piece_at(places, s, window) result(piece)
    !> [length] coordinate of the corners
    real(rk), intent(in) :: places(4)
    real(rk), intent(in) :: s
    type(window_t), intent(in) :: window
    real(rk) :: piece(2)

    piece = piece_inside((1 - s) * places(1) + s * places(2), (1 - s) * places(4) + s * places(3), window)
  end function piece_at

  pure subroutine add_strip(vertices, corners, window, strip, n_outer, rule)
    real(rk), intent(in) :: vertices(:, :)
    !> nodes at (0, 0), (1, 0), (1, 1), (0, 1)
    integer, intent(in) :: corners(4)
    type(window_t), intent(in) :: window
    !> from where to where in s
    real(rk), intent(in) :: strip(2)
    !> n_gauss, n_fine, or none
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

  !> Gauss points along t at one s.
  pure subroutine add_line(vertices, corners, s, piece, weight_of_s, rule)
    real(rk), intent(in) :: vertices(:, :)
    integer, intent(in) :: corners(4)
    real(rk), intent(in) :: s
    !> from where to where in t
    real(rk), intent(in) :: piece(2)
    real(rk), intent(in) :: weight_of_s
    type(facet_rule_t), intent(inout) :: rule
    real(rk) :: along_s(3), along_t(3), length, t, values(4)
    integer :: j

    length = max(0.0_rk, piece(2) - piece(1))
    along_t = (1 - s) * (vertices(:, corners(4)) - vertices(:, corners(1))) + &
      s * (vertices(:, corners(3)) - vertices(:, corners(2)))
    ! the other order of the corners turns the face over
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
