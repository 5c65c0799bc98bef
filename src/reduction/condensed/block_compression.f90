! SPDX-License-Identifier: BSD-3-Clause
!> Compresses a group of columns of a large matrix into blocks: products of narrow matrices where the rows are alike, full blocks
!> elsewhere. The rows are those of a tree, which decides from its leaves upwards whether two halves are one block.
module sig_block_compression
  use sig_compressed_matrix, only: block_entries, block_rank, compressed_matrix_t, first_column, first_row, last_column, last_row
  use sig_kinds, only: rk, sk
  use sig_linear_algebra, only: add_product, transposed_product
  use sig_point_tree, only: point_tree_t
  implicit none(type, external)
  private
  public :: blocks_of, compress_columns, piece_t

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

  !> Makes a leaf one product; it is a full block where this needs as many numbers.
  subroutine compress_leaf(block, tolerance, piece)
    real(rk), contiguous, intent(in) :: block(:, :)
    real(rk), intent(in) :: tolerance
    type(piece_t), intent(out) :: piece

    call find_basis(block, tolerance, size(block) / sum(shape(block)), piece%left)
    if (allocated(piece%left)) then
      piece%form = as_product
      piece%right = transposed_product(piece%left, block)
      piece%n_numbers = size(piece%left, 2) * sum(shape(block))
    else
      piece%form = as_full_block
      piece%n_numbers = size(block)
    end if
  end subroutine compress_leaf

  !> Joins two halves that are both products to one product if this needs fewer numbers. The halves lose their factors then.
  subroutine join(first, second, tolerance, n_columns, piece)
    type(piece_t), intent(inout) :: first
    type(piece_t), intent(inout) :: second
    real(rk), intent(in) :: tolerance
    integer, intent(in) :: n_columns
    type(piece_t), intent(out) :: piece
    real(rk), allocatable :: basis(:, :), both(:, :)
    integer :: n_first, n_rows(2)

    piece%form = as_children
    piece%n_numbers = first%n_numbers + second%n_numbers
    if (first%form /= as_product .or. second%form /= as_product) return
    n_rows = [size(first%left, 1), size(second%left, 1)]
    n_first = size(first%left, 2)
    allocate (both(n_first + size(second%left, 2), n_columns))
    both(:n_first, :) = first%right
    both(n_first + 1:, :) = second%right
    call find_basis(both, tolerance, max(0, piece%n_numbers - 1) / (sum(n_rows) + n_columns), basis)
    if (.not. allocated(basis)) return
    piece%form = as_product
    piece%n_numbers = size(basis, 2) * (sum(n_rows) + n_columns)
    allocate (piece%left(sum(n_rows), size(basis, 2)), source=0.0_rk)
    call add_product(1.0_rk, first%left, basis(:n_first, :), piece%left(:n_rows(1), :))
    call add_product(1.0_rk, second%left, basis(n_first + 1:, :), piece%left(n_rows(1) + 1:, :))
    piece%right = transposed_product(basis, both)
    deallocate (first%left, first%right, second%left, second%right)
  end subroutine join

  !> Finds orthonormal columns so that the sum of squares of the block without its projection on them is at most tolerance**2: each
  !> is the largest column of what is left (Gram-Schmidt with pivoting). The basis is not allocated if it needs more than `most`
  !> columns.
  subroutine find_basis(block, tolerance, most, basis)
    real(rk), intent(in) :: block(:, :)
    real(rk), intent(in) :: tolerance
    integer, intent(in) :: most
    !> shape (n_rows, rank)
    real(rk), allocatable, intent(out) :: basis(:, :)
    real(rk) :: found(size(block, 1), min(most, minval(shape(block)))), rest(size(block, 1), size(block, 2))
    real(rk) :: squares(size(block, 2))
    integer :: i, n

    rest = block
    squares = sum(rest**2, dim=1)
    n = 0
    do while (sum(squares) > tolerance**2)
      if (n == size(found, 2)) return
      n = n + 1
      i = maxloc(squares, dim=1)
      found(:, n) = rest(:, i) / norm2(rest(:, i))
      do i = 1, size(rest, 2)
        rest(:, i) = rest(:, i) - dot_product(found(:, n), rest(:, i)) * found(:, n)
        squares(i) = sum(rest(:, i)**2)
      end do
    end do
    basis = found(:, :n)
  end subroutine find_basis

  !> Returns the blocks of the columns, which are its columns 1, 2, ... Requires: the pieces are those of the columns divided by
  !> row_scale from the left and by column_scale from the right; both are undone here.
  function blocks_of(tree, pieces, columns, row_scale, column_scale) result(matrix)
    type(point_tree_t), intent(in) :: tree
    !> of compress_columns
    type(piece_t), intent(in) :: pieces(:)
    !> the columns themselves, rows in the order of the tree
    real(rk), intent(in) :: columns(:, :)
    !> shape (n_rows)
    real(rk), intent(in) :: row_scale(:)
    !> columns = row_scale * (left * right) * column_scale, shape (n_columns, n_columns)
    real(rk), intent(in) :: column_scale(:, :)
    !> its rows and columns are in the order of `columns`
    type(compressed_matrix_t) :: matrix
    integer :: i, n_blocks, n_values

    allocate (matrix%values(sum(pieces(tree%roots)%n_numbers)), matrix%blocks(block_entries, size(pieces)))
    matrix%row_order = [(i, i=1, size(columns, 1))]
    matrix%column_order = [(i, i=1, size(columns, 2))]
    n_blocks = 0
    n_values = 0
    do i = 1, size(tree%roots)
      call take_piece(tree%roots(i))
    end do
    matrix%blocks = matrix%blocks(:, :n_blocks)
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
      block(first_column) = 1
      block(last_column) = size(columns, 2)
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
      matrix%blocks(:, n_blocks) = block
    end subroutine take_piece

    subroutine take_values(numbers)
      real(rk), intent(in) :: numbers(:, :)

      matrix%values(n_values + 1:n_values + size(numbers)) = reshape(real(numbers, sk), [size(numbers)])
      n_values = n_values + size(numbers)
    end subroutine take_values
  end function blocks_of
end module sig_block_compression
