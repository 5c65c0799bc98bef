! SPDX-License-Identifier: BSD-3-Clause
!> Lemke's complementary pivoting with the lexicographic rule, which cannot cycle.
module sig_lcp_lemke
  use sig_kinds, only: rk
  use sig_lcp_types, only: lcp_failed_iterations, lcp_failed_ray, lcp_solved
  implicit none(type, external)
  private
  public :: run_lemke

  !> a pivot below this times the largest entry of its column counts as zero
  real(rk), parameter :: pivot_tolerance = 1.0e-10_rk
  !> ratios this close (relative) are a tie
  real(rk), parameter :: tie_tolerance = 1.0e-12_rk

  !> Tableau of w - W lambda - d z0 = q. Variables: 1..n w, n+1..2n lambda, 2n+1 z0; last column: values.
  type :: tableau_t
    integer :: n = 0
    !> shape (n, 2n+2)
    real(rk), allocatable :: entries(:, :)
    !> variable of each row, shape (n)
    integer, allocatable :: basis(:)
  end type tableau_t

contains

  !> Follows the path from w = q + d z0 to z0 = 0, or to a ray.
  !>
  !> Source: Lemke, Management Science 11 (1965) 681; Cottle, Pang, Stone, The linear complementarity problem, section 4.4.
  !> Requires: at least one q < 0. The data are scaled inside, so units do not matter.
  subroutine run_lemke(matrix, q, covering, lambda, is_active, reason, n_iterations)
    !> shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> [-] covering vector d > 0, shape (n)
    real(rk), intent(in) :: covering(:)
    !> zero unless solved, shape (n)
    real(rk), intent(out) :: lambda(:)
    !> indices whose lambda is in the last basis, shape (n)
    logical, intent(out) :: is_active(:)
    !> lcp_solved, lcp_failed_ray or lcp_failed_iterations
    integer, intent(out) :: reason
    !> pivots
    integer, intent(out) :: n_iterations
    type(tableau_t) :: tableau
    real(rk) :: matrix_size, q_size
    integer :: entering, i_row, leaving, max_pivots

    lambda = 0
    is_active = .false.
    q_size = maxval(abs(q))
    matrix_size = max(maxval(abs(matrix)), tiny(matrix_size))
    call fill_tableau(matrix / matrix_size, q / q_size, covering, tableau)
    max_pivots = 20 * size(q) + 100
    entering = 2 * tableau%n + 1
    i_row = first_row(tableau)
    reason = lcp_failed_iterations
    do n_iterations = 1, max_pivots
      leaving = tableau%basis(i_row)
      call pivot(tableau, i_row, entering)
      if (leaving == 2 * tableau%n + 1) then
        call read_solution(tableau, lambda, is_active)
        lambda = lambda * (q_size / matrix_size)
        reason = lcp_solved
        return
      end if
      entering = complement(leaving, tableau%n)
      call find_leaving_row(tableau, entering, i_row)
      reason = lcp_failed_ray
      if (i_row == 0) return
      reason = lcp_failed_iterations
    end do
    n_iterations = max_pivots
  end subroutine run_lemke

  !> Columns I, -W, -d and q; the basis is w.
  subroutine fill_tableau(matrix, q, covering, tableau)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    real(rk), intent(in) :: covering(:)
    type(tableau_t), intent(out) :: tableau
    integer :: i_row, n

    n = size(q)
    tableau%n = n
    allocate (tableau%entries(n, 2 * n + 2), source=0.0_rk)
    do i_row = 1, n
      tableau%entries(i_row, i_row) = 1
    end do
    tableau%entries(:, n + 1:2 * n) = -matrix
    tableau%entries(:, 2 * n + 1) = -covering
    tableau%entries(:, 2 * n + 2) = q
    tableau%basis = [(i_row, i_row=1, n)]
  end subroutine fill_tableau

  !> The row that z0 takes first: the lexicographic minimum of (q_i, e_i) / d_i; every row is lexicographically positive then.
  pure function first_row(tableau) result(i_row)
    type(tableau_t), intent(in) :: tableau
    integer :: i_row
    real(rk) :: ratio(tableau%n)

    ! Of equal ratios the last row is the lexicographic minimum: its unit vector starts with more zeros.
    ratio = -tableau%entries(:, 2 * tableau%n + 2) / tableau%entries(:, 2 * tableau%n + 1)
    i_row = findloc(ratio <= minval(ratio) + tie_tolerance * abs(minval(ratio)), .true., dim=1, back=.true.)
  end function first_row

  !> lambda of a w, w of a lambda.
  pure function complement(variable, n) result(partner)
    integer, intent(in) :: variable
    integer, intent(in) :: n
    integer :: partner

    partner = merge(variable + n, variable - n, variable <= n)
  end function complement

  !> Row of the lexicographically smallest ratio among the positive entries of the entering column; 0 = a ray.
  !> z0 leaves as soon as it may: that ends the path.
  pure subroutine find_leaving_row(tableau, entering, i_leaving)
    type(tableau_t), intent(in) :: tableau
    integer, intent(in) :: entering
    integer, intent(out) :: i_leaving
    logical :: is_candidate(tableau%n)
    integer :: column, i_column, z0_row

    i_leaving = 0
    associate (entries => tableau%entries, n => tableau%n)
      is_candidate = entries(:, entering) > pivot_tolerance * maxval(abs(entries(:, entering)))
      if (.not. any(is_candidate)) return
      call keep_smallest(entries(:, 2 * n + 2), entries(:, entering), is_candidate)
      z0_row = findloc(tableau%basis, 2 * n + 1, dim=1)
      if (is_candidate(z0_row)) then
        i_leaving = z0_row
        return
      end if
      ! The columns of w hold the inverse of the basis, whose rows differ: the tie ends.
      do i_column = 1, n
        if (count(is_candidate) == 1) exit
        column = i_column
        call keep_smallest(entries(:, column), entries(:, entering), is_candidate)
      end do
    end associate
    i_leaving = findloc(is_candidate, .true., dim=1)
  end subroutine find_leaving_row

  !> Leaves only the rows whose ratio is the smallest, within the tie tolerance.
  pure subroutine keep_smallest(numerator, denominator, is_candidate)
    real(rk), intent(in) :: numerator(:)
    real(rk), intent(in) :: denominator(:)
    logical, intent(inout) :: is_candidate(:)
    real(rk) :: ratio(size(numerator)), smallest

    ratio = 0
    where (is_candidate) ratio = numerator / denominator
    smallest = minval(ratio, mask=is_candidate)
    is_candidate = is_candidate .and. ratio <= smallest + tie_tolerance * max(1.0_rk, abs(smallest))
  end subroutine keep_smallest

  !> Gauss-Jordan step on one entry; the entering variable takes the row.
  pure subroutine pivot(tableau, i_row, entering)
    type(tableau_t), intent(inout) :: tableau
    integer, intent(in) :: i_row
    integer, intent(in) :: entering
    real(rk) :: column(tableau%n), factor
    integer :: i_column

    column = tableau%entries(:, entering)
    column(i_row) = 0
    do i_column = 1, size(tableau%entries, 2)
      factor = tableau%entries(i_row, i_column) / tableau%entries(i_row, entering)
      if (i_column == entering) cycle
      tableau%entries(i_row, i_column) = factor
      tableau%entries(:, i_column) = tableau%entries(:, i_column) - column * factor
    end do
    tableau%entries(:, entering) = 0
    tableau%entries(i_row, entering) = 1
    tableau%basis(i_row) = entering
  end subroutine pivot

  !> Multipliers of the basis.
  pure subroutine read_solution(tableau, lambda, is_active)
    type(tableau_t), intent(in) :: tableau
    real(rk), intent(out) :: lambda(:)
    logical, intent(out) :: is_active(:)
    integer :: i_row, k

    lambda = 0
    is_active = .false.
    do i_row = 1, tableau%n
      k = tableau%basis(i_row) - tableau%n
      if (k < 1 .or. k > tableau%n) cycle
      lambda(k) = tableau%entries(i_row, 2 * tableau%n + 2)
      is_active(k) = .true.
    end do
  end subroutine read_solution
end module sig_lcp_lemke
