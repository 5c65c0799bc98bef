! SPDX-License-Identifier: BSD-3-Clause
!> Principal pivot transform of a linear complementarity problem w = W z + q: for a set A of indices, w_A and z_A exchange their
!> places.
!>
!> With the other indices I: (z_A, w_I) = M (w_A, z_I) + (-W_AA^-1 q_A, q_I - W_IA W_AA^-1 q_A), where M = [W_AA^-1, -W_AA^-1 W_AI;
!> W_IA W_AA^-1, W_II - W_IA W_AA^-1 W_AI]. Where the active set of the solution is nearly A, only few unknowns of the transformed
!> problem are not zero, and it is solved quickly.
module sig_pivot_transform
  use sig_dense_kernels, only: add_product
  use sig_kinds, only: rk
  use sig_linear_algebra, only: invert
  implicit none(type, external)
  private
  public :: transform_matrix, transform_columns

contains

  !> Computes the matrix M of the problem w = W z + q after w_A and z_A of a set A have exchanged their places: M = [W_AA^-1,
  !> -W_AA^-1 W_AI; W_IA W_AA^-1, W_II - W_IA W_AA^-1 W_AI], with rows and columns in their old order. For an empty set it is W.
  !> Where W_AA is numerically singular, is_singular is true and M is of no use.
  subroutine transform_matrix(matrix, is_in_set, transform, is_singular)
    !> W, shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> A, shape (n)
    logical, intent(in) :: is_in_set(:)
    !> M, shape (n, n)
    real(rk), intent(out) :: transform(:, :)
    logical, intent(out) :: is_singular
    integer, allocatable :: a(:), rest(:)
    real(rk), allocatable :: inverse(:, :), block(:, :), remaining(:, :)
    integer :: i

    transform = matrix
    a = pack([(i, i=1, size(is_in_set))], is_in_set)
    rest = pack([(i, i=1, size(is_in_set))], .not. is_in_set)
    is_singular = .false.
    if (size(a) == 0) return
    allocate (inverse(size(a), size(a)))
    call invert(matrix(a, a), inverse, is_singular)
    if (is_singular) return
    transform(a, a) = inverse
    allocate (block(size(rest), size(a)), source=0.0_rk)
    call add_product(1.0_rk, matrix(rest, a), inverse, block)
    transform(rest, a) = block
    remaining = matrix(rest, rest)
    call add_product(-1.0_rk, block, matrix(a, rest), remaining)
    transform(rest, rest) = remaining
    deallocate (block)
    allocate (block(size(a), size(rest)), source=0.0_rk)
    call add_product(-1.0_rk, inverse, matrix(a, rest), block)
    transform(a, rest) = block
  end subroutine transform_matrix

  !> Replaces vectors q of the problem w = W z + q, one per column, by those after w_A and z_A have exchanged their places: -W_AA^-1
  !> q_A in A, and q_I - W_IA W_AA^-1 q_A in the other rows I.
  subroutine transform_columns(transform, is_in_set, columns)
    !> M of the set, from transform_matrix, shape (n, n)
    real(rk), intent(in) :: transform(:, :)
    !> A, shape (n)
    logical, intent(in) :: is_in_set(:)
    !> on entry q, on exit the transformed q, shape (n, n_columns)
    real(rk), intent(inout) :: columns(:, :)
    real(rk), allocatable :: inside(:, :), changes(:, :)
    integer, allocatable :: a(:)
    integer :: i

    a = pack([(i, i=1, size(is_in_set))], is_in_set)
    inside = columns(a, :)
    columns(a, :) = 0
    allocate (changes(size(columns, 1), size(columns, 2)), source=0.0_rk)
    call add_product(-1.0_rk, transform(:, a), inside, changes)
    columns = columns + changes
  end subroutine transform_columns
end module sig_pivot_transform
