! SPDX-License-Identifier: BSD-3-Clause
!> A large matrix in blocks of single precision: near blocks are full, smooth ones are products of two narrow matrices.
!>
!> With its rows and columns ordered so that a block is an interval of both, the matrix is the sum of its blocks. A block of rank 0
!> is full; one of rank k is L R' with L of shape (n_rows, k) and R of shape (n_columns, k). `values` has the blocks one after the
!> other, column by column, L before R. Products are computed in double precision. The same numbers give the same bits.
module sig_compressed_matrix
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_dense_kernels, only: add_single_columns, add_single_products
  use sig_kinds, only: lk, rk, sk
  use sig_linear_algebra, only: product_of_transposed => transposed_product
  implicit none(type, external)
  private
  public :: compressed_matrix_t

  !> rows of the table `blocks`
  integer, parameter, public :: first_row = 1, last_row = 2, first_column = 3, last_column = 4, block_rank = 5
  integer, parameter, public :: block_entries = 5

  !> Without blocks the matrix is zero, and with sizes 0 it is not there (is_empty).
  type :: compressed_matrix_t
    !> matrix row of each ordered row, a permutation of 1, 2, ...; shape (n_rows)
    integer, allocatable :: row_order(:)
    !> matrix column of each ordered column, likewise; shape (n_columns)
    integer, allocatable :: column_order(:)
    !> of each block: first and last ordered row and column, 1-based, and its rank; shape (block_entries, n_blocks)
    integer, allocatable :: blocks(:, :)
    real(sk), allocatable :: values(:)
  contains
    procedure :: complete
    procedure :: is_empty
    procedure :: fits
    procedure :: add_product
    procedure :: add_transposed_product
    procedure :: row_product
    procedure :: full_matrix
    procedure :: transposed_product
    procedure :: join_columns
    procedure :: size_in_bytes
  end type compressed_matrix_t

contains

  !> Allocates with size 0 each array that is not allocated.
  pure subroutine complete(self)
    class(compressed_matrix_t), intent(inout) :: self

    if (.not. allocated(self%row_order)) allocate (self%row_order(0))
    if (.not. allocated(self%column_order)) allocate (self%column_order(0))
    if (.not. allocated(self%blocks)) allocate (self%blocks(block_entries, 0))
    if (.not. allocated(self%values)) allocate (self%values(0))
  end subroutine complete

  !> Whether there is no matrix. Requires: complete.
  pure logical function is_empty(self)
    class(compressed_matrix_t), intent(in) :: self

    is_empty = size(self%row_order) == 0
  end function is_empty

  !> Whether the data are those of a matrix of this shape with finite values, or of none (is_empty). Requires: complete.
  pure logical function fits(self, n_rows, n_columns)
    class(compressed_matrix_t), intent(in) :: self
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_columns
    integer :: i
    integer(lk) :: n_values

    fits = size(self%blocks, 1) == block_entries
    if (.not. fits) return
    if (self%is_empty()) then
      fits = size(self%column_order) == 0 .and. size(self%blocks, 2) == 0 .and. size(self%values) == 0
      return
    end if
    fits = is_permutation(self%row_order, n_rows) .and. is_permutation(self%column_order, n_columns)
    n_values = 0
    do i = 1, size(self%blocks, 2)
      if (.not. fits) return
      associate (block => self%blocks(:, i))
        fits = block(first_row) >= 1 .and. block(first_row) <= block(last_row) .and. block(last_row) <= n_rows .and. &
          block(first_column) >= 1 .and. block(first_column) <= block(last_column) .and. block(last_column) <= n_columns .and. &
          block(block_rank) >= 0 .and. block(block_rank) <= n_columns
        n_values = n_values + n_values_of(block)
      end associate
    end do
    fits = fits .and. n_values == size(self%values, kind=lk) .and. all(ieee_is_finite(self%values))
  end function fits

  !> Whether the numbers are 1, 2, ..., n in any order.
  pure logical function is_permutation(numbers, n)
    integer, intent(in) :: numbers(:)
    integer, intent(in) :: n
    logical :: is_there(n)

    is_permutation = size(numbers) == n .and. all(numbers >= 1 .and. numbers <= n)
    if (.not. is_permutation) return
    is_there = .false.
    is_there(numbers) = .true.
    is_permutation = all(is_there)
  end function is_permutation

  !> Returns how many values a block has.
  pure integer(lk) function n_values_of(block) result(n)
    !> column of the table `blocks`
    integer, intent(in) :: block(:)
    integer(lk) :: n_rows, n_columns

    n_rows = block(last_row) - block(first_row) + 1
    n_columns = block(last_column) - block(first_column) + 1
    n = n_rows * n_columns
    if (block(block_rank) > 0) n = block(block_rank) * (n_rows + n_columns)
  end function n_values_of

  !> Computes y = y + alpha A x. Blocks whose columns belong to zeros of x are not read.
  subroutine add_product(self, alpha, x, y)
    class(compressed_matrix_t), intent(in) :: self
    real(rk), intent(in) :: alpha
    !> shape (n_columns)
    real(rk), contiguous, intent(in) :: x(:)
    !> shape (n_rows)
    real(rk), contiguous, intent(inout) :: y(:)
    real(rk) :: ordered(size(self%column_order)), sum_of_rows(size(self%row_order))
    integer :: i
    integer(lk) :: at

    ordered = alpha * x(self%column_order)
    sum_of_rows = 0
    at = 0
    do i = 1, size(self%blocks, 2)
      associate (block => self%blocks(:, i))
        associate (part => ordered(block(first_column):block(last_column)), n => n_values_of(block))
          if (any(abs(part) > 0)) call add_block(block, self%values(at + 1:at + n), part, &
            sum_of_rows(block(first_row):block(last_row)))
          at = at + n
        end associate
      end associate
    end do
    y(self%row_order) = y(self%row_order) + sum_of_rows
  end subroutine add_product

  !> Adds the product of one block and its part of the vector.
  pure subroutine add_block(block, values, x, y)
    integer, intent(in) :: block(:)
    !> values of this block
    real(sk), intent(in), contiguous :: values(:)
    real(rk), intent(in), contiguous :: x(:)
    real(rk), intent(inout), contiguous :: y(:)
    real(rk) :: coordinates(block(block_rank))

    if (block(block_rank) == 0) then
      call add_single_columns(values, x, y)
    else
      associate (n_left => size(y) * block(block_rank))
        coordinates = 0
        call add_single_products(values(n_left + 1:), x, coordinates)
        call add_single_columns(values(:n_left), coordinates, y)
      end associate
    end if
  end subroutine add_block

  !> Computes x = x + A'y.
  subroutine add_transposed_product(self, y, x)
    class(compressed_matrix_t), intent(in) :: self
    !> shape (n_rows)
    real(rk), contiguous, intent(in) :: y(:)
    !> shape (n_columns)
    real(rk), contiguous, intent(inout) :: x(:)
    real(rk) :: ordered(size(self%row_order)), sum_of_columns(size(self%column_order))
    integer :: i
    integer(lk) :: at

    ordered = y(self%row_order)
    sum_of_columns = 0
    at = 0
    do i = 1, size(self%blocks, 2)
      associate (block => self%blocks(:, i))
        associate (n => n_values_of(block))
          call add_transposed_block(block, self%values(at + 1:at + n), ordered(block(first_row):block(last_row)), &
            sum_of_columns(block(first_column):block(last_column)))
          at = at + n
        end associate
      end associate
    end do
    x(self%column_order) = x(self%column_order) + sum_of_columns
  end subroutine add_transposed_product

  !> Adds the product of one transposed block and its part of the vector.
  pure subroutine add_transposed_block(block, values, y, x)
    integer, intent(in) :: block(:)
    !> values of this block
    real(sk), intent(in), contiguous :: values(:)
    real(rk), intent(in), contiguous :: y(:)
    real(rk), intent(inout), contiguous :: x(:)
    real(rk) :: coordinates(block(block_rank))

    if (block(block_rank) == 0) then
      call add_single_products(values, y, x)
    else
      associate (n_left => size(y) * block(block_rank))
        coordinates = 0
        call add_single_products(values(:n_left), y, coordinates)
        call add_single_columns(values(n_left + 1:), coordinates, x)
      end associate
    end if
  end subroutine add_transposed_block

  !> Returns one row of A times x. Cost: it looks at all entries of `blocks`, and computes with those of this row.
  pure real(rk) function row_product(self, row, x) result(value)
    class(compressed_matrix_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: row
    !> shape (n_columns)
    real(rk), intent(in) :: x(:)
    integer :: i, place
    integer(lk) :: at

    place = findloc(self%row_order, row, dim=1)
    value = 0
    at = 0
    do i = 1, size(self%blocks, 2)
      associate (block => self%blocks(:, i))
        associate (n => n_values_of(block))
          if (place >= block(first_row) .and. place <= block(last_row)) value = value + row_of_block(block, &
            self%values(at + 1:at + n), place - block(first_row) + 1, x(self%column_order(block(first_column):block(last_column))))
          at = at + n
        end associate
      end associate
    end do
  end function row_product

  !> Returns one row of a block times its part of the vector.
  pure real(rk) function row_of_block(block, values, row, x) result(value)
    integer, intent(in) :: block(:)
    real(sk), intent(in), contiguous :: values(:)
    !> row of the block, 1-based
    integer, intent(in) :: row
    real(rk), intent(in), contiguous :: x(:)
    real(rk) :: coordinates(block(block_rank))
    integer :: n

    n = block(last_row) - block(first_row) + 1
    if (block(block_rank) == 0) then
      value = sum(values(row::n) * x)
    else
      coordinates = 0
      call add_single_products(values(n * block(block_rank) + 1:), x, coordinates)
      value = sum(values(row:n * block(block_rank):n) * coordinates)
    end if
  end function row_of_block

  !> Returns the whole matrix.
  pure function full_matrix(self) result(full)
    class(compressed_matrix_t), intent(in) :: self
    !> shape (n_rows, n_columns)
    real(rk), allocatable :: full(:, :)
    integer :: i, n_left, n_rows
    integer(lk) :: at

    allocate (full(size(self%row_order), size(self%column_order)), source=0.0_rk)
    at = 0
    do i = 1, size(self%blocks, 2)
      associate (block => self%blocks(:, i))
        n_rows = block(last_row) - block(first_row) + 1
        n_left = n_rows * block(block_rank)
        associate (rows => self%row_order(block(first_row):block(last_row)), &
                   columns => self%column_order(block(first_column):block(last_column)), &
                   values => self%values(at + 1:at + n_values_of(block)))
          if (block(block_rank) == 0) then
            full(rows, columns) = reshape(values, [n_rows, size(columns)])
          else
            full(rows, columns) = matmul(reshape(real(values(:n_left), rk), [n_rows, block(block_rank)]), &
              transpose(reshape(real(values(n_left + 1:), rk), [size(columns), block(block_rank)])))
          end if
        end associate
        at = at + n_values_of(block)
      end associate
    end do
  end function full_matrix

  !> Returns A'Y.
  function transposed_product(self, y) result(product)
    class(compressed_matrix_t), intent(in) :: self
    !> shape (n_rows, n)
    real(rk), intent(in) :: y(:, :)
    !> shape (n_columns, n)
    real(rk), allocatable :: product(:, :)
    real(rk) :: ordered(size(self%column_order), size(y, 2))
    integer :: i, n_left, n_rows
    integer(lk) :: at

    ordered = 0
    at = 0
    do i = 1, size(self%blocks, 2)
      associate (block => self%blocks(:, i))
        n_rows = block(last_row) - block(first_row) + 1
        n_left = n_rows * block(block_rank)
        associate (part => y(self%row_order(block(first_row):block(last_row)), :), &
                   values => real(self%values(at + 1:at + n_values_of(block)), rk), &
                   own => ordered(block(first_column):block(last_column), :))
          if (block(block_rank) == 0) then
            own = own + product_of_transposed(reshape(values, [n_rows, size(own, 1)]), part)
          else
            own = own + matmul(reshape(values(n_left + 1:), [size(own, 1), block(block_rank)]), &
              product_of_transposed(reshape(values(:n_left), [n_rows, block(block_rank)]), part))
          end if
        end associate
        at = at + n_values_of(block)
      end associate
    end do
    allocate (product, mold=ordered)
    product(self%column_order, :) = ordered
  end function transposed_product

  !> Sets blocks and values to those of matrices that stand side by side; row_order and column_order do not change.
  subroutine join_columns(self, parts)
    class(compressed_matrix_t), intent(inout) :: self
    !> matrices with the same ordered rows
    type(compressed_matrix_t), intent(in) :: parts(:)
    integer :: i, n_blocks, n_columns
    integer(lk) :: n_values

    if (allocated(self%values)) deallocate (self%values)
    if (allocated(self%blocks)) deallocate (self%blocks)
    allocate (self%values(sum([(size(parts(i)%values, kind=lk), i=1, size(parts))])))
    allocate (self%blocks(block_entries, sum([(size(parts(i)%blocks, 2), i=1, size(parts))])))
    n_blocks = 0
    n_columns = 0
    n_values = 0
    do i = 1, size(parts)
      associate (part => parts(i), blocks => self%blocks(:, n_blocks + 1:n_blocks + size(parts(i)%blocks, 2)))
        blocks = part%blocks
        blocks([first_column, last_column], :) = blocks([first_column, last_column], :) + n_columns
        self%values(n_values + 1:n_values + size(part%values, kind=lk)) = part%values
        n_blocks = n_blocks + size(part%blocks, 2)
        n_columns = n_columns + size(part%column_order)
        n_values = n_values + size(part%values, kind=lk)
      end associate
    end do
  end subroutine join_columns

  !> Returns the number of bytes that `values` take.
  pure integer(lk) function size_in_bytes(self)
    class(compressed_matrix_t), intent(in) :: self

    size_in_bytes = storage_size(1.0_sk, lk) / 8 * size(self%values, kind=lk)
  end function size_in_bytes
end module sig_compressed_matrix
