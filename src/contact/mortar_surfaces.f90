! SPDX-License-Identifier: BSD-3-Clause
!> Dual mortar contact of two surfaces in the plane whose nodes need not match: integrals over the edges of the first surface.
!>
!> The dual functions Phi_j of an edge are the combinations of its shape functions N_k with integral Phi_j N_k = delta_jk integral
!> N_k over the part of the edge that faces the second surface. Everything is computed once, on the undeformed mesh.
module sig_mortar_surfaces
  use sig_facing_edges, only: cut_edge, facing_piece_t, meet_edge, normal_of_edge, point_of_edge
  use sig_k_d_tree, only: k_d_tree_t
  use sig_kinds, only: rk
  use sig_mechanical_models, only: circumference, mechanical_model_t
  use sig_mesh, only: mesh_t
  use sig_mortar_sums, only: mortar_sums_t
  use sig_surface_geometry, only: surface_geometry_t
  implicit none(type, external)
  private
  public :: mortar_side_t, create_side, integrate_mortar

  !> The edges of one surface.
  type :: mortar_side_t
    !> shape (2, n_edges)
    integer, allocatable :: nodes(:, :)
    !> [-] outward, shape (2, n_edges)
    real(rk), allocatable :: outward(:, :)
    !> [length] of the longest one
    real(rk) :: longest = 0
    !> middles of the edges
    type(k_d_tree_t) :: middles
  end type mortar_side_t

  integer, parameter :: n_points = 4
  !> [-] Gauss on 0 to 1, exact for polynomials of degree 7
  real(rk), parameter :: outer = 0.5_rk * sqrt((3 + 2 * sqrt(1.2_rk)) / 7), inner = 0.5_rk * sqrt((3 - 2 * sqrt(1.2_rk)) / 7)
  real(rk), parameter :: places(n_points) = 0.5_rk + [-outer, -inner, inner, outer]
  real(rk), parameter :: weights(n_points) = 0.5_rk * [(18 - sqrt(30.0_rk)) / 36, (18 + sqrt(30.0_rk)) / 36, &
    (18 + sqrt(30.0_rk)) / 36, (18 - sqrt(30.0_rk)) / 36]
  !> [-] an edge of which less faces the second surface counts as one that faces nothing: its dual functions would be huge
  real(rk), parameter :: least_cover = 0.05_rk

contains

  subroutine create_side(mesh, facets, geometry, side)
    type(mesh_t), intent(in) :: mesh
    !> of the surface, edges of two nodes
    integer, intent(in) :: facets(:)
    !> of the same facets
    type(surface_geometry_t), intent(in) :: geometry
    type(mortar_side_t), intent(out) :: side
    real(rk) :: middles(2, size(facets))
    integer :: i

    allocate (side%nodes(2, size(facets)), side%outward(2, size(facets)))
    do i = 1, size(facets)
      side%nodes(:, i) = mesh%facet_nodes(mesh%facet_offsets(facets(i)) + [1, 2])
      side%outward(:, i) = geometry%area_vectors(:, i) / norm2(geometry%area_vectors(:, i))
      middles(:, i) = sum(mesh%coordinates(:, side%nodes(:, i)), dim=2) / 2
    end do
    side%longest = maxval([0.0_rk, norm2(geometry%area_vectors, dim=1)])
    call side%middles%create(middles)
  end subroutine create_side

  !> All edges of the first surface against the second one.
  subroutine integrate_mortar(mesh, model, first, second, normals, limit, sums)
    type(mesh_t), intent(in) :: mesh
    type(mechanical_model_t), intent(in) :: model
    type(mortar_side_t), intent(in) :: first, second
    !> [-] from the first body to the second at the nodes of the first surface, shape (2, n_nodes)
    real(rk), intent(in) :: normals(:, :)
    !> [length] search distance
    real(rk), intent(in) :: limit
    type(mortar_sums_t), intent(out) :: sums
    type(facing_piece_t), allocatable :: pieces(:)
    integer, allocatable :: near(:)
    integer :: i

    call sums%start(mesh%n_nodes)
    do i = 1, size(first%nodes, 2)
      associate (nodes => first%nodes(:, i))
        call find_candidates(mesh%coordinates(:, nodes), normals(:, nodes), second, limit, near)
        call cut_edge(mesh%coordinates(:, nodes), normals(:, nodes), reshape(mesh%coordinates(:, [second%nodes(:, near)]), &
          [2, 2, size(near)]), second%outward(:, near), limit, pieces)
        pieces%i_other = near(pieces%i_other)
        call integrate_edge(mesh, model, nodes, normals(:, nodes), second, pieces, sums)
      end associate
    end do
  end subroutine integrate_mortar

  !> Edges of the second surface that the lines along the normals of an edge can meet within the limit.
  subroutine find_candidates(ends, normals, second, limit, near)
    real(rk), intent(in) :: ends(:, :), normals(:, :)
    type(mortar_side_t), intent(in) :: second
    real(rk), intent(in) :: limit
    integer, allocatable, intent(out) :: near(:)
    real(rk) :: radius

    radius = norm2(ends(:, 2) - ends(:, 1)) + second%longest + limit * norm2(normals(:, 2) - normals(:, 1))
    call second%middles%within(point_of_edge(ends, 0.5_rk), radius, near, normal_of_edge(normals, 0.5_rk))
  end subroutine find_candidates

  !> The integrals of one edge over its pieces.
  subroutine integrate_edge(mesh, model, nodes, normals, second, pieces, sums)
    type(mesh_t), intent(in) :: mesh
    type(mechanical_model_t), intent(in) :: model
    integer, intent(in) :: nodes(:)
    real(rk), intent(in) :: normals(:, :)
    type(mortar_side_t), intent(in) :: second
    type(facing_piece_t), intent(in) :: pieces(:)
    type(mortar_sums_t), intent(inout) :: sums
    real(rk) :: dual(2, 2), mass(2, 2), parts(2)
    integer :: i

    associate (ends => mesh%coordinates(:, nodes))
      call integrate_shapes(model, ends, [0.0_rk], [1.0_rk], mass)
      sums%whole = sums%whole + sum(mass)
      call integrate_shapes(model, ends, pack(pieces%start, pieces%is_far), pack(pieces%end, pieces%is_far), mass)
      sums%far = sums%far + sum(mass)
      if (sum(pieces%end - pieces%start, mask=.not. pieces%is_far) < least_cover) return
      call integrate_shapes(model, ends, pack(pieces%start, .not. pieces%is_far), pack(pieces%end, .not. pieces%is_far), mass)
      sums%covered = sums%covered + sum(mass)
      parts = sum(mass, dim=1)
      ! Phi = dual N with dual mass = diag(parts)
      dual = reshape([mass(2, 2), -mass(2, 1), -mass(1, 2), mass(1, 1)], [2, 2]) / (mass(1, 1) * mass(2, 2) - mass(1, 2)**2)
      dual = spread(parts, 2, 2) * dual
      sums%areas(nodes) = sums%areas(nodes) + parts
      do i = 1, size(pieces)
        if (.not. pieces(i)%is_far) call integrate_piece(mesh, model, nodes, normals, dual, &
          second%nodes(:, pieces(i)%i_other), pieces(i), sums)
      end do
    end associate
  end subroutine integrate_edge

  !> Integrals of N_i N_j over parts of an edge.
  pure subroutine integrate_shapes(model, ends, starts, stops, mass)
    type(mechanical_model_t), intent(in) :: model
    real(rk), intent(in) :: ends(:, :)
    !> [-] on the edge
    real(rk), intent(in) :: starts(:), stops(:)
    !> [length**(n_dim - 1)]
    real(rk), intent(out) :: mass(2, 2)
    real(rk) :: place
    integer :: i, i_point

    mass = 0
    do i = 1, size(starts)
      do i_point = 1, n_points
        place = starts(i) + (stops(i) - starts(i)) * places(i_point)
        associate (shapes => [1 - place, place])
          mass = mass + measure(model, ends, place) * (stops(i) - starts(i)) * weights(i_point) * &
            spread(shapes, 2, 2) * spread(shapes, 1, 2)
        end associate
      end do
    end do
  end subroutine integrate_shapes

  !> Integrals of Phi_j g and Phi_j N_l over a piece.
  subroutine integrate_piece(mesh, model, nodes, normals, dual, others, piece, sums)
    type(mesh_t), intent(in) :: mesh
    type(mechanical_model_t), intent(in) :: model
    integer, intent(in) :: nodes(:)
    real(rk), intent(in) :: normals(:, :)
    !> [-] Phi from the shape functions
    real(rk), intent(in) :: dual(:, :)
    !> nodes of the other edge
    integer, intent(in) :: others(:)
    type(facing_piece_t), intent(in) :: piece
    type(mortar_sums_t), intent(inout) :: sums
    real(rk) :: distance, opposite, place, shares(2, 2), values(2)
    integer :: i_point

    shares = 0
    associate (ends => mesh%coordinates(:, nodes))
      do i_point = 1, n_points
        place = piece%start + (piece%end - piece%start) * places(i_point)
        call meet_edge(point_of_edge(ends, place), normal_of_edge(normals, place), mesh%coordinates(:, others), opposite, distance)
        values = matmul(dual, [1 - place, place]) * measure(model, ends, place) * (piece%end - piece%start) * weights(i_point)
        sums%gaps(nodes) = sums%gaps(nodes) + values * distance
        shares = shares + spread(values, 2, 2) * spread([1 - opposite, opposite], 1, 2)
      end do
    end associate
    call sums%add_shares(nodes, others, shares)
  end subroutine integrate_piece

  !> [length**(n_dim - 1)] of the edge per unit of its coordinate.
  pure real(rk) function measure(model, ends, place)
    type(mechanical_model_t), intent(in) :: model
    real(rk), intent(in) :: ends(:, :)
    real(rk), intent(in) :: place

    measure = norm2(ends(:, 2) - ends(:, 1)) * circumference(model, point_of_edge(ends, place))
  end function measure
end module sig_mortar_surfaces
