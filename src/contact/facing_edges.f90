! SPDX-License-Identifier: BSD-3-Clause
!> Which part of an edge in the plane faces which edge of another surface, seen along the edge's normals.
!>
!> Cuts are found on straight edges, with normals that change linearly from the first node to the second one; an edge of three
!> nodes counts as two of them. Points between the cuts lie on the edges as they are.
module sig_facing_edges
  use sig_edge_cuts, only: cut_edge, facing_piece_t
  use sig_element_types, only: element_types
  use sig_facet_shapes, only: facet_shape_t
  use sig_facing_points, only: facing_points_t
  use sig_kinds, only: rk
  use sig_mortar_sides, only: mortar_side_t
  implicit none(type, external)
  private
  public :: face_edge

  integer, parameter :: n_points = 4
  !> [-] Gauss on 0 to 1, exact for polynomials of degree 7
  real(rk), parameter :: outer = 0.5_rk * sqrt((3 + 2 * sqrt(1.2_rk)) / 7), inner = 0.5_rk * sqrt((3 - 2 * sqrt(1.2_rk)) / 7)
  real(rk), parameter :: places(n_points) = 0.5_rk + [-outer, -inner, inner, outer]
  real(rk), parameter :: weights(n_points) = 0.5_rk * [(18 - sqrt(30.0_rk)) / 36, (18 + sqrt(30.0_rk)) / 36, &
    (18 + sqrt(30.0_rk)) / 36, (18 - sqrt(30.0_rk)) / 36]

contains

  !> Adds the integration points of an edge of the first surface where it faces edges of the second one: cut_edge says which of them
  !> it faces where.
  subroutine face_edge(shapes, first, i_edge, second, near, limit, points)
    !> result of create_shapes
    type(facet_shape_t), intent(in) :: shapes(:)
    type(mortar_side_t), intent(in) :: first
    !> edge of the first surface, 1-based
    integer, intent(in) :: i_edge
    type(mortar_side_t), intent(in) :: second
    !> edges of the second surface that are searched, 1-based
    integer, intent(in) :: near(:)
    !> [length] search distance: points that face an edge farther away get is_far
    real(rk), intent(in) :: limit
    type(facing_points_t), intent(inout) :: points
    type(facing_piece_t), allocatable :: pieces(:)
    real(rk), allocatable :: ends(:, :, :)
    integer, allocatable :: i_other(:)
    integer :: i, i_part

    call list_chords(shapes, second, near, ends, i_other)
    associate (parts => shapes(first%types(i_edge))%parts)
      do i_part = 1, size(parts, 2)
        associate (own => first%offsets(i_edge) + parts(:2, i_part))
          call cut_edge(first%vertices(:, own), first%normals(:, own), ends, second%outward(:, i_other), limit, pieces)
        end associate
        pieces%i_other = i_other(pieces%i_other)
        do i = 1, size(pieces)
          call add_points(shapes, first, i_edge, parts(:2, i_part), second, pieces(i), points)
        end do
      end do
    end associate
  end subroutine face_edge

  !> Lists the straight parts of the edges with the numbers `edges` in a surface.
  pure subroutine list_chords(shapes, side, edges, ends, i_edge)
    type(facet_shape_t), intent(in) :: shapes(:)
    type(mortar_side_t), intent(in) :: side
    integer, intent(in) :: edges(:)
    !> [length] shape (2, 2, n): components, ends, parts
    real(rk), allocatable, intent(out) :: ends(:, :, :)
    !> number in the surface of the edge that each part belongs to, shape (n)
    integer, allocatable, intent(out) :: i_edge(:)
    integer :: i, i_part, n

    n = 0
    do i = 1, size(edges)
      n = n + size(shapes(side%types(edges(i)))%parts, 2)
    end do
    allocate (ends(2, 2, n), i_edge(n))
    n = 0
    do i = 1, size(edges)
      associate (parts => shapes(side%types(edges(i)))%parts)
        do i_part = 1, size(parts, 2)
          n = n + 1
          i_edge(n) = edges(i)
          ends(:, :, n) = side%vertices(:, side%offsets(edges(i)) + parts(:2, i_part))
        end do
      end associate
    end do
  end subroutine list_chords

  !> Adds the four integration points of one piece. A point for which no place on the other edge is found is left out.
  subroutine add_points(shapes, first, i_edge, part, second, piece, points)
    type(facet_shape_t), intent(in) :: shapes(:)
    type(mortar_side_t), intent(in) :: first
    integer, intent(in) :: i_edge
    !> numbers (1-based) among the edge's nodes of both ends of its straight part
    integer, intent(in) :: part(:)
    type(mortar_side_t), intent(in) :: second
    type(facing_piece_t), intent(in) :: piece
    type(facing_points_t), intent(inout) :: points
    real(rk) :: ends(2), normal(2), opposite(1), place(1), point(2)
    integer :: i
    logical :: is_found

    associate (shape => shapes(first%types(i_edge)), own => first%vertices(:, first%offsets(i_edge) + 1: &
      first%offsets(i_edge + 1)), normals => first%normals(:, first%offsets(i_edge) + 1:first%offsets(i_edge + 1)), &
      other => shapes(second%types(piece%i_other)), others => second%vertices(:, second%offsets(piece%i_other) + 1: &
      second%offsets(piece%i_other + 1)))
      ends = element_types(shape%i_type)%reference_nodes(1, part)
      do i = 1, n_points
        place = ends(1) + (ends(2) - ends(1)) * (piece%start + (piece%end - piece%start) * places(i))
        point = matmul(own, shape%values(place))
        normal = matmul(normals, shape%values(place))
        normal = normal / norm2(normal)
        associate (along => [normal(2), -normal(1)])
          call other%find_place(reshape(matmul(along, others) - dot_product(along, point), [1, size(others, 2)]), [0.0_rk], &
            opposite, is_found)
        end associate
        if (is_found) call points%add(piece%i_other, piece%is_far, norm2(shape%tangents(own, place)) * &
          abs(ends(2) - ends(1)) * (piece%end - piece%start) * weights(i), place, opposite, &
          dot_product(matmul(others, other%values(opposite)) - point, normal))
      end do
    end associate
  end subroutine add_points
end module sig_facing_edges
