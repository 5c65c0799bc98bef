! SPDX-License-Identifier: BSD-3-Clause
!> Which part of a facet in space faces which facets of another surface.
!>
!> All facets are projected to an auxiliary plane, along its normal (plane_of): the mean of the contact normals at the facet's
!> nodes. In this plane the facets are polygons, whose common parts are cut into triangles with integration points. M. A. Puso, T.
!> A. Laursen, Comput. Methods Appl. Mech. Engrg. 193 (2004) 601.
module sig_facing_facets
  use sig_convex_polygons, only: area_of, centroid_of, common_part, polygon_of, polygon_t, rest_of
  use sig_cross_products, only: cross_product
  use sig_element_types, only: element_type_with, element_types
  use sig_facet_shapes, only: facet_shape_t, max_corners
  use sig_facing_points, only: facing_points_t
  use sig_kinds, only: rk
  use sig_mortar_sides, only: mortar_side_t
  use sig_rounding, only: rounding
  implicit none(type, external)
  private
  public :: face_facet

  !> A facet seen in the auxiliary plane.
  type :: view_t
    !> number of the facet in its surface
    integer :: i_facet = 0
    !> row of element_types
    integer :: i_type = 0
    !> [length] two coordinates in the plane and the height above it, shape (3, n_nodes)
    real(rk), allocatable :: vertices(:, :)
    !> [-] contact normals along the same axes; of the first surface only
    real(rk), allocatable :: normals(:, :)
    !> whether the map from the reference element is not linear: bend_of is above 0.01
    logical :: is_bent = .false.
  end type view_t

  !> The auxiliary plane.
  type :: plane_t
    !> [length]
    real(rk) :: origin(3) = 0
    !> [-] two directions in the plane and its normal, one per row
    real(rk) :: axes(3, 3) = 0
  end type plane_t

  !> A part that two facets have in common.
  type :: common_t
    type(polygon_t) :: polygon
    !> number of the facet of the second surface among those that are searched
    integer :: i_view = 0
    !> [length] distance of the facets at the mean of its corners
    real(rk) :: distance = 0
  end type common_t

  !> [-] two normals are opposite enough for contact if their product is below this
  real(rk), parameter :: grazing = -0.1_rk
  !> [-] of a facet's extent: a smaller bend leaves the integrals exact to 1e-12
  real(rk), parameter :: noticed_bend = 0.01_rk
  !> the rule of the triangle with six nodes is exact for polynomials of degree 5
  integer, parameter :: n_nodes_of_rule = 6

contains

  !> Adds the integration points of a facet of the first surface where it faces facets of the second one. If several of these lie
  !> one behind the other, the nearest one counts. Let n be the normal of the auxiliary plane (plane_of). A facet of the second
  !> surface counts only if the product of its outward normal and n is below -0.1. The facet of the first surface gets no points if
  !> the product of its outward normal and n is at most 0.1.
  subroutine face_facet(shapes, first, i_facet, second, near, limit, points)
    !> result of create_shapes
    type(facet_shape_t), intent(in) :: shapes(:)
    type(mortar_side_t), intent(in) :: first
    !> facet of the first surface, 1-based
    integer, intent(in) :: i_facet
    type(mortar_side_t), intent(in) :: second
    !> facets of the second surface that are searched, 1-based
    integer, intent(in) :: near(:)
    !> [length] search distance: points that face a facet farther away get is_far
    real(rk), intent(in) :: limit
    type(facing_points_t), intent(inout) :: points
    type(plane_t) :: plane
    type(view_t) :: own
    type(view_t), allocatable :: others(:)
    type(common_t), allocatable :: commons(:)
    integer :: i

    plane = plane_of(first, i_facet)
    if (dot_product(plane%axes(3, :), first%outward(:, i_facet)) <= -grazing) return
    own = view_of(shapes, plane, first, i_facet)
    own%normals = matmul(plane%axes, first%normals(:, first%offsets(i_facet) + 1:first%offsets(i_facet + 1)))
    allocate (others(size(near)))
    do i = 1, size(near)
      if (dot_product(plane%axes(3, :), second%outward(:, near(i))) < grazing) others(i) = view_of(shapes, plane, second, near(i))
    end do
    call find_commons(shapes, own, others, commons)
    do i = 1, size(commons)
      call add_points(shapes, own, others(commons(i)%i_view), commons(i), limit, points)
    end do
  end subroutine face_facet

  !> Returns the auxiliary plane of a facet of the first surface, through the mean place of its nodes. Its normal is the mean
  !> contact normal of the nodes, or the facet's outward normal where these cancel.
  pure type(plane_t) function plane_of(side, i_facet) result(plane)
    type(mortar_side_t), intent(in) :: side
    integer, intent(in) :: i_facet
    integer :: least

    associate (from => side%offsets(i_facet) + 1, to => side%offsets(i_facet + 1))
      plane%origin = sum(side%vertices(:, from:to), dim=2) / (to - from + 1)
      plane%axes(3, :) = sum(side%normals(:, from:to), dim=2)
    end associate
    if (.not. norm2(plane%axes(3, :)) > 0) plane%axes(3, :) = side%outward(:, i_facet)
    plane%axes(3, :) = plane%axes(3, :) / norm2(plane%axes(3, :))
    least = minloc(abs(plane%axes(3, :)), dim=1)
    plane%axes(1, least) = 1
    plane%axes(1, :) = plane%axes(1, :) - plane%axes(3, least) * plane%axes(3, :)
    plane%axes(1, :) = plane%axes(1, :) / norm2(plane%axes(1, :))
    plane%axes(2, :) = cross_product(plane%axes(3, :), plane%axes(1, :))
  end function plane_of

  !> Returns a facet of either surface in the coordinates of the auxiliary plane, without its contact normals.
  pure type(view_t) function view_of(shapes, plane, side, i_facet) result(view)
    type(facet_shape_t), intent(in) :: shapes(:)
    type(plane_t), intent(in) :: plane
    type(mortar_side_t), intent(in) :: side
    integer, intent(in) :: i_facet

    view%i_facet = i_facet
    view%i_type = side%types(i_facet)
    associate (vertices => side%vertices(:, side%offsets(i_facet) + 1:side%offsets(i_facet + 1)))
      view%vertices = matmul(plane%axes, vertices - spread(plane%origin, 2, size(vertices, 2)))
    end associate
    view%is_bent = bend_of(shapes(view%i_type), view%vertices(:2, :)) > noticed_bend
  end function view_of

  !> Returns how far [-] the nodes of a facet lie from the places that the tangents in its middle give, relative to its extent.
  pure real(rk) function bend_of(shape, flat) result(bend)
    type(facet_shape_t), intent(in) :: shape
    !> [length] nodes in the auxiliary plane, shape (2, n_nodes)
    real(rk), intent(in) :: flat(:, :)
    real(rk) :: middle(2), tangents(2, 2)
    integer :: k

    bend = 0
    middle = matmul(flat, shape%values(shape%middle))
    tangents = shape%tangents(flat, shape%middle)
    do k = 1, size(flat, 2)
      associate (straight => middle + matmul(tangents, element_types(shape%i_type)%reference_nodes(:2, k) - shape%middle))
        bend = max(bend, norm2(flat(:, k) - straight))
      end associate
    end do
    bend = bend / maxval(maxval(flat, dim=2) - minval(flat, dim=2))
  end function bend_of

  !> Finds all parts that a facet has in common with others. If others lie one behind the other, the nearest one counts.
  subroutine find_commons(shapes, own, others, commons)
    type(facet_shape_t), intent(in) :: shapes(:)
    !> the facet of the first surface
    type(view_t), intent(in) :: own
    !> facets of the second surface; those without vertices are left out
    type(view_t), intent(in) :: others(:)
    type(common_t), allocatable, intent(out) :: commons(:)
    type(common_t), allocatable :: found(:)
    type(polygon_t) :: polygon
    real(rk) :: smallest
    integer :: i, i_part, j_part

    allocate (found(0))
    associate (shape => shapes(own%i_type))
      do i_part = 1, size(shape%parts, 2)
        polygon = part_of(own, shape%parts(:, i_part))
        smallest = rounding * area_of(polygon)
        do i = 1, size(others)
          if (.not. allocated(others(i)%vertices)) cycle
          associate (other => shapes(others(i)%i_type))
            do j_part = 1, size(other%parts, 2)
              call append_common(common_part(polygon, part_of(others(i), other%parts(:, j_part))), i, smallest, found)
            end do
          end associate
        end do
      end do
      do i = 1, size(found)
        found(i)%distance = distance_at(shapes, own, others(found(i)%i_view), centroid_of(found(i)%polygon))
      end do
    end associate
    call keep_nearest(found, smallest, commons)
  end subroutine find_commons

  pure type(polygon_t) function part_of(view, part) result(polygon)
    type(view_t), intent(in) :: view
    !> nodes, filled up with 0
    integer, intent(in) :: part(max_corners)

    polygon = polygon_of(view%vertices(:2, pack(part, part > 0)))
  end function part_of

  pure subroutine append_common(polygon, i_view, smallest, found)
    type(polygon_t), intent(in) :: polygon
    integer, intent(in) :: i_view
    !> [length**2]
    real(rk), intent(in) :: smallest
    type(common_t), allocatable, intent(inout) :: found(:)
    type(common_t) :: common

    if (area_of(polygon) <= smallest) return
    common%polygon = polygon
    common%i_view = i_view
    found = [found, common]
  end subroutine append_common

  !> Returns the distance [length] from one facet to the other along the plane's normal, negative where they overlap; huge if a
  !> facet has no place at the point.
  pure real(rk) function distance_at(shapes, own, other, point) result(distance)
    type(facet_shape_t), intent(in) :: shapes(:)
    type(view_t), intent(in) :: own, other
    !> [length] in the plane
    real(rk), intent(in) :: point(:)
    real(rk) :: place(2), opposite(2)
    logical :: is_found

    distance = huge(distance)
    call find_places(shapes, own, other, point, place, opposite, is_found)
    if (is_found) distance = height_at(shapes, other, opposite) - height_at(shapes, own, place)
  end function distance_at

  !> Finds the places of both facets at a point of the plane: `place` of the facet `own`, `opposite` of `other`.
  pure subroutine find_places(shapes, own, other, point, place, opposite, is_found)
    type(facet_shape_t), intent(in) :: shapes(:)
    type(view_t), intent(in) :: own, other
    !> [length] in the plane
    real(rk), intent(in) :: point(:)
    !> [-] in the reference elements
    real(rk), intent(out) :: place(2), opposite(2)
    !> both places were found
    logical, intent(out) :: is_found

    opposite = 0
    call shapes(own%i_type)%find_place(own%vertices(:2, :), point, place, is_found)
    if (is_found) call shapes(other%i_type)%find_place(other%vertices(:2, :), point, opposite, is_found)
  end subroutine find_places

  !> Returns the height [length] of a facet above the auxiliary plane.
  pure real(rk) function height_at(shapes, view, place) result(height)
    type(facet_shape_t), intent(in) :: shapes(:)
    type(view_t), intent(in) :: view
    !> [-] in the reference element
    real(rk), intent(in) :: place(:)

    height = dot_product(view%vertices(3, :), shapes(view%i_type)%values(place))
  end function height_at

  !> Removes from each part what it has in common with nearer ones: those of a smaller distance in size. What is left may be several
  !> polygons, which keep the distance of their part. A part whose distance is not known (huge) is left out.
  pure subroutine keep_nearest(found, smallest, commons)
    type(common_t), intent(in) :: found(:)
    !> [length**2] rests of at most this area are left out
    real(rk), intent(in) :: smallest
    type(common_t), allocatable, intent(out) :: commons(:)
    type(polygon_t), allocatable :: left(:), pieces(:), rest(:)
    logical :: is_taken(size(found))
    integer :: i, i_left, i_nearest, i_round, n_before

    is_taken = abs(found%distance) >= huge(1.0_rk)
    allocate (commons(0))
    do i_round = 1, count(.not. is_taken)
      i_nearest = minloc(abs(found%distance), dim=1, mask=.not. is_taken)
      is_taken(i_nearest) = .true.
      left = [found(i_nearest)%polygon]
      n_before = size(commons)
      do i = 1, n_before
        allocate (rest(0))
        do i_left = 1, size(left)
          call rest_of(left(i_left), commons(i)%polygon, smallest, pieces)
          rest = [rest, pieces]
        end do
        call move_alloc(rest, left)
      end do
      do i_left = 1, size(left)
        commons = [commons, common_t(left(i_left), found(i_nearest)%i_view, found(i_nearest)%distance)]
      end do
    end do
  end subroutine keep_nearest

  !> Adds the points of triangles around the mean of a common part's corners, or of the part itself if it is a triangle: seven for
  !> each triangle, or 28 if a facet is bent (view_t). A point at which a facet has no place is left out.
  pure subroutine add_points(shapes, own, other, common, limit, points)
    type(facet_shape_t), intent(in) :: shapes(:)
    type(view_t), intent(in) :: own, other
    type(common_t), intent(in) :: common
    !> [length] all points get is_far if the distance of the part is larger in size
    real(rk), intent(in) :: limit
    type(facing_points_t), intent(inout) :: points
    real(rk) :: triangle(2, 3)
    integer :: i, k

    associate (polygon => common%polygon, is_far => abs(common%distance) > limit)
      do i = 1, merge(1, polygon%n, polygon%n == 3)
        triangle(:, 1) = centroid_of(polygon)
        if (polygon%n == 3) triangle(:, 1) = polygon%corners(:, 3)
        triangle(:, 2:) = polygon%corners(:, [i, modulo(i, polygon%n) + 1])
        if (.not. (own%is_bent .or. other%is_bent)) then
          call add_triangle(shapes, own, other, triangle, is_far, points)
          cycle
        end if
        ! the integrand is no polynomial: four smaller triangles
        do k = 1, 3
          call add_triangle(shapes, own, other, (triangle + spread(triangle(:, k), 2, 3)) / 2, is_far, points)
        end do
        call add_triangle(shapes, own, other, (triangle + cshift(triangle, 1, dim=2)) / 2, is_far, points)
      end do
    end associate
  end subroutine add_points

  pure subroutine add_triangle(shapes, own, other, triangle, is_far, points)
    type(facet_shape_t), intent(in) :: shapes(:)
    type(view_t), intent(in) :: own, other
    !> [length] in the plane
    real(rk), intent(in) :: triangle(2, 3)
    logical, intent(in) :: is_far
    type(facing_points_t), intent(inout) :: points
    real(rk) :: normal(3), opposite(2), place(2), sides(2, 2), weight
    integer :: i
    logical :: is_found

    sides = triangle(:, 2:) - spread(triangle(:, 1), 2, 2)
    associate (rule => shapes(element_type_with(2, n_nodes_of_rule)), shape => shapes(own%i_type))
      do i = 1, size(rule%weights)
        call find_places(shapes, own, other, triangle(:, 1) + matmul(sides, rule%points(:, i)), place, opposite, is_found)
        if (.not. is_found) cycle
        weight = abs(sides(1, 1) * sides(2, 2) - sides(1, 2) * sides(2, 1)) * rule%weights(i)
        normal = matmul(own%normals, shape%values(place))
        call points%add(other%i_facet, is_far, weight * stretch_at(shape, own%vertices, place), place, opposite, &
          (height_at(shapes, other, opposite) - height_at(shapes, own, place)) * normal(3) / norm2(normal))
      end do
    end associate
  end subroutine add_triangle

  !> Returns the area of a facet over that of its image in the plane [-], at a place of the reference element.
  pure real(rk) function stretch_at(shape, vertices, place) result(stretch)
    type(facet_shape_t), intent(in) :: shape
    !> [length] nodes in coordinates of the plane, shape (3, n_nodes)
    real(rk), intent(in) :: vertices(:, :), place(:)
    real(rk) :: area_vector(3), tangents(3, 2)

    tangents = shape%tangents(vertices, place)
    area_vector = cross_product(tangents(:, 1), tangents(:, 2))
    stretch = norm2(area_vector) / abs(area_vector(3))
  end function stretch_at
end module sig_facing_facets
