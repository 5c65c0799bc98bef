! SPDX-License-Identifier: BSD-3-Clause
!> Dual mortar contact of two surfaces whose nodes need not match: integrals over the facets of the first surface.
!>
!> The dual functions Phi_j of a facet are the combinations of its shape functions N_k with integral Phi_j N_k = delta_jk integral
!> N_k over the part of the facet that faces the second surface; where facets have weak corners, N_k are the functions of
!> sig_changed_basis. Everything is computed once, on the undeformed mesh.
module sig_mortar_surfaces
  use sig_element_types, only: n_element_types
  use sig_facet_shapes, only: create_shapes, facet_shape_t
  use sig_facing_edges, only: face_edge
  use sig_facing_facets, only: face_facet
  use sig_facing_points, only: facing_points_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: invert
  use sig_mechanical_models, only: circumference, mechanical_model_t
  use sig_mortar_sides, only: mortar_side_t
  use sig_mortar_sums, only: mortar_sums_t
  use sig_smooth_surfaces, only: bulge_along, bulge_at
  implicit none(type, external)
  private
  public :: integrate_mortar

  !> [-] a facet of which less faces the second surface counts as one that faces nothing: its dual functions would be huge
  real(rk), parameter :: least_cover = 0.05_rk

contains

  !> Computes areas, mean gaps and shares by integrals over all facets of the first surface that face the second one. A facet of
  !> which less than 5 % faces the second surface within `limit`, or which has no dual functions (find_dual), adds to sums%lost
  !> instead. Cost: O(n log n) in the number of facets.
  subroutine integrate_mortar(model, n_nodes, first, second, limit, sums)
    type(mechanical_model_t), intent(in) :: model
    !> number of nodes of the mesh
    integer, intent(in) :: n_nodes
    !> both surfaces, the first one with normals
    type(mortar_side_t), intent(in) :: first, second
    !> [length] search distance: parts that face the second surface beyond it only count in sums%far
    real(rk), intent(in) :: limit
    type(mortar_sums_t), intent(out) :: sums
    type(facet_shape_t) :: shapes(n_element_types)
    type(facing_points_t) :: points
    integer, allocatable :: near(:)
    integer :: i

    call create_shapes(model%n_dim, shapes)
    call sums%start(n_nodes)
    do i = 1, first%n_facets
      call find_candidates(first, i, second, limit, near)
      call points%clear(model%n_dim - 1)
      if (model%n_dim == 2) then
        call face_edge(shapes, first, i, second, near, limit, points)
      else
        call face_facet(shapes, first, i, second, near, limit, points)
      end if
      call integrate_facet(model, shapes, first, i, second, points, sums)
    end do
  end subroutine integrate_mortar

  !> Finds the facets of the second surface that the lines along the normals of a facet can meet: in space at any distance, in the
  !> plane, where the lines may diverge, at least those within the search distance.
  subroutine find_candidates(first, i_facet, second, limit, near)
    type(mortar_side_t), intent(in) :: first
    integer, intent(in) :: i_facet
    type(mortar_side_t), intent(in) :: second
    !> [length] search distance
    real(rk), intent(in) :: limit
    !> numbers of the facets of the second surface, 1-based
    integer, allocatable, intent(out) :: near(:)
    real(rk) :: middle(size(first%vertices, 1)), normal(size(first%vertices, 1)), radius
    integer :: n

    associate (from => first%offsets(i_facet) + 1, to => first%offsets(i_facet + 1))
      n = to - from + 1
      middle = sum(first%vertices(:, from:to), dim=2) / n
      normal = sum(first%normals(:, from:to), dim=2)
      normal = normal / max(norm2(normal), tiny(1.0_rk))
      radius = maxval(norm2(first%vertices(:, from:to) - spread(middle, 2, n), dim=1))
      ! in the plane the lines diverge
      if (size(middle) == 2) radius = radius + limit * maxval(norm2(first%normals(:, from:to) - spread(normal, 2, n), dim=1))
    end associate
    call second%balls%within(middle, radius, near, normal)
  end subroutine find_candidates

  !> Adds the integrals of one facet over the points at which it faces the second surface. integrate_mortar says what does not
  !> count.
  !>
  !> A row has one normal n_j. Usually the coefficient of a node is the value of the field there, also for a vector field. In a
  !> changed basis it is not: if a displacement is g n on a round surface, the coefficient of a mid-side node, along its normal n_j,
  !> is larger than g. Therefore the gap is larger, too: D_j = n_j . integral Phi_j g n / integral Phi_j, with n = sum N_k n_k.
  subroutine integrate_facet(model, shapes, first, i_facet, second, points, sums)
    type(mechanical_model_t), intent(in) :: model
    !> by the row of element_types
    type(facet_shape_t), intent(in) :: shapes(:)
    type(mortar_side_t), intent(in) :: first
    integer, intent(in) :: i_facet
    type(mortar_side_t), intent(in) :: second
    type(facing_points_t), intent(in) :: points
    type(mortar_sums_t), intent(inout) :: sums
    real(rk), allocatable :: dual(:, :), gaps(:), normals(:, :), values(:, :), weights(:)
    real(rk) :: whole
    logical :: is_singular
    integer :: p

    associate (from => first%offsets(i_facet) + 1, to => first%offsets(i_facet + 1), shape => shapes(first%types(i_facet)), &
      is_near => .not. points%is_far(:points%n))
      whole = area_of(model, shape, first%vertices(:, from:to))
      allocate (values(to - from + 1, points%n))
      do p = 1, points%n
        values(:, p) = shape%values(points%places(:, p))
      end do
      weights = points%weights(:points%n) * around(model, matmul(first%vertices(:, from:to), values))
      sums%whole = sums%whole + whole
      sums%far = sums%far + sum(weights, mask=.not. is_near)
      weights = merge(weights, 0.0_rk, is_near)
      if (.not. sum(weights) > 0) return
      if (first%is_changed(i_facet)) then
        normals = matmul(first%normals(:, from:to), values)
        values = matmul(shape%changed_basis, values)
      end if
      call find_dual(values, weights, dual, is_singular)
      if (sum(weights) < least_cover * whole .or. is_singular) then
        sums%lost = sums%lost + sum(weights)
        return
      end if
      sums%covered = sums%covered + sum(weights)
      values = values * spread(weights, 1, size(values, 1))
      sums%sizes(first%nodes(from:to)) = sums%sizes(first%nodes(from:to)) + sum(max(abs(matmul(dual, values)), abs(values)), dim=2)
      values = matmul(dual, values)
      call add_shares(shapes, first%nodes(from:to), values, second, points, sums)
      if (first%is_changed(i_facet)) values = values * matmul(transpose(first%normals(:, from:to)), normals)
      gaps = smooth_gaps(shapes, first, i_facet, second, points)
      call sums%add_gaps(first%nodes(from:to), matmul(values, gaps), minval(gaps, mask=is_near))
    end associate
  end subroutine integrate_facet

  !> Computes the dual functions Phi = dual N with dual M = diag(integral N_k), M = integral N_i N_k.
  subroutine find_dual(values, weights, dual, is_singular)
    !> [-] shape functions at the points, shape (n_nodes, n_points)
    real(rk), intent(in) :: values(:, :)
    !> [length**2, length in the plane] shape (n_points)
    real(rk), intent(in) :: weights(:)
    !> [-] shape (n_nodes, n_nodes)
    real(rk), allocatable, intent(out) :: dual(:, :)
    !> M has no inverse; `dual` is then of no use
    logical, intent(out) :: is_singular

    allocate (dual(size(values, 1), size(values, 1)))
    call invert(matmul(values * spread(weights, 1, size(values, 1)), transpose(values)), dual, is_singular)
    dual = spread(matmul(values, weights), 2, size(values, 1)) * dual
  end subroutine find_dual

  !> Returns the gaps at the points between the curved surfaces that the linear facets represent: the gap between the facets less
  !> the heights (bulge_at) of both surfaces, that of the second one along the normal of the first facet.
  pure function smooth_gaps(shapes, first, i_facet, second, points) result(gaps)
    type(facet_shape_t), intent(in) :: shapes(:)
    type(mortar_side_t), intent(in) :: first
    integer, intent(in) :: i_facet
    type(mortar_side_t), intent(in) :: second
    type(facing_points_t), intent(in) :: points
    !> [length] along the contact normal, shape (points%n)
    real(rk) :: gaps(points%n)
    integer :: p

    do p = 1, points%n
      gaps(p) = points%gaps(p) - bulge_at(shapes, first, i_facet, points%places(:, p)) - &
        bulge_along(shapes, second, points%i_other(p), points%opposite(:, p), first%outward(:, i_facet))
    end do
  end function smooth_gaps

  !> Adds the integrals of Phi_j to sums%areas, and those of Phi_j N_l.
  subroutine add_shares(shapes, nodes, duals, second, points, sums)
    type(facet_shape_t), intent(in) :: shapes(:)
    !> nodes of the facet
    integer, intent(in) :: nodes(:)
    !> [length**2, length in the plane] Phi_j at the points times their weights, shape (size(nodes), n_points)
    real(rk), intent(in) :: duals(:, :)
    type(mortar_side_t), intent(in) :: second
    type(facing_points_t), intent(in) :: points
    type(mortar_sums_t), intent(inout) :: sums
    real(rk), allocatable :: shares(:, :)
    integer :: last, p

    sums%areas(nodes) = sums%areas(nodes) + sum(duals, dim=2)
    last = 0
    do while (last < points%n)
      associate (i_other => points%i_other(last + 1), start => last)
        associate (others => second%nodes(second%offsets(i_other) + 1:second%offsets(i_other + 1)), &
          shape => shapes(second%types(i_other)))
          allocate (shares(size(nodes), size(others)), source=0.0_rk)
          do p = start + 1, points%n
            if (points%i_other(p) /= i_other) exit
            shares = shares + spread(duals(:, p), 2, size(others)) * spread(shape%values(points%opposite(:, p)), 1, size(nodes))
          end do
          call sums%add_shares(nodes, others, shares)
          deallocate (shares)
        end associate
      end associate
      last = p - 1
    end do
  end subroutine add_shares

  !> Returns the area [length**2, length in the plane] of a whole facet, in axisymmetry of the full turn.
  pure real(rk) function area_of(model, shape, vertices) result(area)
    type(mechanical_model_t), intent(in) :: model
    type(facet_shape_t), intent(in) :: shape
    !> [length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: vertices(:, :)
    integer :: p

    area = 0
    do p = 1, size(shape%weights)
      associate (place => shape%points(:, p))
        area = area + shape%weights(p) * size_of(shape%tangents(vertices, place)) * &
          circumference(model, matmul(vertices, shape%values(place)))
      end associate
    end do
  end function area_of

  !> Returns the length [length] of one tangent, or the area [length**2] of the parallelogram that two tangents span.
  pure real(rk) function size_of(tangents)
    !> [length] shape (components, 1 or 2)
    real(rk), intent(in) :: tangents(:, :)

    if (size(tangents, 2) == 1) then
      size_of = norm2(tangents)
    else
      size_of = sqrt(max(0.0_rk, sum(tangents(:, 1)**2) * sum(tangents(:, 2)**2) - dot_product(tangents(:, 1), tangents(:, 2))**2))
    end if
  end function size_of

  !> Returns the circumference at several places: 2 pi r [length] in axisymmetry, else 1 [-].
  pure function around(model, places)
    type(mechanical_model_t), intent(in) :: model
    !> [length] shape (n_dim, n)
    real(rk), intent(in) :: places(:, :)
    real(rk) :: around(size(places, 2))
    integer :: p

    do p = 1, size(around)
      around(p) = circumference(model, places(:, p))
    end do
  end function around
end module sig_mortar_surfaces
