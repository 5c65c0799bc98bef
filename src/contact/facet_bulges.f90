! SPDX-License-Identifier: BSD-3-Clause
!> How far a smooth surface stands out from its linear facets.
!>
!> The nodes of linear elements lie on the surface that was meshed. In the middle of an edge of length h, the distance of the facet
!> from the surface is h**2 / (8 R). If the facets of two surfaces do not match, gaps have an error of this size that varies from
!> place to place, and pressures have an error of about E h / (8 R). So each edge is replaced by an arc, which follows from the
!> normals of the surface at its ends. Normals: N. Max, Journal of Graphics Tools 4 (1999) no. 2, 1: exact where the nodes lie on a
!> sphere or, in the plane, on a circle.
module sig_facet_bulges
  use, intrinsic :: iso_fortran_env, only: int64
  use sig_cross_products, only: cross_product
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: find_bulges

  !> cosine of 20 degrees: if facets of a node lean more from its normal, the surface has a sharp edge there
  real(rk), parameter :: smooth_cosine = 0.93969262078590838_rk

  !> Data of a surface at its nodes, shape (largest node).
  type :: surface_nodes_t
    !> [-] outward, shape (n_dim, largest node)
    real(rk), allocatable :: normals(:, :)
    logical, allocatable :: is_smooth(:)
    !> [-] in the plane: sum of the unit vectors from the node along its edges, near 0 where two edges continue each other. In
    !> space: difference of the unit vectors along its two edges on the border, of length 2 where the border is straight; 0 where
    !> facets surround the node. Shape (n_dim, largest node)
    real(rk), allocatable :: border(:, :)
    !> in space, with the numbers a and b of the two nodes beside it on the border: a - b and a**2 - b**2; 0 where facets surround
    !> the node; shape (2, largest node)
    integer(int64), allocatable :: neighbors(:, :)
  end type surface_nodes_t

contains

  !> Computes the height of each curved edge above the middle of its chord, for the edges from each corner to the next one. In the
  !> plane a facet has one edge.
  pure subroutine find_bulges(offsets, nodes, vertices, outward, n_corners, bulges)
    !> the values at the nodes of facet i are entries offsets(i) + 1 ... offsets(i + 1)
    integer, intent(in) :: offsets(:)
    !> nodes of the facets, natural, 1-based
    integer, intent(in) :: nodes(:)
    !> [length] shape (n_dim, size(nodes))
    real(rk), intent(in) :: vertices(:, :)
    !> [-] normals of the facets, shape (n_dim, n_facets)
    real(rk), intent(in) :: outward(:, :)
    !> number of corners of each facet; 0 = a facet that is curved itself, which gets no heights
    integer, intent(in) :: n_corners(:)
    !> [length] positive outward; shape (size(nodes)): entry offsets(i) + k is that of the edge from corner k of facet i to the next
    !> one, all others are 0. It is 0, too, where the ends bend in opposite directions, or where the slope is known at neither end
    !> and complete_triangle does not find the height
    real(rk), allocatable, intent(out) :: bulges(:)
    type(surface_nodes_t) :: surface
    logical :: is_known(size(nodes))
    integer :: i, k, n, next

    allocate (bulges(size(nodes)), source=0.0_rk)
    surface = nodes_of_surface(offsets, nodes, vertices, outward, n_corners)
    do i = 1, size(n_corners)
      n = n_corners(i)
      do k = 1, merge(1, n, n == 2)
        associate (first => offsets(i) + k)
          next = offsets(i) + modulo(k, n) + 1
          call find_height(surface, nodes([first, next]), vertices(:, next) - vertices(:, first), outward(:, i), bulges(first), &
            is_known(first))
        end associate
      end do
      if (n == 3) call complete_triangle(vertices(:, offsets(i) + 1:), is_known(offsets(i) + 1:), bulges(offsets(i) + 1:))
    end do
  end subroutine find_bulges

  !> If exactly two of the three heights of a triangle are known, computes the third from them: the smallest of all curvatures that
  !> these allow. Otherwise nothing changes. Such triangles are at corners of the surface.
  pure subroutine complete_triangle(vertices, is_known, heights)
    !> [length] the corners first
    real(rk), intent(in) :: vertices(:, :)
    !> whether the heights of the edges from each corner to the next one are known
    logical, intent(in) :: is_known(:)
    !> [length] heights of the same edges
    real(rk), intent(inout) :: heights(:)
    real(rk) :: a(3), b(3), product
    integer :: i

    if (count(is_known(:3)) /= 2) return
    i = findloc(is_known(:3), .false., dim=1)
    associate (after => modulo(i, 3) + 1, before => modulo(i - 2, 3) + 1)
      a = vertices(:, before) - vertices(:, after)
      b = vertices(:, i) - vertices(:, before)
      ! height = e . C e / 8 with C = alpha a a' + beta b b'
      product = dot_product(a, b)
      associate (aa => sum(a**2), bb => sum(b**2), determinant => sum(a**2)**2 * sum(b**2)**2 - product**4)
        heights(i) = ((heights(after) * bb**2 - heights(before) * product**2) * (aa + product)**2 + &
          (heights(before) * aa**2 - heights(after) * product**2) * (bb + product)**2) / determinant
      end associate
    end associate
  end subroutine complete_triangle

  !> Computes the height over the middle of an edge from the slopes at its ends. The smaller slope (in size) counts, because one end
  !> may be next to a sharp edge.
  !> If the slope is known at one end only, this end counts. The height is 0 if it is known at none, or if the ends bend in opposite
  !> directions.
  pure subroutine find_height(surface, ends, along, normal, height, is_known)
    type(surface_nodes_t), intent(in) :: surface
    !> two nodes
    integer, intent(in) :: ends(:)
    !> [length] from the first node to the second one
    real(rk), intent(in) :: along(:)
    !> [-] normal of the facet
    real(rk), intent(in) :: normal(:)
    !> [length] positive outward
    real(rk), intent(out) :: height
    !> whether the slope of the surface is known at one end at least
    logical, intent(out) :: is_known
    real(rk) :: rises(2)
    logical :: knows(2)
    integer :: i

    knows = [(surface%is_smooth(ends(i)) .and. is_seen(surface, ends(i), ends(3 - i)), i=1, 2)]
    height = 0
    is_known = any(knows)
    if (.not. is_known) return
    rises = 0
    do i = 1, 2
      if (knows(i)) rises(i) = (2 * i - 3) * dot_product(surface%normals(:, ends(i)), along) / &
        dot_product(surface%normals(:, ends(i)), normal)
    end do
    if (all(knows) .and. rises(1) * rises(2) <= 0) return
    i = minloc(abs(rises), dim=1, mask=knows)
    ! of a circle: the chord times half the tangent of half the angle between chord and arc
    height = rises(i) / (2 * (1 + sqrt(1 + rises(i)**2 / sum(along**2))))
  end subroutine find_height

  !> Whether the facets at a node tell the slope of the surface there towards another node. Requires: the surface is smooth at the
  !> node. In the plane: two edges meet at the node, and one nearly continues the other. In space: facets stand all round the node,
  !> or the border goes nearly straight on at the node and the other node is next to it on this border.
  pure logical function is_seen(surface, node, other)
    type(surface_nodes_t), intent(in) :: surface
    integer, intent(in) :: node, other
    !> [-] lengths of surface%border: below one_edge, two edges in the plane meet nearly straight; above straight, the border in
    !> space is nearly straight
    real(rk), parameter :: one_edge = 0.8_rk, straight = 1.9_rk

    associate (border => surface%border(:, node), difference => surface%neighbors(1, node), squares => surface%neighbors(2, node))
      if (size(border) == 2) then
        is_seen = norm2(border) < one_edge
      else if (difference == 0) then
        is_seen = squares == 0
      else
        is_seen = norm2(border) > straight .and. &
          abs(2 * other - squares / difference) == abs(difference)
      end if
    end associate
  end function is_seen

  !> Returns all data of surface_nodes_t for a surface. The arguments are those of find_bulges.
  pure function nodes_of_surface(offsets, nodes, vertices, outward, n_corners) result(surface)
    integer, intent(in) :: offsets(:), nodes(:)
    real(rk), intent(in) :: vertices(:, :), outward(:, :)
    integer, intent(in) :: n_corners(:)
    type(surface_nodes_t) :: surface
    integer :: i, k

    allocate (surface%normals(size(vertices, 1), maxval(nodes)), surface%border(size(vertices, 1), maxval(nodes)), source=0.0_rk)
    allocate (surface%neighbors(2, maxval(nodes)), source=0_int64)
    do i = 1, size(n_corners)
      do k = 1, n_corners(i)
        associate (from => offsets(i) + 1, to => offsets(i) + n_corners(i))
          call add_corner(nodes(from:to), vertices(:, from:to), outward(:, i), k, surface)
        end associate
      end do
    end do
    allocate (surface%is_smooth(maxval(nodes)), source=.true.)
    do i = 1, maxval(nodes)
      associate (normal => surface%normals(:, i))
        normal = normal / max(norm2(normal), tiny(1.0_rk))
      end associate
    end do
    do i = 1, size(n_corners)
      do k = offsets(i) + 1, offsets(i) + n_corners(i)
        if (dot_product(surface%normals(:, nodes(k)), outward(:, i)) < smooth_cosine) surface%is_smooth(nodes(k)) = .false.
      end do
    end do
  end function nodes_of_surface

  !> Adds what a facet contributes at one of its corners to normals (not of length 1 yet), border and neighbors. In space an edge
  !> between two facets is added to border and neighbors once from either side, and cancels.
  pure subroutine add_corner(nodes, vertices, outward, corner, surface)
    !> corners of the facet in their order around it, natural
    integer, intent(in) :: nodes(:)
    !> [length] their places, shape (n_dim, n_corners)
    real(rk), intent(in) :: vertices(:, :)
    !> [-] normal of the facet
    real(rk), intent(in) :: outward(:)
    !> number of the corner in the facet, 1-based
    integer, intent(in) :: corner
    type(surface_nodes_t), intent(inout) :: surface
    real(rk) :: after(size(outward)), before(size(outward)), normal(size(outward)), turn
    integer(int64) :: ends(2)
    integer :: i_after, i_before

    i_after = modulo(corner, size(nodes)) + 1
    i_before = modulo(corner - 2, size(nodes)) + 1
    after = vertices(:, i_after) - vertices(:, corner)
    before = vertices(:, i_before) - vertices(:, corner)
    ends = nodes([i_after, i_before])
    associate (neighbors => surface%neighbors(:, nodes(corner)), normals => surface%normals(:, nodes(corner)), &
      border => surface%border(:, nodes(corner)))
      if (size(outward) == 2) then
        normals = normals + outward / norm2(after)
        border = border + after / norm2(after)
      else
        normal = cross_product(after, before)
        turn = sign(1.0_rk, dot_product(normal, outward))
        normals = normals + turn * normal / (sum(after**2) * sum(before**2))
        border = border + turn * (after / norm2(after) - before / norm2(before))
        neighbors = neighbors + nint(turn) * [ends(1) - ends(2), ends(1)**2 - ends(2)**2]
      end if
    end associate
  end subroutine add_corner
end module sig_facet_bulges
