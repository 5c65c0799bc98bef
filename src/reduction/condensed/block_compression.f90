! SPDX-License-Identifier: BSD-3-Clause
!> Compresses a group of columns of a large matrix into blocks: products of narrow matrices where the rows are alike, full blocks
!> elsewhere. The rows are those of a tree, which decides from its leaves upwards whether two halves are one block.
module sig_block_compression
  use sig_compressed_matrix, only: block_entries, block_rank, compressed_matrix_t, first_column, first_row, last_column, last_row
  use sig_kinds, only: rk, sk
  use sig_linear_algebra, only: add_product
  use sig_point_tree, only: point_tree_t
  use sig_singular_values, only: svd
  implicit none(type, external)
  private
  public :: append_columns, compress_columns, piece_t

  !> The columns on the rows of one interval of the tree, nearly left * right.
  type :: piece_t
    !> orthonormal columns, shape (n_rows, rank)
    real(rk), allocatable :: left(:, :)
    !> shape (rank, n_columns)
    real(rk), allocatable :: right(:, :)
    !> how many numbers the interval needs
    integer :: n_numbers = 0
    !> what is kept: one product, the whole block, or the pieces of the children
    integer :: form = 0
  end type piece_t

  integer, parameter :: as_product = 1, as_full_block = 2, as_children = 3

contains

  !> Finds a piece for each interval of the tree, so that in each leaf the sum of squares of what is left out is at most
  !> tolerance**2, likewise where two halves join. An interval has its rows together: n_components for each point of the tree.
  subroutine compress_columns(tree, n_components, columns, tolerance, pieces)
    type(point_tree_t), intent(in) :: tree
    integer, intent(in) :: n_components
    !> rows in the order of the tree, shape (n_components * n_points, n_columns)
    real(rk), contiguous, intent(in) :: columns(:, :)
    real(rk), intent(in) :: tolerance
    !> shape (n_intervals)
    type(piece_t), allocatable, intent(out) :: pieces(:)
    integer :: i

    allocate (pieces(size(tree%first)))
    do i = 1, size(pieces)
      if (tree%children(1, i) == 0) then
        call compress_leaf(columns(n_components * (tree%first(i) - 1) + 1:n_components * tree%last(i), :), tolerance, pieces(i))
      else
        call join(pieces(tree%children(1, i)), pieces(tree%children(2, i)), tolerance, size(columns, 2), pieces(i))
      end if
    end do
  end subroutine compress_columns

  !> Factors a leaf by columns of largest remainder; it is a full block where this needs as many numbers.
  subroutine compress_leaf(block, tolerance, piece)
    real(rk), intent(in) :: block(:, :)
    real(rk), intent(in) :: tolerance
    type(piece_t), intent(out) :: piece
    real(rk) :: rest(size(block, 1), size(block, 2)), basis(size(block, 1), minval(shape(block)))
    integer :: most, n, next

    rest = block
    n = 0
    most = size(block) / sum(shape(block))
    do while (sum(rest**2) > tolerance**2)
      n = n + 1
      if (n > most) exit
      next = maxloc(sum(rest**2, dim=1), dim=1)
      basis(:, n) = rest(:, next) / norm2(rest(:, next))
      rest = rest - spread(basis(:, n), 2, size(rest, 2)) * spread(matmul(basis(:, n), rest), 1, size(rest, 1))
    end do
    if (n > most) then
      piece%form = as_full_block
      piece%n_numbers = size(block)
    else
      piece%form = as_product
      piece%left = basis(:, :n)
      piece%right = matmul(transpose(piece%left), block)
      piece%n_numbers = n * sum(shape(block))
    end if
  end subroutine compress_leaf

  !> Joins two halves that are both products to one product if this needs fewer numbers. The halves lose their factors then.
  subroutine join(first, second, tolerance, n_columns, piece)
    type(piece_t), intent(inout) :: first
    type(piece_t), intent(inout) :: second
    real(rk), intent(in) :: tolerance
    integer, intent(in) :: n_columns
    type(piece_t), intent(out) :: piece
    real(rk), allocatable :: both(:, :), u(:, :), s(:), vt(:, :)
    integer :: i, n, n_first, n_rows(2)

    piece%form = as_children
    piece%n_numbers = first%n_numbers + second%n_numbers
    if (first%form /= as_product .or. second%form /= as_product) return
    n_rows = [size(first%left, 1), size(second%left, 1)]
    n_first = size(first%left, 2)
    allocate (both(n_first + size(second%left, 2), n_columns))
    both(:n_first, :) = first%right
    both(n_first + 1:, :) = second%right
    call svd(both, u, s, vt)
    n = size(s)
    do while (n > 0)
      if (.not. sum(s(n:)**2) <= tolerance**2) exit
      n = n - 1
    end do
    if (n * (sum(n_rows) + n_columns) >= piece%n_numbers) return
    piece%form = as_product
    piece%n_numbers = n * (sum(n_rows) + n_columns)
    allocate (piece%left(sum(n_rows), n), source=0.0_rk)
    call add_product(1.0_rk, first%left, u(:n_first, :n), piece%left(:n_rows(1), :))
    call add_product(1.0_rk, second%left, u(n_first + 1:, :n), piece%left(n_rows(1) + 1:, :))
    piece%right = vt(:n, :)
    do i = 1, n
      piece%right(i, :) = s(i) * vt(i, :)
    end do
    deallocate (first%left, first%right, second%left, second%right)
  end subroutine join

  !> Appends the pieces of a group of columns to a compressed matrix, as its next ordered columns. The pieces are those of the
  !> columns divided by row_scale from the left and by column_scale from the right; both are undone here.
  subroutine append_columns(tree, pieces, columns, row_scale, column_scale, matrix)
    type(point_tree_t), intent(in) :: tree
    !> of compress_columns
    type(piece_t), intent(in) :: pieces(:)
    !> the columns themselves, rows in the order of the tree
    real(rk), intent(in) :: columns(:, :)
    !> shape (n_rows)
    real(rk), intent(in) :: row_scale(:)
    !> columns = row_scale * (left * right) * column_scale, shape (n_columns, n_columns)
    real(rk), intent(in) :: column_scale(:, :)
    !> gets more blocks and values; its column_order has the columns that it has until now
    type(compressed_matrix_t), intent(inout) :: matrix
    real(sk), allocatable :: values(:)
    integer, allocatable :: blocks(:, :)
    integer :: i, n_before, n_blocks, n_values

    n_before = size(matrix%column_order)
    allocate (values(sum(pieces(tree%roots)%n_numbers)), blocks(block_entries, size(pieces)))
    n_blocks = 0
    n_values = 0
    do i = 1, size(tree%roots)
      call take_piece(tree%roots(i))
    end do
    matrix%blocks = reshape([matrix%blocks, blocks(:, :n_blocks)], [block_entries, size(matrix%blocks, 2) + n_blocks])
    matrix%values = [matrix%values, values]
  contains
    !> Takes the piece of an interval, or those below it.
    recursive subroutine take_piece(i)
      integer, intent(in) :: i
      integer :: block(block_entries), rank

      if (pieces(i)%form == as_children) then
        call take_piece(tree%children(1, i))
        call take_piece(tree%children(2, i))
        return
      end if
      associate (n_components => size(row_scale) / size(tree%order))
        block(first_row) = n_components * (tree%first(i) - 1) + 1
        block(last_row) = n_components * tree%last(i)
      end associate
      block(first_column) = n_before + 1
      block(last_column) = n_before + size(columns, 2)
      rank = 0
      if (pieces(i)%form == as_product) then
        rank = size(pieces(i)%left, 2)
        if (rank == 0) return
        call take_values(pieces(i)%left * spread(row_scale(block(first_row):block(last_row)), 2, rank))
        call take_values(transpose(matmul(pieces(i)%right, column_scale)))
      else
        call take_values(columns(block(first_row):block(last_row), :))
      end if
      block(block_rank) = rank
      n_blocks = n_blocks + 1
      blocks(:, n_blocks) = block
    end subroutine take_piece

    subroutine take_values(numbers)
      real(rk), intent(in) :: numbers(:, :)

      values(n_values + 1:n_values + size(numbers)) = reshape(real(numbers, sk), [size(numbers)])
      n_values = n_values + size(numbers)
    end subroutine take_values
  end subroutine append_columns
end module sig_block_compression
