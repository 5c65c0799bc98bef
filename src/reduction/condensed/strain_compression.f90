! SPDX-License-Identifier: BSD-3-Clause
!> Compresses the strains of unit contact forces at the integration points of materials that flow: blocks of single precision, of
!> low rank where the points are far from the contacts (sig_compressed_matrix).
!>
!> Low rank for whole bodies would not do: a contact force strains what is near it much more than the rest, so that the strains of
!> all contacts of a body have nearly as many directions as the body has contacts.
module sig_strain_compression
  use sig_block_compression, only: blocks_of, compress_columns, piece_t
  use sig_compressed_matrix, only: compressed_matrix_t
  use sig_elasticity, only: n_stresses
  use sig_flow_points, only: flow_points_t
  use sig_kinds, only: rk
  use sig_point_tree, only: point_tree_t
  implicit none(type, external)
  private
  public :: compress_strains

  !> [-] error of the strains of each contact force, in the norm of the elastic energy; it is felt in forces as the same share of
  !> what inelastic strains open
  real(rk), parameter :: tolerance = 1.0e-6_rk
  !> points of a leaf of the tree of points
  integer, parameter :: leaf_size = 32

contains

  !> Replaces of_contact of the points by contact_blocks.
  subroutine compress_strains(places, hooke, order, ends, anchors, points)
    !> [length] of each point, shape (n_dim, n_points)
    real(rk), intent(in) :: places(:, :)
    !> [force/length**2] elastic stress per strain, shape (n_stresses, n_stresses * n_materials)
    real(rk), intent(in) :: hooke(:, :)
    !> contacts that are not anchors, groups of near ones together, and the place of the last one of each group
    integer, intent(in) :: order(:)
    integer, intent(in) :: ends(:)
    !> contacts that strain nothing
    integer, intent(in) :: anchors(:)
    type(flow_points_t), intent(inout) :: points
    type(compressed_matrix_t), allocatable :: groups(:)
    type(point_tree_t) :: tree
    integer, allocatable :: rows(:)
    real(rk), allocatable :: scale(:)
    integer :: first, i, k

    call tree%create(places, [(1, i=1, size(places, 2))], leaf_size)
    associate (n => size(points%components))
      rows = [((n * (tree%order(i) - 1) + k, k=1, n), i=1, size(tree%order))]
    end associate
    scale = energy_scale(points, hooke)
    allocate (groups(size(ends)))
    first = 1
    do i = 1, size(ends)
      call compress_group(tree, size(points%components), scale(rows), points%of_contact(rows, order(first:ends(i))), groups(i))
      first = ends(i) + 1
    end do
    associate (blocks => points%contact_blocks)
      blocks%row_order = rows
      ! anchors have no blocks
      blocks%column_order = [order, anchors]
      call blocks%join_columns(groups)
    end associate
    deallocate (points%of_contact)
    allocate (points%of_contact(size(rows), 0))
  end subroutine compress_strains

  !> Returns factors that make of strains about what they are in the norm of the elastic energy, shape (n_strains * n_points).
  pure function energy_scale(points, hooke) result(scale)
    type(flow_points_t), intent(in) :: points
    real(rk), intent(in) :: hooke(:, :)
    real(rk), allocatable :: scale(:)
    integer :: i, k

    scale = [((sqrt(points%weights(i) * hooke(points%components(k), n_stresses * (points%materials(i) - 1) + &
      points%components(k))), k=1, size(points%components)), i=1, points%n_points())]
  end function energy_scale

  !> Compresses the columns of one group of contacts, each to its own size.
  subroutine compress_group(tree, n_strains, scale, columns, matrix)
    type(point_tree_t), intent(in) :: tree
    integer, intent(in) :: n_strains
    !> shape (n_rows)
    real(rk), intent(in) :: scale(:)
    !> rows in the order of the tree
    real(rk), contiguous, intent(in) :: columns(:, :)
    type(compressed_matrix_t), intent(out) :: matrix
    type(piece_t), allocatable :: pieces(:)
    real(rk) :: scaled(size(columns, 1), size(columns, 2)), sizes(size(columns, 2), size(columns, 2))
    integer :: i

    sizes = 0
    scaled = columns * spread(scale, 2, size(columns, 2))
    do i = 1, size(columns, 2)
      sizes(i, i) = norm2(scaled(:, i))
      ! a contact between elastic bodies strains nothing here
      if (sizes(i, i) > 0) scaled(:, i) = scaled(:, i) / sizes(i, i)
    end do
    ! the squares of what the leaves miss add up
    call compress_columns(tree, n_strains, scaled, tolerance / sqrt(real(count(tree%children(1, :) == 0), rk)), pieces)
    matrix = blocks_of(tree, pieces, columns, 1 / scale, sizes)
  end subroutine compress_group
end module sig_strain_compression
