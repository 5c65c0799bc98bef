! SPDX-License-Identifier: BSD-3-Clause
!> Cuts a straight edge in the plane into pieces, each of which faces one edge of another surface.
!>
!> A point of the edge faces what lies along its normal. The normals change linearly from the first node to the second one.
module sig_edge_cuts
  use sig_cross_products, only: plane_cross_product
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: facing_piece_t, cut_edge

  !> A part of an edge that faces one other edge.
  type :: facing_piece_t
    !> number of the other edge, 1-based; 0 = none
    integer :: i_other = 0
    !> [-] both ends of the piece: 0 at the edge's first node, 1 at its second one
    real(rk) :: start = 0
    real(rk) :: end = 1
    !> whether the other edge lies farther away than the limit
    logical :: is_far = .false.
  end type facing_piece_t

  !> [-] of the edge: cuts that are nearer to each other are one cut
  real(rk), parameter :: rounding = 1.0e-10_rk
  !> [-] of the other edge: a point may lie outside by this much, when its ends come out rounded
  real(rk), parameter :: margin = 1.0e-6_rk
  !> [-] two normals are opposite enough for contact if their product is at most this
  real(rk), parameter :: grazing = -0.1_rk

contains

  !> Cuts an edge at the places opposite to the nodes of all other edges. Each piece gets the nearest edge that its middle faces:
  !> the line through the middle along the normal there meets this edge, in front or behind, and the product of both normals is at
  !> most -0.1. Pieces that face no edge are left out.
  pure subroutine cut_edge(ends, normals, others, outward, limit, pieces)
    !> [length] places and [-] normals of the two nodes, shape (2, 2): components, nodes
    real(rk), intent(in) :: ends(:, :)
    real(rk), intent(in) :: normals(:, :)
    !> [length] places of both nodes of the other edges, shape (2, 2, n): components, nodes, edges
    real(rk), intent(in) :: others(:, :, :)
    !> [-] outward normals of the other edges, shape (2, n)
    real(rk), intent(in) :: outward(:, :)
    !> [length] pieces that face an edge farther away than this get is_far
    real(rk), intent(in) :: limit
    !> ascending along the edge; the numbers of the other edges are those in `others`
    type(facing_piece_t), allocatable, intent(out) :: pieces(:)
    type(facing_piece_t) :: piece
    real(rk), allocatable :: cuts(:)
    integer :: i

    cuts = cuts_of_edge(ends, normals, others)
    allocate (pieces(0))
    do i = 1, size(cuts) - 1
      piece%start = cuts(i)
      piece%end = cuts(i + 1)
      call find_nearest(ends, normals, others, outward, limit, piece)
      if (piece%i_other > 0) pieces = [pieces, piece]
    end do
  end subroutine cut_edge

  !> Returns the places of the cuts in ascending order: 0, the places between 0 and 1 opposite to nodes of the other edges, 1. Of
  !> places within 1e-10 of each other only one counts. The arguments are those of cut_edge.
  pure function cuts_of_edge(ends, normals, others) result(cuts)
    real(rk), intent(in) :: ends(:, :), normals(:, :), others(:, :, :)
    real(rk), allocatable :: cuts(:)
    real(rk) :: places(2 * size(others, 3)), smallest
    integer :: i, n

    do i = 1, size(others, 3)
      places(2 * i - 1) = place_opposite(ends, normals, others(:, 1, i))
      places(2 * i) = place_opposite(ends, normals, others(:, 2, i))
    end do
    allocate (cuts(size(places) + 2))
    cuts(1) = 0
    n = 1
    do
      smallest = minval([1.0_rk, pack(places, places > cuts(n) + rounding)])
      if (smallest >= 1 - rounding) exit
      n = n + 1
      cuts(n) = smallest
    end do
    cuts(n + 1) = 1
    cuts = cuts(:n + 1)
  end function cuts_of_edge

  !> Returns the place on the line of the edge whose normal meets a point: 0 at its first node, 1 at its second one, other values
  !> outside of the edge; huge if there is none.
  !>
  !> x(s) - p is parallel to n(s): a quadratic in s, of whose roots the one nearer to the middle of the edge counts.
  pure real(rk) function place_opposite(ends, normals, point) result(place)
    !> of the edge, as for cut_edge
    real(rk), intent(in) :: ends(:, :), normals(:, :)
    !> [length]
    real(rk), intent(in) :: point(:)
    real(rk) :: along(2), bent(2), constant, linear, q, root, square

    along = ends(:, 2) - ends(:, 1)
    bent = normals(:, 2) - normals(:, 1)
    constant = plane_cross_product(ends(:, 1) - point, normals(:, 1))
    linear = plane_cross_product(along, normals(:, 1)) + plane_cross_product(ends(:, 1) - point, bent)
    square = plane_cross_product(along, bent)
    place = huge(place)
    root = linear**2 - 4 * square * constant
    if (root < 0) return
    q = -(linear + sign(sqrt(root), linear)) / 2
    if (abs(q) > 0) place = constant / q
    if (abs(square) * huge(place) > abs(q)) then
      if (abs(q / square - 0.5_rk) < abs(place - 0.5_rk)) place = q / square
    end if
  end function place_opposite

  !> Sets i_other of a piece to the nearest other edge that its middle faces, and is_far to whether this edge is farther away than
  !> `limit` along the normal. If there is none, i_other is 0 and is_far has no meaning. The other arguments are those of cut_edge.
  pure subroutine find_nearest(ends, normals, others, outward, limit, piece)
    real(rk), intent(in) :: ends(:, :), normals(:, :), others(:, :, :), outward(:, :), limit
    !> in: start and end; out: also i_other and is_far
    type(facing_piece_t), intent(inout) :: piece
    real(rk) :: distance, nearest, normal(2), place, point(2)
    integer :: i

    place = (piece%start + piece%end) / 2
    point = point_of_edge(ends, place)
    normal = normal_of_edge(normals, place)
    piece%i_other = 0
    nearest = huge(nearest)
    do i = 1, size(others, 3)
      if (dot_product(normal, outward(:, i)) > grazing) cycle
      call meet_edge(point, normal, others(:, :, i), place, distance)
      if (place < -margin .or. place > 1 + margin .or. abs(distance) >= nearest) cycle
      nearest = abs(distance)
      piece%i_other = i
    end do
    piece%is_far = nearest > limit
  end subroutine find_nearest

  !> Returns the point of an edge at a place: 0 at its first node, 1 at its second one.
  pure function point_of_edge(ends, place) result(point)
    real(rk), intent(in) :: ends(:, :)
    real(rk), intent(in) :: place
    real(rk) :: point(2)

    point = (1 - place) * ends(:, 1) + place * ends(:, 2)
  end function point_of_edge

  !> Returns the unit normal of an edge at a place, 0 to 1 as for point_of_edge.
  pure function normal_of_edge(normals, place) result(normal)
    real(rk), intent(in) :: normals(:, :)
    real(rk), intent(in) :: place
    real(rk) :: normal(2)

    normal = (1 - place) * normals(:, 1) + place * normals(:, 2)
    normal = normal / norm2(normal)
  end function normal_of_edge

  !> Computes where the line through a point along a normal meets the line of an edge, and how far away. Requires: they are not
  !> parallel.
  pure subroutine meet_edge(point, normal, ends, place, distance)
    !> [length]
    real(rk), intent(in) :: point(:)
    !> unit normal
    real(rk), intent(in) :: normal(:)
    !> [length] of the edge, shape (2, 2): components, nodes
    real(rk), intent(in) :: ends(:, :)
    !> [-] 0 at the edge's first node, 1 at its second one, other values outside of the edge
    real(rk), intent(out) :: place
    !> [length] along the normal, negative behind the point
    real(rk), intent(out) :: distance

    place = -plane_cross_product(ends(:, 1) - point, normal) / plane_cross_product(ends(:, 2) - ends(:, 1), normal)
    distance = dot_product(point_of_edge(ends, place) - point, normal)
  end subroutine meet_edge
end module sig_edge_cuts
