! SPDX-License-Identifier: BSD-3-Clause
!> Lemke's complementary pivoting with the lexicographic rule, which cannot cycle.
!>
!> The tableau of w - W lambda - d z0 = q is kept in the workspace. Variables: 1..n w, n+1..2n lambda, 2n+1 z0; last column: values.
module sig_lcp_lemke
  use sig_kinds, only: rk
  use sig_lcp_types, only: lcp_workspace_t
  use sig_reasons, only: reason_converged, reason_max_pivots, reason_ray
  implicit none(type, external)
  private
  public :: run_lemke

  !> a pivot below this times the largest entry of its column counts as zero
  real(rk), parameter :: pivot_tolerance = 1.0e-10_rk
  !> ratios this close (relative) are a tie
  real(rk), parameter :: tie_tolerance = 1.0e-12_rk

contains

  !> Follows the path from w = q + d z0 to z0 = 0, or to a ray.
  !>
  !> Source: Lemke, Management Science 11 (1965) 681; Cottle, Pang, Stone, The linear complementarity problem, section 4.4.
  !> Requires: at least one q < 0; the covering vector d > 0 in workspace%covering. The data are scaled inside, so units do not
  !> matter.
  subroutine run_lemke(matrix, q, workspace, is_active, reason, n_iterations)
    !> shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> its lambda is the answer when solved, else zero
    type(lcp_workspace_t), intent(inout) :: workspace
    !> indices whose lambda is in the last basis, shape (n)
    logical, intent(out) :: is_active(:)
    !> reason_converged, reason_ray or reason_max_pivots
    integer, intent(out) :: reason
    !> pivots
    integer, intent(out) :: n_iterations
    integer :: entering, i_row, leaving, max_pivots, n

    n = size(q)
    workspace%lambda(:n) = 0
    is_active = .false.
    call fill_tableau(matrix, q, workspace)
    max_pivots = 20 * n + 100
    entering = 2 * n + 1
    i_row = first_row(workspace, n)
    reason = reason_max_pivots
    do n_iterations = 1, max_pivots
      leaving = workspace%basis(i_row)
      call pivot(workspace, n, i_row, entering)
      if (leaving == 2 * n + 1) then
        call read_solution(matrix, q, workspace, is_active)
        reason = reason_converged
        return
      end if
      entering = complement(leaving, n)
      call find_leaving_row(workspace, n, entering, i_row)
      reason = reason_ray
      if (i_row == 0) return
      reason = reason_max_pivots
    end do
    n_iterations = max_pivots
  end subroutine run_lemke

  !> Largest entry of W: the unit in which the tableau is written.
  pure real(rk) function matrix_size(matrix)
    real(rk), intent(in) :: matrix(:, :)

    matrix_size = max(maxval(abs(matrix)), tiny(matrix_size))
  end function matrix_size

  !> Columns I, -W, -d and q, scaled; the basis is w.
  pure subroutine fill_tableau(matrix, q, workspace)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    real(rk) :: scale
    integer :: i, n

    n = size(q)
    scale = 1 / matrix_size(matrix)
    do i = 1, n
      workspace%tableau(:n, i) = 0
      workspace%tableau(i, i) = 1
      workspace%tableau(:n, n + i) = -scale * matrix(:, i)
      workspace%basis(i) = i
    end do
    workspace%tableau(:n, 2 * n + 1) = -workspace%covering(:n)
    workspace%tableau(:n, 2 * n + 2) = q / maxval(abs(q))
  end subroutine fill_tableau

  !> The row that z0 takes first: the lexicographic minimum of (q_i, e_i) / d_i; every row is lexicographically positive then.
  pure function first_row(workspace, n) result(i_row)
    type(lcp_workspace_t), intent(in) :: workspace
    integer, intent(in) :: n
    integer :: i_row
    real(rk) :: smallest
    integer :: i

    associate (values => workspace%tableau(:n, 2 * n + 2), covering => workspace%covering)
      smallest = huge(smallest)
      do i = 1, n
        smallest = min(smallest, values(i) / covering(i))
      end do
      ! Of equal ratios the last row is the lexicographic minimum: its unit vector starts with more zeros.
      do i_row = n, 1, -1
        if (values(i_row) / covering(i_row) <= smallest + tie_tolerance * abs(smallest)) return
      end do
    end associate
    i_row = 1
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
  pure subroutine find_leaving_row(workspace, n, entering, i_leaving)
    type(lcp_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: n
    integer, intent(in) :: entering
    integer, intent(out) :: i_leaving
    integer :: i_column, z0_row

    i_leaving = 0
    associate (is_candidate => workspace%is_candidate(:n), column => workspace%tableau(:n, entering))
      is_candidate = column > pivot_tolerance * maxval(abs(column))
      if (.not. any(is_candidate)) return
      call keep_smallest(workspace%tableau(:n, 2 * n + 2), column, is_candidate, workspace%ratio(:n))
      z0_row = findloc(workspace%basis(:n), 2 * n + 1, dim=1)
      if (is_candidate(z0_row)) then
        i_leaving = z0_row
        return
      end if
      ! The columns of w hold the inverse of the basis, whose rows differ: the tie ends.
      do i_column = 1, n
        if (count(is_candidate) == 1) exit
        call keep_smallest(workspace%tableau(:n, i_column), column, is_candidate, workspace%ratio(:n))
      end do
      i_leaving = findloc(is_candidate, .true., dim=1)
    end associate
  end subroutine find_leaving_row

  !> Leaves only the rows whose ratio is the smallest, within the tie tolerance.
  pure subroutine keep_smallest(numerator, denominator, is_candidate, ratio)
    real(rk), intent(in) :: numerator(:)
    real(rk), intent(in) :: denominator(:)
    logical, intent(inout) :: is_candidate(:)
    !> room
    real(rk), intent(inout) :: ratio(:)
    real(rk) :: smallest

    where (is_candidate) ratio = numerator / denominator
    smallest = minval(ratio, mask=is_candidate)
    where (is_candidate) is_candidate = ratio <= smallest + tie_tolerance * max(1.0_rk, abs(smallest))
  end subroutine keep_smallest

  !> Gauss-Jordan step on one entry; the entering variable takes the row.
  pure subroutine pivot(workspace, n, i_row, entering)
    type(lcp_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: n
    integer, intent(in) :: i_row
    integer, intent(in) :: entering
    real(rk) :: factor
    integer :: i_column

    associate (tableau => workspace%tableau, column => workspace%column)
      column(:n) = tableau(:n, entering)
      column(i_row) = 0
      do i_column = 1, 2 * n + 2
        factor = tableau(i_row, i_column) / tableau(i_row, entering)
        if (i_column == entering .or. abs(factor) <= 0) cycle
        tableau(i_row, i_column) = factor
        tableau(:n, i_column) = tableau(:n, i_column) - column(:n) * factor
      end do
      tableau(:n, entering) = 0
      tableau(i_row, entering) = 1
    end associate
    workspace%basis(i_row) = entering
  end subroutine pivot

  !> Multipliers of the basis, in their own unit.
  pure subroutine read_solution(matrix, q, workspace, is_active)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    logical, intent(inout) :: is_active(:)
    real(rk) :: unit
    integer :: i_row, k, n

    n = size(q)
    unit = maxval(abs(q)) / matrix_size(matrix)
    do i_row = 1, n
      k = workspace%basis(i_row) - n
      if (k < 1 .or. k > n) cycle
      workspace%lambda(k) = workspace%tableau(i_row, 2 * n + 2) * unit
      is_active(k) = .true.
    end do
  end subroutine read_solution
end module sig_lcp_lemke
